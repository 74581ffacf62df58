"""Why square-on: the rhythm of the steps in a walker's box, and from where it shows.

Seen from the side a box widens as the legs part (heel strike) and narrows as they cross
(mid-swing), once a step; seen from the front it hardly changes (thesis sections 2.1 and
2.2, Figures 2.1 and 2.2).  Here the step's period is found by autocorrelation, and a test
says whether there is a rhythm at all, so that the thesis's "gait cycles become gradually
detectable" turns into a curve over the view angle σ: 0 = frontal, 90 = square-on.

The curve is width over height, which does not grow as the walker comes near; a parabola
takes out what else changes slowly.  The null hypothesis of the test is noise that
remembers the frame before it, x(t) = φ·x(t−1) + e(t): white noise would be too easily
surprised by a curve that is merely smooth.  Its distribution comes from simulated curves
that have the walk's own length, gaps and φ, and go the same way as the walk's curve.

Steps and strides are looked for apart.  Square-on, a left step looks like a right one and
the curve repeats with every step.  From a view nearly frontal the two look different, and
what little the width swings repeats with every stride, that is every other step.

References
----------
C. BenAbdelkader, R. Cutler and L. Davis, Stride and cadence as a biometric in automatic
person identification and verification, IEEE FG 2002: the period of a walk from its box.
M. R. Allen and L. A. Smith, Monte Carlo SSA, Journal of Climate 9, 1996: oscillations
tested against red noise.
"""

from dataclasses import replace
from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np
import pandas as pd
from pandas.api.types import is_numeric_dtype
from scipy.fft import irfft, next_fast_len, rfft
from scipy.signal import lfilter

from mcnlab import columns
from mcnlab.columns import SEQUENCE, H, W
from mcnlab.datasets.noise import add_noise
from mcnlab.datasets.walkers import View, direction_heading, draw_body, make_walk
from mcnlab.errors import (
    ArgumentError,
    SilhouetteError,
    TableError,
    require_choice,
    require_count,
    require_number,
)
from mcnlab.phase import find_extrema
from mcnlab.silhouettes import measure_sequence

STEP_PERIODS: Final = (0.35, 0.8)  # s: from a hurried walk (171 steps a minute) to a stroll (75)
RHYTHMS: Final = ("step", "stride")
FALSE_ALARM: Final = 0.05  # share of curves without rhythm that pass for one
TREND_DEGREE: Final = 2  # of the polynomial that is taken out
EVENT_RISE: Final = 0.5  # least prominence of a heel strike, in standard deviations
LEAST_FRAMES: Final = 12  # fewer tell a rhythm from nothing
_DRAWS: Final = 999  # simulated curves: 5 % of them is known to 0.7 %
_SETTLE: Final = 100  # frames until a curve that starts at 0 has forgotten it, at φ = 0.95
_BLOCK: Final = 1_000_000  # simulated values at a time, so that memory stays bounded
_MEMORY_STEP: Final = 0.05  # φ is rounded to this, so that walks of one length share curves
_MEMORY_LIMITS: Final = (-0.95, 0.95)
_FLAT: Final = 1e-9  # relative spread under which a curve is constant but for rounding


class Period(NamedTuple):
    """The rhythm of one curve."""

    step: float  # s, from one heel strike to the next; 0 where the curve has no peak at all
    peak: float  # autocorrelation at that lag, −1 … 1
    rise: float  # from the autocorrelation half a step earlier to the peak, 0 … 2
    p_value: float  # share of curves without rhythm that rise as much
    detectable: bool  # p_value ≤ the false-alarm rate

    @property
    def stride(self):
        """Seconds from a heel strike to the next one of the same foot: two steps."""
        return 2 * self.step


class Events(NamedTuple):
    """Two moments of the gait cycle, as frame numbers."""

    heel_strikes: np.ndarray  # the legs are farthest apart
    mid_swings: np.ndarray  # the legs cross


