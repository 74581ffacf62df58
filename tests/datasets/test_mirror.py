"""Mirror images: measured images and mirrored tables must tell the same, to the last bit."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from mcnlab.compass import DIRECTIONS, heading_of, turn_between
from mcnlab.datasets.mirror import (
    OBLIQUE,
    SUFFIX,
    add_mirrored,
    mirror_boxes,
    mirror_direction,
    mirror_masks,
)
from mcnlab.datasets.recording import Recording
from mcnlab.errors import ArgumentError, DatasetError, McnError, SilhouetteError, TableError
from mcnlab.vision.silhouettes import find_body, measure_sequence, rectify_with_flow

# Rectangles (x, y, w, h) on a canvas of 48 by 36 pixels; w or h beyond it is cut off.
rectangles = st.lists(
    st.tuples(st.integers(0, 47), st.integers(0, 35), st.integers(1, 16), st.integers(1, 24)),
    min_size=1,
    max_size=7,
)


def paint(shapes, size=(36, 48)):
    mask = np.zeros(size, np.uint8)
    for x, y, w, h in shapes:
        mask[y : y + h, x : x + w] = 255
    return mask


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_a_mirrored_direction_turns_the_other_way(direction):
    mirrored = mirror_direction(direction)
    assert turn_between(heading_of(mirrored), -heading_of(direction)) == 0
    assert mirror_direction(mirrored) == direction


def test_directions_are_mirrored_all_at_once():
    assert mirror_direction(DIRECTIONS).tolist() == [1, 8, 7, 6, 5, 4, 3, 2]


@pytest.mark.parametrize("direction", [0, 9, -1, 1.5, np.nan, [1, 0], None])
def test_a_direction_that_is_none_is_refused(direction):
    with pytest.raises(ArgumentError, match="1 to 8"):
        mirror_direction(direction)


@given(rectangles)
def test_masks_mirrored_twice_are_the_same(shapes):
    mask = paint(shapes)
    mirrored = mirror_masks([mask, mask])
    assert (mirrored[0] == mask[:, ::-1]).all()
    assert (mirror_masks(mirrored)[1] == mask).all()


@given(data=st.data(), frame_width=st.integers(1, 4000))
def test_boxes_mirrored_twice_are_the_same(box_tables, data, frame_width):
    boxes = data.draw(box_tables)
    try:
        mirrored = mirror_boxes(boxes, frame_width=frame_width)
    except McnError:
        return
    again = mirror_boxes(mirrored, frame_width=frame_width)
    others = boxes.columns.drop(["x", "cx"])
    assert mirrored[others].equals(boxes[others])
    # Two subtractions of numbers under 5000 round by at most 4 halves of 2⁻⁴⁰.
    assert again["x"].to_numpy(float) == pytest.approx(boxes["x"].to_numpy(float), abs=1e-11)
    assert again["cx"].to_numpy(float) == pytest.approx(boxes["cx"].to_numpy(float), abs=1e-11)


def test_pixel_coordinates_mirror_exactly(make_boxes):
    # Whole pixels and sixteenths, as silhouettes are measured: no rounding at all.
    boxes = make_boxes(cx=120 + np.arange(10) / 16)
    mirrored = mirror_boxes(boxes, frame_width=352)
    assert mirrored["x"].tolist() == [352 - x - 40 for x in boxes["x"]]
    assert mirrored["cx"].tolist() == [351 - cx for cx in boxes["cx"]]
    assert mirror_boxes(mirrored, frame_width=352).equals(boxes)


@given(st.lists(rectangles, min_size=1, max_size=3), st.sampled_from([1, 4, 12]))
@settings(max_examples=400)
# Two equal pieces in one row: which is the body must not hang on which is more to the left.
@example([[(8, 1, 1, 2), (0, 5, 1, 3), (8, 5, 1, 3)]], 1)
# A centroid midway between two sixteenths must be rounded the same way from both sides.
@example([[(36, 0, 5, 1), (30, 0, 6, 4), (34, 5, 3, 1)]], 1)
# Two equal pieces in a frame that its neighbours mend.
@example([[(20, 5, 8, 20)]] * 3 + [[(20, 1, 3, 28), (25, 1, 4, 21)]] + [[(20, 5, 8, 20)]] * 3, 12)
def test_measuring_a_mirror_image_gives_the_mirrored_table(frames, min_area):
    masks = np.array([paint(shapes) for shapes in frames])
    tables = []
    for images in (masks, mirror_masks(masks)):
        try:
            tables.append(measure_sequence(images, min_area=min_area))
        except SilhouetteError:
            tables.append(None)
    boxes, mirrored = tables
    assert (boxes is None) == (mirrored is None)
    if boxes is not None:
        pd.testing.assert_frame_equal(
            mirrored, mirror_boxes(boxes, frame_width=48), check_exact=True
        )


@given(rectangles, st.lists(rectangles, min_size=4, max_size=6))
@settings(max_examples=50)
def test_so_it_does_when_neighbours_mend_a_frame(walker, noise):
    # A steady walker with other rubbish in every frame, so that some boxes are mended.
    masks = np.array([paint(walker) | paint(shapes) for shapes in noise] + [paint(walker)] * 5)
    boxes = [_measure_or_none(images) for images in (masks, mirror_masks(masks))]
    assert (boxes[0] is None) == (boxes[1] is None)
    if boxes[0] is not None:
        pd.testing.assert_frame_equal(
            boxes[1], mirror_boxes(boxes[0], frame_width=48), check_exact=True
        )


def _measure_or_none(masks):
    try:
        return measure_sequence(masks)
    except SilhouetteError:
        return None


def test_the_body_of_a_mirror_image_is_the_mirrored_body(draw_walker):
    mask = draw_walker()
    mask[100:104] = 0
    mask[30, 20:22] = 255
    assert (find_body(mirror_masks(mask)).mask == find_body(mask).mask[:, ::-1]).all()


def test_mended_masks_mirror_up_to_a_pixel_at_the_outline(draw_walker):
    masks = np.stack([draw_walker(left=100 + 3 * at) for at in range(3)])
    there, back = rectify_with_flow(masks), mirror_masks(rectify_with_flow(mirror_masks(masks)))
    # Flow is found patch by patch, from the left: the outline may differ, the inside may not.
    assert np.count_nonzero(there != back) < 0.02 * np.count_nonzero(there)


@pytest.fixture
def labelled(make_boxes):
    boxes = pd.concat(
        [make_boxes(sequence=f"walk-{d}", x=30.0 + d) for d in DIRECTIONS], ignore_index=True
    )
    directions = pd.Series({f"walk-{d}": d for d in DIRECTIONS}, name="direction")
    return Recording("made-up", boxes, 25.0, 352, 240, directions=directions)


def test_oblique_walks_get_a_mirrored_copy(labelled):
    eight = add_mirrored(labelled)
    assert eight.copies == {f"walk-{d}{SUFFIX}" for d in OBLIQUE}
    assert len(eight.sequences) == 8 + 4
    for direction in OBLIQUE:
        name = f"walk-{direction}"
        assert eight.directions[name] == direction
        assert eight.directions[name + SUFFIX] == mirror_direction(direction)
        twin = mirror_boxes(eight.sequence(name), frame_width=352)
        assert (
            eight.sequence(name + SUFFIX)
            .drop(columns="sequence")
            .equals(twin.drop(columns="sequence"))
        )
    assert eight.boxes.iloc[: len(labelled.boxes)].equals(labelled.boxes)


def test_other_directions_can_be_chosen_to_mirror(labelled):
    assert add_mirrored(labelled, directions=[3]).copies == {"walk-3" + SUFFIX}
    assert add_mirrored(labelled, directions=[]) is labelled


def test_mirroring_without_labels_or_twice_is_refused(labelled):
    with pytest.raises(DatasetError, match="no direction labels"):
        add_mirrored(labelled.with_boxes(labelled.boxes, directions=None))
    with pytest.raises(DatasetError, match="mirrored walks already"):
        add_mirrored(add_mirrored(labelled))


@pytest.mark.parametrize("frame_width", [0, -352, 352.0, True, np.nan, None])
def test_a_senseless_frame_width_is_refused(make_boxes, frame_width):
    with pytest.raises(ArgumentError, match="frame_width"):
        mirror_boxes(make_boxes(), frame_width=frame_width)


def test_what_is_no_image_and_no_box_table_is_refused(make_boxes):
    with pytest.raises(ArgumentError, match="masks"):
        mirror_masks([1, 2, 3])
    with pytest.raises(TableError, match="cx"):
        mirror_boxes(make_boxes().drop(columns="cx"), frame_width=352)
