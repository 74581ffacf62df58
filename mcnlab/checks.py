"""The one set of checks of arguments; what is sound comes back, converted.

Every message names the argument, says what was wrong with it, and what to do.
"""

import math
from collections.abc import Collection
from numbers import Integral, Real
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mcnlab.errors import ArgumentError, McnError

HAIR = 1e-9  # relative; nearer than this to an edge is on it
MOST_FAR = 1e12  # metres or pixels


def require_number(
    name: str,
    value: Any,
    *,
    low: float | None = None,
    high: float | None = None,
    above: float | None = None,
    unit: str = "",
) -> float:
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
    wanted = _wanted("a finite number", low, high, above, unit)
    if isinstance(value, bool) or not isinstance(value, Real) or not math.isfinite(value):
        raise ArgumentError(f"{name} is {value!r}; pass {wanted}.")
    if not _within(value, low, high, above):
        raise ArgumentError(f"{name} is {value!r}; pass {wanted}.")
    return float(value)


def require_count(name: str, value: Any, *, low: int = 0, high: int | None = None) -> int:
    """Return `value` as an int of at least `low`, and at most `high`, or raise `ArgumentError`."""
    whole = isinstance(value, Integral) and not isinstance(value, bool)
    if not whole or value < low or (high is not None and value > high):
        most = "" if high is None else f" and at most {high}"
        raise ArgumentError(f"{name} is {value!r}; pass a whole number of at least {low}{most}.")
    return int(value)


def require_choice(name: str, value: Any, choices: Collection) -> Any:
    """Return `value` when it is one of `choices`, or raise `ArgumentError`."""
    if value not in choices:
        listed = ", ".join(repr(choice) for choice in choices)
        raise ArgumentError(f"{name} is {value!r}; pass one of {listed}.")
    return value


def require_kind(name: str, value: Any, kind: type | tuple[type, ...], remedy: str) -> Any:
    """Return `value` when it is a `kind`, or raise `ArgumentError` with the remedy."""
    if not isinstance(value, kind):
        raise ArgumentError(f"{name} is a {type(value).__name__}; pass {remedy}.")
    return value


def require_array(
    name: str,
    values: ArrayLike,
    shape: tuple | None = None,
    *,
    dtype: type = float,
    low: float | None = None,
    high: float | None = None,
    above: float | None = None,
    finite: bool = True,
    least: int = 0,
    remedy: str = "",
    error: type[McnError] = ArgumentError,
) -> np.ndarray:
    """Return `values` as an array, or raise.

    Parameters
    ----------
    name : str
        The argument's name, for the message.
    values : array_like
    shape : tuple, optional
        One entry an axis: its length, or None (or a letter, for the message) where any will
        do; a leading ``...`` allows more axes before.
    dtype : {float, int, bool}, optional
        ``int`` takes whole numbers of any kind; ``bool`` takes nothing but bool.
    low, high : float, optional
        Inclusive bounds of every entry.
    above : float, optional
        Exclusive lower bound.
    finite : bool, optional
        Whether NaN and inf are refused; bounds refuse NaN either way.
    least : int, optional
        Rows that there must be.
    remedy : str, optional
        What to pass, for the message; said from the other arguments if not given.
    error : type, optional
        What to raise.

    Returns
    -------
    ndarray
        Of `dtype`; a copy only where it had to be converted.

    Raises
    ------
    ArgumentError
        Or `error`: when `values` are no numbers, have another shape, or an entry is out of
        bounds; the message names the first such row.
    """
    kind = {float: "numbers", int: "whole numbers", bool: "booleans"}[dtype]
    if shape is not None:
        listed = ", ".join("…" if a is ... else "n" if a is None else str(a) for a in shape)
        kind += f" of shape ({listed}{',' * (len(shape) == 1)})"
    if least:
        kind += f", {least} rows or more"
    remedy = remedy or _wanted(
        ("finite " if finite and dtype is float else "") + kind, low, high, above
    )
    try:
        held = np.asarray(values)
        if np.iscomplexobj(held):
            raise TypeError("complex numbers")
        array = held if dtype is bool or held.dtype == dtype else held.astype(float)
    except (TypeError, ValueError) as fault:
        raise error(f"{name} holds what is no number ({fault}); pass {remedy}.") from None
    if dtype is bool and array.dtype != bool:
        raise error(f"{name} is of {array.dtype}; pass {remedy}.")
    if shape is not None:
        more = shape[0] is ...
        ends = shape[1:] if more else shape
        fits = array.ndim >= len(ends) if more else array.ndim == len(ends)
        tail = array.shape[array.ndim - len(ends) :] if fits else ()
        pairs = zip(ends, tail, strict=True) if fits else ()
        fits = fits and all(not isinstance(want, int) or want == size for want, size in pairs)
        if not fits:
            raise error(f"{name} has the shape {array.shape}; pass {remedy}.")
    if least and (array.ndim == 0 or len(array) < least):
        raise error(f"{name} has the shape {array.shape}; pass {remedy}.")
    if dtype is bool:
        return array
    sound = np.isfinite(array) if finite else np.ones(array.shape, bool)
    with np.errstate(invalid="ignore"):
        sound &= _within(array, low, high, above)
        if dtype is int:
            sound &= array == np.round(array)
    require_all(name, array, sound, f"pass {remedy}", error=error)
    return array.astype(int) if dtype is int else array


