"""The real recordings, where MCNLAB_DATA names a folder of them; skipped without.

The folder may hold other subjects than those whose boxes are bundled: what is compared is
what both have.
"""

import json
import shutil

import numpy as np
import pandas as pd
import pytest

from mcnlab.compass import turn_between
from mcnlab.datasets import catalogue
from mcnlab.datasets.casia import find_sequences, read_directions
from mcnlab.datasets.mirror import OBLIQUE, mirror_boxes, mirror_masks
from mcnlab.datasets.pets import PETS, read_pets, read_tsai_place
from mcnlab.errors import SilhouetteError
from mcnlab.files import sha256_of
from mcnlab.occlusion import benchmark
from mcnlab.occlusion.benchmark import compare_sequences
from mcnlab.tables import SEQUENCE, TRACE
from mcnlab.vision.recordings import (
    casia_a,
    measure_casia_a,
    measure_pets2009_traces,
    pets2009_traces,
    read_casia_a,
)
from mcnlab.vision.silhouettes import find_body, measure_sequence
from mcnlab.walking import outdoors
from mcnlab.walking.heading import measure_headings

BUNDLED_CASIA = catalogue.BUNDLED / "casia-a"


@pytest.fixture(scope="module")
def casia(recordings):
    folder = recordings / "casia-a"
    if not (folder / "silhouettes").is_dir():
        pytest.skip("no CASIA A silhouettes in MCNLAB_DATA")
    return folder


@pytest.fixture(scope="module")
def sequences(casia):
    return find_sequences(casia)


@pytest.fixture(scope="module")
def measured(casia):
    return measure_casia_a(casia)


@pytest.fixture(scope="module")
def pets(recordings):
    files = [
        recordings / PETS / "PETS2009-S2L1.xml",
        recordings / PETS / "View_001.xml",
        recordings / "motchallenge" / "PETS09-S2L1" / "gt" / "gt.txt",
    ]
    if not all(path.is_file() for path in files):
        pytest.skip("no PETS 2009 in MCNLAB_DATA")
    return files


def test_every_sequence_is_measured_and_none_is_damaged(sequences, measured):
    assert measured.problems == ()
    assert measured.sequences == [sequence.name for sequence in sequences]
    found = measured.boxes.groupby(SEQUENCE).size()
    frames = pd.Series({sequence.name: len(sequence.paths) for sequence in sequences})
    # A frame may show nobody; hardly any does.
    assert (found <= frames[found.index]).all()
    assert found.sum() >= 0.99 * frames.sum()


def test_the_bundled_boxes_are_what_is_measured_now(measured):
    kept = read_casia_a(BUNDLED_CASIA)
    shared = [name for name in kept.sequences if name in set(measured.sequences)]
    if not shared:
        pytest.skip("no bundled subject in MCNLAB_DATA")
    for name in shared:
        pd.testing.assert_frame_equal(
            measured.sequence(name), kept.sequence(name), check_exact=True, check_dtype=False
        )
    assert measured.directions[shared].tolist() == kept.directions[shared].tolist()


def test_the_noted_checksum_is_the_images(casia, sequences):
    note = json.loads((BUNDLED_CASIA / "provenance.json").read_text())
    subjects = read_casia_a(BUNDLED_CASIA).subjects
    images = [
        path for sequence in sequences if sequence.name in subjects for path in sequence.paths
    ]
    if len({path.parent for path in images}) != note["sequences"]:
        pytest.skip("not every bundled sequence is in MCNLAB_DATA")
    assert len(images) == note["frames"]
    assert sha256_of(images, root=casia) == note["sha256 of the images"]


def test_measuring_mirrored_images_gives_the_mirrored_boxes(sequences, measured):
    for sequence in sequences[::7]:
        mirrored = measure_sequence(
            mirror_masks(sequence.read()), sequence=sequence.name, subject=sequence.subject
        )
        expected = mirror_boxes(measured.sequence(sequence.name), frame_width=352)
        pd.testing.assert_frame_equal(mirrored, expected, check_exact=True)


def test_the_body_is_whole_and_alone(sequences):
    for sequence in sequences[::29]:
        for mask in sequence.read()[::10]:
            try:
                body = find_body(mask)
            except SilhouetteError:
                continue  # nobody yet, or no more
            rows, cols = np.nonzero(body.mask)
            assert (body.x, body.y) == (cols.min(), rows.min())
            assert (body.x + body.w, body.y + body.h) == (cols.max() + 1, rows.max() + 1)
            assert body.area == len(rows)
            assert not (body.mask & ~mask).any()
            # The walker is what most of the foreground belongs to.
            assert body.area >= 0.5 * np.count_nonzero(mask)


def test_labels_agree_with_the_way_the_centroid_goes(measured):
    for name, direction in measured.directions.items():
        moved = np.polyfit(*measured.sequence(name)[["frame", "cx"]].to_numpy().T, 1)[0]
        if direction in (2, 3, 4):
            assert moved > 0, name
        elif direction in (6, 7, 8):
            assert moved < 0, name


