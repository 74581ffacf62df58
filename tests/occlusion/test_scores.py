"""Scores against scikit-learn and by hand."""

from typing import NamedTuple

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sklearn.metrics import average_precision_score, f1_score, precision_recall_curve

from mcnlab.errors import ArgumentError, TableError
from mcnlab.occlusion.scores import (
    average_precision,
    best_threshold,
    calibration_error,
    count_answers,
    curve_of,
    difference,
    f1_of,
    reliability_of,
    score,
)
from mcnlab.statistics import wilson_interval

# Tenths: many probabilities are equal.
tenths = st.integers(0, 10).map(lambda value: value / 10)
some_pairs = st.lists(
    st.tuples(st.booleans(), tenths, st.integers(0, 3)), min_size=1, max_size=30
).filter(lambda pairs: any(occludes and weight for occludes, _, weight in pairs))


def unzip(pairs):
    return tuple(map(np.array, zip(*pairs, strict=True)))


@given(some_pairs)
def test_average_precision_is_that_of_scikit_learn(pairs):
    occludes, probability, weights = unzip(pairs)
    # 1e-12: sums of some thirty ratios, each rounded to 2⁻⁵³.
    assert average_precision(occludes, probability, weights=weights) == pytest.approx(
        average_precision_score(occludes, probability, sample_weight=weights), abs=1e-12
    )
    if occludes.any():
        assert average_precision(occludes, probability) == pytest.approx(
            average_precision_score(occludes, probability), abs=1e-12
        )


@given(some_pairs)
def test_the_curve_is_that_of_scikit_learn(pairs):
    occludes, probability, weights = unzip(pairs)
    curve = curve_of(occludes, probability, weights=weights)
    counts = weights > 0  # scikit-learn keeps thresholds that only weightless pairs reach
    precision, recall, threshold = precision_recall_curve(
        occludes[counts], probability[counts], sample_weight=weights[counts]
    )
    assert curve.threshold.tolist() == threshold[::-1].tolist()
    np.testing.assert_allclose(curve.precision, precision[-2::-1], atol=1e-12)
    np.testing.assert_allclose(curve.recall, recall[-2::-1], atol=1e-12)
    for each, f1 in zip(curve.threshold, curve.f1, strict=True):
        assert f1 == pytest.approx(f1_of(occludes, probability >= each, weights=weights), abs=1e-12)


@given(some_pairs, tenths)
def test_f1_is_that_of_scikit_learn(pairs, threshold):
    occludes, probability, weights = unzip(pairs)
    said = probability >= threshold
    assert f1_of(occludes, said, weights=weights) == pytest.approx(
        f1_score(occludes, said, sample_weight=weights, zero_division=0), abs=1e-12
    )


def test_answers_are_counted():
    found = count_answers([True, True, False, False], [0.9, 0.2, 0.5, 0.4], 0.5)
    assert found == (1, 1, 1, 0.5, 0.5, 0.5)
    assert count_answers([True, False], [0.2, 0.1], 0.5)[3:] == (None, 0, 0)


@given(some_pairs, tenths)
def test_counted_answers_have_the_f1_of_these_answers(pairs, threshold):
    occludes, probability, _ = unzip(pairs)
    found = count_answers(occludes, probability, threshold)
    # 1e-15: each is a ratio, rounded to 2⁻⁵³.
    assert found.f1 == pytest.approx(f1_of(occludes, probability >= threshold), abs=1e-15)


@pytest.mark.parametrize(
    ("occludes", "threshold", "match"),
    [([False, False], 0.5, "no pair that occludes"), ([True, False], 1.5, "threshold is 1.5")],
)
def test_answers_that_cannot_be_counted_are_refused(occludes, threshold, match):
    with pytest.raises(ArgumentError, match=match):
        count_answers(occludes, [0.1, 0.2], threshold)


