"""What cameras see, against geometry done by hand."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcnlab.cameras import visibility
from mcnlab.cameras.visibility import CameraModel, sees, square_on
from mcnlab.errors import ArgumentError, TableError

PAN = CameraModel(near=1.0, reach=20.0, pans=True)
FIXED = CameraModel(field_of_view=60.0, near=1.0, reach=20.0)


def camera(x, y, heading=0.0):
    return pd.DataFrame({"x": [x], "y": [y], "heading": [heading]})


def target(x, y, course):
    return pd.DataFrame({"x": [x], "y": [y], "course": [course]})


def turned(table, angle):
    """The table's places turned about the origin, degrees."""
    c, s = np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))
    out = table.assign(x=c * table["x"] - s * table["y"], y=s * table["x"] + c * table["y"])
    for name in {"course", "heading"} & set(table.columns):
        out[name] = (table[name] + angle) % 360
    return out


def made_up(seed, n=60, m=40):
    """Walker-seconds and cameras at random places, and a few walls."""
    rng = np.random.default_rng(seed)
    targets = pd.DataFrame(rng.uniform(-10, 10, (n, 2)), columns=["x", "y"])
    targets["course"] = rng.uniform(0, 360, n)
    cameras = pd.DataFrame(rng.uniform(-12, 12, (m, 2)), columns=["x", "y"])
    cameras["heading"] = rng.uniform(0, 360, m)
    return targets, cameras, rng.uniform(-8, 8, (4, 2, 2))


def test_a_walker_along_x_is_square_on_from_the_south():
    assert square_on(target(0, 0, 0.0), camera(0, -5, 90.0), FIXED).all()
    assert square_on(target(0, 0, 180.0), camera(0, -5, 90.0), FIXED).all()
    assert not square_on(target(0, 0, 90.0), camera(0, -5, 90.0), FIXED).any()


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize(("off", "expected"), [(14.0, True), (15.0, True), (16.0, False)])
def test_square_on_ends_at_its_angle(side, off, expected):
    x = side * 5 * np.tan(np.deg2rad(off))
    assert square_on(target(0, 0, 0.0), camera(x, -5), PAN).item() is expected


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize(("off", "expected"), [(29.9, True), (30.0, True), (30.1, False)])
def test_the_field_of_view_lies_half_to_either_side(side, off, expected):
    for heading in (0.0, 90.0, 200.0, 345.0):
        turn = np.deg2rad(heading + side * off)
        point = [[5 * np.cos(turn), 5 * np.sin(turn)]]
        assert sees(point, camera(0, 0, heading), FIXED).item() is expected
        assert sees(point, camera(0, 0, heading), PAN).item()


@pytest.mark.parametrize(("away", "expected"), [(0, 0), (0.9, 0), (1, 1), (20, 1), (20.1, 0)])
def test_it_sees_from_near_to_reach(away, expected):
    assert sees([[away, 0]], camera(0, 0), FIXED).item() == bool(expected)


@pytest.mark.parametrize(
    ("wall", "blocked"),
    [
        ([[2, -1], [2, 1]], True),
        ([[2, 0], [2, 1]], True),  # its end belongs to it
        ([[2, 0.01], [2, 1]], False),
        ([[5, -1], [5, 1]], False),  # behind the walker
        ([[4, -1], [4, 1]], False),  # the walker touches it
        ([[0, -1], [0, 1]], False),  # the camera hangs on it
        ([[1, 0], [3, 0]], False),  # seen along
        ([[2, 2], [2, 2]], False),  # a mere point
    ],
)
def test_a_wall_blocks_where_sight_crosses_it(wall, blocked):
    args = ([[4.0, 0.0]], camera(0, 0), PAN)
    assert sees(*args, walls=[wall]).item() is not blocked
    assert sees(*args, walls=[wall[::-1]]).item() is not blocked
    assert sees(*args, walls=[[[9, 9], [9, 8]], wall]).item() is not blocked


