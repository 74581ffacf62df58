"""Synthetic crossings, against the pinhole camera by hand and against how people walk."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from hypothesis import strategies as st

from mcnlab.errors import ArgumentError, DatasetError
from mcnlab.synthetic import crossings
from mcnlab.synthetic.crossings import BOB, PACE, STANDING, Square, make_crossings

metres = st.floats(-20, 20)


def steps_of(recording):
    """Each person's steps from frame to frame, metres: sequence → (n, 2), (n,) first frames."""
    steps = {}
    for name, rows in recording.boxes.groupby("sequence", sort=False):
        place = rows[["world_x", "world_y"]].to_numpy()
        whole = np.diff(rows["frame"]) == 1
        steps[name] = np.diff(place, axis=0)[whole], rows["frame"].to_numpy()[:-1][whole]
    return steps


# The camera


@pytest.mark.parametrize("factor", [0.5, 2, 3])
def test_a_larger_image_shows_the_same_people_larger(factor):
    square = Square()
    plain, large = (
        make_crossings(people=15, seconds=8, square=s).boxes
        for s in (square, square.scaled(factor))
    )
    both = plain.merge(large, on=["sequence", "frame"], suffixes=("", "_large"))
    # Only boxes that touch the frame's edge, or hardly show, may be in one of them only.
    assert len(both) > 0.98 * max(len(plain), len(large))
    for name in ("x", "y", "cx", "cy"):
        # Pixels count from the middle of the first one.
        np.testing.assert_allclose(
            both[f"{name}_large"], factor * (both[name] + 0.5) - 0.5, atol=1e-9
        )
    for name in ("w", "h"):
        np.testing.assert_allclose(both[f"{name}_large"], factor * both[name], atol=1e-9)
    for name in ("world_x", "world_y"):
        np.testing.assert_array_equal(both[f"{name}_large"], both[name])


# The boxes


@pytest.mark.parametrize("tilt", [0, 9, 25])
def test_a_box_stands_where_the_walker_does_and_is_as_tall(tilt):
    square = Square(tilt=tilt, height=2.5 + tilt / 10)
    boxes = make_crossings(people=20, seconds=10, square=square, box_noise=0).boxes
    places = boxes[["world_x", "world_y"]]
    depth, (column, feet) = square.camera.depth(places), square.camera.project(places).T
    np.testing.assert_allclose(boxes["cx"], column, atol=1e-9)
    np.testing.assert_allclose(boxes["y"] + boxes["h"], feet, atol=1e-9)
    # With d the depth of the feet, a the distance ahead and c, s of the tilt, a body of U has
    # h = f·a·U / (d·(a·c + (height − U)·s)); solved for U.
    c, s = np.cos(np.radians(tilt)), np.sin(np.radians(tilt))
    pull = boxes["h"] * depth
    ahead = boxes["world_y"]
    stature = pull * (ahead * c + square.height * s) / (square.focal_length * ahead + pull * s)
    who = stature.groupby(boxes["sequence"])
    assert stature.between(1.4 * (1 - BOB), 2.1 * (1 + BOB)).all()
    # The head bobs by BOB either way, and nothing else changes.
    assert (who.max() / who.min() <= (1 + BOB) / (1 - BOB) + 1e-9).all()


def test_from_a_level_camera_height_shrinks_with_distance(monkeypatch):
    monkeypatch.setattr(crossings, "STATURE", (1.72, 0.0))
    monkeypatch.setattr(crossings, "BOB", 0.0)
    boxes = make_crossings(people=10, seconds=8, square=Square(tilt=0), box_noise=0).boxes
    np.testing.assert_allclose(boxes["h"], 800 * 1.72 / boxes["world_y"])