@given(some_pairs)
def test_only_the_order_of_probabilities_matters_to_average_precision(pairs):
    occludes, probability, weights = unzip(pairs)
    stretched = 0.2 + 0.7 * probability**3  # eleven values stay eleven
    assert average_precision(occludes, probability, weights=weights) == average_precision(
        occludes, stretched, weights=weights
    )


@given(some_pairs)
def test_a_weight_counts_as_so_many_pairs(pairs):
    occludes, probability, weights = unzip(pairs)
    many = np.repeat(np.arange(len(weights)), weights)
    assert average_precision(occludes, probability, weights=weights) == pytest.approx(
        average_precision(occludes[many], probability[many]), abs=1e-12
    )


def test_perfect_constant_and_inverted_forecasters():
    occludes = np.arange(10) < 3
    assert average_precision(occludes, occludes) == 1
    assert average_precision(occludes, np.full(10, 0.4)) == pytest.approx(0.3)
    # The three come last: precision 1/8, 2/9, 3/10 where recall gains a third each.
    last = np.arange(10) / 10
    assert average_precision(occludes, last[::-1]) == 1
    assert average_precision(occludes[::-1], last[::-1]) == pytest.approx(
        (1 / 8 + 2 / 9 + 3 / 10) / 3
    )


@pytest.mark.parametrize(("rank", "wanted"), [(1, 1.0), (2, 0.5), (10, 0.1)])
def test_a_single_positive_scores_one_over_its_rank(rank, wanted):
    probability = np.linspace(1, 0, 10)
    assert average_precision(np.arange(10) == rank - 1, probability) == pytest.approx(wanted)


@given(some_pairs, st.lists(st.integers(0, 2), min_size=30, max_size=30))
def test_no_threshold_is_better_than_the_best(pairs, groups):
    occludes, probability, _ = unzip(pairs)
    groups = np.array(groups)[: len(occludes)]

    def mean_f1(threshold):
        return np.mean(
            [
                f1_of(occludes[groups == group], probability[groups == group] >= threshold)
                for group in set(groups[occludes])
            ]
        )

    best = best_threshold(occludes, probability, groups)
    tried = np.r_[probability, np.arange(0, 1, 0.05)]
    assert 0 <= best <= 1
    assert mean_f1(best) == pytest.approx(max(map(mean_f1, tried)), abs=1e-12)


def test_the_best_threshold_is_the_middle_of_the_widest_best_stretch():
    # Any threshold in (0.2, 0.8] tells the two apart.
    assert best_threshold([True, False], [0.8, 0.2]) == pytest.approx(0.5)
    # F1 is 2/3 in (0.5, 0.9], 2/5 in (0.4, 0.5] and 2/3 in (0.2, 0.4]: the first is wider.
    assert best_threshold(
        [True, False, True, False, False, False], [0.9, 0.5, 0.4, 0.5, 0.1, 0.2]
    ) == pytest.approx(0.7)
    # Neighbours that are equally good make one stretch: saying yes to all, (0, 0.3].
    assert best_threshold([True, True], [0.3, 0.7]) == pytest.approx(0.15)
    # Yes or no only, as the printed tables answer.
    assert best_threshold([True, False, True], [1, 0, 1]) == 0.5


@pytest.mark.parametrize("below", [0.0, 0.5])
def test_neighbouring_probabilities_are_told_apart(below):
    above = np.nextafter(below, 1)
    threshold = best_threshold([True, False], [above, below])
    assert below < threshold <= above


def test_every_sequence_counts_the_same():
    # One sequence of 95 pairs that all occlude, 45 of them foreseen with 0.2 only; and one of
    # two, of which the threshold 0.5 lets the wrong one in.
    occludes = np.r_[np.ones(95, bool), True, False]
    probability = np.r_[np.full(45, 0.2), np.full(50, 0.9), 0.9, 0.5]
    groups = np.r_[np.zeros(95), 1, 1]
    # Pooled, a yes to all is best: 192/193.
    assert best_threshold(occludes, probability) == pytest.approx(0.1)
    # By sequence it scores (1 + 2/3)/2 = 0.83, but yes from 0.9 on (100/145 + 1)/2 = 0.84.
    assert best_threshold(occludes, probability, groups) == pytest.approx(0.7)


