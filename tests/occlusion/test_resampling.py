"""Scores by hand; intervals against simulated crowds."""

from typing import NamedTuple

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcnlab.errors import ArgumentError, TableError
from mcnlab.occlusion.scores import average_precision, calibration_error, difference, f1_of, score


def make_sequence(walkers=8, moments=2, seed=0):
    """Truth and forecast: every two of some walkers at some moments."""
    rng = np.random.default_rng(seed)
    first, second = np.repeat(np.triu_indices(walkers, 1), moments, axis=1)
    n = len(first)
    probability = rng.uniform(0, 1, n)
    occludes = rng.uniform(0, 1, n) < probability
    seconds, x, y = rng.uniform(0, 3, n), rng.uniform(0, 700, n), rng.uniform(0, 500, n)
    truth = pd.DataFrame(
        {
            "occludes": occludes,
            "seconds": np.where(occludes, seconds, np.nan),
            "x": np.where(occludes, x, np.nan),
            "y": np.where(occludes, y, np.nan),
            "first": first,
            "second": second,
            "height": rng.uniform(50, 200, n),
        }
    )
    forecast = pd.DataFrame(
        {
            "probability": probability,
            "seconds": seconds + rng.normal(0, 0.3, n),
            "x": x + rng.normal(0, 20, n),
            "y": y + rng.normal(0, 20, n),
        }
    )
    return truth, forecast


@pytest.fixture(scope="module")
def sequence():
    return make_sequence()


def test_scores_by_hand():
    truth = pd.DataFrame(
        {
            "occludes": [True, True, True, False, False],
            "seconds": [1.0, 2.0, 2.0, np.nan, np.nan],
            "x": [10.0, 20, 30, 40, 50],
            "y": 0.0,
            "first": list("aaabb"),
            "second": list("bcdcd"),
            "height": [100.0, 50, 100, np.nan, 100],
        }
    )
    forecast = pd.DataFrame(
        {
            "probability": [0.9, 0.8, 0.3, 0.7, 0.1],
            "seconds": [1.2, 1.6, 9.0, np.inf, 0.0],
            "x": [40.0, 20, 0, 0, 0],
            "y": [40.0, 5, 0, 0, 0],
        }
    )
    found = score(truth, forecast, threshold=0.5)
    assert found.precision.value == pytest.approx(2 / 3)
    assert found.recall.value == pytest.approx(2 / 3)
    assert found.f1.value == pytest.approx(2 / 3)
    assert found.ap.value == pytest.approx((1 + 1 + 3 / 4) / 3)
    assert found.calibration_error.value == pytest.approx((0.1 + 0.2 + 0.7 + 0.7 + 0.1) / 5)
    assert found.time_error_s.value == pytest.approx((0.2 + 0.4) / 2)
    assert found.place_error.value == pytest.approx((50 / 100 + 5 / 50) / 2)
    assert {estimate.n for estimate in found} == {4}


def test_scores_are_those_of_the_single_functions(sequence):
    truth, forecast = sequence
    found = score(truth, forecast, threshold=0.4)
    pairs = truth["occludes"], forecast["probability"]
    assert found.ap.value == pytest.approx(average_precision(*pairs))
    assert found.calibration_error.value == pytest.approx(calibration_error(*pairs))
    assert found.f1.value == pytest.approx(f1_of(pairs[0], pairs[1] >= 0.4))
    right = pairs[0] & (pairs[1] >= 0.4)
    late = (forecast["seconds"] - truth["seconds"])[right].abs()
    assert found.time_error_s.value == pytest.approx(late.median())
    off = np.hypot(forecast["x"] - truth["x"], forecast["y"] - truth["y"]) / truth["height"]
    assert found.place_error.value == pytest.approx(off[right].median())


def test_a_draw_is_the_score_of_the_pairs_repeated(sequence):
    truth, forecast = sequence
    # The same three draws, one at a time: copy each pair as often as its walkers say.
    times = np.random.default_rng(5).multinomial(8, np.full(8, 1 / 8), 3)
    drawn = []
    for each in times:
        many = np.repeat(np.arange(len(truth)), each[truth["first"]] * each[truth["second"]])
        found = score(truth.iloc[many], forecast.iloc[many], threshold=0.4, draws=1)
        drawn.append([estimate.value for estimate in found])
    found = score(truth, forecast, threshold=0.4, draws=3, seed=5)
    # Of three draws, 2.5 % and 97.5 % are the lowest and the highest.
    for name, values in zip(found._fields, np.transpose(drawn), strict=True):
        estimate = getattr(found, name)
        low, high = values.min(), values.max()
        if name == "calibration_error":
            reach = max(high - estimate.value, estimate.value - low)
            low, high = max(estimate.value - reach, 0), min(estimate.value + reach, 1)
        assert (estimate.low, estimate.high) == pytest.approx((low, high), abs=1e-12), name


