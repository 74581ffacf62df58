"""The one camera, against known geometry, and against recordings."""

import importlib
import inspect
import pkgutil
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import mcnlab
from mcnlab.cameras.camera import Camera
from mcnlab.cameras.homography import find_homography, project
from mcnlab.datasets.motchallenge import read_mot_world
from mcnlab.datasets.pets import PETS_WIDTH, read_pets, read_tsai
from mcnlab.errors import ArgumentError
from mcnlab.synthetic.overhead import TOP_FLOOR
from mcnlab.synthetic.street import STREET
from mcnlab.synthetic.walkers import CASIA_VIEW
from mcnlab.tables import WORLD_X, WORLD_Y

SIZE = {"frame_width": 640, "frame_height": 480}
TILTED = Camera.from_tilt(focal_length=800, height=5, tilt=30, **SIZE)
ROLLED = Camera.from_tilt(focal_length=700, height=3, tilt=40, roll=9, place=(2, -1), **SIZE)
# Unlike focal lengths, a principal point off the middle; Tsai's κ in normalised coordinates.
LENS = np.array([[840.0, 0, 320], [0, 727.0, 240], [0, 0, 1]])
TSAI = Camera(LENS, TILTED.rotation, TILTED.translation, **SIZE, distortion=0.128)
BARREL = replace(TSAI, distortion=-0.3)
MATRIX = Camera.from_matrix(
    -3e-4 * LENS @ np.c_[ROLLED.rotation, ROLLED.translation], frame_size=(640, 480)
)
CAMERAS = {"tilt": TILTED, "roll": ROLLED, "tsai": TSAI, "barrel": BARREL, "matrix": MATRIX}

every_camera = pytest.mark.parametrize("camera", CAMERAS.values(), ids=CAMERAS)
# Below the horizon of all of them.
pixels = arrays(float, (12, 2), elements=st.floats(0, 1)).map(
    lambda share: np.array([0, 100]) + share * [640, 380]
)


# Where it stands and looks


def test_a_level_camera_projects_as_by_hand():
    camera = Camera.from_tilt(focal_length=100, height=2, tilt=0, frame_width=201, frame_height=101)
    # 1 m right and 1 m below the lens at 4 m: 100/4 pixels each from the centre (100, 50).
    assert camera.project([1, 4, 1]) == pytest.approx([125, 75])
    assert camera.depth([1, 4, 1]) == pytest.approx(4)
    assert camera.horizon == pytest.approx(50)


@every_camera
def test_the_axis_looks_along_the_third_row(camera):
    middle = camera.intrinsics[:2, 2]
    assert camera.ray([middle])[0] == pytest.approx(camera.rotation[2], abs=1e-12)


def test_the_axis_meets_the_ground_where_trigonometry_says():
    assert TILTED.centre == pytest.approx([0, 0, 5])
    assert TILTED.to_ground([[319.5, 239.5]]) == pytest.approx(np.array([[0, 5 * np.sqrt(3)]]))
    assert TILTED.depth([0, 5 * np.sqrt(3)]) == pytest.approx(10)  # 5 m / sin 30°


def test_the_camera_stands_where_it_was_put():
    assert ROLLED.centre == pytest.approx([2, -1, 3])
    assert MATRIX.centre == pytest.approx([2, -1, 3])


def test_rolling_turns_the_image_clockwise():
    upright = replace(ROLLED, rotation=TILTED.rotation)
    middle = np.array([319.5, 239.5])
    flat = Camera.from_tilt(focal_length=700, height=3, tilt=40, place=(2, -1), **SIZE)
    points = [[2.5, 3, 1], [1, 4, 0]]
    turn = np.radians(9)
    # Rows grow downwards, so that this matrix turns clockwise.
    turned = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    expected = middle + (flat.project(points) - middle) @ turned.T
    assert ROLLED.project(points) == pytest.approx(expected, abs=1e-9)
    assert upright != ROLLED


@pytest.mark.parametrize("camera", [TILTED, ROLLED, MATRIX, CASIA_VIEW, STREET, TOP_FLOOR])
def test_far_ground_meets_the_horizon(camera):
    column = (camera.frame_width - 1) / 2
    ahead = camera.ray([[column, camera.horizon]])[0]
    assert ahead[2] == pytest.approx(0, abs=1e-12)
    far = camera.project(camera.centre + 1e7 * ahead - [0, 0, camera.centre[2]])
    assert far == pytest.approx([column, camera.horizon], abs=0.01)


@given(st.floats(-80, 80))
def test_the_horizon_is_above_the_middle_by_the_tilt(tilt):
    camera = Camera.from_tilt(focal_length=800, height=2, tilt=tilt, **SIZE)
    row = 239.5 - 800 * np.tan(np.radians(tilt))
    assert camera.horizon == pytest.approx(row, abs=1e-8)


def test_a_camera_that_looks_straight_down_sees_no_horizon():
    down = Camera.from_tilt(focal_length=800, height=5, tilt=90, **SIZE)
    assert down.horizon is None
    # 100 pixels are 100·5/800 m there; the top of the image is ahead.
    assert down.to_ground([[419.5, 139.5]]) == pytest.approx(np.array([[0.625, 0.625]]))


