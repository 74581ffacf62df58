"""How ways of choosing camera places are judged: on walks that the choice did not see.

People are split in two halves at random.  Every method chooses from one half, and the other
half tells what its cameras see square-on; then the halves change places, so that everybody is
judged by a choice that did not know him.  That is done for several splits.
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from mcnlab import control, coverage, covering, placement
from mcnlab.columns import TRACE, X, Y, check_columns
from mcnlab.errors import ArgumentError, require_choice, require_count, require_number
from mcnlab.ground import GridMap, check_area
from mcnlab.results import Estimate, mean_by_subject

METHODS = ("votes", "area", "random", "greedy", "swaps", "exact")
MOST_PLACES = 1500  # candidate places of a scene; a larger one gets larger cells
DRAWS = 200  # of cameras at random
SPLITS = 5  # of the people in halves
FAR = 1000.0  # metres; as good as endless


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


def choose_cameras(site, method, n, *, seed=0, time_limit=60.0, weights="cells"):
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
    weights : {"cells", "traces"}, optional
        Of votes, as in `placement.vote`.

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
            site.scene.traces, site.grid, n=n, forbidden=site.forbidden, weights=weights
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
    folds = require_count("folds", folds, low=1)
    if len(cameras) == 0:
        return np.zeros(len(targets), bool)
    served = coverage.square_on(targets, cameras, model, walls=walls)
    return np.count_nonzero(served, axis=1) >= folds


def compare_methods(
    scene, *, n, model, grid=None, methods=METHODS, forbidden=None, splits=SPLITS, seed=0
):
    """Let every method choose from one half of the people, and judge it on the other.

    Parameters
    ----------
    scene : Scene
    n : int
        Cameras.
    model : coverage.CameraModel
    grid : GridMap, optional
    methods : sequence of str, optional
    forbidden : ndarray of bool, optional
    splits : int, optional
        How often the people are split anew; a person's score is the mean over them.
    seed : int, optional
        Of the first split and of the random draws.

    Returns
    -------
    shares : pandas.DataFrame
        One row a method: ``scene, method``; ``share, low, high, n``, of the held-out
        walker-seconds seen square-on, with a bootstrap interval over the `n` people (the
        places are not chosen anew in each draw); ``fitted``, the share on the walks it
        chose from; ``gap``, the largest optimality gap (0 but for "exact").
    seconds : pandas.DataFrame
        One row a held-out walker-second and split: ``person, split, half`` and a column
        of shares a method (0 or 1; for random draws the mean over the draws).

    Raises
    ------
    ArgumentError
        When there is one person only, nobody moves in one half, or no method is named.
    """
    if len(methods) == 0:
        raise ArgumentError("methods is empty; pass at least one.")
    splits = require_count("splits", splits, low=1)
    grid = grid_over(scene.area) if grid is None else grid
    fitted, gap = {method: [] for method in methods}, dict.fromkeys(methods, 0.0)
    held = []
    for split in range(splits):
        halves = scene.split(seed=seed + split)
        sites = [prepare_site(one, model=model, grid=grid, forbidden=forbidden) for one in halves]
        for half, (site, other) in enumerate(zip(sites, sites[::-1], strict=True)):
            person = scene.who(other.targets[TRACE])
            table = pd.DataFrame({"person": person, "split": split, "half": half})
            for method in methods:
                table[method], mean, loose = _choose_and_judge(site, other, method, n, seed)
                fitted[method].append(mean)
                gap[method] = max(gap[method], loose)
            held.append(table)
    seconds = pd.concat(held, ignore_index=True)
    rows = []
    for method in methods:
        share = mean_by_subject(seconds[method], seconds["person"], seed=seed)
        mean = float(np.mean(fitted[method]))
        names = {"scene": scene.name, "method": method}
        rows.append({**names, **share._asdict(), "fitted": mean, "gap": gap[method]})
    return pd.DataFrame(rows).rename(columns={"value": "share"}), seconds


def _choose_and_judge(site, other, method, n, seed):
    """Shares of another site's walker-seconds, the mean of its own, and the optimality gap."""
    if method == "random":
        draws = covering.choose_random(site.served, n, draws=DRAWS, seed=seed)
        seen = [covering.covered(other.served, row) for row in draws.cameras]
        return np.mean(seen, axis=0), draws.share, 0.0
    cameras, choice = choose_cameras(site, method, n, seed=seed)
    own, others = (
        judge_cameras(cameras, one.targets, model=site.model, walls=site.scene.walls)
        for one in (site, other)
    )
    gap = choice.gap if method == "exact" else 0.0
    return others.astype(float), float(own.mean()), gap


