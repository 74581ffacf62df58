"""From feet to traces on the ground, and how traces are scored.

Feet found in each frame (see `feet`) are taken to the ground, where gates are in metres, and
linked from frame to frame; a trace is the smoothest walk that the feet allow (thesis section
2.3, Figure 2.9).

References
----------
P. H. C. Eilers, "A perfect smoother", Analytical Chemistry 75(14), 2003.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mcnlab.checks import require_array, require_kind, require_number
from mcnlab.datasets.video import Video
from mcnlab.errors import ArgumentError, TableError
from mcnlab.tables import (
    FRAME,
    FRAME_LIMIT,
    PIXEL_LIMIT,
    TRACE,
    X,
    Y,
    check_columns,
    check_traces,
    starts_of,
)
from mcnlab.vision.feet import (
    BACKGROUND,
    COARSEST,
    check_mask_options,
    detect_feet,
    learn_height,
    moving_masks,
    person_sizes,
    trunk_widths,
)

STIFFEST = 1e9
LONGEST_GAP = 10_000  # frames
LEARN_FRAMES = 500  # to learn from how tall people appear
WALKING = 1.4  # m/s, the spread of a walker's unknown first velocity


def link(
    detections: pd.DataFrame,
    *,
    frame_rate: float,
    gate: float = 1.5,
    most_gap: float = 2.0,
    shortest: float = 1.0,
    noise: float = 0.25,
    acceleration: float = 0.6,
) -> pd.DataFrame:
    """Link feet from frame to frame: one trace a walker.

    Each walker is expected where a constant velocity takes it (a Kalman filter with random
    acceleration); feet and expectations are paired one to one so that the sum of squared
    distances is least, pairs farther apart than the gate never.  A walker who is not seen,
    because another covers it, is expected on for a while; the gap is filled when it is
    seen again.  Then every trace is smoothed as a whole (see `smooth`).

    Parameters
    ----------
    detections : pandas.DataFrame
        ``frame, x, y``: feet on the ground, metres, in any order.
    frame_rate : float
        Frames a second.
    gate : float, optional
        Metres between a walker's expected and found place.
    most_gap : float, optional
        Seconds without feet that a trace may bridge.
    shortest : float, optional
        Seconds; a trace of fewer feet is dropped.
    noise : float, optional
        Standard deviation of a detection, metres.
    acceleration : float, optional
        Standard deviation of a walker's acceleration, m/s².

    Returns
    -------
    pandas.DataFrame
        A trace table, named "1", "2", … in order of appearance.

    Raises
    ------
    TableError
        When `detections` is not such a table, or no trace is long enough.
    """
    frame_rate = require_number("frame_rate", frame_rate, above=0, unit="frames a second")
    gate = require_number("gate", gate, above=0, unit="metres")
    most_gap = require_number("most_gap", most_gap, low=0, unit="seconds")
    shortest = require_number("shortest", shortest, low=0, unit="seconds")
    noise = require_number("noise", noise, above=0, unit="metres")
    acceleration = require_number("acceleration", acceleration, above=0, unit="m/s²")
    if most_gap * frame_rate > LONGEST_GAP:
        raise ArgumentError(
            f"most_gap is {most_gap:g} s, {most_gap * frame_rate:g} frames; nobody is expected "
            f"back after {LONGEST_GAP} frames: pass less."
        )
    frame, places = _check_detections(detections)
    kick = acceleration / frame_rate**2  # metres a frame, each frame
    walker = _associate(
        frame,
        places,
        gate=gate,
        most_gap=most_gap * frame_rate,
        noise=noise,
        kick=kick,
        pace=WALKING / frame_rate,
    )
    tables = []
    for rows in pd.Series(walker).groupby(walker).indices.values():
        if len(rows) < max(2.0, shortest * frame_rate):
            continue
        steps = np.arange(frame[rows[0]], frame[rows[-1]] + 1)
        held, seen = np.zeros((len(steps), 2)), np.zeros(len(steps))
        held[frame[rows] - steps[0]], seen[frame[rows] - steps[0]] = places[rows], 1.0
        place = smooth(held, weights=seen, stiffness=(noise / kick) ** 2)
        name = str(len(tables) + 1)
        tables.append(pd.DataFrame({TRACE: name, FRAME: steps, X: place[:, 0], Y: place[:, 1]}))
    if not tables:
        raise TableError(
            f"detections hold no trace of {shortest:g} s; pass a smaller shortest, a wider gate, "
            "or more frames."
        )
    return check_traces(pd.concat(tables, ignore_index=True))


def _associate(frame, places, *, gate, most_gap, noise, kick, pace):
    """The number of each detection's walker."""
    from scipy.optimize import linear_sum_assignment

    walker = np.full(len(frame), -1)
    first = np.diag([noise**2, pace**2])
    # Of each walker expected: name, last frame seen, state (place, velocity) × (x, y), and
    # the state's covariance, which is the same along x and y.
    name, last = np.empty(0, int), np.empty(0, int)
    state, spread = np.empty((0, 2, 2)), np.empty((0, 2, 2))
    names = 0
    starts = starts_of(frame)
    for start, stop in zip(starts, np.r_[starts[1:], len(frame)], strict=True):
        now = frame[start]
        kept = now - last - 1 <= most_gap
        name, last, state, spread = name[kept], last[kept], state[kept], spread[kept]
        steps = float(now - frame[start - 1]) if start else 0.0
        move = np.array([[1.0, steps], [0.0, 1.0]])
        # What as many random accelerations, each through its frame, add up to.
        across = steps**2 / 2
        shake = kick**2 * np.array([[steps**3 / 3 - steps / 12, across], [across, steps]])
        state, spread = move @ state, move @ spread @ move.T + shake
        found = places[start:stop]
        square = ((state[:, None, 0] - found[None]) ** 2).sum(axis=2)
        # A pair beyond the gate costs more than any set of pairs within it.
        barred = gate**2 * (1 + min(square.shape))
        mine, its = linear_sum_assignment(np.where(square <= gate**2, square, barred))
        near = square[mine, its] <= gate**2
        mine, its = mine[near], its[near]
        gain = spread[mine, :, 0] / (spread[mine, 0, 0] + noise**2)[:, None]
        state[mine] += gain[:, :, None] * (found[its] - state[mine, 0])[:, None, :]
        spread[mine] -= gain[:, :, None] * spread[mine, None, 0, :]
        last[mine] = now
        walker[start + its] = name[mine]
        new = np.setdiff1d(np.arange(len(found)), its)
        born = names + np.arange(len(new))
        names += len(new)
        walker[start + new] = born
        still = np.stack([found[new], np.zeros((len(new), 2))], axis=1)
        name, last = np.r_[name, born], np.r_[last, np.full(len(new), now)]
        state = np.concatenate([state, still])
        spread = np.concatenate([spread, np.tile(first, (len(new), 1, 1))])
    return walker


