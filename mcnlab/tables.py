"""The columns a box table and a trace table have, and the checks that they have them.

One row of a box table is one walker's bounding box in one frame.  Rows are grouped by
sequence and ordered by frame.  Pixels count from the centre of the top-left pixel, x to the
right and y downwards; a box covers columns ``x … x + w − 1`` and rows ``y … y + h − 1``, so its
edges are at ``x − ½, x + w − ½, y − ½, y + h − ½``, its middle at ``x + (w − 1)/2, y + (h − 1)/2``.

One row of a trace table is the place of one walker's feet in one frame: metres on the ground,
x to the right and y upwards as seen from above, unless a function says pixels.
"""

from collections.abc import Iterable, Iterator
from typing import Any, Final, NamedTuple

import numpy as np
import pandas as pd
from pandas.api.types import is_numeric_dtype

from mcnlab.checks import require_number
from mcnlab.errors import TableError

SEQUENCE: Final = "sequence"  # one walk, unique in a recording
SUBJECT: Final = "subject"  # who walks
FRAME: Final = "frame"  # frame number, whole
X: Final = "x"  # left edge, pixels
Y: Final = "y"  # top edge, pixels
W: Final = "w"  # width, pixels
H: Final = "h"  # height, pixels
CX: Final = "cx"  # centroid column, pixels
CY: Final = "cy"  # centroid row, pixels
AREA: Final = "area"  # foreground pixels of the body; absent where boxes were placed by hand
DIRECTION: Final = "direction"  # 1 … 8, clockwise from "away"
TRACE: Final = "trace"  # one walker's feet, in a trace table, where X and Y are their place
BOX_COLUMNS: Final = (SEQUENCE, SUBJECT, FRAME, X, Y, W, H, CX, CY)
MEASURES: Final = (X, Y, W, H, CX, CY)
TRACE_COLUMNS: Final = (TRACE, FRAME, X, Y)
PIXEL_LIMIT: Final = 1e6  # no image is larger
FRAME_LIMIT: Final = 1e9  # a year at 30 frames a second


def check_columns(table: Any, columns: Iterable[str], *, argument: str) -> None:
    """Raise `TableError` unless `table` is a table that has `columns`."""
    held = getattr(table, "columns", None)
    if held is None:
        raise TableError(f"{argument} is a {type(table).__name__}; pass a pandas DataFrame.")
    missing = [name for name in columns if name not in held]
    twice = [name for name in columns if list(held).count(name) > 1]
    if twice:
        raise TableError(
            f"{argument} has the column(s) {', '.join(twice)} twice; keep one of each."
        )
    if missing:
        raise TableError(
            f"{argument} lacks the column(s) {', '.join(missing)}; "
            f"it has {', '.join(map(str, held))}. Add or rename them."
        )


def check_boxes(boxes: pd.DataFrame, *, argument: str = "boxes") -> pd.DataFrame:
    """Return `boxes` when it is a sound box table.

    Parameters
    ----------
    boxes : pandas.DataFrame
        A table with the columns of `BOX_COLUMNS`.
    argument : str, optional
        The argument's name, for the message.

    Raises
    ------
    TableError
        When a column is missing, the table is empty, a number is not finite, a width
        or height is not positive, or a sequence's frames are repeated, out of order
        or not whole.
    """
    values = _numbers_of(
        boxes, BOX_COLUMNS, (SEQUENCE, SUBJECT), argument=argument, least="one box"
    )
    finite = np.isfinite(values).all(axis=1)
    if not finite.all():
        row = int(np.flatnonzero(~finite)[0])
        raise TableError(
            f"{argument} row {row} holds a value that is not finite; drop that row: "
            "a frame without a walker has no row."
        )
    vast = (np.abs(values) > [FRAME_LIMIT] + [PIXEL_LIMIT] * len(MEASURES)).any(axis=1)
    if vast.any():
        row = int(np.flatnonzero(vast)[0])
        raise TableError(
            f"{argument} row {row} holds a frame number or a place beyond any video; "
            "check its units: frames and pixels."
        )
    flat = (boxes[W].to_numpy() <= 0) | (boxes[H].to_numpy() <= 0)
    if flat.any():
        row = int(np.flatnonzero(flat)[0])
        raise TableError(
            f"{argument} row {row} has w = {boxes[W].iloc[row]:g}, h = {boxes[H].iloc[row]:g}; "
            "both must be positive pixels. Drop that row."
        )
    _check_order(boxes[SEQUENCE], values[:, 0], argument=argument, key=SEQUENCE)
    return boxes


def check_traces(traces: pd.DataFrame, *, argument: str = "traces") -> pd.DataFrame:
    """Return `traces` when it is a sound trace table.

    Parameters
    ----------
    traces : pandas.DataFrame
        A table with the columns of `TRACE_COLUMNS`.
    argument : str, optional
        The argument's name, for the message.

    Raises
    ------
    TableError
        When a column is missing, the table is empty, a number is not finite, or a
        trace's frames are repeated, out of order or not whole.
    """
    values = _numbers_of(
        traces, TRACE_COLUMNS, (TRACE,), argument=argument, least="one place of one walker"
    )
    sound = np.isfinite(values).all(axis=1) & (
        np.abs(values) <= [FRAME_LIMIT, PIXEL_LIMIT, PIXEL_LIMIT]
    ).all(axis=1)
    if not sound.all():
        row = int(np.flatnonzero(~sound)[0])
        raise TableError(
            f"{argument} row {row} holds a value that is not finite or beyond any place; drop it."
        )
    _check_order(traces[TRACE], values[:, 0], argument=argument, key=TRACE)
    return traces