@given(st.lists(st.booleans(), min_size=56, max_size=56))
def test_exchanging_the_two_walkers_changes_nothing(swap):
    truth, forecast = make_sequence()
    first, second = truth["first"], truth["second"]
    swap = np.array(swap)
    other = truth.assign(first=first.mask(swap, second), second=second.mask(swap, first))
    assert score(truth, forecast, threshold=0.4, draws=20) == score(
        other, forecast, threshold=0.4, draws=20
    )


def test_the_order_of_the_pairs_changes_nothing_but_rounding(sequence):
    truth, forecast = sequence
    found = score(truth, forecast, threshold=0.4)
    turned = score(truth[::-1], forecast[::-1], threshold=0.4)
    for one, other in zip(found, turned, strict=True):
        assert one == pytest.approx(other, abs=1e-12)


def test_scaling_the_seconds_scales_the_time_error_alone(sequence):
    truth, forecast = sequence
    found = score(truth, forecast, threshold=0.4)
    scaled = score(
        truth.assign(seconds=4 * truth["seconds"]),
        forecast.assign(seconds=4 * forecast["seconds"]),
        threshold=0.4,
    )
    value, low, high, n = found.time_error_s  # times 4 is exact
    assert scaled == found._replace(time_error_s=(4 * value, 4 * low, 4 * high, n))


def test_scaling_the_image_changes_nothing(sequence):
    truth, forecast = sequence
    pixels = ["x", "y", "height"]
    assert score(
        truth.assign(**(4 * truth[pixels])),
        forecast.assign(**(4 * forecast[pixels[:2]])),
        threshold=0.4,
    ) == score(truth, forecast, threshold=0.4)


def test_the_same_seed_draws_the_same_walkers(sequence):
    found = [score(*sequence, threshold=0.4, seed=seed) for seed in (1, 1, 2)]
    assert found[0] == found[1]
    assert found[0].ap.low != found[2].ap.low
    assert [one.value for one in found[0]] == [one.value for one in found[2]]


def test_what_is_drawn_at_a_time_changes_nothing(sequence, monkeypatch):
    found = score(*sequence, threshold=0.4)
    monkeypatch.setattr("mcnlab.occlusion.scores._CELLS", 500)
    assert score(*sequence, threshold=0.4) == found


def test_tuples_are_as_good_as_tables(sequence):
    class Truth(NamedTuple):
        occludes: list
        seconds: list
        x: list
        y: list
        first: list
        second: list
        height: list

    class Forecast(NamedTuple):
        probability: list
        seconds: list
        x: list
        y: list

    truth, forecast = sequence
    assert score(
        Truth(*(truth[name].tolist() for name in Truth._fields)),
        Forecast(*(forecast[name].tolist() for name in Forecast._fields)),
        threshold=0.4,
    ) == score(truth, forecast, threshold=0.4)


def test_nobody_told_to_occlude_has_no_precision_and_no_errors(sequence):
    truth, forecast = sequence
    found = score(truth, forecast.assign(probability=0.0), threshold=0.4)
    for name in ("precision", "time_error_s", "place_error"):
        assert getattr(found, name) == (None, None, None, 8)
    assert found.recall == found.f1 == (0, None, None, 8)
    assert found.ap.value == pytest.approx(truth["occludes"].mean())


def test_draws_that_are_all_alike_show_no_spread(sequence):
    truth, forecast = sequence
    found = score(truth, forecast.assign(probability=truth["occludes"]), threshold=0.5)
    for name in ("precision", "recall", "f1", "ap"):
        assert getattr(found, name) == (1, None, None, 8)
    assert found.calibration_error == (0, None, None, 8)


def test_two_walkers_give_no_interval():
    truth, forecast = make_sequence(walkers=2, moments=30)
    for estimate in score(truth, forecast, threshold=0.4):
        assert estimate.value is not None
        assert estimate[1:] == (None, None, 2)


def test_a_single_positive_is_missing_from_most_draws():
    truth, forecast = make_sequence(walkers=30, moments=1)
    truth = truth.assign(occludes=truth.index == 7, seconds=1.0, x=0.0, y=0.0)
    found = score(truth, forecast, threshold=0.0)
    # Both walkers are drawn in about (1 − 1/e)² = 0.4 of the draws: fewer than half.
    for estimate in found:
        assert estimate.value is not None
        assert estimate[1:] == (None, None, 30)


