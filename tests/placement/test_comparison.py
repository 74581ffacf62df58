"""Choosing camera places from one half of the walkers, judged on the other half."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcnlab.cameras import visibility
from mcnlab.cameras.floor import GridMap
from mcnlab.cameras.visibility import CameraModel
from mcnlab.control import pan_tilt
from mcnlab.control.pan_tilt import PanTilt
from mcnlab.datasets import trajectories
from mcnlab.datasets.scene import Scene
from mcnlab.errors import ArgumentError
from mcnlab.placement import comparison, coverage, votes
from mcnlab.placement.choice import choose_random
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
from mcnlab.synthetic.corridor import make_corridor
from mcnlab.tables import FRAME, TRACE, X, Y

RATE = 10.0
SPLITS = 2
MODEL = CameraModel(near=0.5, reach=4.0, pans=True, square_within=15.0)


def trace(name, x, y, *, start=0):
    """One walker's places, a frame each."""
    return pd.DataFrame({TRACE: name, FRAME: start + np.arange(len(x)), X: x, Y: y})


@pytest.fixture(scope="module")
def hall():
    """Six people who walk along y = 3, some this way and some that, a metre a second."""
    along = 1 + np.arange(101) / RATE
    walks = [
        trace(f"w{number}", along[:: (-1) ** number], np.full(101, 3 + 0.02 * number), start=number)
        for number in range(6)
    ]
    return Scene("hall", pd.concat(walks, ignore_index=True), RATE, (0.0, 0.0, 12.0, 6.0))


@pytest.fixture(scope="module")
def ring():
    """Four people who walk round (4.25, 4.25), in the middle of cell (8, 8), at 2 to 2.6 m."""
    angle = np.arange(0, 2 * np.pi, 1.2 / 2.3 / RATE)
    middle = 4.25
    walks = [
        trace(f"w{number}", middle + radius * np.cos(angle), middle + radius * np.sin(angle))
        for number, radius in enumerate((2.0, 2.2, 2.4, 2.6))
    ]
    return Scene("ring", pd.concat(walks, ignore_index=True), RATE, (0.0, 0.0, 8.5, 8.5))


@pytest.fixture(scope="module")
def corridor():
    """A few people in the corridor."""
    return make_corridor(walkers=16, seed=3)


@pytest.fixture(scope="module")
def compared(corridor):
    """Every method on the corridor, three cameras."""
    return comparison.compare_methods(corridor, n=3, model=MODEL, splits=SPLITS)


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


# Two halves


def test_every_walker_second_is_judged_once_by_the_other_half(corridor, compared):
    _, seconds = compared
    whole = coverage.walker_seconds(corridor)
    counts = whole[TRACE].value_counts().sort_index()
    assert seconds["split"].unique().tolist() == list(range(SPLITS))
    for split, part in seconds.groupby("split"):
        judged = part["person"].value_counts().sort_index()
        pd.testing.assert_series_equal(judged, counts, check_names=False)
        # Half 0 chose; so the second half of the split is judged under it.
        for number, held in enumerate(corridor.split(seed=split)[::-1]):
            assert set(part["person"][part["half"] == number]) <= set(held.walkers)


def test_held_out_shares_are_what_the_chosen_cameras_see_of_the_others(corridor, compared):
    shares, seconds = compared
    shares = shares.set_index("method")
    grid = grid_over(corridor.area)
    halves = [corridor.split(seed=split)[:: 1 - 2 * turn] for split in range(2) for turn in (0, 1)]
    for method in ("votes", "area", "greedy", "swaps", "exact"):
        held, fitted = [], []
        for half, other in halves:
            site = prepare_site(half, model=MODEL, grid=grid)
            cameras, _ = choose_cameras(site, method, 3)
            for walks, seen in ((other, held), (half, fitted)):
                served = visibility.square_on(
                    coverage.walker_seconds(walks), cameras, MODEL, walls=corridor.walls
                )
                seen.append(served.any(axis=1))
        np.testing.assert_array_equal(seconds[method], np.concatenate(held))
        row = shares.loc[method]
        assert row["share"] == pytest.approx(np.concatenate(held).mean())
        assert row["fitted"] == pytest.approx(np.mean([seen.mean() for seen in fitted]))
        assert row["low"] <= row["share"] <= row["high"]
        assert row["n"] == len(corridor.walkers)
    assert shares.loc["exact", "gap"] == 0
    assert shares.loc["exact", "fitted"] == shares["fitted"].max()


