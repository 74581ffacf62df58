"""Intervals against scipy and against draws by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from mcnlab.errors import ArgumentError
from mcnlab.statistics import (
    Estimate,
    accuracy,
    mean_by_subject,
    median_by_subject,
    share_by_subject,
    share_of,
    wilson_interval,
)


@given(st.integers(1, 2000).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_wilson_interval_is_scipys(counts):
    right, n = counts
    low, high = wilson_interval(right / n, n)
    expected = stats.binomtest(right, n).proportion_ci(0.95, method="wilson")
    assert (low, high) == (
        pytest.approx(expected.low, abs=1e-12),
        pytest.approx(expected.high, abs=1e-12),
    )
    assert 0 <= low <= high <= 1


@pytest.mark.parametrize(
    ("share", "n", "word"),
    [
        (-0.1, 5, "share"),
        (1.1, 5, "share"),
        (np.nan, 5, "share"),
        (True, 5, "share"),
        (0.5, 0, "n"),
        (0.5, 2.5, "n"),
        (0.5, True, "n"),
        (0.5, -3, "n"),
    ],
)
def test_senseless_shares_are_refused(share, n, word):
    with pytest.raises(ArgumentError, match=f"^{word} is"):
        wilson_interval(share, n)


@given(st.lists(st.booleans(), min_size=1, max_size=60))
def test_mirrored_copies_do_not_narrow_the_interval(right):
    alone = accuracy(right)
    assert alone == (np.mean(right), *wilson_interval(np.mean(right), len(right)), len(right))
    own = [True] * len(right) + [False] * len(right)
    doubled = accuracy(right * 2, own=own)
    assert doubled == pytest.approx(alone)
    assert doubled.n == len(right)


@pytest.mark.parametrize(
    ("right", "own"),
    [([], None), ([[True]], None), ([True], [False]), ([True, False], [True] * 50)],
    ids=["none", "2d", "no-own", "lengths"],
)
def test_answers_that_cannot_be_counted_are_refused(right, own):
    with pytest.raises(ArgumentError):
        accuracy(right, own=own)


def test_the_interval_of_a_mean_draws_whole_subjects():
    rng = np.random.default_rng(0)
    subjects = np.repeat(np.arange(40), 50)
    level = rng.normal(size=40)
    values = level[subjects] + 0.01 * rng.normal(size=2000)
    estimate = mean_by_subject(values, subjects)
    assert estimate.n == 40
    assert estimate.value == pytest.approx(values.mean())
    # With equal counts the mean's standard error is the subjects' spread over √40; 4000
    # draws know a 2.5 % quantile to 0.043 standard errors (√(0.025·0.975/4000)/φ(1.96)): five
    # times that, and the normal's error at 40 subjects, stay under 0.4.
    error = level.std() / np.sqrt(40)
    assert estimate.low == pytest.approx(values.mean() - 1.96 * error, abs=0.4 * error)
    assert estimate.high == pytest.approx(values.mean() + 1.96 * error, abs=0.4 * error)
    assert mean_by_subject(values, subjects) == estimate


def test_one_subject_has_no_interval():
    assert mean_by_subject([1.0, 2.0], ["abc", "abc"]) == (1.5, None, None, 1)


def test_the_interval_of_a_median_is_that_of_drawing_whole_subjects():
    rng = np.random.default_rng(1)
    # Nine subjects of five values: every draw is odd and has one value in its middle.
    subjects = np.repeat(list("abcdefghi"), 5)
    values = rng.gamma(2.0, size=45)
    own = [values[subjects == name] for name in "abcdefghi"]
    draw = np.random.default_rng(0)
    medians = [
        np.median(np.concatenate([own[at] for at in draw.integers(9, size=9)])) for _ in range(1000)
    ]
    low, high = np.percentile(medians, [2.5, 97.5])
    assert median_by_subject(values, subjects) == pytest.approx((np.median(values), low, high, 9))


@given(
    st.lists(
        st.tuples(st.floats(-1e6, 1e6), st.sampled_from("abcde")), min_size=1, max_size=40
    ).flatmap(lambda pairs: st.tuples(st.just(pairs), st.permutations(pairs)))
)
def test_the_order_of_values_does_not_move_their_median(orders):
    estimates = [median_by_subject(*zip(*pairs, strict=True), draws=50) for pairs in orders]
    assert estimates[0] == estimates[1]
    values, subjects = zip(*orders[0], strict=True)
    assert estimates[0].value == np.median(values)
    assert estimates[0].n == len(set(subjects))
    if estimates[0].n > 1:
        assert min(values) <= estimates[0].low <= estimates[0].high <= max(values)


def test_a_median_turned_round_has_its_interval_turned_round():
    rng = np.random.default_rng(2)
    values, subjects = rng.normal(size=35), np.repeat(np.arange(7), 5)  # odd, as above
    estimate, turned = median_by_subject(values, subjects), median_by_subject(-values, subjects)
    assert turned == pytest.approx((-estimate.value, -estimate.high, -estimate.low, 7))


def test_the_interval_holds_the_true_median_about_95_times_in_100():
    rng = np.random.default_rng(3)
    held = 0
    for seed in range(300):
        level = rng.normal(size=30)
        values = np.repeat(level, 7) + 0.5 * rng.normal(size=210)
        estimate = median_by_subject(values, np.repeat(np.arange(30), 7), seed=seed, draws=200)
        held += estimate.low <= 0 <= estimate.high
    # Percentile intervals of 30 subjects are a little narrow: 93 in 100, which 300 trials know
    # to 1.5 points; four of those to either side.  Drawing values, not subjects, holds it 62.
    assert 0.87 <= held / 300 <= 0.99


@pytest.mark.parametrize("estimate", [mean_by_subject, median_by_subject])
def test_subjects_that_hold_one_value_have_no_spread(estimate):
    assert estimate([2.5] * 6, list("aabbcc")) == (2.5, 2.5, 2.5, 3)


def test_one_subject_has_no_interval_of_a_median():
    assert median_by_subject([4.0, 1.0, 2.0], ["abc"] * 3) == (2.0, None, None, 1)


@pytest.mark.parametrize("estimate", [mean_by_subject, median_by_subject])
@pytest.mark.parametrize(
    ("values", "subjects"),
    [([], []), ([1.0, np.nan], ["a", "b"]), ([1.0, 2.0, 3.0], ["a", "b"]), ([[1.0]], [["a"]])],
    ids=["none", "nan", "lengths", "2d"],
)
def test_values_that_have_no_mean_are_refused(estimate, values, subjects):
    with pytest.raises(ArgumentError):
        estimate(values, subjects)


def test_a_share_of_alike_answers_is_worth_its_subjects():
    right = np.ones(56, bool)
    estimate = share_by_subject(right, np.repeat(np.arange(14), 4))
    assert estimate == share_of(1.0, 14)


def test_a_share_of_subjects_with_one_answer_each_is_wilson_s():
    right = np.arange(40) % 4 > 0
    estimate = share_by_subject(right, np.arange(40))
    # (n − 1)/n for the spread about the mean: 39 of 40, not below the number of subjects.
    assert estimate == share_of(0.75, 40)


def test_answers_that_are_the_subject_s_are_worth_one_each():
    right = np.repeat(np.arange(10) % 2 == 0, 6)
    assert share_by_subject(right, np.repeat(np.arange(10), 6)) == Estimate(
        0.5, *wilson_interval(0.5, 10), 10
    )


def test_a_share_needs_answers():
    with pytest.raises(ArgumentError, match="True or False"):
        share_by_subject([0.5, 1.0], ["a", "b"])
