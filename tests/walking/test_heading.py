"""Sticks seen by a pinhole camera: their heading, speed and place must come back."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcnlab.cameras.horizon import Sighting, estimate_camera, estimate_cameras
from mcnlab.compass import DIRECTIONS, heading_of, turn_between
from mcnlab.datasets.mirror import SUFFIX, add_mirrored
from mcnlab.datasets.recording import Recording
from mcnlab.errors import ArgumentError, McnError
from mcnlab.walking import heading as perspective
from mcnlab.walking.heading import FEET_LEAD, estimate_focal_length, measure_headings

SPEED = 0.8  # body heights a second, a stroll


@dataclass(frozen=True)
class Pinhole:
    """A camera above level ground; lengths in body heights, angles in radians."""

    focal_length: float
    height: float
    tilt: float
    frame_width: int
    frame_height: int
    frame_rate: float

    def depth(self, z, up=0.0):
        """Depth of a point `up` above the ground at `z`, along the optical axis."""
        return z * np.cos(self.tilt) + (self.height - up) * np.sin(self.tilt)

    def project(self, x, z, up):
        """Column and row, pixels, of a point `up` above the ground at (x, z)."""
        down = (self.height - up) * np.cos(self.tilt) - z * np.sin(self.tilt)
        scale = self.focal_length / self.depth(z, up)
        return (self.frame_width - 1) / 2 + scale * x, (self.frame_height - 1) / 2 + scale * down

    @property
    def horizon(self):
        return (self.frame_height - 1) / 2 - self.focal_length * np.tan(self.tilt)

    def walk(self, name, heading, *, x=0.0, z=6.0, speed=SPEED, n=40, subject="stick"):
        """Boxes of an upright stick that passes (x, z) halfway."""
        time = (np.arange(n) - (n - 1) / 2) / self.frame_rate
        xs = x + speed * time * np.sin(np.radians(heading))
        zs = z + speed * time * np.cos(np.radians(heading))
        _, feet = self.project(xs, zs, 0.0)
        _, head = self.project(xs, zs, 1.0)
        cx, cy = self.project(xs, zs, 0.5)
        h = feet - head
        return pd.DataFrame(
            {
                "sequence": name,
                "subject": subject,
                "frame": np.arange(1, n + 1),
                "x": cx - 0.2 * h,
                "y": head,
                "w": 0.4 * h,
                "h": h,
                "cx": cx,
                "cy": cy,
            }
        )

    def record(self, walks, **known):
        boxes = pd.concat(walks, ignore_index=True)
        return Recording(
            "sticks", boxes, self.frame_rate, self.frame_width, self.frame_height, **known
        )


LEVEL = Pinhole(400.0, 0.8, 0.0, 352, 240, 25.0)
HIGH = Pinhole(1190.0, 4.0, np.radians(14), 768, 576, 7.0)

# Where sticks walk before the high camera: x, z and heading, all over the frame.
PLACES = [
    (x, z, heading)
    for x, z in ((-2.0, 12.0), (2.0, 14.0), (0.0, 18.0))
    for heading in (*heading_of(DIRECTIONS), 17.0, 203.0)
]


@pytest.fixture
def sticks(monkeypatch):
    """A stick has no feet: without their correction the geometry is exact."""
    monkeypatch.setattr(perspective, "FEET_LEAD", 0.0)


@pytest.fixture(scope="module")
def crowd():
    walks = [
        HIGH.walk(f"walk-{at}", heading, x=x, z=z, n=14)
        for at, (x, z, heading) in enumerate(PLACES)
    ]
    return HIGH.record(walks)


def greatest_turn(error, x, z):
    """How far a relative error of the scale, proportional to nearness, can turn a heading.

    If s is read as s·(1 + ε) with ε proportional to 1/z, then 1/s = z·(1 − ε) and (x − c)/s =
    x·(1 − ε): adding a constant to z, so vz stays while vx shrinks by ε and gains x·vz·ε/z.
    With a common factor ε, which turns nothing, the worst ratio of the two is 1 + ε, a turn
    of ε/2 at most, and ε·|x|/z for the last term; the rest is of second order, under ε².
    """
    return np.degrees(error / 2 + error * np.abs(x) / z + error**2)


@pytest.mark.parametrize("direction", DIRECTIONS)
@pytest.mark.parametrize("z", [2.5, 6.0])
def test_each_direction_is_recovered_exactly_before_a_level_camera(sticks, direction, z):
    heading = heading_of(direction)
    walk = LEVEL.walk("walk", heading, z=z)
    (found,) = measure_headings(LEVEL.record([walk]), focal_length=400.0).itertuples()
    # Box height is f/z and the feet's drop 0.8·f/z: every reading is exact.
    assert turn_between(found.heading, heading) == pytest.approx(0, abs=1e-6)
    assert found.direction == direction
    assert found.speed == pytest.approx(SPEED, rel=1e-6)
    assert (found.x, found.z) == (pytest.approx(0, abs=1e-6), pytest.approx(z, rel=1e-6))


@given(st.floats(0, 360), st.floats(-1.0, 1.0), st.floats(4, 9), st.floats(0.3, 1.5))
def test_any_heading_is_recovered_before_a_level_camera(heading, x, z, speed):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(perspective, "FEET_LEAD", 0.0)
        recording = LEVEL.record([LEVEL.walk("walk", heading, x=x, z=z, speed=speed)])
        (found,) = measure_headings(recording, focal_length=400.0).itertuples()
    assert turn_between(found.heading, heading) == pytest.approx(0, abs=1e-6)
    assert found.speed == pytest.approx(speed, rel=1e-6)
    assert (found.x, found.z) == (pytest.approx(x, abs=1e-6), pytest.approx(z, rel=1e-6))
    sight = heading - np.degrees(np.arctan2(x, z))
    assert turn_between(found.sight, sight) == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("heading", [0.0, 30.0, 90.0, 160.0, 180.0, 250.0])
def test_the_correction_for_feet_turns_a_stick_by_little(heading):
    x, z = 1.0, 6.0
    walk = LEVEL.walk("walk", heading, x=x, z=z)
    (found,) = measure_headings(LEVEL.record([walk]), focal_length=400.0).itertuples()
    # (x − c)/s gains FEET_LEAD·|cos|·x/z, whose rate is at most speed·√(1 + (x/z)²)/z.
    nearest = z - SPEED * 40 / 25 / 2
    bias = FEET_LEAD * np.hypot(1, (x + SPEED * 0.8) / nearest) / nearest
    assert abs(turn_between(found.heading, heading)) <= np.degrees(np.arcsin(bias))


def test_a_high_camera_that_is_known_gives_headings_within_the_sticks_own_depth(sticks, crowd):
    known = Sighting(1190.0, 768, 576, HIGH.horizon, 4.0, 3.5)
    found = measure_headings(
        crowd, focal_length=1190.0, cameras=dict.fromkeys(crowd.sequences, known)
    )
    x, z, heading = np.array(PLACES).T
    # The feet's drop is exact.  Middle and head are nearer to a camera that looks down by
    # sin τ/2 and sin τ: the centroid's drop is long by that over the depth, the box height
    # short by up to (C − 1) times that.  They enter the scale with 3.5² and 1 parts in
    # 1 + 4² + 3.5².  The centroid's column, too, is off by sin τ/2 over the depth.
    nearer = np.sin(HIGH.tilt) / HIGH.depth(z - SPEED)
    error = (3.5**2 / 2 + (HIGH.height - 1)) / (1 + 4**2 + 3.5**2) * nearer + nearer / 2
    turn = np.abs(turn_between(found["heading"], heading))
    assert (turn <= greatest_turn(error, x, z)).all()
    assert found["speed"].to_numpy() == pytest.approx(SPEED, rel=2 * error.max())


def horizon_bracket(boxes):
    """Between which drops the line through box heights may put the horizon.

    With u the feet's drop, q = sin τ·cos τ/f and C the camera's height, the box height is
    h = (u/C)·(1 − q·u)/(1 − q·u/C): bent downwards, so a line through the boxes crosses zero
    between the crossings of the tangents at the farthest and at the nearest box.
    """
    u = (boxes["y"] + boxes["h"]).to_numpy() - HIGH.horizon
    q = np.sin(HIGH.tilt) * np.cos(HIGH.tilt) / HIGH.focal_length
    u = np.array([u.min(), u.max()])
    h = u / HIGH.height * (1 - q * u) / (1 - q * u / HIGH.height)
    slope = (1 - 2 * q * u + q**2 * u**2 / HIGH.height) / (1 - q * u / HIGH.height) ** 2
    return u - h / (slope / HIGH.height)


def test_walkers_show_the_horizon_and_the_tilt_of_a_high_camera(crowd):
    cameras = estimate_cameras(crowd, focal_length=1190.0, shared="recording")
    assert set(cameras) == set(crowd.sequences)
    assert len(set(cameras.values())) == 1
    camera = cameras["walk-0"]
    farthest, nearest = horizon_bracket(crowd.boxes)
    assert nearest < farthest < 0
    assert HIGH.horizon + nearest <= camera.horizon <= HIGH.horizon + farthest
    tilt = np.arctan(np.tan(HIGH.tilt) - np.array([farthest, nearest]) / HIGH.focal_length)
    assert tilt[0] <= camera.tilt <= tilt[1]
    # The line's slope is 1/C, less the bend.
    assert HIGH.height <= camera.feet <= 1.2 * HIGH.height


def test_headings_before_a_high_camera_need_the_focal_length_only(sticks, crowd):
    found = measure_headings(crowd, focal_length=1190.0, shared="recording")
    x, z, heading = np.array(PLACES).T
    # The horizon's error moves every drop by as much, so the scale by that share of it; and
    # the stick's own depth counts as with a known camera.
    _, nearest = horizon_bracket(crowd.boxes)
    farthest_drop = (crowd.boxes["y"] + crowd.boxes["h"]).min() - HIGH.horizon
    error = -nearest / farthest_drop + np.sin(HIGH.tilt) / HIGH.depth(z - SPEED).min()
    assert error < 0.15
    turn = np.abs(turn_between(found["heading"], heading))
    assert (turn <= greatest_turn(error, x, z)).all()
    sight = heading - np.degrees(np.arctan2(x, z))
    assert (np.abs(turn_between(found["sight"], sight)) <= greatest_turn(error, x, z) + 1).all()
    # The scale's factor C/feet and its drift each change the speed by that share at most.
    assert found["speed"].to_numpy() == pytest.approx(SPEED, rel=2 * error)
    assert (found["direction"].to_numpy() == 1 + np.round(heading / 45) % 8).all()


def test_a_level_camera_shows_its_height(sticks):
    walks = [LEVEL.walk("away", 0.0, z=3.0), LEVEL.walk("across", 90.0, z=5.0)]
    camera = estimate_camera(
        pd.concat(walks, ignore_index=True), focal_length=400.0, frame_width=352, frame_height=240
    )
    assert camera.horizon == pytest.approx(LEVEL.horizon, abs=1e-6)
    assert camera.feet == pytest.approx(0.8)
    assert camera.centroid == pytest.approx(0.3)
    assert camera.tilt == pytest.approx(0, abs=1e-6)


def test_boxes_of_one_size_or_upside_down_show_no_horizon(make_boxes):
    optics = {"focal_length": 400.0, "frame_width": 352, "frame_height": 240}
    same = estimate_camera(make_boxes(h=100.0, y=20.0 + np.arange(10)), **optics)
    assert (same.horizon, same.feet, same.tilt) == (None, 0, 0)
    shrinking = make_boxes(h=100.0 - 5 * np.arange(10), y=50.0 + 8 * np.arange(10))
    assert estimate_camera(shrinking, **optics).horizon is None


def test_the_focal_length_is_found_from_an_equal_pace(sticks):
    walks = [LEVEL.walk(f"walk-{d}", heading_of(d)) for d in DIRECTIONS]
    # 400 trials between 100 and 2000 pixels are 0.75 % apart: the nearest is within 0.38 %.
    assert estimate_focal_length(LEVEL.record(walks)) == pytest.approx(400, rel=0.0038)


def test_mirrored_copies_do_not_change_the_focal_length(sticks):
    walks = [LEVEL.walk(f"walk-{d}", heading_of(d), x=0.5) for d in DIRECTIONS]
    labels = pd.Series({f"walk-{d}": d for d in DIRECTIONS})
    recording = LEVEL.record(walks, directions=labels)
    assert estimate_focal_length(add_mirrored(recording)) == estimate_focal_length(recording)


def test_a_mirrored_walk_heads_the_other_way(crowd):
    labels = pd.Series({name: 2 for name in crowd.sequences})
    both = add_mirrored(crowd.with_boxes(crowd.boxes, directions=labels))
    found = measure_headings(both, focal_length=1190.0, shared="recording").set_index("sequence")
    here, there = found.loc[crowd.sequences], found.loc[[f"{n}{SUFFIX}" for n in crowd.sequences]]
    for name in ("heading", "sight"):
        turn = turn_between(there[name].to_numpy(), -here[name].to_numpy())
        assert turn == pytest.approx(0, abs=1e-6)
    assert there["x"].to_numpy() == pytest.approx(-here["x"].to_numpy(), abs=1e-9)
    for name in ("speed", "z", "margin"):
        assert there[name].to_numpy() == pytest.approx(here[name].to_numpy(), rel=1e-6)
    alone = measure_headings(crowd, focal_length=1190.0, shared="recording")
    assert alone["heading"].to_numpy() == pytest.approx(here["heading"].to_numpy(), abs=1e-3)


def noisy(crowd, seed):
    """The crowd with boxes a pixel off here and there, as detectors give them."""
    jitter = np.random.default_rng(seed).normal(scale=0.7, size=(len(crowd.boxes), 4))
    boxes = crowd.boxes.copy()
    boxes[["y", "h", "cx", "cy"]] += jitter
    return boxes


def assert_same_headings(here, there, turned=0.0):
    # A fit stops when a round moves it by less than a millionth of the residuals.
    turn = turn_between(there["heading"].to_numpy() - turned, here["heading"].to_numpy())
    assert turn == pytest.approx(0, abs=1e-3)
    for name in ("speed", "margin", "z"):
        assert there[name].to_numpy() == pytest.approx(here[name].to_numpy(), rel=1e-4)


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.5, 2.0, 3.0]))
@settings(max_examples=10)
def test_a_larger_image_of_the_same_scene_shows_the_same_walk(crowd, seed, k):
    boxes = noisy(crowd, seed)
    larger = boxes.copy()
    # Pixels count from the centre of the first: position p becomes k·(p + ½) − ½.
    for name in ("x", "y", "cx", "cy"):
        larger[name] = k * (boxes[name] + 0.5) - 0.5
    for name in ("w", "h"):
        larger[name] = k * boxes[name]
    here = measure_headings(crowd.with_boxes(boxes), focal_length=1190.0, shared="recording")
    scene = crowd.with_boxes(larger, frame_width=int(768 * k), frame_height=int(576 * k))
    there = measure_headings(scene, focal_length=1190.0 * k, shared="recording")
    assert_same_headings(here, there)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=10)
def test_a_film_run_backwards_turns_every_walk_round(crowd, seed):
    boxes = noisy(crowd, seed)
    last = boxes.groupby("sequence")["frame"].transform("max")
    backwards = boxes.assign(frame=1 + last - boxes["frame"]).sort_values(
        ["sequence", "frame"], ignore_index=True
    )
    forwards = boxes.sort_values(["sequence", "frame"], ignore_index=True)
    here, there = (
        measure_headings(crowd.with_boxes(rows), focal_length=1190.0, shared="recording")
        for rows in (forwards, backwards)
    )
    assert_same_headings(here, there, turned=180.0)


@given(st.integers(0, 2**32 - 1), st.integers(-(10**6), 10**6))
@settings(max_examples=10)
def test_counting_frames_from_elsewhere_changes_nothing(crowd, seed, first):
    boxes = noisy(crowd, seed)
    later = boxes.assign(frame=boxes["frame"] + first)
    here, there = (
        measure_headings(crowd.with_boxes(rows), focal_length=1190.0, window=7, shared="recording")
        for rows in (boxes, later)
    )
    assert there["frame"].tolist() == (here["frame"] + first).tolist()
    assert there.drop(columns="frame").equals(here.drop(columns="frame"))


def test_a_walk_is_measured_alike_alone_and_in_company(crowd):
    boxes = noisy(crowd, 3)
    known = Sighting(1190.0, 768, 576, HIGH.horizon, 4.0, 3.5)
    cameras = dict.fromkeys(crowd.sequences, known)
    # A walk of enormous boxes must not change what counts as an outlier elsewhere.
    giant = boxes[boxes["sequence"] == "walk-0"].assign(sequence="giant")
    giant[["h", "w"]] *= 1000
    crowded = pd.concat([boxes, giant], ignore_index=True)
    together = measure_headings(
        crowd.with_boxes(crowded), focal_length=1190.0, cameras={**cameras, "giant": known}
    )
    together = together[together["sequence"] != "giant"]
    alone = pd.concat(
        [
            measure_headings(crowd.with_boxes(rows), focal_length=1190.0, cameras=cameras)
            for _, rows in boxes.groupby("sequence", sort=False)
        ]
    )
    assert_same_headings(alone, together)


def test_windows_follow_each_other_from_the_first_frame(sticks):
    walk = LEVEL.walk("walk", 90.0, n=30)
    walk["frame"] += 100
    found = measure_headings(LEVEL.record([walk]), focal_length=400.0, window=12)
    assert found["frame"].tolist() == [101, 113]  # the last six frames are dropped
    assert found["frames"].tolist() == [12, 12]
    assert found["heading"].to_numpy() == pytest.approx(90, abs=1e-6)
    # Windows begin 12 frames apart, in which the walk goes on 0.48 s.
    assert np.diff(found["x"]) == pytest.approx(SPEED * 12 / 25)


def test_a_window_without_enough_boxes_has_no_heading(sticks):
    walk = LEVEL.walk("walk", 90.0, n=30).drop(index=range(12, 18))
    found = measure_headings(
        LEVEL.record([walk.reset_index(drop=True)]), focal_length=400.0, window=10
    )
    assert found["frame"].tolist() == [1, 21]  # 11 … 20 has 4 of 10 boxes


def test_missing_frames_do_not_turn_the_heading(sticks):
    walk = LEVEL.walk("walk", 60.0).drop(index=[3, 4, 17, 30, 31, 32])
    (found,) = measure_headings(
        LEVEL.record([walk.reset_index(drop=True)]), focal_length=400.0
    ).itertuples()
    assert found.heading == pytest.approx(60, abs=1e-6)
    assert found.frames == 34


def test_the_margin_covers_the_error_of_noisy_walks():
    rng = np.random.default_rng(5)
    walks = []
    for at in range(200):
        walk = LEVEL.walk(f"walk-{at}", heading_of(1 + at % 8), z=6.0)
        # Outlines good to 0.6 % of the height, as `OUTLINE_NOISE` says.
        walk[["h", "cx"]] += rng.normal(scale=0.006 * walk["h"].mean(), size=(len(walk), 2))
        walks.append(walk)
    found = measure_headings(LEVEL.record(walks), focal_length=400.0, shared="subject")
    truth = heading_of(1 + np.arange(200) % 8)
    covered = np.abs(turn_between(found["heading"], truth)) <= found["margin"]
    # A 95 % interval that reckons with gait as well; 200 trials miss 0.92 with p < 0.03.
    assert covered.mean() >= 0.92
    assert found["margin"].max() < 10


@pytest.mark.parametrize("focal_length", [0, -400.0, np.nan, np.inf, True, "long", None])
def test_a_senseless_focal_length_is_refused(crowd, make_boxes, focal_length):
    size = {"frame_width": 352, "frame_height": 240}
    for measure in (
        lambda: measure_headings(crowd, focal_length=focal_length),
        lambda: estimate_cameras(crowd, focal_length=focal_length),
        lambda: estimate_camera(make_boxes(), focal_length=focal_length, **size),
        lambda: Sighting(focal_length, 352, 240),
    ):
        with pytest.raises(ArgumentError, match="focal_length"):
            measure()


@pytest.mark.parametrize("window", [0, 3, -7, 7.5, True])
def test_a_senseless_window_is_refused(crowd, window):
    with pytest.raises(ArgumentError, match="window"):
        measure_headings(crowd, focal_length=1190.0, window=window)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_walks_too_short_for_a_heading_are_refused(n):
    with pytest.raises(ArgumentError, match="no walk has 4 boxes"):
        measure_headings(LEVEL.record([LEVEL.walk("walk", 90.0, n=n)]), focal_length=400.0)


def test_a_window_longer_than_every_walk_is_refused(crowd):
    with pytest.raises(ArgumentError, match="window is 100"):
        measure_headings(crowd, focal_length=1190.0, window=100)


def test_cameras_are_shared_by_recording_or_subject_only(crowd):
    with pytest.raises(ArgumentError, match="shared is 'walk'"):
        measure_headings(crowd, focal_length=1190.0, shared="walk")


def test_a_walk_without_its_camera_is_named(crowd):
    with pytest.raises(McnError, match="walk-0"):
        measure_headings(crowd, focal_length=1190.0, cameras={})


def test_without_enough_walks_there_is_no_focal_length(sticks):
    one = LEVEL.record([LEVEL.walk("walk", 45.0)])
    with pytest.raises(ArgumentError, match="one walk a subject"):
        estimate_focal_length(one)
    across = LEVEL.record([LEVEL.walk(f"walk-{k}", 90.0, z=5.0 + k) for k in range(3)])
    with pytest.raises(ArgumentError, match="focal length"):
        estimate_focal_length(across)


@pytest.mark.parametrize(("low", "high"), [(0, 2000), (-5, 2000), (100, np.nan), (True, 2000)])
def test_a_senseless_range_of_focal_lengths_is_refused(sticks, low, high):
    walks = [LEVEL.walk(f"walk-{d}", heading_of(d)) for d in DIRECTIONS]
    with pytest.raises(ArgumentError, match=r"low|high|between"):
        estimate_focal_length(LEVEL.record(walks), low=low, high=high)


@given(data=st.data(), window=st.sampled_from([None, 4, 7]))
@settings(max_examples=300)
def test_headings_of_any_table_are_finite_or_a_clear_error(box_tables, data, window):
    boxes = data.draw(box_tables)
    try:
        recording = Recording("made-up", boxes, 25.0, 352, 240)
        found = measure_headings(recording, focal_length=400.0, window=window)
    except McnError:
        return
    numbers = found[["heading", "sight", "margin", "speed", "x", "z"]]
    assert np.isfinite(numbers.to_numpy(float)).all()
    assert found["heading"].between(0, 360).all()
    assert found["margin"].between(0, 180).all()
    assert (found["speed"] >= 0).all()
    assert found["direction"].isin((0, *DIRECTIONS)).all()
    assert (found["frames"] >= 4).all()
