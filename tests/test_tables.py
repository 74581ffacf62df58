"""Box tables: what is refused, and why; and that stacking loses nothing."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcnlab import tables
from mcnlab.errors import McnError, TableError
from mcnlab.tables import BOX_COLUMNS, FRAME, MEASURES, SEQUENCE, check_boxes


def test_a_sound_table_comes_back_as_it_is(make_boxes):
    boxes = make_boxes()
    assert check_boxes(boxes) is boxes


@pytest.mark.parametrize("name", BOX_COLUMNS)
def test_a_missing_column_is_named(make_boxes, name):
    with pytest.raises(TableError, match=rf"people lacks the column\(s\) {name};"):
        check_boxes(make_boxes().drop(columns=name), argument="people")


def test_what_is_no_table_is_refused():
    with pytest.raises(TableError, match="boxes is a list; pass a pandas DataFrame"):
        check_boxes([1, 2, 3])


def test_an_empty_table_is_refused(make_boxes):
    with pytest.raises(TableError, match="no rows"):
        check_boxes(make_boxes().iloc[:0])


@pytest.mark.parametrize("name", [FRAME, *MEASURES])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_values_that_are_not_finite_are_refused(make_boxes, name, value):
    boxes = make_boxes().astype({FRAME: float})
    boxes.loc[3, name] = value
    with pytest.raises(TableError, match=r"row 3 .*not finite; drop"):
        check_boxes(boxes)


@pytest.mark.parametrize("name", MEASURES)
def test_values_beyond_any_image_are_refused(make_boxes, name):
    boxes = make_boxes()
    boxes.loc[3, name] = 1e300  # finite, but its square is not
    with pytest.raises(TableError, match="row 3"):
        check_boxes(boxes)


@pytest.mark.parametrize("name", ["w", "h"])
@pytest.mark.parametrize("value", [0.0, -5.0])
def test_boxes_without_a_size_are_refused(make_boxes, name, value):
    boxes = make_boxes()
    boxes.loc[3, name] = value
    with pytest.raises(TableError, match=r"row 3 .*positive"):
        check_boxes(boxes)


@pytest.mark.parametrize("frame", [[1, 3, 2], [1, 2, 2]], ids=["unsorted", "repeated"])
def test_frames_out_of_order_are_refused(make_boxes, frame):
    with pytest.raises(TableError, match="'walk'; drop duplicates and sort"):
        check_boxes(make_boxes(3, frame=frame))


def test_a_walk_in_two_pieces_is_refused(make_boxes):
    with pytest.raises(TableError, match="sort by sequence"):
        check_boxes(make_boxes(3, sequence=["a", "b", "a"]))


def test_fractional_frame_numbers_are_refused(make_boxes):
    with pytest.raises(TableError, match="fractional"):
        check_boxes(make_boxes(2, frame=[1, 1.5]))


@pytest.mark.parametrize("text", ["wide", "40"])
def test_text_in_a_number_column_is_refused(make_boxes, text):
    with pytest.raises(TableError, match="text"):
        check_boxes(make_boxes(w=text))


@pytest.mark.parametrize("name", ["sequence", "subject"])
def test_a_walk_without_a_name_is_refused(make_boxes, name):
    with pytest.raises(TableError, match="without a sequence or subject"):
        check_boxes(make_boxes(2, **{name: ["walk", None]}))


def test_a_column_that_is_there_twice_is_refused(make_boxes):
    boxes = make_boxes()
    with pytest.raises(TableError, match="w"):
        check_boxes(pd.concat([boxes, boxes[["w"]]], axis=1))


@given(data=st.data())
@settings(max_examples=300)
def test_whatever_passes_the_check_is_sound(box_tables, data):
    boxes = data.draw(box_tables)
    try:
        check_boxes(boxes)
    except McnError:
        return
    numbers = boxes[[FRAME, *MEASURES]].astype(float)
    assert np.isfinite(numbers.to_numpy()).all()
    assert (numbers[["w", "h"]] > 0).all(axis=None)
    for _, walk in boxes.groupby(SEQUENCE):
        assert np.ptp(walk.index) == len(walk) - 1
        assert (np.diff(walk[FRAME].astype(float)) >= 1).all()


@given(data=st.data())
@settings(max_examples=300)
def test_a_stack_holds_every_box_and_nothing_else(box_tables, data):
    boxes = data.draw(box_tables)
    try:
        stack = tables.stack_sequences(boxes)
    except McnError:
        return
    assert stack.valid.sum() == len(boxes)
    row = np.array([stack.names.index(name) for name in boxes[SEQUENCE]])
    column = boxes[FRAME].to_numpy(int) - stack.start[row]
    assert stack.valid[row, column].all()
    assert (column < stack.length[row]).all()
    for name in MEASURES:
        assert (stack.curves[name][row, column] == boxes[name].to_numpy(float)).all()
        assert (stack.curves[name][~stack.valid] == 0).all()


def test_split_sequences_gives_each_walk_its_rows(make_boxes):
    boxes = make_boxes(5, sequence=["b", "b", "a", "a", "a"], frame=[1, 2, 1, 2, 3])
    found = list(tables.split_sequences(boxes))
    assert found == [("b", slice(0, 2)), ("a", slice(2, 5))]


@pytest.mark.parametrize(
    ("names", "starts"),
    [("", []), ("a", [0]), ("aab", [0, 2]), ("abba", [0, 1, 3])],
)
def test_a_name_starts_where_it_differs_from_the_one_before(names, starts):
    assert tables.starts_of(np.array(list(names), dtype=object)).tolist() == starts
    assert tables.starts_of(np.array([ord(name) for name in names])).tolist() == starts


@pytest.mark.parametrize("last", [10**12, 1e300])
def test_a_frame_number_far_off_is_refused(make_boxes, last):
    with pytest.raises(TableError, match="frame"):
        tables.stack_sequences(make_boxes(2, frame=[1, last]))


def test_stacking_a_column_that_is_not_there_names_it(make_boxes):
    with pytest.raises(TableError, match=r"lacks .* area"):
        tables.stack_sequences(make_boxes(), ["area"])
