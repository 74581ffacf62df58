"""The best choice of n cameras: by greed, by swaps, proven, by floor seen, at random.

Choosing n cameras that serve the most walker-seconds is the maximal covering location
problem.  `choose_exact` solves it and proves it, `choose_greedy` and `choose_with_swaps` come
close in no time, and `choose_area` and `choose_random` are what people do without the thesis.
All of them start from a matrix of which camera serves which target (see `coverage`).

References
----------
R. Church and C. ReVelle, "The maximal covering location problem", Papers of the Regional
Science Association 32, 1974.
G. Nemhauser, L. Wolsey and M. Fisher, "An analysis of approximations for maximizing
submodular set functions", Mathematical Programming 14, 1978.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from mcnlab.checks import HAIR, require_array, require_count, require_number
from mcnlab.errors import ArgumentError
from mcnlab.placement.exact import (
    check_numbers,
    check_served,
    check_weights,
    choose_greedily,
    maximise,
    minimise,
    quick_bound,
    search_by_swaps,
    set_up,
    strike_off,
    trim,
    value_of,
)

BLOCK = 2_000_000  # numbers in a block of draws, so that memory stays bounded


@dataclass(frozen=True, eq=False)
class Choice:
    """Chosen cameras and how good the choice is.

    Attributes
    ----------
    method : str
    cameras : ndarray of int
        Columns of the served matrix; the greedy methods' in the order of choice.
    share : float
        Of the targets' weight, served.
    cost : float
        Of the cameras together; their number, where no costs were given.
    bound : float
        No choice has a greater share.  For `fewest_for_share`: none that reaches the
        required share costs less.
    gap : float
        Between what was found and the bound, not negative.
    proven : bool
        Whether the choice is the optimum.
    """

    method: str
    cameras: np.ndarray
    share: float
    cost: float
    bound: float
    gap: float
    proven: bool


@dataclass(frozen=True, eq=False)
class Draws:
    """Cameras placed at random, many times over.

    Attributes
    ----------
    cameras : ndarray of int, shape (draws, n)
    shares : ndarray, shape (draws,)
        Of the targets' weight, served by each draw.
    """

    cameras: np.ndarray
    shares: np.ndarray

    @property
    def share(self) -> float:
        """The mean share."""
        return float(self.shares.mean())

    @property
    def spread(self) -> tuple[float, float]:
        """The share's 2.5 % and 97.5 % quantiles over the draws."""
        low, high = np.quantile(self.shares, [0.025, 0.975])
        return float(low), float(high)


def covered(served: ArrayLike, cameras: ArrayLike, *, folds: int = 1) -> np.ndarray:
    """Which targets at least `folds` of the chosen cameras serve, shape (n,)."""
    served = check_served(served)
    folds = require_count("folds", folds, low=1)
    last = served.shape[1] - 1
    remedy = f"a list of column numbers of served, 0 to {last}"
    cameras = require_array("cameras", cameras, (None,), dtype=int, low=0, high=last, remedy=remedy)
    if len(np.unique(cameras)) < len(cameras):
        raise ArgumentError("cameras name one column twice; name each once.")
    return np.count_nonzero(served[:, cameras], axis=1) >= folds


def choose_greedy(
    served: ArrayLike,
    n: int | None = None,
    *,
    weights: ArrayLike | None = None,
    folds: int = 1,
    costs: ArrayLike | None = None,
    budget: float | None = None,
) -> Choice:
    """Choose cameras one after another, each where it adds most.

    With one fold and equal costs it reaches 1 − 1/e of the optimum at least.

    Parameters
    ----------
    served : ndarray of bool, shape (n_targets, n_cameras)
        As from `square_on` or `sees`.
    n : int, optional
        Cameras to choose at most; fewer are chosen when more would add nothing.
    weights : array_like, shape (n_targets,), optional
        Not negative; all alike if left out.
    folds : int, optional
        A target counts when so many chosen cameras serve it.
    costs : array_like, shape (n_cameras,), optional
        Positive; all 1 if left out.
    budget : float, optional
        What the chosen cameras may cost together; `n` may then be left out.

    Returns
    -------
    Choice
        The bound is that of Nemhauser, Wolsey and Fisher: what is served, and the most
        that as many cameras could add.

    Raises
    ------
    ArgumentError
        When an argument has an impossible shape or value, `n` is beyond the number of
        cameras, or nothing can be served.
    """
    problem = strike_off(set_up(served, n, weights, folds, costs, budget))
    return _choice("greedy", problem, choose_greedily(problem))


