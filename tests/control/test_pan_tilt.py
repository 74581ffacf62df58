"""Master and slaves against closed forms, exhaustive matching, and the scene's symmetries."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import maximum_bipartite_matching

from mcnlab.cameras.visibility import CameraModel
from mcnlab.control.pan_tilt import STATES, PanTilt, simulate, slaves_at
from mcnlab.errors import ArgumentError, TableError

RATE = 25.0


def walk_past(*, distance=5.0, speed=1.4, half=8.0, name="a", frame_rate=RATE):
    """A trace along y = distance, from x = −half to half, at an even speed."""
    x = np.arange(-half, half, speed / frame_rate)
    return pd.DataFrame({"trace": name, "frame": np.arange(len(x)), "x": x, "y": distance})


def wander(seed, *, walkers=4, frames=50):
    """Traces that turn as they like, for 2 s each, through a place 20 m wide."""
    rng = np.random.default_rng(seed)
    tables = []
    for number in range(walkers):
        course = rng.uniform(0, 2 * np.pi) + np.cumsum(rng.normal(0, 0.05, frames))
        step = 1.4 / RATE * np.stack([np.cos(course), np.sin(course)], axis=1)
        x, y = (rng.uniform(-6, 6, 2) + np.cumsum(step, axis=0)).T
        start = int(rng.integers(0, 20))
        tables.append(
            pd.DataFrame(
                {"trace": f"w{number}", "frame": start + np.arange(frames), "x": x, "y": y}
            )
        )
    return pd.concat(tables, ignore_index=True)


def slaves(seed, *, number=3, **options):
    rng = np.random.default_rng([seed, 1])
    return [
        PanTilt(*rng.uniform(-10, 10, 2), pan=float(rng.uniform(-180, 180)), **options)
        for _ in range(number)
    ]


seeds = st.integers(0, 2**32 - 1)


@pytest.mark.parametrize(("distance", "speed"), [(2.0, 0.8), (5.0, 1.4), (3.0, 2.5)])
def test_needed_pan_rate_is_speed_times_sine_over_distance(distance, speed):
    traces = walk_past(distance=distance, speed=speed)
    watch = simulate(traces, [PanTilt(0, 0, reach=20, wake_time=0)], frame_rate=RATE)
    needed = np.radians(watch.table["needed"].to_numpy())[1:]
    # From frame to frame the bearing turns by the mean of w(t) = v·sin(a)/r over the time
    # between: that is w in the middle, but for dt²/24 · max|w''|, and w'' is greatest where
    # the walker is nearest, 2·(v/d)³.
    middle = (traces["x"].to_numpy()[1:] + traces["x"].to_numpy()[:-1]) / 2
    radius = np.hypot(middle, distance)
    closed = -speed * (distance / radius) / radius  # clockwise: he walks to the right
    bound = RATE**-2 / 12 * (speed / distance) ** 3
    assert np.abs(needed - closed).max() <= bound * (1 + 1e-6)
    # Nearest of all is some middle within half a step of x = 0, where w falls by (v·dt/2d)².
    most = np.radians(watch.summary["needed_most"])
    nearest = speed / distance
    assert nearest * (1 - (nearest / RATE) ** 2) <= most <= nearest


def test_a_camera_fast_enough_keeps_the_walker_and_a_slow_one_loses_him():
    traces = walk_past(distance=3.0, half=12)  # v/d = 26.7 degrees a second
    at_first = float(np.degrees(np.arctan2(3.0, -12)))

    def lost(limit):
        camera = PanTilt(0, 0, reach=20, pan_limit=limit, wake_time=0, pan=at_first)
        summary = simulate(traces, [camera], frame_rate=RATE).summary
        assert summary["turning_s"] == 0  # it looks at him when he comes
        return summary["lagging_s"]

    assert lost(27) == 0
    times = [lost(limit) for limit in (0.5, 3, 10, 20)]
    assert times == sorted(times, reverse=True)
    assert times[2] > 0


def test_a_camera_that_cannot_pan_sees_what_passes_its_field_of_view():
    traces = walk_past(distance=5.0, speed=1.0, half=10)
    camera = PanTilt(0, 0, field_of_view=40, reach=30, pan_limit=0, wake_time=0, pan=90)
    summary = simulate(traces, [camera], frame_rate=RATE).summary
    # Of the frames between −5·tan 20° and 5·tan 20°, at most one at each end is off.
    assert summary["watched_s"] == pytest.approx(2 * 5 * np.tan(np.radians(20)), abs=2 / RATE)
    assert summary["turning_s"] + summary["watched_s"] + summary["lagging_s"] == pytest.approx(
        len(traces) / RATE
    )


def test_pan_never_beats_its_limit_and_follows_the_shorter_way():
    # The walker is behind the camera's back: 170° to −170° is 20°, not 340°.
    x = np.full(30, -5.0)
    traces = pd.DataFrame({"trace": "a", "frame": np.arange(30), "x": x, "y": -0.88})
    camera = PanTilt(0, 0, field_of_view=5, pan_limit=25, wake_time=0, pan=170)
    table = simulate(traces, [camera], frame_rate=RATE).table
    assert table["rate"].abs().max() <= 25 + 1e-9
    # One degree a frame from 170° on, through 180°, to atan2(−0.88, −5) = −170.02°.
    assert table["pan"][:19].to_numpy() == pytest.approx([*range(171, 180), *range(-180, -170)])
    assert table["pan"][19:].to_numpy() == pytest.approx(np.degrees(np.arctan2(-0.88, -5)))
    assert table["rate"][20:].to_numpy() == pytest.approx(0, abs=1e-9)


@settings(max_examples=25)
@given(seeds)
def test_without_a_limit_no_time_is_lost(seed):
    cameras = slaves(seed, pan_limit=180 * RATE, wake_time=0)
    summary = simulate(wander(seed), cameras, frame_rate=RATE).summary
    assert summary["turning_s"] == summary["lagging_s"] == summary["lost_share"] == 0
    assert summary["waking_s"] == 0
    assert summary["watched_s"] + summary["unwatched_s"] + summary["unseen_s"] == pytest.approx(
        summary["walker_s"]
    )


@settings(max_examples=25)
@given(seeds)
def test_in_the_mirror_the_cameras_pan_the_other_way(seed):
    traces, cameras = wander(seed), slaves(seed, pan_limit=40)
    mirrored = [
        PanTilt(-camera.x, camera.y, pan=180 - camera.pan, pan_limit=40) for camera in cameras
    ]
    there = simulate(traces, cameras, frame_rate=RATE)
    here = simulate(traces.assign(x=-traces["x"]), mirrored, frame_rate=RATE)
    for name in ("pan", "wanted"):
        turned = (here.table[name] + there.table[name] - 180 + 180) % 360 - 180
        assert np.abs(turned).max() < 1e-9
    for name in ("rate", "needed"):
        assert here.table[name].to_numpy() == pytest.approx(-there.table[name].to_numpy(), abs=1e-8)
    assert here.table["trace"].tolist() == there.table["trace"].tolist()
    assert here.walkers["state"].tolist() == there.walkers["state"].tolist()


@settings(max_examples=25)
@given(seeds)
def test_twice_as_fast_is_the_same_in_half_the_time(seed):
    traces = wander(seed)
    slow = simulate(
        traces, slaves(seed, pan_limit=32, wake_time=0.5), frame_rate=RATE, look_back=0.5
    )
    fast = simulate(
        traces, slaves(seed, pan_limit=64, wake_time=0.25), frame_rate=2 * RATE, look_back=0.25
    )
    # Doubling is exact in binary: not a bit differs.
    assert fast.walkers.equals(slow.walkers)
    assert fast.table["pan"].equals(slow.table["pan"])
    assert fast.table["rate"].equals(2 * slow.table["rate"])
    for name in ("lost_share", "watched_share", "square_share", "awake_share", "hand_overs"):
        assert fast.summary[name] == slow.summary[name]
    assert fast.summary["turning_s"] == slow.summary["turning_s"] / 2


@settings(max_examples=25)
@given(seeds)
def test_as_many_walkers_are_watched_as_can_be(seed):
    traces = wander(seed, walkers=5)
    cameras = slaves(seed, number=3, reach=7.0)
    watch = simulate(traces, cameras, frame_rate=RATE)
    distance = np.stack(
        [np.hypot(traces["x"] - camera.x, traces["y"] - camera.y) for camera in cameras], axis=1
    )
    possible = (distance >= 1) & (distance <= 7)
    for rows in traces.groupby("frame").indices.values():
        matched = maximum_bipartite_matching(csr_array(possible[rows]), perm_type="column")
        called = watch.walkers["camera"].to_numpy()[rows]
        assert (called >= 0).sum() == (matched >= 0).sum()
        used = called[called >= 0]
        assert len(set(used)) == len(used)
        assert possible[rows][called >= 0, used].all()
    unseen = watch.walkers["state"].to_numpy() == "unseen"
    assert (unseen == ~possible.any(axis=1)).all()


@settings(max_examples=25)
@given(seeds)
def test_both_tables_tell_the_same_story(seed):
    watch = simulate(wander(seed), slaves(seed), frame_rate=RATE)
    awake = watch.table[watch.table["awake"]]
    called = watch.walkers[watch.walkers["camera"] >= 0]
    columns = ["frame", "camera", "trace"]
    assert sorted(map(tuple, awake[columns].to_numpy())) == sorted(
        map(tuple, called[columns].to_numpy())
    )
    asleep = watch.table[~watch.table["awake"]]
    assert not asleep[["rate", "needed"]].to_numpy().any()
    assert (asleep["trace"] == "").all()
    assert (asleep["wanted"] == asleep["pan"]).all()
    numbers = watch.table.select_dtypes("number").to_numpy()
    assert np.isfinite(numbers).all()
    assert np.isfinite(watch.summary.to_numpy()).all()
    summary = watch.summary
    states = [f"{name}_s" for name in STATES]
    assert summary[states].sum() == pytest.approx(summary["walker_s"])
    could = summary["walker_s"] - summary["unseen_s"]
    for name in ("watched", "waking", "turning", "lagging"):
        assert summary[f"{name}_share"] * could == pytest.approx(summary[f"{name}_s"])
    assert summary["lost_share"] == pytest.approx(
        summary["turning_share"] + summary["lagging_share"]
    )


def test_who_is_out_of_reach_wakes_nobody():
    watch = simulate(walk_past(distance=30), [PanTilt(0, 0), PanTilt(5, 0)], frame_rate=RATE)
    assert not watch.table["awake"].any()
    assert watch.awake_share.tolist() == [0, 0]
    assert watch.hand_overs.tolist() == [0]
    assert watch.summary["unseen_s"] == watch.summary["walker_s"]
    assert watch.summary["watched_share"] == watch.summary["needed_most"] == 0
    assert watch.summary["waking_share"] == watch.summary["lost_share"] == 0
    assert (watch.walkers["off_square"] == 90).all()


def test_turning_to_a_new_walker_is_told_from_lagging_behind_an_old_one():
    # The walker stands behind the camera, 120° from where it looks: at 60° a second and with
    # 15° of view to that side he comes into view in 1.75 s, within a frame.
    table = walk_past(half=3)
    table["x"], table["y"] = -5.0, 0.0
    camera = PanTilt(0, 0, field_of_view=30, wake_time=0, pan=60)
    summary = simulate(table, [camera], frame_rate=RATE).summary
    assert summary["turning_s"] == pytest.approx(1.75, abs=1.01 / RATE)
    assert summary["turning_share"] == pytest.approx(summary["turning_s"] * RATE / len(table))
    assert summary["lagging_share"] == summary["waking_share"] == 0


def test_waking_takes_its_time():
    traces = walk_past(half=3)
    camera = PanTilt(0, 0, field_of_view=360, wake_time=0.5)
    state = simulate(traces, [camera], frame_rate=RATE).walkers["state"]
    # 0.5 s are 12.5 frames: the 13th frame after the call is the first with a picture.
    assert (state[:13] == "waking").all()
    assert (state[13:] == "watched").all()


def test_a_camera_sleeps_between_walkers_and_wakes_anew():
    early = walk_past(half=1)
    late = early.assign(trace="b", frame=early["frame"] + 100)
    camera = PanTilt(0, 0, field_of_view=360, wake_time=0.2)
    watch = simulate(pd.concat([early, late]), [camera], frame_rate=RATE)
    assert watch.summary["waking_s"] == pytest.approx(2 * 0.2)
    assert watch.awake_share[0] == pytest.approx(2 * len(early) / (100 + len(early)))


@pytest.mark.parametrize("hysteresis", [0.0, 12.0, 40.0])
def test_a_walker_is_handed_over_where_the_other_view_is_better_by_the_hysteresis(hysteresis):
    traces = walk_past(distance=0.0, half=9)
    cameras = [PanTilt(-5, 5, reach=30), PanTilt(5, 5, reach=30)]
    watch = simulate(traces, cameras, frame_rate=RATE, hysteresis=hysteresis)
    x = traces["x"].to_numpy()
    off = [np.degrees(np.arctan(np.abs(x - camera.x) / 5)) for camera in cameras]
    # Once handed over he stays: he never comes back as far as −hysteresis.
    expected = np.maximum.accumulate(np.where(off[0] - off[1] > hysteresis, 1, 0))
    assert watch.walkers["camera"].tolist() == expected.tolist()
    assert watch.hand_overs["a"] == 1
    # The view counts as square-on within 5·tan 15° of either camera.
    chosen = np.where(expected == 1, off[1], off[0])
    assert watch.walkers["off_square"].to_numpy() == pytest.approx(chosen)


def test_one_walker_more_counts_for_more_than_a_better_angle():
    # Camera 0 reaches both walkers, camera 1 only the first, whom 0 sees square-on.
    first, second = walk_past(half=1), walk_past(distance=-5, half=1, name="b")
    cameras = [PanTilt(0, 0), PanTilt(-8, 5, reach=10)]
    watch = simulate(pd.concat([first, second]), cameras, frame_rate=RATE)
    camera = watch.walkers.groupby("trace")["camera"].unique()
    assert camera["a"].tolist() == [1]
    assert camera["b"].tolist() == [0]


def test_a_wall_hides_the_walker():
    wall = [[[-1.0, 2.0], [1.0, 2.0]]]
    watch = simulate(walk_past(half=8), [PanTilt(0, 0)], frame_rate=RATE, walls=wall)
    x = walk_past(half=8)["x"].to_numpy()
    # At 5 m the wall's shadow is 2.5 times as wide as the wall is at 2 m.
    assert ((watch.walkers["state"] == "unseen") == (np.abs(x) <= 2.5)).all()


def test_who_stands_keeps_his_course():
    x = np.r_[np.linspace(-2, 0, 40), np.zeros(60)]
    traces = pd.DataFrame({"trace": "a", "frame": np.arange(100), "x": x, "y": 5.0})
    off = simulate(traces, [PanTilt(0, 0)], frame_rate=RATE).walkers["off_square"]
    assert off[39:].to_numpy() == pytest.approx(0, abs=1e-9)


def test_who_never_moves_is_watched_but_not_square_on():
    traces = pd.DataFrame({"trace": "a", "frame": [3], "x": [0.0], "y": [5.0]})
    watch = simulate(traces, [PanTilt(0, 0, wake_time=0, pan=90)], frame_rate=RATE)
    assert watch.summary["watched_share"] == 1
    assert watch.summary["square_share"] == 0


def test_nobody_can_be_watched_from_right_above():
    traces = walk_past(distance=0.0, half=1)
    traces["x"] = 0.0
    summary = simulate(traces, [PanTilt(0, 0, near=0)], frame_rate=RATE).summary
    assert summary["unseen_s"] == summary["walker_s"]


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"x": np.nan}, "x is"),
        ({"y": np.inf}, "y is"),
        ({"field_of_view": 0}, "field_of_view"),
        ({"field_of_view": 361}, "field_of_view"),
        ({"reach": 1.0}, "reach"),
        ({"near": -1}, "near"),
        ({"pan_limit": -1}, "pan_limit"),
        ({"pan_limit": np.nan}, "pan_limit"),
        ({"wake_time": -0.1}, "wake_time"),
        ({"pan": None}, "pan"),
    ],
)
def test_an_impossible_camera_is_refused(options, word):
    with pytest.raises(ArgumentError, match=word):
        PanTilt(**{"x": 0.0, "y": 0.0, **options})


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"cameras": []}, "cameras"),
        ({"cameras": None}, "cameras"),
        ({"cameras": PanTilt(0, 0)}, "cameras"),
        ({"cameras": [(0, 0)]}, "cameras"),
        ({"frame_rate": 0}, "frame_rate"),
        ({"frame_rate": np.nan}, "frame_rate"),
        ({"square_within": 91}, "square_within"),
        ({"hysteresis": -1}, "hysteresis"),
        ({"look_back": 0}, "look_back"),
        ({"walls": [[0, 1]]}, "walls"),
    ],
)
def test_a_senseless_option_is_refused(options, word):
    options = {"cameras": [PanTilt(0, 0)], "frame_rate": RATE, **options}
    with pytest.raises(ArgumentError, match=word):
        simulate(walk_past(), options.pop("cameras"), **options)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (lambda t: t.iloc[:0], "no rows"),
        (lambda t: t.drop(columns="x"), "lacks"),
        (lambda t: t.assign(x=np.nan), "not finite"),
        (lambda t: t.assign(y=np.inf), "not finite"),
        (lambda t: t.assign(frame=1), "repeated"),
        (lambda t: t.assign(x="here"), "text"),
        (lambda t: t.assign(frame=t["frame"] * 100_000), "span"),
        (lambda t: t["x"], "DataFrame"),
    ],
)
def test_unsound_traces_are_refused(change, word):
    with pytest.raises(TableError, match=word):
        simulate(change(walk_past()), [PanTilt(0, 0)], frame_rate=RATE)


def test_the_traces_are_left_as_they_were():
    traces = wander(1)
    before = traces.copy()
    simulate(traces, slaves(1), frame_rate=RATE)
    assert traces.equals(before)


def test_slaves_stand_where_cameras_were_chosen():
    cameras = pd.DataFrame({"x": [1.0, 4.5], "y": [0.5, -2.0]})
    model = CameraModel(near=0.5, reach=4.0, pans=True)
    assert slaves_at(cameras, model=model, pan_limit=45.0) == [
        PanTilt(x, y, field_of_view=30.0, near=0.5, reach=4.0, pan_limit=45.0)
        for x, y in zip(cameras["x"], cameras["y"], strict=True)
    ]
