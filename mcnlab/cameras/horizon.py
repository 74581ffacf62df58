"""The camera as its walkers show it: horizon, tilt and height from their boxes alone."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mcnlab import tables
from mcnlab.cameras.camera import Camera
from mcnlab.cameras.homography import find_homography
from mcnlab.checks import require_choice, require_count, require_number
from mcnlab.errors import ArgumentError, DatasetError
from mcnlab.regression import fit_lines_robust
from mcnlab.tables import (
    CX,
    CY,
    FRAME,
    PIXEL_LIMIT,
    SEQUENCE,
    SUBJECT,
    WORLD_X,
    WORLD_Y,
    H,
    Y,
    check_columns,
)

HORIZON_BOXES = 3000  # boxes are enough to see the horizon
DEPTH_RANGE = 1.25  # a walk whose boxes grow by less does not show the horizon


@dataclass(frozen=True)
class Sighting:
    """What walkers show of the pinhole camera that filmed them.

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

    def __post_init__(self) -> None:
        require_number("focal_length", self.focal_length, above=0, unit="pixels")
        require_count("frame_width", self.frame_width, low=1)
        require_count("frame_height", self.frame_height, low=1)

    @property
    def tilt(self) -> float:
        """How far the optical axis points below the horizon, radians; 0 if unknown."""
        if self.horizon is None:
            return 0.0
        return float(np.arctan(((self.frame_height - 1) / 2 - self.horizon) / self.focal_length))

    @property
    def camera(self) -> Camera | None:
        """The camera, in a world whose unit is the body height; None without a horizon."""
        if self.horizon is None:
            return None
        return Camera.from_tilt(
            focal_length=self.focal_length,
            height=self.feet,
            tilt=np.degrees(self.tilt),
            frame_width=self.frame_width,
            frame_height=self.frame_height,
        )


def estimate_camera(
    boxes: pd.DataFrame, *, focal_length: float, frame_width: int, frame_height: int
) -> Sighting:
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
    Sighting
        Without a horizon where the boxes differ in height by less than a quarter, or
        shrink towards the bottom of the frame.

    Raises
    ------
    TableError, ArgumentError
        When the table is not sound or a number is out of range.

    Examples
    --------
    >>> from mcnlab.synthetic import make_crossings
    >>> boxes = make_crossings().boxes
    >>> seen = estimate_camera(boxes, focal_length=800, frame_width=640, frame_height=480)
    >>> round(seen.horizon), round(seen.feet, 1), round(seen.camera.horizon)
    (107, 1.9, 107)
    """
    tables.check_boxes(boxes)
    height, top, centroid = (boxes[name].to_numpy(float) for name in (H, Y, CY))
    plain = Sighting(focal_length, frame_width, frame_height)
    walk = np.unique(boxes[SEQUENCE].to_numpy(object).astype(str), return_inverse=True)[1]
    return _find_horizon(height, top + height, centroid, walk, plain)


def horizons_until(recording: Any, frame: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The horizon that the boxes up to each frame show, see `estimate_camera`.

    Parameters
    ----------
    recording : Recording
    frame : ndarray of int, shape (n,)

    Returns
    -------
    horizon, rise : ndarray, shape (n,)
        The horizon's row, pixels, and the camera's height in body heights; 0 where the
        boxes do not show them yet.
    """
    boxes = recording.boxes
    clock, height = boxes[FRAME].to_numpy(np.int64), boxes[H].to_numpy(float)
    feet = boxes[Y].to_numpy(float) + height
    # Whatever the order of the tracks, the same boxes are taken.
    order = np.lexsort((height, feet, clock))
    clock, height, feet = clock[order], height[order], feet[order]
    horizon, rise = np.zeros(len(frame)), np.zeros(len(frame))
    for moment in np.unique(frame):
        count = np.searchsorted(clock, moment, side="right")
        some = np.linspace(0, count - 1, min(count, HORIZON_BOXES)).astype(int)
        fit = _fit_horizon(feet[some], height[some])
        if fit is not None:
            now = frame == moment
            horizon[now], rise[now], _ = fit
    return horizon, rise


def _fit_horizon(feet, height):
    """Row of the horizon, the camera's height in bodies, and weights; None if none shows."""
    low, high = np.percentile(height, [5, 95])
    if high < DEPTH_RANGE * low or np.ptp(feet) == 0:
        return None
    line, weights = fit_lines_robust(feet, height)
    # A horizon beyond any image is a line that is level but for rounding.
    if line.slope * PIXEL_LIMIT <= abs(line.intercept):
        return None
    return float(-line.intercept / line.slope), float(1 / line.slope), weights


