"""The eight directions and headings: 1 is away, clockwise seen from above (Figure 3.2)."""

import numpy as np

from mcnlab.errors import ArgumentError

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


def heading_of(direction):
    """The heading of a direction 1 … 8, degrees clockwise from "away"."""
    return 45.0 * (_check_directions(direction) - 1)


def direction_of(heading):
    """The direction 1 … 8 nearest to a heading.

    Parameters
    ----------
    heading : array_like
        Degrees clockwise from "away".
    """
    heading = np.asarray(heading, dtype=float)
    if not np.isfinite(heading).all():
        raise ArgumentError("heading holds values that are not finite; pass degrees.")
    return np.round(heading / 45.0).astype(int) % 8 + 1


def turn_between(heading, reference):
    """The signed turn from `reference` to `heading`, degrees in [−180, 180)."""
    return (np.asarray(heading) - np.asarray(reference) + 180.0) % 360.0 - 180.0


def _check_directions(directions):
    directions = np.asarray(directions)
    if not np.isin(directions, DIRECTIONS).all():
        raise ArgumentError("directions holds values other than the whole numbers 1 to 8.")
    return directions.astype(int)
