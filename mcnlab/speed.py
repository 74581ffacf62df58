"""Apparent speed in three levels (thesis section 3.2.2).

p is the displacement of a walker's centroid in f frames, one second, in pixels: level v1
up to 1 % of the frame's width, v2 up to 5 %, v3 above.  The thesis's middle line is garbled;
1 % < p ≤ 5 % is meant, the only reading that leaves no gap.

p tells of the place as much as of the pace; `mcnlab.pace` holds it against true speed.
"""

import numpy as np
import pandas as pd

from mcnlab.checks import require_numbers
from mcnlab.columns import CX, CY, FRAME, SEQUENCE
from mcnlab.direction import PRESENT, uncut
from mcnlab.errors import ArgumentError, require_count, require_number

LEVELS = (1, 2, 3)
NAMES = {1: "v1", 2: "v2", 3: "v3"}
SLOW, FAST = 0.01, 0.05  # shares of the frame's width: v1 up to the one, v2 up to the other
SECONDS = 1.0  # the thesis's f frames
MOST_FRAMES = 1e9  # no recording is longer


def frames_of(seconds, frame_rate):
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


def displacement_of(recording, *, seconds=SECONDS, step=None):
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
        `direction.uncut`: half a walker has another centroid.

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


def level_of(p, *, frame_width, slow=SLOW, fast=FAST):
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
    p = require_numbers("p", p)
    if not (np.isfinite(p) & (p >= 0)).all():
        raise ArgumentError("p holds values that are negative or not finite; pass pixels.")
    return 1 + (p > slow * frame_width).astype(int) + (p > fast * frame_width)


def bin_speeds(recording, *, seconds=SECONDS, step=None, slow=SLOW, fast=FAST):
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
    """
    table = displacement_of(recording, seconds=seconds, step=step)
    level = level_of(table["pixels"], frame_width=recording.frame_width, slow=slow, fast=fast)
    return table.assign(share=table["pixels"] / recording.frame_width, level=level)
