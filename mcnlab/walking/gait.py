"""The rhythm of the steps in a walker's box.

Seen from the side a box widens as the legs part (heel strike) and narrows as they cross
(mid-swing), once a step; seen from the front it hardly changes (thesis sections 2.1 and
2.2, Figures 2.1 and 2.2).  Here the step's period is found by autocorrelation, and a test
says whether there is a rhythm at all.

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

from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy.fft import irfft, next_fast_len, rfft
from scipy.signal import lfilter

from mcnlab import tables
from mcnlab.checks import require_all, require_array, require_choice, require_number
from mcnlab.errors import ArgumentError
from mcnlab.tables import SEQUENCE, H, W
from mcnlab.walking.phase import find_extrema

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
    def stride(self) -> float:
        """Seconds from a heel strike to the next one of the same foot: two steps."""
        return 2 * self.step


class Events(NamedTuple):
    """Two moments of the gait cycle, as frame numbers."""

    heel_strikes: np.ndarray  # the legs are farthest apart
    mid_swings: np.ndarray  # the legs cross


def autocorrelation(curve: ArrayLike, *, valid: ArrayLike | None = None) -> np.ndarray:
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
    curve, valid = _check_curve(curve, valid, (..., None))
    if curve.shape[-1] == 0:
        raise ArgumentError(f"curve has the shape {curve.shape}; pass at least one value.")
    # Between −1 and 1 squares neither overflow nor vanish.
    scale = np.abs(curve).max(axis=-1, keepdims=True)
    return _autocorrelate(curve / np.where(scale > 0, scale, 1.0), valid)


def find_period(
    curve: ArrayLike,
    *,
    frame_rate: float,
    valid: ArrayLike | None = None,
    rhythm: str = "step",
    periods: tuple[float, float] = STEP_PERIODS,
    false_alarm: float = FALSE_ALARM,
) -> Period:
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
    alarms, as memory alone lifts both.  A step shorter than half of the longest looked for
    repeats twice within `periods`; where it falls between two frames and its double on one,
    the double may be found.
    """
    search = _check_options(frame_rate, rhythm, periods, false_alarm)
    curve, valid = _check_curve(curve, valid, (None,))
    return _find_period(curve, valid, search)[0]


