"""The one family of errors, and the checks that raise them.

Every message names the argument, says what was wrong with it, and what to do.
"""

import math
from numbers import Integral, Real


class McnError(Exception):
    """Anything that mcnlab refuses to do; the message says how to put it right."""


class ArgumentError(McnError, ValueError):
    """An argument has an impossible value or type."""


class TableError(McnError, ValueError):
    """A table lacks a column or holds impossible rows."""


class SilhouetteError(McnError, ValueError):
    """An image shows no walker, or not exactly one."""


class DatasetError(McnError):
    """Files of a dataset are missing, damaged or inconsistent."""


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
