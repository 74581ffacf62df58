"""Which camera sees which walker square-on.

The thesis places cameras where many perpendiculars to the walks meet (section 2.2.4), so
that gait is seen from the side.  Here that aim is put as a number: the share of
walker-seconds that some chosen camera sees within an angle of square-on.  The matrix of who
sees whom is what the choices of `choice` start from.

Headings and courses are degrees counter-clockwise from the x axis, seen from above.
"""

from collections.abc import Callable

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mcnlab.cameras.floor import GridMap
from mcnlab.cameras.visibility import CameraModel, square_on
from mcnlab.checks import (
    HAIR,
    require_array,
    require_count,
    require_kind,
    require_number,
    require_points,
)
from mcnlab.datasets.scene import Scene
from mcnlab.errors import ArgumentError
from mcnlab.tables import (
    COURSE,
    FRAME,
    HEADING,
    PLACE,
    SECOND,
    TRACE,
    X,
    Y,
    check_traces,
    starts_of,
)


def walker_seconds(
    walks: Scene | pd.DataFrame,
    *,
    frame_rate: float | None = None,
    every: float = 1.0,
    least_speed: float = 0.3,
) -> pd.DataFrame:
    """Where each walker is and whither it goes, second by second.

    Each trace is cut into seconds from its first frame on.  The course is the direction
    of the least-squares line through a second's places, both ends included.  A second
    with fewer than two places, or with a gap over more than half of it, is left out, and
    so is one whose walker stands: it has no course.

    Parameters
    ----------
    walks : Scene or pandas.DataFrame
        A scene, or a trace table in metres.
    frame_rate : float, optional
        Frames a second; needed with a table, not with a scene.
    every : float, optional
        Seconds; the length of a "second".
    least_speed : float, optional
        Metres a second; slower is standing.

    Returns
    -------
    pandas.DataFrame
        One row a walker-second: `trace`; `second`, the mean time of its places since
        frame 0; `x`, `y`, their mean, metres; `course`, degrees in [0, 360).

    Raises
    ------
    TableError, ArgumentError
        When the table is not sound, a number is out of range, or nobody moves.
    """
    if isinstance(walks, Scene):
        if frame_rate is not None:
            raise ArgumentError("frame_rate: the scene has its own; leave it out.")
        walks, frame_rate = walks.traces, walks.frame_rate
    else:
        check_traces(walks, argument="walks")
    frame_rate = require_number("frame_rate", frame_rate, above=0, unit="frames a second")
    every = require_number("every", every, above=0, unit="seconds")
    least_speed = require_number("least_speed", least_speed, above=0, unit="metres a second")

    names = walks[TRACE].to_numpy(dtype=object)
    starts = starts_of(names)
    walk = np.repeat(np.arange(len(starts)), np.diff(np.r_[starts, len(names)]))
    time, x, y = (walks[name].to_numpy(float) for name in (FRAME, X, Y))
    time = time / frame_rate
    age = (time - time[starts][walk]) / every
    period = np.floor(age + HAIR * (1 + age))
    # A place on the border of two seconds is the end of one and the start of the other.
    border = np.flatnonzero((age - period < HAIR * (1 + age)) & (period > 0))
    row = np.r_[np.arange(len(age)), border]
    period = np.r_[period, period[border] - 1]
    _, first, group = np.unique(
        np.stack([walk[row], period], axis=1), axis=0, return_index=True, return_inverse=True
    )
    group = group.ravel()
    number = np.bincount(group)
    mean_time, mean_x, mean_y = (
        np.bincount(group, values[row]) / number for values in (time, x, y)
    )
    since = time[row] - mean_time[group]
    square = np.bincount(group, since**2)
    ages = pd.Series(since).groupby(group)
    span = (ages.max() - ages.min()).to_numpy()
    sampled = (number > 1) & (span >= every * (0.5 - HAIR))
    if not sampled.any():
        raise ArgumentError(
            f"every is {every:g} s, in which no walker is seen twice, half of it apart; pass a "
            "longer time, and check frame_rate."
        )
    with np.errstate(divide="ignore", invalid="ignore"):  # not sampled: dropped below
        speed_x, speed_y = (
            np.bincount(group, since * (values[row] - mean[group])) / square
            for values, mean in ((x, mean_x), (y, mean_y))
        )
    keep = sampled.copy()
    keep[sampled] = np.hypot(speed_x[sampled], speed_y[sampled]) >= least_speed
    if not keep.any():
        raise ArgumentError(
            f"walks: nobody moves at least_speed, {least_speed:g} m/s, or faster; lower it, and "
            "check that places are metres and frame_rate is right."
        )
    course = np.rad2deg(np.arctan2(speed_y[keep], speed_x[keep])) % 360.0
    table = {
        TRACE: names[row[first[keep]]],
        SECOND: mean_time[keep],
        X: mean_x[keep],
        Y: mean_y[keep],
        COURSE: np.where(course < 360.0, course, 0.0),
    }
    return pd.DataFrame(table)


