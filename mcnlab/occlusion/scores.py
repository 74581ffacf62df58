"""How forecasts of occlusion are scored: yes or no, and how sure.

A *pair* is two walkers at a moment.  The truth says whether one will occlude the other; a
forecast gives a probability.  The answer is "yes" where the probability reaches a threshold,
and a *true positive* is a yes to a pair that does occlude.

How sure such a score is, and how good times and places are, is told by bootstrap, below.
"""

from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy import sparse

from mcnlab.checks import (
    require_all,
    require_array,
    require_count,
    require_flags,
    require_labels,
    require_like,
    require_number,
)
from mcnlab.errors import ArgumentError
from mcnlab.statistics import (
    Couples,
    Estimate,
    draw_pairs,
    estimate_of,
    weighted_medians,
    wilson_interval,
)
from mcnlab.tables import check_columns

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


def curve_of(
    occludes: ArrayLike, probability: ArrayLike, *, weights: ArrayLike | None = None
) -> Curve:
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
    from sklearn.metrics import precision_recall_curve

    occludes, probability, weights = _check_counting(occludes, probability, weights)
    precision, recall, rising = precision_recall_curve(occludes, probability, sample_weight=weights)
    # The last entry is above every probability.
    precision, recall = precision[-2::-1], recall[-2::-1]
    some = np.where(precision + recall > 0, precision + recall, 1.0)
    return Curve(rising[::-1], precision, recall, 2 * precision * recall / some)


def average_precision(
    occludes: ArrayLike, probability: ArrayLike, *, weights: ArrayLike | None = None
) -> float:
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
    from sklearn.metrics import average_precision_score

    occludes, probability, weights = _check_counting(occludes, probability, weights)
    return float(average_precision_score(occludes, probability, sample_weight=weights))


def f1_of(occludes: ArrayLike, said: ArrayLike, *, weights: ArrayLike | None = None) -> float:
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
    from sklearn.metrics import f1_score

    occludes, said = require_flags("occludes", occludes), require_flags("said", said)
    require_like(occludes, of="occludes", said=said)
    weights = _check_weights(weights, occludes)
    _require_positive(occludes & (weights > 0))
    return float(f1_score(occludes, said, sample_weight=weights, zero_division=0.0))


def count_answers(occludes: ArrayLike, probability: ArrayLike, threshold: float) -> Answers:
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
    _require_positive(occludes)
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


def best_threshold(
    occludes: ArrayLike,
    probability: ArrayLike,
    groups: ArrayLike | None = None,
    *,
    say: dict | None = None,
) -> float:
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
    _require_positive(occludes)
    say = _check_say(say, groups)
    names = (
        np.zeros(len(occludes)) if groups is None else require_labels("groups", groups).astype(str)
    )
    require_like(occludes, of="occludes", groups=names)
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


def calibration_error(occludes: ArrayLike, probability: ArrayLike, *, bins: int = BINS) -> float:
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


def reliability_of(
    occludes: ArrayLike, probability: ArrayLike, *, bins: int = BINS
) -> pd.DataFrame:
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


def bins_of(probability: np.ndarray, bins: int) -> np.ndarray:
    """The bin 0 … bins − 1 of each probability; each holds its upper edge."""
    bins = require_count("bins", bins, low=1)
    return np.searchsorted(np.arange(1, bins) / bins, probability, side="left")


def _check_pairs(occludes, probability):
    """Flags and probabilities, one of each a pair."""
    occludes = require_flags("occludes", occludes)
    probability = require_array("probability", probability, low=0, high=1)
    require_like(occludes, of="occludes", probability=probability)
    return occludes, probability


def _check_counting(occludes, probability, weights):
    """The pairs that count anything, and what they count; so every yes has a precision."""
    occludes, probability = _check_pairs(occludes, probability)
    weights = _check_weights(weights, occludes)
    _require_positive(occludes & (weights > 0))
    return tuple(values[weights > 0] for values in (occludes, probability, weights))


