"""How sure a score is: forecasters scored on walkers drawn again and again.

Pairs are many, walkers few: one walker is in many pairs, and two walkers meet at many moments,
so pairs are not independent and their number says little about how sure a score is.  All
intervals of `score` and `difference` therefore draw whole walkers.

The truth says whether a pair occludes, and if so when and where; a forecast gives a
probability, a time and a place.  The single scores are those of `mcnlab.scoring`.
"""

from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy import sparse

from mcnlab.checks import (
    require_all,
    require_flags,
    require_flat,
    require_length,
    require_numbers,
    require_positive,
    require_probabilities,
)
from mcnlab.columns import check_columns
from mcnlab.errors import ArgumentError, require_count, require_number
from mcnlab.results import Estimate
from mcnlab.scoring import BINS, bins_of

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


def score(truth, forecast, *, threshold, draws=400, seed=0):
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
    walkers = _draw_walkers(truth, draws=draws, seed=seed)
    (found,) = _measure(walkers, [_count(walkers, forecast, threshold)])
    return Scores(
        **{
            name: _estimate(values, walkers.n, centred=name == "calibration_error")
            for name, values in found.items()
        }
    )


def difference(truth, forecast, other, *, thresholds, draws=400, seed=0):
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
    walkers = _draw_walkers(truth, draws=draws, seed=seed)
    ours, theirs = _measure(
        walkers,
        [
            _count(walkers, forecast, thresholds[0], argument="forecast"),
            _count(walkers, other, thresholds[1], argument="other"),
        ],
    )
    return Difference(
        *(_estimate(ours[name] - theirs[name], walkers.n) for name in Difference._fields)
    )


class _Walkers(NamedTuple):
    """The truth, and how often each walker is drawn."""

    truth: dict  # name → (n,)
    couple: np.ndarray  # (n,) which two walkers a pair is
    one: np.ndarray  # (couples,) a couple's one walker
    two: np.ndarray  # (couples,) and the other
    times: np.ndarray  # (1 + draws, walkers): how often drawn; once each in the first row

    @property
    def n(self):
        return self.times.shape[1]


class _Counts(NamedTuple):
    """What the scores are made of: sums over pairs, and errors in rising order."""

    sums: sparse.csr_array  # (4 + BINS + 2·levels, couples)
    levels: int  # distinct probabilities of the positives
    errors: dict  # name → rising errors (k,) of the true positives, and their couples (k,)


def _draw_walkers(truth, *, draws, seed):
    """Check the truth and draw walkers."""
    draws, seed = require_count("draws", draws, low=1), require_count("seed", seed)
    held = _columns(truth, TRUTH, argument="truth")
    occludes = held["occludes"] = require_flags("truth.occludes", held["occludes"])
    require_positive(occludes, name="truth.occludes")
    for name in ("seconds", "x", "y", "height"):
        values = held[name] = require_numbers(f"truth.{name}", held[name])
        sound = np.isfinite(values) & ((values > 0) | (name != "height"))
        kind = "positive" if name == "height" else "finite"
        require_all(
            f"truth.{name}", values, sound | ~occludes, f"the pair occludes: pass a {kind} number"
        )
    who = np.concatenate([held["first"], held["second"]])
    one, two = np.sort(_codes("truth.first and truth.second", who).reshape(2, -1), axis=0)
    if (one == two).any():
        row = int(np.flatnonzero(one == two)[0])
        raise ArgumentError(
            f"truth.first and truth.second are both {str(who[row])!r} at pair {row}; "
            "pass two different walkers."
        )
    walkers = int(two.max()) + 1
    couples, couple = np.unique(one * walkers + two, return_inverse=True)
    drawn = np.random.default_rng(seed).multinomial(walkers, np.full(walkers, 1 / walkers), draws)
    times = np.vstack([np.ones(walkers), drawn])
    return _Walkers(held, couple, couples // walkers, couples % walkers, times)


def _count(walkers, forecast, threshold, *, argument="forecast"):
    """Sum up per couple all that a draw will weigh."""
    truth, couple = walkers.truth, walkers.couple
    threshold = require_number("threshold", threshold, low=0, high=1)
    occludes = truth["occludes"]
    held = {
        name: require_numbers(f"{argument}.{name}", values)
        for name, values in _columns(forecast, FORECAST, argument=argument, like=occludes).items()
    }
    probability = require_probabilities(f"{argument}.probability", held["probability"])
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


def _measure(walkers, counts):
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
        times = walkers.times[start : start + step].T
        weights = times[walkers.one] * times[walkers.two]  # (couples, draws at a time)
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
        scores[name] = _weighted_medians(rising, weights[couple])
    return {name: np.where(positive > 0, values, np.nan) for name, values in scores.items()}


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
    require_length(like, of="the truth", **{f"{argument}.{name}": held[name] for name in names})
    return held


def _codes(name, names):
    """Whole numbers from 0 on, one for each distinct name."""
    return np.unique(require_flat(name, names).astype(str), return_inverse=True)[1]