def test_a_sequence_without_an_occlusion_has_no_say():
    occludes, probability = [True, False, False], [0.8, 0.2, 0.9]
    assert best_threshold(occludes, probability, ["a", "a", "b"]) == pytest.approx(0.5)


@given(
    st.lists(st.tuples(st.booleans(), tenths, st.integers(0, 2)), min_size=1, max_size=20).filter(
        lambda pairs: any(occludes for occludes, _, _ in pairs)
    )
)
def test_a_sequence_that_has_two_votes_is_there_twice(pairs):
    occludes, probability, groups = unzip(pairs)
    say = {0: 1, 1: 2, 2: 1.0}
    twice = groups == 1
    again = (
        np.r_[occludes, occludes[twice]],
        np.r_[probability, probability[twice]],
        np.r_[groups, np.full(twice.sum(), 3)],
    )
    assert best_threshold(occludes, probability, groups, say=say) == best_threshold(*again)
    # All alike is what is meant where nothing is said.
    alike = dict.fromkeys("012", 7.5)
    assert best_threshold(occludes, probability, groups, say=alike) == best_threshold(
        occludes, probability, groups
    )


def test_who_has_the_say_decides():
    # "a" wants a yes to 0.4 and "b" does not.
    occludes, probability, groups = [True, True, True, False], [0.9, 0.4, 0.9, 0.4], list("aabb")
    # Yes from 0.4 on: 1 and 2/3; from 0.9 on: 2/3 and 1.
    assert best_threshold(occludes, probability, groups, say={"a": 2, "b": 1}) == 0.2
    assert best_threshold(occludes, probability, groups, say={"a": 1, "b": 2}) == 0.65
    # Without an occlusion nobody is asked, so a yes to all, (0, 0.9], is as good.
    assert best_threshold([True, False], [0.9, 0.1], ["a", "c"], say={"a": 1}) == 0.45


@pytest.mark.parametrize(
    ("groups", "say", "match"),
    [
        (["a", "b"], {"a": 1}, "say lacks the group 'b'"),
        (["a", "b"], {}, "say lacks the group 'a'"),
        (["a", "b"], {"a": 1, "b": 0}, r"say\['b'\]"),
        (["a", "b"], {"a": 1, "b": -1}, r"say\['b'\]"),
        (["a", "b"], {"a": np.nan, "b": 1}, r"say\['a'\]"),
        (["a", "b"], {"a": "much", "b": 1}, r"say\['a'\]"),
        (["a", "b"], [1, 2], "say is list, groups given"),
        (None, {"a": 1}, "say is dict, groups not given"),
    ],
)
def test_a_say_that_does_not_fit_the_groups_is_refused(groups, say, match):
    with pytest.raises(ArgumentError, match=match):
        best_threshold([True, True], [0.1, 0.9], groups, say=say)


def test_calibration_error_by_hand():
    # (0.1, 0.2]: two pairs, one occludes: |0.5 − 0.15|; (0.8, 0.9]: one, which does: |1 − 0.9|.
    error = calibration_error([True, False, True], [0.2, 0.1 + 1e-9, 0.9])
    assert error == pytest.approx((2 * 0.35 + 0.1) / 3, abs=1e-9)
    # 0.1 and 0.2 are upper edges, so they lie in different bins; with one bin they cancel.
    assert calibration_error([True, False], [0.2, 0.1]) == pytest.approx((0.8 + 0.1) / 2)
    assert calibration_error([True, False], [0.2, 0.8], bins=1) == pytest.approx(0)
    assert calibration_error([False, False], [0, 0]) == 0
    assert calibration_error([False, True], [1, 0]) == 1


