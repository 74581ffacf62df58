"""Masks whose walker is known: one body, its box, and nothing else."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcnlab.errors import ArgumentError, DatasetError, SilhouetteError
from mcnlab.tables import AREA, MEASURES
from mcnlab.vision.silhouettes import (
    check_mask,
    close_gaps,
    find_body,
    measure_sequence,
    measure_sequences,
    rectify_with_flow,
)


def box_of(mask):
    """x, y, w, h, cx, cy and area of all foreground, straight from the definition."""
    rows, cols = np.nonzero(mask)
    x, y = cols.min(), rows.min()
    return x, y, cols.max() - x + 1, rows.max() - y + 1, cols.mean(), rows.mean(), len(rows)


def assert_box(body, mask):
    *box, cx, cy, area = box_of(mask)
    assert [body.x, body.y, body.w, body.h] == box
    # Centroids are kept to 1/16 pixel, so at most 1/32 off.
    assert (body.cx, body.cy) == (pytest.approx(cx, abs=1 / 32), pytest.approx(cy, abs=1 / 32))
    assert body.area == area


@given(st.integers(0, 232), st.integers(0, 96), st.sampled_from([36, 60, 96, 144]))
def test_a_whole_walker_has_its_own_box(draw_walker, left, top, height):
    mask = draw_walker(left, top, height)
    body = find_body(mask)
    assert_box(body, mask)
    assert body.fragments == 1
    assert (body.mask == mask).all()


def test_head_torso_and_legs_apart_are_one_body(draw_walker):
    mask = draw_walker(left=100, top=40, height=120)
    mask[58:63] = 0  # between head and torso
    mask[105:112] = 0  # between torso and legs
    body = find_body(mask)
    assert body.fragments == 4
    assert_box(body, mask)
    assert (body.mask == mask).all()


def test_specks_are_no_part_of_the_body(draw_walker):
    mask = draw_walker()
    specked = mask.copy()
    specked[5, 5] = specked[200:203, 300:303] = specked[30:32, 118:120] = 255
    body = find_body(specked)
    assert_box(body, mask)
    assert (body.mask == mask).all()


@pytest.mark.parametrize(
    ("left", "top"), [(-20, 40), (332, 40), (100, -30), (100, 180), (-20, -30)]
)
def test_a_walker_half_out_of_the_frame_keeps_the_half_inside(draw_walker, left, top):
    whole = draw_walker(left=400 + left, top=300 + top, shape=(900, 1200))
    mask = whole[300:540, 400:752]
    assert mask[[0, -1]].any() or mask[:, [0, -1]].any()
    assert_box(find_body(mask), mask)


def test_masks_of_any_number_type_mean_the_same(draw_walker):
    mask = draw_walker()
    bodies = [
        find_body(same) for same in (mask, mask > 0, mask / 255.0, -(mask // 255).astype(int))
    ]
    assert all((body.mask == mask).all() for body in bodies)
    assert len({(body.x, body.y, body.w, body.h, body.cx, body.cy) for body in bodies}) == 1


@pytest.mark.parametrize(
    ("mask", "error", "word"),
    [
        (np.zeros((240, 352), np.uint8), SilhouetteError, "no walker"),
        (np.zeros((240, 352), bool), SilhouetteError, "no walker"),
        (np.full((240, 352), 255, np.uint8), SilhouetteError, "inverted"),
        (np.ones((240, 352), bool), SilhouetteError, "inverted"),
        (np.ones((240, 352)), ArgumentError, "binary"),
        (np.arange(20, dtype=np.uint8).reshape(4, 5), ArgumentError, "20 grey levels"),
        (np.array([[0.0, 0.5, 1.0]]), ArgumentError, "3 grey levels"),
        (np.array([[0.0, np.nan]] * 30), ArgumentError, "mask"),
        (np.zeros((2, 240, 352), np.uint8), ArgumentError, "shape"),
        (np.zeros((0, 352), np.uint8), ArgumentError, "shape"),
        (np.array([["walker"]]), ArgumentError, "dtype"),
        (None, ArgumentError, "mask"),
    ],
    ids=[
        "black",
        "black-bool",
        "white",
        "white-bool",
        "ones",
        "grey",
        "halves",
        "nan",
        "3d",
        "empty",
        "text",
        "none",
    ],
)
def test_a_mask_without_a_walker_is_refused(mask, error, word):
    with pytest.raises(error, match=word):
        find_body(mask)


@pytest.mark.parametrize("min_area", [0, -1, 2.5, True, np.nan])
def test_a_senseless_least_area_is_refused(draw_walker, min_area):
    with pytest.raises(ArgumentError, match="min_area"):
        find_body(draw_walker(), min_area=min_area)


def test_two_walkers_in_one_image_are_refused(draw_walker):
    mask = draw_walker(left=60) | draw_walker(left=220)
    with pytest.raises(SilhouetteError, match=r"two walkers, at columns (60 and 220|220 and 60)"):
        find_body(mask)


def test_noise_in_a_large_frame_is_refused_not_miscounted():
    mask = np.zeros((700, 700), np.uint8)
    mask[::2, ::2] = 255  # 122,500 single pixels
    with pytest.raises(SilhouetteError, match="no walker"):
        find_body(mask)


def test_frames_without_a_walker_have_no_row_and_numbers_stay(draw_walker):
    masks = [draw_walker(left=100 + 3 * at) for at in range(8)]
    masks[0] = masks[5] = np.zeros_like(masks[0])
    masks[6] = draw_walker(left=40) | draw_walker(left=240)
    boxes = measure_sequence(masks, sequence="abc-00_1", subject="abc")
    assert boxes["frame"].tolist() == [2, 3, 4, 5, 8]
    assert set(boxes["sequence"]) == {"abc-00_1"}
    assert set(boxes["subject"]) == {"abc"}
    for row in boxes.itertuples():
        assert_box(row, masks[row.frame - 1])


def test_frame_numbers_can_be_given(draw_walker):
    masks = [draw_walker(), np.zeros((240, 352), np.uint8), draw_walker()]
    assert measure_sequence(masks, frames=[10, 20, 40])["frame"].tolist() == [10, 40]


@pytest.mark.parametrize(
    "frames", [[1, 2], [1, 3, 2], [1, 1, 2], [0.2, 0.5, 0.9], [1, np.nan, 3], 7]
)
def test_frame_numbers_that_do_not_fit_are_refused(draw_walker, frames):
    with pytest.raises(ArgumentError, match="frames"):
        measure_sequence([draw_walker()] * 3, frames=frames)


@pytest.mark.parametrize("masks", [[], [np.zeros((240, 352), np.uint8)] * 3], ids=["none", "black"])
def test_a_sequence_without_any_walker_is_refused(masks):
    with pytest.raises(SilhouetteError, match=f"none of the {len(masks)} frames"):
        measure_sequence(masks)


def test_a_head_lost_but_for_a_speck_is_found_again(draw_walker):
    masks = [draw_walker(left=100 + 3 * at) for at in range(11)]
    truth = measure_sequence(masks)
    # The head shrinks to a piece too small to reach over the gap by itself.
    masks[5][43:60] = 0
    masks[5][40:43, :133] = masks[5][40:43, 137:] = 0
    assert find_body(masks[5]).h == 100
    boxes = measure_sequence(masks)
    assert boxes["y"].tolist() == truth["y"].tolist()
    assert boxes["h"].tolist() == truth["h"].tolist()


class Walk:
    """A stand-in for a `SilhouetteSequence`: masks, or a fault to raise."""

    subject = "abc"

    def __init__(self, name, masks):
        self.name = name
        self.masks = masks

    def frames(self):
        if isinstance(self.masks, Exception):
            raise self.masks
        yield from self.masks


def test_walks_that_cannot_be_measured_are_left_out_and_named(draw_walker):
    good = Walk("good", [draw_walker()] * 3)
    black = Walk("black", [np.zeros((240, 352), np.uint8)] * 3)
    torn = Walk("torn", DatasetError("sequence torn: truncated."))
    boxes, problems = measure_sequences([torn, good, black], n_jobs=1)
    assert set(boxes["sequence"]) == {"good"}
    assert len(problems) == 2
    assert "torn" in problems[0]
    assert "black" in problems[1]


@pytest.mark.parametrize("walks", [[], [Walk("torn", DatasetError("sequence torn: truncated."))]])
def test_nothing_to_measure_is_refused(walks):
    with pytest.raises(DatasetError, match="none could be measured"):
        measure_sequences(walks, n_jobs=1)


def test_the_number_of_processes_changes_nothing(draw_walker):
    walks = [
        Walk(f"walk-{k}", [draw_walker(left=90 + k + 2 * at) for at in range(6)]) for k in range(3)
    ]
    one, _ = measure_sequences(walks, n_jobs=1)
    two, _ = measure_sequences(walks, n_jobs=2)
    assert one.equals(two)
    assert one[[*MEASURES, AREA]].notna().all(axis=None)


@given(
    st.lists(
        st.tuples(st.integers(0, 40), st.integers(0, 30), st.integers(1, 12), st.integers(1, 12)),
        min_size=1,
        max_size=6,
    ),
    st.integers(1, 9),
)
def test_closing_only_adds_and_closes_once(rectangles, size):
    mask = np.zeros((40, 50), np.uint8)
    for x, y, w, h in rectangles:
        mask[y : y + h, x : x + w] = 255
    closed = close_gaps(mask, size=size)
    assert (closed >= mask).all()
    assert (close_gaps(closed, size=size) == closed).all()
    assert (close_gaps(mask[:, ::-1], size=size) == closed[:, ::-1]).all()


def test_closing_bridges_gaps_but_not_to_the_border():
    mask = np.zeros((60, 60), np.uint8)
    mask[2:58, 2:20] = 255
    mask[2:58, 22:40] = 255
    expected = mask.copy()
    expected[2:58, 20:22] = 255
    closed = close_gaps(mask, size=5)
    # A disc leaves the ends of a gap open by less than its radius.
    assert (closed[4:56] == expected[4:56]).all()
    assert not closed[:2].any()
    assert not closed[58:].any()
    assert not closed[:, :2].any()


def overlap(mask, truth):
    """Intersection over union."""
    return np.count_nonzero(mask & truth) / np.count_nonzero(mask | truth)


def test_flow_brings_back_a_leg_that_is_lost_for_a_frame(draw_walker):
    truth = np.stack([draw_walker(left=60 + 3 * at) for at in range(7)])
    masks = truth.copy()
    masks[3, 110:160, 89:] = 0
    mended = rectify_with_flow(masks)
    assert mended.dtype == np.uint8
    assert set(np.unique(mended)) == {0, 255}
    assert overlap(masks[3], truth[3]) < 0.9 < overlap(mended[3], truth[3])
    # The neighbours, whole before, stay so.
    assert min(overlap(mended[at], truth[at]) for at in (2, 4)) > 0.95


def test_flow_drops_a_speck_that_lasts_one_frame(draw_walker):
    masks = np.stack([draw_walker(left=60 + 3 * at) for at in range(5)])
    masks[2, 200:206, 300:306] = 255
    assert not rectify_with_flow(masks)[2, 195:211, 295:311].any()


@pytest.mark.parametrize(
    "masks",
    [
        np.zeros((1, 40, 50), np.uint8),
        [np.zeros((40, 50), np.uint8), np.zeros((50, 40), np.uint8)],
        np.zeros((3, 8, 8), np.uint8),
        np.full((2, 40, 50), 7.0),
    ],
    ids=["one", "sizes", "tiny", "grey"],
)
def test_masks_that_flow_cannot_work_on_are_refused(masks):
    with pytest.raises(ArgumentError, match="mask"):
        rectify_with_flow(masks)


def test_a_checked_mask_is_zero_and_255():
    assert check_mask([[0, 3], [3, 0]]).tolist() == [[0, 255], [255, 0]]