def test_boxes_are_wholly_inside_the_frame():
    for seed, square in enumerate((Square(), Square(tilt=35, height=6), Square().scaled(0.3))):
        made = make_crossings(people=30, seconds=10, seed=seed, square=square, box_noise=0.02)
        boxes = made.boxes
        assert (made.frame_width, made.frame_height) == (square.frame_width, square.frame_height)
        assert (boxes[["x", "y"]] >= 0).all().all()
        assert (boxes["x"] + boxes["w"] <= square.frame_width - 1 + 1e-9).all()
        assert (boxes["y"] + boxes["h"] <= square.frame_height - 1 + 1e-9).all()
        assert (boxes[["w", "h"]] > 1).all().all()
        assert boxes["frame"].between(1, 250).all()
        np.testing.assert_allclose(boxes["cx"], boxes["x"] + boxes["w"] / 2)
        np.testing.assert_allclose(boxes["cy"], boxes["y"] + boxes["h"] / 2)


def test_edges_are_wrong_by_the_noise():
    plain, noisy = (make_crossings(people=30, seconds=20, box_noise=s).boxes for s in (0, 0.01))
    both = plain.merge(noisy, on=["sequence", "frame"], suffixes=("", "_noisy"))
    # Away from the frame's edges, where boxes with unlucky errors are left out.
    both = both[
        (both["x"] > 15)
        & (both["x"] + both["w"] < 624)
        & (both["y"] > 15)
        & (both["y"] + both["h"] < 464)
    ]
    assert len(both) > 2000
    for error in (
        both["x_noisy"] - both["x"],
        both["y_noisy"] - both["y"],
        both["x_noisy"] + both["w_noisy"] - both["x"] - both["w"],
        both["y_noisy"] + both["h_noisy"] - both["y"] - both["h"],
    ):
        share = error / both["h"]
        # The standard error of n normal values' deviation is 1/√(2n), of their mean 1/√n.
        assert share.std() == pytest.approx(0.01, rel=4 / np.sqrt(2 * len(both)))
        assert abs(share.mean()) < 4 * 0.01 / np.sqrt(len(both))


def test_who_stands_has_a_box_that_keeps_still(monkeypatch):
    monkeypatch.setattr(crossings, "STANDING", 1.0)
    boxes = make_crossings(people=10, seconds=5, box_noise=0).boxes
    who = boxes.groupby("sequence")[["x", "y", "w", "h"]]
    pd.testing.assert_frame_equal(who.min(), who.max(), check_exact=True)


# How people walk


@pytest.mark.parametrize("turning", [0.0, 12.0, 40.0])
def test_people_keep_their_pace_in_metres(turning):
    made = make_crossings(people=400, seconds=6, turning=turning, seed=3)
    pace = []
    for steps, _ in steps_of(made).values():
        speed = np.hypot(*steps.T) * made.frame_rate
        if len(speed):
            np.testing.assert_allclose(speed, speed[0], atol=1e-9)
            pace.append(speed[0])
    pace = np.array(pace)
    walking = pace > 1e-9
    # Standard errors of a share and of a mean of n; a few are too many standing in view or
    # too few, as who walks may be in view for less than two frames.
    n = len(pace)
    assert n > 300
    assert (~walking).mean() == pytest.approx(STANDING, abs=4 * np.sqrt(STANDING / n))
    assert pace[walking].mean() == pytest.approx(PACE[0], abs=4 * PACE[1] / np.sqrt(n / 2))


def test_people_who_do_not_turn_walk_straight():
    for steps, _ in steps_of(make_crossings(people=30, seconds=8, turning=0)).values():
        np.testing.assert_allclose(steps, np.broadcast_to(steps[:1], steps.shape), atol=1e-9)


def test_headings_wander_as_stated_within_a_second():
    made = make_crossings(people=300, seconds=20, turning=12, seed=4)
    turns = []
    for steps, frame in steps_of(made).values():
        if not len(steps):
            continue
        moving = np.hypot(*steps.T) > 1e-9
        heading = pd.Series(np.arctan2(*steps[moving].T), index=frame[moving])
        seconds = heading[(heading.index - frame[0]) % 25 == 0]
        after = heading.reindex(seconds.index + 25).to_numpy()
        turn = (after - seconds.to_numpy() + np.pi) % (2 * np.pi) - np.pi
        turns.extend(turn[np.isfinite(turn)])
    turns = np.degrees(turns)
    # Turns in seconds apart from each other are independent.
    assert len(turns) > 500
    assert turns.std() == pytest.approx(12, rel=4 / np.sqrt(2 * len(turns)))
    assert abs(turns.mean()) < 4 * 12 / np.sqrt(len(turns))


