"""One recording: a box table with the camera's frame rate and size, and what is known of it."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import pandas as pd

from mcnlab import tables
from mcnlab.checks import require_count, require_number
from mcnlab.compass import DIRECTIONS
from mcnlab.errors import DatasetError


@dataclass(frozen=True)
class Recording:
    """Walkers' boxes from one kind of camera.

    Attributes
    ----------
    name : str
        The dataset's name, lower case.
    boxes : pandas.DataFrame
        A box table (`mcnlab.tables`).
    frame_rate : float
        Frames a second.
    frame_width, frame_height : int
        Pixels.
    directions : pandas.Series or None
        The true direction, 1 … 8, indexed by sequence.
    copies : frozenset of str
        Sequences that are mirror images of other sequences here: they count as
        videos, but not as further observations.
    problems : tuple of str
        What was left out on loading, one sentence each.
    source : str
        Where the boxes come from: "bundled" or "measured"; empty if neither.

    Examples
    --------
    >>> row = {"sequence": "walk", "subject": "abc", "frame": [1, 2], "x": [10, 12], "y": 20}
    >>> boxes = pd.DataFrame({**row, "w": 8, "h": 30, "cx": [14, 16], "cy": 35})
    >>> Recording("garden", boxes, frame_rate=25.0, frame_width=320, frame_height=240).summary
    'garden, 1 subject'
    """

    name: str
    boxes: pd.DataFrame
    frame_rate: float
    frame_width: int
    frame_height: int
    directions: pd.Series | None = None
    copies: frozenset = frozenset()
    problems: tuple = field(default=(), repr=False)
    source: str = ""

    def __post_init__(self):
        tables.check_boxes(self.boxes)
        require_number("frame_rate", self.frame_rate, above=0, unit="frames a second")
        require_count("frame_width", self.frame_width, low=1)
        require_count("frame_height", self.frame_height, low=1)
        if self.directions is not None:
            check_directions(self.directions, self.sequences)

    @cached_property
    def stack(self) -> tables.Stack:
        """The boxes laid side by side (`tables.stack_sequences`), made once."""
        return tables.stack_sequences(self.boxes)

    @property
    def sequences(self) -> list[str]:
        """The sequences' names, in table order."""
        return list(self.boxes[tables.SEQUENCE].unique())

    @property
    def subjects(self) -> pd.Series:
        """Series: each sequence's subject."""
        return self.boxes.groupby(tables.SEQUENCE, sort=False)[tables.SUBJECT].first()

    @property
    def summary(self) -> str:
        """What this is, in a few words, for a result row."""
        people = self.subjects.nunique()
        parts = [self.name, f"{people} subject{'s' * (people != 1)}", self.source]
        return ", ".join(part for part in parts if part)

    def sequence(self, name: str) -> pd.DataFrame:
        """The boxes of one sequence.

        Raises
        ------
        DatasetError
            When there is no such sequence.
        """
        rows = self.boxes[self.boxes[tables.SEQUENCE] == name]
        if rows.empty:
            raise DatasetError(
                f"sequence {name!r} is not in {self.name}; it holds {len(self.sequences)} "
                f"sequences, such as {self.sequences[0]!r}."
            )
        return rows.reset_index(drop=True)

    def with_boxes(self, boxes: pd.DataFrame, **changes: Any) -> "Recording":
        """A copy with other boxes."""
        return replace(self, boxes=boxes, **changes)

    def without_copies(self) -> "Recording":
        """The recording without its mirrored copies: what was filmed."""
        if not self.copies:
            return self
        labels = self.directions
        return self.with_boxes(
            self.boxes[~self.boxes[tables.SEQUENCE].isin(self.copies)].reset_index(drop=True),
            directions=None if labels is None else labels.drop(list(self.copies)),
            copies=frozenset(),
        )


def check_directions(directions: pd.Series, sequences: Iterable[str]) -> None:
    """Raise `DatasetError` unless every label is 1 … 8 and belongs to one of `sequences`."""
    stray = [name for name in directions.index if name not in set(sequences)]
    if stray:
        raise DatasetError(
            f"directions names sequence(s) that are not there: {', '.join(map(str, stray[:5]))}; "
            "drop those labels or add the sequences."
        )
    missing = [name for name in sequences if name not in directions.index]
    if missing:
        raise DatasetError(
            f"directions lacks a label for {', '.join(map(str, missing[:5]))}; label every one."
        )
    if not directions.index.is_unique:
        raise DatasetError("directions labels a sequence twice; keep one label each.")
    wrong = directions[~directions.isin(DIRECTIONS)]
    if len(wrong):
        raise DatasetError(
            f"directions gives {wrong.index[0]!r} the direction {wrong.iloc[0]!r}; "
            "use whole numbers 1 to 8."
        )
