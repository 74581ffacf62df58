"""Apparent speed: what p and the levels are, and true speed against what the picture shows."""

import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mcnlab.cameras import horizon
from mcnlab.datasets.mirror import mirror_boxes
from mcnlab.datasets.recording import Recording
from mcnlab.errors import ArgumentError, DatasetError, McnError, TableError
from mcnlab.statistics import Estimate
from mcnlab.tables import FRAME, SEQUENCE, WORLD_X, WORLD_Y
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
    with pytest.raises(ArgumentError, match=r"^p (is|holds)"):
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


# --- speeds compared ---------------------------------------------------------------------------


FOCAL, CAMERA = 900.0, np.array([3.0, -20.0, 6.0])


def filmed(make_boxes, tracks, *, stature=1.8, frame_rate=10.0):
    """People seen by a level camera at `CAMERA` that looks along world y: boxes and places."""
    boxes, world = [], []
    for name, (x, y, vx, vy) in tracks.items():
        time = np.arange(21) / frame_rate
        east, depth = x + vx * time - CAMERA[0], y + vy * time - CAMERA[1]
        height = FOCAL * stature / depth
        cx = (2000 - 1) / 2 + FOCAL * east / depth
        feet = 200 + FOCAL * CAMERA[2] / depth
        boxes.append(
            make_boxes(
                21,
                sequence=name,
                subject=name,
                x=cx - height / 5,
                y=feet - height,
                w=height / 2.5,
                h=height,
                cx=cx,
                cy=feet - height / 2,
            )
        )
        world.append(
            pd.DataFrame(
                {
                    SEQUENCE: name,
                    FRAME: 1 + np.arange(21),
                    WORLD_X: east + CAMERA[0],
                    WORLD_Y: depth + CAMERA[1],
                }
            )
        )
    held = record(*boxes, frame_rate=frame_rate, width=2000, height=1500)
    return held, pd.concat(world, ignore_index=True)


PACES = {0: 1.0, 8: -1.5, 16: 0.8, 24: 1.2, 32: -1.0}  # world y: m/s to the right
ACROSS = {f"{y}": (CAMERA[0] - v, y, v, 0.0) for y, v in PACES.items()}


@pytest.fixture(scope="module")
def scene(make_boxes):
    return filmed(make_boxes, ACROSS)


def test_the_camera_is_found_where_it_stands(scene):
    # Exact geometry: only the rounding of the direct linear transform is left.
    np.testing.assert_allclose(horizon.find_place(*scene), CAMERA[:2], atol=1e-6)


def test_pixels_fall_with_distance_and_body_heights_do_not(scene):
    recording, world = scene
    table = speed.compare_speeds(recording, world, place=CAMERA, focal_length=FOCAL)
    np.testing.assert_allclose(
        table["true_speed"], [abs(ACROSS[name][2]) for name in table[SEQUENCE]], atol=1e-9
    )
    # A second of at most 1.5 m across at 20 m or more leaves the line of sight by ±2° at most,
    # and its sine's square is what true_sideways may lose.
    np.testing.assert_allclose(table["true_sideways"], table["true_speed"], rtol=2e-3)
    depth = np.array([ACROSS[name][1] for name in table[SEQUENCE]]) - CAMERA[1]
    np.testing.assert_allclose(table["pixels"], FOCAL * table["true_speed"] / depth, rtol=1e-6)
    columns = (table["true_speed"], table["distance"], table[SEQUENCE])
    apparent = speed.distance_slope(table["pixels"], *columns)
    relative = speed.distance_slope(table["body_heights"], *columns)
    # Distance includes the camera's height, 6 m at 20 m and more: up to (6/20)²/2 = 5 % of the
    # logarithm's fall over the range, log(52/20.9), bends the slope by 0.05.
    assert apparent.value == pytest.approx(-1, abs=0.06)
    # FEET_LEAD moves the box by 0.11 body heights of 11 to 29: at most 1 % over the range.
    assert relative.value == pytest.approx(0, abs=0.02)
    assert apparent.n == relative.n == 5


def test_windows_without_true_motion_are_left_out(scene):
    recording, world = scene
    known = world[(world[SEQUENCE] == "8") & (world[FRAME] > 9)]
    table = speed.compare_speeds(recording, known, place=CAMERA, focal_length=FOCAL)
    # Of the first window, frames 1 … 10, one position is left: too few.
    assert table[[SEQUENCE, FRAME]].to_numpy().tolist() == [["8", 11]]
    with pytest.raises(DatasetError, match="no two positions"):
        speed.compare_speeds(recording, known[known[FRAME] > 99], place=CAMERA, focal_length=FOCAL)


def test_longer_and_shorter_windows_stand_in_one_table(scene):
    recording, world = scene
    table = speed.compare_speeds(
        recording, world, place=CAMERA[:2], focal_length=FOCAL, seconds=(0.5, 1, 2)
    )
    for seconds, count in {0.5: 4, 1.0: 2, 2.0: 1}.items():
        own = table[table["seconds"] == seconds]
        assert own[SEQUENCE].value_counts().to_dict() == dict.fromkeys(ACROSS, count)


@pytest.mark.parametrize("place", [(1, 2, 3, 4), (1,), (np.nan, 0), 3.0])
def test_the_place_must_be_a_place(scene, place):
    with pytest.raises(ArgumentError, match="place"):
        speed.compare_speeds(*scene, place=place, focal_length=FOCAL)


