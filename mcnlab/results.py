"""Thesis | here: the one table that every notebook writes to, and the intervals in it."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from mcnlab.checks import require_number
from mcnlab.errors import ArgumentError
from mcnlab.files import write_whole
from mcnlab.statistics import Estimate

COLUMNS = ("id", "thesis", "here", "low", "high", "unit", "data", "n", "notebook")
OUT = "MCNLAB_OUT"  # where a reproduction gathers; nothing is written without it
SECONDS = "s"  # rows in seconds are timings: they differ from run to run


@dataclass(frozen=True)
class Row:
    """One reported quantity; empty text where there is nothing to say."""

    id: str
    thesis: str
    here: str
    low: str
    high: str
    unit: str
    data: str
    n: str
    notebook: str


class Results:
    """What one notebook reports.

    Parameters
    ----------
    notebook : str
        Its file name without the ending.
    data : str
        The data its numbers come from, unless a row says otherwise.
    """

    def __init__(self, notebook, *, data=""):
        self.notebook = notebook
        self.data = data
        self.rows = []

    def add(
        self,
        name: str,
        here: Estimate | float | int | None,
        *,
        thesis: float | None = None,
        unit: str = "",
        data: str | None = None,
    ) -> None:
        """Report one quantity.

        Parameters
        ----------
        name : str
            Its id.
        here : Estimate or float or int or None
            What was measured; None where the data at hand do not say, as when leaving
            one subject out of one.
        thesis : float, optional
            What the thesis claims.
        unit : str, optional
        data : str, optional
            The data, if not the notebook's.

        Raises
        ------
        ArgumentError
            When the id was reported before or the number is not finite.
        """
        if any(row.id == name for row in self.rows):
            raise ArgumentError(f"name {name!r} was reported before; report an id once.")
        estimate = here if isinstance(here, Estimate) else Estimate(here, None, None, None)
        if here is None:
            thesis = None  # there is nothing to hold the claim against
        for number in (thesis, *estimate[:3]):
            if number is not None:
                require_number(name, number)
        self.rows.append(
            Row(
                id=name,
                thesis=_text(thesis),
                here=_text(estimate.value),
                low=_text(estimate.low),
                high=_text(estimate.high),
                unit=unit,
                data=self.data if data is None else data,
                n="" if estimate.n is None else str(estimate.n),
                notebook=self.notebook,
            )
        )

    def table(self) -> pd.DataFrame:
        """The rows as a table of text."""
        return pd.DataFrame([vars(row) for row in self.rows], columns=list(COLUMNS))

    def show(self) -> None:
        """Print "quantity | thesis | here | interval"; write the rows if reproducing.

        Timings are written, not printed: they differ from run to run.
        """
        rows = [row for row in self.rows if row.unit != SECONDS]
        width = max([len(row.id) for row in rows] + [8])
        print(f"{'quantity':<{width}} | {'thesis':>7} | {'here':>17} | 95 % interval    | n")
        print("-" * (width + 58))
        for row in rows:
            interval = f"{row.low} to {row.high}" if row.low else ""
            here = f"{row.here} {row.unit}".strip()
            print(f"{row.id:<{width}} | {row.thesis:>7} | {here:>17} | {interval:<16} | {row.n}")
        out = os.environ.get(OUT)
        if out:
            path = Path(out) / "rows" / f"{self.notebook}.csv"
            write_whole(path, self.table().to_csv(index=False, lineterminator="\n"))


def verdict_of(row: Mapping[str, str]) -> str:
    """What a result row says of the thesis's claim.

    Parameters
    ----------
    row : mapping
        ``thesis, here, low, high, unit``, text.

    Returns
    -------
    str
        "holds" when the claim lies within the interval or equals the number, "exceeded"
        or "below the claim" when it lies outside; "faster" or "slower" for seconds;
        "other data" when a count differs, as with fewer subjects; "no claim" when the
        thesis has none.
    """
    if not row["thesis"]:
        return "no claim"
    claim, here = float(row["thesis"]), float(row["here"])
    if row["unit"] == SECONDS:
        return "faster" if here < claim else "slower"
    low, high = (float(row[key]) if row[key] else here for key in ("low", "high"))
    if low <= claim <= high:
        return "holds"
    if row["unit"] and not row["low"]:
        return "other data"
    return "exceeded" if here > claim else "below the claim"


def _text(value):
    """A number to four decimals, or a whole one from a thousand on."""
    if value is None:
        return ""
    if isinstance(value, int | np.integer):
        return str(int(value))
    if abs(value) >= 1000:
        return f"{value:.0f}"
    text = f"{value:.4f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text
