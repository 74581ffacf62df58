"""Straight lines through noisy curves, many at a time.

Ordinary least squares is what the thesis calls linear regression (section 3.2.1; its
printed slope has ∑y where ∑xy is meant, and a misplaced bracket in the denominator).
Huber's M-estimate is its robust counterpart: a frame whose box is wrong loses its pull.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from threadpoolctl import ThreadpoolController

from mcnlab.checks import require_number
from mcnlab.errors import ArgumentError

HUBER = 2.0  # robust standard deviations; beyond them a point's pull no longer grows


class Line(NamedTuple):
    """A line y = slope·x + intercept, or many of them (arrays of one shape)."""

    slope: np.ndarray
    intercept: np.ndarray

    def at(self, x: ArrayLike) -> np.ndarray:
        """The line's value at `x`; for many lines, `x` has one axis more."""
        slope, intercept = np.asarray(self.slope), np.asarray(self.intercept)
        if slope.ndim:
            slope, intercept = slope[..., None], intercept[..., None]
        return slope * np.asarray(x) + intercept


def fit_line(x: np.ndarray, y: np.ndarray) -> Line:
    """The thesis's linear regression of one curve (section 3.2.1, misprints mended).

    Slope m = (n∑xy − ∑x∑y) / (n∑x² − (∑x)²), computed about the means, which is the same
    and loses fewer digits.

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        Finite, at least two different `x`.

    Returns
    -------
    Line
        Two floats.
    """
    mean_x, mean_y = float(x.mean()), float(y.mean())
    dx = x - mean_x
    square = float(dx @ dx)
    if square == 0:
        raise ArgumentError("x needs at least two different values to fit a line; add points.")
    slope = float(dx @ y) / square
    return Line(slope, mean_y - slope * mean_x)


def fit_lines(x: ArrayLike, y: ArrayLike, *, weights: ArrayLike | None = None) -> Line:
    """Least-squares lines along the last axis.

    Parameters
    ----------
    x, y : array_like, shape (..., n)
        Points; a point of weight 0 is not looked at, whatever it holds but NaN.
    weights : array_like, shape (..., n), optional
        Not negative.

    Returns
    -------
    Line
        Slopes and intercepts, shape (...).

    Raises
    ------
    ArgumentError
        When the shapes differ, a value is not finite, or a line has fewer than two
        points of different `x`.
    """
    x, y, weights = _check_points(x, y, weights)
    return _solve(x, y, weights)


def fit_lines_robust(
    x: ArrayLike,
    y: ArrayLike,
    *,
    weights: ArrayLike | None = None,
    huber: float = HUBER,
    iterations: int = 12,
) -> tuple[Line, np.ndarray]:
    """Huber's M-estimate of lines along the last axis, by reweighted least squares.

    Parameters
    ----------
    x, y, weights
        As in `fit_lines`; `weights` are inverse variances up to a factor.
    huber : float, optional
        Where the pull of a residual stops growing, in robust standard deviations.
    iterations : int, optional
        Rounds of reweighting.

    Returns
    -------
    line : Line
    weights : ndarray, shape (..., n)
        The final weights, outliers' reduced.

    Raises
    ------
    ArgumentError
        As in `fit_lines`.
    """
    x, y, weights = _check_points(x, y, weights)
    huber = require_number("huber", huber, above=0)
    root = np.sqrt(weights)
    used = weights > 0
    final = weights
    line = _solve(x, y, weights)
    settled = np.zeros(line.slope.shape, dtype=bool)
    for _ in range(iterations):
        residual = np.abs(y - line.at(x)) * root
        # The median of the residuals in use gives their robust standard deviation.
        ordered = np.sort(np.where(used, residual, np.inf), axis=-1)
        middle = (used.sum(axis=-1, keepdims=True) - 1) // 2
        spread = 1.4826 * np.take_along_axis(ordered, middle, axis=-1)
        # A line through the majority of points exactly leaves no scale to judge by.
        limit = np.maximum(huber * spread, 1e-9 * (1 + np.abs(y).max() * root.max()))
        pull = weights * np.minimum(1.0, limit / np.maximum(residual, 1e-300))
        new = _solve(x, y, pull)
        moved = np.abs(new.at(x) - line.at(x)) * root
        # A settled line stays, so that it does not depend on the company it is fitted in.
        final = np.where(settled[..., None], final, pull)
        line = Line(*(np.where(settled, *pair) for pair in zip(line, new, strict=True)))
        settled |= (moved <= 1e-3 * limit).all(axis=-1)
        if settled.all():
            break
    return line, final


def fit_correlated(
    design: np.ndarray, y: np.ndarray, covariance: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Generalised least squares, many problems at a time.

    Parameters
    ----------
    design : ndarray, shape (..., n, k)
        One column a coefficient.
    y : ndarray, shape (..., n)
    covariance : ndarray, shape (..., n, n)
        Of the noise in `y`; positive definite.

    Returns
    -------
    coefficients : ndarray, shape (..., k)
    uncertainty : ndarray, shape (..., k, k)
        The coefficients' covariance.
    misfit : ndarray, shape (...)
        Squared residual in units of the covariance: about n − k if that is right.

    References
    ----------
    A. C. Aitken, Proc. Royal Society of Edinburgh 55, 1935.
    """
    # Many small systems: threads inside each would only wait for one another.
    with _threads().limit(limits=1, user_api="blas"):
        whitened = np.linalg.solve(covariance, np.concatenate([design, y[..., None]], axis=-1))
    across = np.swapaxes(design, -1, -2)
    uncertainty = np.linalg.inv(across @ whitened[..., :-1])
    coefficients = (uncertainty @ (across @ whitened[..., -1:]))[..., 0]
    residual = y - (design @ coefficients[..., None])[..., 0]
    white = whitened[..., -1] - (whitened[..., :-1] @ coefficients[..., None])[..., 0]
    return coefficients, uncertainty, (residual * white).sum(axis=-1)


@lru_cache(maxsize=1)
def _threads():
    """The libraries' thread pools; finding them takes longer than a fit."""
    return ThreadpoolController()


def _check_points(x, y, weights):
    y = np.asarray(y, dtype=float)
    x = np.asarray(x, dtype=float)
    weights = np.ones(y.shape) if weights is None else np.asarray(weights, dtype=float)
    if y.ndim == 0 or weights.shape != y.shape or x.shape not in (y.shape, y.shape[-1:]):
        raise ArgumentError(
            f"x has shape {x.shape}, y {y.shape} and weights {weights.shape}; they must agree, "
            "with at least one axis."
        )
    x = np.broadcast_to(x, y.shape)
    if not (np.isfinite(x).all() and np.isfinite(y).all() and np.isfinite(weights).all()):
        raise ArgumentError("x, y or weights hold values that are not finite; drop those points.")
    if (weights < 0).any():
        raise ArgumentError("weights hold negative values; give 0 to leave a point out.")
    used = weights > 0
    low = np.where(used, x, np.inf).min(axis=-1, initial=np.inf)
    high = np.where(used, x, -np.inf).max(axis=-1, initial=-np.inf)
    if not (high > low).all():
        raise ArgumentError("x needs at least two different values to fit a line; add points.")
    return x, y, weights


def _solve(x, y, weights):
    total = weights.sum(axis=-1)
    mean_x = (weights * x).sum(axis=-1) / total
    mean_y = (weights * y).sum(axis=-1) / total
    dx = x - mean_x[..., None]
    slope = (weights * dx * (y - mean_y[..., None])).sum(axis=-1) / (weights * dx**2).sum(axis=-1)
    return Line(slope, mean_y - slope * mean_x)
