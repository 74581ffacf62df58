"""The solvers behind `choice`: what may be struck off, search by swaps, and the proof.

What no optimum needs is struck off first: targets that the same cameras serve become one,
cameras that serve a part of what another serves go.  A search by swaps gives a choice, the
linear relaxation (HiGHS) a bound, and its reduced costs strike off what cannot be in a better
choice.  Two cameras are then found by trying all pairs, a few by branch and bound with
Lagrangian bounds (see `branch_and_bound`), all else by HiGHS.

References
----------
G. Cornuéjols, M. Fisher and G. Nemhauser, "Location of bank accounts to optimize float",
Management Science 23, 1977: Lagrangian bounds for location problems.
"""

from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mcnlab.checks import HAIR, require_array, require_count, require_number
from mcnlab.errors import ArgumentError
from mcnlab.placement.branch_and_bound import best_pair, branch

FEW = 8  # cameras; up to so many, branch and bound of our own is faster than HiGHS
RESTARTS = 20  # of the search by swaps


class Problem(NamedTuple):
    """A choice to be made: rows of targets, columns of cameras."""

    served: Any  # sparse (rows, columns), float
    serves: np.ndarray  # (columns, rows), the same as booleans
    weights: np.ndarray  # (rows,)
    costs: np.ndarray  # (columns,)
    columns: np.ndarray  # (columns,) the cameras' numbers
    total: float  # weight of all targets, served or not
    folds: int
    most: int  # cameras
    budget: float  # may be inf
    unit: float  # what a cost of one stands for


def set_up(
    served: ArrayLike,
    n: int | None,
    weights: ArrayLike | None,
    folds: int,
    costs: ArrayLike | None,
    budget: float | None,
) -> Problem:
    """The choice as numbers, or why there is none."""
    served = check_served(served)
    rows, columns = served.shape
    weights = check_weights(weights, rows)
    if weights.max() > 1e4 or (weights != np.round(weights)).any():
        weights = weights / weights.max()  # solvers' tolerances are absolute
    total = float(weights.sum())
    if n is None and budget is None:
        raise ArgumentError("n is None; pass how many cameras to choose, or a budget with costs.")
    most, folds = check_numbers(columns if n is None else n, folds, columns)
    costs = (
        np.ones(columns) if costs is None else require_array("costs", costs, (columns,), above=0)
    )
    unit = float(costs.max())  # solvers' tolerances are absolute
    costs = costs / unit
    if budget is None:
        limit = np.inf
    else:
        limit = require_number("budget", budget, above=0) / unit * (1 + HAIR)
        if costs.min() > limit:
            raise ArgumentError(
                f"budget is {budget!r}, less than any camera's {costs.min() * unit:g}."
            )
        most = min(most, int((np.cumsum(np.sort(costs)) <= limit).sum()))
    # Targets that no choice can serve are out; those served by the same cameras are one.
    affordable = np.flatnonzero(costs <= limit)
    served = served[:, affordable]
    keep = (np.count_nonzero(served, axis=1) >= folds) & (weights > 0)
    if not keep.any() or folds > most:
        raise ArgumentError(
            f"served: no target can be served by {folds} of the cameras; give them more reach or "
            "other places, or lower folds."
        )
    needs = served[keep].T, weights[keep], costs[affordable], affordable
    return _merge(Problem(None, *needs, total, folds, most, limit, unit))[0]


def _merge(problem, price=None):
    """Targets that the same cameras serve made one; their prices are added up too."""
    from scipy import sparse

    packed = np.ascontiguousarray(np.packbits(problem.serves.T, axis=1))
    _, first, group = np.unique(
        packed.view(f"V{packed.shape[1]}").ravel(), return_index=True, return_inverse=True
    )
    weights = np.bincount(group, problem.weights)
    serves = np.ascontiguousarray(problem.serves[:, first])
    merged = problem._replace(
        served=sparse.csr_array(serves.T, dtype=float), serves=serves, weights=weights
    )
    if price is not None:
        price = np.clip(np.bincount(group, price), 0.0, weights)
    return merged, price