def require_all(
    name: str,
    values: np.ndarray,
    sound: np.ndarray,
    remedy: str,
    *,
    error: type[McnError] = ArgumentError,
) -> None:
    """Raise naming the first of `values` that is not `sound`, flags of the same shape."""
    if not sound.all():
        place = np.unravel_index(int(np.argmin(sound)), sound.shape)
        row = f" in row {', '.join(str(int(at)) for at in place)}" if sound.ndim else ""
        raise error(f"{name} is {values[place]:g}{row}; {remedy}.")


def require_like(like: np.ndarray, *, of: str, **others: ArrayLike) -> None:
    """Raise `ArgumentError` unless all `others` have the shape of the array `like`."""
    for name, values in others.items():
        if np.shape(values) != like.shape:
            raise ArgumentError(
                f"{name} has the shape {np.shape(values)}, {of} {like.shape}; pass as many of each."
            )


def require_points(name: str, points: ArrayLike, *, least: int = 1) -> np.ndarray:
    """Return `points` as floats of shape (n, 2), or raise `ArgumentError`."""
    remedy = f"at least {least} rows of finite x, y"
    return require_array(
        name, points, (None, 2), low=-MOST_FAR, high=MOST_FAR, least=least, remedy=remedy
    )


def require_labels(name: str, values: ArrayLike) -> np.ndarray:
    """Return `values` as a flat array without gaps, or raise `ArgumentError`."""
    try:
        values = np.asarray(values)
    except ValueError:  # ragged
        values = np.empty((0, 0))
    if values.ndim != 1 or pd.isna(values).any():
        raise ArgumentError(f"{name} must be a flat list without gaps; pass one entry a row.")
    return values


def require_flags(name: str, values: ArrayLike) -> np.ndarray:
    """Return `values` as a flat array of bool with an entry at least, or raise `ArgumentError`."""
    values = require_labels(name, values)
    if len(values) == 0 or not np.isin(values, (0, 1)).all():
        raise ArgumentError(f"{name} must hold True or False, one a row, for at least one row.")
    return values.astype(bool)


def _wanted(
    kind: str, low: float | None, high: float | None, above: float | None, unit: str = ""
) -> str:
    bounds = [
        f"{word} {bound:g}"
        for word, bound in (("above", above), ("at least", low), ("at most", high))
        if bound is not None
    ]
    parts = [kind, " and ".join(bounds), f"({unit})" if unit else ""]
    return " ".join(part for part in parts if part)


def _within(values: Any, low: float | None, high: float | None, above: float | None) -> Any:
    """Whether each value lies within the bounds; NaN does not, where there is one."""
    sound = np.ones(np.shape(values), bool)
    if above is not None:
        sound &= values > above
    if low is not None:
        sound &= values >= low
    if high is not None:
        sound &= values <= high
    return sound