def compare_scenes(scenes, *, n, model, methods=METHODS, most=MOST_PLACES, seed=0, n_jobs=-1):
    """`compare_methods` on every scene, and the price of voting.

    Parameters
    ----------
    scenes : sequence of Scene
    n, model, methods, seed
        As in `compare_methods`.
    most : int, optional
        Candidate places of a scene.
    n_jobs : int, optional
        Scenes at a time, as joblib counts.

    Returns
    -------
    shares : pandas.DataFrame
        As in `compare_methods`, the scenes one after another.
    price : dict of str to Estimate
        Scene → what the exact choice sees more than the voted one, as a share of the
        held-out walker-seconds; the interval is over people.

    Raises
    ------
    ArgumentError
        As in `compare_methods`, and when there is no scene.
    """
    from joblib import Parallel, delayed

    if len(scenes) == 0:
        raise ArgumentError("scenes is empty; pass at least one.")
    options = {"n": n, "model": model, "methods": methods, "seed": seed}
    found = Parallel(n_jobs=n_jobs)(
        delayed(compare_methods)(scene, grid=grid_over(scene.area, most=most), **options)
        for scene in scenes
    )
    price = {}
    if {"exact", "votes"} <= set(methods):
        for scene, (_, seconds) in zip(scenes, found, strict=True):
            more = seconds["exact"] - seconds["votes"]
            price[scene.name] = mean_by_subject(more, seconds["person"], seed=seed)
    return pd.concat([shares for shares, _ in found], ignore_index=True), price


def explain_price(scene, *, n, model, grid=None):
    """What the price of voting is made of: take away one difficulty after another.

    Parameters
    ----------
    scene : Scene
    n, model, grid
        As in `compare_methods`.

    Returns
    -------
    pandas.DataFrame
        One row a change: ``votes, exact, price``, shares of the walks they chose from.
    """
    open_scene = replace(scene, walls=None)
    changes = {
        "as it is": (scene, model, {}),
        "no blind spot near the camera": (scene, replace(model, near=0.0), {}),
        "endless reach": (scene, replace(model, reach=FAR), {}),
        "walls block no sight": (open_scene, model, {}),
        "a vote a walk, not a cell": (scene, model, {"weights": "traces"}),
    }
    rows = {}
    for name, (place, changed, options) in changes.items():
        site = prepare_site(place, model=changed, grid=grid)
        row = {}
        for method in ("votes", "exact"):
            given = options if method == "votes" else {}
            cameras, _ = choose_cameras(site, method, n, **given)
            judged = judge_cameras(cameras, site.targets, model=changed, walls=place.walls)
            row[method] = judged.mean()
        rows[name] = {**row, "price": row["exact"] - row["votes"]}
    return pd.DataFrame.from_dict(rows, orient="index")


def hump_error(humps, best_places):
    """The farthest that any of the best places is from its nearest hump, metres."""
    apart = humps[[X, Y]].to_numpy()[:, None] - np.asarray(best_places, float)[None]
    return float(np.linalg.norm(apart, axis=2).min(axis=0).max())


def shifted_grids(grid, *, steps=4):
    """The same cells, shifted by parts of a cell in x and y: steps² grids that cover it all."""
    steps = require_count("steps", steps, low=1)
    return [
        GridMap(
            grid.left - across * grid.cell / steps,
            grid.bottom - up * grid.cell / steps,
            grid.rows + (up > 0),
            grid.columns + (across > 0),
            grid.cell,
        )
        for across in range(steps)
        for up in range(steps)
    ]


def shares_by_number(
    scene, *, numbers, model, grid=None, methods=("votes", "greedy", "exact"), seed=0, n_jobs=-1
):
    """Held-out shares as the number of cameras grows, one row a number and method; one split."""
    from joblib import Parallel, delayed

    options = {"model": model, "grid": grid, "methods": methods, "splits": 1, "seed": seed}
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
    check_columns(cameras, (X, Y), argument="cameras")
    sees = {"near": model.near, "reach": model.reach}
    return [
        control.PanTilt(x, y, field_of_view=field_of_view, pan_limit=pan_limit, **sees)
        for x, y in cameras[[X, Y]].itertuples(index=False)
    ]
