"""The thesis's phase of a walk: the slope of a box's height or width over time.

Section 3.2.1 (c) and (d): curve → extrema → soft extrema dropped → envelope → mean line.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy.signal import find_peaks

from mcnlab import tables
from mcnlab.checks import require_all, require_array, require_choice, require_number
from mcnlab.errors import ArgumentError
from mcnlab.regression import Line, fit_line, fit_lines_robust
from mcnlab.tables import FRAME, SEQUENCE, H, W

PROMINENCE = 1.0  # pixels: the least rise that makes an extremum; the thesis gives none
SPACING = 5  # frames between like extrema, under half a step at 25 frames a second
SOFT_RULES = ("line", "keep")


@dataclass(frozen=True)
class Phase:
    """What the thesis draws over one curve.

    Attributes
    ----------
    frames, curve : ndarray, shape (n,)
        Frame numbers and the dimension, pixels.
    maxima, minima : ndarray of int
        Positions of the extrema that are kept.
    soft : ndarray of int
        Positions of the soft extrema that were dropped.
    trend : Line
        Regression over the whole curve, by which extrema are soft or not.
    upper, lower : Line
        The envelope: regressions over the maxima and over the minima.
    mean : Line
        The phase: the line midway between the two.
    complete : bool
        False where fewer than two maxima or minima were left, so that the trend stands
        in for the missing side of the envelope (the thesis does not say what then).
    """

    frames: np.ndarray
    curve: np.ndarray
    maxima: np.ndarray
    minima: np.ndarray
    soft: np.ndarray
    trend: Line
    upper: Line
    lower: Line
    mean: Line
    complete: bool


def find_extrema(
    curve: ArrayLike, *, prominence: float = PROMINENCE, spacing: float = SPACING
) -> tuple[np.ndarray, np.ndarray]:
    """Positions of the maxima and the minima of a curve.

    Parameters
    ----------
    curve : array_like, shape (n,)
    prominence : float, optional
        The least height of an extremum over its surroundings, in the curve's unit.
    spacing : float, optional
        The least distance between two maxima or two minima, samples.

    Returns
    -------
    maxima, minima : ndarray of int
        A plateau counts once, at its middle.

    Raises
    ------
    ArgumentError
        When the curve is not a finite sequence, or a threshold is out of range.
    """
    curve = require_array("curve", curve, (None,))
    prominence = require_number("prominence", prominence, low=0, unit="pixels")
    spacing = require_number("spacing", spacing, low=1, unit="frames")
    # find_peaks needs a prominence above zero to leave plateaus of the whole curve out.
    options = {"prominence": max(prominence, 1e-9), "distance": spacing}
    return find_peaks(curve, **options)[0], find_peaks(-curve, **options)[0]


def find_soft(
    frames: np.ndarray, curve: np.ndarray, maxima: np.ndarray, minima: np.ndarray, trend: Line
) -> tuple[np.ndarray, np.ndarray]:
    """Which extrema are soft: a maximum below the trend line, a minimum above it.

    Parameters
    ----------
    frames, curve : ndarray, shape (n,)
    maxima, minima : ndarray of int
        Positions, from `find_extrema`.
    trend : Line
        Through the whole curve.

    Returns
    -------
    soft_maxima, soft_minima : ndarray of bool
        One flag an extremum (thesis 3.2.1 (c), Figure 3.9).
    """
    line = trend.at(frames)
    return curve[maxima] < line[maxima], curve[minima] > line[minima]


def measure_phase(
    frames: ArrayLike,
    curve: ArrayLike,
    *,
    prominence: float = PROMINENCE,
    spacing: float = SPACING,
    soft_rule: str = "line",
) -> Phase:
    """The phase of one curve, as the thesis finds it.

    Parameters
    ----------
    frames : array_like, shape (n,)
        Frame numbers, rising.
    curve : array_like, shape (n,)
        Box height or width, pixels.
    prominence, spacing : optional
        As in `find_extrema`.
    soft_rule : {"line", "keep"}, optional
        Drop the soft extrema by the trend line, as the thesis does, or keep all.

    Returns
    -------
    Phase

    Raises
    ------
    ArgumentError
        When there are fewer than three frames, or an argument is out of range.
    """
    remedy = "three frames or more, finite and rising"
    frames = require_array("frames", frames, (None,), least=3, remedy=remedy)
    curve = require_array("curve", curve, frames.shape)
    require_all("frames", frames[1:], np.diff(frames) > 0, "sort them and drop repeated ones")
    require_choice("soft_rule", soft_rule, SOFT_RULES)
    maxima, minima = find_extrema(curve, prominence=prominence, spacing=spacing)
    trend = fit_line(frames, curve)
    soft = np.zeros(0, int)
    if soft_rule == "line":
        soft_maxima, soft_minima = find_soft(frames, curve, maxima, minima, trend)
        soft = np.sort(np.r_[maxima[soft_maxima], minima[soft_minima]])
        maxima, minima = maxima[~soft_maxima], minima[~soft_minima]
    upper, lower = (
        fit_line(frames[at], curve[at]) if len(at) >= 2 else trend for at in (maxima, minima)
    )
    mean = Line((upper.slope + lower.slope) / 2, (upper.intercept + lower.intercept) / 2)
    complete = len(maxima) >= 2 and len(minima) >= 2
    return Phase(frames, curve, maxima, minima, soft, trend, upper, lower, mean, complete)


def measure_phases(
    boxes: pd.DataFrame,
    *,
    prominence: float = PROMINENCE,
    spacing: float = SPACING,
    soft_rule: str = "line",
    dimensions: Iterable[str] = (H, W),
) -> pd.DataFrame:
    """The thesis's phases of every walk.

    Parameters
    ----------
    boxes : pandas.DataFrame
        A box table.
    prominence, spacing, soft_rule : optional
        As in `measure_phase`.
    dimensions : iterable of {"h", "w"}, optional
        Which curves.

    Returns
    -------
    pandas.DataFrame
        Indexed by sequence: ``m_h, c_h, m_w, c_w`` (slopes in pixels a frame, intercepts
        in pixels) and ``complete_h, complete_w``.

    Raises
    ------
    TableError, ArgumentError
        When the table is not sound, or a walk has fewer than three frames.

    Examples
    --------
    >>> from mcnlab import vision, walking
    >>> boxes = vision.casia_a().boxes
    >>> walk = boxes[boxes["sequence"] == "fyc-00_1"]
    >>> walking.measure_phases(walk)[["m_h", "m_w"]].reset_index().round(2)
       sequence   m_h   m_w
    0  fyc-00_1 -0.04 -0.01
    """
    tables.check_boxes(boxes)
    frames = boxes[FRAME].to_numpy(float)
    curves = {
        require_choice("dimensions", key, (H, W)): boxes[key].to_numpy(float) for key in dimensions
    }
    find_phase = partial(measure_phase, prominence=prominence, spacing=spacing, soft_rule=soft_rule)
    rows, names = [], []
    for name, at in tables.split_sequences(boxes):
        if at.stop - at.start < 3:
            raise ArgumentError(
                f"boxes: sequence {name!r} has {at.stop - at.start} frame(s); a phase needs three."
            )
        row = {}
        for key, curve in curves.items():
            phase = find_phase(frames[at], curve[at])
            row[f"m_{key}"], row[f"c_{key}"] = phase.mean
            row[f"complete_{key}"] = phase.complete
        rows.append(row)
        names.append(name)
    return pd.DataFrame(rows, index=pd.Index(names, name=SEQUENCE))


def relative_growth(
    time: ArrayLike, curve: ArrayLike, *, weights: ArrayLike | None = None
) -> np.ndarray:
    """How fast a curve grows, as a share of itself: d(log curve)/dt.

    Twice as near, a walker is twice as tall in the image and grows twice as fast in
    pixels; the share is the same when the scene is scaled.  That is the distance
    invariance which section 3.2.1 claims for the raw slope.

    Parameters
    ----------
    time : array_like, shape (n,)
        Seconds.
    curve : array_like, shape (..., n)
        Positive values, pixels.
    weights : array_like, shape (..., n), optional
        0 leaves a frame out.

    Returns
    -------
    ndarray, shape (...)
        1/s; 0.1 means 10 % taller each second.

    Raises
    ------
    ArgumentError
        When a value is not positive, or a curve does not span time.

    Notes
    -----
    A robust line through log(curve).  A pixel of noise in the curve is 1/curve in its
    logarithm, so frames are weighed by curve².
    """
    curve = require_array("curve", curve, above=0)
    weights = np.ones(curve.shape) if weights is None else np.asarray(weights, dtype=float)
    line, _ = fit_lines_robust(time, np.log(curve), weights=weights * curve**2)
    return line.slope