def _find_horizon(height, feet, centroid, walk, plain):
    """The sighting `plain`, with the horizon that all boxes show."""
    fit = _fit_horizon(feet, height)
    if fit is None:
        return plain
    horizon, rise, weights = fit
    drop = float(np.median((centroid - horizon) / height))
    spread = _horizon_std(feet, height, weights, walk)
    return replace(plain, horizon=horizon, feet=rise, centroid=drop, horizon_std=spread)


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


def estimate_cameras(
    recording: Any, *, focal_length: float, shared: str = "subject"
) -> dict[str, Sighting]:
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
        Sequence → `Sighting`.
    """
    require_choice("shared", shared, ("recording", "subject"))
    plain = Sighting(focal_length, recording.frame_width, recording.frame_height)
    boxes = recording.boxes
    walks = dict(tables.split_sequences(boxes))
    subject = boxes[SUBJECT].to_numpy()
    height, top, centroid = (boxes[name].to_numpy(float) for name in (H, Y, CY))
    feet = top + height
    groups: dict[str, list] = {}
    for name, at in walks.items():
        groups.setdefault(subject[at.start] if shared == "subject" else "", []).append(name)
    cameras: dict[str, Sighting] = {}
    for names in groups.values():
        own = [name for name in names if name not in recording.copies] or names
        rows = np.concatenate([np.arange(walks[name].start, walks[name].stop) for name in own])
        walk = np.repeat(
            np.arange(len(own)), [walks[name].stop - walks[name].start for name in own]
        )
        camera = _find_horizon(height[rows], feet[rows], centroid[rows], walk, plain)
        cameras |= dict.fromkeys(names, camera)
    return cameras


def body_scale(height: ArrayLike, feet: ArrayLike, centroid: ArrayLike, camera: Any) -> np.ndarray:
    """Pixels a body height at the walker's place, from three readings of it.

    Parameters
    ----------
    height, feet, centroid : array_like
        Box height, and rows of feet and centroid, pixels.
    camera : Sighting
        Or anything with ``horizon``, ``feet`` and ``centroid`` that broadcast; where
        ``feet`` is 0 only the height is read.

    Returns
    -------
    ndarray
        The scale s that brings s, feet·s and centroid·s nearest to the three lengths in
        the image, in the least-squares sense.
    """
    horizon = 0.0 if camera.horizon is None else camera.horizon
    drops = np.asarray(feet) - horizon, np.asarray(centroid) - horizon
    pull = camera.feet * drops[0] + camera.centroid * drops[1]
    return (np.asarray(height) + pull) / (1 + camera.feet**2 + camera.centroid**2)


def find_place(recording: Any, world: pd.DataFrame) -> np.ndarray:
    """Where on the ground a camera that does not roll stands, from boxes whose place is known.

    Places that one image column shows lie on a line to the camera.  The homography from
    ground to image gives those lines, and where they meet; no focal length is needed.

    Parameters
    ----------
    recording : Recording
        Of one unmoved camera; its boxes reach the feet.
    world : pandas.DataFrame
        ``sequence, frame, world_x, world_y``: where those feet are, metres.

    Returns
    -------
    ndarray, shape (2,)
        World metres.

    Raises
    ------
    McnError
        When fewer than four boxes have a position, all of them lie on a line, or the
        camera looks straight down.
    """
    check_columns(world, (SEQUENCE, FRAME, WORLD_X, WORLD_Y), argument="world")
    held = recording.boxes.merge(world, on=[SEQUENCE, FRAME])
    feet = np.stack([held[CX], held[Y] + held[H]], axis=1)
    places = held[[WORLD_X, WORLD_Y]].to_numpy(float)
    try:
        to_image = np.linalg.inv(find_homography(feet, places))
    except ArgumentError as fault:
        raise DatasetError(
            f"world does not show where the camera stands, in {len(held)} boxes with a place "
            f"({fault}); name its place."
        ) from fault
    # Column = (row 1 · place) / (row 3 · place): both vanish where all columns meet.
    x, y, scale = np.cross(to_image[0], to_image[2])
    if abs(scale) <= 1e-9 * max(abs(x), abs(y)):
        raise DatasetError(
            "world does not show where the camera stands: all lines of sight are parallel; "
            "name its place."
        )
    return np.array([x, y]) / scale
