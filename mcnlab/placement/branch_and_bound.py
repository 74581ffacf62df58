"""Branch and bound with Lagrangian bounds: few cameras of equal cost, each target served once.

References
----------
M. Held, P. Wolfe and H. Crowder, "Validation of subgradient optimization", Mathematical
Programming 6, 1974.
"""

from time import perf_counter

import numpy as np

from mcnlab.checks import HAIR


def branch(
    serves: np.ndarray,
    weights: np.ndarray,
    most: int,
    price: np.ndarray,
    *,
    value: float,
    goal: float,
    step: float,
    end: float,
) -> tuple[list[int] | None, float]:
    """Branch and bound with Lagrangian bounds, for few cameras of equal cost.

    Let each target t pay its cameras a price 0 ≤ p_t ≤ w_t for being served, and keep the
    rest of its weight in any case: no choice is worth more than Σ(w − p) and the n
    greatest sums of prices.  The relaxation's prices are the best to begin with; below,
    a few subgradient steps mend them.  A node is a set of chosen cameras and those that
    may follow; nodes are bounded many at a time, and the last two cameras are found by
    trying all pairs.

    Parameters
    ----------
    serves : ndarray, shape (cameras, targets)
        1.0 where a camera serves a target, else 0.0.
    weights : ndarray, shape (targets,)
    most : int
        Cameras to choose, three or more.
    price : ndarray, shape (targets,)
        The relaxation's.
    value : float
        Of the best choice so far.
    goal : float
        Choices worth less are of no interest; one that reaches it ends the search.
    step : float
        A choice that is better at all is better by this much.
    end : float
        On `time.perf_counter`; then the search stops.

    Returns
    -------
    better : list of int or None
        None when no choice is better than `value`.
    bound : float
    """
    better, needed = None, max(value + step, goal)
    everyone = np.arange(len(serves))
    sums = serves @ price
    top = np.sort(sums)[-most:].sum()
    nodes = [((weights - price).sum() + top, [], everyone, price, sums)]
    unseen = 0.0  # the best bound of what time did not allow
    while nodes:
        nodes = [node for node in nodes if node[0] >= needed]
        if not nodes or (better is not None and value >= goal > 0):
            break
        if perf_counter() > end:
            unseen = max(node[0] for node in nodes)
            break
        # The deepest first, of those the most promising.
        nodes.sort(key=lambda node: (len(node[1]), node[0]))
        depth = len(nodes[-1][1])
        parents = [node for node in nodes[-8:] if len(node[1]) == depth]
        del nodes[-len(parents) :]
        children = [child for node in parents for child in _children(node, most, needed)]
        left = most - depth - 1
        for start in range(0, len(children), 64):
            batch = children[start : start + 64]
            if perf_counter() > end:
                unseen = max(unseen, *(child[0] for child in batch))
                continue
            reached = np.stack([serves[chosen].any(axis=0) for _, chosen, _, _ in batch])
            bounds, prices, sums = _price(serves, weights, reached, batch, left, needed)
            for (bound, chosen, others, _), now, paid, own, gone in zip(
                batch, bounds, prices, sums, reached, strict=True
            ):
                bound = min(bound, now)
                if bound < needed:
                    continue
                if left > 2:
                    nodes.append((bound, chosen, others, paid, own))
                    continue
                more, pair = best_pair(serves, np.where(gone, 0.0, weights), others)
                if weights[gone].sum() + more >= needed:
                    value = weights[gone].sum() + more
                    better, needed = chosen + pair, max(value + step, goal)
    if unseen >= needed:
        return better, unseen
    return better, max(value, needed - step if value < goal else 0.0)


def _children(node, most, needed):
    """One child a camera: that one chosen, those before it in order of price ruled out."""
    bound, chosen, others, price, sums = node
    left = most - len(chosen)
    order = others[np.argsort(-sums[others], kind="stable")]
    ranked = sums[order]
    if len(order) > left:
        # Choosing a camera beyond the first `left` costs the difference to the last of them.
        useful = bound - ranked[left - 1] + ranked >= needed
        order, ranked = order[useful], ranked[useful]
    running = np.r_[0.0, np.cumsum(ranked)]
    first = np.arange(len(order))
    last = np.minimum(first + left, len(order))
    bounds = bound - running[min(left, len(order))] + running[last] - running[first]
    return [
        (bounds[i], [*chosen, int(order[i])], order[i + 1 :], price)
        for i in np.flatnonzero(bounds >= needed)
    ]


def _price(serves, weights, reached, batch, left, needed):
    """Lagrangian bounds of a batch of nodes, each mended by a few subgradient steps."""
    size, cameras = len(batch), len(serves)
    value = reached @ weights
    open_weights = np.where(reached, 0.0, weights)
    price = np.minimum(np.stack([node[3] for node in batch]), open_weights)
    barred = np.full((size, cameras), -np.inf)
    for row, (_, _, others, _) in enumerate(batch):
        barred[row, others] = 0.0
    best, best_price, best_sums = np.full(size, np.inf), price.copy(), np.empty((size, cameras))
    stride = np.ones(size)
    active = np.arange(size)
    rounds = max(2, left)
    count = min(left, cameras)
    for number in range(rounds):
        sums = price @ serves.T + barred[active]
        top = np.argpartition(sums, cameras - count, axis=1)[:, cameras - count :]
        paid = np.maximum(np.take_along_axis(sums, top, axis=1), 0.0)
        kept = open_weights[active]
        bound = value[active] + (kept - price).sum(axis=1) + paid.sum(axis=1)
        lower = bound < best[active]
        at = active[lower]
        best[at], best_price[at], best_sums[at] = bound[lower], price[lower], sums[lower]
        stride[active[~lower]] *= 0.6
        alive = best[active] >= needed
        if number == rounds - 1 or not alive.any():
            break
        active, price, kept, bound = active[alive], price[alive], kept[alive], bound[alive]
        top, paid = top[alive], paid[alive]
        # A target chosen for twice over pays too much, one not chosen for too little.
        slope = np.full(price.shape, -1.0)
        for camera in range(count):
            slope += serves[top[:, camera]] * (paid[:, [camera]] > 0)
        slope[((price <= 0) & (slope > 0)) | ((price >= kept) & (slope < 0))] = 0.0
        length = stride[active] * (bound - needed + 1.0) / (np.square(slope).sum(axis=1) + HAIR)
        price = np.clip(price - length[:, None] * slope, 0.0, kept)
    return best, best_price, best_sums


def best_pair(
    serves: np.ndarray, weights: np.ndarray, others: np.ndarray
) -> tuple[float, list[int]]:
    """How much the best two of the cameras `others` serve, and which these are."""
    if len(others) == 0:
        return 0.0, []
    own = serves[others]
    gain = own @ weights
    # A pair better than the best camera and its best complement has two cameras worth that.
    best = int(gain.argmax())
    floor = (gain[best] + (np.maximum(own[best], own) - own[best]) @ weights).max()
    useful = np.flatnonzero(gain + gain[best] >= floor * (1 - HAIR))
    own, gain = own[useful], gain[useful]
    both = gain[:, None] + gain - (own * weights) @ own.T
    first, second = np.unravel_index(both.argmax(), both.shape)
    pair = [int(others[useful[first]])]
    if second != first:
        pair.append(int(others[useful[second]]))
    return float(both[first, second]), pair
