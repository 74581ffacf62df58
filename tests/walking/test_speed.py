"""Apparent speed: what p and the levels are."""

import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mcnlab.datasets.mirror import mirror_boxes
from mcnlab.datasets.recording import Recording
from mcnlab.errors import ArgumentError, McnError, TableError
from mcnlab.tables import FRAME, SEQUENCE
from mcnlab.walking import speed

WIDTH, HEIGHT = 352, 240


def record(*tables, frame_rate=25.0, width=WIDTH, height=HEIGHT):
    """A recording of box tables."""
    boxes = pd.concat(tables, ignore_index=True)
    return Recording("made-up", boxes, frame_rate, width, height)


def walk(make_boxes, n, *, right, down=0.0, frame_rate=25.0, **columns):
    """A walker whose centroid moves by `right` and `down` pixels a second."""
    time = np.arange(n) / frame_rate
    cx, cy = 60 + right * time, 100 + down * time
    sound = {"x": cx - 20, "y": cy - 50, "w": 40.0, "h": 100.0, "cx": cx, "cy": cy}
    return make_boxes(n, **{**sound, **columns})


# --- levels ---------------------------------------------------------------------------------


def test_the_thresholds_belong_to_the_lower_level():
    # Thesis 3.2.2: v1 if p ≤ 1 % of the width, v2 up to 5 %, v3 above; exact in binary.
    p = [0, 1, 4, 4.0001, 20, 20.0001, 399, 1e6]
    levels = speed.level_of(p, frame_width=400, slow=0.01, fast=0.05)
    assert levels.tolist() == [1, 1, 1, 2, 2, 3, 3, 3]
    assert levels.dtype.kind == "i"


def test_one_walker_has_one_level():
    assert speed.level_of(0.0, frame_width=352) == 1
    assert speed.level_of(10.0, frame_width=352) == 2
    assert speed.level_of(18.0, frame_width=352) == 3


def test_equal_thresholds_leave_no_middle_level():
    assert speed.level_of([1, 10], frame_width=100, slow=0.05, fast=0.05).tolist() == [1, 3]


@given(
    st.lists(st.floats(0, 1e4), min_size=1, max_size=20),
    st.floats(1, 1e4),
    st.floats(0, 1),
    st.floats(0, 1),
)
def test_levels_rise_with_p_and_fall_with_thresholds(p, width, one, other):
    slow, fast = sorted((one, other))
    levels = speed.level_of(np.sort(p), frame_width=width, slow=slow, fast=fast)
    assert (np.diff(levels) >= 0).all()
    assert set(levels) <= set(speed.LEVELS)
    higher = speed.level_of(np.sort(p), frame_width=width, slow=fast, fast=fast + 0.1)
    assert (higher <= levels).all()


@pytest.mark.parametrize("p", [-1, np.nan, np.inf, [1, -0.1], "fast", [None]])
def test_p_must_be_a_length(p):
    with pytest.raises(ArgumentError, match=r"^p holds"):
        speed.level_of(p, frame_width=352)


@pytest.mark.parametrize("width", [0, -352, np.nan, None, "352"])
def test_the_frame_must_have_a_width(width):
    with pytest.raises(ArgumentError, match="frame_width"):
        speed.level_of(1.0, frame_width=width)


def test_thresholds_out_of_order_are_refused():
    with pytest.raises(ArgumentError, match=r"fast is 0\.01, below slow, 0\.05"):
        speed.level_of(1.0, frame_width=352, slow=0.05, fast=0.01)


@pytest.mark.parametrize("name", ["slow", "fast"])
def test_negative_thresholds_are_refused(name):
    with pytest.raises(ArgumentError, match=name):
        speed.level_of(1.0, frame_width=352, **{name: -0.01})


# --- windows and displacement ---------------------------------------------------------------


@pytest.mark.parametrize(
    ("seconds", "frame_rate", "frames"), [(1, 25, 25), (1, 7, 7), (0.5, 30, 15), (1, 2, 2)]
)
def test_a_window_has_as_many_frames_as_it_lasts(seconds, frame_rate, frames):
    assert speed.frames_of(seconds, frame_rate) == frames


