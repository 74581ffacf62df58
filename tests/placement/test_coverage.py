"""Walker-seconds and candidates against geometry done by hand."""

import numpy as np
import pandas as pd
import pytest

from mcnlab.cameras.floor import GridMap
from mcnlab.cameras.visibility import CameraModel
from mcnlab.datasets.scene import Scene
from mcnlab.errors import ArgumentError
from mcnlab.placement.coverage import aim_cameras, candidates, walker_seconds

PAN = CameraModel(near=1.0, reach=20.0, pans=True)
FIXED = CameraModel(field_of_view=60.0, near=1.0, reach=20.0)


def walk(course, speed=1.2, *, frame_rate=25.0, seconds=4.0, start=(0.0, 0.0), trace="a"):
    """A straight walk, course in degrees."""
    frame = np.arange(int(seconds * frame_rate) + 1)
    far = speed * frame / frame_rate
    turn = np.deg2rad(course)
    x, y = start[0] + far * np.cos(turn), start[1] + far * np.sin(turn)
    return pd.DataFrame({"trace": trace, "frame": frame, "x": x, "y": y})


def target(x, y, course):
    return pd.DataFrame({"x": [x], "y": [y], "course": [course]})


# Walker-seconds


@pytest.mark.parametrize("frame_rate", [2.0, 2.5, 7.0, 16.0, 25.0])
@pytest.mark.parametrize("course", [0.0, 30.0, 200.0, 359.0])
def test_a_straight_walk_has_its_course_every_second(frame_rate, course):
    table = walker_seconds(walk(course, frame_rate=frame_rate), frame_rate=frame_rate)
    assert len(table) == 4
    assert table["course"].to_numpy() == pytest.approx(course, abs=1e-6)
    away = np.hypot(table["x"], table["y"])
    assert away.to_numpy() == pytest.approx(1.2 * table["second"])
    # A second's places lie within it, both ends included.
    assert (abs(table["second"] - (np.arange(4) + 0.5)) <= 0.5).all()


def test_frame_numbers_may_have_a_step():
    dense = walk(70.0, frame_rate=2.5)
    sparse = dense.assign(frame=10 * dense["frame"] + 1)
    one, other = walker_seconds(dense, frame_rate=2.5), walker_seconds(sparse, frame_rate=25.0)
    pd.testing.assert_frame_equal(one.drop(columns="second"), other.drop(columns="second"))


def test_standing_people_are_left_out():
    walks = pd.concat([walk(0.0, trace="walks"), walk(0.0, 0.1, trace="stands")])
    assert set(walker_seconds(walks, frame_rate=25.0)["trace"]) == {"walks"}


def test_a_gap_leaves_its_seconds_out():
    table = walk(0.0, seconds=6.0)
    table = table[(table["frame"] < 40) | (table["frame"] > 110)]  # 1.6 s to 4.4 s
    # Of second 1, 0.6 s are left, and of second 4, 0.56 s; of 2 and 3 nothing.
    found = np.floor(walker_seconds(table, frame_rate=25.0)["second"])
    assert list(found) == [0, 1, 4, 5]


def test_walked_backwards_the_course_is_opposite():
    there = walk(20.0)
    back = there.assign(x=there["x"].to_numpy()[::-1], y=there["y"].to_numpy()[::-1])
    course = walker_seconds(back, frame_rate=25.0)["course"].to_numpy()
    assert course == pytest.approx(200.0)


def test_a_scene_brings_its_frame_rate():
    traces = walk(10.0)
    scene = Scene("made up", traces, 25.0, (-5, -5, 10, 10))
    pd.testing.assert_frame_equal(walker_seconds(scene), walker_seconds(traces, frame_rate=25.0))
    with pytest.raises(ArgumentError, match="frame_rate"):
        walker_seconds(scene, frame_rate=25.0)


@pytest.mark.parametrize(
    ("traces", "options", "word"),
    [
        (walk(0.0, 0.0), {"frame_rate": 25.0}, "nobody moves"),
        (walk(0.0), {"frame_rate": 0.4}, "twice"),
        (walk(0.0), {}, "frame_rate"),
        (walk(0.0), {"frame_rate": 25.0, "every": 0}, "every"),
        (walk(0.0), {"frame_rate": 25.0, "least_speed": np.nan}, "least_speed"),
    ],
)
def test_walks_without_walker_seconds_are_refused(traces, options, word):
    with pytest.raises(ArgumentError, match=word):
        walker_seconds(traces, **options)


# Cameras


def test_candidates_are_every_place_with_every_heading():
    grid = GridMap(0.0, 0.0, 2, 3, 1.0)
    table = candidates(grid, model=FIXED, headings=4)
    assert len(table) == 2 * 3 * 4
    assert list(table["heading"][:4]) == [0, 90, 180, 270]
    row, column = grid.cell_of(table["x"], table["y"])
    assert (table["place"] == row * 3 + column).all()
    assert len(candidates(grid, model=PAN)) == 6


def test_no_camera_stands_where_it_is_forbidden():
    grid = GridMap(0.0, 0.0, 2, 3, 1.0)
    forbidden = np.zeros((2, 3), dtype=bool)
    forbidden[1, 2] = True
    by_map = candidates(grid, model=PAN, forbidden=forbidden)
    by_rule = candidates(grid, model=PAN, forbidden=lambda x, y: (x > 2) & (y > 1))
    assert list(by_map["place"]) == [0, 1, 2, 3, 4]
    pd.testing.assert_frame_equal(by_map, by_rule)


def test_a_voted_place_turns_to_where_it_adds_most():
    # The second camera at the same place takes the walkers that the first left.
    targets = pd.concat([target(0, 5, 0.0)] * 3 + [target(5, 0, 90.0)] * 2)
    table = aim_cameras([[0, 0], [0, 0], [0, 0]], targets, FIXED, headings=4)
    assert list(table["heading"]) == [90, 0, 90]
    assert list(table["place"]) == [0, 1, 2]
    assert len(aim_cameras([[0, 0]], targets, PAN)) == 1


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"forbidden": np.ones((2, 2), dtype=bool)}, "no place"),
        ({"forbidden": np.zeros((2, 3), dtype=bool)}, "shape"),
        ({"forbidden": np.zeros((2, 2))}, "boolean"),
        ({"headings": 0}, "headings"),
        ({"headings": []}, "headings"),
        ({"headings": [np.nan]}, "finite"),
        ({"model": None}, "CameraModel"),
    ],
)
def test_impossible_candidates_are_refused(options, word):
    with pytest.raises(ArgumentError, match=word):
        candidates(GridMap(0.0, 0.0, 2, 2, 1.0), **{"model": FIXED, **options})