def smooth(
    places: ArrayLike, *, weights: ArrayLike, stiffness: float, huber: float = 2.0
) -> np.ndarray:
    """The smoothest walk through places: Whittaker's smoother, robust to strays.

    What is least is ∑ w·|z − p|² + stiffness · ∑ |z″|², with z″ the second difference; frames
    of weight 0 are filled in.  With stiffness the ratio of the noise's variance to that of
    the acceleration, it gives what a Kalman smoother gives.  Places farther from the
    walk than `huber` robust standard deviations lose weight, in three rounds.

    Parameters
    ----------
    places : array_like, shape (n, 2)
        Finite, also where the weight is 0.
    weights : array_like, shape (n,)
        Not negative, at least two positive.
    stiffness : float
    huber : float, optional

    Returns
    -------
    ndarray, shape (n, 2)

    Raises
    ------
    ArgumentError
        When fewer than two weights are positive, or a value is impossible.
    """
    from scipy.linalg import solveh_banded

    places = require_array("places", places, ("n", 2))
    weights = require_array("weights", weights, (len(places),), low=0)
    # Beyond this a walk is straight to a micrometre, and the system singular to rounding.
    stiffness = min(require_number("stiffness", stiffness, low=0), STIFFEST)
    huber = require_number("huber", huber, above=0)
    n = len(places)
    if (weights > 0).sum() < 2:
        raise ArgumentError("weights must be positive for at least two places.")
    # stiffness·DᵀD in upper banded form, D the second differences.
    bands = np.zeros((3, n))
    difference = (1.0, -2.0, 1.0)
    for first, one in enumerate(difference):
        for second in range(first, 3):
            band = bands[2 - (second - first)]
            band[second : second + max(n - 2, 0)] += stiffness * one * difference[second]
    pull = weights
    for _ in range(3):
        system = bands.copy()
        system[2] += pull
        walk = solveh_banded(system, pull[:, None] * places)
        away = np.hypot(*(walk - places).T)
        limit = np.maximum(huber * 1.4826 * np.median(away[weights > 0]), 1e-9)
        pull = weights * np.minimum(1.0, limit / np.maximum(away, 1e-12))
    return walk