def test_a_random_share_is_the_mean_over_draws(corridor, compared):
    _, seconds = compared
    half, other = corridor.split(seed=0)
    grid = grid_over(corridor.area)
    site, held = (prepare_site(part, model=MODEL, grid=grid) for part in (half, other))
    draws = choose_random(site.served, 3, draws=comparison.DRAWS, seed=0)
    expected = np.mean([held.served[:, drawn].any(axis=1) for drawn in draws.cameras], axis=0)
    first = (seconds["split"] == 0) & (seconds["half"] == 0)
    np.testing.assert_allclose(seconds["random"][first], expected)


def test_the_seed_alone_decides(corridor, compared):
    again = comparison.compare_methods(corridor, n=3, model=MODEL, splits=SPLITS)
    for table, other in zip(compared, again, strict=True):
        pd.testing.assert_frame_equal(table, other)
    moved = comparison.compare_methods(corridor, n=3, model=MODEL, methods=("greedy",), seed=1)[1]
    assert not moved["person"].equals(compared[1]["person"])


def test_a_mirrored_scene_has_the_same_optimum(corridor):
    width = corridor.area[0] + corridor.area[2]
    mirrored = replace(
        corridor,
        traces=corridor.traces.assign(x=width - corridor.traces[X]),
        walls=np.stack([width - corridor.walls[..., 0], corridor.walls[..., 1]], axis=-1),
    )
    # 11.5 m are 23 cells: the grid is its own mirror image, and so are eight headings.
    shares = [
        comparison.compare_methods(scene, n=2, model=replace(MODEL, pans=pans), methods=("exact",))[
            0
        ]
        for pans in (True, False)
        for scene in (corridor, mirrored)
    ]
    for left, right in (shares[:2], shares[2:]):
        assert left["fitted"][0] == pytest.approx(right["fitted"][0])
        assert left["fitted"][0] > 0


def test_forbidden_places_hold_for_both_halves(hall):
    grid = grid_over(hall.area)
    everywhere_but = np.ones(grid.shape, bool)
    everywhere_but[0, 2] = False  # (1.25, 0.25): sees only who is just setting out, or arrives
    options = {"n": 1, "model": MODEL, "grid": grid, "methods": ("exact",)}
    free = comparison.compare_methods(hall, **options)[0]
    barred = comparison.compare_methods(hall, forbidden=everywhere_but, **options)[0]
    assert 0 < barred["share"][0] < free["share"][0]


def test_one_walker_cannot_be_halved(hall):
    alone = hall.with_traces(hall.traces[hall.traces[TRACE] == "w0"])
    with pytest.raises(ArgumentError, match="one walker"):
        comparison.compare_methods(alone, n=1, model=MODEL)


def test_a_half_in_which_nobody_moves_is_refused():
    walks = pd.concat(
        [
            trace("moves", 1 + np.arange(50) / RATE, np.full(50, 2.0)),
            trace("stands", np.full(50, 3.0), np.full(50, 3.0)),
        ],
        ignore_index=True,
    )
    scene = Scene("two", walks, RATE, (0, 0, 8, 4))
    with pytest.raises(ArgumentError, match="nobody moves"):
        comparison.compare_methods(scene, n=1, model=MODEL)


# Many scenes


def test_scenes_are_compared_as_each_alone(hall, corridor):
    shares, price = comparison.compare_scenes([corridor, hall], n=3, model=MODEL, n_jobs=1)
    compared = comparison.compare_methods(corridor, n=3, model=MODEL)
    alone = comparison.compare_methods(hall, n=3, model=MODEL)
    both = pd.concat([compared[0], alone[0]], ignore_index=True)
    pd.testing.assert_frame_equal(shares, both, check_dtype=False)
    assert list(price) == ["corridor", "hall"]
    for name, seconds in (("corridor", compared[1]), ("hall", alone[1])):
        apart = seconds["exact"].mean() - seconds["votes"].mean()
        assert price[name].value == pytest.approx(apart)
        assert price[name].n == seconds["person"].nunique()
        assert price[name].low <= price[name].value <= price[name].high