def _check_weights(weights, occludes):
    if weights is None:
        return np.ones(len(occludes))
    weights = require_array("weights", weights, low=0, high=_HEAVIEST)
    require_like(occludes, of="occludes", weights=weights)
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


TRUTH = ("occludes", "seconds", "x", "y", "first", "second", "height")
FORECAST = ("probability", "seconds", "x", "y")
_CELLS = 2_000_000  # numbers held at a time while drawing


class Scores(NamedTuple):
    """What a forecaster is worth; each with its interval by walker, ``n`` counting walkers."""

    precision: Estimate
    recall: Estimate
    f1: Estimate
    ap: Estimate
    calibration_error: Estimate
    time_error_s: Estimate  # median over true positives, seconds
    place_error: Estimate  # median over true positives, body heights


class Difference(NamedTuple):
    """How much more one forecaster is worth than another, on the same draws of walkers."""

    f1: Estimate
    ap: Estimate


def score(
    truth: pd.DataFrame,
    forecast: pd.DataFrame,
    *,
    threshold: float,
    draws: int = 400,
    seed: int = 0,
) -> Scores:
    """Score one forecaster on one sequence, with intervals by walker.

    A draw takes as many walkers as there are, with replacement; a pair counts the product of
    how often its two walkers were drawn (a walker does not meet his own copy), with all its
    moments.  This is the bootstrap of a jointly exchangeable array, the way to resample data
    on pairs from one population; with rows and columns from two populations it is known as
    the pigeonhole bootstrap.  It allows for any dependence between pairs that share a walker
    and none between pairs that do not, as when a whole crowd stops.  It is conservative: chance
    that belongs to the single pair is counted up to three times, so that an interval is up to
    √3 times too wide where the walkers themselves hardly matter.  Where hardly anything else
    matters it is somewhat too narrow, as any bootstrap of few: in simulation, intervals from
    20 walkers then held the truth nine times in ten.

    Parameters
    ----------
    truth : pandas.DataFrame or NamedTuple
        Arrays of shape (n,): ``occludes`` (bool); ``seconds`` (from now to the first frame of
        occlusion), ``x, y`` (its place, pixels) and ``height`` (a body's height there, pixels),
        which are read where a pair occludes only; ``first, second`` (who the two are, each by
        one name throughout).
    forecast : pandas.DataFrame or NamedTuple
        Arrays of shape (n,), in the same order: ``probability`` in [0, 1], ``seconds`` (inf:
        never), ``x, y`` (pixels).
    threshold : float
        Yes where the probability is at least this; to be chosen on other sequences.
    draws : int, optional
    seed : int, optional

    Returns
    -------
    Scores
        A value is None where it does not exist: a precision without a yes, an error of time or
        place without a true positive, a median time of "never".  An interval holds the middle
        95 % of the draws (of the calibration error, whose draws lie too high: as far to both
        sides as they go to one).  Draws without a positive, or in which the value does not
        exist, are left out; where they are most, or all draws are alike and so show no spread,
        the interval is None.

    Raises
    ------
    McnError
        When a column is missing, lengths differ, a number is out of range, no pair occludes,
        or a walker is paired with himself.

    References
    ----------
    L. Davezies, X. D'Haultfœuille and Y. Guyonvarch, Empirical process results for
    exchangeable arrays, Annals of Statistics 49, 2021. A. B. Owen, The pigeonhole bootstrap,
    Annals of Applied Statistics 1, 2007; A. B. Owen and D. Eckles, Bootstrapping data arrays of
    arbitrary order, Annals of Applied Statistics 6, 2012 (why it is conservative).
    """
    held = _check_truth(truth)
    walkers = draw_pairs(held["first"], held["second"], draws=draws, seed=seed)
    (found,) = _measure(walkers, [_count(held, walkers, forecast, threshold)])
    return Scores(
        **{
            name: estimate_of(values, walkers.n, centred=name == "calibration_error")
            for name, values in found.items()
        }
    )