def _check_detections(detections):
    """Frames and places of detections, in order of frame."""
    check_columns(detections, (FRAME, X, Y), argument="detections")
    if len(detections) == 0:
        raise TableError("detections has no rows; nobody moved.")
    frame, x, y = (
        require_array(
            f"detections.{name}", detections[name], low=-most, high=most, error=TableError
        )
        for name, most in ((FRAME, FRAME_LIMIT), (X, PIXEL_LIMIT), (Y, PIXEL_LIMIT))
    )
    frame = require_array(FRAME, frame, dtype=int, error=TableError)
    # Within a frame by place, so that the order of rows does not matter.
    order = np.lexsort((y, x, frame))
    return frame[order], np.c_[x, y][order]


def trace_video(
    video: Video,
    to_ground: Callable,
    *,
    method: str = BACKGROUND,
    height: Callable | float | None = None,
    coarsest: float = COARSEST,
    mask_options: dict | None = None,
    **options: Any,
) -> pd.DataFrame:
    """The whole chain: a video to traces on the ground (thesis section 2.3).

    Parameters
    ----------
    video : Video
    to_ground : callable
        Image points (n, 2) → ground metres (n, 2): `Camera.to_ground`, or
        ``functools.partial(ground.project, homography)``.
    method : str, optional
        One of `METHODS`: "background", or an optical flow.
    height : callable, float or None, optional
        How tall a person appears, see `person_sizes`; learnt from the silhouettes if
        not given.
    coarsest : float, optional
        Metres on the ground a pixel, beyond which a place is too far away.
    mask_options : dict, optional
        For `background_masks` or `flow_masks`, such as ``{"speed": 0.8}``; one that the
        method does not have is refused.
    **options
        For `link`: gate, most_gap, shortest, noise, acceleration.

    Returns
    -------
    pandas.DataFrame
        A trace table, metres.

    Raises
    ------
    SilhouetteError
        When nobody moved.
    ArgumentError, DatasetError, TableError
        As the steps do.

    Examples
    --------
    A block of 12 by 30 pixels that moves by three a frame, seen at 0.05 m a pixel.

    >>> from mcnlab.datasets.video import open_video
    >>> frames = np.full((30, 60, 160), 90, np.uint8)
    >>> for at, frame in enumerate(frames):
    ...     frame[20:50, 20 + 3 * at : 32 + 3 * at] = 200
    >>> video = open_video(frames, frame_rate=10.0)
    >>> traces = trace_video(video, lambda points: 0.05 * points, height=30.0)
    >>> traces["trace"].unique().tolist()
    ['1']
    """
    mask_options = {} if mask_options is None else mask_options
    require_kind("mask_options", mask_options, dict, "a dict, such as {'speed': 0.8}")
    check_mask_options(method, mask_options)
    masks = moving_masks(video, method=method, **mask_options)
    widths = trunk_widths((video.height, video.width), to_ground, coarsest=coarsest)
    if height is None:
        some = islice(moving_masks(video, method=method, **mask_options), LEARN_FRAMES)
        height = learn_height(some, widths)
    feet = detect_feet(masks, person_sizes(widths, height), to_ground)
    return link(feet, frame_rate=video.frame_rate, **options)