# There and back


@every_camera
@given(points=pixels)
def test_ground_and_image_undo_each_other(camera, points):
    assert camera.project(camera.to_ground(points)) == pytest.approx(points, abs=1e-9)


@every_camera
@given(points=pixels, reach=st.floats(0.1, 50))
def test_a_ray_is_seen_at_its_pixel(camera, points, reach):
    rays = camera.ray(points)
    assert np.linalg.norm(rays, axis=1) == pytest.approx(1)
    assert camera.project(camera.centre + reach * rays) == pytest.approx(points, abs=1e-8)


@pytest.mark.parametrize("camera", [TILTED, ROLLED, MATRIX, TOP_FLOOR])
@given(shares=arrays(float, (12, 2), elements=st.floats(-1, 1)))
def test_the_homography_takes_the_image_to_the_ground(camera, shares):
    floor = np.array([2, 4]) + shares * [3, 2]
    seen = camera.project(floor)
    assert project(camera.homography, seen) == pytest.approx(floor, abs=1e-8)
    corners = np.array([[-2, 1], [6, 1], [6, 7], [-2, 7.0]])
    found = find_homography(camera.project(corners), corners)
    assert project(found, seen) == pytest.approx(floor, abs=1e-6)


@given(tilt=st.floats(-30, 60), x=st.floats(-9, 9), ahead=st.floats(1, 40), up=st.floats(0, 2))
def test_a_point_is_seen_along_its_ray(tilt, x, ahead, up):
    camera = Camera.from_tilt(focal_length=800, height=3, tilt=tilt, **SIZE)
    turn = np.radians(tilt)
    # Axes of the camera in metres right, up and ahead.
    right, down, along = np.array(
        [[1, 0, 0], [0, -np.cos(turn), -np.sin(turn)], [0, -np.sin(turn), np.cos(turn)]]
    )
    point = np.array([x, up - 3, ahead])
    depth = camera.depth([x, ahead, up])
    assert depth == pytest.approx(point @ along, abs=1e-12)
    if depth > 0.1:
        column, row = camera.project([x, ahead, up])
        assert (column - 319.5) * depth == pytest.approx(800 * point @ right, abs=1e-8)
        assert (row - 239.5) * depth == pytest.approx(800 * point @ down, abs=1e-8)


@given(arrays(float, (9, 3), elements=st.floats(-4, 4)))
def test_the_mirrored_world_is_the_mirrored_image(points):
    points = points + np.array([0, 9, 4])
    mirrored = TILTED.project(points * [-1, 1, 1])
    assert mirrored == pytest.approx(TILTED.project(points) * [-1, 1] + [639, 0], abs=1e-9)


@every_camera
@given(points=pixels, factor=st.floats(0.2, 3))
def test_a_resized_image_sees_the_same_ground(camera, points, factor):
    resized, there = camera.scaled(factor), factor * (points + 0.5) - 0.5
    assert resized.to_ground(there) == pytest.approx(camera.to_ground(points), rel=1e-7, abs=1e-9)
    assert resized.height_at(there) == pytest.approx(factor * camera.height_at(points), rel=1e-6)


def test_a_larger_frame_is_that_of_a_longer_focal_length():
    twice = TILTED.scaled(2)
    made = Camera.from_tilt(
        focal_length=1600, height=5, tilt=30, frame_width=1280, frame_height=960
    )
    assert twice == made
    assert hash(twice) == hash(made)
    assert len({twice, made, TILTED}) == 2


def test_a_person_appears_as_tall_as_its_head_says():
    feet, head = TSAI.project([[1, 8, 0], [1, 8, 1.75]])
    assert TSAI.height_at([feet]) == pytest.approx([np.linalg.norm(head - feet)], rel=1e-9)


# The lens


def test_the_seen_radius_grows_to_the_ideal_one_as_tsai_says():
    ideal = replace(TSAI, distortion=0.0)
    points = [[1, 8, 0], [-2, 6, 1]]
    seen, straight = (
        np.linalg.norm((camera.project(points) - LENS[:2, 2]) / [840, 727], axis=1)
        for camera in (TSAI, ideal)
    )
    assert seen * (1 + 0.128 * seen**2) == pytest.approx(straight, rel=1e-12)


def test_what_lies_beyond_the_lens_is_refused():
    barrel = replace(TSAI, distortion=-1.2)
    with pytest.raises(ArgumentError, match="beyond what the lens"):
        barrel.project([[0, 9, 0], [20, 8, 0]])
    with pytest.raises(ArgumentError, match="lens distortion does not reach"):
        barrel.ray([[5000.0, 240.0]])
    image, visible = barrel.see([[0, 9, 0], [20, 8, 0]])
    assert visible.tolist() == [True, False]
    assert np.isnan(image[1]).all()
    with pytest.raises(ArgumentError, match="a lens that distorts has no homography"):
        _ = TSAI.homography


# Out of sight