def strike_off(problem: Problem) -> Problem:
    """Without cameras that others can stand in for: the optimum stays the same.

    A camera is dominated by one that serves the same targets, costs no more, and is not
    dominated itself.  Where targets need several cameras, as many must dominate it as
    can be chosen: then one of them is always free to stand in.
    """
    served = problem.served
    size = np.asarray(served.sum(axis=0)).ravel()
    both = (served.T @ served).toarray() if served.nnz < 0.02 * np.prod(served.shape) else None
    if both is None:
        dense = problem.serves.astype(np.float32)
        both = dense @ dense.T  # whole numbers, exact
    within = both == size[:, None]  # column i serves nothing that column j does not
    within &= problem.costs[:, None] >= problem.costs
    # Of cameras alike in everything, the first stays.
    order = np.arange(len(size))
    alike = within & within.T
    within &= ~alike | (order[:, None] > order)
    np.fill_diagonal(within, False)
    rivals = within.sum(axis=1)
    keep = rivals < (1 if problem.folds == 1 else problem.most)
    keep &= size > 0
    return problem._replace(
        served=served[:, np.flatnonzero(keep)],
        serves=problem.serves[keep],
        costs=problem.costs[keep],
        columns=problem.columns[keep],
    )


def _counts(problem, chosen):
    return np.count_nonzero(problem.serves[chosen], axis=0)


def value_of(problem: Problem, chosen: list[int]) -> float:
    """The weight of the targets that the chosen cameras serve."""
    return float(problem.weights[_counts(problem, chosen) >= problem.folds].sum())


def choose_greedily(problem: Problem) -> list[int]:
    """The best of a few greedy runs; with one fold and equal costs they are one.

    They differ in counting a camera's gain or its gain a cost, and in what a target is worth
    while it still lacks some of its folds.
    """
    powers = (1.0,) if problem.folds == 1 else (1.0, 3.0)
    prices = [np.ones(len(problem.costs))]
    if np.ptp(problem.costs) > 0 and np.isfinite(problem.budget):
        prices.append(problem.costs)
    runs = [_greedy_run(problem, power, price) for price in prices for power in powers]
    return max(runs, key=lambda chosen: value_of(problem, chosen))


def _greedy_run(problem, power, price):
    counts = np.zeros(len(problem.weights))
    chosen, spent = [], 0.0
    while len(chosen) < problem.most:
        now, then = (
            (np.minimum(number, problem.folds) / problem.folds) ** power
            for number in (counts, counts + 1)
        )
        gain = problem.served.T @ (problem.weights * (then - now)) / price
        gain[chosen] = 0.0
        gain[spent + problem.costs > problem.budget] = 0.0
        best = int(gain.argmax())
        if gain[best] <= HAIR * problem.weights.max():
            break
        chosen.append(best)
        spent += problem.costs[best]
        counts += problem.serves[best]
    return chosen


def _swap(problem, chosen):
    """Best improvement by adding a camera or exchanging one, until there is none."""
    chosen = list(chosen)
    value = value_of(problem, chosen)
    while True:
        # Row 0 removes no camera, row i the i-th.
        without = np.repeat(_counts(problem, chosen)[None], len(chosen) + 1, axis=0)
        without[1:] -= problem.serves[chosen]
        wanting = problem.weights * (without == problem.folds - 1)
        kept = (problem.weights * (without >= problem.folds)).sum(axis=1)
        new = kept[:, None] + (problem.served.T @ wanting.T).T
        spent = problem.costs[chosen].sum() - np.r_[0.0, problem.costs[chosen]]
        new[spent[:, None] + problem.costs > problem.budget] = -np.inf
        new[:, chosen] = -np.inf
        if len(chosen) == problem.most:
            new[0] = -np.inf
        out, into = np.unravel_index(new.argmax(), new.shape)
        if not new[out, into] > value * (1 + HAIR):
            return chosen
        if out:
            chosen[out - 1] = int(into)
        else:
            chosen.append(int(into))
        value = value_of(problem, chosen)