def test_headings_are_within_half_a_direction_of_the_labels(measured):
    walks = measure_headings(measured, focal_length=400.0)
    truth = measured.directions[walks[SEQUENCE]].to_numpy()
    # The claim of design section 3 for every focal length between 300 and 500 pixels.
    assert (walks["direction"].to_numpy() == truth).mean() >= 0.98


def test_a_subset_of_subjects_will_do(casia, sequences, tmp_path, monkeypatch):
    subjects = sorted({sequence.subject for sequence in sequences})[:2]
    (tmp_path / "casia-a" / "silhouettes").mkdir(parents=True)
    for subject in subjects:
        (tmp_path / "casia-a" / "silhouettes" / subject).symlink_to(
            casia / "silhouettes" / subject, target_is_directory=True
        )
    shutil.copy(casia / "directions.csv", tmp_path / "casia-a")
    monkeypatch.setenv("MCNLAB_DATA", str(tmp_path))
    recording = casia_a()
    own = [sequence.name for sequence in sequences if sequence.subject in subjects]
    labels = read_directions(casia / "directions.csv")[own]
    assert recording.without_copies().sequences == own
    assert len(recording.copies) == labels.isin(OBLIQUE).sum()
    assert set(recording.subjects) == set(subjects)
    assert recording.problems == ()


def test_a_sequence_with_a_truncated_image_is_left_out_and_named(casia, sequences, tmp_path):
    whole, torn = sequences[:2]
    for sequence in (whole, torn):
        folder = (
            tmp_path / "silhouettes" / sequence.paths[0].parent.relative_to(casia / "silhouettes")
        )
        shutil.copytree(sequence.paths[0].parent, folder)
    shutil.copy(casia / "directions.csv", tmp_path)
    path = folder / torn.paths[3].name
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    recording = measure_casia_a(tmp_path)
    assert recording.sequences == [whole.name]
    (problem,) = recording.problems
    assert torn.name in problem
    assert f"{path.name} is truncated" in problem


def test_the_bundled_pets_headings_are_what_is_measured_now(pets, recordings):
    kept = catalogue.read_table(catalogue.BUNDLED / PETS / "headings.csv.gz", dtype={SEQUENCE: str})
    now = outdoors.measure_pets2009(recordings)
    assert list(now.columns) == list(kept.columns)
    exact = ["sequence", "frame", "direction", "frames"]
    assert now[exact].astype(str).to_dict("list") == kept[exact].astype(str).to_dict("list")
    angles = ["heading", "sight", "true_sight", "error"]
    others = ["margin", "speed", "x", "z", "true_speed"]
    # Rounded to four decimals; linear algebra differs in the last bits between machines.
    assert np.abs(turn_between(now[angles], kept[angles])).max() < 1e-3
    assert now[others].to_numpy() == pytest.approx(kept[others].to_numpy(), abs=1e-3)


def test_the_noted_checksum_is_the_pets_files(pets, recordings):
    note = json.loads((catalogue.BUNDLED / PETS / "provenance.json").read_text())
    sources = [*pets, recordings / PETS / "vtest.mp4"]
    assert sha256_of(sources, root=recordings) == note["sha256 of the sources"]


def test_the_bundled_pets_traces_are_what_is_measured_now(recordings):
    finders = ["background", "horn-schunck"]
    now = measure_pets2009_traces(recordings, finders=finders)
    for table, kept in zip(now, pets2009_traces(finders), strict=True):
        assert table["method"].tolist() == kept["method"].tolist()
        assert table[TRACE].astype(str).tolist() == kept[TRACE].tolist()
        numbers = table.select_dtypes(float).columns
        # Rounded to four decimals.
        assert table[numbers].to_numpy() == pytest.approx(kept[numbers].to_numpy(), abs=1e-3)


def test_the_pets_camera_stands_seven_metres_high(pets):
    place = read_tsai_place(pets[1])
    assert place.shape == (3,)
    # The calibration's own numbers, undone: 7.07 m.
    assert abs(place[2]) == pytest.approx(7.07, abs=0.01)


def test_everybody_of_pets_is_read(pets):
    recording = read_pets(pets[0].parent)
    assert recording.sequences == [str(person) for person in range(1, 20)]
    assert recording.boxes["frame"].between(0, 794).all()


def test_the_bundled_forecasts_are_what_is_made_now(recordings):
    made, _ = compare_sequences(recordings / catalogue.MOTCHALLENGE)
    now = {table["recording"].iloc[0]: table for table in made}
    kept = {table["recording"].iloc[0]: table for table in benchmark.video_pairs()[0]}
    assert set(now) & set(kept), "MCNLAB_DATA holds none of the bundled sequences"
    for name in set(now) & set(kept):
        assert list(now[name].columns) == list(kept[name].columns)
        for column, values in kept[name].items():
            if values.dtype.kind == "f":
                # Rounded to four decimals or six figures; a step of the future that begins
                # half of a probability may be another one on another machine.
                apart = np.abs(now[name][column].to_numpy() - values.to_numpy())
                assert np.quantile(apart, 0.999) < 1e-3, (name, column)
            else:
                assert now[name][column].astype(str).tolist() == values.astype(str).tolist()
