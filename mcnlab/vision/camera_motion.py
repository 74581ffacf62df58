"""Does the camera move?  MOTChallenge's own word, or an estimate from the boxes alone."""

import re
from typing import Final

import numpy as np

from mcnlab.datasets.recording import Recording
from mcnlab.errors import DatasetError
from mcnlab.tables import CX, CY

# The benchmark's own word for its cameras.  MOT16 has the videos of MOT17; all of MOT20 are
# static, though some sway a little.
STATIC: Final = frozenset(
    {f"mot17-{number:02d}" for number in (1, 2, 3, 4, 8, 9)}
    | {f"mot20-{number:02d}" for number in range(1, 9)}
    | {"adl-rundle-3", "adl-rundle-6", "avg-towncentre", "kitti-16", "kitti-17", "pets09-s2l1"}
    | {"pets09-s2l2", "tud-campus", "tud-crossing", "tud-stadtmitte", "venice-1", "venice-2"}
)

MOVING: Final = frozenset(
    {f"mot17-{number:02d}" for number in (5, 6, 7, 10, 11, 12, 13, 14)}
    | {"adl-rundle-1", "adl-rundle-8", "eth-bahnhof", "eth-crossing", "eth-jelmoli"}
    | {"eth-linthescher", "eth-pedcross2", "eth-sunnyday", "kitti-13", "kitti-19"}
)

# Share of the boxes' acceleration that all have in common, above which a camera is taken to
# move.  Ten seconds of any of the four static sequences at hand stay below 0.27, and a whole
# sequence below 0.06.  A bob of 0.1 % of the frame's width at two steps a second, added to
# them, gives more than 0.7, and a pan to and fro by 2 % every four seconds more than 0.4.
SHARED: Final = 0.3
_SPANS: Final = (0.25, 0.5)  # seconds between the three boxes of an acceleration


def moves(recording: Recording) -> bool:
    """Whether the camera moves: as the benchmark says, or by an estimate for other names.

    Parameters
    ----------
    recording : Recording

    Returns
    -------
    bool
        For a name that the benchmark does not know, whether `shared_motion` exceeds `SHARED`.

    Raises
    ------
    DatasetError
        When the name is not known and there is nothing to estimate from.
    """
    known = known_motion(recording.name)
    return shared_motion(recording) > SHARED if known is None else known


def known_motion(name: str) -> bool | None:
    """Whether the benchmark says that a sequence's camera moves; None if it does not say.

    Parameters
    ----------
    name : str
        Such as "mot17-02-frcnn", in any case.
    """
    name = name.lower()
    found = re.fullmatch(r"mot1[67]-(\d\d)(-\w+)?", name)  # with or without a detector's name
    name = f"mot17-{found[1]}" if found else name
    return name in MOVING if name in MOVING | STATIC else None


def shared_motion(recording: Recording) -> float:
    """The share of the boxes' acceleration that all people in a frame have in common.

    People walk each in their own way, so the accelerations a of two boxes in one frame are
    uncorrelated; a camera that shakes, bobs or pans moves all boxes together.  The share is
    the intraclass correlation, sum of a_i·a_j over all pairs i ≠ j in the same frame against
    the same sum with a_i² in the place of the products: 0 for a fixed camera on average, 1
    when all boxes move as one.  Accelerations are second differences of the boxes' centres
    over a quarter and over half a second, across and down, cut off at their 99th percentile;
    the largest of the four shares counts.

    This is an estimate.  A slow and even pan or drive has no acceleration and goes unseen; a
    group that starts or stops together looks like a moving camera.

    Parameters
    ----------
    recording : Recording

    Returns
    -------
    float
        At most 1; slightly below 0 by chance.

    Raises
    ------
    DatasetError
        When no two people are boxed together for half a second.
    """
    stack = recording.stack
    shares = []
    for seconds in _SPANS:
        span = max(1, round(seconds * recording.frame_rate))
        early, middle, late = (slice(k * span, k * span - 2 * span or None) for k in range(3))
        there = stack.valid[:, early] & stack.valid[:, middle] & stack.valid[:, late]
        row, column = np.nonzero(there)
        _, frame = np.unique(stack.start[row] + column, return_inverse=True)
        others = np.bincount(frame) - 1
        if not others.any():
            raise DatasetError(
                f"{recording.name} never shows two people together for half a second, so there is "
                "no telling whether its camera moves; pass a longer recording."
            )
        for name in (CX, CY):
            curve = stack.curves[name]
            bend = (curve[:, late] - 2 * curve[:, middle] + curve[:, early])[there]
            most = np.quantile(np.abs(bend), 0.99)
            bend = np.clip(bend, -most, most)
            squares = np.bincount(frame, bend**2)
            total = (others * squares).sum()
            products = (np.bincount(frame, bend) ** 2 - squares).sum()
            shares.append(products / total if total > 0 else 0.0)
    return float(max(shares))
