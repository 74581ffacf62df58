"""Synthetic walkers: geometry against hand calculation, gait against recorded boxes."""

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from mcnlab import tables
from mcnlab.cameras.camera import Camera
from mcnlab.compass import heading_of
from mcnlab.errors import ArgumentError
from mcnlab.synthetic.body import JOINTS, LIMBS, Body, draw_body
from mcnlab.synthetic.walkers import (
    CUT,
    HEADING,
    PHASE,
    SPEED,
    STATURE_PX,
    X_M,
    Y_M,
    Walk,
    make_walk,
    make_walks,
    render_walk,
    walk_joints,
)

CASIA = Path(__file__).resolve().parents[2] / "data" / "casia-a"
PETS_LIKE = Camera.from_tilt(
    focal_length=1190.0, height=7.0, tilt=17.0, frame_width=768, frame_height=576
)


@pytest.fixture(scope="module")
def walks():
    return make_walks(subjects=8, seed=7)


@pytest.fixture(scope="module")
def lateral():
    return make_walk(Body(), heading=90.0, distance=6.0)


# --- the gait -----------------------------------------------------------------------------


@pytest.mark.parametrize("stride", [0.85, 1.0, 1.15])
def test_the_lowest_sole_is_on_the_ground(stride):
    body = Body(stride=stride)
    joints, radii = walk_joints(body, Walk(30.0, n_frames=200))
    soles = [name.split()[-1] in ("heel", "ball") for name in JOINTS]
    lowest = (joints[:, soles, 2] - radii[soles]).min(axis=1)
    # Exact at the samples of the cycle; between two of them a straight line cuts the corner
    # where one sole takes over from another.
    np.testing.assert_allclose(lowest, 0.0, atol=1e-3)


@pytest.mark.parametrize(("heading", "sideways"), [(0.0, [1, 0, 0]), (90.0, [0, -1, 0])])
def test_the_right_side_is_to_the_right(heading, sideways):
    joints, _ = walk_joints(Body(), Walk(heading, n_frames=30))
    across = joints[:, JOINTS.index("right hip")] - joints[:, JOINTS.index("left hip")]
    np.testing.assert_allclose(across / np.linalg.norm(across[0]), [sideways] * 30, atol=1e-9)


@pytest.mark.parametrize("heading", [0.0, 90.0, 217.0])
def test_the_stance_foot_does_not_slip(heading):
    body = Body(phase=0.13)
    walk = Walk(heading, n_frames=200, frame_rate=100.0)
    joints, radii = walk_joints(body, walk)
    phase = (body.phase + body.cadence / 2 * np.arange(walk.n_frames) / walk.frame_rate) % 1.0
    slips = []
    for side, stance in (("right", phase < 0.5), ("left", phase >= 0.5)):
        foot = [JOINTS.index(f"{side} {name}") for name in ("heel", "ball")]
        carrier = (joints[:, foot, 2] - radii[foot]).argmin(axis=1)
        place = joints[np.arange(len(joints)), np.take(foot, carrier)][:, :2]
        same = stance[1:] & stance[:-1] & (carrier[1:] == carrier[:-1])
        slips.append(np.linalg.norm(np.diff(place, axis=0)[same], axis=1))
        assert same.sum() > 50
    step = body.speed / walk.frame_rate
    assert np.concatenate(slips).max() < 0.01 * step


def test_a_stride_later_the_feet_are_a_stride_farther():
    body = Body(cadence=2.0)  # one stride is 1 s, 25 frames
    joints, _ = walk_joints(body, Walk(90.0, n_frames=26))
    moved = joints[25] - joints[0]
    np.testing.assert_allclose(moved[:, 0], 2 * body.step_length, atol=1e-9)
    np.testing.assert_allclose(moved[:, 1:], 0.0, atol=1e-9)


def test_drawn_bodies_are_normal_adults():
    bodies = [draw_body(np.random.default_rng(seed)) for seed in range(300)]
    stature = np.array([body.stature for body in bodies])
    cadence = np.array([body.cadence for body in bodies])
    pace = np.array([body.speed / body.stature for body in bodies])
    assert stature.min() >= 1.55
    assert stature.max() <= 1.90
    assert cadence.min() >= 1.75
    assert cadence.max() <= 2.1
    assert 0.78 < pace.mean() < 0.88
    assert np.mean((pace > 0.7) & (pace < 0.98)) > 0.95


def test_an_upright_body_is_as_tall_as_its_stature():
    body = Body(stature=1.8)
    joints, radii = walk_joints(body, Walk(90.0, n_frames=100))
    top = (joints[..., 2] + radii).max()
    assert 1.75 < top < 1.81


# --- truth --------------------------------------------------------------------------------