def autocorrelation(curve, *, valid=None):
    """How like itself a curve is some frames later.

    Parameters
    ----------
    curve : array_like, shape (..., n)
        Taken as it is: remove mean and trend first.
    valid : array_like of bool, shape (n,) or (..., n), optional
        Where there is a value; others are not looked at.

    Returns
    -------
    ndarray, shape (..., n)
        At lags 0 … n − 1, within −1 … 1: the correlation (about 0) of the values that have
        a partner at that lag, so that it does not fade as partners get fewer; 0 where none
        has, or their values are all 0.

    Raises
    ------
    ArgumentError
        When the curve has no value or one that is not finite, or `valid` has another shape.
    """
    curve = _numbers("curve", curve)
    if curve.ndim == 0 or curve.shape[-1] == 0:
        raise ArgumentError(f"curve has shape {curve.shape}; pass at least one value.")
    valid = np.ones(curve.shape[-1], bool) if valid is None else np.asarray(valid)
    if valid.dtype != bool or valid.shape not in (curve.shape, curve.shape[-1:]):
        raise ArgumentError(
            f"valid is {valid.dtype} of shape {valid.shape}; pass one bool a value of curve."
        )
    curve = np.where(valid, curve, 0.0)
    if not np.isfinite(curve).all():
        raise ArgumentError("curve holds values that are not finite; mark them as not valid.")
    # Between −1 and 1 squares neither overflow nor vanish.
    scale = np.abs(curve).max(axis=-1, keepdims=True)
    return _autocorrelate(curve / np.where(scale > 0, scale, 1.0), valid)


def find_period(
    curve,
    *,
    frame_rate,
    valid=None,
    rhythm="step",
    periods=STEP_PERIODS,
    false_alarm=FALSE_ALARM,
):
    """The period of a walker's steps, from one curve of his box.

    Parameters
    ----------
    curve : array_like, shape (n,)
        Box width over height (or width alone), one value a frame.
    frame_rate : float
        Frames a second.
    valid : array_like of bool, shape (n,), optional
        Where there is a value; others may hold anything.
    rhythm : {"step", "stride"}, optional
        Which repetition to look for.  A stride is two steps that differ: square-on, where
        they do not, there is no such rhythm.
    periods : (float, float), optional
        The shortest and the longest step looked for, s.
    false_alarm : float, optional
        The share of curves without rhythm that may pass for one, between 0 and 1.

    Returns
    -------
    Period
        Not detectable, and 0 s, where the curve is constant, shorter than two of the
        shortest steps, or its autocorrelation has no peak among those periods.

    Raises
    ------
    ArgumentError
        When a value is not finite, an option is out of range, or the frame rate is too
        low to see such periods.

    Notes
    -----
    The peak is the highest local maximum of the autocorrelation within `periods` (twice
    as late for strides), placed between frames by a parabola.  Tested is its rise over the
    autocorrelation at half the lag, where the legs cross (or the other foot steps): that
    finds more of the oblique walks than the peak's height, at the same rate of false
    alarms, as memory alone lifts both.
    """
    search = _check_options(frame_rate, rhythm, periods, false_alarm)
    curve = _numbers("curve", curve)
    valid = np.ones(curve.shape, bool) if valid is None else np.asarray(valid)
    if curve.ndim != 1 or valid.shape != curve.shape or valid.dtype != bool:
        raise ArgumentError(
            f"curve has shape {curve.shape} and valid {valid.shape}; pass one number (and one "
            "bool) a frame."
        )
    if not np.isfinite(curve[valid]).all():
        raise ArgumentError("curve holds values that are not finite; mark them as not valid.")
    return _find_period(curve, valid, search)[0]


