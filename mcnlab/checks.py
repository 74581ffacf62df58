"""Checks of arrays, most with one entry a pair; `mcnlab.errors` checks single values.

What is sound comes back as an array; messages name the argument and the first bad pair.
"""

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