@pytest.mark.parametrize("heading", [0.0, 33.0, 90.0, 135.0, 180.0, 262.5, 315.0, -45.0])
def test_positions_follow_the_heading(heading):
    walk = make_walk(Body(), heading=heading, distance=7.0, n_frames=60)
    truth = walk.truth
    moved = truth[[X_M, Y_M]].iloc[-1] - truth[[X_M, Y_M]].iloc[0]
    turn = math.degrees(math.atan2(moved[X_M], moved[Y_M])) - heading
    assert (turn + 180) % 360 - 180 == pytest.approx(0.0, abs=1e-6)
    assert (truth[HEADING] == heading).all()
    # In its middle frame it passes the place asked for.
    assert truth[X_M].iloc[30] == pytest.approx(0.0, abs=1e-9)
    assert truth[Y_M].iloc[30] == pytest.approx(7.0)


def test_speed_is_distance_over_time():
    body = Body(cadence=2.0)
    walk = make_walk(body, heading=90.0, n_frames=51)  # two strides
    truth = walk.truth
    np.testing.assert_allclose(truth[SPEED], body.speed)
    assert truth[X_M].iloc[-1] - truth[X_M].iloc[0] == pytest.approx(2 * body.speed)


def test_a_wobbling_pace_keeps_the_mean_speed():
    body = Body()
    joints, _ = walk_joints(body, Walk(0.0, n_frames=751, pace_wobble=0.1))  # ten wobbles
    assert joints[-1, 0, 1] - joints[0, 0, 1] == pytest.approx(30 * body.speed, rel=0.01)
    truth = make_walk(body, heading=0.0, distance=9.0, n_frames=75, pace_wobble=0.1).truth
    assert np.ptp(truth[SPEED]) == pytest.approx(0.2 * body.speed, rel=0.01)


def test_the_speed_in_the_table_is_that_of_the_wobbling_pace():
    body = Body(cadence=2.0)  # one stride is about 1 s, 25 frames
    truth = make_walk(body, heading=90.0, n_frames=76, pace_wobble=0.2).truth
    way = truth[X_M].to_numpy()
    speed = truth[SPEED].to_numpy()
    for first in (0, 25, 50):
        moved = way[first + 25] - way[first]
        # Within a stride the pelvis is at most 0.02 statures ahead of or behind an even pace.
        assert moved == pytest.approx(speed[first : first + 26].mean(), abs=0.04 * body.stature)
    assert np.ptp(speed) > 0.3 * body.speed


def test_the_box_is_that_of_the_projected_body(lateral):
    joints, radii = walk_joints(lateral.body, lateral.walk)
    pixels = lateral.view.project(joints)
    reach = (lateral.view.focal_length * radii / lateral.view.depth(joints))[..., None]
    low = (pixels - reach).min(axis=1)
    high = (pixels + reach).max(axis=1)
    box = lateral.truth[["x", "y", "w", "h"]].to_numpy()
    # A pixel covers half a pixel either side of its centre.
    np.testing.assert_allclose(box[:, :2] - 0.5, low, atol=1.0)
    np.testing.assert_allclose(box[:, :2] + box[:, 2:] - 0.5, high, atol=1.0)
    assert abs((box[:, 2:] - (high - low)).mean()) < 0.2


def test_the_table_describes_the_masks(lateral):
    tables.check_boxes(lateral.truth)
    for mask, row in zip(lateral.masks, lateral.truth.itertuples(), strict=True):
        ys, xs = np.nonzero(mask)
        assert (row.x, row.y) == (xs.min(), ys.min())
        assert (row.w, row.h) == (np.ptp(xs) + 1, np.ptp(ys) + 1)
        assert row.area == len(xs)
        assert row.cx == pytest.approx(xs.mean())
        assert row.cy == pytest.approx(ys.mean())
    assert lateral.masks.dtype == np.uint8
    assert set(np.unique(lateral.masks)) == {0, 255}
    assert lateral.truth[PHASE].between(0, 1).all()


def test_a_walk_can_be_rendered_again():
    walk = make_walk(Body(phase=0.3), heading=45.0, distance=7.0, pace_wobble=0.1)
    masks, truth = render_walk(walk.body, walk.walk, walk.view)
    np.testing.assert_array_equal(masks, walk.masks)
    pd.testing.assert_frame_equal(truth, walk.truth)


def test_box_height_falls_with_depth():
    view = Camera.from_tilt(focal_length=450, tilt=0, height=1, frame_width=801, frame_height=601)
    near = make_walk(Body(), heading=90.0, distance=4.0, n_frames=40, view=view).truth
    far = make_walk(Body(), heading=90.0, distance=8.0, n_frames=40, view=view).truth
    # Both boxes are whole pixels.
    np.testing.assert_allclose(near["h"], 2 * far["h"], atol=3)
    np.testing.assert_allclose(near[STATURE_PX], 450 * 1.7 / 4.0)
    np.testing.assert_allclose(far[STATURE_PX], 450 * 1.7 / 8.0)