def measure_gait(
    boxes, *, frame_rate, rhythm="step", periods=STEP_PERIODS, false_alarm=FALSE_ALARM
):
    """The rhythm of every walk in a box table.

    Parameters
    ----------
    boxes : pandas.DataFrame
        A box table.
    frame_rate, rhythm, periods, false_alarm
        As in `find_period`.

    Returns
    -------
    pandas.DataFrame
        Indexed by sequence: ``step_s, stride_s`` (0 where there is no rhythm), ``peak,
        rise, p_value, detectable`` as in `Period`, and ``swing``: by how much of its height
        the box swings about its mean width (√2 standard deviations: a sine's amplitude).

    Raises
    ------
    TableError, ArgumentError
        When the table is not sound or an option is out of range.
    """
    search = _check_options(frame_rate, rhythm, periods, false_alarm)
    stack = columns.stack_sequences(boxes, (W, H))
    rows = []
    for valid, width, height, length in zip(
        stack.valid, stack.curves[W], stack.curves[H], stack.length, strict=True
    ):
        valid, width, height = valid[:length], width[:length], height[:length]
        curve = np.divide(width, height, out=np.zeros(length), where=valid)
        found, rest = _find_period(curve, valid, search)
        rows.append(
            {
                "step_s": found.step,
                "stride_s": found.stride,
                "peak": found.peak,
                "rise": found.rise,
                "p_value": found.p_value,
                "detectable": found.detectable,
                "swing": float(np.sqrt(2 * np.mean(rest[valid] ** 2))),
            }
        )
    return pd.DataFrame(rows, index=pd.Index(stack.names, name=SEQUENCE))


