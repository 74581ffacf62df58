"""The figures of sections 2.2.1 to 2.3: from traces to votes to places."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mcnlab.cameras.floor import GridMap
from mcnlab.cameras.visibility import square_on
from mcnlab.figures.registry import EXACT, VOTE, figure
from mcnlab.placement import cells
from mcnlab.placement.cells import CHAOS, DIRECTED, NO_LOCUS, DirectedCells
from mcnlab.plotting.gait import plot_timeline
from mcnlab.plotting.placement import (
    cells_legend,
    plot_band,
    plot_cameras,
    plot_cells,
    plot_forbidden,
    plot_ground,
    plot_histogram,
    plot_mesh,
    plot_patterns,
    plot_served,
    plot_shares,
    plot_sights,
    plot_traces,
    plot_votes,
    served_legend,
)
from mcnlab.plotting.style import CHOICE_COLOURS, CHOICE_MARKERS, INK, LOWER, PALE, UPPER
from mcnlab.tables import FRAME, TRACE, X, Y


@figure("2.3", section="2.2.1", notebook=VOTE)
def loci(scene, grid) -> Figure:
    """Loci of those who walk.

    Figure 2.3: every trace over the cells of the grid.

    Claim
    -----
    From overhead, the loci of many walkers make a visible pattern.

    Finding
    -------
    Lanes along the corridor and round its bends; those who cross or linger stand out.
    """
    figure, ax = plt.subplots(figsize=(9, 4.2))
    plot_ground(grid.area, walls=scene.walls, grid=grid, ax=ax)
    plot_traces(scene.traces, ax=ax)
    ax.set_title(f"{len(scene.walkers)} walkers, cells of {grid.cell:g} m")
    return figure


@figure("2.4", section="2.2.2", notebook=VOTE)
def patterns() -> Figure:
    """The angle of a pattern of pixels.

    Figure 2.4: strokes at the eight bins' centres and patterns without an angle.

    Claim
    -----
    The pixels of a locus in an 8×8 cell show one of the angles in [0, π].

    Finding
    -------
    The principal axis of the pixels; a point, a block or a cross has none.
    """
    examples = cells.example_patterns()
    angles, known = cells.infer_angle(np.stack(list(examples.values())))
    figure = plt.figure(figsize=(9, 3.4))
    plot_patterns(list(examples.values()), angles, known, figure=figure)
    return figure


@figure(
    "2.5", section="2.2.2", notebook=VOTE, ids=("placement.pets.directed", "placement.pets.chaos")
)
def kinds_of_cells(scene, grid, placed, *, chaos_ratio) -> Figure:
    """Three kinds of cells.

    Figure 2.5: (a) a directed cell, (b) a chaos cell, (c) one without a locus.

    Claim
    -----
    A cell has one direction, or several (chaos), or nobody passed it.

    Finding
    -------
    Red is the highest bin, blue its neighbours, grey the others, which decide.
    """
    figure, axes = plt.subplots(2, 3, figsize=(10, 5), height_ratios=(1.1, 1))
    walks = placed.cells.histograms.sum(axis=2)
    names = {DIRECTED: "(a) one direction", CHAOS: "(b) chaos", NO_LOCUS: "(c) no locus"}
    for column, (kind, name) in enumerate(names.items()):
        held = np.where(placed.cells.kind == kind, walks, -1)
        above, below = axes[:, column]
        above.set_title(name)
        if held.max() < 0:
            for ax in (above, below):
                ax.text(0.5, 0.5, "no such cell here", ha="center", transform=ax.transAxes)
                ax.axis("off")
            continue
        cell = np.unravel_index(int(held.argmax()), held.shape)
        _draw_cell(scene, grid, cell, ax=above)
        counts = placed.cells.histograms[cell]
        plot_histogram(counts, chaos_ratio=chaos_ratio, ax=below)
        if column:
            below.set_ylabel("")
    return figure


@figure("2.6", section="2.2.3–2.2.4", notebook=VOTE)
def path_band(scene, grid, placed) -> Figure:
    """From path band to places.

    Figure 2.6: (a) the band and its growth, (b) votes, (c) the places.

    Claim
    -----
    The band grows from the strongest cell; where perpendiculars to it meet, cameras go.

    Finding
    -------
    Every directed cell votes, as in the thesis's experiment; the band and its thinned line are
    drawn to show what would vote in their place.
    """
    figure, axes = plt.subplots(3, 1, figsize=(7.5, 10.5))
    order = cells.grow_band(placed.cells)
    for ax, name in zip(axes, ("(a) path band", "(b) votes", "(c) places"), strict=True):
        plot_ground(grid.area, walls=scene.walls, ax=ax)
        ax.set_title(name)
    image = plot_band(grid, order, cells.thin(order >= 0), ax=axes[0])
    figure.colorbar(image, ax=axes[0], label="joined in step", shrink=0.8)
    axes[0].legend(loc="lower right")
    plot_votes(grid, placed.votes, ax=axes[1])
    draw_cells(grid, placed.cells, ax=axes[2])
    axes[2].plot(
        *placed.places[[X, Y]].to_numpy().T,
        "^",
        ms=12,
        color=UPPER,
        mec="white",
        ls="",
        label="camera place",
    )
    cells_legend(axes[2], loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=3)
    return figure


@figure("2.10", section="2.3", notebook=VOTE)
def sample_cell(scene, grid, placed, *, chaos_ratio, walks=15) -> Figure:
    """A cell and its histogram.

    Figure 2.10: a directed cell with about so many walks.

    Claim
    -----
    A cell with 15 walks whose angles agree is given their direction.

    Finding
    -------
    The cell whose number of walks is nearest to 15 (its title says how many); no bin (grey) but
    the highest (red) and its neighbours (blue) reaches 0.8 of the highest.
    """
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.4), width_ratios=(1, 1.5))
    counts = np.where(placed.cells.directed, placed.cells.histograms.sum(axis=2), -(10**6))
    cell = np.unravel_index(int(np.abs(counts - walks).argmin()), counts.shape)
    _draw_cell(scene, grid, cell, ax=left)
    left.set_title(f"cell ({cell[0]}, {cell[1]})")
    plot_histogram(
        placed.cells.histograms[cell],
        chaos_ratio=chaos_ratio,
        title=f"{counts[cell]} walks",
        ax=right,
    )
    return figure


@figure(
    "2.11",
    section="2.3",
    notebook=VOTE,
    ids=("placement.corridor.humps", "placement.corridor.hump_error_m"),
)
def mesh(scene, grid, placed) -> Figure:
    """The mesh of votes and its humps.

    Figure 2.11: votes as a mesh, and the same from above.

    Claim
    -----
    Two humps, at grid cells (4, 4) and (5, 18), are the places for two cameras.
    """
    figure = plt.figure(figsize=(12, 4.4))
    figure.get_layout_engine().set(wspace=0.12)  # the mesh's own label takes no room
    left = figure.add_subplot(1, 2, 1, projection="3d")
    plot_mesh(grid, placed.votes, humps=placed.humps, ax=left)
    right = figure.add_subplot(1, 2, 2)
    plot_ground(grid.area, walls=scene.walls, ax=right)
    plot_votes(grid, placed.votes, humps=placed.humps, ax=right)
    right.legend(loc="upper right")
    return figure


@figure("votes-on-real-people", notebook=VOTE, ids=("placement.pets.humps",))
def real_votes(scene, grid, placed) -> Figure:
    """Votes of real people.

    Traces, cells and votes of a real scene.

    Question
    --------
    What do the votes say where people walk as they like?
    """
    figure, axes = plt.subplots(1, 3, figsize=(12, 4.2))
    for ax, name in zip(axes, ("traces", "cells (shaded: chaos)", "votes"), strict=True):
        plot_ground(grid.area, walls=scene.walls, ax=ax)
        ax.set_title(name)
    plot_traces(scene.traces, ax=axes[0])
    draw_cells(grid, placed.cells, ax=axes[1])
    plot_votes(grid, placed.votes, humps=placed.humps, ax=axes[2])
    axes[2].legend(loc="upper right")
    for ax in axes[1:]:
        ax.set_ylabel("")
    return figure


def draw_cells(grid: GridMap, directed: DirectedCells, *, ax: Axes) -> None:
    """The kinds and directions of cells."""
    return plot_cells(
        grid,
        directed.kind,
        directed.angle,
        magnitude=directed.magnitude,
        no_locus=NO_LOCUS,
        directed=DIRECTED,
        chaos=CHAOS,
        ax=ax,
    )


def _draw_cell(scene, grid, cell, *, ax):
    """The traces of one cell, as pixels of the map see it."""
    x, y = grid.place_of(*cell)
    half = grid.cell / 2
    area = (x - half, y - half, x + half, y + half)
    plot_ground(area, ax=ax)
    edges = np.arange(9) * grid.pixel
    ax.vlines(area[0] + edges, area[1], area[3], color=PALE, lw=0.4)
    ax.hlines(area[1] + edges, area[0], area[2], color=PALE, lw=0.4)
    near = (np.abs(scene.traces[X] - x) < 3 * half) & (np.abs(scene.traces[Y] - y) < 3 * half)
    near = scene.traces[TRACE].isin(scene.traces[TRACE][near])
    if near.any():
        plot_traces(scene.traces[near], alpha=0.8, ax=ax)
    ax.set(xlabel="", ylabel="", xticks=[], yticks=[])
    for spine in ax.spines.values():
        spine.set(visible=True, color=PALE)


@figure("plans", notebook=EXACT)
def plans(site, chosen) -> Figure:
    """Four ways to place the same cameras.

    One map a method: its cameras, and the walker-seconds they see square-on.

    Question
    --------
    Where do votes, ground seen, greed and proof put the cameras?

    Finding
    -------
    Green walker-seconds are seen square-on by some camera. Whoever maximises ground sees the
    corridor along its length.

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
        plot_ground(site.grid.area, walls=site.scene.walls, ax=ax)
        plot_served(site.targets, served, ax=ax)
        seen = square_on(site.targets, cameras, site.model, walls=site.scene.walls)
        plot_sights(cameras, site.targets, seen & served[:, None], ax=ax)
        plot_cameras(cameras, site.model, method=method, ax=ax)
        ax.set_title(f"{method}: {share:.0%} of walker-seconds")
    for ax in axes.flat[: len(chosen) - columns]:
        ax.set_xlabel("")
    served_legend(figure, reach=site.model.reach)
    for ax in axes.flat[len(chosen) :]:
        ax.axis("off")
    return figure


