"""Choices of cameras against trying every subset."""

from itertools import combinations

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mcnlab.cameras.floor import GridMap
from mcnlab.cameras.visibility import CameraModel, square_on
from mcnlab.errors import ArgumentError
from mcnlab.placement import exact as solvers
from mcnlab.placement.choice import (
    choose_area,
    choose_exact,
    choose_greedy,
    choose_random,
    choose_with_swaps,
    covered,
    fewest_for_share,
)
from mcnlab.placement.coverage import candidates, walker_seconds


@st.composite
def instances(draw):
    n, m = draw(st.integers(1, 14)), draw(st.integers(1, 8))
    served = draw(arrays(bool, (n, m)))
    weights = draw(
        st.one_of(
            st.none(),
            arrays(float, n, elements=st.integers(0, 5)),
            arrays(float, n, elements=st.floats(0.01, 3)),
        )
    )
    most = draw(st.integers(1, m))
    return served, weights, most, draw(st.integers(1, min(2, most)))


def possible(served, weights, folds):
    weights = np.ones(len(served)) if weights is None else weights
    return (weights[served.sum(axis=1) >= folds] > 0).any()


def share_of(served, cameras, *, weights=None, folds=1):
    """The share of the targets' weight that the cameras serve."""
    weights = np.ones(len(served)) if weights is None else np.asarray(weights)
    return weights[covered(served, list(cameras), folds=folds)].sum() / weights.sum()


def subsets(m, most):
    return (subset for k in range(1, most + 1) for subset in combinations(range(m), k))


def best_of(served, weights, most, folds, costs=None, budget=np.inf):
    costs = np.ones(served.shape[1]) if costs is None else costs
    return max(
        share_of(served, subset, weights=weights, folds=folds)
        for subset in subsets(served.shape[1], most)
        if costs[list(subset)].sum() <= budget * (1 + 1e-9)
    )


@given(instances())
def test_exact_is_the_best_of_all_subsets(instance):
    served, weights, most, folds = instance
    options = {"weights": weights, "folds": folds}
    if not possible(served, weights, folds):
        with pytest.raises(ArgumentError, match=r"no target|all zero"):
            choose_exact(served, most, **options)
        return
    exact, swaps, greedy = (
        choose(served, most, **options)
        for choose in (choose_exact, choose_with_swaps, choose_greedy)
    )
    best = best_of(served, weights, most, folds)
    # Solvers prove an optimum to a ten-millionth of the weight.
    assert exact.share == pytest.approx(best, abs=2e-7)
    assert exact.proven
    assert exact.bound >= best - 2e-7
    assert exact.share >= swaps.share - 2e-7 >= greedy.share - 4e-7
    if folds == 1:
        assert greedy.share >= (1 - 1 / np.e) * best - 1e-9
    for choice in (exact, swaps, greedy):
        assert len(choice.cameras) <= most
        assert choice.share == pytest.approx(share_of(served, choice.cameras, **options))
        assert choice.gap == pytest.approx(choice.bound - choice.share, abs=1e-8)
        assert choice.bound >= best - 2e-7


@pytest.mark.parametrize("choose", [choose_exact, choose_with_swaps])
@given(instance=instances(), data=st.data())
@settings(max_examples=60)
def test_without_any_of_the_chosen_less_is_served(choose, instance, data):
    served, weights, most, folds = instance
    if not possible(served, weights, folds):
        return
    costs = data.draw(
        st.one_of(st.none(), arrays(float, served.shape[1], elements=st.integers(1, 5)))
    )
    budget = None if costs is None else float(costs.sum())
    options = {"weights": weights, "folds": folds}
    choice = choose(served, most, costs=costs, budget=budget, **options)
    for camera in choice.cameras:
        rest = [other for other in choice.cameras if other != camera]
        assert share_of(served, rest, **options) < choice.share