@pytest.mark.parametrize("heading", [20.0, 90.0, 135.0])
def test_the_mirror_image_is_the_mirrored_walk(heading):
    body = Body(arm_bias=0.4, phase=0.2)
    here = Walk(heading, x=-0.5, y=6.0, n_frames=30)
    there = Walk(-heading, x=0.5, y=6.0, n_frames=30)
    masks, truth = render_walk(body, here)
    mirrored, other = render_walk(body.mirrored(), there)
    np.testing.assert_allclose(other["x"], 352 - truth["x"] - truth["w"], atol=1)
    for name in ("y", "w", "h"):
        np.testing.assert_allclose(other[name], truth[name], atol=1)
    # Only the outline may round differently.
    assert (mirrored != masks[:, :, ::-1]).sum() < 0.05 * (masks > 0).sum()


def test_dropped_limbs_are_not_drawn(lateral):
    arms = ("left arm", "right arm")
    without, _ = render_walk(lateral.body, lateral.walk, drop_limbs=arms)
    assert (without <= lateral.masks).all()
    assert (without < lateral.masks).any()
    headless, table = render_walk(lateral.body, lateral.walk, drop_limbs="head")
    assert (table["y"] > lateral.truth["y"] + 5).all()
    assert headless.shape == lateral.masks.shape
    assert "head" in LIMBS


def test_the_frames_edge_is_noticed():
    walk = make_walk(Body(), heading=90.0, n_frames=127)
    cut = walk.truth[CUT].to_numpy()
    gone = walk.truth["area"].to_numpy() == 0
    inside = make_walk(Body(), heading=90.0).truth
    assert cut[0]
    assert cut[-1]
    assert not cut[63]
    assert (cut | ~gone).all()
    assert (walk.truth.loc[gone, ["x", "y", "w", "h"]] == 0).all(axis=None)
    assert not inside[CUT].any()


# --- data sets ----------------------------------------------------------------------------


def test_eight_directions_inside_the_frame(walks):
    assert len(walks) == 64
    assert sorted({walk.direction for walk in walks}) == list(range(1, 9))
    for walk in walks:
        assert walk.heading == heading_of(walk.direction)
        assert not walk.truth[CUT].any()
        assert 37 <= len(walk.masks) <= 127
        right, bottom = walk.truth["x"] + walk.truth["w"], walk.truth["y"] + walk.truth["h"]
        assert (walk.truth[["x", "y"]] > 0).all(axis=None)
        assert (right < 352).all()
        assert (bottom < 240).all()
    assert len({walk.name for walk in walks}) == 64
    assert 70 < np.mean([len(walk.masks) for walk in walks]) < 95


def test_the_same_seed_gives_the_same_walks():
    once = make_walks(subjects=2, directions=(2, 3), seed=5)
    again = make_walks(subjects=2, directions=(2, 3), seed=5)
    other = make_walks(subjects=2, directions=(2, 3), seed=6)
    for first, second in zip(once, again, strict=True):
        np.testing.assert_array_equal(first.masks, second.masks)
        pd.testing.assert_frame_equal(first.truth, second.truth)
    assert all(first.body != second.body for first, second in zip(once, other, strict=True))


def test_a_walk_does_not_depend_on_what_else_is_asked_for():
    few = make_walks(subjects=1, directions=(3,), seed=5)
    more = make_walks(subjects=2, directions=(2, 3), seed=5, repeats=2)
    same = next(walk for walk in more if walk.name == few[0].name)
    np.testing.assert_array_equal(few[0].masks, same.masks)


@pytest.mark.parametrize("heading", [0.0, 67.0, 90.0, 200.0, 315.0])
def test_a_high_tilted_camera(heading):
    walk = make_walk(Body(), heading=heading, view=PETS_LIKE, distance=22.0)
    assert walk.masks.shape[1:] == (576, 768)
    assert not walk.truth[CUT].any()
    # The ray through the foot of the box meets the ground where the walker is.
    below = (walk.truth["y"] + walk.truth["h"] - 0.5 - (576 - 1) / 2) / 1190.0
    angle = np.arctan(below) + math.radians(17.0)
    np.testing.assert_allclose(7.0 / np.tan(angle), walk.truth[Y_M], atol=1.0)


# --- against recorded boxes -----------------------------------------------------------------

GROUPS = {"lateral": (3, 7), "oblique": (2, 4, 6, 8), "radial": (1, 5)}


