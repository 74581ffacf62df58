"""Homographies, calibrated cameras and the grid map, against known geometry."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mcnlab.cameras.camera import TsaiCamera
from mcnlab.cameras.floor import GridMap, check_grid, check_walls
from mcnlab.cameras.homography import find_homography, project
from mcnlab.datasets.motchallenge import read_mot_world
from mcnlab.datasets.pets import PETS_WIDTH, read_pets, read_tsai
from mcnlab.errors import ArgumentError
from mcnlab.tables import WORLD_X, WORLD_Y

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


@given(arrays(float, (20, 2), elements=st.floats(-1, 1)))
def test_the_image_of_the_floor_is_taken_back_to_it(camera, shares):
    # Metres on the floor in front of the camera that is fixed below, seen without distortion.
    floor = np.array([0, 8]) + shares * [4, 5]
    ideal = TsaiCamera(8.0, 0.0, camera.centre, 1.0, camera.pitch, camera.turn, camera.shift)
    corners = np.array([[-4, 3], [4, 3], [4, 13], [-4, 13.0]])
    to_ground = find_homography(ideal.to_image(corners), corners)
    assert project(to_ground, ideal.to_image(floor)) == pytest.approx(floor, abs=1e-6)


def test_walls_come_back_as_segments():
    wall = [[0, 0], [1, 2]]
    for none in (None, [], (), np.empty((0, 2, 2)), np.empty(0)):
        assert check_walls(none).shape == (0, 2, 2)
    assert check_walls([wall, wall]).tolist() == [wall, wall]
    assert check_walls([wall]).dtype == float


@pytest.mark.parametrize(
    ("walls", "words"),
    [
        ([[0, 1]], "shape"),
        (3.0, "shape"),
        ([[0, 0, 1, 2]], "shape"),
        ([[[0, 0], [1, 2]], [[0, 0]]], "no number|not numbers"),
        ([[["a", "b"], ["c", "d"]]], "no number|not numbers"),
        ("wall", "no number|not numbers"),
        ({"wall": 1}, "no number|not numbers"),
        ([[[0, 0], [1, 2]], [[0, np.nan], [1, 2]]], "nan in row 1"),
        ([[[0, 0], [np.inf, 2]]], "row 0"),
        ([[[0, 0], [1e300, 2]]], "row 0"),
    ],
)
def test_walls_that_are_none_are_refused(walls, words):
    with pytest.raises(ArgumentError, match=f"edges .*{words}"):
        check_walls(walls, argument="edges")


@pytest.mark.parametrize("grid", [None, (0, 0, 1, 1), np.zeros((3, 3)), GridMap])
def test_what_is_no_grid_is_refused(grid):
    with pytest.raises(ArgumentError, match=r"map is a .*; pass a GridMap"):
        check_grid(grid, argument="map")


@given(
    st.floats(-20, 20),
    st.floats(-20, 20),
    st.floats(0.05, 3),
    arrays(float, (20, 2), elements=st.floats(0, 0.999)),
)
def test_every_point_lies_in_the_cell_that_it_is_given(left, bottom, cell, shares):
    grid = GridMap(left, bottom, 7, 5, cell)
    places = [left, bottom] + shares * cell * np.array([5, 7])
    assume(grid.inside(*places.T).all())
    row, column = grid.cell_of(*places.T)
    x, y = grid.place_of(row, column)
    # Half a cell from its centre at most, but for rounding.
    assert np.abs(places - np.stack([x, y], axis=1)).max() <= cell / 2 + 1e-9
    assert (row >= 0).all() and (row < 7).all() and (column >= 0).all() and (column < 5).all()


def test_a_grid_covers_its_area_with_row_0_at_the_bottom():
    grid = GridMap.over((-1, 2, 4, 4.5), cell=0.5)
    assert grid.shape == (5, 10)
    assert grid.area == (-1, 2, 4, 4.5)
    assert grid.pixel == 0.5 / 8
    x, y = grid.centres()
    assert (x[0], y[0]) == (-0.75, 2.25)
    row, column = grid.cell_of([-1.0, 3.99], [2.0, 4.49])
    assert (row.tolist(), column.tolist()) == ([0, 4], [0, 9])


def test_points_outside_the_map_are_counted():
    grid = GridMap.over((0, 0, 2, 2))
    assert grid.inside([-0.1, 0, 2, np.nan], [0, 0, 0, 0]).tolist() == [False, True, False, False]
    with pytest.raises(ArgumentError, match="2 points lie outside"):
        grid.cell_of([1, 3, np.nan], [1, 1, 1])


@pytest.mark.parametrize(
    ("area", "cell", "words"),
    [
        ((0, 0, 0, 1), 0.5, "left < right"),
        ((0, 0, 1, np.nan), 0.5, "finite"),
        ((0, 0, 1), 0.5, "area"),
        (None, 0.5, "area"),
        ((0, 0, 1, 1), 0, "cell"),
        ((0, 0, 1e9, 1e9), 0.01, "larger cell"),
    ],
)
def test_an_impossible_map_is_refused(area, cell, words):
    with pytest.raises(ArgumentError, match=words):
        GridMap.over(area, cell=cell)


@pytest.fixture(scope="module")
def camera():
    """Five metres up over the world's origin, looking north and 30° down, with distortion."""
    sin, cos = 0.5, np.sqrt(0.75)
    # Camera x = world x; the axis (camera z) points north and down; camera y is what is left.
    turn = np.array([[1, 0, 0], [0, -sin, -cos], [0, cos, -sin]])
    shift = -turn @ np.array([0, 0, 5000.0])
    return TsaiCamera(8.0, 0.002, (320.0, 240.0), 1.05, (0.01, 0.011), turn, shift)


