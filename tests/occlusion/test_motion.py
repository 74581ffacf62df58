"""Walkers foreseen: exactly where they walk straight before a pinhole camera."""

from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcnlab.errors import ArgumentError
from mcnlab.occlusion import motion as module
from mcnlab.occlusion.motion import (
    BOX_NOISE,
    DRIFT,
    JITTER,
    PERSISTENCE,
    RECENT,
    WANDER,
    Ground,
    _doubt_of,
    move_straight,
)
from mcnlab.occlusion.pairs import Film, Walkers, find_pairs
from mcnlab.regression import fit_lines
from mcnlab.synthetic import crossings
from mcnlab.synthetic.crossings import Square, make_crossings

FOCAL, MIDDLE, HORIZON = 800.0, 319.5, 240.0  # pixels
STATURE, ABOVE, ASPECT = 1.7, 3.0, 0.4  # metres, metres of the camera, width over height
TIMES = np.arange(1, 16) / 5
CAMERA = Film(25.0, 640, 480)

# Metres, and metres a second; within the three seconds nobody comes near the camera.
places = st.tuples(st.floats(-4, 4), st.floats(9, 25))
paces = st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5)).filter(lambda v: np.hypot(*v) > 0.2)
seeds = st.integers(0, 10**6)


def project(place, pace, times):
    """The box of a straight walk before a level camera: centre, feet, width, height."""
    right, ahead = (
        np.asarray(a) + np.multiply.outer(times, b) for a, b in zip(place, pace, strict=True)
    )
    h = FOCAL * STATURE / ahead
    return MIDDLE + FOCAL * right / ahead, HORIZON + FOCAL * ABOVE / ahead, ASPECT * h, h


def watch(place, pace, *, horizon=True, rate=25):
    """One walker, seen for the second until he is at `place`."""
    time = np.arange(1 - rate, 1) / rate
    x, feet, w, h = (value[None] for value in project(place, pace, time))
    known = (HORIZON, ABOVE / STATURE) if horizon else (0.0, 0.0)
    seen = np.ones(x.shape, bool)
    return Walkers(time, seen, x, feet, w, h, *map(np.atleast_1d, known), CAMERA)


def scatter(seed, *, walkers=12, frames=20):
    """Noisy walkers with gaps, some with a horizon, some with feet above it."""
    rng = np.random.default_rng(seed)
    time = np.arange(1 - frames, 1) / frames
    column = rng.uniform(size=(walkers, 1))
    h = 40 + 100 * column + rng.normal(0, 20, (walkers, 1)) * time
    h = np.maximum(h + rng.normal(size=(walkers, frames)), 5)
    x = 600 * rng.uniform(size=(walkers, 1)) + rng.normal(0, 60, (walkers, 1)) * time
    feet = 480 * rng.uniform(size=(walkers, 1)) + rng.normal(0, 30, (walkers, 1)) * time
    seen = rng.uniform(size=(walkers, frames)) < 0.9
    seen[:, [0, -1]] = True
    noise = rng.normal(size=(3, walkers, frames))
    rise = np.where(rng.uniform(size=walkers) < 0.7, rng.uniform(0.3, 3, walkers), 0.0)
    row = np.where(rise > 0, 100.0, 0.0)
    values = (
        np.where(seen, value, 0)
        for value in (x + noise[0], feet + noise[1], 0.4 * h + noise[2] / 4, h)
    )
    return Walkers(time, seen, *values, row, rise, CAMERA)


@contextmanager
def going_on_forever():
    """Velocities do not fade, and whatever moves goes on."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "PERSISTENCE", 1e12)
        patch.setattr(module, "JITTER", 0.0)
        yield


def assert_motion(motion, truth, *, atol=1e-6):
    """Centre, width and height are right; feet have tests of their own."""
    for value, wanted in zip(motion[:1] + motion[2:], truth[:1] + truth[2:], strict=True):
        np.testing.assert_allclose(value[:, 0], wanted, rtol=0, atol=atol)


@pytest.fixture(scope="module")
def exact():
    """People of one stature, boxed without error from a level camera, and their pairs."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(crossings, "STATURE", (STATURE, 0.0))
        patch.setattr(crossings, "BOB", 0.0)
        return _made(box_noise=0.0)