def candidates(
    places: GridMap | ArrayLike,
    *,
    model: CameraModel,
    headings: int | ArrayLike = 8,
    forbidden: ArrayLike | Callable | None = None,
) -> pd.DataFrame:
    """Cameras that could be placed.

    Parameters
    ----------
    places : GridMap or array_like, shape (k, 2)
        The centre of every cell, or any places, metres.
    model : CameraModel
    headings : int or array_like, optional
        How many, evenly from 0° on, or which, degrees.  A camera that pans has none.
    forbidden : ndarray of bool or callable, optional
        Where no camera may be: a map of the grid's shape, a mask of shape (k,), or a
        function of x and y arrays that gives a mask.

    Returns
    -------
    pandas.DataFrame
        One row a camera: `place`, the number of its place (row × columns + column on a
        grid); `x`, `y`, metres; `heading`, degrees in [0, 360), 0 where it pans.

    Raises
    ------
    ArgumentError
        When an argument is out of range or every place is forbidden.
    """
    require_kind("model", model, CameraModel, "a CameraModel")
    if isinstance(places, GridMap):
        shape = places.shape
        across, up = places.centres()
        places = np.stack([axis.ravel() for axis in np.meshgrid(across, up)], axis=1)
    else:
        places = require_points("places", places)
        shape = (len(places),)
    if callable(forbidden):
        forbidden = forbidden(places[:, 0], places[:, 1])
        shape = (len(places),)
    allowed = np.arange(len(places))
    if forbidden is not None:
        forbidden = require_array("forbidden", forbidden, shape, dtype=bool)
        allowed = np.flatnonzero(~forbidden.ravel())
    if len(allowed) == 0:
        raise ArgumentError("forbidden leaves no place for a camera; allow at least one.")
    turns = np.zeros(1) if model.pans else _check_headings(headings)
    place = np.repeat(allowed, len(turns))
    table = {
        PLACE: place,
        X: places[place, 0],
        Y: places[place, 1],
        HEADING: np.tile(turns, len(allowed)),
    }
    return pd.DataFrame(table)


def aim_cameras(
    places: ArrayLike,
    targets: pd.DataFrame,
    model: CameraModel,
    *,
    headings: int | ArrayLike = 8,
    walls: ArrayLike | None = None,
) -> pd.DataFrame:
    """Turn cameras at given places, one after another, to where they add most.

    This makes cameras of voted places, which have no heading.

    Parameters
    ----------
    places : array_like, shape (k, 2)
        Metres, the most voted first.
    targets, model, walls
        As in `square_on`.
    headings : int or array_like, optional
        As in `candidates`.

    Returns
    -------
    pandas.DataFrame
        One row a place, in the same order, as from `candidates`.

    Raises
    ------
    TableError, ArgumentError
        As in `candidates` and `square_on`.
    """
    cameras = candidates(places, model=model, headings=headings)
    served = square_on(targets, cameras, model, walls=walls)
    missing = np.ones(len(served), dtype=bool)
    rows = []
    for _, at in cameras.groupby(PLACE, sort=True).indices.items():
        added = served[np.ix_(missing, at)].sum(axis=0)
        # Where no heading adds a walker-second, the one that sees most is as good as any.
        best = at[np.lexsort((-served[:, at].sum(axis=0), -added))[0]]
        missing &= ~served[:, best]
        rows.append(best)
    return cameras.iloc[rows].reset_index(drop=True)


def _check_headings(headings):
    if np.ndim(headings) == 0:
        number = require_count("headings", headings, low=1)
        return np.arange(number) * 360.0 / number
    remedy = "a number of headings, or a list of finite degrees"
    return np.unique(require_array("headings", headings, (None,), least=1, remedy=remedy) % 360.0)
