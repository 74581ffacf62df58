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

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from scipy import stats

from mcnlab import columns
from mcnlab.columns import CX, CY, SEQUENCE, SUBJECT, H, Y
from mcnlab.direction import PRESENT, direction_of, uncut
from mcnlab.errors import ArgumentError, require_choice, require_count, require_number
from mcnlab.lines import Line, fit_correlated, fit_lines_robust

DEPTH_RANGE = 1.25  # a walk whose boxes grow by less does not show the horizon
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
class Camera:
    """A pinhole camera, as far as the walkers show it.

    Attributes
    ----------
    focal_length : float
        Pixels.
    frame_width, frame_height : int
        Pixels; the principal point is taken to be the middle.
    horizon : float or None
        Row of the horizon, pixels; None where it is not known.
    feet : float
        Drop of the feet below the horizon as a multiple of the box height: the camera's
        height in body heights.  0 where the horizon is not known.
    centroid : float
        The same for the centroid.
    horizon_std : float
        Standard error of the horizon's row, pixels, by leaving out one walk at a time;
        0 where one walk alone showed it.
    """

    focal_length: float
    frame_width: int
    frame_height: int
    horizon: float | None = None
    feet: float = 0.0
    centroid: float = 0.0
    horizon_std: float = 0.0

    def __post_init__(self):
        require_number("focal_length", self.focal_length, above=0, unit="pixels")
        require_count("frame_width", self.frame_width, low=1)
        require_count("frame_height", self.frame_height, low=1)

    @property
    def tilt(self):
        """How far the optical axis points below the horizon, radians; 0 if unknown."""
        if self.horizon is None:
            return 0.0
        return float(np.arctan(((self.frame_height - 1) / 2 - self.horizon) / self.focal_length))


def estimate_camera(boxes, *, focal_length, frame_width, frame_height):
    """The horizon and the camera's height, from the walkers' boxes alone.

    On level ground box height is linear in the row of the feet, h = a(y_feet − y_0): y_0
    is the horizon and 1/a the camera's height in body heights.  The line is fitted
    robustly, over all boxes.

    Parameters
    ----------
    boxes : pandas.DataFrame
        A box table from one camera.
    focal_length : float
        Pixels.
    frame_width, frame_height : int
        Pixels.

    Returns
    -------
    Camera
        Without a horizon where the boxes differ in height by less than a quarter, or
        shrink towards the bottom of the frame.

    Raises
    ------
    TableError, ArgumentError
        When the table is not sound or a number is out of range.
    """
    columns.check_boxes(boxes)
    height, top, centroid = (boxes[name].to_numpy(float) for name in (H, Y, CY))
    plain = Camera(focal_length, frame_width, frame_height)
    walk = np.unique(boxes[SEQUENCE].to_numpy(object).astype(str), return_inverse=True)[1]
    return _find_horizon(height, top + height, centroid, walk, plain)


def _find_horizon(height, feet, centroid, walk, plain):
    low, high = np.percentile(height, [5, 95])
    if high < DEPTH_RANGE * low or np.ptp(feet) == 0:
        return plain
    line, weights = fit_lines_robust(feet, height)
    if line.slope <= 0:
        return plain
    horizon = float(-line.intercept / line.slope)
    drop = float(np.median((centroid - horizon) / height))
    spread = _horizon_std(feet, height, weights, walk)
    return replace(
        plain, horizon=horizon, feet=float(1 / line.slope), centroid=drop, horizon_std=spread
    )


def _horizon_std(feet, height, weights, walk):
    """The jackknife over walks: boxes of one walk err together."""
    # Weighted sums a walk, about the middle; leaving a walk out subtracts its sums.
    middle = np.average(feet, weights=weights)
    dx = feet - middle
    parts = (weights, weights * dx, weights * dx**2, weights * height, weights * dx * height)
    sums = np.array([np.bincount(walk, part) for part in parts])
    n, x, xx, y, xy = sums.sum(axis=1, keepdims=True) - sums
    determinant = n * xx - x**2
    count = sums.shape[1]
    slope, level = n * xy - x * y, xx * y - x * xy
    sound = (determinant > 1e-9 * n**2) & (slope > 0)
    if count < 2 or not sound.all():
        return 0.0
    rows = middle - level / slope
    return float(np.sqrt((count - 1) * np.mean((rows - rows.mean()) ** 2)))


def estimate_cameras(recording, *, focal_length, shared="subject"):
    """The camera of every walk.

    Parameters
    ----------
    recording : Recording
    focal_length : float
        Pixels.
    shared : {"recording", "subject"}, optional
        Which walks were filmed by one unmoved camera: all, or those of a subject (a
        session).  Mirrored copies lend nothing.

    Returns
    -------
    dict
        Sequence → `Camera`.
    """
    require_choice("shared", shared, ("recording", "subject"))
    plain = Camera(focal_length, recording.frame_width, recording.frame_height)
    boxes = recording.boxes
    walks = dict(columns.split_sequences(boxes))
    subject = boxes[SUBJECT].to_numpy()
    height, top, centroid = (boxes[name].to_numpy(float) for name in (H, Y, CY))
    feet = top + height
    groups = {}
    for name, at in walks.items():
        groups.setdefault(subject[at.start] if shared == "subject" else "", []).append(name)
    cameras = {}
    for names in groups.values():
        own = [name for name in names if name not in recording.copies] or names
        rows = np.concatenate([np.arange(walks[name].start, walks[name].stop) for name in own])
        walk = np.repeat(
            np.arange(len(own)), [walks[name].stop - walks[name].start for name in own]
        )
        camera = _find_horizon(height[rows], feet[rows], centroid[rows], walk, plain)
        cameras |= dict.fromkeys(names, camera)
    return cameras


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


def body_scale(height, feet, centroid, camera):
    """Pixels a body height at the walker's place, from three readings of it.

    Parameters
    ----------
    height, feet, centroid : array_like
        Box height, and rows of feet and centroid, pixels.
    camera : Camera
        Or anything with ``horizon``, ``feet`` and ``centroid`` that broadcast; where
        ``feet`` is 0 only the height is read.

    Returns
    -------
    ndarray
        The scale s that brings s, feet·s and centroid·s nearest to the three lengths in
        the image, in the least-squares sense.
    """
    horizon = 0.0 if camera.horizon is None else camera.horizon
    pull = camera.feet * (feet - horizon) + camera.centroid * (centroid - horizon)
    return (height + pull) / (1 + camera.feet**2 + camera.centroid**2)


def measure_headings(recording, *, focal_length, window=None, shared="subject", cameras=None):
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
        Sequence → `Camera`, to use instead of estimating them.

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


def fit_tracks(cx, y, h, cy, *, weights, optics, frame_rate):
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


def degrees_of_freedom(count):
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


def estimate_focal_length(recording, *, shared="subject", low=100.0, high=2000.0):
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
    angle = np.radians(walks["heading"].to_numpy())
    vx, vz = walks["speed"].to_numpy() * np.sin(angle), walks["speed"].to_numpy() * np.cos(angle)
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
