"""True speed, and what is left of it in the camera's picture.

The displacement p (`mcnlab.speed`) tells of the place as much as of the pace.  At depth Z a
speed v across the view gives p = f·v/Z, so log(p/v) falls by 1 when log Z rises by 1; straight
along the view, by 2.  In body heights a second (`mcnlab.perspective`) it should not fall at all.
"""

import numpy as np
import pandas as pd

from mcnlab.checks import require_numbers
from mcnlab.columns import CX, FRAME, SEQUENCE, H, Y, check_columns
from mcnlab.datasets.pedestrians import WORLD_X, WORLD_Y, true_motion
from mcnlab.errors import ArgumentError, DatasetError, require_count, require_number
from mcnlab.ground import find_homography
from mcnlab.lines import fit_lines_robust
from mcnlab.perspective import measure_headings
from mcnlab.results import Estimate
from mcnlab.speed import SECONDS, displacement_of, frames_of

WALKING = 0.6  # m/s; who is slower lingers, and a ratio to his speed is noise
PASSING = 0.3  # m/s across the view, likewise


def find_place(recording, world):
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


def compare_speeds(recording, world, *, place, focal_length, seconds=(SECONDS,)):
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
    camera = np.asarray(place, dtype=float)
    if camera.shape not in ((2,), (3,)) or not np.isfinite(camera).all():
        raise ArgumentError("place must be two or three finite numbers; pass world metres.")
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
                SEQUENCE: table[SEQUENCE],
                FRAME: table[FRAME],
                "pixels": table["pixels"],
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


def distance_slope(speed, true_speed, distance, people, *, least=WALKING, draws=1000, seed=0):
    """How a measure of speed depends on distance: the slope of log(speed/true) on log distance.

    −1: the measure halves when the distance doubles; 0: it does not depend on distance.  The
    line is robust (`lines.fit_lines_robust`), the interval from drawing whole people.

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
    weights = _draw_people(len(names), draws, seed)[:, codes]
    apart = np.where(weights > 0, x, -np.inf).max(axis=1)
    apart = apart - np.where(weights > 0, x, np.inf).min(axis=1)
    weights = weights[apart > 1e-9]  # who was drawn stood at two distances
    if len(names) < 2 or len(weights) == 0:
        return Estimate(slope, None, None, len(names))
    shape = weights.shape
    lines, _ = fit_lines_robust(
        np.broadcast_to(x, shape), np.broadcast_to(y, shape), weights=weights
    )
    low, high = np.percentile(lines.slope, [2.5, 97.5])
    return Estimate(slope, float(low), float(high), len(names))


def misordered(true_speed, level, people, *, lower=2, upper=3, draws=1000, seed=0):
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
    weights = _draw_people(count, draws, seed)
    wrong, total = (((weights @ held) * weights).sum(axis=1) for held in (wrong, total))
    low, high = np.percentile(wrong[total > 0] / total[total > 0], [2.5, 97.5])
    return Estimate(share, float(low), float(high), names)


def level_like(values, level):
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
    values, level = np.asarray(values, dtype=float), np.asarray(level)
    if values.shape != level.shape or values.ndim != 1 or not np.isfinite(values).all():
        raise ArgumentError(
            f"values has shape {values.shape}, level {level.shape}; pass a finite number and a "
            "level a window."
        )
    found = np.empty_like(level)
    found[np.argsort(values, kind="stable")] = np.sort(level)
    return found


def _draw_people(count, draws, seed):
    """How often each of `count` people is drawn, shape (draws, count)."""
    draws = require_count("draws", draws, low=1)
    drawn = np.random.default_rng(seed).integers(count, size=(draws, count))
    cell = drawn + count * np.arange(draws)[:, None]
    return np.bincount(cell.ravel(), minlength=draws * count).reshape(draws, count).astype(float)


def _check_windows(people, **columns):
    """The columns as finite floats of one length, and the number of each one's person."""
    codes = np.unique(np.asarray(people, dtype=str), return_inverse=True)[1]
    held = []
    for name, values in columns.items():
        values = require_numbers(name, values)
        if values.shape != codes.shape or values.ndim != 1 or len(values) == 0:
            raise ArgumentError(
                f"{name} has shape {values.shape}, people {codes.shape}; pass one of each a window."
            )
        if not np.isfinite(values).all():
            raise ArgumentError(f"{name} holds values that are not finite; drop those windows.")
        held.append(values)
    return (*held, codes)
