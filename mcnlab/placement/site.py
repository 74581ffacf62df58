"""A site: a scene made ready for choosing cameras, and the choice by every method."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mcnlab.cameras import visibility
from mcnlab.cameras.floor import GridMap, check_area
from mcnlab.checks import require_array, require_choice, require_count, require_number
from mcnlab.datasets.scene import Scene
from mcnlab.errors import ArgumentError
from mcnlab.placement import coverage, votes
from mcnlab.placement.choice import (
    Choice,
    choose_area,
    choose_exact,
    choose_greedy,
    choose_random,
    choose_with_swaps,
    covered,
)
from mcnlab.tables import X, Y

METHODS = ("votes", "area", "random", "greedy", "swaps", "exact")
MOST_PLACES = 1500  # candidate places of a scene; a larger one gets larger cells


@dataclass(frozen=True, eq=False)
class Site:
    """One scene made ready for choosing: what some walkers ask, and where cameras may stand.

    Attributes
    ----------
    scene : Scene
        The walkers that the choice may see.
    grid : GridMap
        Of the votes and of the camera places.
    model : CameraModel
    cameras : pandas.DataFrame
        The candidates.
    targets : pandas.DataFrame
        The walker-seconds.
    served : ndarray of bool, shape (targets, cameras)
    headings : int
        How many a camera that does not pan is offered.
    forbidden : ndarray of bool, shape (rows, columns)
    """

    scene: Scene
    grid: GridMap
    model: visibility.CameraModel
    cameras: pd.DataFrame
    targets: pd.DataFrame
    served: np.ndarray
    headings: int
    forbidden: np.ndarray


def grid_over(area: ArrayLike, *, cell: float = 0.5, most: int = MOST_PLACES) -> GridMap:
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


def prepare_site(
    scene: Scene,
    *,
    model: visibility.CameraModel,
    grid: GridMap | None = None,
    headings: int = 8,
    forbidden: ArrayLike | None = None,
) -> Site:
    """Lay out candidates and walker-seconds of a scene.

    Parameters
    ----------
    scene : Scene
    model : CameraModel
    grid : GridMap, optional
        Default: `grid_over` the scene's area.
    headings : int, optional
        Of cameras that do not pan.
    forbidden : ndarray of bool, shape (rows, columns), optional
        Besides what is no floor.

    Returns
    -------
    Site

    Examples
    --------
    >>> from mcnlab.cameras import CameraModel
    >>> from mcnlab.synthetic.corridor import make_corridor
    >>> site = prepare_site(make_corridor(walkers=5), model=CameraModel(pans=True))
    >>> site.served.shape == (len(site.targets), len(site.cameras))
    True
    """
    grid = grid_over(scene.area) if grid is None else grid
    barred = no_floor(scene, grid)
    if forbidden is not None:
        barred = barred | require_array("forbidden", forbidden, grid.shape, dtype=bool)
    cameras = coverage.candidates(grid, model=model, headings=headings, forbidden=barred)
    targets = coverage.walker_seconds(scene)
    served = visibility.square_on(targets, cameras, model, walls=scene.walls)
    return Site(scene, grid, model, cameras, targets, served, headings, barred)


def no_floor(scene: Scene, grid: GridMap) -> np.ndarray:
    """Cells whose centre lies in one of the scene's blocks, shape (rows, columns)."""
    x, y = np.meshgrid(*grid.centres())
    left, bottom, right, top = scene.blocks.T[:, :, None, None]
    return ((x > left) & (x < right) & (y > bottom) & (y < top)).any(axis=0)


def choose_cameras(
    site: Site,
    method: str,
    n: int,
    *,
    seed: int = 0,
    time_limit: float = 60.0,
    rules: votes.VoteRules = votes.RULES,
) -> tuple[pd.DataFrame, Choice | None]:
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
    rules : votes.VoteRules, optional
        Of the votes.

    Returns
    -------
    cameras : pandas.DataFrame
        n rows of candidates or, for votes, aimed cameras at the voted places.
    choice : choice.Choice or None
        None for votes, ground and random draws, which do not look at walker-seconds.

    Examples
    --------
    >>> from mcnlab.cameras import CameraModel
    >>> from mcnlab.synthetic.corridor import make_corridor
    >>> site = prepare_site(make_corridor(walkers=5), model=CameraModel(pans=True))
    >>> cameras, choice = choose_cameras(site, "greedy", 2)
    >>> len(cameras), choice.method
    (2, 'greedy')
    """
    require_choice("method", method, METHODS)
    n = require_count("n", n, low=1)
    if method == "votes":
        voted = votes.place_by_votes(
            site.scene.traces, site.grid, n=n, rules=rules, forbidden=site.forbidden
        )
        aimed = coverage.aim_cameras(
            voted.places[[X, Y]].to_numpy(),
            site.targets,
            site.model,
            headings=site.headings,
            walls=site.scene.walls,
        )
        return aimed, None
    if method == "area":
        ground = np.stack(np.meshgrid(*site.grid.centres()), axis=-1)
        ground = ground[~no_floor(site.scene, site.grid)]
        seen = visibility.sees(ground, site.cameras, site.model, walls=site.scene.walls)
        chosen = list(choose_area(seen, n).cameras)
        return site.cameras.iloc[_spread(site.cameras, seen, chosen, n)], None
    if method == "random":
        drawn = choose_random(site.served, n, draws=1, seed=seed).cameras[0]
        return site.cameras.iloc[drawn], None
    if method == "exact":
        choice = choose_exact(site.served, n, time_limit=time_limit)
    else:
        choose = {"greedy": choose_greedy, "swaps": choose_with_swaps}[method]
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


def judge_cameras(
    cameras: pd.DataFrame,
    targets: pd.DataFrame,
    *,
    model: visibility.CameraModel,
    walls: ArrayLike | None = None,
    folds: int = 1,
) -> np.ndarray:
    """Which walker-seconds a set of cameras sees square-on, shape (targets,)."""
    folds = require_count("folds", folds, low=1)
    if len(cameras) == 0:
        return np.zeros(len(targets), bool)
    served = visibility.square_on(targets, cameras, model, walls=walls)
    return np.count_nonzero(served, axis=1) >= folds


def plan_of(
    site: Site, choice: Choice, *, folds: int = 1
) -> tuple[pd.DataFrame, np.ndarray, np.ndarray]:
    """What a choice comes to on its own site.

    Returns
    -------
    cameras : pandas.DataFrame
    served : ndarray of bool, shape (targets,)
    forbidden : ndarray of bool, shape (rows, columns)
    """
    served = covered(site.served, choice.cameras, folds=folds)
    return site.cameras.iloc[choice.cameras], served, site.forbidden


def away_from_walls(scene: Scene, grid: GridMap, *, within: float = 0.5) -> np.ndarray:
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