@figure(
    "price-of-voting",
    notebook=EXACT,
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
def price_of_voting(shares) -> Figure:
    """The price of voting.

    Held-out shares of every method on every scene, with intervals over walkers.

    Question
    --------
    How much less do voted cameras see, of people whom no method has seen?
    """
    scenes = shares["scene"].nunique()
    figure, ax = plt.subplots(figsize=(9, 1.6 + 0.62 * scenes))
    plot_shares(shares, ax=ax)
    return figure


@figure("how-many-cameras", notebook=EXACT, ids=("placement.corridor.fewest_for_0.6",))
def how_many(tables, *, required) -> Figure:
    """How many cameras?

    Held-out share against the number of cameras, one panel a scene.

    Question
    --------
    What does one more camera add? How many see 60 % of what they were chosen from?

    Parameters
    ----------
    tables : dict
        Scene → table from `comparison.shares_by_number`.
    required : float
        The share drawn as a line.
    """
    figure, axes = plt.subplots(1, len(tables), figsize=(5 * len(tables), 3.6), squeeze=False)
    for ax, (scene, table) in zip(axes.flat, tables.items(), strict=True):
        ax.axhline(required, color=INK, lw=1, ls=":")
        for method, rows in table.groupby("method", sort=False):
            style = {"color": CHOICE_COLOURS[method]}
            ax.plot(
                rows["cameras"],
                rows["share"],
                marker=CHOICE_MARKERS[method],
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


@figure("demands", notebook=EXACT, ids=("placement.demands.largest_gap",))
def demands(site, variants) -> Figure:
    """Other demands on the same program.

    Exact choices under other demands, one map each.

    Claim
    -----
    Places may be forbidden, cameras may cost, a gait may need two views.

    Finding
    -------
    Each is one more line in the integer program.

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
        plot_ground(site.grid.area, walls=site.scene.walls, ax=ax)
        if forbidden is not None:
            plot_forbidden(site.grid, forbidden, ax=ax)
        plot_served(site.targets, served, ax=ax)
        plot_cameras(cameras, site.model, method="exact", cones=False, ax=ax)
        ax.set_title(title)
    served_legend(figure)
    for ax in axes.flat[len(variants) :]:
        ax.axis("off")
    return figure


@figure(
    "master-and-slaves",
    notebook=EXACT,
    ids=(
        "control.corridor.awake_share",
        "control.corridor.square_share",
        "control.corridor.turning_share",
        "control.corridor.lagging_share",
    ),
)
def master_and_slaves(log, limits, lost, *, seconds=(60, 180)) -> Figure:
    """Master and slaves.

    Which camera is awake when, how fast each must pan, and what a slower one loses.

    Claim
    -----
    The overhead camera wakes the cameras and tells them how fast to pan (section 2.2.5).

    Parameters
    ----------
    log : control.pan_tilt.Log
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
    time = log.table[FRAME] / log.frame_rate
    shown = log.table[(time >= seconds[0]) & (time <= seconds[1])]
    plot_timeline(shown, log.frame_rate, cameras=len(log.cameras), ax=top)
    top.set(xlim=seconds, title="awake")
    needed = np.abs(log.table["needed"][log.table["awake"]])
    left.hist(needed, bins=40, color=LOWER)
    left.set(xlabel="pan rate that the walker asks for (degrees a second)")
    left.set_yscale("log" if len(needed) else "linear")
    left.set_ylabel("camera frames")
    right.plot(limits, lost, "o-", color=LOWER)
    right.set(xlabel="pan limit (degrees a second)", ylabel="time lost turning or lagging (share)")
    right.set_ylim(0, None)
    return figure
