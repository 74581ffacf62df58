"""How forecasts of occlusion are scored: yes or no, and how sure.

A *pair* is two walkers at a moment.  The truth says whether one will occlude the other; a
forecast gives a probability.  The answer is "yes" where the probability reaches a threshold,
and a *true positive* is a yes to a pair that does occlude.

How sure such a score is, and how good times and places are, is for `mcnlab.resampling`.
"""

from typing import NamedTuple

import numpy as np
import pandas as pd

from mcnlab.checks import (
    require_flags,
    require_flat,
    require_length,
    require_numbers,
    require_positive,
    require_probabilities,
)
from mcnlab.errors import ArgumentError, require_count, require_number
from mcnlab.results import wilson_interval

BINS = 10  # of the calibration error
_TIE = 1e-12  # means of F1 closer than this differ by rounding only
_HEAVIEST = 1e9  # more than any pair counts, and nothing overflows


class Curve(NamedTuple):
    """Precision against recall, one entry a distinct probability, the highest first."""

    threshold: np.ndarray  # yes where the probability is at least this
    precision: np.ndarray
    recall: np.ndarray
    f1: np.ndarray


class Answers(NamedTuple):
    """What yes/no answers came to: pairs, and the shares that follow; None: no such share."""

    hits: int
    misses: int
    false_alarms: int
    precision: float | None
    recall: float
    f1: float


def curve_of(occludes, probability, *, weights=None):
    """Precision and recall at every threshold that makes a difference.

    Parameters
    ----------
    occludes : array_like of bool, shape (n,)
    probability : array_like, shape (n,)
        In [0, 1]; equal ones share one entry of the curve.
    weights : array_like, shape (n,), optional
        What each pair counts, at least 0; 1 if not given.

    Returns
    -------
    Curve
        Arrays of one length.  Above the highest threshold nobody is told to occlude.

    Raises
    ------
    ArgumentError
        When lengths differ, a number is out of range, or no pair occludes.
    """
    occludes, probability = _check_pairs(occludes, probability)
    weights = _check_weights(weights, occludes)
    # A pair that counts nothing makes no entry; so every entry has a precision.
    occludes, probability, weights = (
        values[weights > 0] for values in (occludes, probability, weights)
    )
    require_positive(occludes)
    falling = np.argsort(-probability, kind="stable")
    occludes, probability, weights = occludes[falling], probability[falling], weights[falling]
    last = np.r_[np.flatnonzero(np.diff(probability)), len(probability) - 1]
    hits = np.cumsum(weights * occludes)[last]
    yes = np.cumsum(weights)[last]
    return Curve(probability[last], hits / yes, hits / hits[-1], 2 * hits / (yes + hits[-1]))


def average_precision(occludes, probability, *, weights=None):
    """The mean precision over recall: Σ (Rₖ − Rₖ₋₁) Pₖ along the curve, without interpolation.

    Pairs of equal probability enter together, so their order does not matter, and only the
    order of the probabilities does.  A constant forecaster gets the share that occludes.

    Parameters
    ----------
    occludes, probability, weights
        As for `curve_of`.

    Returns
    -------
    float
        In (0, 1].

    Raises
    ------
    ArgumentError
        As for `curve_of`.
    """
    curve = curve_of(occludes, probability, weights=weights)
    return float(np.sum(np.diff(curve.recall, prepend=0.0) * curve.precision))


def f1_of(occludes, said, *, weights=None):
    """F1 of yes/no answers: 2·TP / (2·TP + FP + FN), the harmonic mean of precision and recall.

    Parameters
    ----------
    occludes, said : array_like of bool, shape (n,)
    weights : array_like, shape (n,), optional

    Returns
    -------
    float
        0 where no yes is right.

    Raises
    ------
    ArgumentError
        When lengths differ, a flag is neither True nor False, or no pair occludes.
    """
    occludes, said = require_flags("occludes", occludes), require_flags("said", said)
    require_length(occludes, said=said)
    weights = _check_weights(weights, occludes)
    require_positive(occludes & (weights > 0))
    hits = weights[occludes & said].sum()
    return float(2 * hits / (weights[occludes].sum() + weights[said].sum()))


def count_answers(occludes, probability, threshold):
    """What becomes of pairs when those with at least `threshold` are told that they occlude.

    Parameters
    ----------
    occludes : array_like of bool, shape (n,)
    probability : array_like, shape (n,)
    threshold : float

    Returns
    -------
    Answers

    Raises
    ------
    ArgumentError
        When lengths differ, a number is out of range, or no pair occludes.
    """
    occludes, probability = _check_pairs(occludes, probability)
    require_positive(occludes)
    said = probability >= require_number("threshold", threshold, low=0, high=1)
    hits, yes, positive = (int(each.sum()) for each in (occludes & said, said, occludes))
    return Answers(
        hits,
        positive - hits,
        yes - hits,
        hits / yes if yes else None,
        hits / positive,
        2 * hits / (yes + positive),
    )


