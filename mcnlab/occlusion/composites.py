"""Every two walks over each other: what the thesis foresees of them, and what happens.

Thesis sections 3.4 and 3.5.  Two walks laid over each other (`datasets.composites`) are two
people who never met: their boxes say when one covers the other, and the first second that
shows both is all that the tables and equations may see.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np
import pandas as pd

from mcnlab.cameras.horizon import estimate_cameras
from mcnlab.checks import require_number
from mcnlab.datasets.recording import Recording
from mcnlab.errors import ArgumentError
from mcnlab.occlusion import thesis
from mcnlab.occlusion.pairs import RULES
from mcnlab.occlusion.truth import Truth, find_occlusions
from mcnlab.tables import CX, CY, DIRECTION, FRAME, PRESENT, SEQUENCE, H, W, X, Y
from mcnlab.walking.heading import measure_headings
from mcnlab.walking.speed import frames_of, level_of

SHIFTS: Final = (0.0, 0.5, 1.0, 1.5, 2.0)  # seconds from one walk's beginning to the other's
LEAST_FRAMES: Final = 4  # fewer show no heading
_CHUNK: Final = 4000  # pairs at a time: a few hundred numbers each


@dataclass(frozen=True)
class Composites:
    """Pairs of walks of one recording, each at one moment.

    Attributes
    ----------
    recording : Recording
        That the walks are from.
    table : pandas.DataFrame
        One row a composite; ``first, second`` and ``shift`` are what `composites.compose`
        takes.

        - ``frame``: the moment of decision, the last frame of the first second that shows
          both, in the composite's clock;
        - ``swapped``: whether S1, the walker on the left, is ``second``;
        - ``x1, y1, x2, y2``: the centroids of S1 and S2 at that moment, pixels;
        - ``direction1, direction2, level1, level2``: measured in that second;
        - ``p1, p2``: pixels travelled in it;
        - ``rule``: what the tables say, `occlusion.CERTAIN`, `BY_SPEED`, `APART` or
          `UNIDENTIFIED`;
        - ``said, said_seconds, said_x, said_y``: `occlusion.foresee`; seconds are inf for
          never;
        - ``occludes, seconds, x, y``: the truth, from the boxes: the first later frame in
          which both are boxed and the intersection is more than ``RULES.cover`` of the
          smaller box; where there is none, seconds are inf and the place is the middle
          between the two now;
        - ``left``: seconds of video after the moment in which both are still walking.
    """

    recording: Recording
    table: pd.DataFrame

    @property
    def known(self) -> pd.Series:
        """Where S1 and S2 are told apart, one bool a row."""
        return (self.table["rule"] != thesis.UNIDENTIFIED).to_numpy()

    def people(self, column: str) -> np.ndarray:
        """Who walks, one name a row: `column` is ``"first"`` or ``"second"``."""
        return self.table[column].astype(str).map(self.recording.subjects).to_numpy(str)


def compose_all(
    recording: Recording,
    *,
    focal_length: float,
    shifts: Sequence[int] = SHIFTS,
    seconds: float = 1.0,
) -> Composites:
    """Every two walks of different people over each other, at several offsets.

    Directions come from perspective (`heading.measure_headings`), levels and the way of
    motion from where the centroid was at the second's two ends.  A camera that does not move
    knows its horizon: that is taken from all of a subject's walks.

    Parameters
    ----------
    recording : Recording
    focal_length : float
        Pixels.
    shifts : sequence of float, optional
        Seconds by which the second walk begins later; at least 0, since every two walks
        are taken in both orders.
    seconds : float, optional
        How long both are watched before the decision.

    Returns
    -------
    Composites
        Without pairs that cover each other already by more than ``RULES.apart``, and without
        walkers whose second has too few boxes or who stand still in it.  Walks of one
        person are laid over each other only where the recording has no other.

    Raises
    ------
    McnError
        When the table is not sound, a number is out of range, or nothing can be composed.

    Examples
    --------
    >>> from mcnlab import occlusion, synthetic
    >>> street = synthetic.make_street()
    >>> made = occlusion.compose_all(street.recording, focal_length=450, shifts=[0])
    >>> len(made.table), int(made.table["occludes"].sum())
    (98, 87)
    """
    focal_length = require_number("focal_length", focal_length, above=0, unit="pixels")
    window = frames_of(seconds, recording.frame_rate)
    if window < LEAST_FRAMES:
        raise ArgumentError(
            f"seconds is {seconds:g}, {window} frames at {recording.frame_rate:g} a second; a "
            f"direction needs {LEAST_FRAMES}: pass at least "
            f"{LEAST_FRAMES / recording.frame_rate:g}."
        )
    offsets = [
        check_shift(
            round(require_number("shifts", shift, low=0, unit="seconds") * recording.frame_rate)
        )
        for shift in shifts
    ]
    if not offsets:
        raise ArgumentError("shifts is empty; pass at least one offset in seconds, such as 0.")
    cameras = estimate_cameras(recording, focal_length=focal_length)
    begun = _watch(recording, 0, window, focal_length, cameras)
    parts = []
    for offset in dict.fromkeys(offsets):
        later = begun if offset == 0 else _watch(recording, offset, window, focal_length, cameras)
        first, second = np.nonzero(_may_meet(recording, offset) & later.usable[:, None])
        keep = begun.usable[second]
        first, second = first[keep], second[keep]
        for at in range(0, len(first), _CHUNK):
            chunk = slice(at, at + _CHUNK)
            parts.append(
                _decide(recording, later, begun, first[chunk], second[chunk], offset, window)
            )
    table = pd.concat(parts, ignore_index=True) if parts else pd.DataFrame()
    if table.empty:
        raise ArgumentError(
            f"recording {recording.name} has no two walks that can be watched together for "
            f"{seconds:g} s before they cover each other; pass more or longer walks."
        )
    return Composites(recording, table)


class _Watched(NamedTuple):
    """What one second of each walk shows, one element a walk."""

    usable: np.ndarray
    walker: thesis.Walker
    level: np.ndarray


def _watch(recording, offset, window, focal_length, cameras):
    """Direction, speed and place of every walk in the `window` frames from `offset` on."""
    stack = recording.stack
    count, longest = stack.valid.shape
    usable = np.zeros(count, bool)
    empty = np.zeros(count)
    nothing = thesis.Walker(empty, empty, empty.astype(int), empty, empty, empty)
    last = offset + window - 1
    if last >= longest:
        return _Watched(usable, nothing, empty.astype(int))
    ends = stack.valid[:, offset] & stack.valid[:, last]
    boxed = stack.valid[:, offset : last + 1].sum(axis=1)
    usable = ends & (boxed >= max(PRESENT * window, LEAST_FRAMES))
    if not usable.any():
        return _Watched(usable, nothing, empty.astype(int))
    direction = _directions(recording, offset, window, usable, focal_length, cameras)
    usable &= direction > 0
    # One second has one interval fewer than frames.
    rate = recording.frame_rate / (window - 1)
    vx, vy = (
        rate * (stack.curves[name][:, last] - stack.curves[name][:, offset]) for name in (CX, CY)
    )
    pixels = np.hypot(vx, vy)
    level = level_of(np.where(usable, pixels, 0.0), frame_width=recording.frame_width)
    x, y = stack.curves[CX][:, last], stack.curves[CY][:, last]
    return _Watched(usable, thesis.Walker(x, y, direction, pixels, vx, vy), level)


def _directions(recording, offset, window, usable, focal_length, cameras):
    """Each usable walk's direction in a window, 1 … 8; 0 where there is none."""
    stack, boxes = recording.stack, recording.boxes
    row = boxes[SEQUENCE].map({name: place for place, name in enumerate(stack.names)}).to_numpy()
    since = boxes[FRAME].to_numpy() - stack.start[row]
    inside = (since >= offset) & (since < offset + window) & usable[row]
    part = recording.with_boxes(
        boxes[inside].reset_index(drop=True), directions=None, copies=frozenset()
    )
    try:
        headings = measure_headings(part, focal_length=focal_length, cameras=cameras)
    except ArgumentError:
        return np.zeros(len(stack.names), int)  # the frame's edge cuts all of them
    direction = pd.Series(headings[DIRECTION].to_numpy(), index=headings[SEQUENCE])
    return direction.reindex(stack.names, fill_value=0).to_numpy(int)