@pytest.fixture(scope="module")
def noisy():
    """The same with boxes that err."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(crossings, "STATURE", (STATURE, 0.0))
        patch.setattr(crossings, "BOB", 0.0)
        return _made(box_noise=0.004)


def _made(*, box_noise):
    square = Square(tilt=0, height=ABOVE, near=8, far=20)
    made = make_crossings(people=60, seconds=40, turning=0, box_noise=box_noise, square=square)
    pairs = find_pairs(made)
    # There, columns count from the middle of the first pixel; here, from its edge.
    walkers = replace(pairs.walkers, x=pairs.walkers.x + 0.5)
    return made, replace(pairs, walkers=walkers)


# On the ground


# Lines through 25 values are exact to 1e-12 of their size; three seconds ahead, and on images
# of hundreds of pixels, 1e-6 leaves room for a thousand times that.
@given(place=places, pace=paces, horizon=st.booleans())
def test_a_straight_walk_is_foreseen_exactly(place, pace, horizon):
    with going_on_forever():
        motion = Ground.of(watch(place, pace, horizon=horizon)).move(TIMES)
    assert_motion(motion, project(place, pace, TIMES))


@given(place=places, pace=paces, horizon=st.booleans())
def test_distances_are_in_body_heights(place, pace, horizon):
    ground = Ground.of(watch(place, pace, horizon=horizon))
    assert FOCAL * ground.near[0] == pytest.approx(place[1] / STATURE)
    assert ground.side[0] - MIDDLE * ground.near[0] == pytest.approx(place[0] / STATURE, abs=1e-9)
    assert (ground.fill[0], ground.aspect[0]) == pytest.approx((1, ASPECT))
    assert (FOCAL * ground.near_rate[0]) == pytest.approx(pace[1] / STATURE, abs=1e-9)


@given(place=places, pace=paces)
def test_feet_keep_their_place_below_the_horizon(place, pace):
    with going_on_forever():
        motion = Ground.of(watch(place, pace)).move(TIMES)
    feet = project(place, pace, TIMES)[1]
    share = (motion.feet[:, 0] - HORIZON) / (feet - HORIZON)
    # Where they are now is read from a line through a curve, 1 / (1 + g·t), with g the growth
    # a second; nowhere in the second is it off by more than the curve bends away from its
    # tangent at the far end, g² / (1 − g)³.
    growth = abs(pace[1]) / place[1]
    np.testing.assert_allclose(share, share[0], rtol=1e-9)
    assert share[0] == pytest.approx(1, abs=growth**2 / (1 - growth) ** 3 + 1e-9)


@given(place=places, pace=paces)
def test_without_a_horizon_feet_go_on_along_a_line(place, pace):
    walkers = watch(place, pace, horizon=False)
    with going_on_forever():
        motion = Ground.of(walkers).move(TIMES)
    slope, now = np.polyfit(walkers.time, walkers.feet[0], 1, w=2 ** (walkers.time / RECENT / 2))
    np.testing.assert_allclose(motion.feet[:, 0], now + slope * TIMES, atol=1e-7)


@given(place=places, pace=paces, horizon=st.booleans())
def test_velocities_fade_by_a_known_amount(place, pace, horizon):
    ground = Ground.of(watch(place, pace, horizon=horizon))
    # As far as in so many seconds without fading, along the same straight walk; what hardly
    # moves nor grows goes less far.
    square = ground.pace[0] ** 2 + (pace[1] / place[1]) ** 2
    lasting = square / (square + JITTER**2) * PERSISTENCE * (1 - np.exp(-TIMES / PERSISTENCE))
    assert_motion(ground.move(TIMES), project(place, pace, lasting))


@given(
    place=places,
    right=st.floats(-1.5, 1.5),
    away=st.floats(0.3, 1.5),
    sign=st.sampled_from([-1, 1]),
)
def test_straight_lines_in_the_image_shrink_who_walks_along_the_line_of_sight(
    place, right, away, sign
):
    # Height and feet's row are convex in time: a line through the past runs below them.
    walkers = watch(place, (right, sign * away))
    straight = move_straight(walkers, TIMES)
    _, feet, _, h = project(place, (right, sign * away), TIMES)
    assert (straight.h[:, 0] < h).all()
    assert (straight.feet[:, 0] < feet).all()


def test_across_the_line_of_sight_both_are_right():
    place, pace = (-2.0, 12.0), (1.3, 0.0)
    wanted, walkers = project(place, pace, TIMES), watch(place, pace)
    with going_on_forever():
        both = Ground.of(walkers).move(TIMES), move_straight(walkers, TIMES)
    for motion in both:
        assert_motion(motion, wanted)
        np.testing.assert_allclose(motion.feet[:, 0], wanted[1])


@given(place=places)
def test_who_stands_stays(place):
    walkers = watch(place, (0.0, 0.0))
    wanted = project(place, (0.0, 0.0), TIMES)
    assert Ground.of(walkers).pace[0] < 1e-9
    assert_motion(Ground.of(walkers).move(TIMES), wanted)
    assert_motion(move_straight(walkers, TIMES), wanted)


def test_a_box_that_creeps_goes_on_by_a_part():
    # At half of the jitter, a fifth of the way: (1/2)² / ((1/2)² + 1).
    place, pace = (0.0, 10.0), (JITTER / 2 * STATURE, 0.0)
    ground = Ground.of(watch(place, pace))
    assert ground.pace[0] == pytest.approx(JITTER / 2)
    assert ground.near_rate[0] == pytest.approx(0, abs=1e-9)
    way = ground.move([3.0]).x[0, 0] - MIDDLE
    fading = PERSISTENCE * (1 - np.exp(-3 / PERSISTENCE))
    assert way == pytest.approx(FOCAL * pace[0] / 10 * fading / 5)


def test_the_velocity_in_the_image_is_that_of_the_box():
    place, pace = (2.0, 12.0), (0.8, -1.1)
    ground = Ground.of(watch(place, pace))
    tiny = 1e-5
    x, _, _, h = project(place, pace, np.array([-tiny, 0, tiny]))
    assert ground.rate[0][0] == pytest.approx((x[2] - x[0]) / (2 * tiny) / h[1], rel=1e-6)
    assert ground.pace[0] == np.hypot(*ground.rate)[0]


def test_who_comes_too_near_is_let_go_no_farther():
    # From 3 m, at 1.5 m a second: after 1.5 s a quarter of the way is left.
    place, pace = (0.5, 3.0), (0.3, -1.5)
    with going_on_forever():
        motion = Ground.of(watch(place, pace)).move([1.4, 1.5, 2.0, 20.0])
    assert_motion(motion, project(place, pace, np.array([1.4, 1.5, 1.5, 1.5])))


def test_who_goes_does_not_shrink_to_nothing():
    straight = move_straight(watch((0.0, 9.0), (0.0, 2.0)), np.linspace(0, 60, 50))
    assert straight.h.min() == pytest.approx(straight.h[0, 0] / 4)


# What is seen


@given(place=places, pace=paces, seed=seeds)
def test_missing_boxes_do_not_matter_on_a_straight_walk(place, pace, seed):
    rng = np.random.default_rng(seed)
    walkers = watch(place, pace)
    seen = rng.uniform(size=walkers.seen.shape) < 0.8
    seen[:, [0, -1]] = True
    changed = [
        np.where(seen, value, rng.choice([0, -1e6, 1e6], seen.shape))
        for value in (walkers.x, walkers.feet, walkers.w, walkers.h)
    ]
    gappy = replace(walkers, seen=seen, **dict(zip(("x", "feet", "w", "h"), changed, strict=True)))
    with going_on_forever():
        assert_motion(Ground.of(gappy).move(TIMES), project(place, pace, TIMES))


@given(seed=seeds, filler=st.sampled_from([-1e6, 0.0, 1.0, 1e6]))
def test_what_stands_where_there_is_no_box_does_not_matter(seed, filler):
    walkers = scatter(seed)
    names = ("x", "feet", "w", "h")
    filled = {name: np.where(walkers.seen, getattr(walkers, name), filler) for name in names}
    other = replace(walkers, **filled)
    for look in (lambda w: Ground.of(w).move(TIMES), lambda w: move_straight(w, TIMES)):
        for one, two in zip(look(walkers), look(other), strict=True):
            np.testing.assert_array_equal(one, two)


def test_the_latest_boxes_count_most():
    # A turn half a second ago: the ground's line follows the latter half more closely.
    walkers = watch((0.0, 12.0), (1.0, 0.0), horizon=False)
    turned = replace(walkers, x=MIDDLE + np.abs(walkers.time + 0.5)[None] * 60)
    assert Ground.of(turned).rate[0][0] > 0
    weights = np.exp2(turned.time / RECENT)
    slope = np.polyfit(turned.time, turned.x[0], 1, w=np.sqrt(weights))[0]
    assert Ground.of(turned).rate[0][0] == pytest.approx(slope / turned.h[0, -1])


@given(place=places, pace=paces)
def test_a_walk_backwards_in_time_has_opposite_rates(place, pace):
    walkers = watch(place, pace)
    names = ("x", "feet", "w", "h")
    back = replace(walkers, **{name: getattr(walkers, name)[:, ::-1] for name in names})
    there, again = Ground.of(walkers), Ground.of(back)
    assert again.near_rate == pytest.approx(-there.near_rate, abs=1e-12)
    assert again.side_rate == pytest.approx(-there.side_rate, abs=1e-9)


def test_feet_above_the_horizon_say_nothing_of_the_distance():
    walkers = watch((1.0, 12.0), (0.5, -1.0))
    # On a balcony: scales are read from the height alone, as without a horizon.
    above = replace(walkers, feet=walkers.feet - 400)
    plain = Ground.of(replace(above, rise=np.zeros(1)))
    ground = Ground.of(above)
    assert ground.near == plain.near
    assert ground.near_rate == plain.near_rate
    motion = ground.move(TIMES)
    assert all(np.isfinite(value).all() for value in motion)
    np.testing.assert_array_equal(motion.h, plain.move(TIMES).h)


@pytest.mark.parametrize("sizes", [(20, 200), (200, 2), (1, 5000)])
@pytest.mark.parametrize("horizon", [True, False])
@pytest.mark.parametrize("jump", [3, 12, 20])
def test_a_box_that_jumps_in_size_keeps_a_size(sizes, horizon, jump):
    walkers = watch((0.0, 12.0), (0.5, 0.0), horizon=horizon)
    h = np.where(np.arange(25) < jump, *sizes).astype(float)[None]
    walkers = replace(walkers, h=h, w=0.4 * h)
    for motion in (Ground.of(walkers).move(TIMES), move_straight(walkers, TIMES)):
        assert all(np.isfinite(value).all() for value in motion)
        assert (motion.h > 0).all()
        assert (motion.w > 0).all()
    assert (Ground.of(walkers).spread(TIMES) > 0).all()


# Symmetry


def changed(walkers, *, scale=1.0, across=0.0, down=0.0, mirror=False):
    """The same walkers in a larger, shifted or mirrored image."""
    x = CAMERA.width - 1 - walkers.x if mirror else walkers.x
    return replace(
        walkers,
        x=scale * x + across,
        feet=scale * walkers.feet + down,
        w=scale * walkers.w,
        h=scale * walkers.h,
        horizon=scale * walkers.horizon + down,
    )


def both_ways(walkers):
    return Ground.of(walkers).move(TIMES), move_straight(walkers, TIMES)


@given(seed=seeds)
def test_mirrored_walkers_have_a_mirrored_future(seed):
    walkers = scatter(seed)
    mirrored = changed(walkers, mirror=True)
    for one, two in zip(both_ways(walkers), both_ways(mirrored), strict=True):
        np.testing.assert_allclose(two.x, CAMERA.width - 1 - one.x, rtol=1e-9, atol=1e-7)
        for value, other in zip(one[1:], two[1:], strict=True):
            np.testing.assert_allclose(other, value, rtol=1e-9, atol=1e-7)
    heading, other = (Ground.of(w).heading(focal_length=700) for w in (walkers, mirrored))
    np.testing.assert_allclose(np.cos(np.radians(heading + other)), 1, atol=1e-9)


@given(seed=seeds, scale=st.sampled_from([0.25, 3.0, 8.0]))
def test_a_larger_image_has_a_larger_future(seed, scale):
    walkers = scatter(seed)
    larger = changed(walkers, scale=scale)
    for one, two in zip(both_ways(walkers), both_ways(larger), strict=True):
        for value, other in zip(one, two, strict=True):
            np.testing.assert_allclose(other, scale * value, rtol=1e-9, atol=1e-7)
    ground, other = Ground.of(walkers), Ground.of(larger)
    np.testing.assert_allclose(other.pace, ground.pace, rtol=1e-9)
    np.testing.assert_allclose(other.spread(TIMES), scale * ground.spread(TIMES), rtol=1e-9)


@given(seed=seeds, across=st.floats(-500, 500), down=st.floats(-500, 500))
def test_where_the_optical_axis_is_does_not_matter(seed, across, down):
    walkers = scatter(seed)
    # Where no horizon is known its row is not read, wherever it is said to be.
    shifted = changed(walkers, across=across, down=down)
    for one, two in zip(both_ways(walkers), both_ways(shifted), strict=True):
        np.testing.assert_allclose(two.x, one.x + across, rtol=1e-9, atol=1e-6)
        np.testing.assert_allclose(two.feet, one.feet + down, rtol=1e-9, atol=1e-6)
        np.testing.assert_allclose(two.h, one.h, rtol=1e-9, atol=1e-6)


@given(seed=seeds)
def test_neither_camera_nor_company_matters(seed):
    walkers = scatter(seed)
    other = replace(walkers, camera=Film(7.0, 10, 10))
    some = np.array([5, 0, 3])
    fewer = replace(
        walkers,
        **{
            name: getattr(walkers, name)[some]
            for name in ("seen", "x", "feet", "w", "h", "horizon", "rise")
        },
    )
    for one, two, three in zip(*map(both_ways, (walkers, other, fewer)), strict=True):
        for value, same, few in zip(one, two, three, strict=True):
            np.testing.assert_array_equal(same, value)
            np.testing.assert_allclose(few, value[:, some], rtol=1e-12)
        for taken, few in zip(one.take(some), three, strict=True):
            np.testing.assert_allclose(few, taken, rtol=1e-12)


# Uncertainty


@given(seed=seeds)
def test_the_future_is_less_certain_every_second(seed):
    ground = Ground.of(scatter(seed))
    spread = ground.spread(np.r_[0.0, TIMES])
    height = ground.fill / ground.near
    assert (spread > 0).all()
    assert (np.diff(spread, axis=0) > 0).all()
    now = np.sqrt(1 + ground.doubt[0])
    np.testing.assert_allclose(spread[0], BOX_NOISE * now * height)
    faster = replace(ground, feet_rate=ground.feet_rate + np.sign(ground.feet_rate))
    assert (faster.spread(TIMES) > spread[1:]).all()


def test_the_spread_adds_noise_drift_and_wandering():
    place, pace = (0.0, 10.0), (1.0, 0.0)
    ground = Ground.of(watch(place, pace))
    height = FOCAL * STATURE / 10
    now, rate, both = ground.doubt[:, 0]
    boxes = BOX_NOISE**2 * (1 + now + 4 * both + 4 * rate)
    wanted = height * np.sqrt(boxes + 4 * (DRIFT**2 + (WANDER / STATURE) ** 2))
    assert ground.spread([2.0])[0, 0] == pytest.approx(wanted)


@pytest.mark.parametrize("rate", [2, 7, 25])
def test_the_noise_of_boxes_passes_into_the_line_as_it_does_by_chance(rate):
    time = np.arange(1 - rate, 1) / rate
    weights = np.exp2(time / RECENT)[None]
    if rate > 7:
        weights[0, 3:9] = 0.0
    doubt = _doubt_of(time, weights)[:, 0]
    drawn = np.random.default_rng(1).normal(size=(40_000, rate))
    line = fit_lines(time, drawn, weights=np.broadcast_to(weights, drawn.shape))
    found = np.cov(line.intercept, line.slope)
    # A variance of 40,000 draws is good to 0.7 %; five times that, and as much of the root of
    # the product for the covariance.
    assert found[0, 0] == pytest.approx(doubt[0], rel=0.035)
    assert found[1, 1] == pytest.approx(doubt[1], rel=0.035)
    assert found[0, 1] == pytest.approx(doubt[2], abs=0.035 * np.sqrt(doubt[0] * doubt[1]))


# Headings


@given(place=places, pace=paces, horizon=st.booleans())
def test_headings_are_exact_before_a_level_camera(place, pace, horizon):
    heading = Ground.of(watch(place, pace, horizon=horizon)).heading(focal_length=FOCAL)
    wanted = np.degrees(np.arctan2(*pace))
    assert np.cos(np.radians(heading[0] - wanted)) == pytest.approx(1, abs=1e-9)


def true_headings(made, pairs):
    """Each walker's true heading, radians, and whether he walks."""
    world = made.boxes.groupby("sequence", sort=False)[["world_x", "world_y"]]
    step = (world.last() - world.first()).to_numpy()
    track = np.zeros(len(pairs.walkers), int)
    track[pairs.who] = pairs.track
    return np.arctan2(*step[track].T), np.hypot(*step[track].T) > 0