def measure_gait(
    boxes: pd.DataFrame,
    *,
    frame_rate: float,
    rhythm: str = "step",
    periods: tuple[float, float] = STEP_PERIODS,
    false_alarm: float = FALSE_ALARM,
) -> pd.DataFrame:
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

    Examples
    --------
    >>> from mcnlab import vision, walking
    >>> boxes = vision.casia_a().boxes
    >>> walk = boxes[boxes["sequence"] == "fyc-00_1"]
    >>> gait = walking.measure_gait(walk, frame_rate=25).reset_index()
    >>> gait[["sequence", "step_s", "detectable"]].round(2)
       sequence  step_s  detectable
    0  fyc-00_1    0.52        True
    """
    search = _check_options(frame_rate, rhythm, periods, false_alarm)
    stack = tables.stack_sequences(boxes, (W, H))
    rows = []
    for at, curve in enumerate(_width_over_height(stack)):
        length = stack.length[at]
        valid = stack.valid[at, :length]
        found, rest = _find_period(curve[:length], valid, search)
        swing = float(np.sqrt(2 * np.mean(rest[valid] ** 2)))
        rows.append((found.step, found.stride, *found[1:], swing))
    columns = ["step_s", "stride_s", *Period._fields[1:], "swing"]
    return pd.DataFrame(rows, pd.Index(stack.names, name=SEQUENCE), columns)


def rhythm_of(walk: pd.DataFrame, *, frame_rate: float) -> tuple[np.ndarray, np.ndarray, Period]:
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
    stack = tables.stack_sequences(walk, (W, H))
    if len(stack.names) > 1:
        raise ArgumentError(f"walk holds {len(stack.names)} walks; pass the boxes of one.")
    valid = stack.valid[0]
    period, rest = _find_period(_width_over_height(stack)[0], valid, search)
    lags = np.arange(len(valid) // 2) / frame_rate
    return lags, autocorrelation(rest, valid=valid)[: len(lags)], period


def find_events(
    frames: ArrayLike, width: ArrayLike, *, frame_rate: float, shortest: float = STEP_PERIODS[0]
) -> Events:
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
    limit, remedy = tables.FRAME_LIMIT, "three frames or more: finite whole numbers that rise"
    frames = require_array(
        "frames", frames, (None,), dtype=int, low=-limit, high=limit, least=3, remedy=remedy
    )
    width = require_array("width", width, frames.shape)
    require_all("frames", frames[1:], np.diff(frames) > 0, "sort them, so that they rise")
    if frames[-1] - frames[0] > 10_000 + 20 * len(frames):
        raise ArgumentError("frames span far more than there are widths; number them 1, 2, 3, …")
    every = np.arange(frames[0], frames[-1] + 1)
    curve = np.interp(every, frames, width)
    rest = _detrend(curve, np.ones(len(curve), bool))
    if not rest.any():
        return Events(every[:0], every[:0])
    peaks, troughs = find_extrema(
        curve, prominence=EVENT_RISE * rest.std(), spacing=max(1.0, shortest * frame_rate)
    )
    return Events(every[peaks], every[troughs])


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
    if last > tables.FRAME_LIMIT:
        raise ArgumentError(f"periods' longest is {longest:g} s, beyond any walk; pass seconds.")
    return _Search(first, last, unit, false_alarm)


def _check_curve(curve, valid, shape):
    """The curve, 0 where it is not valid, and the flags of where it is."""
    curve = require_array("curve", curve, shape, finite=False)
    valid = np.ones(curve.shape[-1], bool) if valid is None else np.asarray(valid)
    if valid.dtype != bool or valid.shape not in (curve.shape, curve.shape[-1:]):
        raise ArgumentError(
            f"valid is {valid.dtype} of shape {valid.shape}; pass one bool a value of curve."
        )
    remedy = "finite numbers, or mark the others as not valid"
    return require_array("curve", np.where(valid, curve, 0.0), remedy=remedy), valid


def _width_over_height(stack):
    """The walks' curves, shape (walks, frames), 0 where there is no box."""
    empty = np.zeros(stack.valid.shape)
    return np.divide(stack.curves[W], stack.curves[H], out=empty, where=stack.valid)


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
    held = (curves, curves**2, valid.astype(float))
    spectrum, power, mask = (rfft(values, size) for values in held)

    def lagged(earlier, later):
        return irfft(np.conj(earlier) * later, size)[..., :n]

    # Each lag is normalised by the power of just those values that meet there.
    power = np.maximum(lagged(power, mask), 0) * np.maximum(lagged(mask, power), 0)
    total = (curves**2).sum(axis=-1, keepdims=True)
    sound = power > (1e-12 * total) ** 2  # below that, rounding in the transform
    meeting = lagged(spectrum, spectrum)
    like = np.divide(meeting, np.sqrt(power), out=np.zeros(power.shape), where=sound)
    return np.clip(like, -1.0, 1.0)


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
    # The beginning of one long table, which walks of about one length share.
    white = _draw_noise(64 * -(-len(valid) // 64))[:, : _SETTLE + len(valid)]
    rises = []
    for part in np.array_split(white, 1 + white.size // _BLOCK):
        noise = lfilter([1.0], [1.0, -memory], part, axis=-1)[:, _SETTLE:]
        r = _autocorrelate(_detrend(noise, valid), valid)
        rises.append(_highest_peak(r, first, last)[2])
    return np.sort(np.concatenate(rises))


@lru_cache(maxsize=4)
def _draw_noise(length):
    """White noise, shape (_DRAWS, _SETTLE + length)."""
    return np.random.default_rng(0).normal(size=(_DRAWS, _SETTLE + length))
