"""Thesis | here: the one table that every notebook writes to, and the intervals in it."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from mcnlab.errors import ArgumentError, require_count, require_number
from mcnlab.files import write_whole

COLUMNS = ("id", "thesis", "here", "low", "high", "unit", "data", "n", "notebook")
OUT = "MCNLAB_OUT"  # where a reproduction gathers; nothing is written without it
SECONDS = "s"  # rows in seconds are timings: they differ from run to run


class Estimate(NamedTuple):
    """A number with its 95 % interval and the observations behind it."""

    value: float
    low: float
    high: float
    n: int


def wilson_interval(share, n, *, z=1.959963984540054):
    """Wilson's score interval of a share.

    Parameters
    ----------
    share : float
        Between 0 and 1; need not be a multiple of 1/n.
    n : int
        Independent observations.
    z : float, optional
        Normal quantile; 95 % if not given.

    Returns
    -------
    tuple of float
        Low and high.

    Raises
    ------
    ArgumentError
        When a number is out of range.

    References
    ----------
    E. B. Wilson, J. American Statistical Association 22, 1927.
    """
    share = require_number("share", share, low=0, high=1)
    n = require_count("n", n, low=1)
    middle = (share + z**2 / (2 * n)) / (1 + z**2 / n)
    half = z / (1 + z**2 / n) * np.sqrt(share * (1 - share) / n + z**2 / (4 * n**2))
    return max(0.0, float(middle - half)), min(1.0, float(middle + half))


def accuracy(right, *, own=None):
    """The share that is right, with Wilson's interval.

    Parameters
    ----------
    right : array_like of bool, shape (n,)
    own : array_like of bool, shape (n,), optional
        False for mirrored copies: they count in the share, as in the thesis, but a
        mirror image is no second observation and does not narrow the interval.

    Returns
    -------
    Estimate
    """
    right = np.asarray(right, dtype=bool)
    if right.ndim != 1 or len(right) == 0:
        raise ArgumentError(f"right has shape {right.shape}; pass one flag an answer.")
    if own is not None and np.shape(own) != right.shape:
        raise ArgumentError(f"own has shape {np.shape(own)}, right {right.shape}; pass as many.")
    n = len(right) if own is None else int(np.count_nonzero(own))
    return share_of(right.mean(), n)


def share_of(share, n):
    """A share of `n` independent observations, with Wilson's interval."""
    return Estimate(float(share), *wilson_interval(float(share), n), n)


def mean_by_subject(values, subjects, *, seed=0, draws=4000):
    """A mean, with a bootstrap interval that draws whole subjects.

    Parameters
    ----------
    values : array_like, shape (n,)
    subjects : array_like, shape (n,)
        Values of one subject are alike; subjects are independent.
    seed : int, optional
    draws : int, optional

    Returns
    -------
    Estimate
        ``n`` counts subjects.
    """
    values, codes = _by_subject(values, subjects)
    if codes.max() == 0:
        return Estimate(float(values.mean()), None, None, 1)  # one subject shows no spread
    total, count = np.bincount(codes, values), np.bincount(codes)
    drawn = np.random.default_rng(seed).integers(len(count), size=(draws, len(count)))
    means = total[drawn].sum(axis=1) / count[drawn].sum(axis=1)
    low, high = np.percentile(means, [2.5, 97.5])
    return Estimate(float(values.mean()), float(low), float(high), len(count))


def share_by_subject(right, subjects):
    """A share, with Wilson's interval of as many observations as it is worth.

    Answers about one subject are alike, so n of them are worth fewer: as many as would make
    the spread between subjects a binomial one, but no fewer than there are subjects.  Where
    all answers are alike they show no spread, and each subject counts once.

    Parameters
    ----------
    right : array_like of bool, shape (n,)
    subjects : array_like, shape (n,)

    Returns
    -------
    Estimate
        ``n`` counts subjects.

    References
    ----------
    E. L. Korn and B. I. Graubard, Survey Methodology 24, 1998: effective sample sizes.
    """
    right, codes = _by_subject(right, subjects)
    if not np.isin(right, (0.0, 1.0)).all():
        raise ArgumentError("right must hold True or False, one an answer.")
    share, count = right.mean(), np.bincount(codes)
    subjects = len(count)
    apart = np.bincount(codes, right) - share * count
    spread = (apart**2).sum() / len(right) ** 2 * subjects / max(subjects - 1, 1)
    worth = share * (1 - share) / spread if spread > 0 else 0.0
    worth = round(min(max(worth, subjects), len(right)))
    return Estimate(float(share), *wilson_interval(float(share), worth), subjects)


def median_by_subject(values, subjects, *, seed=0, draws=1000):
    """A median, with a bootstrap interval that draws whole subjects; see `mean_by_subject`."""
    values, codes = _by_subject(values, subjects)
    if codes.max() == 0:
        return Estimate(float(np.median(values)), None, None, 1)
    order = np.argsort(values)
    size = codes.max() + 1
    rng = np.random.default_rng(seed)
    medians = np.empty(draws)
    for draw in range(draws):
        # How often each subject was drawn weighs all of its values.
        weights = np.bincount(rng.integers(size, size=size), minlength=size)[codes[order]]
        below = np.cumsum(weights)
        middle = [np.searchsorted(below, below[-1] / 2, side) for side in ("left", "right")]
        medians[draw] = values[order[middle]].mean()
    low, high = np.percentile(medians, [2.5, 97.5])
    return Estimate(float(np.median(values)), float(low), float(high), int(size))


def _by_subject(values, subjects):
    """Values as floats, and the number of each one's subject."""
    values = np.asarray(values, dtype=float)
    if values.ndim != 1 or len(values) == 0 or not np.isfinite(values).all():
        raise ArgumentError("values must be a non-empty sequence of finite numbers.")
    if np.shape(subjects) != values.shape:
        raise ArgumentError(f"subjects names {len(subjects)} of {len(values)} values; name all.")
    return values, np.unique(np.asarray(subjects, dtype=str), return_inverse=True)[1]


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

    def add(self, name, here, *, thesis=None, unit="", data=None):
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

    def table(self):
        """The rows as a table of text."""
        return pd.DataFrame([vars(row) for row in self.rows], columns=list(COLUMNS))

    def show(self):
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


def verdict_of(row):
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