def gait_of(boxes):
    """Mean and swing of width over height, step frequency, growth, fill, bob of one walk."""
    inside = (boxes["x"] > 0) & (boxes["x"] + boxes["w"] < 352)
    inside &= (boxes["y"] > 0) & (boxes["y"] + boxes["h"] < 240)
    boxes = boxes[inside]
    if len(boxes) < 20:
        return None
    frame = boxes["frame"].to_numpy(float)
    every = np.arange(frame[0], frame[-1] + 1)
    ratio = np.interp(every, frame, boxes["w"] / boxes["h"])
    log_height = np.interp(every, frame, np.log(boxes["h"]))
    swing = ratio - np.polyval(np.polyfit(every, ratio, 2), every)
    bob = log_height - np.polyval(np.polyfit(every, log_height, 3), every)
    power = np.abs(np.fft.rfft(swing * np.hanning(len(swing)), 4096))
    hertz = np.fft.rfftfreq(4096, 1 / 25)
    band = (hertz > 1.2) & (hertz < 3.0)
    return {
        "ratio": ratio.mean(),
        "swing": swing.std() * math.sqrt(2),
        "steps": hertz[band][power[band].argmax()],
        "growth": abs(np.polyfit(every, log_height, 1)[0]) * 25,
        "fill": (boxes["area"] / (boxes["w"] * boxes["h"])).mean(),
        "bob": bob.std() * math.sqrt(2),
        "height": boxes["h"].mean(),
        "frames": len(every),
    }


def gaits(sequences):
    """One row a walk: its group and `gait_of`; `sequences` yields (direction, boxes)."""
    group = {direction: name for name, members in GROUPS.items() for direction in members}
    found = [(group[direction], gait_of(boxes)) for direction, boxes in sequences]
    return pd.DataFrame([{"group": name, **gait} for name, gait in found if gait is not None])


@pytest.fixture(scope="module")
def recorded():
    if not (CASIA / "boxes.csv.gz").is_file():
        pytest.skip("the bundled table of CASIA A boxes is not there")
    boxes = pd.read_csv(CASIA / "boxes.csv.gz")
    directions = pd.read_csv(CASIA / "directions.csv").set_index("sequence")["direction"]
    return gaits((directions[name], rows) for name, rows in boxes.groupby("sequence"))


@pytest.mark.parametrize("group", GROUPS)
@pytest.mark.parametrize(
    "measure", ["ratio", "swing", "steps", "growth", "fill", "bob", "height", "frames"]
)
def test_synthetic_walks_are_like_recorded_ones(walks, recorded, group, measure):
    synthetic = gaits((walk.direction, walk.truth) for walk in walks)
    mean = synthetic.loc[synthetic["group"] == group, measure].mean()
    low, high = recorded.loc[recorded["group"] == group, measure].quantile([0.025, 0.975])
    if group == "radial" and measure in ("swing", "bob"):
        # Seen from the front a body hardly changes its outline: there the recorded
        # boxes' width swings with the noise of segmentation, which these do not have.
        low = 0.0
    assert low <= mean <= high


# --- bad arguments --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Walk(math.inf), "heading is inf"),
        (lambda: Walk(0.0, n_frames=1), "n_frames is 1"),
        (lambda: Walk(0.0, frame_rate=0.0), "frame_rate is 0"),
        (lambda: Body(stature=0.0), "stature is 0"),
        (lambda: Body(cadence=-1.0), "cadence is -1"),
        (lambda: Body(phase=math.nan), "phase is nan"),
        (lambda: make_walks(subjects=1, seed=1, directions=[9]), "direction is 9"),
        (lambda: make_walks(subjects=0, seed=1), "subjects is 0"),
        (lambda: make_walks(subjects=1, seed=None), "seed is None"),
        (lambda: make_walks(subjects=1, seed=1, directions=(0,)), "direction is 0"),
        (lambda: make_walks(subjects=1, seed=1, distances={}), "distances lacks direction"),
        (lambda: make_walk(Body(), heading=90.0, distance=2.0), "does not show the whole body"),
        (lambda: make_walk(Body(), heading=math.nan), "heading is nan"),
        (lambda: make_walk(Body(), heading=0.0, n_frames=1), "n_frames is 1"),
        (lambda: render_walk(Body(), Walk(180.0, y=3.0)), "in frame .* start farther ahead"),
        (lambda: render_walk(Body(), Walk(0.0, y=-5.0)), "in frame 1; start farther ahead"),
        (lambda: render_walk(Body(), Walk(90.0, x=50.0)), "never in view"),
        (lambda: render_walk(Body(), Walk(90.0), drop_limbs=("tail",)), "drop_limbs is 'tail'"),
    ],
)
def test_impossible_arguments_are_refused(call, message):
    with pytest.raises(ArgumentError, match=message):
        call()
