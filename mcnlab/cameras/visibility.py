"""Which targets on the ground a camera sees, and how nearly square-on."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mcnlab.cameras.floor import check_walls
from mcnlab.checks import (
    HAIR,
    require_array,
    require_choice,
    require_kind,
    require_number,
    require_points,
)
from mcnlab.tables import COURSE, HEADING, X, Y, check_columns

BLOCK = 2_000_000  # numbers in a block of pairs, so that memory stays bounded


@dataclass(frozen=True)
class CameraModel:
    """What every camera of a network can do.

    Attributes
    ----------
    field_of_view : float
        Degrees, half to either side of the heading; not used when it pans.
    near, reach : float
        Metres; nearer than `near` or farther than `reach` it sees nobody well enough.
    pans : bool
        It turns to whoever walks (PTZ, section 2.2.5): sees all around.
    square_within : float
        Degrees that the line of sight may be off the perpendicular to a course.

    Raises
    ------
    ArgumentError
        When a number is out of range.

    Examples
    --------
    >>> CameraModel(reach=8.0, pans=True)
    CameraModel(field_of_view=60.0, near=1.0, reach=8.0, pans=True, square_within=15.0)
    """

    field_of_view: float = 60.0
    near: float = 1.0
    reach: float = 12.0
    pans: bool = False
    square_within: float = 15.0

    def __post_init__(self) -> None:
        require_number("field_of_view", self.field_of_view, above=0, high=360, unit="degrees")
        require_number("near", self.near, low=0, unit="metres")
        require_number("reach", self.reach, above=self.near, unit="metres, beyond near")
        require_number("square_within", self.square_within, above=0, high=90, unit="degrees")
        require_choice("pans", self.pans, (True, False))


def sees(
    points: ArrayLike, cameras: pd.DataFrame, model: CameraModel, *, walls: ArrayLike | None = None
) -> np.ndarray:
    """Which camera sees which point of the ground.

    A wall blocks where the line of sight crosses it; its ends belong to it.  A camera or
    a point that touches a wall is not hidden by that wall, nor is what lies along it.

    Parameters
    ----------
    points : array_like, shape (n, 2)
        Metres.
    cameras : pandas.DataFrame
        m cameras, as from `candidates`.
    model : CameraModel
    walls : array_like, shape (k, 2, 2), optional
        The ends of segments, metres.

    Returns
    -------
    ndarray of bool, shape (n, m)

    Raises
    ------
    TableError, ArgumentError
        When a table lacks a column, or an array has an impossible shape or value.
    """
    return _look(require_points("points", points), None, cameras, model, walls)


def square_on(
    targets: pd.DataFrame,
    cameras: pd.DataFrame,
    model: CameraModel,
    *,
    walls: ArrayLike | None = None,
) -> np.ndarray:
    """Which camera serves which walker-second: sees it, and nearly from the side.

    Parameters
    ----------
    targets : pandas.DataFrame
        n walker-seconds with `x`, `y`, `course`, as from `walker_seconds`.
    cameras, model, walls
        As in `sees`.

    Returns
    -------
    ndarray of bool, shape (n, m)

    Raises
    ------
    TableError, ArgumentError
        As in `sees`.
    """
    check_columns(targets, (X, Y, COURSE), argument="targets")
    points = require_points("targets", targets[[X, Y]].to_numpy())
    course = require_array("targets", targets[COURSE], (None,))
    return _look(points, np.deg2rad(course), cameras, model, walls)


def within_reach(away: ArrayLike, near: ArrayLike, reach: ArrayLike) -> np.ndarray:
    """Whether what is `away`, metres, is neither too near a camera nor too far; never right above.

    Parameters
    ----------
    away, near, reach : array_like
        Metres; of shapes that go together.

    Returns
    -------
    ndarray of bool
    """
    away, near, reach = (np.asarray(value, float) for value in (away, near, reach))
    hair = HAIR * reach
    return (away >= near - hair) & (away <= reach + hair) & (away > 0)


def _look(points, course, cameras, model, walls):
    """What `sees` and `square_on` share; `course` is radians or None."""
    require_kind("model", model, CameraModel, "a CameraModel")
    needed = (X, Y) if model.pans else (X, Y, HEADING)
    check_columns(cameras, needed, argument="cameras")
    spots = require_points("cameras", cameras[[X, Y]].to_numpy())
    walls = check_walls(walls)
    # Where coordinates are large, their differences are not.
    middle = spots.mean(axis=0)
    points, walls = points - middle, walls - middle
    # Cameras at one place share all but the heading.
    places, place = np.unique(spots - middle, axis=0, return_inverse=True)
    place = place.ravel()
    if not model.pans:
        heading = np.deg2rad(require_array("cameras", cameras[HEADING], (None,)))
        ahead = np.stack([np.cos(heading), np.sin(heading)])
        edge = np.cos(np.deg2rad(model.field_of_view / 2))
    hair = HAIR * model.reach
    out = np.empty((len(points), len(spots)), dtype=bool)
    step = max(1, BLOCK // len(spots))
    for start in range(0, len(points), step):
        rows = slice(start, start + step)
        to = points[rows, None, :] - places
        away = np.hypot(to[..., 0], to[..., 1])
        seen = within_reach(away, model.near, model.reach)
        if course is not None:
            turn = course[rows, None]
            along = to[..., 0] * np.cos(turn) + to[..., 1] * np.sin(turn)
            seen &= np.abs(along) <= np.sin(np.deg2rad(model.square_within)) * away + hair
        _hide(seen, points[rows], places, walls)
        out[rows] = seen[:, place]
        if not model.pans:
            forward = points[rows] @ ahead - ((spots - middle).T * ahead).sum(axis=0)
            out[rows] &= forward >= edge * away[:, place] - hair
    return out


def _hide(seen, points, places, walls):
    """Clear `seen`, in place, where a wall crosses the line from point to place."""
    for first, second in walls:
        here, there = (_side(first, second, at).astype(np.int8) for at in (points, places))
        row, column = np.nonzero(seen & (here[:, None] * there == -1))
        start, end = points[row], places[column]
        meets = _side(start, end, first) * _side(start, end, second) <= 0
        seen[row[meets], column[meets]] = False


def _side(start, end, point):
    """1 left of the line through start and end, −1 right of it, 0 on it."""
    x, y = (end - start)[..., 0], (end - start)[..., 1]
    u, v = (point - start)[..., 0], (point - start)[..., 1]
    turn = x * v - y * u
    return np.where(np.abs(turn) <= HAIR * np.hypot(x, y), 0, np.sign(turn))
