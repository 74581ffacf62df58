"""Will two walkers cover each other, when, and where: the forecasters.

*thesis* is its tables and equations (section 3.3) on directions and speeds of the last second.
*constant-velocity* is the obvious baseline: straight lines in the image.
*perspective* goes straight on the ground.  For a pinhole camera, 1/s and x/s are linear in
time, s being the pixels a body height (`mcnlab.walking.heading`): neither the focal length nor
the principal point is needed to go back to the image.  Walkers do not walk straight on, and
boxes are noisy, so the distance between the two is uncertain by more every second.  At each
time, the cover exceeds the bound while the boxes are nearer across than some reach, which
gives an interval of errors that make them occlude.  The intervals of neighbouring times pass
into one another, so their union is taken to reach from the lowest end to the highest; its
probability is the forecast.  (It is too large where boxes are level with each other, then
not, and then again.)
*uncertain-velocity* lies between the two: straight in the image, with that uncertainty.
*learned* corrects the probability of *perspective* by what other recordings taught.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy.special import expit, logit, ndtr

from mcnlab.checks import require_array, require_flags, require_like, require_number
from mcnlab.compass import direction_of
from mcnlab.errors import ArgumentError
from mcnlab.occlusion import thesis
from mcnlab.occlusion.motion import Ground, move_straight
from mcnlab.occlusion.pairs import Rules, Walkers, WatchedPairs
from mcnlab.occlusion.thesis import Foreseen, Walker
from mcnlab.walking.speed import level_of

STEPS = 15  # of the horizon, at which the future is looked at
FIELD = 1.3  # focal length in frame widths where it is not known: a view 42 degrees wide
UPRIGHT = 0.4  # a walker's uncertainty up and down, against across
FAR = 4.0  # standard deviations beyond which two boxes will not meet
WIDEST = 6.0  # widths; a wider gap makes no difference
# Nodes and weights of Gauss-Hermite quadrature with three points.
_NODES = ((-np.sqrt(3), 1 / 6), (0.0, 2 / 3), (np.sqrt(3), 1 / 6))


class Forecast(NamedTuple):
    """What a forecaster says of n pairs; shape (n,) each."""

    probability: np.ndarray  # that they occlude within the horizon
    seconds: np.ndarray  # when, if they do
    x: np.ndarray  # where, pixels
    y: np.ndarray


def steps_of(rules: Rules) -> np.ndarray:
    """The times at which the future is looked at, seconds, shape (k,)."""
    return rules.horizon * np.arange(1, STEPS + 1) / STEPS


@dataclass(frozen=True)
class ConstantVelocity:
    """Straight lines in the image through the last second's boxes: centre, foot and height.

    The probability is a smooth function of the margin by which the largest cover foreseen
    exceeds the bound, or of the gap that is left: it ranks pairs, and is 1/2 at the bound.

    Attributes
    ----------
    softness : float
        Margin, in cover, that makes the odds e to one.
    """

    softness: float = 0.15
    name = "constant-velocity"

    def __post_init__(self):
        require_number("softness", self.softness, above=0)

    def forecast(self, pairs: WatchedPairs) -> Forecast:
        """What it says of each pair.

        Parameters
        ----------
        pairs : pairs.Pairs

        Returns
        -------
        Forecast
        """
        times = steps_of(pairs.rules)
        first, second = _of_pairs(move_straight(pairs.walkers, times), pairs.who)
        margin = np.maximum(_margin(first, second), -WIDEST) - pairs.rules.cover
        at, seconds = _first_crossing(margin, times)
        probability = expit(margin.max(axis=0) / self.softness)
        return Forecast(probability, seconds, *_place(first, second, at))


@dataclass(frozen=True)
class Thesis:
    """The thesis's tables and equations (section 3.3), "within the horizon" by its own time.

    Directions and speeds are those of the observed time, by the better means of this package
    (closed-form headings); what is put to the test are the tables and the equations.

    Attributes
    ----------
    focal_length : float or None
        Pixels, for the headings; 1.3 frame widths if None.
    """

    focal_length: float | None = None
    name = "thesis"

    def forecast(self, pairs: WatchedPairs) -> Forecast:
        """What it says of each pair: a probability of 1 or 0; see `ConstantVelocity.forecast`."""
        foreseen, _ = self.explain(pairs)
        horizon = pairs.rules.horizon
        yes = foreseen.occludes & (foreseen.seconds <= horizon)
        seconds = np.where(yes, foreseen.seconds, horizon)
        return Forecast(yes.astype(float), seconds, foreseen.x, foreseen.y)

    def explain(self, pairs: WatchedPairs) -> tuple[Foreseen, pd.DataFrame]:
        """The tables' answer, and what they were asked.

        Returns
        -------
        foreseen : occlusion.Foreseen
        asked : pandas.DataFrame
            ``direction1, direction2, level1, level2`` of S1 and S2, the one on the left; of
            two in one column, of whom the tables say nothing, the upper one is S1.
        """
        camera = pairs.walkers.camera
        seen = self.look(pairs.walkers)
        one, two = (thesis.Walker(*(value[rows] for value in seen)) for rows in pairs.who.T)
        foreseen = thesis.foresee(one, two, frame_width=camera.width, frame_height=camera.height)
        ordered = (one.x < two.x) | ((one.x == two.x) & (one.y < two.y))
        left = np.where(ordered[:, None], pairs.who, pairs.who[:, ::-1])
        level = level_of(seen.pixels, frame_width=camera.width)
        asked = {
            f"{name}{number}": value[left[:, number - 1]]
            for name, value in (("direction", seen.direction), ("level", level))
            for number in (1, 2)
        }
        return foreseen, pd.DataFrame(asked)

    def look(self, walkers: Walkers) -> Walker:
        """Place, direction and speed of each walker, as `occlusion.Walker`."""
        camera = walkers.camera
        focal_length = self.focal_length
        if focal_length is None:
            focal_length = FIELD * camera.width
        require_number("focal_length", focal_length, above=0, unit="pixels")
        heading = Ground.of(walkers).heading(focal_length=focal_length)
        middle = walkers.feet - walkers.h / 2
        span = walkers.time[-1] - walkers.time[0]
        vx, vy = ((value[:, -1] - value[:, 0]) / span for value in (walkers.x, middle))
        return thesis.Walker(
            walkers.x[:, -1], middle[:, -1], direction_of(heading), np.hypot(vx, vy), vx, vy
        )


@dataclass(frozen=True)
class Perspective:
    """Straight on the ground in body heights, with the uncertainty of walking and of boxes."""

    name = "perspective"

    def forecast(self, pairs: WatchedPairs) -> Forecast:
        """What it says of each pair; see `ConstantVelocity.forecast`."""
        return self.look_ahead(pairs).forecast

    def look_ahead(self, pairs: WatchedPairs) -> "Outlook":
        """The forecast, and what it was made of.

        Returns
        -------
        Outlook
        """
        times = steps_of(pairs.rules)
        ground = Ground.of(pairs.walkers)
        motion, spread = self._move(ground, times), ground.spread(times)
        who = pairs.who
        near = _may_meet(motion, spread, who)
        first, second = _of_pairs(motion, who[near])
        apart = np.hypot(*(spread[:, walkers] for walkers in who[near].T))
        # Of those whose ways may cross, these may be there at the same time.
        meet = np.flatnonzero(_may_touch(first, second, apart).any(axis=0))
        near, first, second, apart = near[meet], first.take(meet), second.take(meet), apart[:, meet]
        probability = np.zeros(len(who))
        probability[near], by_then, margin = _meeting(first, second, apart, pairs.rules.cover)
        at, when = _half_way(by_then, times)
        seconds = np.full(len(who), times[-1])
        seconds[near] = when
        x, y = (
            (place[-1, who[:, 0]] + place[-1, who[:, 1]]) / 2 for place in (motion.x, motion.feet)
        )
        x[near], y[near] = _place(first, second, at)
        return Outlook(Forecast(probability, seconds, x, y), pairs, ground, near, margin)

    def _move(self, ground, times):
        return ground.move(times)


@dataclass(frozen=True)
class UncertainVelocity(Perspective):
    """`ConstantVelocity`'s straight lines in the image with `Perspective`'s uncertainty.

    It shows how much of what `Perspective` gains is to know how uncertain the future is.
    """

    name = "uncertain-velocity"

    def _move(self, ground, times):
        return move_straight(ground.walkers, times)


@dataclass(frozen=True)
class Outlook:
    """How `Perspective` came to its forecast.

    Attributes
    ----------
    forecast : Forecast
    pairs : pairs.Pairs
    ground : Ground
    near : ndarray of int, shape (n,)
        The pairs that may meet at all; of the others the probability is 0.
    margin : ndarray, shape (STEPS, n)
        Of those: by how many standard deviations the boxes on the mean path reach into each
        other beyond the bound, at each time.
    """

    forecast: Forecast
    pairs: WatchedPairs
    ground: "Ground"
    near: np.ndarray
    margin: np.ndarray


def _may_meet(motion, spread, who):
    """Pairs that the far bound does not rule out, positions."""
    first, second = who.T
    near = np.ones(len(who), bool)
    reach = motion.w / 2 + FAR * spread
    slack = FAR * UPRIGHT * spread
    for low, high in (
        (motion.x - reach, motion.x + reach),
        (motion.feet - motion.h - slack, motion.feet + slack),
    ):
        # Where each walker may be at any time of the horizon.
        low, high = low.min(axis=0), high.max(axis=0)
        near &= (low[first] < high[second]) & (low[second] < high[first])
    return np.flatnonzero(near)


def _may_touch(first, second, apart):
    """When the far bound does not keep two boxes from touching, shape (k, n)."""
    across = (first.w + second.w) / 2 - np.abs(first.x - second.x)
    down = np.minimum(first.feet, second.feet) - np.maximum(
        first.feet - first.h, second.feet - second.h
    )
    return (across > -FAR * apart) & (down > -FAR * UPRIGHT * apart)


def _meeting(first, second, apart, bound):
    """The probability that the cover exceeds `bound`, and how it comes about.

    Parameters
    ----------
    first, second : Motion, shape (k, n)
    apart : ndarray, shape (k, n)
        Standard deviation of the distance between the two, pixels.
    bound : float

    Returns
    -------
    probability : ndarray, shape (n,)
    by_then : ndarray, shape (k, n)
        The same up to each time, with the feet where they are expected.
    margin : ndarray, shape (k, n)
        By how many standard deviations the boxes reach into each other beyond the bound.
    """
    distance = first.x - second.x
    half = (first.w + second.w) / 2
    narrow = np.minimum(first.w, second.w)
    wanted = bound * np.minimum(first.w * first.h, second.w * second.h)
    probability = 0.0
    for node, weight in _NODES:
        feet = first.feet + node * UPRIGHT * apart
        down = np.minimum(feet, second.feet) - np.maximum(feet - first.h, second.feet - second.h)
        # So far must the boxes reach into each other across; more than the narrower is not.
        need = np.where(down > 0, wanted / np.where(down > 0, down, 1.0), np.inf)
        reach = np.where(need <= narrow, half - need, -np.inf)
        # Errors of the distance, in standard deviations, between which they occlude.
        high, low = (reach - distance) / apart, (-reach - distance) / apart
        if node == 0:
            margin = (reach - np.abs(distance)) / apart
            by_then = _between(
                np.minimum.accumulate(low, axis=0), np.maximum.accumulate(high, axis=0)
            )
            probability = probability + weight * by_then[-1]
        else:
            probability = probability + weight * _between(low.min(axis=0), high.max(axis=0))
    return probability, by_then, margin


def _between(low, high):
    """The share of a normal distribution between two bounds; 0 where they have changed sides."""
    # From the nearer tail, where small shares keep their digits; so the walkers' order, which
    # turns the interval round, changes nothing.
    low, high = np.where(low > -high, [-high, -low], [low, high])
    return np.where(high > low, ndtr(high) - ndtr(low), 0.0)


def _half_way(by_then, times):
    """The step and the second by which half of all that will occlude has occluded."""
    pair = np.arange(by_then.shape[1])
    half = by_then[-1] / 2
    # Without any chance the last second will do.
    at = np.where(half > 0, (by_then >= half).argmax(axis=0), len(times) - 1)
    here, before = by_then[at, pair], np.where(at > 0, by_then[at - 1, pair], 0.0)
    share = np.where(half > 0, (here - half) / np.where(here > before, here - before, 1.0), 0.0)
    return at, times[at] - share * times[0]


def describe(outlook: Outlook) -> np.ndarray:
    """What `Learned` learns from: no identity, no place in the image, no unit but seconds.

    Parameters
    ----------
    outlook : Outlook

    Returns
    -------
    ndarray, shape (n, len(FEATURES))
        One row a near pair.
    """
    pairs, ground, margin = outlook.pairs, outlook.ground, outlook.margin
    who = pairs.who[outlook.near]
    straight = move_straight(pairs.walkers, steps_of(pairs.rules))
    cover = _margin(*_of_pairs(straight, who)).max(axis=0)
    height = ground.fill / ground.near
    body = height[who].mean(axis=1)
    x, width = ground.side / ground.near, ground.aspect * height
    right, down = ground.rate
    seconds = outlook.forecast.seconds[outlook.near]
    odds = _log_odds(outlook.forecast.probability[outlook.near])
    pace = ground.pace[who]
    margin = np.clip(margin, -FAR, FAR)

    def apart(values):
        return np.abs(values[who[:, 0]] - values[who[:, 1]])

    columns = {
        "perspective": odds,
        "straight": np.maximum(cover, -1.0),
        "when": seconds,
        "late": odds * seconds,
        "margin": margin.max(axis=0),
        "soon": margin[: STEPS // 3].max(axis=0),
        "lasting": (margin > 0).mean(axis=0),
        "closing": np.minimum(np.hypot(apart(right), apart(down)), 1.5),
        "slower": np.minimum(pace.min(axis=1), 1.5),
        "faster": np.minimum(pace.max(axis=1), 1.5),
        "gap": np.clip((apart(x) - width[who].mean(axis=1)) / body, -0.5, 1.5),
        "feet_apart": np.minimum(apart(ground.feet) / body, 1.5),
        "scales_apart": np.minimum(apart(np.log(ground.near)), 1.0),
        "width": width[who].mean(axis=1) / body,
    }
    return np.stack([columns[name] for name in FEATURES], axis=1)


FEATURES = (
    "perspective",  # its log-odds
    "straight",  # largest cover on straight lines in the image, the gap in widths below 0
    "when",  # they would meet, seconds
    "late",  # the log-odds times that
    "margin",  # the largest within the horizon, standard deviations
    "soon",  # the largest within its first third
    "lasting",  # share of the horizon in which the bound is exceeded
    "closing",  # relative velocity in the image, body heights a second
    "slower",  # speed in the image of the slower one, body heights a second
    "faster",
    "gap",  # between the boxes, across, body heights
    "feet_apart",  # rows between the feet, body heights
    "scales_apart",  # log of the ratio of distances from the camera
    "width",  # of the boxes, body heights
)


class Learned:
    """The mean of `Perspective`'s probability and a logistic regression's on `FEATURES`.

    The regression learns where the closed form errs.  The squared error of the mean of two
    forecasts is never above the mean of theirs, and often below both (Bates and Granger,
    Operational Research Quarterly 20, 1969); and what was learned from a few recordings moves
    the forecast by half of the way at most.

    Attributes
    ----------
    coef_ : ndarray, shape (features,)
        Log-odds a standard deviation of a feature.
    intercept_ : float
    mean_, scale_ : ndarray, shape (features,)
        Of the features it was fitted on.
    """

    name = "learned"
    STRENGTH = 0.05  # inverse strength of regularisation, as scikit-learn's C

    def fit(
        self, features: ArrayLike, occludes: ArrayLike, *, weights: ArrayLike | None = None
    ) -> "Learned":
        """Fit the regression.

        Parameters
        ----------
        features : array_like, shape (n, len(FEATURES))
            As `describe` gives them.
        occludes : array_like of bool, shape (n,)
        weights : array_like, shape (n,), optional
            What each pair counts, above 0; 1 if not given.

        Returns
        -------
        Learned

        Raises
        ------
        ArgumentError
            When shapes differ, a value is not finite, a weight is not above 0, or all pairs
            occlude or none does.
        """
        from sklearn.linear_model import LogisticRegression
        from sklearn.pipeline import make_pipeline
        from sklearn.preprocessing import StandardScaler

        values = _require_features(features)
        occludes = require_flags("occludes", occludes)
        require_like(values[:, 0], of="a feature", occludes=occludes)
        if len(np.unique(occludes)) != 2:
            raise ArgumentError(
                f"occludes holds {len(occludes)} answers, {np.count_nonzero(occludes)} of "
                "them yes; pass True or False a pair, both among them."
            )
        if weights is not None:
            weights = require_array("weights", weights, above=0)
            require_like(occludes, of="occludes", weights=weights)
        self.model_ = make_pipeline(
            StandardScaler(), LogisticRegression(C=self.STRENGTH, max_iter=1000)
        )
        self.model_.fit(
            values,
            occludes,
            standardscaler__sample_weight=weights,
            logisticregression__sample_weight=weights,
        )
        scaler, regression = self.model_[0], self.model_[-1]
        self.mean_, self.scale_ = scaler.mean_, scaler.scale_
        self.coef_, self.intercept_ = regression.coef_[0], float(regression.intercept_[0])
        return self

    def predict_probability(self, features: ArrayLike, probability: ArrayLike) -> np.ndarray:
        """The probability of near pairs that they occlude.

        Parameters
        ----------
        features : array_like, shape (n, len(FEATURES))
        probability : array_like, shape (n,)
            `Perspective`'s.

        Returns
        -------
        ndarray, shape (n,)

        Raises
        ------
        ArgumentError
            When nothing was fitted, shapes differ, a value is not finite, or a probability is
            none.
        """
        if not hasattr(self, "model_"):
            raise ArgumentError("Learned has learned nothing yet; call fit first.")
        values = _require_features(features)
        probability = require_array("probability", probability, low=0, high=1)
        require_like(values[:, 0], of="a feature", probability=probability)
        if len(values) == 0:
            return probability
        return (self.model_.predict_proba(values)[:, 1] + probability) / 2

    def forecast(self, pairs: WatchedPairs) -> Forecast:
        """What it says of each pair; time and place are `Perspective`'s."""
        outlook = Perspective().look_ahead(pairs)
        probability = outlook.forecast.probability.copy()
        near = outlook.near
        probability[near] = self.predict_probability(describe(outlook), probability[near])
        return outlook.forecast._replace(probability=probability)


