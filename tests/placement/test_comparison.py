"""Choosing camera places from one half of the walkers, judged on the other half."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from mcnlab.cameras import visibility
from mcnlab.cameras.visibility import CameraModel
from mcnlab.datasets.scene import Scene
from mcnlab.errors import ArgumentError
from mcnlab.placement import comparison, coverage
from mcnlab.placement.choice import choose_random
from mcnlab.placement.site import (
    choose_cameras,
    grid_over,
    prepare_site,
)
from mcnlab.tables import FRAME, TRACE, X, Y

RATE = 10.0
SPLITS = 2
MODEL = CameraModel(near=0.5, reach=4.0, pans=True, square_within=15.0)


def trace(name, x, y, *, start=0):
    """One walker's places, a frame each."""
    return pd.DataFrame({TRACE: name, FRAME: start + np.arange(len(x)), X: x, Y: y})


@pytest.fixture(scope="module")
def compared(corridor):
    """Every method on the corridor, three cameras."""
    return comparison.compare_methods(corridor, n=3, model=MODEL, splits=SPLITS)


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