def search_by_swaps(problem: Problem) -> list[int]:
    """Greedy, swaps, and the same from other starts."""
    best = _swap(problem, choose_greedily(problem))
    number = len(problem.columns)
    if number <= problem.most and not np.isfinite(problem.budget):
        return best
    rng = np.random.default_rng(0)
    worth = problem.served.T @ problem.weights
    value = value_of(problem, best)
    for restart in range(RESTARTS):
        kept = rng.permutation(best)[: len(best) // 2 * (restart % 2)]
        others = np.setdiff1d(np.arange(number), kept)
        new = min(problem.most - len(kept), len(others))
        drawn = rng.choice(others, new, replace=False, p=worth[others] / worth[others].sum())
        start = np.r_[kept, drawn].astype(int)
        start = start[np.cumsum(problem.costs[start]) <= problem.budget]
        again = _swap(problem, start)
        if value_of(problem, again) > value * (1 + HAIR):
            best, value = again, value_of(problem, again)
    return best


def quick_bound(problem: Problem, chosen: list[int]) -> float:
    """Weight that no choice exceeds, without solving anything."""
    alone = problem.served.T @ problem.weights / problem.folds
    bounds = [problem.weights.sum(), np.sort(alone)[-problem.most :].sum()]
    if problem.folds == 1:
        missing = problem.weights * (_counts(problem, chosen) == 0)
        more = np.sort(problem.served.T @ missing)[-problem.most :].sum()
        bounds.append(problem.weights.sum() - missing.sum() + more)
    return float(min(bounds))


def maximise(
    problem: Problem, found: list[int], time_limit: float, goal: float = 0.0
) -> tuple[list[int], float]:
    """A better choice than `found`, and what none exceeds.

    Choices worth less than `goal` are of no interest; the search ends with one that
    reaches it.  The bound is then that of choices that reach it.
    """
    value = value_of(problem, found)
    if quick_bound(problem, found) <= value:
        return found, value
    everyone = np.arange(len(problem.columns))
    if len(everyone) <= problem.most and not np.isfinite(problem.budget):
        return everyone.tolist(), float(problem.weights.sum())
    plain = problem.folds == 1 and np.ptp(problem.costs) == 0 and not np.isfinite(problem.budget)
    if plain and problem.most == 2:
        most, pair = best_pair(problem.serves.astype(float), problem.weights, everyone)
        return (pair, most) if most > value * (1 + HAIR) else (found, value)
    end = perf_counter() + time_limit
    root = _relax(problem, time_limit)
    if root is None:  # not even the relaxation was solved in time
        return found, quick_bound(problem, found)
    bound, cost, price = root
    if bound < max(value + _step(problem), goal):
        return found, max(value, bound if value < goal else 0.0)
    if plain and 2 < problem.most <= FEW:
        # A camera whose reduced cost exceeds what is to be gained is in no better choice.
        keep = np.flatnonzero(cost <= bound - max(value + _step(problem), goal) + 1e-6 * bound)
        rest, price = _merge(problem._replace(serves=problem.serves[keep]), price)
        better, bound = branch(
            rest.serves.astype(float),
            rest.weights,
            rest.most,
            price,
            value=value,
            goal=goal,
            step=_step(problem),
            end=end,
        )
        return (found if better is None else list(keep[better])), bound
    return _program(problem, found, bound, max(0.01, end - perf_counter()))


def _step(problem):
    """A choice that is better at all is better by this much."""
    total = problem.weights.sum()
    whole = (problem.weights == np.round(problem.weights)).all() and total < 1e8
    return 1.0 - 1e-3 if whole else 100 * HAIR * total


def _constraints(problem):
    """Matrix and upper limits over cameras x, then targets z."""
    from scipy import sparse

    rows, columns = problem.served.shape
    matrices = [sparse.hstack([-problem.served, problem.folds * sparse.eye_array(rows)])]
    limits = [np.zeros(rows)]
    if problem.most < columns:
        matrices.append(np.r_[np.ones(columns), np.zeros(rows)][None])
        limits.append([problem.most])
    if np.isfinite(problem.budget):
        matrices.append(np.r_[problem.costs, np.zeros(rows)][None])
        limits.append([problem.budget])
    return sparse.vstack(matrices, format="csr"), np.concatenate(limits)


def _relax(problem, time_limit):
    """The linear relaxation: its value, the cameras' reduced costs, the targets' prices."""
    from scipy.optimize import linprog

    rows, columns = problem.served.shape
    matrix, limits = _constraints(problem)
    result = linprog(
        np.r_[np.zeros(columns), -problem.weights],
        A_ub=matrix,
        b_ub=limits,
        bounds=(0, 1),
        options={"time_limit": time_limit},
    )
    if result.status != 0:
        return None
    return -result.fun, result.lower.marginals[:columns], -result.ineqlin.marginals[:rows]


def _solve(problem, aims, matrix, limits, time_limit, gap=0.0):
    """The integer program by HiGHS: the cameras found, or None, and what none aims below."""
    from scipy.optimize import Bounds, LinearConstraint, milp

    rows, columns = problem.served.shape
    result = milp(
        aims,
        constraints=LinearConstraint(matrix, ub=limits),
        bounds=Bounds(0, 1),
        # With one fold a target is served wholly or not at all, by itself.
        integrality=np.r_[np.ones(columns), np.full(rows, problem.folds > 1)],
        options={"time_limit": time_limit, "mip_rel_gap": gap},
    )
    chosen = None if result.x is None else np.flatnonzero(result.x[:columns] > 0.5).tolist()
    bound = result.mip_dual_bound
    return chosen, bound if bound is not None and np.isfinite(bound) else -np.inf


def _program(problem, found, bound, time_limit):
    """The integer program, as it stands."""
    aims = np.r_[np.zeros(len(problem.columns)), -problem.weights]
    gap = 0.5 * _step(problem) / bound
    chosen, dual = _solve(problem, aims, *_constraints(problem), time_limit, gap)
    value = value_of(problem, found)
    if chosen is not None:
        paid = problem.costs[chosen].sum() <= problem.budget  # not only within tolerances
        if paid and value_of(problem, chosen) > value:
            found, value = chosen, value_of(problem, chosen)
    bound = min(bound, -dual)
    return found, value if bound < value + _step(problem) else bound


def trim(problem: Problem, chosen: list[int], goal: float) -> list[int]:
    """As few of the chosen as reach the goal: the first ones, then without the needless."""
    if value_of(problem, chosen) < goal:  # greedy for several folds may stop early
        chosen = list(range(len(problem.columns)))
    else:
        while chosen and value_of(problem, chosen[:-1]) >= goal:
            chosen = chosen[:-1]
    for camera in sorted(chosen, key=lambda camera: -problem.costs[camera]):
        rest = [other for other in chosen if other != camera]
        if value_of(problem, rest) >= goal:
            chosen = rest
    return list(chosen)


def minimise(
    problem: Problem, found: list[int], goal: float, time_limit: float
) -> tuple[list[int], float]:
    """Cheaper cameras than `found` that reach the goal, and what none of them costs less than."""
    from scipy import sparse

    end = perf_counter() + time_limit
    equal = np.ptp(problem.costs) == 0
    # With one fold and equal costs, one camera less at a time, while that reaches the goal.
    while equal and problem.folds == 1 and 1 < len(found) <= FEW + 1:
        fewer = strike_off(problem._replace(most=len(found) - 1))
        local = search_by_swaps(fewer)
        bound = np.inf
        if value_of(fewer, local) < goal:
            local, bound = maximise(fewer, local, max(0.01, end - perf_counter()), goal)
        if value_of(fewer, local) < goal:
            proven = bound < goal
            return found, (len(found) if proven else len(found) - 1) * problem.costs[0]
        found = list(np.searchsorted(problem.columns, fewer.columns[local]))
    if equal and len(found) == 1:
        return found, problem.costs[0]
    rows, columns = problem.served.shape
    matrix, limits = _constraints(problem)
    matrix = sparse.vstack([matrix, np.r_[np.zeros(columns), -problem.weights][None]])
    aims, limits = np.r_[problem.costs, np.zeros(rows)], np.r_[limits, -goal]
    chosen, dual = _solve(problem, aims, matrix, limits, max(0.01, end - perf_counter()))
    if chosen is not None:
        cheaper = problem.costs[chosen].sum() < problem.costs[found].sum()
        if value_of(problem, chosen) >= goal and cheaper:
            found = chosen
    bound = max(problem.costs.min(), dual)
    if equal:  # whole cameras
        bound = np.ceil(bound / problem.costs[0] - 1e-6) * problem.costs[0]
    return found, bound


def check_served(served: ArrayLike) -> np.ndarray:
    """Return `served` as booleans of shape (targets, cameras), or raise `ArgumentError`."""
    remedy = "booleans, a row a target and a column a camera, one of each at least"
    served = require_array("served", served, (None, None), dtype=bool, remedy=remedy)
    if served.size == 0:
        raise ArgumentError(f"served has the shape {served.shape}; pass {remedy}.")
    return served


def check_numbers(n: int, folds: int, columns: int) -> tuple[int, int]:
    """Return `n` and `folds` when so many of `columns` cameras can be chosen, or raise."""
    n, folds = require_count("n", n, low=1), require_count("folds", folds, low=1)
    if n > columns:
        raise ArgumentError(
            f"n is {n}, but there are {columns} cameras to choose from; pass fewer, or allow more "
            "places."
        )
    if folds > n:
        raise ArgumentError(
            f"folds is {folds}, but {n} cameras are chosen at most; no target could count."
        )
    return n, folds


def check_weights(weights: ArrayLike | None, number: int) -> np.ndarray:
    """Return the targets' weights, all alike if None, or raise `ArgumentError`."""
    if weights is None:
        return np.ones(number)
    weights = require_array("weights", weights, (number,), low=0)
    if weights.sum() <= 0:
        raise ArgumentError("weights are all zero; give some target a weight.")
    return weights
