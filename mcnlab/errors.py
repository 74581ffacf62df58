"""The one family of errors, and the checks that raise them.

Every message names the argument, says what was wrong with it, and what to do.
"""


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
