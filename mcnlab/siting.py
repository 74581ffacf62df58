"""How ways of choosing camera places are judged: on walks that the choice did not see.

Walkers are split in two halves at random.  Every method chooses from one half, and the
other half tells what its cameras see square-on; then the halves change places, so that
every walker is judged once, by a choice that did not know him.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from mcnlab import control, coverage, covering, placement
from mcnlab.columns import TRACE, X, Y
from mcnlab.errors import ArgumentError, require_choice, require_count, require_number
from mcnlab.ground import GridMap, check_area
from mcnlab.results import Estimate, mean_by_subject

METHODS = ("votes", "area", "random", "greedy", "swaps", "exact")
MOST_PLACES = 1500  # candidate places of a scene; a larger one gets larger cells
DRAWS = 200  # of cameras at random


@dataclass(frozen=True, eq=False)
class Site:
    """One scene made ready for choosing: what some walkers ask, and where cameras may stand.

    Attributes
    ----------
    scene : Scene
        The walkers that the choice may see.
    grid : GridMap
        Of the votes and of the camera places.
    model : coverage.CameraModel
    cameras : pandas.DataFrame
        The candidates.
    targets : pandas.DataFrame
        The walker-seconds.
    served : ndarray of bool, shape (targets, cameras)
    headings : int
        How many a camera that does not pan is offered.
    forbidden : ndarray of bool, shape (rows, columns)
    """

    scene: object
    grid: GridMap
    model: coverage.CameraModel
    cameras: pd.DataFrame
    targets: pd.DataFrame
    served: np.ndarray
    headings: int
    forbidden: np.ndarray


def grid_over(area, *, cell=0.5, most=MOST_PLACES):
    """A grid of at most `most` cells: of `cell` metres, or of whole decimetres beyond it."""
    left, bottom, right, top = check_area(area)
    cell = require_number("cell", cell, above=0, unit="metres")
    most = require_count("most", most, low=1)
    # No smaller cells can do; from there on up in small steps.
    fit = np.sqrt((right - left) * (top - bottom) / most)
    if cell < fit:
        cell = np.ceil(10 * fit) / 10
    while True:
        grid = GridMap.over(area, cell=float(cell))
        if grid.rows * grid.columns <= most:
            return grid
        cell = np.round(cell + max(0.1, 0.02 * cell), 1)


def prepare_site(scene, *, model, grid=None, headings=8, forbidden=None):
    """Lay out candidates and walker-seconds of a scene.

    Parameters
    ----------
    scene : Scene
    model : coverage.CameraModel
    grid : GridMap, optional
        Default: `grid_over` the scene's area.
    headings : int, optional
        Of cameras that do not pan.
    forbidden : ndarray of bool, shape (rows, columns), optional
        Besides what is no floor.

    Returns
    -------
    Site
    """
    grid = grid_over(scene.area) if grid is None else grid
    barred = no_floor(scene, grid)
    if forbidden is not None:
        if np.shape(forbidden) != grid.shape:
            raise ArgumentError(
                f"forbidden has the shape {np.shape(forbidden)}, the grid {grid.shape}; pass one "
                "flag a cell."
            )
        barred = barred | np.asarray(forbidden, dtype=bool)
    forbidden = barred
    cameras = coverage.candidates(grid, model=model, headings=headings, forbidden=forbidden)
    targets = coverage.walker_seconds(scene)
    served = coverage.square_on(targets, cameras, model, walls=scene.walls)
    return Site(scene, grid, model, cameras, targets, served, headings, forbidden)


def no_floor(scene, grid):
    """Cells whose centre lies in one of the scene's blocks, shape (rows, columns)."""
    x, y = np.meshgrid(*grid.centres())
    left, bottom, right, top = scene.blocks.T[:, :, None, None]
    return ((x > left) & (x < right) & (y > bottom) & (y < top)).any(axis=0)


