"""Reading files: what goes wrong is a `DatasetError` that names the file, and where."""

import configparser
import re
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Final
from xml.etree.ElementTree import ParseError

import numpy as np
import pandas as pd

from mcnlab.errors import DatasetError

NUMBER: Final = re.compile(rb"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?")
_FAULTS: Final = (
    *(OSError, EOFError, ValueError, LookupError, TypeError, AttributeError, OverflowError),
    *(zlib.error, configparser.Error, ParseError),
)


@contextmanager
def reading(path: Path, what: str, remedy: str = "restore it") -> Iterator[None]:
    """Raise `DatasetError` where a file is missing or is not `what` it should be.

    Parameters
    ----------
    path : pathlib.Path
    what : str
        Such as "a table of numbers".
    remedy : str, optional
        What to do about a damaged one.

    Raises
    ------
    DatasetError
        For whatever of the kind is raised within.
    """
    try:
        yield
    except DatasetError:
        raise
    except FileNotFoundError as fault:
        raise DatasetError(f"{path} is missing; put {what} there.") from fault
    except _FAULTS as fault:
        reason = " ".join(str(getattr(fault, "strerror", None) or fault).split())
        raise DatasetError(f"{path} is not {what} ({reason}); {remedy}.") from fault


def read_numbers(
    path: Path, layouts: Mapping[int, str], *, sep: str = ",", comment: str | None = None
) -> np.ndarray:
    """A file of numbers in columns.

    Parameters
    ----------
    path : pathlib.Path
    layouts : dict
        The numbers of columns that there may be → what they are called.
    sep : str, optional
        What stands between numbers; ``\\s+`` is white space.
    comment : str, optional
        What comments begin with.

    Returns
    -------
    ndarray, shape (rows, columns)
        Finite.

    Raises
    ------
    DatasetError
        When the file is missing, empty, or no such table; the message names the line and
        the column.
    """
    values = None
    with reading(path, "a table of numbers, " + _listed(layouts)):
        if path.stat().st_size == 0:
            raise DatasetError(f"{path} is empty; restore it from the dataset.")
        try:
            table = pd.read_csv(
                path,
                sep=sep,
                comment=comment,
                header=None,
                dtype=float,
                skipinitialspace=True,
                na_filter=False,
                quoting=3,  # a quotation mark is text
                encoding="utf-8-sig",
            )
            values = table.to_numpy()
        except (ValueError, OverflowError) as fault:  # pandas' own errors are ValueErrors
            raise DatasetError(_describe_fault(path, layouts, sep, comment)) from fault
    if values.shape[1] not in layouts or not np.isfinite(values).all():
        raise DatasetError(_describe_fault(path, layouts, sep, comment))
    return values


def line_of(path: Path, row: int) -> int:
    """The line of a file that holds a row of numbers, from 1: blank lines hold none."""
    return next(number for k, (number, _) in enumerate(_lines(path, None)) if k == row)


def _listed(layouts):
    return " or ".join(f"{count} ({names})" for count, names in layouts.items())


def _lines(path, comment):
    """Yield (number, line) of each line that is not blank: the slow way, to name a place."""
    with path.open("rb") as file:
        for number, line in enumerate(file, start=1):
            line = line.removeprefix(b"\xef\xbb\xbf") if number == 1 else line
            line = line.split(comment.encode())[0] if comment else line
            if line.strip():
                yield number, line


def _describe_fault(path, layouts, sep, comment):
    """What is wrong with a file that is not a table of numbers, and where."""
    wanted = None
    for number, line in _lines(path, comment):
        fields = [field.strip() for field in line.split(b"," if sep == "," else None)]
        if len(fields) not in layouts:
            wants = f"the format has {_listed(layouts)}"
            return f"{path} line {number} has {len(fields)} columns; {wants}."
        wanted = wanted or len(fields)
        if len(fields) != wanted:
            return (
                f"{path} line {number} has {len(fields)} columns and the first line {wanted}; "
                "give every line as many."
            )
        for column, field in enumerate(fields, start=1):
            text = field.decode("utf-8", "backslashreplace")
            if not NUMBER.fullmatch(field):
                return f"{path} line {number}, column {column} holds {text!r}; put a number there."
            if not np.isfinite(float(field)):
                return f"{path} line {number}, column {column} holds {text}; it is too large."
    if wanted is None:
        return f"{path} holds blank lines only; restore it from the dataset."
    return f"{path} cannot be read as a table of numbers; write it as plain text."