def _may_meet(recording, offset):
    """Which two walks make a composite, shape (n, n): the first one began `offset` earlier."""
    person = pd.factorize(recording.subjects[recording.stack.names])[0]
    # Alone in a recording, one meets oneself; a walk never meets itself.
    alone = person.max() == 0
    apart = ~np.eye(len(person), dtype=bool) if alone else person[:, None] != person
    return np.triu(apart) if offset == 0 else apart


def _decide(recording, later, begun, first, second, offset, window):
    """Forecast and truth of some pairs, as a table."""
    stack = recording.stack
    both, a, b = _boxes_ahead(stack, first, second, offset, window)
    truth = find_occlusions(a, b, both, cover=RULES.cover)
    clear = truth.now <= RULES.apart
    first, second, both = first[clear], second[clear], both[clear]
    truth = Truth(*(values[clear] for values in truth))
    one = thesis.Walker(*(values[first] for values in later.walker))
    two = thesis.Walker(*(values[second] for values in begun.walker))
    swapped = two.x < one.x
    said = thesis.foresee(
        one, two, frame_width=recording.frame_width, frame_height=recording.frame_height
    )
    levels = later.level[first], begun.level[second]
    left, right = (
        thesis.Walker(*(np.where(swapped, q, p) for p, q in zip(*who, strict=True)))
        for who in ((one, two), (two, one))
    )
    names = np.array(stack.names, dtype=object)
    last = both.shape[1] - 1 - both[:, ::-1].argmax(axis=1)
    return pd.DataFrame(
        {
            "first": names[first],
            "second": names[second],
            "shift": offset,
            "frame": offset + window,
            "swapped": swapped,
            "x1": left.x,
            "y1": left.y,
            "x2": right.x,
            "y2": right.y,
            "direction1": left.direction,
            "direction2": right.direction,
            "level1": np.where(swapped, levels[1], levels[0]),
            "level2": np.where(swapped, levels[0], levels[1]),
            "p1": left.pixels,
            "p2": right.pixels,
            "rule": said.rule,
            "said": said.occludes,
            "said_seconds": said.seconds,
            "said_x": said.x,
            "said_y": said.y,
            "occludes": truth.occludes,
            "seconds": np.where(truth.occludes, truth.frame / recording.frame_rate, np.inf),
            "x": np.where(truth.occludes, truth.x, (one.x + two.x) / 2),
            "y": np.where(truth.occludes, truth.y, (one.y + two.y) / 2),
            "left": last / recording.frame_rate,
        }
    )