def choose_cameras(site, method, n, *, seed=0, time_limit=60.0):
    """Choose n cameras of a site by one method.

    Parameters
    ----------
    site : Site
    method : str
        One of `METHODS`: the thesis's votes; most ground seen, and cameras to spare as far
        from the others as can be; at random; one after
        another where each adds most; that, with swaps; the proven optimum.
    n : int
    seed : int, optional
        Of the random draw.
    time_limit : float, optional
        Seconds for the proof of "exact"; after it the best so far is returned.

    Returns
    -------
    cameras : pandas.DataFrame
        n rows of candidates or, for votes, aimed cameras at the voted places.
    choice : covering.Choice or None
        None for votes, ground and random draws, which do not look at walker-seconds.
    """
    require_choice("method", method, METHODS)
    n = require_count("n", n, low=1)
    if method == "votes":
        voted = placement.place_by_votes(
            site.scene.traces, site.grid, n=n, forbidden=site.forbidden
        ).places
        places = voted[[X, Y]].to_numpy()
        aimed = coverage.aim_cameras(
            places, site.targets, site.model, headings=site.headings, walls=site.scene.walls
        )
        return aimed, None
    if method == "area":
        ground = np.stack(np.meshgrid(*site.grid.centres()), axis=-1)
        ground = ground[~no_floor(site.scene, site.grid)]
        seen = coverage.sees(ground, site.cameras, site.model, walls=site.scene.walls)
        chosen = list(covering.choose_area(seen, n).cameras)
        return site.cameras.iloc[_spread(site.cameras, seen, chosen, n)], None
    if method == "random":
        drawn = covering.choose_random(site.served, n, draws=1, seed=seed).cameras[0]
        return site.cameras.iloc[drawn], None
    if method == "exact":
        choice = covering.choose_exact(site.served, n, time_limit=time_limit)
    else:
        choose = {"greedy": covering.choose_greedy, "swaps": covering.choose_with_swaps}[method]
        choice = choose(site.served, n)
    return site.cameras.iloc[choice.cameras], choice


def _spread(cameras, seen, chosen, n):
    """Fill up to n cameras where none adds ground: far from the others, as one takes corners."""
    places = cameras[[X, Y]].to_numpy()
    while len(chosen) < n:
        apart = np.linalg.norm(places[:, None] - places[chosen], axis=2).min(axis=1)
        apart[chosen] = -1.0
        farthest = np.flatnonzero(apart >= apart.max() * (1 - 1e-9))
        chosen.append(int(farthest[seen[:, farthest].sum(axis=0).argmax()]))
    return chosen


def judge_cameras(cameras, targets, *, model, walls=None, folds=1):
    """Which walker-seconds a set of cameras sees square-on, shape (targets,)."""
    if len(cameras) == 0:
        return np.zeros(len(targets), bool)
    served = coverage.square_on(targets, cameras, model, walls=walls)
    return np.count_nonzero(served, axis=1) >= folds


def compare_methods(scene, *, n, model, grid=None, methods=METHODS, forbidden=None, seed=0):
    """Let every method choose from one half of the walkers, and judge it on the other.

    Parameters
    ----------
    scene : Scene
    n : int
        Cameras.
    model : coverage.CameraModel
    grid : GridMap, optional
    methods : sequence of str, optional
    forbidden : ndarray of bool, optional
    seed : int, optional
        Of the split and of the random draws.

    Returns
    -------
    shares : pandas.DataFrame
        One row a method: ``scene, method``; ``share, low, high, n``, of the held-out
        walker-seconds seen square-on, with a bootstrap interval over the `n` walkers;
        ``fitted``, the share on the walks it chose from, mean of the halves; ``gap``, the
        larger of the two optimality gaps (exact only).
    seconds : pandas.DataFrame
        One row a held-out walker-second: ``trace, half`` and a column of shares a method
        (0 or 1; for random draws the mean over the draws).

    Raises
    ------
    ArgumentError
        When there is one walker only, or nobody moves in one half.
    """
    grid = grid_over(scene.area) if grid is None else grid
    halves = scene.split(seed=seed)
    sites = [prepare_site(half, model=model, grid=grid, forbidden=forbidden) for half in halves]
    held, fitted, gaps = [], {method: [] for method in methods}, {}
    for number, (site, other) in enumerate(zip(sites, sites[::-1], strict=True)):
        table = pd.DataFrame({TRACE: other.targets[TRACE].to_numpy(), "half": number})
        for method in methods:
            if method == "random":
                draws = covering.choose_random(site.served, n, draws=DRAWS, seed=seed)
                seen = np.stack([covering.covered(other.served, row) for row in draws.cameras])
                table[method] = seen.mean(axis=0)
                fitted[method].append(draws.share)
                continue
            cameras, choice = choose_cameras(site, method, n, seed=seed)
            judge = {"model": model, "walls": scene.walls}
            table[method] = judge_cameras(cameras, other.targets, **judge).astype(float)
            fitted[method].append(judge_cameras(cameras, site.targets, **judge).mean())
            if method == "exact":
                gaps[method] = max(gaps.get(method, 0.0), choice.gap)
        held.append(table)
    seconds = pd.concat(held, ignore_index=True)
    rows = []
    for method in methods:
        share = mean_by_subject(seconds[method], seconds[TRACE], seed=seed)
        rows.append(
            {
                "scene": scene.name,
                "method": method,
                **share._asdict(),
                "fitted": float(np.mean(fitted[method])),
                "gap": gaps.get(method),
            }
        )
    return pd.DataFrame(rows).rename(columns={"value": "share"}), seconds


