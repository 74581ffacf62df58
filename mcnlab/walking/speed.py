"""Apparent speed in three levels (thesis section 3.2.2).

p is the displacement of a walker's centroid in f frames, one second, in pixels: level v1
up to 1 % of the frame's width, v2 up to 5 %, v3 above.  The thesis's middle line is garbled;
1 % < p ≤ 5 % is meant, the only reading that leaves no gap.

p tells of the place as much as of the pace; `level_like` holds it against true speed.
"""

from collections.abc import Iterable

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mcnlab.checks import require_array, require_count, require_labels, require_number
from mcnlab.datasets.recording import Recording
from mcnlab.errors import ArgumentError, DatasetError
from mcnlab.regression import fit_lines_robust
from mcnlab.statistics import Estimate, draw_people, interval_of
from mcnlab.tables import CX, CY, FRAME, PRESENT, SEQUENCE, uncut
from mcnlab.walking.heading import measure_headings
from mcnlab.walking.truth import true_motion

LEVELS = (1, 2, 3)
NAMES = {1: "v1", 2: "v2", 3: "v3"}
SLOW, FAST = 0.01, 0.05  # shares of the frame's width: v1 up to the one, v2 up to the other
SECONDS = 1.0  # the thesis's f frames
MOST_FRAMES = 1e9  # no recording is longer


def frames_of(seconds: float, frame_rate: float) -> int:
    """The thesis's f: how many frames a window of `seconds` has.

    Parameters
    ----------
    seconds : float
    frame_rate : float
        Frames a second.

    Raises
    ------
    ArgumentError
        When a number is not positive or the window holds fewer than two frames.
    """
    seconds = require_number("seconds", seconds, above=0, unit="s")
    frame_rate = require_number("frame_rate", frame_rate, above=0, unit="frames a second")
    frames = round(min(seconds * frame_rate, MOST_FRAMES))
    if frames < 2:
        raise ArgumentError(
            f"seconds is {seconds:g}, {frames} frame(s) at {frame_rate:g} frames a second; a "
            f"displacement needs two: pass at least {2 / frame_rate:g}."
        )
    return frames


def displacement_of(
    recording: Recording, *, seconds: float = SECONDS, step: int | None = None
) -> pd.DataFrame:
    """The displacement p of every walker's centroid, window by window.

    A window is f frames.  p is the straight line between the centroids at its two ends.
    Where the box at an end is missing, the nearest one within the window stands for it, and
    p is scaled by the time between the two boxes: that is still a displacement, as the
    thesis has it, and needs no frame in particular.  (A least-squares line would use all
    boxes, but it measures another thing as soon as somebody turns.)

    Parameters
    ----------
    recording : Recording
    seconds : float, optional
        Length of a window; p is per second whatever it is.
    step : int, optional
        Frames from one window's start to the next.  Windows follow each other without
        overlap if not given.

    Returns
    -------
    pandas.DataFrame
        One row a window whose two boxes span at least 60 % of it: ``sequence, frame`` (the
        window's first), ``pixels`` (p, pixels a second), ``sideways`` (its part to the
        right, pixels a second).  Boxes at the frame's edge are not used, as in
        `tables.uncut`: half a walker has another centroid.

    Raises
    ------
    McnError
        When a number is out of range, or no track is long enough.
    """
    window = frames_of(seconds, recording.frame_rate)
    step = window if step is None else require_count("step", step, low=1)
    stack = recording.stack
    walk, start = _starts_of(stack.length, window, step)
    trusted = uncut(stack, recording.frame_width, recording.frame_height)
    column, beyond = np.arange(trusted.shape[1]), trusted.shape[1]
    ahead = np.where(trusted, column, beyond)
    ahead = np.minimum.accumulate(ahead[:, ::-1], axis=1)[:, ::-1]
    behind = np.maximum.accumulate(np.where(trusted, column, -1), axis=1)
    first, last = ahead[walk, start], behind[walk, start + window - 1]
    keep = (last > first) & (last - first + 1 >= PRESENT * window)
    if not keep.any():
        raise ArgumentError(
            f"seconds is {seconds:g}, {window} frames: no track of {recording.name} has two boxes "
            f"{PRESENT:.0%} of that apart; pass longer tracks or a shorter window."
        )
    walk, start, first, last = walk[keep], start[keep], first[keep], last[keep]
    time = (last - first) / recording.frame_rate
    right, down = (
        (curve[walk, last] - curve[walk, first]) / time
        for curve in (stack.curves[CX], stack.curves[CY])
    )
    return pd.DataFrame(
        {
            SEQUENCE: np.array(stack.names, dtype=object)[walk],
            FRAME: stack.start[walk] + start,
            "pixels": np.hypot(right, down),
            "sideways": right,
        }
    )


