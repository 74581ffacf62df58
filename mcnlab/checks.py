"""Checks of arrays, most with one entry a pair; `mcnlab.errors` checks single values.

What is sound comes back as an array; messages name the argument and the first bad pair.
"""

import math
from numbers import Integral, Real

import numpy as np
import pandas as pd

from mcnlab.errors import ArgumentError


def require_flat(name, values):
    """Return `values` as a flat array without gaps, or raise `ArgumentError`."""
    try:
        values = np.asarray(values)
    except ValueError:  # ragged
        values = np.empty((0, 0))
    if values.ndim != 1 or pd.isna(values).any():
        raise ArgumentError(f"{name} must be a flat list without gaps; pass one entry a pair.")
    return values


def require_flags(name, values):
    """Return `values` as a flat array of bool with an entry, or raise `ArgumentError`."""
    values = require_flat(name, values)
    if len(values) == 0 or not np.isin(values, (0, 1)).all():
        raise ArgumentError(f"{name} must hold True or False, one a pair, for at least one pair.")
    return values.astype(bool)


def require_numbers(name, values):
    """Return `values` as an array of float, NaN and inf among them, or raise `ArgumentError`."""
    try:
        return np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise ArgumentError(f"{name} holds what is no number; pass numbers only.") from None


def require_probabilities(name, values):
    """Return `values` as an array of float from 0 to 1, or raise `ArgumentError`."""
    values = require_numbers(name, values)
    require_all(name, values, (values >= 0) & (values <= 1), "pass numbers from 0 to 1")
    return values


def require_all(name, values, sound, remedy):
    """Raise `ArgumentError` naming the first of `values` that is not `sound`."""
    if not sound.all():
        row = int(np.flatnonzero(~sound)[0])
        raise ArgumentError(f"{name} is {values[row]:g} at pair {row}; {remedy}.")


def require_length(like, *, of="occludes", **others):
    """Raise `ArgumentError` unless all `others` have the shape of the array `like`."""
    for name, values in others.items():
        if np.shape(values) != like.shape:
            raise ArgumentError(
                f"{name} has shape {np.shape(values)}, {of} {like.shape}; pass one a pair."
            )


def require_positive(occludes, *, name="occludes"):
    """Raise `ArgumentError` when no pair occludes."""
    if not occludes.any():
        raise ArgumentError(
            f"{name} names no pair that occludes (and counts), so there is nothing to find; "
            "pass at least one."
        )


def require_number(name, value, *, low=None, high=None, above=None, unit=""):
    """Return `value` as a float, or raise.

    Parameters
    ----------
    name : str
        The argument's name, for the message.
    value : object
        What was passed.
    low, high : float, optional
        Inclusive bounds.
    above : float, optional
        Exclusive lower bound.
    unit : str, optional
        The unit, for the message.

    Raises
    ------
    ArgumentError
        When `value` is not a finite number within the bounds.
    """
    bounds = []
    if above is not None:
        bounds.append(f"above {above:g}")
    if low is not None:
        bounds.append(f"at least {low:g}")
    if high is not None:
        bounds.append(f"at most {high:g}")
    wanted = " ".join(["a finite number", " and ".join(bounds), f"({unit})" if unit else ""])
    wanted = " ".join(wanted.split())
    if isinstance(value, bool) or not isinstance(value, Real) or not math.isfinite(value):
        raise ArgumentError(f"{name} is {value!r}; pass {wanted}.")
    if (
        (above is not None and value <= above)
        or (low is not None and value < low)
        or (high is not None and value > high)
    ):
        raise ArgumentError(f"{name} is {value!r}; pass {wanted}.")
    return float(value)


def require_count(name, value, *, low=0):
    """Return `value` as an int of at least `low`, or raise `ArgumentError`."""
    if isinstance(value, bool) or not isinstance(value, Integral) or value < low:
        raise ArgumentError(f"{name} is {value!r}; pass a whole number of at least {low}.")
    return int(value)


def require_choice(name, value, choices):
    """Return `value` when it is one of `choices`, or raise `ArgumentError`."""
    if value not in choices:
        listed = ", ".join(repr(choice) for choice in choices)
        raise ArgumentError(f"{name} is {value!r}; pass one of {listed}.")
    return value


HAIR = 1e-9  # relative; nearer than this to an edge is on it
MOST_FAR = 1e12  # metres or pixels


def check_points(name, points, *, low=1):
    """Return `points` as floats of shape (n, 2), or raise `ArgumentError`."""
    try:
        points = np.asarray(points, dtype=float)
    except (TypeError, ValueError) as fault:
        raise ArgumentError(f"{name} are not numbers ({fault}); pass rows of x, y.") from fault
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < low:
        raise ArgumentError(
            f"{name} has the shape {points.shape}; pass at least {low} rows of x, y."
        )
    sound = (np.abs(points) <= MOST_FAR).all(axis=1)  # not so for NaN
    if not sound.all():
        row = int(np.flatnonzero(~sound)[0])
        raise ArgumentError(f"{name} row {row} is not finite, or beyond any place; mend it.")
    return points
