"""A recording checks its labels and its camera, and knows its walks."""

import numpy as np
import pandas as pd
import pytest

from mcnlab.compass import DIRECTIONS
from mcnlab.datasets.recording import Recording
from mcnlab.errors import ArgumentError, DatasetError


@pytest.fixture
def labelled(make_boxes):
    boxes = pd.concat(
        [make_boxes(sequence=f"walk-{d}", x=30.0 + d) for d in DIRECTIONS], ignore_index=True
    )
    directions = pd.Series({f"walk-{d}": d for d in DIRECTIONS}, name="direction")
    return Recording("made-up", boxes, 25.0, 352, 240, directions=directions)


@pytest.mark.parametrize(
    ("labels", "word"),
    [
        ({}, "lacks a label for walk"),
        ({"walk": 3, "stray": 1}, "not there: stray"),
        ({"walk": 0}, "1 to 8"),
        ({"walk": 9}, "1 to 8"),
        ({"walk": 1.5}, "1 to 8"),
        ({"walk": np.nan}, "1 to 8"),
        ({"walk": "away"}, "1 to 8"),
    ],
)
def test_labels_that_do_not_fit_the_walks_are_refused(make_boxes, labels, word):
    with pytest.raises(DatasetError, match=word):
        Recording("made-up", make_boxes(), 25.0, 352, 240, directions=pd.Series(labels))


def test_a_walk_labelled_twice_is_refused(make_boxes):
    with pytest.raises(DatasetError, match="twice"):
        Recording(
            "made-up",
            make_boxes(),
            25.0,
            352,
            240,
            directions=pd.Series([1, 2], index=["walk", "walk"]),
        )


@pytest.mark.parametrize(
    ("frame_rate", "width", "height", "word"),
    [
        (0, 352, 240, "frame_rate"),
        (np.nan, 352, 240, "frame_rate"),
        (True, 352, 240, "frame_rate"),
        (25, 0, 240, "frame_width"),
        (25, 352.5, 240, "frame_width"),
        (25, 352, -1, "frame_height"),
    ],
)
def test_a_camera_with_senseless_numbers_is_refused(make_boxes, frame_rate, width, height, word):
    with pytest.raises(ArgumentError, match=word):
        Recording("made-up", make_boxes(), frame_rate, width, height)


def test_a_recording_knows_its_walks(labelled):
    assert labelled.sequences == [f"walk-{d}" for d in DIRECTIONS]
    assert labelled.subjects.to_dict() == dict.fromkeys(labelled.sequences, "walker")
    assert labelled.sequence("walk-3")["x"].eq(33).all()
    with pytest.raises(DatasetError, match="'walk-9' is not in made-up"):
        labelled.sequence("walk-9")