def test_a_person_twice_in_a_frame_is_refused(scene):
    recording, world = scene
    twice = pd.concat([world, world.iloc[:1]], ignore_index=True)
    with pytest.raises(DatasetError, match="twice"):
        speed.compare_speeds(recording, twice, place=CAMERA, focal_length=FOCAL)


def test_too_few_positions_show_no_camera(scene):
    recording, world = scene
    with pytest.raises(DatasetError, match="in 3 boxes with a place"):
        horizon.find_place(recording, world.iloc[:3])
    with pytest.raises(DatasetError, match="does not show where the camera stands"):
        horizon.find_place(recording, world[world[SEQUENCE] == "0"])


def test_a_camera_that_looks_straight_down_has_no_lines_of_sight(make_boxes):
    grid = np.array([(x, y) for x in range(4) for y in range(3)], float)
    boxes = make_boxes(12, x=90 + 10 * grid[:, 0], cx=100 + 10 * grid[:, 0], y=50 + 10 * grid[:, 1])
    world = pd.DataFrame({SEQUENCE: "walk", FRAME: 1 + np.arange(12)})
    world[[WORLD_X, WORLD_Y]] = np.c_[grid[:, 0], -grid[:, 1]]
    held = record(boxes.assign(h=40.0), width=2000, height=1500)
    with pytest.raises(DatasetError, match="parallel"):
        horizon.find_place(held, world)


# --- what the comparisons say ---------------------------------------------------------------


@given(st.floats(-3, 3), st.integers(0, 10))
def test_the_slope_is_the_power_of_distance(power, seed):
    rng = np.random.default_rng(seed)
    distance, true = rng.uniform(5, 50, 40), rng.uniform(0.6, 2, 40)
    people = np.arange(40) % 8
    found = speed.distance_slope(7 * true * distance**power, true, distance, people, draws=20)
    assert found.value == pytest.approx(power, abs=1e-6)
    assert found.low == pytest.approx(power, abs=1e-6)
    assert found.high == pytest.approx(power, abs=1e-6)
    assert found.n == 8
    assert Estimate(*found).value == found.value


def test_who_lingers_does_not_enter_the_slope():
    distance = np.array([10, 20, 30, 40.0])
    true, wild = np.ones(4), np.array([0.01, 0.0, 0.5, 0.1])
    found = speed.distance_slope(
        np.r_[1 / distance, [5, 5, 0, 5]],
        np.r_[true, wild],
        np.r_[distance, distance],
        list("abcdabcd"),
    )
    assert found.value == pytest.approx(-1)


def test_no_slope_where_the_data_have_none():
    same = np.ones(5)
    assert speed.distance_slope(same, same, 10 * same, list("abcde")) is None
    assert speed.distance_slope([1, 1], [1, 1], [10, 20], list("ab")) is None
    assert speed.distance_slope(same * 0, same, np.arange(1, 6), list("abcde")) is None
    alone = speed.distance_slope(1 / np.arange(1.0, 6), same, np.arange(1, 6), list("aaaaa"))
    assert alone.value == pytest.approx(-1)
    assert (alone.low, alone.high, alone.n) == (None, None, 1)


def test_people_seen_at_one_distance_each_still_have_an_interval():
    distance = np.array([10, 20, 40.0])
    found = speed.distance_slope(1 / distance, np.ones(3), distance, list("abc"))
    assert found[:3] == pytest.approx((-1, -1, -1))


@pytest.mark.parametrize("bad", [[1, 2, np.nan], [1, 2], [[1], [2], [3]], list("abc")])
def test_slopes_need_a_finite_number_of_each(bad):
    with pytest.raises(ArgumentError, match="distance"):
        speed.distance_slope([1, 2, 3], [1, 1, 1], bad, list("abc"))


@given(
    st.lists(
        st.tuples(st.integers(0, 6), st.sampled_from(speed.LEVELS), st.sampled_from("abc")),
        min_size=1,
        max_size=25,
    )
)
def test_misordered_pairs_are_counted(windows):
    true, level, people = map(np.array, zip(*windows, strict=True))
    below, above = true[level == 2], true[level == 3]
    found = speed.misordered(true, level, people, draws=50)
    if len(below) * len(above) == 0:
        assert found is None
        return
    wrong = [(low > high) + (low == high) / 2 for low in below for high in above]
    assert found.value == pytest.approx(np.mean(wrong))
    if found.low is not None:
        assert 0 <= found.low <= found.high <= 1
    assert found.n == len(set(people[level > 1]))


def test_levels_that_sort_people_are_never_wrong():
    true = np.arange(12.0)
    level = np.repeat([1, 2, 3], 4)
    people = np.tile(list("abcd"), 3)
    assert speed.misordered(true, level, people)[:3] == (0, 0, 0)
    assert speed.misordered(-true, level, people)[:3] == (1, 1, 1)
    assert speed.misordered(0 * true, level, people)[:3] == (0.5, 0.5, 0.5)


@given(st.lists(st.tuples(st.floats(0, 9), st.sampled_from(speed.LEVELS)), min_size=1))
def test_levels_by_another_measure_hold_as_many(windows):
    values, level = map(np.array, zip(*windows, strict=True))
    found = speed.level_like(values, level)
    assert np.bincount(found, minlength=4).tolist() == np.bincount(level, minlength=4).tolist()
    assert (np.diff(found[np.argsort(values, kind="stable")]) >= 0).all()


@pytest.mark.parametrize(("values", "level"), [([1, 2], [1]), ([np.nan], [1]), (1.0, 2)])
def test_levels_by_another_measure_need_one(values, level):
    with pytest.raises(ArgumentError, match=r"values|level"):
        speed.level_like(values, level)
