"""The rhythm of steps: direct formulas, synthetic walkers' truth, noise, and CASIA A."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import stats
from scipy.signal import lfilter

from mcnlab.datasets.mirror import mirror_boxes
from mcnlab.errors import ArgumentError, TableError
from mcnlab.walking.gait import autocorrelation, find_events, find_period, measure_gait
from mcnlab.walking.viewpoint import (
    record_at_angles,
)

RATE = 25.0
HALF_FRAME = 0.5 / RATE

numbers = st.integers(-100, 100).map(float)
curves = st.integers(1, 40).flatmap(lambda n: arrays(float, n, elements=numbers))


@pytest.fixture(scope="module")
def square_on():
    """Boxes of eight synthetic walkers seen from the side, twice each, and the truth."""
    (boxes,), truth = record_at_angles([90], subjects=8, seed=5)
    return boxes, truth


def sine(period, *, n=100, phase=0.0):
    return np.sin(2 * np.pi * np.arange(n) / period + phase)


def noise(memory, *, n, count, seed):
    """Curves x(t) = memory·x(t−1) + e(t), after 200 frames to settle."""
    e = np.random.default_rng(seed).normal(size=(count, n + 200))
    return lfilter([1.0], [1.0, -memory], e, axis=-1)[:, 200:]


@given(curves, st.data())
def test_autocorrelation_is_the_textbook_formula(curve, data):
    valid = data.draw(arrays(bool, len(curve)))
    found = autocorrelation(curve, valid=valid)
    for lag in range(len(curve)):
        both = valid[: len(curve) - lag] & valid[lag:]
        early, late = curve[: len(curve) - lag][both], curve[lag:][both]
        power = np.sqrt((early @ early) * (late @ late))
        expected = (early @ late) / power if power > 0 else 0.0
        # Whole numbers up to 100: the transform's rounding, 1e-16 of the total power, is
        # under 1e-9 of the least power that is not 0.
        assert found[lag] == pytest.approx(expected, abs=1e-6)


@given(curves, st.floats(1e-6, 1e6), st.booleans())
def test_autocorrelation_knows_neither_scale_nor_the_arrow_of_time(curve, scale, turned):
    found = autocorrelation(curve)
    other = autocorrelation(scale * (curve[::-1] if turned else -curve))
    assert other == pytest.approx(found, abs=1e-6)
    assert np.abs(found).max() <= 1
    assert found[0] == pytest.approx(1.0 if curve.any() else 0.0)


def test_many_curves_are_correlated_each_by_itself():
    many = np.random.default_rng(0).normal(size=(2, 3, 20))
    together = autocorrelation(many)
    for at in np.ndindex(2, 3):
        assert together[at] == pytest.approx(autocorrelation(many[at]), abs=1e-12)


# From half of the longest step on: a shorter one repeats twice within what is looked for.
@settings(max_examples=40)
@given(st.floats(10.2, 19.5), st.floats(0, 6.3), st.integers(80, 160))
def test_a_sines_period_is_found_to_half_a_frame(period, phase, n):
    found = find_period(sine(period, n=n, phase=phase), frame_rate=RATE)
    # r(k) = cos(2πk/P) but for the window's ends, so the highest whole lag is the nearest
    # or, where two are near alike, the next; the parabola then puts the peak between them.
    assert found.step == pytest.approx(period / RATE, abs=HALF_FRAME)
    assert found.stride == 2 * found.step
    assert found.detectable
    assert found.peak > 0.9


def test_a_step_between_two_frames_may_be_found_at_its_double():
    # r is cos(2π·9/9.5) = 0.95 at both frames beside 9.5, and 1 at 19.
    assert find_period(sine(9.5, n=80), frame_rate=RATE).step * RATE == pytest.approx(19, abs=0.5)
    assert find_period(sine(9.0, n=80), frame_rate=RATE).step * RATE == pytest.approx(9, abs=0.5)


def test_a_curve_without_end_effects_is_located_far_better_than_a_frame():
    # Over 2000 frames the ends weigh nothing.  The parabola through a cosine's samples errs
    # by tan(w·d)/(2·tan(w/2)) − d at an offset d, under 0.007 frames at w = 2π/12.
    found = find_period(sine(12.3, n=2000), frame_rate=RATE)
    assert found.step * RATE == pytest.approx(12.3, abs=0.01)


@given(st.floats(9.5, 19.0), st.floats(-5, 5), st.floats(-5, 5), st.floats(0.01, 100))
def test_slow_change_and_scale_do_not_touch_the_period(period, slope, bend, scale):
    time = np.linspace(-1, 1, 100)
    plain = find_period(sine(period), frame_rate=RATE)
    other = find_period(scale * (sine(period) + slope * time + bend * time**2), frame_rate=RATE)
    assert other[:3] == pytest.approx(plain[:3], abs=1e-9)
    assert other.detectable == plain.detectable


def test_two_steps_that_differ_are_a_stride_and_no_step():
    # A period of 26 frames, with hardly anything at 13.
    curve = sine(26, n=130)
    stride = find_period(curve, frame_rate=RATE, rhythm="stride")
    assert stride.stride == pytest.approx(26 / RATE, abs=HALF_FRAME)
    assert stride.detectable
    assert not find_period(curve, frame_rate=RATE).detectable


def test_like_steps_make_no_stride():
    assert not find_period(sine(13, n=130), frame_rate=RATE, rhythm="stride").detectable


@pytest.mark.parametrize("rhythm", ["step", "stride"])
@pytest.mark.parametrize("memory", [0.0, 0.5, 0.8, 0.9])
@pytest.mark.parametrize("n", [40, 80])
def test_noise_passes_for_a_rhythm_once_in_twenty(rhythm, memory, n):
    count = 300
    alarms = sum(
        find_period(curve, frame_rate=RATE, rhythm=rhythm).detectable
        for curve in noise(memory, n=n, count=count, seed=n)
    )
    # φ is estimated, and rounded to 0.05; that shifts the rate to 3 … 6.5 % (measured with
    # 1000 curves each).  Beyond the binomial's 0.1 % tails of those it would be a fault.
    assert stats.binom.ppf(0.001, count, 0.03) <= alarms <= stats.binom.ppf(0.999, count, 0.065)


def test_the_false_alarm_rate_is_what_was_asked_for():
    curves = noise(0.6, n=60, count=400, seed=1)
    p_values = np.array([find_period(curve, frame_rate=RATE).p_value for curve in curves])
    loose = [find_period(curve, frame_rate=RATE, false_alarm=0.2).detectable for curve in curves]
    assert np.array_equal(loose, p_values <= 0.2)
    # As above, a fifth of the nominal rate either way for the estimated φ.
    assert stats.binom.ppf(0.001, 400, 0.16) <= sum(loose) <= stats.binom.ppf(0.999, 400, 0.25)


def test_gaps_neither_hide_a_rhythm_nor_feign_one():
    rng = np.random.default_rng(3)
    valid = np.ones(100, bool)
    valid[rng.choice(98, 30, replace=False) + 1] = False
    curve = np.where(valid, sine(13), np.nan)
    found = find_period(curve, frame_rate=RATE, valid=valid)
    assert found.step == pytest.approx(13 / RATE, abs=HALF_FRAME)
    assert found.detectable
    alarms = sum(
        find_period(curve, frame_rate=RATE, valid=valid).detectable
        for curve in noise(0.6, n=100, count=300, seed=2)
    )
    # Estimated over gaps, φ is somewhat less certain than without: allow 8 %.
    assert alarms <= stats.binom.ppf(0.999, 300, 0.08)


@pytest.mark.parametrize(
    "curve",
    [np.full(80, 0.4), np.zeros(80), np.linspace(0, 1, 80), np.full(80, 1e300), sine(13, n=11)],
)
def test_what_cannot_have_a_rhythm_has_none(curve):
    assert find_period(curve, frame_rate=RATE) == (0.0, 0.0, 0.0, 1.0, False)


def test_nothing_but_gaps_has_no_rhythm():
    valid = np.zeros(80, bool)
    assert not find_period(np.full(80, np.nan), frame_rate=RATE, valid=valid).detectable
    assert not find_period([], frame_rate=RATE).detectable


@given(arrays(float, st.integers(0, 60), elements=st.floats(-1e150, 1e150)), st.data())
def test_whatever_the_curve_the_answer_is_a_number(curve, data):
    valid = data.draw(arrays(bool, len(curve)))
    found = find_period(curve, frame_rate=RATE, valid=valid)
    assert np.isfinite(found[:4]).all()
    assert 0 <= found.step <= 0.8 + HALF_FRAME
    assert -1 <= found.peak <= 1
    assert 0 < found.p_value <= 1


def test_square_on_every_cadence_is_right(square_on):
    boxes, truth = square_on
    found = measure_gait(boxes, frame_rate=RATE)
    assert found["detectable"].all()
    # As for a sine: half a frame.
    assert np.abs(found["step_s"] - truth["step_s"]).max() <= HALF_FRAME
    # A frame of an adult's walk from the side: steps of 0.75 statures' speed and more part
    # the feet by 0.44 statures, so the width swings by more than a tenth of the height.
    assert (found["swing"] > 0.1).all()


def test_backwards_mirrored_and_nearer_the_rhythm_is_the_same(square_on):
    boxes, _ = square_on
    plain = measure_gait(boxes, frame_rate=RATE)
    mirrored = measure_gait(mirror_boxes(boxes, frame_width=352), frame_rate=RATE)
    pd.testing.assert_frame_equal(mirrored, plain)
    turned = boxes.copy()
    turned["frame"] = -boxes["frame"]
    turned = turned.sort_values(["sequence", "frame"], ignore_index=True)
    backwards = measure_gait(turned, frame_rate=RATE).loc[plain.index]
    pd.testing.assert_frame_equal(backwards, plain)
    nearer = boxes.assign(w=2 * boxes["w"], h=2 * boxes["h"])
    pd.testing.assert_frame_equal(measure_gait(nearer, frame_rate=RATE), plain)


def test_filmed_twice_as_fast_a_period_takes_half_the_time(square_on):
    boxes, _ = square_on
    plain = measure_gait(boxes, frame_rate=RATE)
    fast = measure_gait(boxes, frame_rate=2 * RATE, periods=(0.175, 0.4))
    assert fast["step_s"].to_numpy() == pytest.approx(plain["step_s"].to_numpy() / 2)
    assert fast["p_value"].equals(plain["p_value"])


def test_heel_strikes_and_mid_swings_come_when_they_must():
    walks = record_walks_square_on()
    for walk, boxes in walks:
        found = find_events(boxes["frame"], boxes["w"], frame_rate=RATE)
        phase = np.interp(
            np.concatenate(found), walk.truth["frame"], np.unwrap(walk.truth["phase"], period=1)
        )
        strikes, swings = np.split(2 * phase, [len(found.heel_strikes)])  # in steps
        # Between the contact of a heel and the lift of the other foot's toes, a tenth of a
        # cycle or a fifth of a step later, the feet are farthest apart; legs cross midway
        # between contacts.  A frame is 0.076 steps at 1.9 steps a second; two are allowed.
        late = (strikes - 0.1 + 0.5) % 1 - 0.5
        assert np.abs(late).max() <= 0.1 + 2 * 0.076
        crossing = (swings - 0.6 + 0.5) % 1 - 0.5
        assert np.abs(crossing).max() <= 0.1 + 2 * 0.076
        # Both come once a step, in turn.
        order = np.argsort(np.concatenate(found))
        kinds = np.r_[np.zeros(len(strikes)), np.ones(len(swings))][order]
        assert (np.diff(kinds) != 0).all()
        assert len(strikes) >= 3


def record_walks_square_on():
    from mcnlab.synthetic.body import draw_body
    from mcnlab.synthetic.walkers import make_walk
    from mcnlab.vision.silhouettes import measure_sequence

    walks = [
        make_walk(draw_body(np.random.default_rng(seed)), heading=90, distance=6.5)
        for seed in range(5)
    ]
    return [(walk, measure_sequence(walk.masks)) for walk in walks]


def test_events_bridge_missing_frames():
    curve = sine(13)
    frames = np.arange(100)
    kept = np.delete(frames, [20, 21, 50, 75])
    whole = find_events(frames, curve, frame_rate=RATE)
    some = find_events(kept, curve[kept], frame_rate=RATE)
    assert len(some.heel_strikes) == len(whole.heel_strikes) == 8
    assert np.abs(some.heel_strikes - whole.heel_strikes).max() <= 1
    assert np.abs(some.mid_swings - whole.mid_swings).max() <= 1


def test_a_constant_width_has_no_events():
    found = find_events([1, 2, 3, 4], [5.0, 5, 5, 5], frame_rate=RATE)
    assert len(found.heel_strikes) == len(found.mid_swings) == 0


@pytest.mark.parametrize(
    ("curve", "options", "word"),
    [
        ([0.0, np.nan], {}, "is nan .*not valid"),
        ([0.0, np.inf], {}, "is inf .*not valid"),
        (["wide", "thin"], {}, "no number"),
        ([0.0, 1j], {}, "complex"),
        (np.zeros((2, 3)), {}, "shape"),
        ([0.0, 1.0], {"valid": [True]}, "shape"),
        ([0.0, 1.0], {"valid": [1, 0]}, "bool"),
        ([0.0], {"frame_rate": 0}, "frame_rate"),
        ([0.0], {"frame_rate": np.nan}, "frame_rate"),
        ([0.0], {"frame_rate": 3}, "film faster"),
        ([0.0], {"periods": (0.8, 0.35)}, "longest"),
        ([0.0], {"periods": 0.5}, "periods"),
        ([0.0], {"periods": (0.0, 1.0)}, "shortest"),
        ([0.0], {"periods": (1.0, 1e12)}, "seconds"),
        ([0.0], {"false_alarm": 0}, "false_alarm"),
        ([0.0], {"false_alarm": 0.6}, "false_alarm"),
        ([0.0], {"rhythm": "trot"}, "rhythm"),
    ],
)
def test_a_curve_or_option_without_sense_is_refused(curve, options, word):
    with pytest.raises(ArgumentError, match=word):
        find_period(curve, **{"frame_rate": RATE, **options})


@pytest.mark.parametrize(
    ("curve", "valid", "word"),
    [
        (1.0, None, "shape"),
        ([], None, "at least one"),
        ([1.0, np.nan], None, "is nan .*not valid"),
        ([1.0, 2.0], [True], "shape"),
        ([1.0, 2.0], [1, 1], "bool"),
    ],
)
def test_a_curve_that_cannot_be_correlated_is_refused(curve, valid, word):
    with pytest.raises(ArgumentError, match=word):
        autocorrelation(curve, valid=valid)


@pytest.mark.parametrize(
    ("frames", "width", "options", "word"),
    [
        ([1, 2], [1, 2], {}, "three frames"),
        ([1, 2, 3], [1, 2], {}, "shape"),
        ([1, 2, 2], [1, 2, 3], {}, "rise"),
        ([1, 2, 3.5], [1, 2, 3], {}, "whole"),
        ([1, 2, np.nan], [1, 2, 3], {}, "finite"),
        ([1, 2, 3], [1, np.inf, 3], {}, "finite"),
        ([1, 2, 10**8], [1, 2, 3], {}, "span"),
        ([1, 2, 3], [1, 2, 3], {"frame_rate": 0}, "frame_rate"),
        ([1, 2, 3], [1, 2, 3], {"shortest": -1}, "shortest"),
    ],
)
def test_events_of_no_curve_are_refused(frames, width, options, word):
    with pytest.raises(ArgumentError, match=word):
        find_events(frames, width, **{"frame_rate": RATE, **options})


def test_an_unsound_table_is_refused(make_boxes):
    with pytest.raises(TableError, match="boxes"):
        measure_gait(make_boxes(5).drop(columns="w"), frame_rate=RATE)


def test_a_short_or_steady_walk_is_not_detected_and_no_row_is_lost(make_boxes):
    boxes = pd.concat(
        [make_boxes(1), make_boxes(11, sequence="short"), make_boxes(60, sequence="z", h=100.0)],
        ignore_index=True,
    )
    found = measure_gait(boxes, frame_rate=RATE)
    assert found.index.tolist() == ["walk", "short", "z"]
    assert not found["detectable"].any()
    assert np.isfinite(found.to_numpy(float)).all()
