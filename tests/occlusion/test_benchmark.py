"""Tables of pairs: what they hold, what they leave out, and whose recordings are whose."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from joblib import parallel_config

from mcnlab.datasets.motchallenge import place_of
from mcnlab.errors import DatasetError
from mcnlab.occlusion import benchmark as comparison
from mcnlab.occlusion.benchmark import (
    COMPOSITES,
    CROSSINGS,
    DECIMALS,
    FIGURES,
    compare,
    compare_composites,
    compare_crossings,
    compare_sequences,
)
from mcnlab.occlusion.forecasters import (
    FEATURES,
    ConstantVelocity,
    Perspective,
    Thesis,
    UncertainVelocity,
    describe,
)
from mcnlab.occlusion.pairs import Rules, find_pairs
from mcnlab.occlusion.pairs import find_pairs as find_pairs_of_pairs
from mcnlab.occlusion.thesis import APART, look_up
from mcnlab.synthetic.crossings import make_crossings
from mcnlab.vision import recordings

NAMES = ("thesis", "constant-velocity", "uncertain-velocity", "perspective")


@pytest.fixture(scope="module")
def recording():
    return make_crossings(people=20, seconds=12.0, seed=5)


@pytest.fixture(scope="module")
def pairs(recording):
    return find_pairs(recording)


@pytest.fixture(scope="module")
def table(pairs):
    return compare(pairs)


def test_a_table_has_a_row_a_pair_and_the_columns_that_are_promised(pairs, table):
    said = [f"{name}.{value}" for name in NAMES for value in ("probability", "seconds")]
    assert set(table.columns) == {
        *("recording", "frame", "first", "second", "body", "occludes", "seconds"),
        *("direction1", "direction2", "level1", "level2", "near", "moving"),
        *(*said, *(f"{name}.place_error" for name in NAMES), *FEATURES),
    }
    assert len(table) == len(pairs)
    assert not table.isna().any().any()
    assert (table["recording"] == "crossings").all()
    assert (table[["first", "second"]].to_numpy(str) == pairs.people).all()
    assert (table["frame"] == pairs.frame).all()
    assert (table["occludes"] == pairs.occludes).all()
    assert table["occludes"].any()


def test_numbers_are_those_of_the_forecasters_rounded(pairs, table):
    outlook = Perspective().look_ahead(pairs)
    half = 0.5 * 10.0**-DECIMALS + 1e-9
    for forecaster in (Thesis(), ConstantVelocity(), UncertainVelocity(), Perspective()):
        said = forecaster.forecast(pairs)
        kept = table[f"{forecaster.name}.probability"]
        # Half of the last of six figures is 5e-6 of the number at most.
        np.testing.assert_allclose(kept, said.probability, rtol=5.1 * 10.0**-FIGURES, atol=1e-30)
        assert kept.between(0, 1).all()
        np.testing.assert_allclose(table[f"{forecaster.name}.seconds"], said.seconds, atol=half)
        error = np.hypot(said.x - pairs.x, said.y - pairs.y) / pairs.body
        kept = table[f"{forecaster.name}.place_error"]
        np.testing.assert_allclose(kept[pairs.occludes], error[pairs.occludes], atol=half)
        assert (kept[~pairs.occludes] == 0).all()
    kept = table.loc[table["near"], list(FEATURES)]
    np.testing.assert_allclose(kept, describe(outlook), atol=half)
    numbers = table.select_dtypes(float)
    numbers = numbers.drop(columns=[name for name in numbers if name.endswith("probability")])
    assert numbers.equals(numbers.round(DECIMALS))


def test_rounding_keeps_the_order_of_small_probabilities(pairs, table):
    said = ConstantVelocity().forecast(pairs).probability
    kept = table["constant-velocity.probability"].to_numpy()
    order = np.argsort(said, kind="stable")
    assert (np.diff(kept[order]) >= 0).all()
    # Rounding to four decimals would leave few different ones.
    assert len(np.unique(kept)) > 0.9 * len(np.unique(said))
    assert len(np.unique(kept.round(DECIMALS))) < 0.8 * len(np.unique(kept))


def test_a_table_outlives_a_file(table, tmp_path):
    table.to_csv(tmp_path / "pairs.csv", index=False)
    again = pd.read_csv(tmp_path / "pairs.csv", dtype={"first": str, "second": str})
    pd.testing.assert_frame_equal(again, table, check_dtype=False, check_exact=True)


def test_far_pairs_have_no_features(pairs, table):
    near = np.zeros(len(pairs), bool)
    near[Perspective().look_ahead(pairs).near] = True
    assert (table["near"] == near).all()
    assert 0 < near.sum() < len(near)
    assert (table.loc[~near, list(FEATURES)] == 0).all().all()
    assert (table.loc[~near, "perspective.probability"] == 0).all()
    assert (table.loc[near, "width"] > 0).all()


def test_the_tables_were_asked_what_the_table_says(table):
    asked = table[["direction1", "direction2", "level1", "level2"]].to_numpy().T
    apart = look_up(*asked) == APART
    assert 0 < apart.sum() < len(apart)
    assert (table.loc[apart, "thesis.probability"] == 0).all()


def test_a_moving_camera_and_another_name_are_written_down(pairs):
    table = compare(pairs, name="other", moving=True)
    assert table["moving"].all()
    assert (table["recording"] == "other").all()
    assert not compare(pairs)["moving"].any()


def test_the_truth_changes_nothing_that_is_said(pairs, table):
    other = compare(replace(pairs, occludes=~pairs.occludes, seconds=3 - pairs.seconds))
    same = [name for name in table if name not in ("occludes", "seconds")]
    same = [name for name in same if not name.endswith("place_error")]
    assert other[same].equals(table[same])


def test_crossings_have_a_name_and_follow_the_rules():
    table = compare_crossings(rules=Rules(horizon=1.0))
    assert (table["recording"] == CROSSINGS).all()
    assert table["perspective.seconds"].max() <= 1


def test_composites_have_a_name_and_are_of_two_people():
    recording = recordings.casia_a(mirrored=False)
    some = recording.subjects.groupby(recording.subjects).head(4).index[:12]
    boxes = recording.boxes[recording.boxes["sequence"].isin(some)].reset_index(drop=True)
    table = compare_composites(recording.with_boxes(boxes, directions=None))
    assert (table["recording"] == COMPOSITES).all()
    assert (table["first"] != table["second"]).all()
    assert set(table["first"]) | set(table["second"]) <= set(recording.subjects[some])
    assert not table["moving"].any()


@pytest.mark.parametrize(
    ("names", "place"),
    [
        (("mot16-02", "mot17-02-dpm", "mot17-02-frcnn", "MOT17-02-SDP", "mot17det-02"), "mot-02"),
        (("mot16-04", "mot17-04-frcnn", "mot17-4"), "mot-04"),
        # MOT16 took these over from MOT15: 600, 525, 837, 654, 450, 1194, 500, 625 frames each.
        (("venice-2", "mot17-02-frcnn"), "mot-02"),
        (("ADL-Rundle-6", "mot17-09-sdp"), "mot-09"),
        (("eth-pedcross2", "mot16-05"), "mot-05"),
        (("adl-rundle-8", "mot16-10"), "mot-10"),
        (("venice-1", "mot16-01"), "mot-01"),
        (("eth-linthescher", "mot16-06"), "mot-06"),
        (("adl-rundle-1", "mot16-07"), "mot-07"),
        (("adl-rundle-3", "mot16-08"), "mot-08"),
        (("pets09-s2l1", "PETS09-S2L2", "pets2009"), "pets-2009"),
        (("mot20-01", "MOT20-02", "mot20-07"), "mot20-hall"),
    ],
)
def test_recordings_of_the_same_people_are_one_place(names, place):
    assert {place_of(name) for name in names} == {place}


def test_other_recordings_are_places_of_their_own():
    names = [
        *("mot17-02-frcnn", "mot17-04-frcnn", "mot17-13-sdp", "mot20-01", "mot20-03", "mot20-08"),
        *("tud-stadtmitte", "tud-campus", "pets09-s2l1", "kitti-13", "kitti-17", "my-mot17-02"),
        *(COMPOSITES, CROSSINGS, "mot17", "mot17-2x"),
    ]
    assert len({place_of(name) for name in names}) == len(names)


def write_sequence(folder, recording, **info):
    """A sequence in the format of MOTChallenge, nine columns."""
    boxes = recording.boxes
    (folder / "gt").mkdir(parents=True)
    rows = boxes[["frame", "x", "y", "w", "h"]].copy()
    rows.insert(1, "id", pd.factorize(boxes["subject"])[0] + 1)
    rows.assign(conf=1, kind=1, visibility=1.0).to_csv(
        folder / "gt" / "gt.txt", header=False, index=False
    )
    info = {
        **{"frameRate": 25, "imWidth": 640, "imHeight": 480},
        **info,
    }
    lines = ["[Sequence]", *(f"{key}={value}" for key, value in info.items())]
    (folder / "seqinfo.ini").write_text("\n".join(lines) + "\n")


@pytest.fixture
def folder(tmp_path, recording):
    write_sequence(tmp_path / "Sound", recording)
    write_sequence(
        tmp_path / "MOT17-05-SDP",
        recording.with_boxes(
            recording.boxes.iloc[::-1].sort_values(["subject", "frame"]).reset_index(drop=True)
        ),
        frameRate=24,
    )
    short = recording.with_boxes(recording.boxes[recording.boxes["frame"] < 60])
    write_sequence(tmp_path / "Short", short)
    write_sequence(tmp_path / "Broken", recording)
    path = tmp_path / "Broken" / "gt" / "gt.txt"
    path.write_text(path.read_text().replace(",1,1,1.0", ",one,1,1.0", 1))
    write_sequence(tmp_path / "Slow", recording, frameRate=0)
    return tmp_path


def test_damaged_sequences_are_named_and_the_others_compared(folder):
    tables, problems = compare_sequences(folder)
    assert [table["recording"].iloc[0] for table in tables] == ["mot17-05-sdp", "sound"]
    # The benchmark says that the camera of -05 moves.
    assert [bool(table["moving"].any()) for table in tables] == [True, False]
    for name in ("Broken", "short", "Slow"):
        (found,) = [problem for problem in problems if name in problem]
        assert found.endswith((".", "]"))
    assert len(problems) == 3


def test_sequences_are_compared_alike_by_one_and_by_two(folder):
    one = compare_sequences(folder)
    with parallel_config(backend="threading"):
        two = compare_sequences(folder, n_jobs=2)
    assert one[1] == two[1]
    for here, there in zip(one[0], two[0], strict=True):
        assert here.equals(there)


def test_a_fault_in_one_sequence_stops_no_other(folder, monkeypatch):
    real = find_pairs_of_pairs

    def fail(recording, *, rules):
        if recording.name == "sound":
            raise DatasetError("boxes of nobody.")
        return real(recording, rules=rules)

    monkeypatch.setattr(comparison, "find_pairs", fail)
    tables, problems = compare_sequences(folder)
    assert [table["recording"].iloc[0] for table in tables] == ["mot17-05-sdp"]
    assert "sound was left out: boxes of nobody." in problems