def difference(
    truth: pd.DataFrame,
    forecast: pd.DataFrame,
    other: pd.DataFrame,
    *,
    thresholds: tuple[float, float],
    draws: int = 400,
    seed: int = 0,
) -> Difference:
    """How much better one forecaster is than another, on the same pairs and draws.

    Both meet the same easy and hard walkers, so the difference is surer than the two scores.

    Parameters
    ----------
    truth, forecast, draws, seed
        As for `score`.
    other : pandas.DataFrame or NamedTuple
        The other forecast.
    thresholds : tuple of float
        That of `forecast` and that of `other`.

    Returns
    -------
    Difference
        `forecast` less `other`; intervals as in `score`.

    Raises
    ------
    McnError
        As for `score`.
    """
    if not isinstance(thresholds, tuple | list) or len(thresholds) != 2:
        raise ArgumentError(
            f"thresholds is {thresholds!r}; pass two, that of forecast and that of other."
        )
    held = _check_truth(truth)
    walkers = draw_pairs(held["first"], held["second"], draws=draws, seed=seed)
    ours, theirs = _measure(
        walkers,
        [
            _count(held, walkers, forecast, thresholds[0], argument="forecast"),
            _count(held, walkers, other, thresholds[1], argument="other"),
        ],
    )
    return Difference(
        *(estimate_of(ours[name] - theirs[name], walkers.n) for name in Difference._fields)
    )


class _Counts(NamedTuple):
    """What the scores are made of: sums over pairs, and errors in rising order."""

    sums: sparse.csr_array  # (4 + BINS + 2·levels, couples)
    levels: int  # distinct probabilities of the positives
    errors: dict  # name → rising errors (k,) of the true positives, and their couples (k,)


def _check_truth(truth) -> dict[str, np.ndarray]:
    """The columns of the truth, by name."""
    held = _columns(truth, TRUTH, argument="truth")
    occludes = held["occludes"] = require_flags("truth.occludes", held["occludes"])
    _require_positive(occludes, name="truth.occludes")
    for name in ("seconds", "x", "y", "height"):
        values = held[name] = require_array(f"truth.{name}", held[name], finite=False)
        sound = np.isfinite(values) & ((values > 0) | (name != "height"))
        kind = "positive" if name == "height" else "finite"
        require_all(
            f"truth.{name}", values, sound | ~occludes, f"the pair occludes: pass a {kind} number"
        )
    first, second = (
        require_labels(f"truth.{name}", held[name]).astype(str) for name in ("first", "second")
    )
    if (first == second).any():
        row = int(np.argmax(first == second))
        raise ArgumentError(
            f"truth.first and truth.second are both {str(first[row])!r} at pair {row}; "
            "pass two different walkers."
        )
    return held


def _count(truth, walkers, forecast, threshold, *, argument="forecast"):
    """Sum up per couple all that a draw will weigh."""
    couple = walkers.couple
    threshold = require_number("threshold", threshold, low=0, high=1)
    occludes = truth["occludes"]
    held = {
        name: require_array(f"{argument}.{name}", values, finite=False)
        for name, values in _columns(forecast, FORECAST, argument=argument, like=occludes).items()
    }
    probability = require_array(f"{argument}.probability", held["probability"], low=0, high=1)
    for name, sound in (
        ("seconds", held["seconds"] > -np.inf),
        ("x", np.isfinite(held["x"])),
        ("y", np.isfinite(held["y"])),
    ):
        remedy = "pass a best guess for every pair (seconds may be inf: never)"
        require_all(f"{argument}.{name}", held[name], sound, remedy)
    said = probability >= threshold
    # How many pairs reach each probability that a positive has: all that the curve needs.
    rising = np.unique(probability[occludes])
    levels = len(rising)
    level = levels - np.searchsorted(rising, probability, side="right")
    reach = level < levels
    each = np.arange(len(occludes))
    rows = [
        (0, occludes & said),
        (1, ~occludes & said),
        (2, occludes & ~said),
        (3, np.ones_like(said)),
        (4 + bins_of(probability, BINS), probability - occludes),
        (4 + BINS + np.where(reach, level, 0), occludes),  # every positive reaches one
        (4 + BINS + levels + np.where(reach, level, 0), reach),
    ]
    row = np.concatenate([np.broadcast_to(at, each.shape) for at, _ in rows])
    value = np.concatenate([values.astype(float) for _, values in rows])
    sums = sparse.coo_array(
        (value, (row, np.tile(couple, len(rows)))),
        shape=(4 + BINS + 2 * levels, len(walkers.one)),
    ).tocsr()
    right = np.flatnonzero(occludes & said)
    gap = {name: np.abs(held[name][right] - truth[name][right]) for name in ("seconds", "x", "y")}
    errors = {}
    for name, error in (
        ("time_error_s", gap["seconds"]),
        ("place_error", np.hypot(gap["x"], gap["y"]) / truth["height"][right]),
    ):
        order = np.argsort(error, kind="stable")
        errors[name] = error[order], couple[right[order]]
    return _Counts(sums, levels, errors)