def _boxes_ahead(stack, first, second, offset, window):
    """From the decision on: where both have a box, and their boxes, each (pairs, frames)."""
    begin = offset + window - 1, window - 1
    length = stack.valid.shape[1] - max(begin)
    frames = [slice(start, start + length) for start in begin]
    at = list(zip((first, second), frames, strict=True))
    both = np.logical_and(*(stack.valid[:, part][walk] for walk, part in at))
    a, b = ([stack.curves[name][:, part][walk] for name in (X, Y, W, H)] for walk, part in at)
    return both, a, b


SHIFT_LIMIT = 100_000  # frames: over an hour of video between two walks is a mistake


def compose(recording: Recording, first: str, second: str, *, shift: int = 0) -> Recording:
    """Two walks of a recording in one clock.

    Parameters
    ----------
    recording : Recording
    first, second : str
        Two different sequences of it.
    shift : int, optional
        Frames from the first box of `first` to the first box of `second`; negative when
        `second` begins earlier.

    Returns
    -------
    Recording
        With these two sequences, in that order.  The earlier one begins in frame 1;
        frames that show only one of the two stay.

    Raises
    ------
    DatasetError
        When a sequence is not there.
    ArgumentError
        When both are the same sequence or `shift` is not a whole number of frames.
    """
    shift = check_shift(shift)
    if first == second:
        raise ArgumentError(
            f"first and second are both {first!r}: that walk would cover itself in every frame; "
            "pass two different sequences."
        )
    starts = start_frames(shift)
    tables = [
        rows.assign(**{FRAME: rows[FRAME] - int(rows[FRAME].iloc[0]) + start})
        for rows, start in zip(map(recording.sequence, (first, second)), starts, strict=True)
    ]
    labels = recording.directions
    return recording.with_boxes(
        pd.concat(tables, ignore_index=True),
        directions=None if labels is None else labels[[first, second]],
        copies=recording.copies & {first, second},
        problems=(),
    )


def compose_masks(first: np.ndarray, second: np.ndarray, *, shift: int = 0) -> np.ndarray:
    """The silhouettes of two walks in one clock.

    Parameters
    ----------
    first, second : array_like, shape (frames, height, width)
        Masks, 0 where background; each begins with the frame of the walk's first box.
    shift : int, optional
        As in `compose`.

    Returns
    -------
    ndarray of uint8, shape (frames, height, width)
        0 background, 1 the first walker, 2 the second, 3 both.

    Raises
    ------
    ArgumentError
        When the masks are not two stacks of images of one size.
    """
    shift = check_shift(shift)
    first, second = np.asarray(first), np.asarray(second)
    if first.ndim != 3 or second.ndim != 3 or first.shape[1:] != second.shape[1:]:
        raise ArgumentError(
            f"first and second have shapes {first.shape} and {second.shape}; pass masks "
            "(frames, height, width) of one size."
        )
    if min(first.size, second.size) == 0:
        raise ArgumentError("first or second holds no masks; pass at least one frame each.")
    starts = [start - 1 for start in start_frames(shift)]
    frames = max(starts[0] + len(first), starts[1] + len(second))
    both = np.zeros((frames, *first.shape[1:]), np.uint8)
    both[starts[0] : starts[0] + len(first)] |= (first != 0).astype(np.uint8)
    both[starts[1] : starts[1] + len(second)] |= 2 * (second != 0).astype(np.uint8)
    return both


def start_frames(shift: int) -> tuple[int, int]:
    """The frames of a composite in which the first and the second walk begin, from 1."""
    return 1 + max(-shift, 0), 1 + max(shift, 0)


def check_shift(shift: Any) -> int:
    """Return `shift` as an int, or raise `ArgumentError`."""
    whole = isinstance(shift, int | np.integer) and not isinstance(shift, bool)
    if not whole or abs(shift) > SHIFT_LIMIT:
        raise ArgumentError(
            f"shift is {shift!r}; pass a whole number of frames, at most {SHIFT_LIMIT} either way."
        )
    return int(shift)
