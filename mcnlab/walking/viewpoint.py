"""Why square-on: from which view angle a walker's gait shows in his box.

The thesis shows three views, in which gait cycles become gradually detectable (section 2.2,
Figure 2.2).  Here they become a curve over the view angle σ: 0 = frontal, 90 = square-on.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mcnlab.cameras.camera import Camera
from mcnlab.checks import require_array, require_count, require_kind, require_number
from mcnlab.compass import heading_of
from mcnlab.errors import ArgumentError, SilhouetteError, TableError
from mcnlab.synthetic.body import draw_body
from mcnlab.synthetic.noise import SegmentationNoise, add_noise
from mcnlab.synthetic.walkers import make_walk
from mcnlab.tables import SEQUENCE, check_columns
from mcnlab.vision.silhouettes import measure_sequence


def view_angle(heading: ArrayLike) -> np.ndarray | float:
    """The angle σ between a walk and the camera's line of sight.

    Parameters
    ----------
    heading : array_like
        Degrees clockwise from "away".

    Returns
    -------
    ndarray or float
        Degrees, 0 (frontal or from behind) … 90 (square-on).
    """
    heading = require_array("heading", heading, remedy="finite degrees")
    return np.abs((heading + 90) % 180 - 90)[()]


def view_angle_of(direction: int) -> float:
    """The view angle σ of one of the eight directions, degrees: 0, 45 or 90."""
    if np.ndim(direction) != 0:
        raise ArgumentError(f"direction is {direction!r}; pass one at a time, 1 to 8.")
    return float(view_angle(heading_of(direction)))


def record_at_angles(
    angles: ArrayLike,
    *,
    subjects: int = 8,
    seed: int = 0,
    noises: Sequence[SegmentationNoise | None] = (None,),
    distance: float = 6.5,
    n_frames: int = 60,
    view: Camera | None = None,
) -> tuple[list[pd.DataFrame], pd.DataFrame]:
    """Synthetic walkers filmed from several view angles, and the truth about their steps.

    Each person walks at each angle twice: once going, to one side, once coming, to the
    other; each walk begins at another moment of the gait cycle.

    Parameters
    ----------
    angles : sequence of float
        View angles σ in mid-walk, degrees, 0 … 90; square-on and close by they differ by
        some 15° from one end of a walk to the middle.
    subjects : int, optional
        People.
    seed : int, optional
        Of the people and of the noise.
    noises : sequence of SegmentationNoise or None, optional
        The same walks are measured once through each.
    distance : float, optional
        Metres ahead of the camera in mid-walk.
    n_frames : int, optional
        At most so many frames, 25 a second, as far as the body is wholly in view.
    view : Camera, optional
        Default: `synthetic.walkers.CASIA_VIEW`.

    Returns
    -------
    tables : list of pandas.DataFrame
        One box table a noise.  A walk in which the noise left no walker is not in it.
    truth : pandas.DataFrame
        Indexed by sequence, every walk: ``subject, angle, heading, step_s``.

    Raises
    ------
    ArgumentError
        When an angle is out of range, there is none, or a noise hides every walker.
    """
    angles = require_array("angles", angles, (None,), low=0, high=90, least=1).tolist()
    noises = require_kind("noises", noises, (list, tuple), "a list of them")
    if len(set(angles)) != len(angles) or not noises:
        raise ArgumentError("angles repeat or noises are empty; pass each angle once.")
    require_kind("view", view, (Camera, type(None)), "a Camera")
    subjects = require_count("subjects", subjects, low=1)
    seed = require_count("seed", seed)
    ways = [(angle, turned) for angle in angles for turned in (angle, angle - 180)]
    tables, rows = [[] for _ in noises], []
    for number in range(1, subjects + 1):
        person = draw_body(np.random.default_rng([seed, number]))
        side = 1 if number % 2 else -1
        for angle, turned in ways:
            heading = side * turned % 360
            # One walk at a time: all the masks together would fill the memory.
            rng = np.random.default_rng([seed, number, len(rows)])
            walk = make_walk(
                replace(person, phase=float(rng.uniform())),
                heading=heading,
                view=view,
                distance=distance,
                max_frames=n_frames,
                name=f"s{number:02d}-{len(rows):04d}",
                subject=f"s{number:02d}",
            )
            for table, noise in zip(tables, noises, strict=True):
                masks = walk.masks
                if noise is not None:
                    masks = add_noise(masks, noise, seed=seed + len(rows))
                try:
                    boxes = measure_sequence(masks, sequence=walk.name, subject=walk.subject)
                except SilhouetteError:
                    continue  # detectability counts it as not detected
                table.append(boxes)
            rows.append((walk.name, walk.subject, angle, heading, 1 / person.cadence))
    if not all(tables):
        raise ArgumentError("noises: one hides every walker; turn it down.")
    truth = pd.DataFrame(rows, columns=[SEQUENCE, "subject", "angle", "heading", "step_s"])
    return [pd.concat(table, ignore_index=True) for table in tables], truth.set_index(SEQUENCE)


def detectability(
    gait: pd.DataFrame, angles: pd.Series, *, steps: pd.Series | None = None, tolerance: float = 0.1
) -> pd.DataFrame:
    """How well steps show at each view angle.

    Parameters
    ----------
    gait : pandas.DataFrame
        From `measure_gait`.
    angles : pandas.Series
        View angle σ, degrees, indexed by sequence.  A walk that `gait` lacks could not be
        measured: it counts as not detected, with a peak and a swing of 0.
    steps : pandas.Series, optional
        The true step periods, s, indexed by sequence.
    tolerance : float, optional
        A period is right when it is off by no more than this share.

    Returns
    -------
    pandas.DataFrame
        One row an angle, rising: ``angle, walks, detected`` (counts), ``share``, median
        ``peak`` with quartiles ``peak_low, peak_high``, median ``swing``; with `steps` also
        ``right`` (count detected and right) and ``right_share``.  Without, ``step_s``: the
        median period of the walks detected, 0 if none is.

    Raises
    ------
    TableError, ArgumentError
        When `gait` lacks a column, a walk has no angle or no true period, or a value is
        out of range.
    """
    names = ("step_s", "peak", "swing", "detectable")
    check_columns(gait, names, argument="gait")
    if not gait.index.is_unique:
        raise TableError("gait names a sequence twice; pass a table from measure_gait.")
    tolerance = require_number("tolerance", tolerance, low=0)
    angles = _check_series("angles", angles, gait.index, low=0, high=90)
    table = gait[list(names)].astype(float).reindex(angles.index, fill_value=0.0)
    detected = table["detectable"].to_numpy(bool)
    table = table.assign(angle=angles.astype(float), detected=detected)
    groups = table.groupby("angle")
    out = groups["detected"].agg(walks="size", detected="sum", share="mean")
    for name, share in (("peak", 0.5), ("peak_low", 0.25), ("peak_high", 0.75)):
        out[name] = groups["peak"].quantile(share)
    out["swing"] = groups["swing"].median()
    if steps is None:
        medians = table[detected].groupby("angle")["step_s"].median()
        out["step_s"] = medians.reindex(out.index, fill_value=0.0)
    else:
        true = _check_series("steps", steps, angles.index, above=0)[angles.index].to_numpy(float)
        table["right"] = detected & (np.abs(table["step_s"] - true) <= tolerance * true)
        out[["right", "right_share"]] = table.groupby("angle")["right"].agg(["sum", "mean"])
    return out.reset_index()


def half_peak_angle(table: pd.DataFrame) -> float:
    """From square-on towards frontal, the angle at which half the peak is lost.

    Parameters
    ----------
    table : pandas.DataFrame
        From `detectability`: ``angle, peak``, two angles or more.

    Returns
    -------
    float
        Degrees, by a straight line between the angles around it.

    Raises
    ------
    TableError, ArgumentError
        When a column is missing or holds a value that is not a finite number, or the peak
        at the largest angle is not positive or does not fall to its half.
    """
    names = ("angle", "peak")
    check_columns(table, names, argument="table")
    angle, peak = (require_array(f"table's {n}", table[n], error=TableError) for n in names)
    rising = np.argsort(angle, kind="stable")
    angle, peak = angle[rising], peak[rising]
    below = np.flatnonzero(peak <= peak[-1] / 2) if len(peak) and peak[-1] > 0 else []
    if len(below) == 0:
        raise ArgumentError(
            "table: the peak is nowhere half of that at the largest angle; add angles that are "
            "nearer to frontal, and a square-on one."
        )
    around = slice(below[-1], below[-1] + 2)
    return float(np.interp(peak[-1] / 2, peak[around], angle[around]))


def _check_series(name, series, wanted, **bounds):
    """`series` when it gives each sequence of `wanted` one number within bounds."""
    if not isinstance(series, pd.Series) or not series.index.is_unique or series.empty:
        raise ArgumentError(f"{name} must be a pandas Series, one number a sequence.")
    missing = [sequence for sequence in wanted if sequence not in series.index]
    if missing:
        raise TableError(f"{name} lacks sequence(s) {', '.join(map(str, missing[:5]))}; add them.")
    require_array(name, series, **bounds)
    return series
