"""The grid map and walls, against known geometry."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mcnlab.cameras.floor import GridMap, check_grid, check_walls
from mcnlab.errors import ArgumentError


def test_walls_come_back_as_segments():
    wall = [[0, 0], [1, 2]]
    for none in (None, [], (), np.empty((0, 2, 2)), np.empty(0)):
        assert check_walls(none).shape == (0, 2, 2)
    assert check_walls([wall, wall]).tolist() == [wall, wall]
    assert check_walls([wall]).dtype == float


@pytest.mark.parametrize(
    ("walls", "words"),
    [
        ([[0, 1]], "shape"),
        (3.0, "shape"),
        ([[0, 0, 1, 2]], "shape"),
        ([[[0, 0], [1, 2]], [[0, 0]]], "no number|not numbers"),
        ([[["a", "b"], ["c", "d"]]], "no number|not numbers"),
        ("wall", "no number|not numbers"),
        ({"wall": 1}, "no number|not numbers"),
        ([[[0, 0], [1, 2]], [[0, np.nan], [1, 2]]], "nan in row 1"),
        ([[[0, 0], [np.inf, 2]]], "row 0"),
        ([[[0, 0], [1e300, 2]]], "row 0"),
    ],
)
def test_walls_that_are_none_are_refused(walls, words):
    with pytest.raises(ArgumentError, match=f"edges .*{words}"):
        check_walls(walls, argument="edges")


@pytest.mark.parametrize("grid", [None, (0, 0, 1, 1), np.zeros((3, 3)), GridMap])
def test_what_is_no_grid_is_refused(grid):
    with pytest.raises(ArgumentError, match=r"map is a .*; pass a GridMap"):
        check_grid(grid, argument="map")


@given(
    st.floats(-20, 20),
    st.floats(-20, 20),
    st.floats(0.05, 3),
    arrays(float, (20, 2), elements=st.floats(0, 0.999)),
)
def test_every_point_lies_in_the_cell_that_it_is_given(left, bottom, cell, shares):
    grid = GridMap(left, bottom, 7, 5, cell)
    places = [left, bottom] + shares * cell * np.array([5, 7])
    assume(grid.inside(*places.T).all())
    row, column = grid.cell_of(*places.T)
    x, y = grid.place_of(row, column)
    # Half a cell from its centre at most, but for rounding.
    assert np.abs(places - np.stack([x, y], axis=1)).max() <= cell / 2 + 1e-9
    assert (row >= 0).all() and (row < 7).all() and (column >= 0).all() and (column < 5).all()


def test_a_grid_covers_its_area_with_row_0_at_the_bottom():
    grid = GridMap.over((-1, 2, 4, 4.5), cell=0.5)
    assert grid.shape == (5, 10)
    assert grid.area == (-1, 2, 4, 4.5)
    assert grid.pixel == 0.5 / 8
    x, y = grid.centres()
    assert (x[0], y[0]) == (-0.75, 2.25)
    row, column = grid.cell_of([-1.0, 3.99], [2.0, 4.49])
    assert (row.tolist(), column.tolist()) == ([0, 4], [0, 9])


def test_points_outside_the_map_are_counted():
    grid = GridMap.over((0, 0, 2, 2))
    assert grid.inside([-0.1, 0, 2, np.nan], [0, 0, 0, 0]).tolist() == [False, True, False, False]
    with pytest.raises(ArgumentError, match="2 points lie outside"):
        grid.cell_of([1, 3, np.nan], [1, 1, 1])


@pytest.mark.parametrize(
    ("area", "cell", "words"),
    [
        ((0, 0, 0, 1), 0.5, "left < right"),
        ((0, 0, 1, np.nan), 0.5, "finite"),
        ((0, 0, 1), 0.5, "area"),
        (None, 0.5, "area"),
        ((0, 0, 1, 1), 0, "cell"),
        ((0, 0, 1e9, 1e9), 0.01, "larger cell"),
    ],
)
def test_an_impossible_map_is_refused(area, cell, words):
    with pytest.raises(ArgumentError, match=words):
        GridMap.over(area, cell=cell)
