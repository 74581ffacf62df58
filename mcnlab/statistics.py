"""Estimates with an interval: Wilson, bootstrap by person and by pair."""

from typing import NamedTuple

import numpy as np

from mcnlab.checks import require_count, require_number
from mcnlab.errors import ArgumentError


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


def _draw_people(count, draws, seed):
    """How often each of `count` people is drawn, shape (draws, count)."""
    draws = require_count("draws", draws, low=1)
    drawn = np.random.default_rng(seed).integers(count, size=(draws, count))
    cell = drawn + count * np.arange(draws)[:, None]
    return np.bincount(cell.ravel(), minlength=draws * count).reshape(draws, count).astype(float)


def _weighted_medians(rising, weights):
    """The median of rising values (k,) under each column of weights (k, draws)."""
    if len(rising) == 0:
        return np.full(weights.shape[1], np.nan)
    below = weights.cumsum(axis=0)
    half = below[-1] / 2
    # Where the weights halve exactly between two values, the median is their mean.
    left = np.count_nonzero(below < half, axis=0)
    right = np.minimum(np.count_nonzero(below <= half, axis=0), len(rising) - 1)
    return np.where(half > 0, (rising[left] + rising[right]) / 2, np.nan)


def _estimate(values, n, *, centred=False):
    """The first value, with an interval from those drawn."""
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