def choose_with_swaps(
    served: ArrayLike,
    n: int | None = None,
    *,
    weights: ArrayLike | None = None,
    folds: int = 1,
    costs: ArrayLike | None = None,
    budget: float | None = None,
) -> Choice:
    """The greedy choice, then the best exchange of one camera for another, until none helps.

    One such search may end far from the optimum, so it is repeated, with half of the
    cameras kept or none, and the rest drawn at random (always in the same way).  Cameras
    without which as much is served are left out.

    Parameters, the result and what is raised are those of `choose_greedy`.
    """
    problem = strike_off(set_up(served, n, weights, folds, costs, budget))
    return _choice("swaps", problem, _needed(problem, search_by_swaps(problem)))


def choose_exact(
    served: ArrayLike,
    n: int | None = None,
    *,
    weights: ArrayLike | None = None,
    folds: int = 1,
    costs: ArrayLike | None = None,
    budget: float | None = None,
    time_limit: float = 60.0,
) -> Choice:
    """The best choice there is, by integer programming (Church and ReVelle, 1974).

    Maximise the weight of the targets z that are served, where a target needs `folds`
    of the cameras x that serve it, at most `n` of them and within the budget.  What
    cannot be part of a choice better than the one by swaps is struck off first, by the
    linear relaxation's reduced costs (HiGHS).  Two cameras of equal cost, chosen for one
    fold, are found by trying all pairs; a few by branch and bound with Lagrangian bounds;
    all else by HiGHS as an integer program.

    Parameters
    ----------
    served, n, weights, folds, costs, budget
        As in `choose_greedy`.
    time_limit : float, optional
        Seconds; after it the best choice so far is returned, with its gap.

    Returns
    -------
    Choice
        Every camera in it is needed: without it less would be served.  So there may be
        fewer than `n`; how few would do, `fewest_for_share` says.

    Raises
    ------
    ArgumentError
        As in `choose_greedy`.

    Examples
    --------
    Four targets, three cameras: the first two together serve all.

    >>> import numpy as np
    >>> served = np.array([[1, 0, 1], [1, 0, 0], [0, 1, 1], [0, 1, 0]], dtype=bool)
    >>> choice = choose_exact(served, 2)
    >>> sorted(choice.cameras.tolist()), choice.share, choice.proven
    ([0, 1], 1.0, True)
    """
    time_limit = require_number("time_limit", time_limit, above=0, unit="seconds")
    problem = strike_off(set_up(served, n, weights, folds, costs, budget))
    found, bound = maximise(problem, search_by_swaps(problem), time_limit)
    return _choice("exact", problem, _needed(problem, found), bound=bound)


def choose_area(
    seen: ArrayLike,
    n: int | None = None,
    *,
    weights: ArrayLike | None = None,
    costs: ArrayLike | None = None,
    budget: float | None = None,
    exact: bool = False,
) -> Choice:
    """The cameras that see the most floor: what people do without the thesis.

    Parameters
    ----------
    seen : ndarray of bool, shape (n_cells, n_cameras)
        Of `sees`, for the cells' centres.
    n, weights, costs, budget
        As in `choose_greedy`.
    exact : bool, optional
        Prove the optimum, as `choose_exact` does, instead of searching by swaps.

    Returns
    -------
    Choice
        The share is of the floor.

    Raises
    ------
    ArgumentError
        As in `choose_greedy`.
    """
    choose = choose_exact if exact else choose_with_swaps
    choice = choose(seen, n, weights=weights, costs=costs, budget=budget)
    return replace(choice, method="area")