@pytest.mark.parametrize("n", [7, 13])
def test_more_cameras_than_are_useful_are_not_taken(n):
    # Seven cameras serve ten targets each; six more serve some of two of them each:
    # none stands in for another, and the seven serve all.
    served = np.zeros((70, 13), bool)
    served[np.arange(70), np.arange(70) // 10] = True
    for k in range(6):
        served[[10 * k, 10 * k + 10, 10 * k + 11], 7 + k] = True
    choice = choose_exact(served, n)
    assert (choice.share, choice.cost, choice.proven) == (1.0, 7.0, True)
    assert sorted(choice.cameras) == list(range(7))
    assert sorted(choose_with_swaps(served, n).cameras) == list(range(7))


@pytest.mark.parametrize("choose", [choose_exact, choose_with_swaps])
def test_a_budget_that_serves_nothing_buys_nothing(choose):
    # Only the two dear cameras together serve the target twice.
    choice = choose(np.array([[1, 1, 0, 0]], bool), costs=[3, 3, 1, 1], budget=4, folds=2)
    assert (list(choice.cameras), choice.share, choice.cost) == ([], 0.0, 0.0)


@given(instances(), st.data())
def test_with_costs_exact_is_the_best_that_the_budget_buys(instance, data):
    served, weights, most, _ = instance
    costs = data.draw(arrays(float, served.shape[1], elements=st.integers(1, 5)))
    budget = float(data.draw(st.integers(int(costs.min()), int(costs.sum()))))
    if not possible(served[:, costs <= budget], weights, 1):
        with pytest.raises(ArgumentError, match=r"no target|all zero"):
            choose_exact(served, costs=costs, budget=budget, weights=weights)
        return
    choice = choose_exact(served, most, costs=costs, budget=budget, weights=weights)
    assert choice.share == pytest.approx(best_of(served, weights, most, 1, costs, budget), abs=2e-7)
    assert choice.cost == pytest.approx(costs[choice.cameras].sum())
    assert choice.cost <= budget * (1 + 1e-9)


@pytest.mark.parametrize("unit", [1e-9, 1e9])
def test_the_currency_of_costs_and_weights_does_not_matter(unit):
    served, costs = scattered(5), np.random.default_rng(5).uniform(0.5, 3, 60)
    one = choose_exact(served, costs=costs, budget=7.0)
    other = choose_exact(
        served, costs=unit * costs, budget=unit * 7, weights=np.full(len(served), unit)
    )
    assert one.proven
    assert other.proven
    assert other.share == pytest.approx(one.share, abs=2e-7)
    assert other.cost == pytest.approx(unit * costs[other.cameras].sum())
    assert other.cost <= unit * 7 * (1 + 1e-9)


@given(instances(), st.data())
@settings(max_examples=60)
def test_the_fewest_are_the_cheapest_subset_that_reaches_the_share(instance, data):
    served, weights, _, folds = instance
    if folds > served.shape[1] or not possible(served, weights, folds):
        return
    costs = data.draw(
        st.one_of(st.none(), arrays(float, served.shape[1], elements=st.integers(1, 4)))
    )
    reachable = share_of(served, range(served.shape[1]), weights=weights, folds=folds)
    share = data.draw(st.floats(0.2, 1.0)) * reachable
    choice = fewest_for_share(served, share, weights=weights, folds=folds, costs=costs)
    prices = np.ones(served.shape[1]) if costs is None else costs
    least = min(
        prices[list(subset)].sum()
        for subset in subsets(served.shape[1], served.shape[1])
        if share_of(served, subset, weights=weights, folds=folds) >= share * (1 - 1e-7)
    )
    assert choice.share >= share * (1 - 1e-7)
    assert choice.cost == pytest.approx(least)
    assert choice.proven
    assert choice.bound == pytest.approx(least)


def scattered(seed, n=150, m=60, density=0.08):
    rng = np.random.default_rng(seed)
    served = rng.random((n, m)) < density
    served[0] = True
    return served


@pytest.mark.parametrize("seed", range(6))
def test_branch_and_bound_agrees_with_the_integer_program(seed, monkeypatch):
    weights = np.random.default_rng(seed).integers(1, 4, 150).astype(float)
    if seed % 2:
        weights /= 7
    ours = choose_exact(scattered(seed), 5, weights=weights)
    monkeypatch.setattr(solvers, "FEW", 0)
    theirs = choose_exact(scattered(seed), 5, weights=weights)
    assert ours.proven
    assert theirs.proven
    assert ours.share == pytest.approx(theirs.share, abs=2e-7)


@pytest.mark.parametrize("n", [2, 4, 6])
def test_the_fewest_are_the_inverse_of_exact(n):
    served = scattered(9)
    choice = choose_exact(served, n)
    fewest = fewest_for_share(served, choice.share)
    assert fewest.proven
    assert fewest.cost == n  # here every camera more serves more
    assert fewest.share >= choice.share - 1e-9


@given(st.integers(0, 10**6))
@settings(max_examples=15)
def test_a_candidate_more_never_lowers_the_optimum(seed):
    served = scattered(seed, 40, 20, 0.15)
    shares = [choose_exact(served[:, :m], 3).share for m in (10, 15, 20)]
    assert shares == sorted(shares)


@pytest.mark.parametrize("folds", [1, 2])
def test_an_exact_choice_cut_short_says_so(folds):
    served = scattered(1, 400, 120, 0.1)
    choice = choose_exact(served, 8, folds=folds, time_limit=1e-3)
    assert not choice.proven
    assert choice.gap > 0
    assert choice.gap == pytest.approx(choice.bound - choice.share)
    assert choice.share >= choose_with_swaps(served, 8, folds=folds).share


def test_greedy_stops_short_where_swaps_do_not():
    assert choose_greedy(np.eye(3, dtype=bool), 2).proven
    # All cameras serve two targets; greedy takes the first, which the other two replace.
    served = np.array([[1, 1, 0], [1, 0, 1], [0, 1, 0], [0, 0, 1]], dtype=bool)
    greedy, swaps = choose_greedy(served, 2), choose_with_swaps(served, 2)
    assert (greedy.share, greedy.bound, greedy.proven) == (0.75, 1.0, False)
    assert (swaps.share, swaps.gap, swaps.proven) == (1.0, 0.0, True)
    assert sorted(swaps.cameras) == [1, 2]


def test_area_is_the_same_choice_over_cells():
    seen = scattered(2)
    assert choose_area(seen, 3).method == "area"
    assert choose_area(seen, 3, exact=True).share == choose_exact(seen, 3).share


def test_random_draws_are_repeatable_and_fair():
    served = scattered(4)
    draws = choose_random(served, 3, draws=400)
    assert draws.cameras.shape == (400, 3)
    assert (np.diff(draws.cameras, axis=1) > 0).all()
    assert draws.shares[7] == pytest.approx(share_of(served, draws.cameras[7]))
    assert (draws.shares == choose_random(served, 3, draws=400).shares).all()
    assert draws.spread[0] < draws.share < draws.spread[1] < choose_exact(served, 3).share
    # Served by none of three of m cameras: the product of the chances of missing them.
    m, by = served.shape[1], served.sum(axis=1)
    missed = (m - by) * (m - by - 1) * (m - by - 2) / (m * (m - 1) * (m - 2))
    # 400 draws: four standard errors of their mean.
    error = 4 * draws.shares.std() / 20
    assert draws.share == pytest.approx((1 - missed).mean(), abs=error)


def test_folds_ask_for_several_cameras():
    served = np.array([[1, 1, 0], [1, 0, 1], [1, 1, 1]], dtype=bool)
    assert list(covered(served, [0, 1], folds=2)) == [True, False, True]
    assert not covered(served, []).any()
    choice = choose_exact(served, 2, folds=2, weights=[1, 2, 1])
    assert (choice.share, choice.proven) == (0.75, True)  # the first and last, by cameras 0 and 2


CHOOSERS = [choose_greedy, choose_with_swaps, choose_exact, choose_random]


@pytest.mark.parametrize("choose", CHOOSERS)
@pytest.mark.parametrize(
    ("served", "n", "options", "word"),
    [
        (np.ones((3, 2), bool), 3, {}, "2 cameras"),
        (np.ones((3, 2), bool), 0, {}, "n is 0"),
        (np.ones((3, 2), bool), 1.0, {}, "n is 1.0"),
        (np.ones((3, 2)), 1, {}, "boolean"),
        (np.ones(3, bool), 1, {}, "boolean"),
        (np.ones((0, 2), bool), 1, {}, "at least"),
        (np.ones((3, 0), bool), 1, {}, "at least"),
        (np.ones((3, 2), bool), 1, {"weights": [1, 2]}, "weights"),
        (np.ones((3, 2), bool), 1, {"weights": [1, 2, -1]}, "weights is -1"),
        (np.ones((3, 2), bool), 1, {"weights": [1, 2, np.nan]}, "weights is nan"),
        (np.ones((3, 2), bool), 1, {"weights": [0, 0, 0]}, "all zero"),
        (np.ones((3, 2), bool), 1, {"folds": 0}, "folds"),
        (np.ones((3, 2), bool), 1, {"folds": 2}, "folds"),
    ],
)
def test_an_impossible_choice_is_refused(choose, served, n, options, word):
    with pytest.raises(ArgumentError, match=word):
        choose(served, n, **options)


@pytest.mark.parametrize("choose", CHOOSERS[:3])
@pytest.mark.parametrize(
    ("n", "options", "word"),
    [
        (None, {}, "budget"),
        (1, {"costs": [1]}, "costs"),
        (1, {"costs": [1, 0]}, "costs is 0"),
        (1, {"costs": [1, np.inf]}, "finite"),
        (1, {"costs": [2, 3], "budget": 1}, "budget"),
        (None, {"costs": [2, 3], "budget": np.nan}, "budget"),
        (2, {"costs": [2, 3], "budget": 4, "folds": 2}, "folds"),
    ],
)
def test_impossible_costs_are_refused(choose, n, options, word):
    with pytest.raises(ArgumentError, match=word):
        choose(np.ones((3, 2), bool), n, **options)


def test_nothing_to_serve_is_refused():
    with pytest.raises(ArgumentError, match="no target"):
        choose_exact(np.zeros((3, 2), bool), 1)


def test_an_infeasible_share_names_the_best_reachable():
    served = np.array([[1, 0], [0, 1], [0, 0]], dtype=bool)
    with pytest.raises(ArgumentError, match=r"0\.6667"):
        fewest_for_share(served, 0.7)
    assert fewest_for_share(served, 2 / 3).cost == 2
    for share in (0, 1.1, np.nan):
        with pytest.raises(ArgumentError, match="share"):
            fewest_for_share(served, share)


@pytest.mark.parametrize("cameras", [[0, 0], [2], [-1], [0.5], [[0]], "a"])
def test_cameras_that_are_no_columns_are_refused(cameras):
    with pytest.raises(ArgumentError, match="cameras"):
        covered(np.ones((3, 2), bool), cameras)


def test_on_real_walks_the_optimum_is_proven_and_swaps_come_close(recordings):
    rows = np.loadtxt(recordings / "eth-ucy" / "seq_hotel" / "obsmat.txt")
    traces = pd.DataFrame(
        {
            "trace": rows[:, 1].astype(int).astype(str),
            "frame": rows[:, 0].astype(int),
            "x": rows[:, 2],
            "y": rows[:, 4],
        }
    ).sort_values(["trace", "frame"], ignore_index=True)
    targets = walker_seconds(traces, frame_rate=25.0)
    grid = GridMap.over((-6, -13, 7, 7), cell=1.3)
    served = square_on(targets, candidates(grid, model=CameraModel()), CameraModel())
    exact, swaps = choose_exact(served, 4), choose_with_swaps(served, 4)
    assert exact.proven
    assert exact.share >= swaps.share >= 0.99 * exact.share
    assert exact.share > 1.5 * choose_random(served, 4, draws=100).share
