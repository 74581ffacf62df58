"""Recordings by name: CASIA A, PETS 2009, and boxes of one's own."""

import numpy as np
import pytest

from mcnlab.compass import turn_between
from mcnlab.datasets.mirror import SUFFIX
from mcnlab.errors import ArgumentError, McnError
from mcnlab.tables import check_boxes
from mcnlab.vision import recordings
from mcnlab.walking import outdoors

# CASIA A has twelve walks a subject, two in each of directions 1, 2, 3, 5, 6 and 7; the
# four oblique ones are mirrored: sixteen (thesis 3.1).
SUBJECTS, WALKS, VIDEOS = 14, 12, 16


@pytest.fixture(scope="module")
def recording():
    return recordings.casia_a()


@pytest.fixture
def bring_your_own(tmp_path, make_boxes):
    """A folder with a box table of one's own and its labels."""
    make_boxes().to_csv(tmp_path / "boxes.csv.gz", index=False)
    (tmp_path / "directions.csv").write_text("sequence,direction\nwalk,3\n")
    return tmp_path


def test_casia_a_is_mirrored_to_eight_directions(recording):
    assert len(recording.sequences) == SUBJECTS * VIDEOS == 224
    assert len(recording.copies) == SUBJECTS * (VIDEOS - WALKS)
    assert recording.directions.value_counts().to_dict() == dict.fromkeys(range(1, 9), 28)
    assert recording.subjects.value_counts().eq(VIDEOS).all()
    assert recording.problems == ()
    for name in recording.copies:
        assert recording.subjects[name] == recording.subjects[name.removesuffix(SUFFIX)]


def test_casia_a_as_it_was_filmed(recording):
    filmed = recordings.casia_a(mirrored=False)
    assert len(filmed.sequences) == SUBJECTS * WALKS == 168
    assert not filmed.copies
    assert set(filmed.directions) == {1, 2, 3, 5, 6, 7}
    assert (filmed.frame_width, filmed.frame_height, filmed.frame_rate) == (352, 240, 25)
    assert recording.without_copies().boxes.equals(filmed.boxes)
    boxes = check_boxes(filmed.boxes)
    assert (boxes[["x", "y"]] >= 0).all(axis=None)
    assert (boxes["x"] + boxes["w"] <= 352).all()
    assert (boxes["y"] + boxes["h"] <= 240).all()
    inside = boxes["cx"].between(boxes["x"], boxes["x"] + boxes["w"] - 1)
    assert inside.all()
    assert (boxes["area"] <= boxes["w"] * boxes["h"]).all()


def test_pets_headings_hold_together():
    table = outdoors.pets2009_headings()
    assert np.isfinite(table.select_dtypes(float)).all(axis=None)
    error = turn_between(table["sight"], table["true_sight"])
    # Kept to four decimals each: half a unit of the last three times over.
    assert np.abs(turn_between(error, table["error"])).max() < 1.6e-4
    assert table["margin"].between(0, 180).all()
    assert not table.duplicated(["sequence", "frame"]).any()


def test_recordings_that_lie_there_are_measured(casia_folder, monkeypatch):
    casia_folder.rename(casia_folder.parent / "casia-a")
    monkeypatch.setenv("MCNLAB_DATA", str(casia_folder.parent))
    recording = recordings.casia_a()
    assert recording.subjects.nunique() == 2
    # One walk a subject is oblique.
    assert recording.copies == {f"abc-45_1{SUFFIX}", f"xyz-45_1{SUFFIX}"}
    assert recording.directions.value_counts().to_dict() == {7: 2, 6: 2, 4: 2}


def test_boxes_of_ones_own_are_read(bring_your_own, make_boxes):
    recording = recordings.read_casia_a(bring_your_own)
    assert recording.boxes.equals(make_boxes())
    assert recording.directions.to_dict() == {"walk": 3}
    (bring_your_own / "boxes.csv.gz").unlink()
    make_boxes().to_csv(bring_your_own / "boxes.csv", index=False)
    assert recordings.read_casia_a(bring_your_own).boxes.equals(make_boxes())


def test_boxes_of_ones_own_are_checked(bring_your_own, make_boxes):
    make_boxes().drop(columns="h").to_csv(bring_your_own / "boxes.csv.gz", index=False)
    with pytest.raises(McnError, match=r"boxes\.csv\.gz lacks the column\(s\) h"):
        recordings.read_casia_a(bring_your_own)
    make_boxes(h="tall").to_csv(bring_your_own / "boxes.csv.gz", index=False)
    with pytest.raises(McnError, match=r"boxes\.csv\.gz holds text"):
        recordings.read_casia_a(bring_your_own)
    make_boxes().to_csv(bring_your_own / "boxes.csv.gz", index=False)
    (bring_your_own / "directions.csv").write_text("sequence,direction\nrun,3\n")
    with pytest.raises(McnError, match="lacks a label for walk"):
        recordings.read_casia_a(bring_your_own)
    (bring_your_own / "directions.csv").unlink()
    with pytest.raises(McnError, match=r"directions\.csv is missing"):
        recordings.read_casia_a(bring_your_own)


def test_a_finder_that_is_not_held_is_named():
    with pytest.raises(ArgumentError, match="finders is 'haar'"):
        recordings.pets2009_traces(["background", "haar"])
