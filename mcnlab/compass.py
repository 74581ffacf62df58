"""The eight directions and headings: 1 is away, clockwise seen from above (Figure 3.2)."""

import numpy as np
from numpy.typing import ArrayLike

from mcnlab.checks import require_array

DIRECTIONS = tuple(range(1, 9))

NAMES = {
    1: "away",
    2: "away-right",
    3: "right",
    4: "toward-right",
    5: "toward",
    6: "toward-left",
    7: "left",
    8: "away-left",
}


def heading_of(direction: ArrayLike) -> np.ndarray:
    """The heading of a direction 1 … 8, degrees clockwise from "away".

    Raises
    ------
    ArgumentError
        When a direction is not one of the whole numbers 1 to 8.

    Examples
    --------
    >>> heading_of([1, 2, 3, 8])
    array([  0.,  45.,  90., 315.])
    """
    return 45.0 * (require_directions("direction", direction) - 1)


def direction_of(heading: ArrayLike) -> np.ndarray:
    """The direction 1 … 8 nearest to a heading.

    Parameters
    ----------
    heading : array_like
        Degrees clockwise from "away".

    Raises
    ------
    ArgumentError
        When a heading is not finite.

    Examples
    --------
    >>> direction_of([0, 50, 359])
    array([1, 2, 1])
    """
    heading = require_array("heading", heading, remedy="finite degrees")
    return np.round(heading / 45.0).astype(int) % 8 + 1


def turn_between(heading: ArrayLike, reference: ArrayLike) -> np.ndarray:
    """The signed turn from `reference` to `heading`, degrees in [−180, 180).

    Examples
    --------
    >>> turn_between([10, 350], [350, 10]).tolist()
    [20.0, -20.0]
    """
    return (np.asarray(heading) - np.asarray(reference) + 180.0) % 360.0 - 180.0


def require_directions(name: str, directions: ArrayLike) -> np.ndarray:
    """Return `directions` as whole numbers 1 … 8, or raise `ArgumentError`."""
    return require_array(
        name, directions, dtype=int, low=1, high=8, remedy="the whole numbers 1 to 8"
    )
