"""Lines against numpy.polyfit, hand calculation and the textbook formulas."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mcnlab.errors import ArgumentError
from mcnlab.regression import HUBER, Line, fit_correlated, fit_line, fit_lines, fit_lines_robust

# Whole numbers up to 1000 keep every fit here well conditioned: rounding stays far under 1e-9
# of the largest value.
values = st.integers(-1000, 1000).map(float)
curves = st.integers(2, 30).flatmap(lambda n: arrays(float, n, elements=values))


@given(curves, st.data())
def test_ordinary_fit_agrees_with_polyfit(y, data):
    x = np.array(
        data.draw(st.lists(values, min_size=len(y), max_size=len(y), unique=True)), dtype=float
    )
    weights = data.draw(arrays(float, len(y), elements=st.integers(1, 9).map(float)))
    line = fit_lines(x, y, weights=weights)
    # polyfit weighs residuals, not their squares.
    slope, intercept = np.polyfit(x, y, 1, w=np.sqrt(weights))
    assert line.slope == pytest.approx(slope, rel=1e-8, abs=1e-6)
    assert line.intercept == pytest.approx(intercept, rel=1e-8, abs=1e-6)


@given(curves)
def test_one_line_is_fitted_as_many_are(y):
    x = np.arange(len(y), dtype=float)
    assert fit_line(x, y) == pytest.approx(tuple(fit_lines(x, y)), abs=1e-9)


def test_one_line_needs_two_places():
    with pytest.raises(ArgumentError, match="two different"):
        fit_line(np.array([3.0, 3.0]), np.array([0.0, 1.0]))


def test_ordinary_least_squares_is_meant_not_the_printed_slope():
    x = np.arange(1.0, 6.0)
    y = 2 * x + 1
    n = len(x)
    printed = (n * y.sum() - x.sum() * y.sum()) / (n * ((x**2).sum() - x.sum() ** 2))
    assert fit_lines(x, y) == pytest.approx((2, 1))
    assert fit_line(x, y) == pytest.approx((2, 1))
    assert printed == pytest.approx(0.41, abs=0.01)  # (175 − 525) / (5·(55 − 225)): not 2


def test_points_of_weight_zero_are_not_looked_at():
    line = fit_lines([0, 1, 2, 3], [1, 3, -999, 7], weights=[1, 1, 0, 1])
    assert line == pytest.approx((2, 1))


def test_many_lines_are_fitted_each_by_itself():
    rng = np.random.default_rng(0)
    y = rng.normal(size=(2, 3, 9))
    weights = rng.integers(1, 4, size=y.shape)
    x = np.arange(9)
    together = fit_lines(x, y, weights=weights)
    assert together.slope.shape == (2, 3)
    for at in np.ndindex(2, 3):
        alone = fit_lines(x, y[at], weights=weights[at])
        assert together.slope[at] == pytest.approx(alone.slope)
        assert together.intercept[at] == pytest.approx(alone.intercept)


def test_a_line_is_evaluated_along_the_last_axis():
    assert Line(2.0, 1.0).at([0, 1]).tolist() == [1, 3]
    assert Line(np.array([2.0, 0.0]), np.array([1.0, 5.0])).at([0, 1]).tolist() == [[1, 3], [5, 5]]


@given(st.integers(-50, 50), st.integers(-50, 50), st.integers(2, 40))
def test_on_exact_data_the_robust_fit_is_the_ordinary_one(slope, intercept, n):
    x = np.arange(n)
    y = slope * x + intercept
    weights = np.arange(1.0, n + 1)
    line, final = fit_lines_robust(x, y, weights=weights)
    ordinary = fit_lines(x, y, weights=weights)
    assert line == pytest.approx(tuple(ordinary), abs=1e-9)
    assert final == pytest.approx(weights)


@given(
    st.integers(0, 2**32 - 1),
    st.lists(st.integers(0, 49), min_size=1, max_size=2, unique=True),
    st.sampled_from([-1.0, 1.0]),
    st.floats(10, 1000),
)
def test_gross_outliers_move_the_robust_line_by_a_bounded_amount(seed, wrong, side, size):
    n, noise = 50, 1.0
    x = np.arange(n) - (n - 1) / 2
    truth = Line(0.7, 100.0)
    y = truth.at(x) + np.random.default_rng(seed).uniform(-noise, noise, n)
    y[wrong] = truth.at(x[wrong]) + side * size
    line, _ = fit_lines_robust(x, y)
    # Let E be the largest error of the line over the frames, and h the hat matrix of all
    # points but the wrong ones.  At the solution the pulls balance: each right point pulls
    # with its residual at most, each wrong one with at most HUBER·1.4826·median, and the
    # median residual is at most noise + E.  So E ≤ S·noise + k·hat·L·(noise + E) with
    # S = max Σ|h| over the right points, hat = max |h| between any point and a wrong one,
    # L = 1.4826·HUBER: solve for E.  (The median of even noise is half its bound, so L times
    # the median is 1.5 times the bound: no right point is pulled back.)  Twelve rounds leave
    # the share (k·hat·L)^12 of the ordinary fit's error, which is k·hat·size at most.
    design = np.stack([np.ones(n), x], axis=1)
    right = np.setdiff1d(np.arange(n), wrong)
    hat = np.abs(design @ np.linalg.inv(design[right].T @ design[right]) @ design.T)
    pull = HUBER * 1.4826 * len(wrong) * hat[:, wrong].max()
    assert pull < 0.75
    bound = (hat[:, right].sum(axis=1).max() + pull) * noise / (1 - pull)
    bound += pull**12 * len(wrong) * hat[:, wrong].max() * size
    assert np.abs(line.at(x) - truth.at(x)).max() <= bound


def test_the_ordinary_line_has_no_such_bound():
    x, y = np.arange(50.0), np.zeros(50)
    y[-1] = 1e6
    robust, weights = fit_lines_robust(x, y)
    assert abs(robust.at(x)).max() < 1e-2 < 1e4 < abs(fit_lines(x, y).at(x)).max()
    assert weights[-1] < 1e-6


@given(curves.filter(lambda y: len(y) > 4), st.integers(1, 9), values, values)
def test_the_robust_line_follows_a_change_of_scale_and_slope(y, scale, slope, shift):
    x = np.arange(len(y))
    line, _ = fit_lines_robust(x, y)
    moved, _ = fit_lines_robust(x, scale * y + slope * x + shift)
    # Both stop when a round moves the line by less than 1e-6 of the residuals' spread.
    assert moved.slope == pytest.approx(scale * line.slope + slope, abs=1e-2)
    assert moved.intercept == pytest.approx(scale * line.intercept + shift, abs=1e-1)


@given(st.integers(0, 2**32 - 1), st.integers(4, 12))
def test_correlated_fit_is_the_textbook_formula(seed, n):
    rng = np.random.default_rng(seed)
    design = np.stack([np.ones(n), np.arange(n)], axis=1)
    mixing = rng.normal(size=(n, n))
    covariance = mixing @ mixing.T + n * np.eye(n)
    y = rng.normal(size=n)
    fit, uncertainty, misfit = fit_correlated(design, y, covariance)
    # Aitken: b = (XᵀV⁻¹X)⁻¹ XᵀV⁻¹y.  V's condition is under 10, so rounding is negligible.
    inverse = np.linalg.inv(covariance)
    expected_uncertainty = np.linalg.inv(design.T @ inverse @ design)
    expected = expected_uncertainty @ design.T @ inverse @ y
    residual = y - design @ expected
    assert uncertainty == pytest.approx(expected_uncertainty, rel=1e-8)
    assert fit == pytest.approx(expected, rel=1e-8, abs=1e-10)
    assert misfit == pytest.approx(residual @ inverse @ residual, rel=1e-8, abs=1e-10)


def test_with_white_noise_the_correlated_fit_is_least_squares():
    rng = np.random.default_rng(1)
    x, y = np.arange(8.0), rng.normal(size=(3, 8))
    design = np.broadcast_to(np.stack([np.ones(8), x], axis=1), (3, 8, 2))
    fit, uncertainty, _ = fit_correlated(design, y, np.broadcast_to(4 * np.eye(8), (3, 8, 8)))
    line = fit_lines(x, y)
    assert fit[:, 1] == pytest.approx(line.slope)
    assert fit[:, 0] == pytest.approx(line.intercept)
    # The variance of a slope is σ²/Σ(x − x̄)², here 4/42.
    assert uncertainty[:, 1, 1] == pytest.approx(4 / 42)


@pytest.mark.parametrize("fit", [fit_lines, fit_lines_robust])
@pytest.mark.parametrize(
    ("x", "y", "weights", "word"),
    [
        ([0, 1, 2], [0, 1], None, "shape"),
        ([0, 1], [0, 1], [1, 1, 1], "shape"),
        (0, 1, None, "shape"),
        ([0, np.nan], [0, 1], None, "finite"),
        ([0, 1], [0, np.inf], None, "finite"),
        ([0, 1], [0, 1], [1, np.nan], "finite"),
        ([0, 1], [0, 1], [1, -1], "negative"),
        ([3, 3], [0, 1], None, "two different"),
        ([0, 1], [0, 1], [1, 0], "two different"),
        ([], [], None, "two different"),
    ],
)
def test_points_that_make_no_line_are_refused(fit, x, y, weights, word):
    with pytest.raises(ArgumentError, match=word):
        fit(x, y, weights=weights)


@pytest.mark.parametrize("huber", [0, -1, np.nan, True])
def test_a_senseless_threshold_is_refused(huber):
    with pytest.raises(ArgumentError, match="huber"):
        fit_lines_robust([0, 1, 2], [0, 1, 2], huber=huber)
