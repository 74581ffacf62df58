"""Estimates with an interval: Wilson's, and bootstraps that draw people.

Answers about one person are alike; so whole people are drawn, with replacement, and what is
known of somebody counts as often as he was drawn (`draw_people`).  What is known of a pair of
people counts the product of how often its two were drawn (`draw_pairs`).  A difference of two
methods is measured on the same draws.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mcnlab.checks import (
    require_array,
    require_count,
    require_flags,
    require_labels,
    require_like,
    require_number,
)
from mcnlab.errors import ArgumentError


class Estimate(NamedTuple):
    """A number with its 95 % interval and the observations behind it."""

    value: float | None
    low: float | None
    high: float | None
    n: int | None


def wilson_interval(share: float, n: int, *, z: float = 1.959963984540054) -> tuple[float, float]:
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


def accuracy(right: ArrayLike, *, own: ArrayLike | None = None) -> Estimate:
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
    right = require_flags("right", right)
    own = right | True if own is None else require_flags("own", own)
    require_like(right, of="right", own=own)
    n = int(np.count_nonzero(own))
    return share_of(right.mean(), n)


def share_of(share: float, n: int) -> Estimate:
    """A share of `n` independent observations, with Wilson's interval."""
    return Estimate(float(share), *wilson_interval(float(share), n), n)


def mean_by_subject(
    values: ArrayLike, subjects: ArrayLike, *, seed: int = 0, draws: int = 4000
) -> Estimate:
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
    weights = draw_people(len(count), draws=draws, seed=seed)
    means = (weights @ total) / (weights @ count)
    return Estimate(float(values.mean()), *interval_of(means), len(count))


def share_by_subject(right: ArrayLike, subjects: ArrayLike) -> Estimate:
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


def median_by_subject(
    values: ArrayLike, subjects: ArrayLike, *, seed: int = 0, draws: int = 1000
) -> Estimate:
    """A median, with a bootstrap interval that draws whole subjects; see `mean_by_subject`."""
    values, codes = _by_subject(values, subjects)
    if codes.max() == 0:
        return Estimate(float(np.median(values)), None, None, 1)
    order = np.argsort(values)
    size = int(codes.max()) + 1
    medians = np.empty(draws)
    for draw, times in enumerate(draw_people(size, draws=draws, seed=seed)):
        medians[draw] = weighted_medians(values[order], times[codes[order], None])[0]
    return Estimate(float(np.median(values)), *interval_of(medians), size)


def _by_subject(values: ArrayLike, subjects: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Values as floats, and the number of each one's subject."""
    values = require_array("values", values, (None,), least=1)
    subjects = require_labels("subjects", subjects)
    require_like(values, of="values", subjects=subjects)
    return values, np.unique(subjects.astype(str), return_inverse=True)[1]


def interval_of(drawn: np.ndarray) -> tuple[float, float]:
    """The middle 95 % of what was drawn: low and high."""
    low, high = np.percentile(drawn, [2.5, 97.5])
    return float(low), float(high)


def draw_people(count: int, *, draws: int, seed: int) -> np.ndarray:
    """How often each of `count` people is drawn when as many are: shape (draws, count)."""
    draws = require_count("draws", draws, low=1)
    drawn = np.random.default_rng(seed).integers(count, size=(draws, count))
    cell = drawn + count * np.arange(draws)[:, None]
    return np.bincount(cell.ravel(), minlength=draws * count).reshape(draws, count).astype(float)


class Couples(NamedTuple):
    """Which two people each observation is of, and how often each person is drawn."""

    couple: np.ndarray  # (n,) the number of the two
    one: np.ndarray  # (couples,) a couple's one person
    two: np.ndarray  # (couples,) and the other
    times: np.ndarray  # (1 + draws, people): how often drawn; once each in the first row

    @property
    def n(self) -> int:
        """How many people there are."""
        return self.times.shape[1]

    def weights(self, rows: slice = slice(None)) -> np.ndarray:
        """What each couple counts in some draws, shape (couples, draws)."""
        times = self.times[rows].T
        return times[self.one] * times[self.two]


def draw_pairs(first: ArrayLike, second: ArrayLike, *, draws: int, seed: int) -> Couples:
    """Draw people, for observations of pairs of them.

    Parameters
    ----------
    first, second : array_like, shape (n,)
        Who the two are, each by one name throughout; their order says nothing.
    draws, seed : int

    Returns
    -------
    Couples

    Raises
    ------
    ArgumentError
        When lengths differ, a name is missing, or a number is out of range.
    """
    draws, seed = require_count("draws", draws, low=1), require_count("seed", seed)
    first, second = require_labels("first", first), require_labels("second", second)
    require_like(first, of="first", second=second)
    people, codes = np.unique(np.r_[first.astype(str), second.astype(str)], return_inverse=True)
    one, two = np.sort(codes.reshape(2, -1), axis=0)
    size = len(people)
    couples, couple = np.unique(one * size + two, return_inverse=True)
    drawn = np.random.default_rng(seed).multinomial(size, np.full(size, 1 / size), draws)
    times = np.vstack([np.ones(size), drawn])
    return Couples(couple, couples // size, couples % size, times)


def share_by_pair(hit: np.ndarray, every: np.ndarray, couples: Couples) -> Estimate | None:
    """The share of `every` that is a `hit`, with an interval from drawing people.

    Parameters
    ----------
    hit, every : ndarray of bool, shape (n,)
        A hit is one of `every`.
    couples : Couples
        As `draw_pairs` gives them for the n observations.

    Returns
    -------
    Estimate or None
        ``n`` counts people; fewer than three show no spread, and there is no interval.  None
        where there is nothing to count.
    """
    if not every.any():
        return None
    value, people = float(hit.sum() / every.sum()), couples.n
    if people < 3:
        return Estimate(value, None, None, people)
    weights = couples.weights(slice(1, None)).T
    hits, alls = (weights @ np.bincount(couples.couple, part) for part in (hit, every))
    return Estimate(value, *interval_of(hits[alls > 0] / alls[alls > 0]), people)


def weighted_medians(rising: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """The median of rising values (k,) under each column of weights (k, draws)."""
    if len(rising) == 0:
        return np.full(weights.shape[1], np.nan)
    below = weights.cumsum(axis=0)
    half = below[-1] / 2
    # Where the weights halve exactly between two values, the median is their mean.
    left = np.count_nonzero(below < half, axis=0)
    right = np.minimum(np.count_nonzero(below <= half, axis=0), len(rising) - 1)
    return np.where(half > 0, (rising[left] + rising[right]) / 2, np.nan)


def estimate_of(values: np.ndarray, n: int, *, centred: bool = False) -> Estimate:
    """The first value, with an interval from those drawn; NaN where a draw has none.

    There is no interval where most draws have no value, or all are alike.  A `centred` one goes
    as far to both sides as the draws do to one, and stays within 0 and 1.
    """
    value, drawn = float(values[0]), values[1:]
    if not np.isfinite(value):
        return Estimate(None, None, None, n)
    known = drawn[~np.isnan(drawn)]
    if len(known) == 0 or 2 * len(known) < len(drawn):
        return Estimate(value, None, None, n)
    # Without interpolation, which would fail next to an infinite error.
    low, high = np.percentile(known, [2.5, 97.5], method="inverted_cdf").tolist()
    if low == high or not np.isfinite(high):
        return Estimate(value, None, None, n)
    if centred:
        reach = max(high - value, value - low)
        low, high = max(value - reach, 0.0), min(value + reach, 1.0)
    return Estimate(value, low, high, n)
