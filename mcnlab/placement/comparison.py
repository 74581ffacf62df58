"""How ways of choosing camera places are judged: on walks that the choice did not see.

People are split in two halves at random.  Every method chooses from one half, and the other
half tells what its cameras see square-on; then the halves change places, so that everybody is
judged by a choice that did not know him.  That is done for several splits.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mcnlab.cameras.floor import GridMap
from mcnlab.cameras.visibility import CameraModel
from mcnlab.checks import require_count
from mcnlab.datasets.scene import Scene
from mcnlab.errors import ArgumentError
from mcnlab.placement.choice import choose_random, covered
from mcnlab.placement.site import (
    METHODS,
    MOST_PLACES,
    choose_cameras,
    grid_over,
    judge_cameras,
    prepare_site,
)
from mcnlab.placement.votes import VoteRules
from mcnlab.statistics import Estimate, mean_by_subject
from mcnlab.tables import TRACE

DRAWS = 200  # of cameras at random
SPLITS = 5  # of the people in halves
FAR = 1000.0  # metres; as good as endless


def compare_methods(
    scene: Scene,
    *,
    n: int,
    model: CameraModel,
    grid: GridMap | None = None,
    methods: Sequence[str] = METHODS,
    forbidden: ArrayLike | None = None,
    splits: int = SPLITS,
    seed: int = 0,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Let every method choose from one half of the people, and judge it on the other.

    Parameters
    ----------
    scene : Scene
    n : int
        Cameras.
    model : CameraModel
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
        draws = choose_random(site.served, n, draws=DRAWS, seed=seed)
        seen = [covered(other.served, row) for row in draws.cameras]
        return np.mean(seen, axis=0), draws.share, 0.0
    cameras, choice = choose_cameras(site, method, n, seed=seed)
    own, others = (
        judge_cameras(cameras, one.targets, model=site.model, walls=site.scene.walls)
        for one in (site, other)
    )
    gap = choice.gap if method == "exact" else 0.0
    return others.astype(float), float(own.mean()), gap


def compare_scenes(
    scenes: Sequence[Scene],
    *,
    n: int,
    model: CameraModel,
    methods: Sequence[str] = METHODS,
    most: int = MOST_PLACES,
    seed: int = 0,
    n_jobs: int = -1,
) -> tuple[pd.DataFrame, dict[str, Estimate]]:
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

    Examples
    --------
    >>> from mcnlab.cameras import CameraModel
    >>> from mcnlab.synthetic.corridor import make_corridor
    >>> scene = make_corridor(walkers=6)
    >>> model, methods = CameraModel(pans=True), ("votes", "greedy")
    >>> shares, price = compare_scenes([scene], n=1, model=model, methods=methods, n_jobs=1)
    >>> shares["method"].tolist(), price
    (['votes', 'greedy'], {})
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


def explain_price(
    scene: Scene, *, n: int, model: CameraModel, grid: GridMap | None = None
) -> pd.DataFrame:
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
        "a vote a walk, not a cell": (scene, model, {"rules": VoteRules(weights="traces")}),
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


def shares_by_number(
    scene: Scene,
    *,
    numbers: Sequence[int],
    model: CameraModel,
    grid: GridMap | None = None,
    methods: Sequence[str] = ("votes", "greedy", "exact"),
    seed: int = 0,
    n_jobs: int = -1,
) -> pd.DataFrame:
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


def estimate_of(row: pd.Series) -> Estimate:
    """The estimate in one row of shares."""
    low, high = (None if pd.isna(row[key]) else row[key] for key in ("low", "high"))
    return Estimate(row["share"], low, high, int(row["n"]))