pixels = arrays(float, (12, 2), elements=st.floats(0, 1)).map(
    lambda share: np.array([0, 100]) + share * [640, 380]
)


def test_the_axis_meets_the_ground_where_trigonometry_says(camera):
    assert camera.place == pytest.approx([0, 0, 5])
    assert camera.to_ground([[320.0, 240.0]]) == pytest.approx(np.array([[0, 5 * np.sqrt(3)]]))


@given(pixels)
def test_ground_and_image_undo_each_other(camera, points):
    assert camera.to_image(camera.to_ground(points)) == pytest.approx(points, abs=1e-7)


@given(pixels, st.floats(0.2, 3))
def test_a_resized_image_sees_the_same_ground(camera, points, factor):
    assert camera.scaled(factor).to_ground(factor * points) == pytest.approx(
        camera.to_ground(points), rel=1e-9
    )
    assert camera.scaled(factor).height_at(factor * points) == pytest.approx(
        factor * camera.height_at(points), rel=1e-6
    )


def test_a_person_appears_as_tall_as_its_head_says(camera):
    feet = camera.to_image([[1.0, 8.0]])
    head = camera.to_image([[1.0, 8.0, 1.75]])
    assert camera.height_at(feet) == pytest.approx(np.linalg.norm(head - feet), rel=1e-6)


def test_what_a_camera_cannot_see_is_refused(camera):
    with pytest.raises(ArgumentError, match="1 lie on or above the horizon"):
        camera.to_ground([[320, 240], [320, -600]])
    with pytest.raises(ArgumentError, match="row 1 lies behind"):
        camera.to_image([[0, 8], [0, -30]])
    with pytest.raises(ArgumentError, match="not finite"):
        camera.to_image([[0, np.nan]])
    with pytest.raises(ArgumentError, match="inf in row 0"):
        camera.to_ground([[0, np.inf]])
    with pytest.raises(ArgumentError, match="shape"):
        camera.to_image([0, 8])
    with pytest.raises(ArgumentError, match="not numbers"):
        camera.to_image([["a", "b"]])
    with pytest.raises(ArgumentError, match="factor"):
        camera.scaled(0)


def test_a_barrel_that_folds_over_is_refused(camera):
    barrel = TsaiCamera(8.0, -0.02, camera.centre, 1.0, camera.pitch, camera.turn, camera.shift)
    with pytest.raises(ArgumentError, match="row 0 lies beyond what the lens"):
        barrel.to_image([[20.0, 8.0]])


def test_pets_boxes_stand_where_the_world_truth_says(recordings):
    folder = recordings / "pets2009"
    camera = read_tsai(folder / "View_001.xml")
    boxes = read_pets(folder).boxes
    world = read_mot_world(recordings / "motchallenge" / "PETS09-S2L1" / "gt" / "gt.txt")
    both = boxes.merge(world, on=["sequence", "frame"])
    assert len(both) == len(world)
    found = camera.to_ground(np.c_[both["cx"], both["y"] + both["h"]])
    away = np.linalg.norm(found - both[[WORLD_X, WORLD_Y]], axis=1)
    # Boxes are whole pixels of 768×576 in one file and not in the other: half a pixel of the
    # feet's row, which is 0.07 m to 0.15 m of ground where people walk.
    assert np.median(away) < 0.15
    assert np.percentile(away, 95) < 0.3


def test_every_pets_camera_undoes_itself(recordings):
    grid = np.stack(np.meshgrid([100, PETS_WIDTH / 2, 700], [350, 450, 570]), axis=-1)
    points = grid.reshape(-1, 2).astype(float)
    for number in range(1, 9):
        camera = read_tsai(recordings / "pets2009" / f"View_00{number}.xml")
        assert camera.to_image(camera.to_ground(points)) == pytest.approx(points, abs=1e-6)
        assert camera.place[2] > 1.5  # metres: on a tripod at the least
