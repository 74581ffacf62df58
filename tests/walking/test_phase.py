"""Phases of made-up curves whose envelope is known."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mcnlab.errors import ArgumentError, McnError
from mcnlab.tables import FRAME, SEQUENCE, H, W
from mcnlab.walking.phase import find_extrema, measure_phase, measure_phases, relative_growth

curves = arrays(float, st.integers(3, 60), elements=st.integers(10, 60).map(float))


def gait(n, *, slope, period, amplitude=8.0, level=100.0, shift=0.0):
    frames = np.arange(1, n + 1)
    swing = amplitude * np.sin(2 * np.pi * (frames - shift) / period)
    return frames, level + slope * frames + swing


@pytest.mark.parametrize("slope", [-0.4, 0.0, 0.25])
@pytest.mark.parametrize("period", [12, 15, 20])
def test_the_phase_of_a_steady_gait_is_the_line_it_swings_about(slope, period):
    # Whole periods: every maximum is sampled alike, so the envelope is exact.
    frames, curve = gait(6 * period, slope=slope, period=period)
    phase = measure_phase(frames, curve)
    assert phase.complete
    assert len(phase.soft) == 0
    assert phase.upper.slope == pytest.approx(slope, abs=1e-9)
    assert phase.lower.slope == pytest.approx(slope, abs=1e-9)
    assert phase.mean.slope == pytest.approx(slope, abs=1e-9)


@given(st.floats(-0.3, 0.3), st.floats(12, 20), st.floats(0, 20), st.integers(80, 120))
def test_sampling_moves_the_phase_no_more_than_the_extrema(slope, period, shift, n):
    amplitude, omega = 8.0, 2 * np.pi / period
    frames, curve = gait(n, slope=slope, period=period, amplitude=amplitude, shift=shift)
    phase = measure_phase(frames, curve)
    # The sampled extremum is one of the two frames around the true one, t*.  There the swing's
    # derivative is −slope, so less than a frame off the swing has changed by less than
    # |slope| + amplitude·ω²/2.  Points that are off a line of the true slope by at most e
    # turn the fitted line by at most e·Σ|dx|/Σdx².
    off = abs(slope) + amplitude * omega**2 / 2
    bounds = []
    for at, line in ((phase.maxima, phase.upper), (phase.minima, phase.lower)):
        dx = frames[at] - frames[at].mean()
        bounds.append(off * np.abs(dx).sum() / (dx**2).sum())
        assert abs(line.slope - slope) <= bounds[-1]
    assert abs(phase.mean.slope - slope) <= sum(bounds) / 2


def test_the_phase_is_midway_between_the_envelope_lines():
    frames, curve = gait(80, slope=0.2, period=16)
    curve = curve + 0.05 * frames * (curve > 100 + 0.2 * frames)  # an opening envelope
    phase = measure_phase(frames, curve)
    assert phase.upper.slope > phase.lower.slope + 0.03
    assert phase.mean.slope == (phase.upper.slope + phase.lower.slope) / 2
    assert phase.mean.intercept == (phase.upper.intercept + phase.lower.intercept) / 2


def test_soft_extrema_are_dropped_and_named():
    frames, curve = gait(80, slope=0.0, period=16)
    clean = measure_phase(frames, curve)
    dented = curve.copy()
    # In a trough, 8 below the line, a crest of 4: a maximum below the line.
    trough = clean.minima[2]
    dented[trough - 1 : trough + 2] += [2, 4, 2]
    # On a crest, 8 above the line, a dent of 4: a minimum above it.
    crest = clean.maxima[2]
    dented[crest - 1 : crest + 2] -= [2, 4, 2]
    phase = measure_phase(frames, dented)
    assert phase.soft.tolist() == sorted([trough, crest])
    assert trough not in phase.maxima
    assert crest not in phase.minima
    kept = measure_phase(frames, dented, soft_rule="keep")
    assert len(kept.soft) == 0
    assert trough in kept.maxima
    assert crest in kept.minima
    # A soft extremum lies 8 − 4 px beyond the line: kept, it turns the envelope.
    assert abs(kept.upper.slope - clean.upper.slope) > abs(phase.upper.slope - clean.upper.slope)


@given(curves)
def test_extrema_that_stay_are_on_their_side_of_the_trend(curve):
    frames = np.arange(len(curve))
    phase = measure_phase(frames, curve)
    trend = phase.trend.at(frames)
    assert (curve[phase.maxima] >= trend[phase.maxima]).all()
    assert (curve[phase.minima] <= trend[phase.minima]).all()
    maxima, minima = find_extrema(curve)
    assert sorted([*phase.maxima, *phase.minima, *phase.soft]) == sorted([*maxima, *minima])


@pytest.mark.parametrize(
    "curve",
    [[5, 5, 5, 5], [1, 2, 3, 4, 5], [0, 0, 9, 0, 0], [0, 9, 0, 0, 0, 0, 9, 0]],
    ids=["flat", "rising", "one-peak", "no-second-trough"],
)
def test_without_two_extrema_a_side_the_trend_stands_in(curve):
    phase = measure_phase(np.arange(len(curve)), curve)
    assert not phase.complete
    sides = ((phase.maxima, phase.upper), (phase.minima, phase.lower))
    assert any(len(at) < 2 for at, _ in sides)
    for at, line in sides:
        assert (line == phase.trend) == (len(at) < 2)


def test_a_plateau_counts_once_at_its_middle():
    curve = [0, 0, 5, 5, 5, 0, 0, 0, 0, 7, 0]
    maxima, minima = find_extrema(curve)
    assert maxima.tolist() == [3, 9]
    assert minima.tolist() == [6]  # the flat stretch 5 … 8; the ends are no extrema


def test_extrema_are_far_enough_apart_and_high_enough():
    curve = np.array([0, 4, 3, 9, 0, 0, 0, 0, 0, 0.5, 0, 0])
    assert find_extrema(curve, spacing=1, prominence=0.1)[0].tolist() == [1, 3, 9]
    assert find_extrema(curve, spacing=5, prominence=0.1)[0].tolist() == [3, 9]
    assert find_extrema(curve, spacing=1, prominence=0.8)[0].tolist() == [1, 3]
    assert find_extrema(curve, spacing=1, prominence=2)[0].tolist() == [3]


@given(curves)
def test_a_curve_upside_down_has_its_phase_upside_down(curve):
    frames = np.arange(len(curve))
    phase, turned = measure_phase(frames, curve), measure_phase(frames, -curve)
    assert turned.maxima.tolist() == phase.minima.tolist()
    assert turned.mean.slope == pytest.approx(-phase.mean.slope, abs=1e-9)
    assert turned.complete == phase.complete


@given(curves, st.sampled_from([0.5, 2.0, 4.0]), st.integers(-500, 500))
def test_scaling_scales_the_phase_and_counting_from_elsewhere_does_not(curve, factor, first):
    frames = np.arange(len(curve))
    phase = measure_phase(frames, curve)
    # Powers of two scale without rounding.
    scaled = measure_phase(frames, factor * curve, prominence=factor)
    assert scaled.mean.slope == factor * phase.mean.slope
    moved = measure_phase(frames + first, curve)
    assert moved.mean.slope == pytest.approx(phase.mean.slope, abs=1e-9)
    assert moved.maxima.tolist() == phase.maxima.tolist()


@pytest.mark.parametrize(
    ("frames", "curve", "options", "word"),
    [
        ([1], [5.0], {}, "three frames"),
        ([1, 2], [5.0, 6.0], {}, "three frames"),
        ([1, 2, 3], [5.0, 6.0], {}, "shape"),
        ([1, 2, 3], [5.0, np.nan, 6.0], {}, "finite"),
        ([1, np.nan, 3], [5.0, 5.0, 6.0], {}, "finite"),
        ([1, 1, 1], [5.0, 6.0, 7.0], {}, "x needs|frames"),
        ([1, 1, 2], [5.0, 6.0, 7.0], {}, "frames"),
        ([3, 1, 2], [5.0, 6.0, 7.0], {}, "frames"),
        ([1, 2, 3], [5.0, 6.0, 7.0], {"prominence": -1}, "prominence"),
        ([1, 2, 3], [5.0, 6.0, 7.0], {"prominence": np.nan}, "prominence"),
        ([1, 2, 3], [5.0, 6.0, 7.0], {"spacing": 0}, "spacing"),
        ([1, 2, 3], [5.0, 6.0, 7.0], {"soft_rule": "never"}, "soft_rule"),
    ],
)
def test_a_curve_without_a_phase_is_refused(frames, curve, options, word):
    with pytest.raises(ArgumentError, match=word):
        measure_phase(frames, curve, **options)


def test_every_walk_of_a_table_gets_its_phases(make_boxes):
    frames, h = gait(60, slope=0.3, period=12)
    w = gait(60, slope=-0.1, period=15)[1]
    boxes = pd.concat(
        [
            make_boxes(60, sequence="a", frame=frames, h=h, w=w),
            make_boxes(30, sequence="b", frame=frames[:30] + 70, h=w[:30], w=40.0),
        ],
        ignore_index=True,
    )
    phases = measure_phases(boxes)
    assert phases.index.tolist() == ["a", "b"]
    for name, column, curve in (("h", H, h), ("w", W, w)):
        phase = measure_phase(frames, curve)
        assert boxes.loc[boxes[SEQUENCE] == "a", column].tolist() == curve.tolist()
        assert phases.loc["a", f"m_{name}"] == phase.mean.slope
        assert phases.loc["a", f"c_{name}"] == phase.mean.intercept
        assert phases.loc["a", f"complete_{name}"]
    assert not phases.loc["b", "complete_w"]  # a flat curve
    assert phases.loc["b", "m_w"] == 0


@pytest.mark.parametrize("n", [1, 2])
def test_a_walk_too_short_for_a_phase_is_named(make_boxes, n):
    with pytest.raises(ArgumentError, match=rf"'walk' has {n} frame\(s\)"):
        measure_phases(make_boxes(n))


@given(data=st.data())
@settings(max_examples=300)
def test_phases_of_any_table_are_finite_or_a_clear_error(box_tables, data):
    boxes = data.draw(box_tables)
    try:
        phases = measure_phases(boxes)
    except McnError:
        return
    assert np.isfinite(phases[["m_h", "c_h", "m_w", "c_w"]].to_numpy()).all()
    # No slope is steeper than the steepest piece of its curve.
    for name, walk in boxes.groupby(SEQUENCE):
        for key in ("h", "w"):
            rise = np.diff(walk[key].astype(float)) / np.diff(walk[FRAME].astype(float))
            assert abs(phases.loc[name, f"m_{key}"]) <= np.abs(rise).max() + 1e-9


@given(st.floats(-0.5, 0.5), st.integers(3, 60), st.sampled_from([0.5, 2.0, 3.0]))
def test_relative_growth_is_the_rate_of_an_exponential_at_any_distance(rate, n, nearness):
    time = np.arange(n) / 25
    curve = 80 * np.exp(rate * time)
    assert relative_growth(time, curve) == pytest.approx(rate, abs=1e-9)
    assert relative_growth(time, nearness * curve) == pytest.approx(rate, abs=1e-9)


def test_relative_growth_leaves_out_frames_of_no_weight():
    time = np.arange(5.0)
    curve = 50 * np.exp(0.1 * time)
    curve[2] = 9000
    assert relative_growth(time, curve, weights=[1, 1, 0, 1, 1]) == pytest.approx(0.1)


@pytest.mark.parametrize("curve", [[1.0, 0.0, 2.0], [1.0, -1.0, 2.0], [1.0, np.nan, 2.0]])
def test_a_curve_without_size_has_no_growth(curve):
    with pytest.raises(ArgumentError, match="curve"):
        relative_growth([0, 1, 2], curve)