def _measure(walkers: Couples, counts: list[_Counts]) -> list[dict[str, np.ndarray]]:
    """Every score of every forecaster in every draw, NaN where it does not exist.

    Returns
    -------
    list of dict
        Name → (1 + draws,), the first one without drawing.
    """
    largest = max(len(walkers.one), *(each.sums.shape[0] for each in counts))
    step = max(_CELLS // largest, 1)
    parts = [[] for _ in counts]
    for start in range(0, len(walkers.times), step):
        weights = walkers.weights(slice(start, start + step))
        for part, each in zip(parts, counts, strict=True):
            part.append(_measure_weighted(each, weights))
    return [
        {name: np.concatenate([chunk[name] for chunk in part]) for name in Scores._fields}
        for part in parts
    ]


def _measure_weighted(counts, weights):
    """Every score, one entry a column of weights."""
    sums = counts.sums @ weights
    hits, false, missed, everyone = sums[:4]
    gaps = sums[4 : 4 + BINS]
    gained, entered = sums[4 + BINS :].reshape(2, counts.levels, -1)
    positive = hits + missed
    held, yes = gained.cumsum(axis=0), entered.cumsum(axis=0)
    precision = np.divide(held, yes, out=np.zeros_like(held), where=yes > 0)
    scores = {
        "precision": _ratio(hits, hits + false),
        "recall": _ratio(hits, positive),
        "f1": _ratio(2 * hits, hits + false + positive),
        "ap": _ratio((gained * precision).sum(axis=0), positive),
        "calibration_error": _ratio(np.abs(gaps).sum(axis=0), everyone),
    }
    for name, (rising, couple) in counts.errors.items():
        scores[name] = weighted_medians(rising, weights[couple])
    return {name: np.where(positive > 0, values, np.nan) for name, values in scores.items()}


def _ratio(part, whole):
    """`part` / `whole`, NaN where `whole` is 0."""
    return np.divide(part, whole, out=np.full(np.shape(whole), np.nan), where=whole > 0)


def _columns(table, names, *, argument, like=None):
    """The named columns of a table, or fields of a tuple, of one length."""
    if isinstance(table, pd.DataFrame):
        check_columns(table, names, argument=argument)
        held = {name: np.asarray(table[name]) for name in names}
    else:
        missing = [name for name in names if not hasattr(table, name)]
        if missing:
            raise ArgumentError(
                f"{argument} lacks {', '.join(missing)}; "
                f"pass a table or tuple with {', '.join(names)}."
            )
        held = {name: np.asarray(getattr(table, name)) for name in names}
    like = held[names[0]] if like is None else like
    require_like(like, of="the truth", **{f"{argument}.{name}": held[name] for name in names})
    return held


def _require_positive(occludes, *, name="occludes"):
    """Raise `ArgumentError` when no pair occludes."""
    if not occludes.any():
        raise ArgumentError(
            f"{name} names no pair that occludes (and counts), so there is nothing to find; "
            "pass at least one."
        )