def best_threshold(occludes, probability, groups=None, *, say=None):
    """The threshold with the best F1, for use on *other* pairs than these.

    F1 is constant between neighbouring probabilities.  Of the stretches with the best F1 the
    widest is taken (of equally wide ones the lowest), and its middle is the threshold.

    Parameters
    ----------
    occludes : array_like of bool, shape (n,)
    probability : array_like, shape (n,)
    groups : array_like, shape (n,), optional
        Each pair's sequence.  The mean of the sequences' F1 is then best, so that a long
        sequence counts no more than a short one.  A sequence in which no pair occludes has F1
        0 at any threshold, and no say.
    say : dict, optional
        Sequence → how much it counts in that mean, above 0; all alike if not given.

    Returns
    -------
    float
        In [0, 1]; say yes where the probability is at least this.

    Raises
    ------
    ArgumentError
        When lengths differ, a number is out of range, no pair occludes, or `say` lacks a
        sequence in which one does.
    """
    occludes, probability = _check_pairs(occludes, probability)
    require_positive(occludes)
    say = _check_say(say, groups)
    names = (
        np.zeros(len(occludes)) if groups is None else require_flat("groups", groups).astype(str)
    )
    require_length(occludes, groups=names)
    levels = np.unique(probability)
    f1, total = np.zeros(len(levels)), 0.0
    for group in np.unique(names[occludes]):
        counts = 1.0 if say is None else _say_of(say, group)
        inside = names == group
        everyone = np.sort(probability[inside])
        positive = np.sort(probability[inside & occludes])
        yes = len(everyone) - np.searchsorted(everyone, levels)
        hits = len(positive) - np.searchsorted(positive, levels)
        f1 += counts * 2 * hits / (yes + len(positive))
        total += counts
    f1 /= total
    # Any threshold above the level before and up to this one gives this level's answers.
    low = np.r_[0.0, levels[:-1]]
    best = np.r_[False, f1 >= f1.max() - _TIE, False]
    start = np.flatnonzero(best[1:] & ~best[:-1])
    stop = np.flatnonzero(best[:-1] & ~best[1:]) - 1
    widest = int(np.argmax(levels[stop] - low[start]))
    bottom, top = low[start[widest]], levels[stop[widest]]
    middle = (bottom + top) / 2
    # Neighbouring floats have no middle; and 0 instead of −0.
    return float(middle if middle > bottom else top) + 0.0


def calibration_error(occludes, probability, *, bins=BINS):
    """The expected calibration error: how far probabilities are from what then happens.

    Σ_b n_b/n · |share that occludes in b − mean probability in b| over `bins` bins of equal
    width, (0, 1/bins], (1/bins, 2/bins], …; 0 belongs to the first.  It is never below 0, so a
    perfectly calibrated forecaster is found a little off, the more so the fewer the pairs; and
    where few pairs occlude it is small for anyone who says so, whatever else he knows.

    Parameters
    ----------
    occludes : array_like of bool, shape (n,)
    probability : array_like, shape (n,)
    bins : int, optional

    Returns
    -------
    float
        In [0, 1].

    Raises
    ------
    ArgumentError
        When lengths differ or a number is out of range.

    References
    ----------
    M. P. Naeini, G. F. Cooper and M. Hauskrecht, AAAI 2015; C. Guo, G. Pleiss, Y. Sun and
    K. Q. Weinberger, ICML 2017, equation 3.
    """
    occludes, probability = _check_pairs(occludes, probability)
    gap = np.bincount(bins_of(probability, bins), probability - occludes)
    return float(np.abs(gap).sum() / len(probability))


def reliability_of(occludes, probability, *, bins=BINS):
    """The table behind a reliability diagram and the calibration error.

    Parameters
    ----------
    occludes, probability, bins
        As for `calibration_error`.

    Returns
    -------
    pandas.DataFrame
        One row a bin that holds pairs: ``low, high`` (the bin), ``n`` (pairs), ``probability``
        (their mean), ``share`` (that occludes), ``share_low, share_high`` (Wilson's interval of
        n pairs; too narrow where they share walkers).

    Raises
    ------
    ArgumentError
        As for `calibration_error`.
    """
    occludes, probability = _check_pairs(occludes, probability)
    held, code, n = np.unique(bins_of(probability, bins), return_inverse=True, return_counts=True)
    share = np.bincount(code, occludes) / n
    interval = np.array([wilson_interval(*each) for each in zip(share, n.tolist(), strict=True)])
    return pd.DataFrame(
        {
            "low": held / bins,
            "high": (held + 1) / bins,
            "n": n,
            "probability": np.bincount(code, probability) / n,
            "share": share,
            "share_low": interval[:, 0],
            "share_high": interval[:, 1],
        }
    )


def bins_of(probability, bins):
    """The bin 0 … bins − 1 of each probability; each holds its upper edge."""
    bins = require_count("bins", bins, low=1)
    return np.searchsorted(np.arange(1, bins) / bins, probability, side="left")


def _check_pairs(occludes, probability):
    """Flags and probabilities, one of each a pair."""
    occludes = require_flags("occludes", occludes)
    require_length(occludes, probability=require_numbers("probability", probability))
    return occludes, require_probabilities("probability", probability)


def _check_weights(weights, occludes):
    if weights is None:
        return np.ones(len(occludes))
    weights = require_numbers("weights", weights)
    require_length(occludes, weights=weights)
    if not ((weights >= 0) & (weights <= _HEAVIEST)).all():
        raise ArgumentError(f"weights must hold numbers from 0 to {_HEAVIEST:g}, one a pair.")
    return weights


def _check_say(say, groups):
    """`say` by the names of the groups as text, as groups are told apart."""
    if say is None:
        return None
    if groups is None or not isinstance(say, dict):
        raise ArgumentError(
            f"say is {type(say).__name__}, groups {'not ' * (groups is None)}given; pass groups, "
            "and say as a dict: group → how much it counts."
        )
    return {str(group): counts for group, counts in say.items()}


def _say_of(say, group):
    group = str(group)
    if group not in say:
        raise ArgumentError(f"say lacks the group {group!r}; say how much every group counts.")
    return require_number(f"say[{group!r}]", say[group], above=0)