@pytest.mark.parametrize("seconds", [0, -1, np.nan, np.inf, None, "1"])
def test_a_window_must_last(seconds):
    with pytest.raises(ArgumentError, match="seconds"):
        speed.frames_of(seconds, 25)


@pytest.mark.parametrize("frame_rate", [0, -25, np.nan])
def test_frames_must_follow_each_other(frame_rate, make_boxes):
    with pytest.raises(ArgumentError, match="frame_rate"):
        speed.frames_of(1, frame_rate)
    with pytest.raises(ArgumentError, match="frame_rate"):
        record(make_boxes(), frame_rate=frame_rate)


def test_two_frames_are_the_least():
    with pytest.raises(ArgumentError, match=r"pass at least 0\.08"):
        speed.frames_of(0.04, 25)


@given(
    st.floats(2, 120),
    st.floats(0.3, 3),
    st.floats(-150, 150),
    st.floats(-60, 60),
    st.integers(1, 4),
)
def test_p_does_not_depend_on_the_frame_rate(make_boxes, frame_rate, seconds, right, down, step):
    assume(round(frame_rate * seconds) >= 2)
    n = 2 * round(frame_rate * seconds)
    table = walk(make_boxes, n, right=right, down=down, frame_rate=frame_rate)
    # A frame wide enough that nobody reaches its edge.
    table = table.assign(x=table["x"] + 1000, cx=table["cx"] + 1000, y=table["y"] + 1000)
    held = record(table, frame_rate=frame_rate, width=4000, height=4000)
    found = speed.displacement_of(held, seconds=seconds, step=step)
    # 1e-6: places of up to 2000 px, rounded to 2⁻⁴², over two frames of 1/120 s.
    np.testing.assert_allclose(found["pixels"], math.hypot(right, down), atol=1e-6)
    np.testing.assert_allclose(found["sideways"], right, atol=1e-6)


def test_windows_follow_each_other_from_the_first_frame(make_boxes):
    held = record(
        walk(make_boxes, 60, right=10.0, sequence="long", frame=100 + np.arange(60)),
        walk(make_boxes, 24, right=10.0, sequence="short"),
        walk(make_boxes, 25, right=20.0, sequence="just", frame=7 + np.arange(25)),
    )
    found = speed.displacement_of(held)
    assert found[SEQUENCE].tolist() == ["long", "long", "just"]
    assert found[FRAME].tolist() == [100, 125, 7]
    np.testing.assert_allclose(found["pixels"], [10, 10, 20])


def test_windows_may_overlap(make_boxes):
    found = speed.displacement_of(record(walk(make_boxes, 30, right=10.0)), step=2)
    assert found[FRAME].tolist() == [1, 3, 5]


@pytest.mark.parametrize("step", [0, -1, 2.5, True])
def test_windows_start_whole_frames_apart(make_boxes, step):
    with pytest.raises(ArgumentError, match="step"):
        speed.displacement_of(record(walk(make_boxes, 30, right=10.0)), step=step)


@given(st.sets(st.integers(1, 25), max_size=10), st.floats(-80, 80))
def test_missing_frames_do_not_change_an_even_walk(make_boxes, missing, right):
    table = walk(make_boxes, 26, right=right, down=5.0)
    table = table[~table[FRAME].isin(missing)]
    table = table.assign(x=table["x"] + 300, cx=table["cx"] + 300)
    held = record(table, width=1000)
    first = table[FRAME].iloc[0]
    inside = table[FRAME][table[FRAME] < first + 25]
    # A window needs 60 % of its 25 frames between its boxes, and a track that long.
    assume(inside.iloc[-1] - first + 1 >= 15 and table[FRAME].iloc[-1] - first >= 24)
    found = speed.displacement_of(held)
    # 1e-9: places of up to 500 px over 0.6 s, rounded to 2⁻⁴⁴.
    np.testing.assert_allclose(found["pixels"], math.hypot(right, 5.0), atol=1e-9)


def test_a_window_with_too_large_a_gap_at_its_end_is_left_out(make_boxes):
    table = walk(make_boxes, 50, right=10.0)
    # Boxes 1 … 14 span 56 % of the first window, 1 … 15 just 60 %.
    assert speed.displacement_of(record(table.drop(range(14, 25))))[FRAME].tolist() == [26]
    assert speed.displacement_of(record(table.drop(range(15, 25))))[FRAME].tolist() == [1, 26]


