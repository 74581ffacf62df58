"""Two walks in one clock keep their boxes; their silhouettes are where the boxes are."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcnlab import tables
from mcnlab.cameras.camera import Camera
from mcnlab.datasets.mirror import add_mirrored
from mcnlab.datasets.recording import Recording
from mcnlab.errors import ArgumentError, DatasetError
from mcnlab.occlusion.composites import compose, compose_masks, start_frames
from mcnlab.synthetic.street import make_street
from mcnlab.synthetic.walkers import make_walks

shifts = st.integers(-30, 30)


@pytest.fixture(scope="module")
def pair(make_boxes):
    """A walk of 10 frames from frame 5 on, and one of 6 from frame 100 on, with a gap."""
    boxes = pd.concat(
        [
            make_boxes(10, sequence="a", subject="ann", frame=5 + np.arange(10)),
            make_boxes(6, sequence="b", subject="bob", frame=[100, 101, 102, 105, 106, 107]),
            make_boxes(3, sequence="c", subject="cy"),
        ],
        ignore_index=True,
    )
    labels = pd.Series({"a": 2, "b": 7, "c": 1})
    return Recording("made-up", boxes, 25.0, 352, 240, directions=labels)


@given(shift=shifts)
def test_the_second_begins_so_many_frames_after_the_first(pair, shift):
    both = compose(pair, "a", "b", shift=shift)
    starts = [int(both.sequence(name)["frame"].iloc[0]) for name in "ab"]
    assert starts[1] - starts[0] == shift
    assert min(starts) == 1
    assert tuple(starts) == start_frames(shift)


@given(shift=shifts)
def test_boxes_and_steps_between_frames_stay(pair, shift):
    both = compose(pair, "b", "a", shift=shift)
    assert both.sequences == ["b", "a"]
    for name in "ab":
        before, after = pair.sequence(name), both.sequence(name)
        assert after.drop(columns="frame").equals(before.drop(columns="frame"))
        assert np.diff(after["frame"]).tolist() == np.diff(before["frame"]).tolist()


@given(shift=shifts)
def test_exchanging_the_walks_turns_the_shift_round(pair, shift):
    one, other = compose(pair, "a", "b", shift=shift), compose(pair, "b", "a", shift=-shift)
    for name in "ab":
        assert one.sequence(name).equals(other.sequence(name))


def test_labels_and_the_camera_go_along(pair):
    both = compose(pair, "b", "a", shift=np.int64(3))
    assert both.directions.to_dict() == {"b": 7, "a": 2}
    assert (both.name, both.frame_rate, both.frame_width) == ("made-up", 25.0, 352)
    assert both.copies == frozenset()
    tables.check_boxes(both.boxes)


def test_a_mirror_image_may_meet_its_original(pair):
    mirrored = add_mirrored(pair)
    both = compose(mirrored, "a", "a-mirror")
    assert both.copies == {"a-mirror"}
    assert both.subjects.to_dict() == {"a": "ann", "a-mirror": "ann"}


def test_a_walk_cannot_meet_itself(pair):
    with pytest.raises(ArgumentError, match="first and second are both 'a'"):
        compose(pair, "a", "a", shift=5)


def test_a_walk_that_is_not_there_is_named(pair):
    with pytest.raises(DatasetError, match="'d' is not in made-up"):
        compose(pair, "a", "d")


@pytest.mark.parametrize("shift", [0.5, 1.0, True, None, "3", np.nan, 10**7])
def test_only_whole_frames_are_shifted_by(pair, shift):
    with pytest.raises(ArgumentError, match="shift is"):
        compose(pair, "a", "b", shift=shift)
    with pytest.raises(ArgumentError, match="shift is"):
        compose_masks(np.ones((2, 3, 4)), np.ones((2, 3, 4)), shift=shift)


@given(st.integers(1, 5), st.integers(1, 5), st.integers(-7, 7))
def test_masks_are_laid_over_each_other_in_one_clock(n, m, shift):
    first, second = np.zeros((n, 4, 6), np.uint8), np.zeros((m, 4, 6), np.uint8)
    first[:, 1:3, 1:4] = 255
    second[:, 1:3, 3:5] = 255
    both = compose_masks(first, second, shift=shift)
    one, two = (start - 1 for start in start_frames(shift))
    assert len(both) == max(one + n, two + m)
    for frame, codes in enumerate(both):
        assert (codes[1, 1] == 1) == (one <= frame < one + n)
        assert (codes[1, 4] == 2) == (two <= frame < two + m)
        assert codes[1, 3] == (one <= frame < one + n) + 2 * (two <= frame < two + m)
        assert codes[0].max() == 0


def test_silhouettes_lie_in_their_boxes():
    walks = make_walks(subjects=2, directions=(3, 7), seed=4)
    one, two = walks[0], walks[3]
    boxes = pd.concat([one.truth, two.truth], ignore_index=True)
    both = compose(Recording("made", boxes, 25.0, 352, 240), one.name, two.name, shift=9)
    codes = compose_masks(one.masks, two.masks, shift=9)
    assert len(codes) == both.boxes["frame"].max()
    for code, name in ((1, one.name), (2, two.name)):
        for row in both.sequence(name).itertuples():
            rows, cols = np.nonzero(codes[row.frame - 1] & code)
            assert (cols.min(), rows.min()) == (row.x, row.y)
            assert (np.ptp(cols) + 1, np.ptp(rows) + 1) == (row.w, row.h)


@pytest.mark.parametrize(
    ("first", "second"),
    [
        (np.ones((3, 4)), np.ones((2, 3, 4))),
        (np.ones((2, 3, 4)), np.ones((2, 3, 5))),
        (np.ones((2, 3, 4)), np.ones((0, 3, 4))),
        (None, None),
    ],
)
def test_masks_that_do_not_fit_are_refused(first, second):
    with pytest.raises(ArgumentError, match="first"):
        compose_masks(first, second)


def test_the_street_is_full_of_people_who_are_wholly_seen():
    street = make_street()
    recording = street.recording
    assert recording.directions.value_counts().to_dict() == {3: 8, 2: 3, 6: 3, 7: 3}
    boxes = recording.boxes
    assert (boxes["x"] > 0).all()
    assert (boxes["x"] + boxes["w"] < recording.frame_width).all()
    assert make_street() is street


def test_only_dawdlers_are_slow_in_the_picture():
    recording = make_street().recording
    for name in recording.sequences:
        walk = recording.sequence(name)
        # In 4.8 s, so that a step more or less does not matter.
        share = abs(walk["cx"].iloc[-1] - walk["cx"].iloc[0]) / recording.frame_width
        share /= (len(walk) - 1) / recording.frame_rate
        assert (share < 0.01) == name.startswith("dawdler"), name


def test_from_above_the_same_people_walk():
    above = Camera.from_tilt(
        focal_length=450, height=6.0, tilt=20.0, frame_width=960, frame_height=540
    )
    street, mast = make_street(), make_street(view=above)
    assert mast.recording.sequences == street.recording.sequences
    assert mast.recording.directions.equals(street.recording.directions)
    far, near = (mast.recording.sequence(name)["cy"].mean() for name in ("dawdler-1", "s01-d3"))
    assert far < near - 50  # higher up in the picture: 12 m away, not 7


def test_cut_outs_put_together_are_the_masks():
    street = make_street()
    walk = street.recording.sequence("s02-d7")
    masks = street.masks("s02-d7")
    assert masks.shape == (len(walk), 540, 960)
    assert ((masks > 0).sum(axis=(1, 2)) == walk["area"].to_numpy()).all()


@pytest.mark.parametrize("options", [{"brisk": 0}, {"dawdlers": -1}, {"seed": 1.5}])
def test_a_street_of_no_such_number_is_refused(options):
    with pytest.raises(ArgumentError, match=next(iter(options))):
        make_street(**options)
