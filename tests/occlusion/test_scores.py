"""Scores against scikit-learn and by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sklearn.metrics import average_precision_score, f1_score, precision_recall_curve

from mcnlab.errors import ArgumentError
from mcnlab.occlusion.scores import (
    average_precision,
    best_threshold,
    calibration_error,
    count_answers,
    curve_of,
    f1_of,
    reliability_of,
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