def compare_scenes(scenes, *, n, model, methods=METHODS, seed=0, n_jobs=-1):
    """`compare_methods` on every scene, and the price of voting.

    Parameters
    ----------
    scenes : sequence of Scene
    n, model, methods, seed
        As in `compare_methods`.
    n_jobs : int, optional
        Scenes at a time, as joblib counts.

    Returns
    -------
    shares : pandas.DataFrame
        As in `compare_methods`, the scenes one after another.
    price : dict of str to Estimate
        Scene → what the exact choice sees more than the voted one, as a share of the
        held-out walker-seconds; the interval is over walkers.
    """
    from joblib import Parallel, delayed

    if len(scenes) == 0:
        raise ArgumentError("scenes is empty; pass at least one.")
    options = {"n": n, "model": model, "methods": methods, "seed": seed}
    found = Parallel(n_jobs=n_jobs)(delayed(compare_methods)(scene, **options) for scene in scenes)
    price = {}
    if {"exact", "votes"} <= set(methods):
        for scene, (_, seconds) in zip(scenes, found, strict=True):
            more = seconds["exact"] - seconds["votes"]
            price[scene.name] = mean_by_subject(more, seconds[TRACE], seed=seed)
    return pd.concat([shares for shares, _ in found], ignore_index=True), price


def shares_by_number(
    scene, *, numbers, model, grid=None, methods=("votes", "greedy", "exact"), n_jobs=-1
):
    """Held-out shares as the number of cameras grows, one row a number and method."""
    from joblib import Parallel, delayed

    options = {"model": model, "grid": grid, "methods": methods}
    if len(numbers) == 0:
        raise ArgumentError("numbers is empty; pass at least one number of cameras.")
    found = Parallel(n_jobs=n_jobs)(
        delayed(compare_methods)(scene, n=n, **options) for n in numbers
    )
    tables = [shares.assign(cameras=n) for n, (shares, _) in zip(numbers, found, strict=True)]
    return pd.concat(tables, ignore_index=True)


def estimate_of(row):
    """The estimate in one row of shares."""
    low, high = (None if pd.isna(row[key]) else row[key] for key in ("low", "high"))
    return Estimate(row["share"], low, high, int(row["n"]))


def mean_price(price):
    """The mean price over scenes, with a bootstrap interval that draws scenes."""
    return mean_by_subject([one.value for one in price.values()], list(price))


def plan_of(site, choice, *, folds=1):
    """What a choice comes to on its own site.

    Returns
    -------
    cameras : pandas.DataFrame
    served : ndarray of bool, shape (targets,)
    forbidden : ndarray of bool, shape (rows, columns)
    """
    served = covering.covered(site.served, choice.cameras, folds=folds)
    return site.cameras.iloc[choice.cameras], served, site.forbidden


def away_from_walls(scene, grid, *, within=0.5):
    """Cells whose centre is farther than `within` metres from every wall, shape (rows, columns).

    Raises
    ------
    ArgumentError
        When the scene has no walls.
    """
    if len(scene.walls) == 0:
        raise ArgumentError(f"scene {scene.name!r} has no walls; forbid places in another way.")
    centres = np.stack(np.meshgrid(*grid.centres()), axis=-1)[..., None, :]
    start, along = scene.walls[:, 0], scene.walls[:, 1] - scene.walls[:, 0]
    part = ((centres - start) * along).sum(axis=-1) / np.maximum((along**2).sum(axis=-1), 1e-12)
    nearest = start + np.clip(part, 0, 1)[..., None] * along
    return np.linalg.norm(centres - nearest, axis=-1).min(axis=-1) > within


def slaves_at(cameras, *, model, field_of_view=30.0, pan_limit=90.0):
    """Panning cameras at chosen places, for `control.simulate`.

    Parameters
    ----------
    cameras : pandas.DataFrame
        ``x, y``.
    model : coverage.CameraModel
        How near and how far they see.
    field_of_view : float, optional
        Degrees.
    pan_limit : float, optional
        Degrees a second.
    """
    sees = {"near": model.near, "reach": model.reach}
    return [
        control.PanTilt(x, y, field_of_view=field_of_view, pan_limit=pan_limit, **sees)
        for x, y in cameras[[X, Y]].itertuples(index=False)
    ]