def test_a_time_of_never_is_the_worst_time(sequence):
    truth, forecast = sequence
    never = forecast.assign(seconds=forecast["seconds"].where(forecast.index % 9 > 0, np.inf))
    found = score(truth, never, threshold=0.4)
    assert score(truth, forecast, threshold=0.4).time_error_s.value < found.time_error_s.value
    assert np.isfinite(found.time_error_s.value)
    found = score(truth, forecast.assign(seconds=np.inf), threshold=0.4)
    assert found.time_error_s == (None, None, None, 8)
    assert found.place_error.value is not None
    # Of the true positives a little fewer than half: the median is a time, its upper end is not.
    right = np.flatnonzero(truth["occludes"] & (forecast["probability"] >= 0.4))
    lost = forecast.index.isin(right[: (len(right) - 1) // 2])
    found = score(
        truth, forecast.assign(seconds=forecast["seconds"].mask(lost, np.inf)), threshold=0.4
    )
    assert found.time_error_s.value is not None
    assert found.time_error_s[1:] == (None, None, 8)


def test_the_difference_is_of_the_two_scores(sequence):
    truth, forecast = sequence
    other = forecast.assign(probability=forecast["probability"] ** 2 % 0.5)
    found = difference(truth, forecast, other, thresholds=(0.4, 0.2))
    one = score(truth, forecast, threshold=0.4)
    two = score(truth, other, threshold=0.2)
    for name in ("f1", "ap"):
        gained = getattr(one, name).value - getattr(two, name).value
        assert getattr(found, name).value == pytest.approx(gained)
    back = difference(truth, other, forecast, thresholds=(0.2, 0.4))
    assert back.f1.value == -found.f1.value
    assert back.ap.value == -found.ap.value
    assert difference(truth, forecast, forecast, thresholds=(0.4, 0.4)).ap == (0, None, None, 8)


def test_a_paired_difference_is_surer_than_two_scores():
    truth, forecast = make_sequence(walkers=20)
    nearly = forecast.assign(probability=forecast["probability"] * 0.98 + 0.01 * truth["occludes"])
    found = difference(truth, nearly, forecast, thresholds=(0.4, 0.4)).ap
    alone = score(truth, forecast, threshold=0.4).ap
    assert 0 < found.low < found.value < found.high
    assert found.high - found.low < (alone.high - alone.low) / 2


def make_crowd(rng, walkers, share, *, apart=False):
    """A sequence in which `share` of what makes a pair occlude is the walkers' doing.

    With `apart`, every pair has two walkers of its own: the same pairs, but independent.
    """
    first, second = np.triu_indices(walkers, 1)
    n = len(first)
    if apart:
        first, second, walkers = np.arange(n), np.arange(n) + n, 2 * n

    def draw():
        own = rng.normal(size=walkers)
        return np.sqrt(share / 2) * (own[first] + own[second]) + np.sqrt(1 - share) * rng.normal(
            size=n
        )

    wanted, blur = draw(), draw()
    truth = pd.DataFrame(
        {
            "occludes": wanted > 1,
            "seconds": 1.0,
            "x": 0.0,
            "y": 0.0,
            "first": first,
            "second": second,
            "height": 1.0,
        }
    )
    probability = 1 / (1 + np.exp(-1.5 * (wanted + blur - 1)))
    return truth, pd.DataFrame({"probability": probability, "seconds": 1.0, "x": 0.0, "y": 0.0})


def test_intervals_hold_the_truth_where_pairs_share_walkers():
    rng = np.random.default_rng(3)
    runs, names = 150, ["f1", "ap", "calibration_error"]
    # A score of endlessly many pairs asks for no walkers: 200 000 independent ones, whose F1
    # and average precision lie within some 0.003 of it, against intervals of 0.1 and more.
    occludes, probability = (
        np.concatenate(values)
        for values in zip(
            *(
                (truth["occludes"], forecast["probability"])
                for truth, forecast in (make_crowd(rng, 448, 0.3, apart=True) for _ in range(2))
            ),
            strict=True,
        )
    )
    wanted = [
        f1_of(occludes, probability >= 0.4),
        average_precision(occludes, probability),
        calibration_error(occludes, probability),
    ]
    held = np.zeros(len(names))
    for run in range(runs):
        found = score(*make_crowd(rng, 30, 0.3), threshold=0.4, draws=150, seed=run)
        held += [
            getattr(found, name).low <= value <= getattr(found, name).high
            for name, value in zip(names, wanted, strict=True)
        ]
    # 95 % of 150 runs, less three standard deviations of a binomial count: 0.897.
    assert (held / runs >= 0.95 - 3 * np.sqrt(0.95 * 0.05 / runs)).all(), held / runs


def test_intervals_are_root_three_too_wide_where_walkers_do_not_matter():
    rng = np.random.default_rng(4)
    runs = 150
    found = [
        score(*make_crowd(rng, 40, 0.0), threshold=0.4, draws=150, seed=run).f1
        for run in range(runs)
    ]
    spread = np.std([estimate.value for estimate in found])
    half = np.mean([estimate.high - estimate.low for estimate in found]) / 2 / 1.96
    # A spread seen in 150 runs is known to 1/√300 = 6 %: three times that either way.
    assert half / spread == pytest.approx(np.sqrt(3), rel=0.18)


def test_pairs_taken_for_independent_would_be_too_sure():
    rng = np.random.default_rng(6)
    values, widths = [], []
    for run in range(60):
        truth, forecast = make_crowd(rng, 40, 0.8)
        each = np.arange(len(truth))
        alone = truth.assign(first=each, second=each + len(each))
        by_walker, by_pair = (
            score(who, forecast, threshold=0.4, draws=100, seed=run).f1 for who in (truth, alone)
        )
        assert by_walker.value == by_pair.value
        values.append(by_walker.value)
        widths.append([by_walker.high - by_walker.low, by_pair.high - by_pair.low])
    half_walker, half_pair = np.mean(widths, axis=0) / 2 / 1.96
    # A spread seen in 60 runs is known to 1/√120 = 9 %: three times that, and still too sure.
    assert half_pair < (1 - 0.27) * np.std(values)
    assert half_walker > 1.3 * half_pair


def spoil(sequence, table, **columns):
    truth, forecast = (each.copy() for each in sequence)
    spoilt = (truth if table == "truth" else forecast).assign(**columns)
    return (spoilt, forecast) if table == "truth" else (truth, spoilt)


@pytest.mark.parametrize(
    ("table", "columns", "match"),
    [
        ("truth", {"occludes": False}, "truth.occludes names no pair that occludes"),
        ("truth", {"occludes": 0.5}, "truth.occludes must hold"),
        ("truth", {"seconds": np.nan}, "truth.seconds is nan in row"),
        ("truth", {"x": np.inf}, "truth.x is inf in row"),
        ("truth", {"y": "low"}, "truth.y holds what is no number"),
        ("truth", {"height": 0.0}, "truth.height is 0 in row"),
        ("truth", {"height": -5.0}, "positive number"),
        ("truth", {"first": 1}, "both '1' at pair"),
        ("truth", {"second": None}, "truth.second must be a flat list"),
        ("forecast", {"probability": 1.5}, "forecast.probability is 1.5 in row 0"),
        ("forecast", {"probability": np.nan}, "forecast.probability is nan"),
        ("forecast", {"seconds": np.nan}, "forecast.seconds is nan in row 0"),
        ("forecast", {"seconds": -np.inf}, "forecast.seconds is -inf"),
        ("forecast", {"x": np.inf}, "forecast.x is inf"),
        ("forecast", {"y": np.nan}, "forecast.y is nan"),
    ],
)
def test_impossible_columns_are_refused_by_name(sequence, table, columns, match):
    with pytest.raises(ArgumentError, match=match):
        score(*spoil(sequence, table, **columns), threshold=0.5)


def test_columns_that_are_missing_are_named(sequence):
    truth, forecast = sequence
    with pytest.raises(TableError, match=r"truth lacks the column.* height"):
        score(truth.drop(columns="height"), forecast, threshold=0.5)
    with pytest.raises(TableError, match=r"forecast lacks the column.* seconds"):
        score(truth, forecast.drop(columns="seconds"), threshold=0.5)
    with pytest.raises(ArgumentError, match="forecast lacks probability, seconds, x, y"):
        score(truth, None, threshold=0.5)


def test_truth_and_forecast_must_be_as_long(sequence):
    truth, forecast = sequence
    with pytest.raises(ArgumentError, match=r"forecast.probability has the shape \(55,\)"):
        score(truth, forecast[1:], threshold=0.5)


@pytest.mark.parametrize(
    ("name", "value"), [("threshold", 1.1), ("threshold", None), ("draws", 0), ("seed", -1)]
)
def test_impossible_settings_are_refused(sequence, name, value):
    with pytest.raises(ArgumentError, match=name):
        score(*sequence, **{"threshold": 0.5, name: value})


@pytest.mark.parametrize("thresholds", [0.5, (0.5,), (0.5, 2), ("a", 0.5)])
def test_a_difference_needs_two_thresholds(sequence, thresholds):
    truth, forecast = sequence
    with pytest.raises(ArgumentError, match="threshold"):
        difference(truth, forecast, forecast, thresholds=thresholds)


def test_the_other_forecast_is_named(sequence):
    truth, forecast = sequence
    with pytest.raises(ArgumentError, match=r"other\.probability is 7"):
        difference(truth, forecast, forecast.assign(probability=7.0), thresholds=(0.5, 0.5))