def rhythm_of(walk, *, frame_rate):
    """The autocorrelation of one walk's curve, and its period, to look at.

    Parameters
    ----------
    walk : pandas.DataFrame
        A box table of one walk.
    frame_rate : float
        Frames a second.

    Returns
    -------
    lags : ndarray, shape (n,)
        Seconds.
    correlation : ndarray, shape (n,)
        Of width over height, its trend taken out.
    period : Period

    Raises
    ------
    TableError, ArgumentError
        As in `measure_gait`, and when there is more than one walk.
    """
    search = _check_options(frame_rate, "step", STEP_PERIODS, FALSE_ALARM)
    stack = columns.stack_sequences(walk, (W, H))
    if len(stack.names) > 1:
        raise ArgumentError(f"walk holds {len(stack.names)} walks; pass the boxes of one.")
    valid = stack.valid[0]
    curve = np.divide(stack.curves[W][0], stack.curves[H][0], out=np.zeros(len(valid)), where=valid)
    period, rest = _find_period(curve, valid, search)
    lags = np.arange(len(valid) // 2) / frame_rate
    return lags, autocorrelation(rest, valid=valid)[: len(lags)], period


def find_events(frames, width, *, frame_rate, shortest=STEP_PERIODS[0]):
    """Heel strikes and mid-swings: the peaks and troughs of a box's width (Figure 2.2).

    Parameters
    ----------
    frames : array_like, shape (n,)
        Frame numbers, whole and rising; frames between are filled in by a straight line.
    width : array_like, shape (n,)
        Box width, or width over height.
    frame_rate : float
        Frames a second.
    shortest : float, optional
        The shortest step, s: like events are at least so far apart.

    Returns
    -------
    Events
        An event stands out by half a standard deviation of the curve about its trend.  In
        a frontal view they are noise; `find_period` says whether to believe them.

    Raises
    ------
    ArgumentError
        When the curve has fewer than three frames, or values that are not finite, or an
        option is out of range.
    """
    frame_rate = require_number("frame_rate", frame_rate, above=0, unit="frames a second")
    shortest = require_number("shortest", shortest, above=0, unit="s")
    frames, width = _numbers("frames", frames), _numbers("width", width)
    if frames.ndim != 1 or frames.shape != width.shape or len(frames) < 3:
        raise ArgumentError(
            f"frames has shape {frames.shape} and width {width.shape}; pass one width a frame, "
            "three frames or more."
        )
    if not (np.isfinite(frames).all() and np.isfinite(width).all()):
        raise ArgumentError("frames or width hold values that are not finite; drop those frames.")
    if (np.diff(frames) <= 0).any() or (frames != np.round(frames)).any():
        raise ArgumentError("frames must be whole numbers that rise; sort and drop repeated ones.")
    if frames[-1] - frames[0] > 10_000 + 20 * len(frames):
        raise ArgumentError("frames span far more than there are widths; number them 1, 2, 3, …")
    every = np.arange(frames[0], frames[-1] + 1)
    curve = np.interp(every, frames, width)
    rest = _detrend(curve, np.ones(len(curve), bool))
    if not rest.any():
        return Events(every[:0].astype(int), every[:0].astype(int))
    peaks, troughs = find_extrema(
        curve, prominence=EVENT_RISE * rest.std(), spacing=max(1.0, shortest * frame_rate)
    )
    return Events(every[peaks].astype(int), every[troughs].astype(int))


def view_angle(heading):
    """The angle σ between a walk and the camera's line of sight.

    Parameters
    ----------
    heading : array_like
        Degrees clockwise from "away".

    Returns
    -------
    ndarray or float
        Degrees, 0 (frontal or from behind) … 90 (square-on).
    """
    heading = _numbers("heading", heading)
    if not np.isfinite(heading).all():
        raise ArgumentError("heading holds values that are not finite numbers; pass degrees.")
    return np.abs((heading + 90) % 180 - 90)[()]


def view_angle_of(direction):
    """The view angle σ of one of the eight directions, degrees: 0, 45 or 90."""
    if np.ndim(direction) != 0:
        raise ArgumentError(f"direction is {direction!r}; pass one at a time, 1 to 8.")
    return float(view_angle(direction_heading(direction)))


def record_at_angles(
    angles, *, subjects=8, seed=0, noises=(None,), distance=6.5, n_frames=60, view=None
):
    """Synthetic walkers filmed from several view angles, and the truth about their steps.

    Each person walks at each angle twice: once going, to one side, once coming, to the
    other; each walk begins at another moment of the gait cycle.

    Parameters
    ----------
    angles : sequence of float
        View angles σ in mid-walk, degrees, 0 … 90; square-on and close by they differ by
        some 15° from one end of a walk to the middle.
    subjects : int, optional
        People.
    seed : int, optional
        Of the people and of the noise.
    noises : sequence of SegmentationNoise or None, optional
        The same walks are measured once through each.
    distance : float, optional
        Metres ahead of the camera in mid-walk.
    n_frames : int, optional
        At most so many frames, 25 a second, as far as the body is wholly in view.
    view : View, optional
        Default: one like CASIA A's.

    Returns
    -------
    tables : list of pandas.DataFrame
        One box table a noise.  A walk in which the noise left no walker is not in it.
    truth : pandas.DataFrame
        Indexed by sequence, every walk: ``subject, angle, heading, step_s``.

    Raises
    ------
    ArgumentError
        When an angle is out of range, there is none, or a noise hides every walker.
    """
    try:
        angles, noises = list(angles), list(noises)
    except TypeError as fault:
        raise ArgumentError(f"angles or noises: {fault}; pass a list of each.") from fault
    angles = [require_number("angles", angle, low=0, high=90, unit="degrees") for angle in angles]
    if not angles or len(set(angles)) != len(angles) or not noises:
        raise ArgumentError("angles or noises are empty or repeat; pass each angle once.")
    if view is not None and not isinstance(view, View):
        raise ArgumentError(f"view is {view!r}; pass a View.")
    subjects = require_count("subjects", subjects, low=1)
    seed = require_count("seed", seed)
    ways = [(angle, turned) for angle in angles for turned in (angle, angle - 180)]
    tables, rows = [[] for _ in noises], []
    for number in range(1, subjects + 1):
        person = draw_body(np.random.default_rng([seed, number]))
        side = 1 if number % 2 else -1
        for angle, turned in ways:
            heading = side * turned % 360
            # One walk at a time: all the masks together would fill the memory.
            rng = np.random.default_rng([seed, number, len(rows)])
            walk = make_walk(
                replace(person, phase=float(rng.uniform())),
                heading=heading,
                view=view,
                distance=distance,
                max_frames=n_frames,
                name=f"s{number:02d}-{len(rows):04d}",
                subject=f"s{number:02d}",
            )
            for table, noise in zip(tables, noises, strict=True):
                masks = walk.masks
                if noise is not None:
                    masks = add_noise(masks, noise, seed=seed + len(rows))
                try:
                    boxes = measure_sequence(masks, sequence=walk.name, subject=walk.subject)
                except SilhouetteError:
                    continue  # detectability counts it as not detected
                table.append(boxes)
            rows.append((walk.name, walk.subject, angle, heading, 1 / person.cadence))
    if not all(tables):
        raise ArgumentError("noises: one hides every walker; turn it down.")
    truth = pd.DataFrame(rows, columns=[SEQUENCE, "subject", "angle", "heading", "step_s"])
    return [pd.concat(table, ignore_index=True) for table in tables], truth.set_index(SEQUENCE)


def detectability(gait, angles, *, steps=None, tolerance=0.1):
    """How well steps show at each view angle.

    Parameters
    ----------
    gait : pandas.DataFrame
        From `measure_gait`.
    angles : pandas.Series
        View angle σ, degrees, indexed by sequence.  A walk that `gait` lacks could not be
        measured: it counts as not detected, with a peak and a swing of 0.
    steps : pandas.Series, optional
        The true step periods, s, indexed by sequence.
    tolerance : float, optional
        A period is right when it is off by no more than this share.

    Returns
    -------
    pandas.DataFrame
        One row an angle, rising: ``angle, walks, detected`` (counts), ``share``, median
        ``peak`` with quartiles ``peak_low, peak_high``, median ``swing``; with `steps` also
        ``right`` (count detected and right) and ``right_share``.  Without, ``step_s``: the
        median period of the walks detected, 0 if none is.

    Raises
    ------
    TableError, ArgumentError
        When `gait` lacks a column, a walk has no angle or no true period, or a value is
        out of range.
    """
    names = ("step_s", "peak", "swing", "detectable")
    columns.check_columns(gait, names, argument="gait")
    if not gait.index.is_unique:
        raise TableError("gait names a sequence twice; pass a table from measure_gait.")
    tolerance = require_number("tolerance", tolerance, low=0)
    angles = _check_series("angles", angles, gait.index, low=0, high=90)
    table = gait[list(names)].astype(float).reindex(angles.index, fill_value=0.0)
    detected = table["detectable"].to_numpy(bool)
    table = table.assign(angle=angles.astype(float), detected=detected)
    groups = table.groupby("angle")
    out = groups["detected"].agg(walks="size", detected="sum", share="mean")
    out["peak"] = groups["peak"].median()
    out["peak_low"] = groups["peak"].quantile(0.25)
    out["peak_high"] = groups["peak"].quantile(0.75)
    out["swing"] = groups["swing"].median()
    if steps is None:
        medians = table[detected].groupby("angle")["step_s"].median()
        out["step_s"] = medians.reindex(out.index, fill_value=0.0)
    else:
        true = _check_series("steps", steps, angles.index, above=0)[angles.index].to_numpy(float)
        table["right"] = detected & (np.abs(table["step_s"] - true) <= tolerance * true)
        out[["right", "right_share"]] = table.groupby("angle")["right"].agg(["sum", "mean"])
    return out.reset_index()


def half_peak_angle(table):
    """From square-on towards frontal, the angle at which half the peak is lost.

    Parameters
    ----------
    table : pandas.DataFrame
        From `detectability`: ``angle, peak``, two angles or more.

    Returns
    -------
    float
        Degrees, by a straight line between the angles around it.

    Raises
    ------
    TableError, ArgumentError
        When a column is missing or holds a value that is not a finite number, or the peak
        at the largest angle is not positive or does not fall to its half.
    """
    columns.check_columns(table, ("angle", "peak"), argument="table")
    text = [name for name in ("angle", "peak") if not is_numeric_dtype(table[name])]
    if text:
        raise TableError(f"table holds text or objects in {', '.join(text)}; pass numbers.")
    values = table[["angle", "peak"]].to_numpy(float)
    if not np.isfinite(values).all():
        row = int(np.flatnonzero(~np.isfinite(values).all(axis=1))[0])
        raise TableError(f"table row {row} has an angle or a peak that is not finite; drop it.")
    angle, peak = values[np.argsort(values[:, 0], kind="stable")].T
    below = np.flatnonzero(peak <= peak[-1] / 2) if len(peak) and peak[-1] > 0 else []
    if len(below) == 0:
        raise ArgumentError(
            "table: the peak is nowhere half of that at the largest angle; add angles that are "
            "nearer to frontal, and a square-on one."
        )
    around = slice(below[-1], below[-1] + 2)
    return float(np.interp(peak[-1] / 2, peak[around], angle[around]))


class _Search(NamedTuple):
    """What `_check_options` makes of the options."""

    first: int  # least and greatest lag, frames
    last: int
    unit: float  # frames a second, times the steps in a lag
    false_alarm: float


def _check_options(frame_rate, rhythm, periods, false_alarm):
    frame_rate = require_number("frame_rate", frame_rate, above=0, unit="frames a second")
    false_alarm = require_number("false_alarm", false_alarm, above=0, high=0.5)
    if not isinstance(periods, tuple | list) or len(periods) != 2:
        raise ArgumentError(f"periods is {periods!r}; pass (shortest, longest) in seconds.")
    shortest = require_number("periods' shortest", periods[0], above=0, unit="s")
    longest = require_number("periods' longest", periods[1], above=shortest, unit="s")
    unit = frame_rate * (1 + RHYTHMS.index(require_choice("rhythm", rhythm, RHYTHMS)))
    first, last = (round(seconds * unit, 9) for seconds in (shortest, longest))
    first, last = int(np.ceil(first)), int(np.floor(last))
    # Two frames a step are the least that can show a peak and a trough.
    if first < 2 or last <= first:
        raise ArgumentError(
            f"frame_rate is {frame_rate:g}: steps of {shortest:g} to {longest:g} s are too few "
            "frames to show; film faster or look for longer periods."
        )
    if last > columns.FRAME_LIMIT:
        raise ArgumentError(f"periods' longest is {longest:g} s, beyond any walk; pass seconds.")
    return _Search(first, last, unit, false_alarm)


def _find_period(curve, valid, search):
    """`find_period` of what was checked before, and the curve without its trend."""
    none = Period(0.0, 0.0, 0.0, 1.0, False)
    curve = np.where(valid, curve, 0.0)
    scale = np.abs(curve).max(initial=0.0)
    if scale == 0 or valid.sum() < LEAST_FRAMES:
        return none, np.zeros(len(curve))
    rest = _detrend(curve / scale, valid)
    first, last = search.first, search.last
    # A lag beyond half the walk has too few partners to speak of repetition.
    last = min(last, int(valid.sum()) // 2)
    if np.abs(rest).max() < _FLAT or last <= first:
        return none, rest * scale
    r = _autocorrelate(rest[None], valid)[:, : last + 2]
    lag, peak, rise = (float(values[0]) for values in _highest_peak(r, first, last))
    if lag == 0:
        return none, rest * scale
    memory = _memory(float(r[0, 1]), int(valid.sum()))
    null = _null_rises(valid.tobytes(), memory, first, last)
    reached = len(null) - int(np.searchsorted(null, rise))
    p_value = (1 + reached) / (1 + len(null))
    found = Period(lag / search.unit, peak, rise, p_value, p_value <= search.false_alarm)
    return found, rest * scale


def _memory(first, count):
    """φ of noise whose autocorrelation at lag 1, after the trend is gone, is `first`."""
    # Taking out a trend of k coefficients lowers it by (k + (k + 2)·φ)/n on average: for
    # k = 1, the mean, that is the (1 + 3φ)/n of Kendall (1954).
    k = TREND_DEGREE + 1
    memory = (first * count + k) / (count - k - 2)
    return _MEMORY_STEP * round(float(np.clip(memory, *_MEMORY_LIMITS)) / _MEMORY_STEP)


def _detrend(curves, valid):
    """Curves, shape (..., n), without the parabola through what is valid, and 0 elsewhere."""
    basis = np.vander(np.linspace(-1, 1, len(valid)), TREND_DEGREE + 1) * valid[:, None]
    basis, _ = np.linalg.qr(basis)
    return np.where(valid, curves - (curves * valid) @ basis @ basis.T, 0.0)


def _autocorrelate(curves, valid):
    """`autocorrelation` of curves within −1 … 1 that are 0 where not valid."""
    n = curves.shape[-1]
    size = next_fast_len(2 * n, real=True)  # so that the end does not meet the beginning
    spectrum, power, mask = (
        rfft(values, size) for values in (curves, curves**2, valid.astype(float))
    )

    def lagged(earlier, later):
        return irfft(np.conj(earlier) * later, size)[..., :n]

    # Each lag is normalised by the power of just those values that meet there.
    power = np.maximum(lagged(power, mask), 0) * np.maximum(lagged(mask, power), 0)
    total = (curves**2).sum(axis=-1, keepdims=True)
    sound = power > (1e-12 * total) ** 2  # below that, rounding in the transform
    return np.clip(
        np.divide(
            lagged(spectrum, spectrum), np.sqrt(power), out=np.zeros(power.shape), where=sound
        ),
        -1.0,
        1.0,
    )


def _highest_peak(r, first, last):
    """The highest local maximum of each autocorrelation at lags first … last.

    Parameters
    ----------
    r : ndarray, shape (m, last + 2)

    Returns
    -------
    lag, peak, rise : ndarray, shape (m,)
        Frames (0 where there is no local maximum), the value there, and how far that is
        above the value at half the lag.
    """
    before, here, after = (r[:, first + shift : last + 1 + shift] for shift in (-1, 0, 1))
    top = np.where((here >= before) & (here > after), here, -np.inf)
    row = np.arange(len(r))
    best = top.argmax(axis=1)
    whole, found = best + first, np.isfinite(top[row, best])
    before, here, after = before[row, best], here[row, best], after[row, best]
    bend = np.where(found, 2 * here - before - after, 1.0)
    shift = np.where(found, (after - before) / (2 * bend), 0.0)
    # At half a lag between two frames, the mean of both.
    half = (r[row, whole // 2] + r[row, (whole + 1) // 2]) / 2
    return (
        np.where(found, whole + shift, 0.0),
        np.where(found, np.minimum(here + (after - before) * shift / 4, 1.0), 0.0),
        np.where(found, here - half, 0.0),
    )


@lru_cache(maxsize=1024)
def _null_rises(valid, memory, first, last):
    """Rises of simulated curves without rhythm, sorted; seeded, so always the same."""
    valid = np.frombuffer(valid, dtype=bool)
    white = _white_noise(len(valid))
    rises = []
    for part in np.array_split(white, 1 + white.size // _BLOCK):
        noise = lfilter([1.0], [1.0, -memory], part, axis=-1)[:, _SETTLE:]
        r = _autocorrelate(_detrend(noise, valid), valid)
        rises.append(_highest_peak(r, first, last)[2])
    return np.sort(np.concatenate(rises))


def _white_noise(length):
    """Normal noise, shape (_DRAWS, _SETTLE + length): the beginning of one long table."""
    longest = 64 * -(-length // 64)
    return _draw_noise(longest)[:, : _SETTLE + length]


@lru_cache(maxsize=4)
def _draw_noise(length):
    return np.random.default_rng(0).normal(size=(_DRAWS, _SETTLE + length))


def _numbers(name, values):
    """`values` as an array of floats, or `ArgumentError`."""
    try:
        values = np.asarray(values)
        if values.dtype.kind in "biufO":
            return values.astype(float)
    except (TypeError, ValueError):
        pass
    raise ArgumentError(f"{name} holds text or objects; pass finite real numbers.")


def _check_series(name, series, wanted, **bounds):
    """`series` when it gives each sequence of `wanted` one number within bounds."""
    if not isinstance(series, pd.Series) or not series.index.is_unique or series.empty:
        raise ArgumentError(f"{name} must be a pandas Series, one number a sequence.")
    missing = [sequence for sequence in wanted if sequence not in series.index]
    if missing:
        raise TableError(f"{name} lacks sequence(s) {', '.join(map(str, missing[:5]))}; add them.")
    for value in series.unique():
        require_number(name, value, **bounds)
    return series