def test_everybody_is_ahead_of_the_camera():
    # A wide view that looks down: it would show people below and behind the camera, too.
    square = Square(focal_length=150, tilt=60, height=5, near=6, far=20)
    boxes = make_crossings(people=100, seconds=30, square=square).boxes
    assert (boxes["world_y"] < 0.4 * square.near).any()
    assert (boxes["world_y"] > 0.3 * square.near).all()
    assert (square.camera.depth(boxes[["world_x", "world_y"]]) > 0).all()


# The recording


def test_the_same_seed_gives_the_same_bytes_and_another_does_not():
    one, two, other = (make_crossings(people=5, seconds=5, seed=seed).boxes for seed in (7, 7, 8))
    pd.testing.assert_frame_equal(one, two, check_exact=True)
    assert (
        one.drop(columns=["sequence", "subject"]).to_numpy().tobytes()
        == two.drop(columns=["sequence", "subject"]).to_numpy().tobytes()
    )
    assert not one.equals(other)


def test_it_is_a_recording_of_so_many_people_at_that_rate():
    made = make_crossings(people=9, seconds=4, frame_rate=7)
    assert (made.name, made.frame_rate, made.source) == ("crossings", 7.0, "synthetic")
    assert len(made.sequences) <= 9
    assert (made.boxes["sequence"] == made.boxes["subject"]).all()
    assert made.boxes["frame"].between(1, 28).all()
    assert all(made.boxes[name].dtype == float for name in ("x", "y", "w", "h", "world_x"))


# Bad input


@pytest.mark.parametrize(
    "square", [Square(tilt=-60), Square(height=300), Square(near=900, far=999)]
)
def test_a_square_without_anybody_is_refused(square):
    with pytest.raises(DatasetError, match="square shows nobody; move near and far"):
        make_crossings(people=3, seconds=2, square=square)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("people", 0),
        ("people", 2.5),
        ("seconds", 0),
        ("seconds", np.nan),
        ("frame_rate", 0),
        ("frame_rate", -25),
        ("turning", -1),
        ("turning", np.inf),
        ("box_noise", -0.1),
        ("box_noise", 0.3),
        ("seed", -1),
        ("seed", None),
        ("square", "square"),
        ("square", 0),
    ],
)
def test_impossible_crossings_are_refused(name, value):
    with pytest.raises(ArgumentError, match=f"^{name} is "):
        make_crossings(**{name: value})


@pytest.mark.parametrize("many", [{"people": 10**9}, {"seconds": 1e12}, {"frame_rate": 1e9}])
def test_more_than_fits_is_refused(many):
    with pytest.raises(ArgumentError, match="pass less, 10,000,000 at most"):
        make_crossings(**many)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("frame_width", 0),
        ("frame_height", 4.5),
        ("focal_length", 0),
        ("focal_length", np.inf),
        ("height", 0),
        ("height", 1e300),
        ("tilt", 81),
        ("tilt", -61),
        ("near", 0),
        ("near", "6"),
        ("far", 6),
        ("far", 1e300),
    ],
)
def test_impossible_cameras_are_refused(name, value):
    with pytest.raises(ArgumentError, match=f"^{name} is "):
        replace(Square(), **{name: value})


@pytest.mark.parametrize("factor", [0, -1, np.nan, np.inf, "2", 1e12])
def test_an_impossible_scale_is_refused(factor):
    with pytest.raises(ArgumentError, match=r"^factor is .* above 0"):
        Square().scaled(factor)