def test_headings_of_synthetic_walkers_are_true(exact):
    made, pairs = exact
    truth, walks = true_headings(made, pairs)
    assert walks.sum() > 100
    heading = np.radians(Ground.of(pairs.walkers).heading(focal_length=FOCAL))
    np.testing.assert_allclose(np.cos(heading - truth)[walks], 1, atol=1e-9)


def test_headings_err_by_what_the_boxes_noise_makes_of_them(noisy):
    made, pairs = noisy
    truth, walks = true_headings(made, pairs)
    walkers = replace(pairs.walkers, rise=np.zeros(len(pairs.walkers)))
    ground = Ground.of(walkers)
    heading = np.radians(ground.heading(focal_length=FOCAL))
    # heading = atan2(A, B); A and B are slopes, sums of readings times these factors.
    weights = walkers.seen * np.exp2(walkers.time / RECENT)
    middle = (weights * walkers.time).sum(axis=1) / weights.sum(axis=1)
    offset = weights * (walkers.time - middle[:, None])
    factor = offset / (offset * walkers.time).sum(axis=1)[:, None]
    h, side = np.where(walkers.seen, walkers.h, 1.0), walkers.x - MIDDLE
    a, b = (
        (ground.side_rate - MIDDLE * ground.near_rate)[:, None],
        FOCAL * ground.near_rate[:, None],
    )
    # Each edge errs by 0.4 % of the height: the height by √2 of that, the middle by 1/√2.
    by_x = factor * b / h * (0.004 * h / np.sqrt(2))
    by_h = factor * (a * FOCAL - b * side) / h**2 * (0.004 * h * np.sqrt(2))
    std = np.sqrt((by_x**2 + by_h**2).sum(axis=1)) / (a**2 + b**2)[:, 0]
    # To first order, so where the error is small; it is normal there.
    good = walks & (std < 0.15)
    score = np.sin(heading - truth)[good] / std[good]
    n = len(score)
    assert n > 200
    # The standard error of a deviation is 1/√(2n); a few percent more for the curvature.
    assert score.std() == pytest.approx(1, abs=4 / np.sqrt(2 * n) + 0.05)
    assert abs(score.mean()) < 4 / np.sqrt(n)


# Bad input


@pytest.mark.parametrize("times", [[np.nan], [0.0, np.inf], [[1.0, 2.0]]])
def test_times_must_be_finite_and_in_a_row(times):
    walkers = watch((0.0, 10.0), (1.0, 0.0))
    ground = Ground.of(walkers)
    for look in (ground.move, ground.spread, lambda t: move_straight(walkers, t)):
        with pytest.raises(ArgumentError, match="times is"):
            look(times)


@pytest.mark.parametrize("focal_length", [0, -800, np.nan, None])
def test_a_focal_length_must_be_positive(focal_length):
    ground = Ground.of(watch((0.0, 10.0), (1.0, 0.0)))
    with pytest.raises(ArgumentError, match="focal_length is"):
        ground.heading(focal_length=focal_length)


def test_a_walker_seen_once_has_no_line():
    walkers = watch((0.0, 10.0), (1.0, 0.0))
    once = replace(walkers, seen=walkers.time[None] == 0)
    for look in (Ground.of, lambda w: move_straight(w, TIMES)):
        with pytest.raises(ArgumentError, match="two different values"):
            look(once)
