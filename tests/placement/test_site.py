"""Sites and every choice on them, against geometry done by hand."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcnlab.cameras.floor import GridMap
from mcnlab.cameras.visibility import CameraModel
from mcnlab.datasets import trajectories
from mcnlab.datasets.scene import Scene
from mcnlab.errors import ArgumentError
from mcnlab.placement import coverage
from mcnlab.placement.site import (
    METHODS,
    MOST_PLACES,
    away_from_walls,
    choose_cameras,
    grid_over,
    judge_cameras,
    no_floor,
    plan_of,
    prepare_site,
)
from mcnlab.tables import FRAME, TRACE, X, Y

RATE = 10.0
SPLITS = 2
MODEL = CameraModel(near=0.5, reach=4.0, pans=True, square_within=15.0)


def trace(name, x, y, *, start=0):
    """One walker's places, a frame each."""
    return pd.DataFrame({TRACE: name, FRAME: start + np.arange(len(x)), X: x, Y: y})


# The grid


@given(
    st.floats(-1e5, 1e5),
    st.floats(-1e5, 1e5),
    st.floats(1e-3, 1e3),
    st.floats(1e-3, 1e3),
    st.integers(1, 2000),
)
def test_a_grid_holds_no_more_cells_than_asked_and_covers_the_area(x, y, wide, tall, most):
    area = (x, y, x + wide, y + tall)
    if area[2] <= area[0] or area[3] <= area[1]:
        return
    grid = grid_over(area, most=most)
    assert grid.rows * grid.columns <= most
    left, bottom, right, top = grid.area
    # A hair beyond a whole number of cells is taken for rounding: 1e-9 of a cell, and of x.
    hair = 1e-8 * (grid.cell + abs(x) + abs(y))
    assert (left, bottom) == area[:2]
    assert right >= area[2] - hair
    assert top >= area[3] - hair
    assert grid.cell >= 0.5


def test_a_small_area_keeps_the_cell_and_a_large_one_gets_the_next_that_does():
    assert grid_over((0, 0, 12, 6)).cell == 0.5
    assert grid_over((0, 0, 12, 6), cell=0.3).cell == 0.3
    assert grid_over((0, 0, 0.1, 0.1)).shape == (1, 1)
    grid = grid_over((0, 0, 30, 30))  # 0.7 m make 43 × 43, 0.8 m 38 × 38
    assert grid.cell == 0.8
    assert grid.shape == (38, 38)


@pytest.mark.parametrize("area", [(0, 0, 1000, 0.1), (0, 0, 0.1, 1000), (0, 0, 900, 900)])
def test_long_and_large_areas_are_covered_too(area):
    grid = grid_over(area)
    assert grid.rows * grid.columns <= MOST_PLACES


# One site


def test_a_site_is_what_its_parts_say(hall):
    site = prepare_site(hall, model=MODEL)
    assert site.grid == GridMap.over(hall.area, cell=0.5)
    pd.testing.assert_frame_equal(site.targets, coverage.walker_seconds(hall))
    assert len(site.cameras) == site.grid.rows * site.grid.columns
    assert site.served.shape == (len(site.targets), len(site.cameras))
    assert not site.forbidden.any()


def test_a_wall_hides_walkers_from_the_candidates(hall):
    walled = replace(hall, walls=[[[0.0, 2.0], [12.0, 2.0]]])
    site = prepare_site(walled, model=MODEL)
    assert not site.served[:, site.cameras[Y] < 2].any()
    assert site.served[:, site.cameras[Y] > 2].any()


def test_no_camera_stands_where_it_may_not(hall):
    grid = grid_over(hall.area)
    forbidden = np.zeros(grid.shape, bool)
    forbidden[4:8] = True  # y from 2 m to 4 m
    site = prepare_site(hall, model=MODEL, grid=grid, forbidden=forbidden)
    for method in METHODS:
        cameras, _ = choose_cameras(site, method, 2)
        assert ((cameras[Y] < 2) | (cameras[Y] > 4)).all(), method


def test_neither_cameras_nor_ground_are_where_there_is_no_floor(hall):
    built = replace(hall, blocks=[[4.0, 3.5, 8.0, 6.0]])
    grid = grid_over(hall.area)
    blocked = no_floor(built, grid)
    x, y = np.meshgrid(*grid.centres())
    np.testing.assert_array_equal(blocked, (x > 4) & (x < 8) & (y > 3.5))
    assert not no_floor(hall, grid).any()
    forbidden = x < 2
    site = prepare_site(built, model=MODEL, grid=grid, forbidden=forbidden)
    np.testing.assert_array_equal(site.forbidden, blocked | forbidden)
    assert len(site.cameras) == np.count_nonzero(~site.forbidden)


def test_the_centre_of_a_ring_sees_everybody(ring):
    # From half a metre off, who walks at 2 m is up to asin(0.5/2) = 14° off square-on.
    model = replace(MODEL, square_within=5.0)
    site = prepare_site(ring, model=model)
    for method in ("votes", "greedy", "swaps", "exact"):
        cameras, choice = choose_cameras(site, method, 1)
        assert cameras[[X, Y]].to_numpy().tolist() == [[4.25, 4.25]], method
        seen = judge_cameras(cameras, site.targets, model=model)
        assert seen.all(), method
        assert choice is None or choice.share == 1