@every_camera
def test_a_point_behind_the_camera_is_never_seen(camera):
    points = np.array([camera.to_ground([[320.0, 300.0]])[0], [0, -30.0], [5, -300.0]])
    with pytest.raises(ArgumentError, match="in row 1; such a point lies behind the camera"):
        camera.project(points)
    image, visible = camera.see(points)
    assert visible.tolist() == [True, False, False]
    assert np.isnan(image[1:]).all()
    assert image[0] == pytest.approx([320, 300])


def test_the_frame_reaches_half_a_pixel_beyond_its_outer_centres():
    edges = np.array([[-0.49, 100], [-0.51, 100], [639.49, 100], [639.51, 479], [5, 479.6]])
    _, visible = TILTED.see(TILTED.to_ground(edges))
    assert visible.tolist() == [True, False, True, False, False]


def test_points_may_have_any_leading_axes():
    points = np.random.default_rng(0).uniform([-2, 5, 0], [2, 9, 2], (4, 3, 3))
    assert TILTED.project(points).shape == (4, 3, 2)
    assert TILTED.see(points)[1].shape == TILTED.depth(points).shape == (4, 3)
    assert TILTED.project(points)[2, 1] == pytest.approx(TILTED.project(points[2, 1]))


def test_what_a_camera_cannot_see_is_refused():
    with pytest.raises(ArgumentError, match=r"1 lie on or above the horizon .* row 1"):
        TILTED.to_ground([[320, 240], [320, -600]])
    with pytest.raises(ArgumentError, match="nan in row 0"):
        TILTED.project([[0, np.nan]])
    with pytest.raises(ArgumentError, match="inf in row 0"):
        TILTED.to_ground([[0, np.inf]])
    with pytest.raises(ArgumentError, match="shape"):
        TILTED.project([[0, 8, 1, 2]])
    with pytest.raises(ArgumentError, match="shape"):
        TILTED.project(3.0)
    with pytest.raises(ArgumentError, match="no number"):
        TILTED.project([["a", "b"]])
    with pytest.raises(ArgumentError, match="factor"):
        TILTED.scaled(0)
    with pytest.raises(ArgumentError, match="metres"):
        TILTED.height_at([[320, 300]], metres=0)


# What is no camera


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("intrinsics", np.eye(2)),
        ("intrinsics", np.diag([-1.0, 1, 1])),
        ("intrinsics", LENS.T),
        ("intrinsics", np.diag([1.0, 1, 2])),
        ("rotation", np.diag([1.0, 1, -1])),
        ("rotation", 2 * np.eye(3)),
        ("rotation", np.full((3, 3), np.nan)),
        ("translation", [0, 0]),
        ("frame_width", 0),
        ("frame_height", 2.5),
        ("distortion", np.inf),
    ],
)
def test_impossible_parts_are_refused(name, value):
    with pytest.raises(ArgumentError, match=f"^{name} "):
        replace(TSAI, **{name: value})


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("focal_length", 0),
        ("height", -1),
        ("tilt", np.nan),
        ("tilt", 91),
        ("roll", np.inf),
        ("frame_width", 0),
        ("frame_height", "9"),
        ("place", [1, 2, 3]),
    ],
)
def test_an_impossible_tilted_camera_is_refused(name, value):
    sound = {"focal_length": 800, "height": 2, "tilt": 4, **SIZE}
    with pytest.raises(ArgumentError, match=f"^{name} "):
        Camera.from_tilt(**{**sound, name: value})


@pytest.mark.parametrize("matrix", [np.zeros((3, 4)), np.ones((3, 4)), np.eye(3), "abc"])
def test_a_matrix_of_no_camera_is_refused(matrix):
    with pytest.raises(ArgumentError, match=r"^matrix "):
        Camera.from_matrix(matrix, (640, 480))


@pytest.mark.parametrize("factor", [1, -1, 1e-6, -1e4])
def test_a_matrix_gives_its_camera_whatever_its_scale(factor):
    made = Camera.from_matrix(factor * LENS @ np.c_[TSAI.rotation, TSAI.translation], (640, 480))
    assert made.intrinsics == pytest.approx(LENS, abs=1e-9)
    assert made.rotation == pytest.approx(TSAI.rotation, abs=1e-12)
    assert made.translation == pytest.approx(TSAI.translation, abs=1e-9)


# One class alone


def test_no_other_class_projects_points():
    modules = [
        importlib.import_module(found.name)
        for found in pkgutil.walk_packages(mcnlab.__path__, "mcnlab.")
        if not found.name.endswith("__main__")
    ]
    classes = {
        held
        for module in modules
        for _, held in inspect.getmembers(module, inspect.isclass)
        if held.__module__.startswith("mcnlab")
    }
    assert {held for held in classes if {"project", "to_image"} & set(dir(held))} == {Camera}
    assert {held for held in classes if held.__name__ == "Camera"} == {Camera}


# Recorded cameras


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
        assert camera.project(camera.to_ground(points)) == pytest.approx(points, abs=1e-9)
        assert camera.centre[2] > 1.5  # metres: on a tripod at the least