def test_the_displacement_is_straight_whatever_the_way(make_boxes):
    # There and back again within a second.
    way = 100 + 40 * np.sin(np.pi * np.arange(25) / 24)
    table = make_boxes(25, x=way, cx=way + 20, cy=110.0)
    assert speed.displacement_of(record(table))["pixels"].iloc[0] == pytest.approx(0, abs=1e-9)


def test_who_stands_has_no_p_and_is_v1(make_boxes):
    found = speed.bin_speeds(record(walk(make_boxes, 25, right=0.0)))
    assert found["pixels"].tolist() == [0.0]
    assert found["share"].tolist() == [0.0]
    assert found["level"].tolist() == [1]


def test_boxes_cut_by_the_edge_are_not_used(make_boxes):
    # He enters at 25 px a second; while he is cut his box's middle moves half as fast.
    left = np.maximum(np.arange(50) - 5.0, 0)
    right = 35.0 + np.arange(50)
    table = make_boxes(50, x=left, w=right - left, cx=(left + right) / 2, h=100.0, cy=110.0)
    found = speed.displacement_of(record(table))
    np.testing.assert_allclose(found["pixels"], 25.0)


def test_a_second_that_nobody_was_seen_for_is_named(make_boxes):
    with pytest.raises(ArgumentError, match="no track of made-up has two boxes"):
        speed.displacement_of(record(walk(make_boxes, 24, right=10.0)))
    with pytest.raises(ArgumentError, match="1e\\+300"):
        speed.displacement_of(record(walk(make_boxes, 24, right=10.0)), seconds=1e300)


def test_frames_out_of_order_are_refused(make_boxes):
    with pytest.raises(TableError, match="unsorted frames"):
        record(make_boxes(25).iloc[::-1])


@given(st.floats(-80, 80), st.floats(-30, 30))
def test_a_mirrored_walk_is_as_fast(make_boxes, right, down):
    table = walk(make_boxes, 25, right=right, down=down)
    table = table.assign(x=table["x"] + 90, cx=table["cx"] + 90)
    mirrored = mirror_boxes(table, frame_width=WIDTH)
    one, other = (speed.displacement_of(record(held)) for held in (table, mirrored))
    # 1e-9: places of up to 352 px, rounded to 2⁻⁴⁴.
    np.testing.assert_allclose(one["pixels"], other["pixels"], atol=1e-9)
    np.testing.assert_allclose(one["sideways"], -other["sideways"], atol=1e-9)


@given(st.floats(0.1, 10))
def test_a_scaled_image_has_the_same_levels(make_boxes, scale):
    # Speeds off the thresholds of 3.52 and 17.6 px a second by more than rounding.
    tables = [
        walk(make_boxes, 25, right=p, sequence=f"walk-{p}") for p in (0.0, 3.4, 3.6, 17.5, 17.7, 90)
    ]
    pixels = ["x", "y", "w", "h", "cx", "cy"]
    scaled = [table.assign(**(table[pixels] * scale)) for table in tables]
    width, height = (round(side * scale * 1000) for side in (WIDTH, HEIGHT))
    assert width >= 1
    plain = speed.bin_speeds(record(*tables))["level"]
    p = speed.displacement_of(record(*scaled, width=width, height=height))["pixels"]
    assert plain.tolist() == [1, 1, 2, 2, 3, 3]
    assert speed.level_of(p, frame_width=scale * WIDTH).tolist() == plain.tolist()


def test_any_table_has_levels_or_a_clear_error(box_tables):
    @given(box_tables, st.floats(0.1, 5), st.integers(1, 40))
    def check(table, seconds, frame_rate):
        try:
            found = speed.bin_speeds(
                Recording("any", table, frame_rate, WIDTH, HEIGHT), seconds=seconds
            )
        except McnError:
            return
        assert np.isfinite(found[["pixels", "sideways", "share"]]).all(axis=None)
        assert found["level"].isin(speed.LEVELS).all()
        assert (found["pixels"] >= found["sideways"].abs() * (1 - 1e-12)).all()

    check()
