"""Heading and speed in closed form: the walker's own body is the ruler.

For a pinhole camera with focal length f (pixels), a walker s pixels tall stands at depth
f/s and sideways (x − c)/s, both in body heights.  A box is thus a ground position, and a
walk a straight line on the ground; no calibration, no training.

Three lengths in the image shrink together with distance: the box height, the drop of the
feet below the horizon, and the drop of the centroid below it.  Where the walkers show the
horizon, all three are read and the least-squares scale is taken.  In a camera high above
the ground the drops are long and carry the estimate; at eye level the height counts too.

A walk is then a straight line through readings whose noise is not white: the body bobs and
the feet alternate, step after step.  The line is fitted by generalised least squares with
that gait in its covariance, which makes short windows steadier and the interval honest.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy import stats

from mcnlab.cameras.horizon import body_scale, estimate_cameras
from mcnlab.checks import require_count, require_number
from mcnlab.compass import direction_of
from mcnlab.datasets.recording import Recording
from mcnlab.errors import ArgumentError
from mcnlab.regression import Line, fit_correlated, fit_lines_robust
from mcnlab.tables import CX, CY, PRESENT, SEQUENCE, H, Y, uncut

STILL = 0.02  # body heights a second, some 3 cm: slower, nobody walks anywhere
# Noise of a walker's scale and place, as shares of the body height: what walking does to
# a box.  The body's centre rises and falls by 2 to 3 % of the stature once a step (Perry
# and Burnfield, Gait Analysis, 2010), the nearer and the farther foot alternate once a
# stride, and outlines are good to a pixel or so at a hundred pixels.  The numbers without
# a source, and TRUST, were set on synthetic walkers so that intervals hold; tests judge
# them on others.
STEP_RATE = 1.95  # steps a second at natural cadence
STEP_NOISE = 0.015
STRIDE_NOISE = 0.007
OUTLINE_NOISE = 0.006
COHERENCE = 0.8  # s, for which a walker keeps time with the mean cadence
TRUST = 15.0  # frames' worth of trust in these numbers, against a walk's own residuals
# The lowest foot is nearer to the camera than the body's middle, by about half of half a
# step whichever way one walks, in body heights: what synthetic walkers show on average.
FEET_LEAD = 0.11
# A body in motion is no rigid ruler: depth and sideways speed may be off against each other
# by this share, on average over a walk.
RULER_NOISE = 0.0015


@dataclass(frozen=True)
class Track:
    """Straight walks on the ground, one a row, in body heights.

    All arrays have one axis, one element a walk or window.

    Attributes
    ----------
    x, z : ndarray
        Mean place: to the right of the optical axis, and away along the ground.  The
        latter is the lowest foot's.
    vx, vz : ndarray
        Velocity, body heights a second.
    heading_std : ndarray
        Standard error of the heading, radians.
    frames : ndarray of int
        Boxes that were used.
    """

    x: np.ndarray
    z: np.ndarray
    vx: np.ndarray
    vz: np.ndarray
    heading_std: np.ndarray
    frames: np.ndarray


def measure_headings(
    recording: Recording,
    *,
    focal_length: float,
    window: int | None = None,
    shared: str = "subject",
    cameras: Mapping | None = None,
) -> pd.DataFrame:
    """The heading of every walk, or of every window of it, in closed form.

    heading = atan2( cos τ · d[(x − c)/s]/dt , f · d[1/s]/dt ), with s the pixels a body
    height (`body_scale`) and τ the camera's tilt; 0 is away along the camera's axis,
    clockwise seen from above.

    Parameters
    ----------
    recording : Recording
    focal_length : float
        Pixels.  The only thing that must be known of the camera.
    window : int, optional
        Frames a window; windows follow each other without overlap from a walk's first
        frame, and what is left at its end is dropped.  Whole walks if not given.
    shared : {"recording", "subject"}, optional
        As in `estimate_cameras`.
    cameras : dict, optional
        Sequence → `Sighting`, to use instead of estimating them.

    Returns
    -------
    pandas.DataFrame
        One row a walk or window with at least four boxes and 60 % of its frames:
        ``sequence, frame`` (the first), ``heading`` (degrees from the camera's axis),
        ``sight`` (degrees from the line of sight to the walker), ``margin`` (half the
        95 % interval, degrees), ``speed`` (body heights a second), ``x, z`` (mean place,
        body heights), ``direction`` (1 … 8, of ``heading``; 0 where the walker stands
        still, the margin being 180°) and ``frames``.

    Raises
    ------
    McnError
        When the table is not sound, a number is out of range, or no walk is long enough.

    Examples
    --------
    >>> from mcnlab import vision, walking
    >>> headings = walking.measure_headings(vision.casia_a(), focal_length=400)
    >>> headings.loc[:2, ["sequence", "heading", "direction"]].round(0)
       sequence  heading  direction
    0  fyc-00_1    273.0          7
    1  fyc-00_2     90.0          3
    2  fyc-00_3    270.0          7
    """
    require_number("focal_length", focal_length, above=0, unit="pixels")
    stack = recording.stack
    if window is not None:
        window = require_count("window", window, low=4)
    if cameras is None:
        cameras = estimate_cameras(recording, focal_length=focal_length, shared=shared)
    unknown = [name for name in stack.names if name not in cameras]
    if unknown:
        raise ArgumentError(f"cameras lacks {unknown[0]!r}; give every sequence its camera.")
    trusted = uncut(stack, recording.frame_width, recording.frame_height)
    walk, start, cut = _cut_windows(stack, window)
    weights = cut(trusted)
    present = (weights > 0).sum(axis=1)
    wanted = stack.length[walk] if window is None else window
    keep = (present >= 4) & (present >= PRESENT * wanted)
    if not keep.any():
        raise ArgumentError(
            f"window is {window}: no walk has 4 boxes and {PRESENT:.0%} of the frames in one; "
            "pass longer walks or another window."
        )
    walk, start = walk[keep], start[keep]
    optics = _Optics.of([cameras[name] for name in stack.names], walk)
    track = fit_tracks(
        *(cut(stack.curves[name])[keep] for name in (CX, Y, H, CY)),
        weights=weights[keep],
        optics=optics,
        frame_rate=recording.frame_rate,
    )
    heading = np.degrees(np.arctan2(track.vx, track.vz)) % 360
    sight = (heading - np.degrees(np.arctan2(track.x, track.z))) % 360
    quantile = stats.t.ppf(0.975, degrees_of_freedom(track.frames))
    margin = np.minimum(np.degrees(quantile * track.heading_std), 180.0)
    speed = np.hypot(track.vx, track.vz)
    return pd.DataFrame(
        {
            SEQUENCE: np.array(stack.names, dtype=object)[walk],
            "frame": stack.start[walk] + start,
            "heading": heading,
            "sight": sight,
            "margin": np.where(speed < STILL, 180.0, margin),
            "speed": speed,
            "x": track.x,
            "z": track.z,
            "direction": np.where(speed < STILL, 0, direction_of(heading)),
            "frames": track.frames,
        }
    )


@dataclass(frozen=True)
class _Optics:
    """Cameras as columns, one row a walk or window, to broadcast over frames."""

    focal_length: np.ndarray
    middle: np.ndarray
    horizon: np.ndarray
    feet: np.ndarray
    centroid: np.ndarray
    horizon_std: np.ndarray
    tilt: np.ndarray

    @classmethod
    def of(cls, cameras, walk):
        def column(values):
            return np.array(list(values), dtype=float)[walk][:, None]

        return cls(
            column(camera.focal_length for camera in cameras),
            column((camera.frame_width - 1) / 2 for camera in cameras),
            column(camera.horizon or 0.0 for camera in cameras),
            column(camera.feet for camera in cameras),
            column(camera.centroid for camera in cameras),
            column(camera.horizon_std for camera in cameras),
            column(camera.tilt for camera in cameras),
        )


def fit_tracks(
    cx: np.ndarray,
    y: np.ndarray,
    h: np.ndarray,
    cy: np.ndarray,
    *,
    weights: ArrayLike,
    optics: "_Optics",
    frame_rate: float,
) -> Track:
    """Straight walks through boxes, in body heights.

    Parameters
    ----------
    cx, y, h, cy : ndarray, shape (n, frames)
        Centroid column, top row, height, centroid row, pixels; anything where there is
        no box.
    weights : ndarray, shape (n, frames)
        0 where there is no box.
    optics : object
        ``focal_length, middle, horizon, feet, centroid, horizon_std, tilt``, each (n, 1).
    frame_rate : float
        Frames a second.

    Returns
    -------
    Track
    """
    weights = np.asarray(weights, dtype=float)
    frames = np.arange(h.shape[1]) / frame_rate
    scale = body_scale(h, y + h, cy, optics)
    # A scale at or above the horizon means nothing; neither does a frame without a box.
    used = (weights > 0) & (scale > 0.1 * h)
    scale = np.where(used, scale, 1.0)
    count = used.sum(axis=1)
    time = frames - (used * frames).sum(axis=1, keepdims=True) / np.maximum(count, 1)[:, None]
    gait = _gait_covariance(frames)

    # 1/s is linear in time on a straight walk.  A pixel of noise in s is 1/s² in 1/s.
    near, pull = fit_lines_robust(time, 1 / scale, weights=used * scale**4)
    trust = pull / scale**4
    smooth = 1 / _above_zero(near.at(time), near.intercept)
    outline = OUTLINE_NOISE * _above_zero(1 / near.intercept, 1.0)[:, None]
    near, near_std = _fit_with_gait(
        time, smooth / scale, smooth, (outline / smooth) ** 2, trust, gait, count
    )
    inverse = _above_zero(near.at(time), near.intercept)

    cosine, focal = np.cos(optics.tilt[:, 0]), optics.focal_length[:, 0]
    vz = focal * near.slope / cosine**2
    column = np.where(used, cx - optics.middle, 0.0)
    # The box is as far as its lowest foot, the centroid as far as the body's middle.
    across = column * (inverse + FEET_LEAD / optics.focal_length)
    side, pull = fit_lines_robust(time, across, weights=used / inverse**2)
    side, side_std = _fit_with_gait(
        time, across, np.ones_like(across), (outline * inverse) ** 2, pull * inverse**2, gait, count
    )

    vx, x = side.slope / cosine, side.intercept / cosine
    z = focal * near.intercept / cosine**2 - optics.feet[:, 0] * np.tan(optics.tilt[:, 0])
    # The noise of 1/s reaches the sideways motion too, through the mean offset (x − c).
    offset = side.intercept / near.intercept
    square = np.maximum(vx**2 + vz**2, 1e-300)
    by_near = (vz * offset / cosine - vx * focal / cosine**2) / square * near_std
    by_side = vz / square * side_std / cosine
    # A horizon that is off changes far and near scales unlike, and so depth against sideways.
    pull = (optics.feet + optics.centroid) / (1 + optics.feet**2 + optics.centroid**2)
    off = np.hypot(RULER_NOISE, (pull * optics.horizon_std)[:, 0] * near.intercept)
    by_ruler = vx * vz / square * off
    heading_std = np.sqrt(by_near**2 + by_side**2 + by_ruler**2)
    return Track(x, z, vx, vz, heading_std, count)


def _fit_with_gait(time, y, scale, white, trust, gait, count):
    """The line (intercept + slope·time)·scale through y, and the slope's standard error.

    `white` is the variance of a frame's own noise; `trust`, the robust fit's weight,
    raises it for outliers and for frames without a box.
    """
    seen = trust > 0
    own = np.where(seen, white / np.maximum(trust, 1e-6), 1.0)
    covariance = gait + own[:, :, None] * np.eye(len(gait))
    # A frame without a box is a row of zeros: it says nothing of the line.
    design = np.stack([scale, time * scale], axis=-1) * seen[:, :, None]
    fit, uncertainty, misfit = fit_correlated(design, np.where(seen, y, 0.0), covariance)
    # Residuals larger than the gait foretells widen the interval, smaller ones narrow it.
    spread = (misfit + TRUST) / degrees_of_freedom(count)
    return Line(fit[:, 1], fit[:, 0]), np.sqrt(uncertainty[:, 1, 1] * spread)


def degrees_of_freedom(count: ArrayLike) -> np.ndarray:
    """Of an interval from `count` boxes: two numbers are fitted, `TRUST` is lent."""
    return np.maximum(np.asarray(count) - 2, 0) + TRUST


def _gait_covariance(time):
    """Covariance of gait noise between frames, shares of a body height squared."""
    lag = time[:, None] - time
    swing = 2 * np.pi * STEP_RATE * lag
    rhythm = STEP_NOISE**2 * np.cos(swing) + STRIDE_NOISE**2 * np.cos(swing / 2)
    return rhythm * np.exp(-((lag / COHERENCE) ** 2) / 2)


def _above_zero(values, typical):
    """`values` kept from zero, where noise would put the walker behind the camera."""
    typical = np.abs(typical)[:, None] if np.ndim(values) == 2 else np.abs(typical)
    return np.maximum(values, 1e-3 * typical)


def _cut_windows(stack, window):
    """Which walk each window is from, its first column, and a function that cuts arrays."""
    count, longest = stack.valid.shape
    if window is None:
        return np.arange(count), np.zeros(count, int), lambda values: values
    pieces = max(1, longest // window)
    walk = np.repeat(np.arange(count), pieces)
    start = np.tile(np.arange(pieces) * window, count)
    whole = start + window <= stack.length[walk]

    def cut(values):
        padded = values[:, : pieces * window]
        if padded.shape[1] < pieces * window:
            padded = np.pad(padded, ((0, 0), (0, pieces * window - padded.shape[1])))
        return padded.reshape(count * pieces, window)[whole]

    return walk[whole], start[whole], cut


def estimate_focal_length(
    recording: Recording, *, shared: str = "subject", low: float = 100.0, high: float = 2000.0
) -> float:
    """The focal length at which each subject walks equally fast in all directions.

    Sideways speed is read without the focal length, speed in depth is proportional to
    it.  If a subject keeps about the same pace in every walk, the right focal length
    makes the speeds agree: no label is used, only that people have a pace.

    Parameters
    ----------
    recording : Recording
        With several walks a subject, some across and some along the line of sight.
    shared : {"recording", "subject"}, optional
        As in `estimate_cameras`.
    low, high : float, optional
        The range to search, pixels.

    Returns
    -------
    float
        Pixels: the least spread of log speed within the subjects.

    Raises
    ------
    McnError
        When no subject has two walks, or the spread has no minimum within the range.
    """
    low = require_number("low", low, above=0, unit="pixels")
    high = require_number("high", high, above=low, unit="pixels")
    recording = recording.without_copies()
    subjects = recording.subjects
    reference = 1000.0
    walks = measure_headings(recording, focal_length=reference, shared=shared)
    who = subjects[walks[SEQUENCE]].to_numpy()
    angle, speed = np.radians(walks["heading"].to_numpy()), walks["speed"].to_numpy()
    vx, vz = speed * np.sin(angle), speed * np.cos(angle)
    names, codes, counts = np.unique(who, return_inverse=True, return_counts=True)
    if (counts < 2).all():
        raise ArgumentError("recording has one walk a subject; equal pace needs two or more.")
    trial = np.geomspace(low, high, 400)
    log_speed = np.log(np.hypot(vx[:, None], vz[:, None] * trial / reference))
    member = (codes[:, None] == np.arange(len(names))).astype(float)
    mean = member.T @ log_speed / counts[:, None]
    spread = ((log_speed - mean[codes]) ** 2).sum(axis=0)
    best = int(spread.argmin())
    if best in (0, len(trial) - 1):
        raise ArgumentError(
            f"recording does not show the focal length between {low:g} and {high:g} pixels; "
            "it needs walks both across and along the line of sight."
        )
    return float(trial[best])