@given(st.integers(0, 10**6), st.sampled_from([90.0, 180.0, 270.0]), st.booleans())
@settings(max_examples=25)
def test_turning_or_mirroring_the_scene_changes_nothing(seed, angle, mirror):
    targets, cameras, walls = made_up(seed)
    before = square_on(targets, cameras, FIXED, walls=walls)
    assert (before <= sees(targets[["x", "y"]], cameras, FIXED, walls=walls)).all()
    ends = pd.DataFrame(walls.reshape(-1, 2), columns=["x", "y"])
    tables = [turned(table, angle) for table in (targets, cameras, ends)]
    if mirror:
        tables = [table.assign(x=-table["x"]) for table in tables]
        for table, name in ((tables[0], "course"), (tables[1], "heading")):
            table[name] = (180 - table[name]) % 360
    walls = tables[2].to_numpy().reshape(-1, 2, 2)
    assert (square_on(tables[0], tables[1], FIXED, walls=walls) == before).all()


@given(st.integers(0, 10**6), st.floats(0.1, 50), st.floats(-1e4, 1e4))
@settings(max_examples=25)
def test_scale_and_origin_change_nothing(seed, scale, shift):
    targets, cameras, walls = made_up(seed)
    big = CameraModel(near=scale, reach=20 * scale)
    moved = [
        table.assign(x=scale * table["x"] + shift, y=scale * table["y"])
        for table in (targets, cameras)
    ]
    after = square_on(*moved, big, walls=scale * walls + [shift, 0])
    assert (after == square_on(targets, cameras, FIXED, walls=walls)).all()


def test_blocks_do_not_show(monkeypatch):
    targets, cameras, walls = made_up(3)
    whole = square_on(targets, cameras, FIXED, walls=walls)
    assert 0 < whole.sum() < sees(targets[["x", "y"]], cameras, FIXED).sum()
    monkeypatch.setattr(visibility, "BLOCK", 50)
    assert (square_on(targets, cameras, FIXED, walls=walls) == whole).all()


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"field_of_view": 0}, "field_of_view"),
        ({"field_of_view": 361}, "field_of_view"),
        ({"near": -1}, "near"),
        ({"reach": 0.5}, "reach"),
        ({"reach": np.nan}, "reach"),
        ({"square_within": 0}, "square_within"),
        ({"pans": "yes"}, "pans"),
    ],
)
def test_an_impossible_camera_is_refused(options, word):
    with pytest.raises(ArgumentError, match=word):
        CameraModel(**options)


def test_bad_points_tables_and_walls_are_refused():
    with pytest.raises(ArgumentError, match="points"):
        sees([[np.nan, 0]], camera(0, 0), FIXED)
    with pytest.raises(ArgumentError, match="cameras"):
        sees([[0, 0]], camera(0, np.inf), FIXED)
    with pytest.raises(ArgumentError, match="cameras"):
        sees([[0, 0]], camera(0, 0).iloc[:0], FIXED)
    with pytest.raises(TableError, match="heading"):
        sees([[0, 0]], camera(0, 0).drop(columns="heading"), FIXED)
    with pytest.raises(TableError, match="course"):
        square_on(target(0, 0, 0).drop(columns="course"), camera(0, 0), FIXED)
    for walls in ([[0, 1]], [[[0, 0], [np.nan, 1]]], [[[0, 0], [1, 1]], [[0, 0]]], "wall"):
        with pytest.raises(ArgumentError, match="walls"):
            sees([[0, 0]], camera(0, 0), FIXED, walls=walls)


def test_within_reach_has_its_edges_and_not_the_place_itself():
    away = np.array([0.0, 0.999, 1.0, 5.0, 12.0, 12.001])
    assert visibility.within_reach(away, 1.0, 12.0).tolist() == [
        False,
        False,
        True,
        True,
        True,
        False,
    ]
    assert visibility.within_reach(away, 0.0, [[5.0], [12.0]]).tolist() == [
        [False, True, True, True, False, False],
        [False, True, True, True, True, False],
    ]