def _starts_of(length, window, step):
    """Which walk each window is from, and its first column."""
    count = np.maximum((length - window) // step + 1, 0)
    walk = np.repeat(np.arange(len(length)), count)
    place = np.arange(len(walk)) - np.repeat(np.cumsum(count) - count, count)
    return walk, place * step


def level_of(
    p: ArrayLike, *, frame_width: float, slow: float = SLOW, fast: float = FAST
) -> np.ndarray:
    """The speed level 1, 2 or 3 of a displacement (thesis section 3.2.2).

    Parameters
    ----------
    p : array_like
        Displacement in a second, pixels.
    frame_width : float
        Pixels.
    slow, fast : float, optional
        Shares of the frame's width; p ≤ slow·width is level 1, p ≤ fast·width level 2.

    Returns
    -------
    ndarray of int, shape of `p`

    Raises
    ------
    ArgumentError
        When p is negative or not finite, or the thresholds are out of order.
    """
    frame_width = require_number("frame_width", frame_width, above=0, unit="pixels")
    slow = require_number("slow", slow, low=0, unit="share of the frame's width")
    fast = require_number("fast", fast, low=0, unit="share of the frame's width")
    if fast < slow:
        raise ArgumentError(f"fast is {fast:g}, below slow, {slow:g}; pass fast ≥ slow.")
    p = require_array("p", p, low=0)
    return 1 + (p > slow * frame_width).astype(int) + (p > fast * frame_width)


def bin_speeds(
    recording: Recording,
    *,
    seconds: float = SECONDS,
    step: int | None = None,
    slow: float = SLOW,
    fast: float = FAST,
) -> pd.DataFrame:
    """Every window of every track with its level.

    Parameters
    ----------
    recording : Recording
    seconds, step
        As in `displacement_of`.
    slow, fast
        As in `level_of`.

    Returns
    -------
    pandas.DataFrame
        As of `displacement_of`, with ``share`` (p as a share of the frame's width) and
        ``level`` (1, 2, 3).

    Examples
    --------
    >>> from mcnlab import vision, walking
    >>> windows = walking.bin_speeds(vision.casia_a())
    >>> windows["level"].value_counts().sort_index().to_dict()
    {1: 1, 2: 136, 3: 541}
    """
    table = displacement_of(recording, seconds=seconds, step=step)
    level = level_of(table["pixels"], frame_width=recording.frame_width, slow=slow, fast=fast)
    return table.assign(share=table["pixels"] / recording.frame_width, level=level)


WALKING = 0.6  # m/s; who is slower lingers, and a ratio to his speed is noise
PASSING = 0.3  # m/s across the view, likewise


def compare_speeds(
    recording: Recording,
    world: pd.DataFrame,
    *,
    place: ArrayLike,
    focal_length: float,
    seconds: Iterable[float] = (SECONDS,),
) -> pd.DataFrame:
    """Apparent speed, speed in body heights and true speed, window by window.

    Parameters
    ----------
    recording : Recording
        Of one unmoved camera.
    world : pandas.DataFrame
        ``sequence, frame, world_x, world_y`` (metres).
    place : array_like, shape (2,) or (3,)
        Where the camera stands, metres: from a calibration or `find_place`.
    focal_length : float
        Pixels.
    seconds : sequence of float, optional
        Lengths of windows.

    Returns
    -------
    pandas.DataFrame
        One row a window whose true motion is known: ``seconds, sequence, frame``; ``pixels``
        and ``sideways`` (pixels a second; of these, across the view), ``share`` (of the frame's
        width); ``body_heights`` and ``body_heights_sideways`` (a second); ``true_speed`` and
        ``true_sideways`` (m/s); ``distance`` (of the feet from `place`, metres).
        "Sideways" is across the line of sight to the walker.

    Raises
    ------
    McnError
        When a number is out of range, or no window has a true motion.
    """
    remedy = "two or three finite numbers, world metres"
    camera = require_array("place", place, (None,), least=2, remedy=remedy)
    if len(camera) > 3:
        raise ArgumentError(f"place has {len(camera)} numbers; pass {remedy}.")
    height = camera[2] if len(camera) == 3 else 0.0
    tables = []
    for length in seconds:
        window = frames_of(length, recording.frame_rate)
        headings = measure_headings(
            recording, focal_length=focal_length, window=window, shared="recording"
        )
        table = headings.merge(displacement_of(recording, seconds=length), on=[SEQUENCE, FRAME])
        place, velocity = true_motion(world, table, window=window, frame_rate=recording.frame_rate)
        reach = place - camera[:2]
        ground = np.maximum(np.hypot(*reach.T), 1e-9)  # nobody stands in the camera
        across = np.abs(reach[:, 0] * velocity[:, 1] - reach[:, 1] * velocity[:, 0]) / ground
        turned = np.abs(np.sin(np.radians(table["sight"])))
        held = pd.DataFrame(
            {
                "seconds": float(length),
                **table[[SEQUENCE, FRAME, "pixels"]],
                "sideways": table["sideways"].abs(),
                "share": table["pixels"] / recording.frame_width,
                "body_heights": table["speed"],
                "body_heights_sideways": table["speed"] * turned,
                "true_speed": np.hypot(*velocity.T),
                "true_sideways": across,
                "distance": np.hypot(ground, height),
            }
        )
        tables.append(held[np.isfinite(place).all(axis=1)])
    table = pd.concat(tables, ignore_index=True)
    if table.empty:
        raise DatasetError("world has no two positions of anybody in one window; match the frames.")
    return table


def distance_slope(
    speed: ArrayLike,
    true_speed: ArrayLike,
    distance: ArrayLike,
    people: ArrayLike,
    *,
    least: float = WALKING,
    draws: int = 1000,
    seed: int = 0,
) -> Estimate | None:
    """How a measure of speed depends on distance: the slope of log(speed/true) on log distance.

    −1: the measure halves when the distance doubles; 0: it does not depend on distance.  The
    line is robust (`regression.fit_lines_robust`), the interval from drawing whole people.

    Parameters
    ----------
    speed, true_speed, distance : array_like, shape (n,)
        One of each a window.  Windows whose `speed` is 0 have no logarithm and are left out.
    people : array_like, shape (n,)
        Who walks in it.
    least : float, optional
        Windows of a lower true speed are left out.
    draws, seed : int, optional
        Of the bootstrap.

    Returns
    -------
    Estimate or None
        None where fewer than three windows, or windows at one distance only, are left.

    Raises
    ------
    ArgumentError
        When the arrays differ in length or hold values that are not finite.
    """
    speed, true_speed, distance, codes = _check_windows(
        people, speed=speed, true_speed=true_speed, distance=distance
    )
    least = require_number("least", least, low=0, unit="m/s")
    use = (speed > 0) & (true_speed > 0) & (true_speed >= least) & (distance > 0)
    x, y = np.log(distance[use]), np.log(speed[use] / true_speed[use])
    if len(x) < 3 or np.ptp(x) < 1e-9:
        return None
    names, codes = np.unique(codes[use], return_inverse=True)
    slope = float(fit_lines_robust(x, y)[0].slope)
    weights = draw_people(len(names), draws=draws, seed=seed)[:, codes]
    apart = np.where(weights > 0, x, -np.inf).max(axis=1)
    apart = apart - np.where(weights > 0, x, np.inf).min(axis=1)
    weights = weights[apart > 1e-9]  # who was drawn stood at two distances
    if len(names) < 2 or len(weights) == 0:
        return Estimate(slope, None, None, len(names))
    shape = weights.shape
    lines, _ = fit_lines_robust(
        np.broadcast_to(x, shape), np.broadcast_to(y, shape), weights=weights
    )
    return Estimate(slope, *interval_of(lines.slope), len(names))


def misordered(
    true_speed: ArrayLike,
    level: ArrayLike,
    people: ArrayLike,
    *,
    lower: int = 2,
    upper: int = 3,
    draws: int = 1000,
    seed: int = 0,
) -> Estimate | None:
    """How often a window of a lower level is truly faster than one of a higher level.

    Parameters
    ----------
    true_speed : array_like, shape (n,)
    level : array_like, shape (n,)
        1, 2, 3.
    people : array_like, shape (n,)
        Who walks in it; the interval draws whole people.
    lower, upper : int, optional
        The levels compared.
    draws, seed : int, optional
        Of the bootstrap.

    Returns
    -------
    Estimate or None
        The share of pairs in the wrong order (equals count half): 0 when the levels sort
        people by true speed, 0.5 when they say nothing of it.  None where a level is empty.
    """
    true_speed, level, codes = _check_windows(people, true_speed=true_speed, level=level)
    below, above = level == lower, level == upper
    if not below.any() or not above.any():
        return None
    count = codes.max() + 1
    gap = true_speed[below][:, None] - true_speed[above]
    pair = (codes[below][:, None] * count + codes[above]).ravel()
    wrong = np.bincount(pair, ((1 + np.sign(gap)) / 2).ravel(), minlength=count**2)
    total = np.bincount(pair, minlength=count**2)
    wrong, total = wrong.reshape(count, count), total.reshape(count, count)
    share = float(wrong.sum() / total.sum())
    names = len(np.unique(codes[below | above]))
    if min(len(np.unique(codes[side])) for side in (below, above)) < 2:
        return Estimate(share, None, None, names)  # one person a side shows no spread
    weights = draw_people(count, draws=draws, seed=seed)
    wrong, total = (((weights @ held) * weights).sum(axis=1) for held in (wrong, total))
    return Estimate(share, *interval_of(wrong[total > 0] / total[total > 0]), names)


def level_like(values: ArrayLike, level: ArrayLike) -> np.ndarray:
    """Levels by another measure, as many windows in each: who would be where.

    Parameters
    ----------
    values : array_like, shape (n,)
        The other measure; its lowest go to the lowest level.
    level : array_like, shape (n,)
        1, 2, 3.

    Returns
    -------
    ndarray of int, shape (n,)
    """
    level = require_labels("level", level)
    values = require_array("values", values, level.shape)
    found = np.empty_like(level)
    found[np.argsort(values, kind="stable")] = np.sort(level)
    return found


def _check_windows(people, **columns):
    """The columns as finite floats of one length, and the number of each one's person."""
    codes = np.unique(require_labels("people", people).astype(str), return_inverse=True)[1]
    held = [require_array(name, values, codes.shape, least=1) for name, values in columns.items()]
    return (*held, codes)