def test_only_the_choices_by_walks_come_with_a_choice(corridor):
    site = prepare_site(corridor, model=MODEL)
    for method in METHODS:
        cameras, choice = choose_cameras(site, method, 2)
        assert len(cameras) == 2, method
        assert (choice is None) == (method in ("votes", "area", "random")), method
        seen = judge_cameras(cameras, site.targets, model=MODEL, walls=corridor.walls)
        assert choice is None or choice.share == pytest.approx(seen.mean())


@pytest.mark.parametrize("pans", [True, False])
@pytest.mark.parametrize("n", [1, 2, 4])
def test_nothing_chosen_from_the_candidates_beats_the_exact_choice(corridor, n, pans):
    model = replace(MODEL, pans=pans)
    site = prepare_site(corridor, model=model)
    share = {}
    for method in METHODS:
        cameras, _ = choose_cameras(site, method, n)
        seen = judge_cameras(cameras, site.targets, model=model, walls=corridor.walls)
        share[method] = seen.mean()
    assert share["exact"] == max(share.values())
    assert share["swaps"] >= share["greedy"] >= (1 - 1 / np.e) * share["exact"]


def test_random_places_follow_the_seed(corridor):
    site = prepare_site(corridor, model=MODEL)
    first, again, other = (
        choose_cameras(site, "random", 3, seed=seed)[0]["place"].tolist() for seed in (1, 1, 2)
    )
    assert first == again != other


def test_folds_ask_for_as_many_views(hall):
    cameras = pd.DataFrame({X: [6.0, 6.0], Y: [1.0, 5.0], "heading": [90.0, 270.0]})
    targets = pd.DataFrame({X: [6.0, 20.0], Y: [3.0, 3.0], "course": [0.0, 0.0]})
    judge = {"model": MODEL}
    assert judge_cameras(cameras, targets, **judge).tolist() == [True, False]
    assert judge_cameras(cameras, targets, folds=2, **judge).tolist() == [True, False]
    one = cameras.head(1)
    assert judge_cameras(one, targets, folds=2, **judge).tolist() == [False, False]
    assert judge_cameras(cameras.head(0), targets, **judge).tolist() == [False, False]


@pytest.mark.parametrize(
    ("method", "n", "word"),
    [("best", 2, "method is 'best'"), ("votes", 0, "n is 0"), ("exact", 1.5, r"n is 1\.5")],
)
def test_choices_that_cannot_be_are_refused(hall, method, n, word):
    site = prepare_site(hall, model=MODEL)
    with pytest.raises(ArgumentError, match=word):
        choose_cameras(site, method, n)


# Plans


def test_a_plan_is_the_choice_on_its_own_site(hall):
    forbidden = np.zeros(grid_over(hall.area).shape, bool)
    forbidden[:, 8] = True
    site = prepare_site(hall, model=MODEL, forbidden=forbidden)
    cameras, choice = choose_cameras(site, "exact", 3)
    planned, served, barred = plan_of(site, choice)
    pd.testing.assert_frame_equal(planned, cameras)
    assert served.mean() == pytest.approx(choice.share)
    np.testing.assert_array_equal(barred, forbidden)
    twice = plan_of(site, choice, folds=2)[1]
    np.testing.assert_array_equal(
        twice, site.served[:, choice.cameras].astype(int).sum(axis=1) >= 2
    )


def test_places_away_from_walls_are_so_far_from_the_nearest_point(hall):
    walls = [[[2.0, 3.0], [6.0, 3.0]], [[9.0, 1.0], [9.0, 1.0]]]  # the second is a post
    scene = replace(hall, walls=walls)
    grid = grid_over(scene.area)
    away = away_from_walls(scene, grid, within=1.0)
    x, y = np.meshgrid(*grid.centres())
    beside = np.hypot(np.maximum(np.maximum(2 - x, x - 6), 0), y - 3)
    np.testing.assert_array_equal(away, np.minimum(beside, np.hypot(x - 9, y - 1)) > 1)
    assert 0 < away.sum() < away.size


def test_a_scene_without_walls_forbids_nothing_by_them(hall):
    with pytest.raises(ArgumentError, match="'hall' has no walls"):
        away_from_walls(hall, grid_over(hall.area))


def test_no_method_beats_the_proven_choice_on_the_walks_that_it_saw(recordings):
    scenes = trajectories.read_scenes(recordings)[0]
    assert scenes
    for scene in scenes:
        half, _ = scene.split(seed=0)
        site = prepare_site(half, model=CameraModel(pans=True))
        shares = {}
        for method in METHODS:
            cameras, choice = choose_cameras(site, method, 3)
            shares[method] = judge_cameras(cameras, site.targets, model=site.model).mean()
        assert choice.proven, scene.name
        assert shares["exact"] == max(shares.values()), (scene.name, shares)


def test_cameras_that_add_no_ground_stand_far_from_the_others():
    # On an open place of 4×4 m one panning camera sees all but the ground at its own foot, and
    # the second that; the other two are to spare, and take corners.
    x = np.linspace(0.1, 3.9, 40)
    walk = pd.DataFrame({"trace": "a", "frame": np.arange(40), "x": x, "y": 2.0})
    scene = Scene("open", walk, 10.0, (0, 0, 4, 4))
    site = prepare_site(scene, model=CameraModel(pans=True, near=0))
    places = choose_cameras(site, "area", 4)[0][["x", "y"]].to_numpy()
    assert np.linalg.norm(places[2:, None] - places[:2], axis=2).min() > 3
    assert np.linalg.norm(places[2] - places[3]) > 3
