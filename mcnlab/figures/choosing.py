"""The figures beyond section 2.2.4: the best choice of cameras, and what voting costs."""

import matplotlib.pyplot as plt
import numpy as np

from mcnlab import plotting
from mcnlab.columns import FRAME
from mcnlab.figures.registry import EXACT
from mcnlab.figures.registry import figure as _figure


@_figure(
    "plans",
    "Four ways to place the same cameras",
    notebook=EXACT,
    claim="Where do votes, ground seen, greed and proof put the cameras?",
    finding="Green walker-seconds are seen square-on by some camera. Whoever maximises ground sees "
    "the corridor along its length.",
)
def plans(site, chosen):
    """One map a method: its cameras, and the walker-seconds they see square-on.

    Parameters
    ----------
    site : siting.Site
    chosen : dict
        Method → (cameras, share, served walker-seconds).
    """
    columns = 2
    rows = -(-len(chosen) // columns)
    left, bottom, right, top = site.grid.area
    height = 5.2 * (top - bottom) / (right - left) + 0.7
    figure, axes = plt.subplots(rows, columns, figsize=(11, rows * height), squeeze=False)
    for ax, (method, (cameras, share, served)) in zip(axes.flat, chosen.items(), strict=False):
        plotting.plot_ground(site.grid.area, walls=site.scene.walls, ax=ax)
        plotting.plot_served(site.targets, served, ax=ax)
        plotting.plot_cameras(cameras, site.model, method=method, cones=not site.model.pans, ax=ax)
        ax.set_title(f"{method}: {share:.0%} of walker-seconds")
    plotting.served_legend(axes.flat[0])
    for ax in axes.flat[len(chosen) :]:
        ax.axis("off")
    return figure


@_figure(
    "price-of-voting",
    "The price of voting",
    notebook=EXACT,
    claim="How much less do voted cameras see, of people whom no method has seen?",
    ids=(
        "placement.corridor.price_of_voting",
        "placement.pets.price_of_voting",
        "placement.price_of_voting",
        "placement.corridor.votes.square_on",
        "placement.corridor.exact.square_on",
        "placement.pets.votes.square_on",
        "placement.pets.exact.square_on",
    ),
)
def price_of_voting(shares):
    """Held-out shares of every method on every scene, with intervals over walkers."""
    scenes = shares["scene"].nunique()
    figure, ax = plt.subplots(figsize=(9, 1.6 + 0.62 * scenes))
    plotting.plot_shares(shares, ax=ax)
    return figure


@_figure(
    "how-many-cameras",
    "How many cameras?",
    notebook=EXACT,
    claim="What does one more camera add? How many see 60 % of what they were chosen from?",
    ids=("placement.corridor.fewest_for_0.6",),
)
def how_many(tables, *, required):
    """Held-out share against the number of cameras, one panel a scene.

    Parameters
    ----------
    tables : dict
        Scene → table from `siting.shares_by_number`.
    required : float
        The share drawn as a line.
    """
    figure, axes = plt.subplots(1, len(tables), figsize=(5 * len(tables), 3.6), squeeze=False)
    for ax, (scene, table) in zip(axes.flat, tables.items(), strict=True):
        ax.axhline(required, color=plotting.INK, lw=1, ls=":")
        for method, rows in table.groupby("method", sort=False):
            style = {"color": plotting.CHOICE_COLOURS[method]}
            ax.plot(
                rows["cameras"],
                rows["share"],
                marker=plotting.CHOICE_MARKERS[method],
                label=method,
                **style,
            )
            low = rows["low"].fillna(rows["share"]).astype(float)
            high = rows["high"].fillna(rows["share"]).astype(float)
            ax.fill_between(rows["cameras"], low, high, alpha=0.12, lw=0, **style)
        ax.set(
            xlabel="cameras",
            ylabel="held-out walker-seconds\nseen square-on (share)",
            ylim=(0, 1),
            xticks=sorted(table["cameras"].unique()),
            title=scene,
        )
    for ax in axes.flat[1:]:
        ax.set_ylabel("")
    axes.flat[-1].legend(loc="lower right")
    return figure


@_figure(
    "demands",
    "Other demands on the same program",
    notebook=EXACT,
    claim="Places may be forbidden, cameras may cost, a gait may need two views.",
    finding="Each is one more line in the integer program.",
    ids=("placement.demands.largest_gap",),
)
def demands(site, variants):
    """Exact choices under other demands, one map each.

    Parameters
    ----------
    site : siting.Site
    variants : dict
        Title → (cameras, served walker-seconds, forbidden map or None).
    """
    left, bottom, right, top = site.grid.area
    height = 5.2 * (top - bottom) / (right - left) + 0.7
    rows = -(-len(variants) // 2)
    figure, axes = plt.subplots(rows, 2, figsize=(11, rows * height), squeeze=False)
    for ax, (title, (cameras, served, forbidden)) in zip(axes.flat, variants.items(), strict=False):
        plotting.plot_ground(site.grid.area, walls=site.scene.walls, ax=ax)
        if forbidden is not None:
            plotting.plot_forbidden(site.grid, forbidden, ax=ax)
        plotting.plot_served(site.targets, served, ax=ax)
        plotting.plot_cameras(cameras, site.model, method="exact", cones=False, ax=ax)
        ax.set_title(title)
    for ax in axes.flat[len(variants) :]:
        ax.axis("off")
    return figure


@_figure(
    "master-and-slaves",
    "Master and slaves",
    notebook=EXACT,
    claim="The overhead camera wakes the cameras and tells them how fast to pan (section 2.2.5).",
    ids=(
        "control.corridor.awake_share",
        "control.corridor.square_share",
        "control.corridor.turning_share",
        "control.corridor.lagging_share",
    ),
)
def master_and_slaves(watch, limits, lost, *, seconds=(60, 180)):
    """Which camera is awake when, how fast each must pan, and what a slower one loses.

    Parameters
    ----------
    watch : control.Watch
    limits, lost : array_like
        Pan limits (degrees a second), and the share of the watchable time lost at each.
    seconds : (float, float), optional
        The part of the time that is drawn.
    """
    figure = plt.figure(figsize=(11, 5.4))
    grid = figure.add_gridspec(2, 2, height_ratios=(1, 1.5))
    top, left, right = (
        figure.add_subplot(grid[at]) for at in (np.s_[0, :], np.s_[1, 0], np.s_[1, 1])
    )
    time = watch.table[FRAME] / watch.frame_rate
    shown = watch.table[(time >= seconds[0]) & (time <= seconds[1])]
    plotting.plot_timeline(shown, watch.frame_rate, cameras=len(watch.cameras), ax=top)
    top.set(xlim=seconds, title="awake")
    needed = np.abs(watch.table["needed"][watch.table["awake"]])
    left.hist(needed, bins=40, color=plotting.LOWER)
    left.set(xlabel="pan rate that the walker asks for (degrees a second)")
    left.set_yscale("log" if len(needed) else "linear")
    left.set_ylabel("camera frames")
    right.plot(limits, lost, "o-", color=plotting.LOWER)
    right.set(xlabel="pan limit (degrees a second)", ylabel="time lost turning or lagging (share)")
    right.set_ylim(0, None)
    return figure