def test_no_price_without_both_methods_and_no_scenes_are_refused(hall):
    shares, price = comparison.compare_scenes(
        [hall], n=1, model=MODEL, methods=("greedy",), n_jobs=1
    )
    assert price == {}
    assert shares["method"].tolist() == ["greedy"]
    with pytest.raises(ArgumentError, match="scenes is empty"):
        comparison.compare_scenes([], n=1, model=MODEL)


def test_more_cameras_fit_no_worse(corridor):
    table = comparison.shares_by_number(
        corridor, numbers=(1, 2, 3), model=MODEL, methods=("exact",)
    )
    assert table["cameras"].tolist() == [1, 2, 3]
    assert (table["fitted"].diff().dropna() >= 0).all()


def test_an_estimate_is_read_back_from_its_row(compared):
    row = compared[0].iloc[0]
    estimate = comparison.estimate_of(row)
    assert estimate == (row["share"], row["low"], row["high"], row["n"])
    assert comparison.estimate_of({**row, "low": None, "high": np.nan})[1:3] == (None, None)


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


def test_slaves_stand_where_cameras_were_chosen(corridor):
    site = prepare_site(corridor, model=MODEL)
    cameras, _ = choose_cameras(site, "greedy", 2)
    slaves = pan_tilt.slaves_at(cameras, model=MODEL, pan_limit=45.0)
    assert slaves == [
        PanTilt(x, y, field_of_view=30.0, near=0.5, reach=4.0, pan_limit=45.0)
        for x, y in zip(cameras[X], cameras[Y], strict=True)
    ]


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


def test_nobody_is_in_both_halves_even_with_several_traces(corridor):
    who = {name: f"person {number % 9}" for number, name in enumerate(corridor.walkers)}
    scene = replace(corridor, people=who)
    for half, other in (scene.split(seed=seed) for seed in range(5)):
        assert not set(half.who(half.walkers)) & set(other.who(other.walkers))
        assert len(half.walkers) + len(other.walkers) == len(scene.walkers)
    shares, seconds = comparison.compare_methods(
        scene, n=1, model=MODEL, methods=("greedy",), splits=1
    )
    assert shares["n"][0] == seconds["person"].nunique() == 9


def test_the_price_is_explained_by_what_is_taken_away():
    # Walkers on a circle of 0.8 m: the votes' place is its centre, too near for a camera that
    # sees nobody within a metre.
    turn = np.linspace(0, 2 * np.pi, 60)
    walks = pd.concat(
        pd.DataFrame(
            {
                "trace": f"w{number}",
                "frame": np.arange(60),
                "x": 2.25 + 0.8 * np.cos(turn + number),
                "y": 2.25 + 0.8 * np.sin(turn + number),
            }
        )
        for number in range(6)
    )
    scene = Scene("circle", walks.reset_index(drop=True), 10.0, (0, 0, 4.5, 4.5))
    table = comparison.explain_price(scene, n=1, model=CameraModel(pans=True))
    np.testing.assert_allclose(table["price"], table["exact"] - table["votes"])
    assert table.loc["as it is", "votes"] == 0
    assert table.loc["no blind spot near the camera", "votes"] == 1
    assert table.loc["no blind spot near the camera", "price"] == 0
    assert (table["price"] >= 0).all()


def test_a_hump_s_error_is_that_of_the_worst_best_place():
    humps = pd.DataFrame({"x": [0.0, 4.0], "y": [0.0, 3.0]})
    assert votes.hump_error(humps, [(0, 0), (4, 3)]) == 0
    assert votes.hump_error(humps, [(0, 1), (4, 5)]) == 2
    assert votes.hump_error(humps[:1], [(0, 0), (4, 3)]) == 5


def test_shifted_grids_cover_the_same_ground_by_quarters_of_a_cell():
    grid = GridMap(1.0, 2.0, 4, 6, 0.5)
    grids = votes.shifted_grids(grid)
    assert len({(one.left, one.bottom) for one in grids}) == 16
    for one in grids:
        left, bottom, right, top = one.area
        assert left <= 1.0 and bottom <= 2.0
        assert right >= grid.area[2] and top >= grid.area[3]
        assert (1.0 - left) % 0.125 == 0 and (2.0 - bottom) % 0.125 == 0