def _require_features(features):
    remedy = f"what describe makes, {len(FEATURES)} finite numbers a pair"
    return require_array("features", features, (None, len(FEATURES)), remedy=remedy)


def _log_odds(probability):
    """Log-odds, of a probability kept one in a thousand from certainty."""
    return logit((probability + 1e-3) / (1 + 2e-3))


def _of_pairs(motion, who):
    return motion.take(who[:, 0]), motion.take(who[:, 1])


def _margin(first, second):
    """The cover of boxes, or where they are apart the gap in widths of the narrower, below 0."""
    narrow = np.minimum(first.w, second.w)
    across = np.minimum((first.w + second.w) / 2 - np.abs(first.x - second.x), narrow)
    down = np.minimum(first.feet, second.feet) - np.maximum(
        first.feet - first.h, second.feet - second.h
    )
    both = np.maximum(across, 0) * np.maximum(down, 0)
    gap = np.hypot(np.minimum(across, 0), np.minimum(down, 0))
    smaller = np.minimum(first.w * first.h, second.w * second.h)
    return np.where(both > 0, both / smaller, -gap / narrow)


def _first_crossing(margin, times):
    """The step and the second at which a margin first rises above 0, else is largest."""
    pair = np.arange(margin.shape[1])
    above = margin > 0
    at = np.where(above.any(axis=0), above.argmax(axis=0), margin.argmax(axis=0))
    here, before = margin[at, pair], margin[at - 1, pair]
    # Between the step before, below the bound, and this one, above it.
    crossed = above[at, pair] & (at > 0)
    share = np.where(crossed, here / np.where(crossed, here - before, 1.0), 0.0)
    return at, times[at] - share * times[0]


def _place(first, second, at):
    """The centre of the two boxes' intersection, or of the gap between them, pixels."""
    pair = np.arange(len(at))
    x1, x2, y1, y2, w1, w2, h1, h2 = (
        getattr(one, name)[at, pair] for name in ("x", "feet", "w", "h") for one in (first, second)
    )
    left, right = np.maximum(x1 - w1 / 2, x2 - w2 / 2), np.minimum(x1 + w1 / 2, x2 + w2 / 2)
    top, bottom = np.maximum(y1 - h1, y2 - h2), np.minimum(y1, y2)
    return (left + right) / 2, (top + bottom) / 2