@dataclass(frozen=True, eq=False)
class TraceScore:
    """How well traces agree with the truth.

    Attributes
    ----------
    radius : float
        Metres within which a trace point and a true foot can be a pair.
    feet : pandas.DataFrame
        The true feet: ``trace, frame, x, y``, ``found`` (bool) and ``error`` (metres; the
        radius where not found).
    points : pandas.DataFrame
        The trace points, in the same columns with ``matched`` for ``found``, and
        ``whose``: the true trace it is paired with, "" where there is none.
    """

    radius: float
    feet: pd.DataFrame
    points: pd.DataFrame

    @property
    def recall(self) -> float:
        """Share of the true feet that a trace passes."""
        return float(self.feet["found"].mean())

    @property
    def precision(self) -> float:
        """Share of the trace points at a true foot; 0 if there are no points."""
        return float(self.points["matched"].mean()) if len(self.points) else 0.0

    @property
    def median_error(self) -> float:
        """Median distance of the pairs, metres; the radius if there are none."""
        error = self.feet["error"][self.feet["found"]]
        return float(error.median()) if len(error) else self.radius

    def between(self, start: int, stop: int) -> "TraceScore":
        """The score of frames `start` to `stop` − 1."""
        feet, points = (
            table[table[FRAME].between(start, stop - 1)].reset_index(drop=True)
            for table in (self.feet, self.points)
        )
        if len(feet) == 0:
            raise ArgumentError(f"start is {start}, stop {stop}: no true feet between; widen them.")
        return TraceScore(self.radius, feet, points)


def score_traces(traces: pd.DataFrame, truth: pd.DataFrame, *, radius: float = 1.0) -> TraceScore:
    """Score traces against true feet, frame by frame.

    In each frame trace points and true feet are paired one to one, as many pairs within the
    radius as possible, and among those the nearest in sum.

    Parameters
    ----------
    traces, truth : pandas.DataFrame
        Trace tables, metres.  Trace points in frames before the truth's first or after its
        last are not judged.
    radius : float, optional
        Metres.

    Returns
    -------
    TraceScore
    """
    from scipy.optimize import linear_sum_assignment

    check_traces(traces)
    check_traces(truth, argument="truth")
    radius = require_number("radius", radius, above=0, unit="metres")
    feet = truth[[TRACE, FRAME, X, Y]].reset_index(drop=True)
    points = traces[[TRACE, FRAME, X, Y]]
    points = points[points[FRAME].between(feet[FRAME].min(), feet[FRAME].max())]
    points = points.reset_index(drop=True)
    feet_at, points_at = (table.groupby(FRAME).indices for table in (feet, points))
    foot_error, point_error = np.full(len(feet), np.inf), np.full(len(points), np.inf)
    whose = np.full(len(points), "", dtype=object)
    names = feet[TRACE].to_numpy(dtype=object)
    foot_place, point_place = feet[[X, Y]].to_numpy(float), points[[X, Y]].to_numpy(float)
    for frame in sorted(feet_at.keys() & points_at.keys()):
        ours, theirs = points_at[frame], feet_at[frame]
        distance = np.linalg.norm(point_place[ours][:, None] - foot_place[theirs][None], axis=2)
        barred = radius * (1 + min(distance.shape))
        i, j = linear_sum_assignment(np.where(distance <= radius, distance, barred))
        point_error[ours[i]] = foot_error[theirs[j]] = distance[i, j]
        near = distance[i, j] <= radius
        whose[ours[i[near]]] = names[theirs[j[near]]]
    feet["found"], points["matched"] = foot_error <= radius, point_error <= radius
    feet["error"], points["error"] = np.minimum(foot_error, radius), np.minimum(point_error, radius)
    points["whose"] = whose
    return TraceScore(radius, feet, points)
