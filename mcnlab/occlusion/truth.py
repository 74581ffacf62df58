"""Whether, when and where two walkers cover each other, from their boxes: the one truth.

Boxes are those of `mcnlab.tables`, which says what pixels they cover.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from mcnlab.checks import require_array
from mcnlab.errors import ArgumentError

COVER = 0.3  # the share of the smaller box that must be exceeded for occlusion


class Truth(NamedTuple):
    """What becomes of n pairs, one element a pair."""

    now: np.ndarray  # the cover at the moment; 0 where not both have a box
    occludes: np.ndarray  # bool: in a later frame
    frame: np.ndarray  # the first such frame, counted from the moment; 0 where there is none
    x: np.ndarray  # the middle of the intersection in that frame, pixels
    y: np.ndarray


def find_occlusions(first: Sequence, second: Sequence, both: np.ndarray, *, cover: float) -> Truth:
    """When and where pairs of boxes first cover each other, after the moment itself.

    Parameters
    ----------
    first, second : sequence of ndarray, shape (n, frames) each
        ``x, y, w, h``; the first column is the moment.
    both : ndarray of bool, shape (n, frames)
        Where both have a box; other boxes are not looked at.
    cover : float
        What the cover (see `cover_of`) must exceed.

    Returns
    -------
    Truth
    """
    covers = np.where(both, _share(first, second), 0.0)
    hit = covers[:, 1:] > cover
    occludes = hit.any(axis=1)
    frame = np.where(occludes, hit.argmax(axis=1) + 1 if hit.size else 0, 0)
    at = np.arange(len(frame)), frame
    x, y = middle_of(*([values[at] for values in box] for box in (first, second)))
    return Truth(covers[:, 0], occludes, frame, x, y)


def cover_of(first: Sequence, second: Sequence) -> np.ndarray:
    """The intersection of boxes as a share of the smaller box.

    Parameters
    ----------
    first, second : tuple of array_like
        ``x, y, w, h`` that broadcast: left, top, width, height, pixels.

    Returns
    -------
    ndarray
        Between 0 and 1; boxes that only touch have 0.

    Raises
    ------
    ArgumentError
        When a number is not finite, or a width or height not positive.
    """
    return _share(_require_boxes("first", first), _require_boxes("second", second))


def middle_of(first: Sequence, second: Sequence) -> tuple[np.ndarray, np.ndarray]:
    """The middle of two boxes' intersection (of the gap, where they are apart), pixels.

    A box covers pixels x … x + w − 1, so its middle is x + (w − 1)/2; see `mcnlab.tables`.
    """
    x, y = (
        (np.maximum(one, two) + np.minimum(one + size, two + other) - 1) / 2
        for one, size, two, other in (
            (first[0], first[2], second[0], second[2]),
            (first[1], first[3], second[1], second[3]),
        )
    )
    return x, y


def _require_boxes(name: str, box: Sequence) -> list[np.ndarray]:
    if len(box) != 4:
        raise ArgumentError(f"{name} has {len(box)} entries; pass x, y, w, h.")
    return [
        require_array(f"{name}.{axis}", values, above=least)
        for axis, values, least in zip("xywh", box, (None, None, 0, 0), strict=True)
    ]


def _share(first: Sequence, second: Sequence) -> np.ndarray:
    """`cover_of`, unchecked; 0 where a box is empty."""
    (x, y, w, h), (u, v, a, b) = first, second
    across = np.minimum(x + w, u + a) - np.maximum(x, u)
    down = np.minimum(y + h, v + b) - np.maximum(y, v)
    smaller = np.minimum(w * h, a * b)
    covered = np.maximum(across, 0) * np.maximum(down, 0)
    # Edges are rounded, so that a box could cover itself by a little more than 1.
    return np.minimum(covered / np.where(smaller > 0, smaller, 1.0), 1.0)