def _numbers_of(table, columns, keys, *, argument, least):
    """The columns that are no keys as floats, once they are there, filled and numbers."""
    check_columns(table, columns, argument=argument)
    if len(table) == 0:
        raise TableError(f"{argument} has no rows; pass at least {least}.")
    numbers = [name for name in columns if name not in keys]
    text = [name for name in numbers if not is_numeric_dtype(table[name])]
    if text:
        raise TableError(
            f"{argument} holds text or objects in {', '.join(text)}; convert it to numbers."
        )
    if table[list(keys)].isna().any(axis=None):
        raise TableError(f"{argument} has rows without a {' or '.join(keys)}; name them.")
    return table[numbers].to_numpy(float)


def _check_order(names, frame, *, argument, key):
    """Frames must be whole and rise within each name, and a name's rows stand together."""
    if (frame != np.round(frame)).any():
        raise TableError(f"{argument} has a fractional frame number; number frames 1, 2, 3, …")
    names = names.to_numpy(dtype=object)
    backwards = (names[1:] == names[:-1]) & (np.diff(frame) <= 0)
    first = names[starts_of(names)]
    if backwards.any() or len(set(first)) != len(first):
        where = (
            f" in {key} {names[1 + int(np.flatnonzero(backwards)[0])]!r}" if backwards.any() else ""
        )
        raise TableError(
            f"{argument} has repeated or unsorted frames{where}; drop duplicates and sort by "
            f"{key}, {FRAME}."
        )


def starts_of(names: np.ndarray) -> np.ndarray:
    """The positions at which a new name begins, in an array of names that stand together."""
    return np.flatnonzero(np.r_[True, names[1:] != names[:-1]][: len(names)])


def split_sequences(table: pd.DataFrame, *, key: str = SEQUENCE) -> Iterator[tuple[Any, slice]]:
    """Yield ``(name, rows)`` in table order; `rows` is a slice of positions."""
    names = table[key].to_numpy()
    starts = starts_of(names)
    for start, stop in zip(starts, np.r_[starts[1:], len(names)], strict=True):
        yield names[start], slice(int(start), int(stop))


class Stack(NamedTuple):
    """A box table as arrays, one row a walk, one column a frame from its first on."""

    names: list  # the sequences
    start: np.ndarray  # (n,) first frame number
    length: np.ndarray  # (n,) frames from first to last
    valid: np.ndarray  # (n, longest) where there is a box
    curves: dict  # column name → (n, longest), 0 where there is no box


def stack_sequences(boxes: pd.DataFrame, names: Iterable[str] = MEASURES) -> Stack:
    """Lay the walks of a sound box table side by side, frame by frame.

    Parameters
    ----------
    boxes : pandas.DataFrame
        A box table.
    names : iterable of str, optional
        The columns to stack.

    Returns
    -------
    Stack

    Raises
    ------
    TableError
        When the table is not sound, or frame numbers jump so far that the frames
        between could not be held.
    """
    check_boxes(boxes)
    names = tuple(names)
    check_columns(boxes, names, argument="boxes")
    walks = list(split_sequences(boxes))
    frame = boxes[FRAME].to_numpy(dtype=np.int64)
    start = np.array([frame[at.start] for _, at in walks])
    length = np.array([frame[at.stop - 1] for _, at in walks]) - start + 1
    if length.max() > 10_000 + 20 * len(boxes):
        raise TableError(
            f"boxes: sequence {walks[int(length.argmax())][0]!r} spans {length.max()} frames with "
            "hardly any boxes; number its frames 1, 2, 3, …"
        )
    row = np.repeat(np.arange(len(walks)), [at.stop - at.start for _, at in walks])
    column = frame - start[row]
    valid = np.zeros((len(walks), int(length.max())), bool)
    valid[row, column] = True
    curves = {}
    for name in names:
        curves[name] = np.zeros(valid.shape)
        curves[name][row, column] = boxes[name].to_numpy(dtype=float)
    return Stack([name for name, _ in walks], start, length, valid, curves)


SECOND, COURSE, PLACE, HEADING = "second", "course", "place", "heading"
WORLD_X, WORLD_Y = "world_x", "world_y"  # metres
PRESENT = 0.6  # share of the frames that must show the walker whole


def uncut(stack: Stack, frame_width: int, frame_height: int) -> np.ndarray:
    """Which boxes to trust: those clear of the frame's edge.

    A walker half out of the frame has a box, but not his own.  A walk that would be left
    with less than `PRESENT` of its boxes keeps them all.

    Parameters
    ----------
    stack : columns.Stack
        With x, y, w and h.
    frame_width, frame_height : int
        Pixels.

    Returns
    -------
    ndarray of bool, shape of ``stack.valid``
    """
    frame_width = require_number("frame_width", frame_width, above=0, unit="pixels")
    frame_height = require_number("frame_height", frame_height, above=0, unit="pixels")
    box = stack.curves
    clear = (
        stack.valid
        & (box[X] > 0)
        & (box[Y] > 0)
        & (box[X] + box[W] < frame_width)
        & (box[Y] + box[H] < frame_height)
    )
    enough = clear.sum(axis=1) >= np.maximum(PRESENT * stack.valid.sum(axis=1), 2)
    return np.where(enough[:, None], clear, stack.valid)
