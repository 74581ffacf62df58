"""Homographies, against known geometry."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mcnlab.cameras.homography import find_homography, project
from mcnlab.errors import ArgumentError

SQUARE = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=float)
# How far a homography may be from affine and keep the unit square in front: p, q > −½ each.
bend = st.floats(-0.4, 0.4)


@st.composite
def homographies(draw):
    """A turned, stretched and foreshortened map of the unit square."""
    angle, stretch = draw(st.floats(-3, 3)), draw(st.floats(0.3, 3))
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    matrix = np.eye(3)
    matrix[:2, :2] = 5.0 * turn @ np.diag([stretch, 1.0])
    matrix[:2, 2] = draw(st.floats(-50, 50)), draw(st.floats(-50, 50))
    matrix[2, :2] = draw(bend), draw(bend)
    return matrix


@given(homographies(), arrays(float, (9, 2), elements=st.floats(0, 1)))
def test_a_homography_is_found_from_four_points(matrix, points):
    found = find_homography(SQUARE, project(matrix, SQUARE))
    # Four corners of a unit square fix it; what is left is rounding, blown up by at most the
    # ratio of the scales here (50/0.3) and the foreshortening (1/0.2²): far below 1e-6.
    assert project(found, points) == pytest.approx(project(matrix, points), abs=1e-6)


@given(homographies(), arrays(float, (9, 2), elements=st.floats(0, 1)))
def test_there_and_back_is_where_one_was(matrix, points):
    there = project(matrix, points)
    assert project(np.linalg.inv(matrix), there) == pytest.approx(points, abs=1e-8)


def test_the_scale_of_the_units_does_not_matter():
    ground = np.array([[0, 0], [10, 1], [9, 12], [-1, 8]], dtype=float)
    pixels = np.array([[100, 900], [1800, 950], [1200, 300], [500, 280]], dtype=float)
    metres = find_homography(pixels, ground)
    millimetres = find_homography(pixels, 1000 * ground)
    middle = [[800.0, 600.0]]
    assert project(millimetres, middle) == pytest.approx(1000 * project(metres, middle))


def test_many_noisy_points_give_their_best_homography():
    rng = np.random.default_rng(0)
    matrix = np.array([[4, 1, 3], [-1, 5, 2], [0.1, 0.2, 1.0]])
    image = rng.uniform(0, 1, (200, 2))
    ground = project(matrix, image) + rng.normal(0, 0.01, (200, 2))
    away = project(find_homography(image, ground), image) - project(matrix, image)
    # Eight parameters from 400 readings: the fit's variance is 8/400 of the noise's on
    # average, 0.0014 in all; thrice that at the worst of the points' mean.
    assert np.sqrt((away**2).mean()) < 3 * 0.01 * np.sqrt(8 / 400)


FAR = np.array([[0, 0], [4, 1], [5, 6], [-1, 5]], dtype=float)


@pytest.mark.parametrize(
    ("points", "words"),
    [
        (FAR[:3], "at least 4 rows"),
        (np.c_[np.arange(4.0), 2 * np.arange(4.0)], "on a line"),
        (np.array([[0, 0], [1, 0], [2, 0], [0, 5.0]]), "on a line"),
        (FAR[[0, 1, 2, 2]], "3 different points"),
        (FAR[[0, 0, 0, 0]], "1 different points"),
        (np.where(FAR == 6, np.nan, FAR), "(nan|inf) in row 2"),
        (np.where(FAR == 6, np.inf, FAR), "(nan|inf) in row 2"),
        (np.zeros((4, 3)), "shape"),
        ([["a", "b"]] * 4, "no number|not numbers"),
        (None, "shape|no number"),
    ],
    ids=[
        *("three", "line", "three-on-a-line", "repeated", "same"),
        *("nan", "inf", "3d", "text", "none"),
    ],
)
@pytest.mark.parametrize("side", ["image_points", "ground_points"])
def test_points_that_fix_no_homography_are_refused(points, words, side):
    sound = {"image_points": FAR, "ground_points": FAR}
    with pytest.raises(ArgumentError, match=words) as refusal:
        find_homography(**{**sound, side: points})
    assert side in str(refusal.value)


def test_points_without_partners_are_refused():
    with pytest.raises(ArgumentError, match="4 rows, ground_points 5"):
        find_homography(FAR, np.r_[FAR, [[2, 2]]])


def test_pairs_in_different_orders_are_refused():
    # Two corners exchanged: the sides cross, as no camera in front of the ground sees them.
    with pytest.raises(ArgumentError, match="both sides of the horizon"):
        find_homography(SQUARE, SQUARE[[0, 1, 3, 2]])


@given(arrays(float, (4, 2), elements=st.integers(-3, 3).map(float)))
def test_any_four_points_give_an_invertible_homography_or_an_error(points):
    try:
        found = find_homography(points, FAR)
    except ArgumentError:
        return
    assert np.linalg.matrix_rank(found) == 3
    assert project(found, points) == pytest.approx(FAR, abs=1e-6)


@pytest.mark.parametrize(
    "matrix",
    [np.ones((3, 3)), np.zeros((3, 3)), np.eye(2), np.full((3, 3), np.nan), "abc", None],
    ids=["rank one", "zero", "2x2", "nan", "text", "none"],
)
def test_a_matrix_that_is_no_homography_is_refused(matrix):
    with pytest.raises(ArgumentError, match="homography"):
        project(matrix, SQUARE)


def test_a_point_on_the_horizon_has_no_ground():
    with pytest.raises(ArgumentError, match="row 1 lies on the horizon"):
        project([[1, 0, 0], [0, 1, 0], [0, 1, -1]], [[0, 0], [5, 1]])


@given(homographies(), arrays(float, (9, 2), elements=st.floats(0, 1)), st.sampled_from([-1, 1e-5]))
def test_a_homography_may_have_any_sign_and_scale(matrix, points, factor):
    assert project(factor * matrix, points) == pytest.approx(project(matrix, points), rel=1e-9)


HORIZON_IN_ROW_40 = np.array([[5, 0, -800.0], [0, 0, 500], [0, 1, -40]])


@pytest.mark.parametrize(
    ("rows", "stray"),
    [([50, 60, 30], 2), ([30, 50, 60], 0), ([10, 50, 20, 30], 1), ([50, 30], 1), ([30, 50], 1)],
)
@pytest.mark.parametrize("sign", [-1, 1])
def test_points_on_both_sides_of_the_horizon_are_refused(rows, stray, sign):
    points = np.c_[np.full(len(rows), 100.0), rows]
    with pytest.raises(ArgumentError, match=f"points row {stray} lies beyond the horizon"):
        project(sign * HORIZON_IN_ROW_40, points)
    for side in (points[points[:, 1] > 40], points[points[:, 1] < 40]):
        assert np.isfinite(project(sign * HORIZON_IN_ROW_40, side)).all()