@given(some_pairs, st.integers(1, 12))
def test_the_reliability_table_adds_up_to_the_calibration_error(pairs, bins):
    occludes, probability, _ = unzip(pairs)
    table = reliability_of(occludes, probability, bins=bins)
    error = (table["n"] * (table["share"] - table["probability"]).abs()).sum() / len(occludes)
    assert calibration_error(occludes, probability, bins=bins) == pytest.approx(error, abs=1e-12)
    assert table["n"].sum() == len(occludes)
    assert (table["n"] > 0).all()
    # 1e-12: a mean of equal numbers is rounded.
    assert (table["low"] - 1e-12 <= table["probability"]).all()
    assert (table["probability"] <= table["high"] + 1e-12).all()
    for row in table.itertuples():
        assert (row.share_low, row.share_high) == wilson_interval(row.share, row.n)


@pytest.mark.parametrize("function", [curve_of, average_precision, best_threshold])
@pytest.mark.parametrize(
    ("occludes", "probability", "match"),
    [
        ([False, False], [0.1, 0.2], "occludes names no pair that occludes"),
        ([True, False], [0.1, 1.1], "probability is 1.1 in row 1"),
        ([True, False], [-0.1, 1], "probability is -0.1 in row 0"),
        ([True, False], [0.1, np.nan], "probability is nan in row 1"),
        ([True, False], [0.1, "x"], "probability holds what is no number"),
        ([True, False], [0.1], r"probability has the shape \(1,\), occludes \(2,\)"),
        ([True, False], [[0.1, 0.2]], r"probability has the shape \(1, 2\)"),
        ([True, 2], [0.1, 0.2], "occludes must hold True or False"),
        ([True, None], [0.1, 0.2], "occludes must be a flat list"),
        ([[True], [True, False]], [0.1, 0.2], "occludes must be a flat list"),
        (["yes", "no"], [0.1, 0.2], "occludes must hold True or False"),
        ([], [], "at least one row"),
    ],
)
def test_pairs_that_cannot_be_scored_are_refused(function, occludes, probability, match):
    with pytest.raises(ArgumentError, match=match):
        function(occludes, probability)


@pytest.mark.parametrize("function", [calibration_error, reliability_of])
@pytest.mark.parametrize(
    ("probability", "bins", "match"),
    [
        ([0.1, 1.1], 10, "probability is 1.1"),
        ([0.1], 10, "probability has the shape"),
        ([0.1, 0.2], 0, "bins is 0"),
        ([0.1, 0.2], 2.5, "bins is 2.5"),
    ],
)
def test_a_calibration_that_cannot_be_measured_is_refused(function, probability, bins, match):
    with pytest.raises(ArgumentError, match=match):
        function([False, False], probability, bins=bins)


@pytest.mark.parametrize(
    ("weights", "match"),
    [
        ([1], "weights has the shape"),
        ([1, -1], "weights is -1 in row 1"),
        ([1, np.nan], "weights is nan in row 1"),
        ([1, 1e300], "weights is 1e.300 in row 1"),
        ([0, 1], "occludes names no pair"),
    ],
)
def test_impossible_weights_are_refused(weights, match):
    for function in (average_precision, f1_of):
        with pytest.raises(ArgumentError, match=match):
            function([True, False], [1, 0], weights=weights)


def test_answers_other_than_yes_and_no_have_no_f1():
    with pytest.raises(ArgumentError, match="said must hold True or False"):
        f1_of([True, False], [0.5, 0.2])
    with pytest.raises(ArgumentError, match="occludes names no pair"):
        f1_of([False, False], [True, False])


@pytest.mark.parametrize("groups", [["a"], ["a", None], [["a"], ["b"]]])
def test_groups_that_do_not_fit_the_pairs_are_refused(groups):
    with pytest.raises(ArgumentError, match="groups"):
        best_threshold([True, False], [0.1, 0.2], groups)


# Intervals by walker


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