def choose_random(
    served: ArrayLike,
    n: int,
    *,
    weights: ArrayLike | None = None,
    folds: int = 1,
    draws: int = 1000,
    seed: int = 0,
) -> Draws:
    """n cameras drawn at random, many times over.

    Parameters
    ----------
    served, n, weights, folds
        As in `choose_greedy`.
    draws : int, optional
    seed : int, optional

    Returns
    -------
    Draws

    Raises
    ------
    ArgumentError
        As in `choose_greedy`.
    """
    from scipy import sparse

    served = check_served(served)
    weights = check_weights(weights, len(served))
    n, folds = check_numbers(n, folds, served.shape[1])
    draws = require_count("draws", draws, low=1)
    rng = np.random.default_rng(require_count("seed", seed))
    matrix = sparse.csr_array(served, dtype=np.float32)
    cameras, shares = [], []
    step = max(1, BLOCK // max(served.shape))
    for start in range(0, draws, step):
        lots = rng.random((min(step, draws - start), served.shape[1]))
        drawn = np.sort(np.argpartition(lots, n - 1, axis=1)[:, :n], axis=1)
        picked = np.zeros(lots.shape, dtype=np.float32)
        np.put_along_axis(picked, drawn, 1.0, axis=1)
        shares.append(weights @ (matrix @ picked.T >= folds) / weights.sum())
        cameras.append(drawn)
    return Draws(np.concatenate(cameras), np.concatenate(shares))


def fewest_for_share(
    served: ArrayLike,
    share: float,
    *,
    weights: ArrayLike | None = None,
    folds: int = 1,
    costs: ArrayLike | None = None,
    time_limit: float = 60.0,
) -> Choice:
    """The cheapest cameras that serve a required share.

    Parameters
    ----------
    served, weights, folds, costs
        As in `choose_greedy`; without costs, the fewest cameras.
    share : float
        Of the targets' weight, in (0, 1].
    time_limit : float, optional
        Seconds; after it the cheapest choice so far is returned, with its gap.

    Returns
    -------
    Choice
        Its bound and gap are of the cost.

    Raises
    ------
    ArgumentError
        As in `choose_greedy`, and when no choice reaches the share; the message says
        what the best reachable share is.

    Examples
    --------
    >>> import numpy as np
    >>> served = np.array([[1, 0, 1], [1, 0, 0], [0, 1, 1], [0, 1, 0]], dtype=bool)
    >>> len(fewest_for_share(served, 0.5).cameras), len(fewest_for_share(served, 0.6).cameras)
    (1, 2)
    """
    share = require_number("share", share, above=0, high=1)
    time_limit = require_number("time_limit", time_limit, above=0, unit="seconds")
    number = check_served(served).shape[1]
    problem = set_up(served, number, weights, folds, costs, None)
    reachable = problem.weights.sum() / problem.total
    if share > reachable + HAIR:
        raise ArgumentError(
            f"share is {share:g}, but all {number} cameras together reach {reachable:.4f}; "
            "require that or less, or give more or other cameras."
        )
    goal = min(share, reachable) * problem.total * (1 - HAIR)
    found = trim(problem, choose_greedily(problem), goal)
    found, bound = minimise(problem, found, goal, time_limit)
    cost = float(problem.costs[found].sum() * problem.unit)
    gap = float(max(0.0, cost - bound * problem.unit))
    return Choice(
        method="fewest",
        cameras=problem.columns[found],
        share=value_of(problem, found) / problem.total,
        cost=cost,
        bound=cost - gap,
        gap=gap,
        proven=bool(gap <= HAIR * cost),
    )


def _needed(problem, chosen):
    """The chosen cameras without those that can be left out for nothing, the dearest first."""
    return trim(problem, list(chosen), value_of(problem, chosen))


def _choice(method, problem, chosen, *, bound=None):
    value = value_of(problem, chosen)
    bound = max(value, quick_bound(problem, chosen) if bound is None else bound)
    gap = (bound - value) / problem.total
    return Choice(
        method=method,
        cameras=problem.columns[chosen],
        share=value / problem.total,
        cost=float(problem.costs[chosen].sum() * problem.unit),
        bound=bound / problem.total,
        gap=gap if gap > HAIR else 0.0,
        proven=bool(gap <= HAIR),
    )
