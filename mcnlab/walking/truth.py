"""True motion on the ground, from places that others measured."""

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mcnlab.errors import DatasetError
from mcnlab.regression import fit_lines
from mcnlab.tables import FRAME, SEQUENCE, WORLD_X, WORLD_Y, check_columns


def true_motion(
    world: pd.DataFrame, windows: pd.DataFrame, *, window: int, frame_rate: float
) -> tuple[np.ndarray, np.ndarray]:
    """Where each window's walker is and how he moves, by least-squares lines.

    Parameters
    ----------
    world : pandas.DataFrame
        ``sequence, frame, world_x, world_y`` (metres).
    windows : pandas.DataFrame
        ``sequence, frame``: whose, and from which frame on.
    window : int
        Frames a window.
    frame_rate : float
        Frames a second.

    Returns
    -------
    place, velocity : ndarray, shape (n, 2)
        Metres and metres a second; not a number where a window has fewer than two
        positions.

    Raises
    ------
    McnError
        When a column is missing, or a person is twice in a frame.
    """
    check_columns(world, (SEQUENCE, FRAME, WORLD_X, WORLD_Y), argument="world")
    check_columns(windows, (SEQUENCE, FRAME), argument="windows")
    if world.duplicated([SEQUENCE, FRAME]).any():
        raise DatasetError("world has a person twice in one frame; drop the duplicates.")
    frames = windows[FRAME].to_numpy()[:, None] + np.arange(window)
    names = np.repeat(windows[SEQUENCE].to_numpy(), window)
    index = pd.MultiIndex.from_arrays([names, frames.ravel()])
    held = world.set_index([SEQUENCE, FRAME])[[WORLD_X, WORLD_Y]].reindex(index).to_numpy()
    held = held.reshape(len(windows), window, 2)
    there = np.isfinite(held).all(axis=2)
    known = there.sum(axis=1) >= 2
    place, velocity = np.full((2, len(windows), 2), np.nan)
    if known.any():
        held, weights = held[known], there[known].astype(float)
        held = np.where(weights[..., None] > 0, held, 0.0)
        time = np.arange(window) / frame_rate
        place[known] = held.sum(axis=1) / weights.sum(axis=1)[:, None]
        for axis in (0, 1):
            velocity[known, axis] = fit_lines(time, held[..., axis], weights=weights).slope
    return place, velocity


def true_headings(
    world: pd.DataFrame,
    windows: pd.DataFrame,
    *,
    place: ArrayLike,
    window: int,
    frame_rate: float,
) -> pd.DataFrame:
    """The true heading against the line of sight, and the true speed, in each window.

    Parameters
    ----------
    world : pandas.DataFrame
        ``sequence, frame, world_x, world_y`` (metres).
    windows : pandas.DataFrame
        ``sequence, frame``: whose, and from which frame on.
    place : array_like, shape (2,) or (3,)
        Where the camera stands, metres.
    window : int
        Frames a window.
    frame_rate : float
        Frames a second.

    Returns
    -------
    pandas.DataFrame
        Indexed like `windows`: ``true_sight`` (degrees, clockwise from straight away)
        and ``true_speed`` (m/s), by least-squares lines through the positions.

    Raises
    ------
    DatasetError
        When a window has fewer than two positions.
    """
    middle, velocity = true_motion(world, windows, window=window, frame_rate=frame_rate)
    unknown = np.isnan(middle).any(axis=1)
    if unknown.any():
        name = windows[SEQUENCE].iloc[int(np.argmax(unknown))]
        raise DatasetError(
            f"world has no two positions of {name!r} in one of its windows; "
            "pass windows of people whose positions are known."
        )
    middle, (vx, vy) = middle - np.asarray(place)[:2], velocity.T
    # World angles turn counter-clockwise, headings clockwise.
    turn = np.arctan2(middle[:, 1], middle[:, 0]) - np.arctan2(vy, vx)
    return pd.DataFrame(
        {"true_sight": np.degrees(turn) % 360, "true_speed": np.hypot(vx, vy)},
        index=windows.index,
    )
