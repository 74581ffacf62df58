"""Places on the ground: traces, grids, votes, cameras and what they see.

Metres, as on a map: x to the right, y upwards.
"""

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mcnlab.cameras.floor import GridMap
from mcnlab.plotting.style import (
    CHOICE_COLOURS,
    CHOICE_MARKERS,
    DENSITY,
    FAINT,
    GREY,
    INK,
    LOWER,
    PALE,
    SERVED_COLOURS,
    UPPER,
    axes_or_new,
)
from mcnlab.tables import TRACE, X, Y, split_sequences

CHAOS = "#f4c9a8"


def plot_ground(area, *, walls=None, grid=None, ax: Axes | None = None) -> Axes:
    """An empty map: the area, its walls, and the cells of a grid if given."""
    ax = axes_or_new(ax)
    left, bottom, right, top = area
    if walls is not None and len(walls):
        ax.add_collection(mpl.collections.LineCollection(walls, colors=INK, lw=2.4, zorder=4))
    if grid is not None:
        edges_x = grid.left + grid.cell * np.arange(grid.columns + 1)
        edges_y = grid.bottom + grid.cell * np.arange(grid.rows + 1)
        ax.vlines(edges_x, edges_y[0], edges_y[-1], color=PALE, lw=0.4, zorder=0.5)
        ax.hlines(edges_y, edges_x[0], edges_x[-1], color=PALE, lw=0.4, zorder=0.5)
    ax.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
    ax.set(xlabel="x (metres)", ylabel="y (metres)")
    ax.grid(False)
    return ax


def plot_traces(
    traces, *, colour=LOWER, alpha=0.35, lw=0.9, ends=False, label=None, ax: Axes | None = None
) -> Axes:
    """Traces from above, one thin line a walker.

    Parameters
    ----------
    traces : pandas.DataFrame
        A trace table.
    colour : colour, optional
    alpha, lw : float, optional
    ends : bool, optional
        Mark where each begins.
    label : str, optional
    ax : matplotlib.axes.Axes, optional
    """
    ax = axes_or_new(ax)
    places = traces[[X, Y]].to_numpy(float)
    lines = [places[rows] for _, rows in split_sequences(traces, key=TRACE)]
    ax.add_collection(
        mpl.collections.LineCollection(lines, colors=colour, alpha=alpha, lw=lw, label=label)
    )
    if ends:
        first = np.array([line[0] for line in lines])
        ax.plot(first[:, 0], first[:, 1], "o", ms=3, color=colour)
    return ax


def plot_patterns(
    patterns: np.ndarray, angles: np.ndarray, known: np.ndarray, *, figure: Figure
) -> list[Axes]:
    """Pixel patterns of a cell, each with the angle inferred from it (Figure 2.4)."""
    columns = (len(patterns) + 1) // 2
    axes = figure.subplots(2, columns)
    for ax, pattern, angle, sure in zip(axes.flat, patterns, angles, known, strict=False):
        size = len(pattern)
        ax.pcolormesh(
            np.where(pattern, 0.35, 1.0), vmin=0, vmax=1, cmap="gray", edgecolors=PALE, lw=0.4
        )
        if sure:
            along = 0.62 * size * np.array([np.cos(angle), np.sin(angle)])
            middle = _middle(pattern)
            ax.plot(*np.transpose([middle - along, middle + along]), color=UPPER, lw=1.8)
            ax.set_title(f"{np.degrees(angle):.0f}°", loc="center")
        else:
            ax.set_title("no angle", loc="center", fontweight="normal")
        ax.set(aspect="equal", xticks=[], yticks=[], xlim=(0, size), ylim=(0, size))
        ax.grid(False)
    for ax in axes.flat[len(patterns) :]:
        ax.axis("off")
    return axes


def plot_histogram(counts, *, chaos_ratio=0.8, title="", ax: Axes | None = None) -> Axes:
    """How many traces run at each angle through one cell, and the chaos rule (Figure 2.10).

    Parameters
    ----------
    counts : array_like, shape (8,)
    chaos_ratio : float, optional
    title : str, optional
    ax : matplotlib.axes.Axes, optional
    """
    ax = axes_or_new(ax)
    counts = np.asarray(counts)
    number = len(counts)
    angles = np.arange(number) * 180 / number
    highest = int(counts.argmax())
    apart = np.abs((np.arange(number) - highest + number // 2) % number - number // 2)
    colours = np.where(apart == 0, UPPER, np.where(apart == 1, LOWER, FAINT))
    ax.bar(angles, counts, width=0.86 * 180 / number, color=colours)
    if counts.max() > 0:
        ax.axhline(chaos_ratio * counts.max(), color=INK, lw=1, ls="--")
        ax.text(
            180 - 90 / number,
            chaos_ratio * counts.max(),
            f"{chaos_ratio:g} of the highest",
            ha="right",
            va="bottom",
            fontsize=8,
        )
    ax.set(xticks=angles, xlabel="angle of the trace (degrees)", ylabel="traces")
    ax.set_ylim(0, max(1.15 * counts.max(), 1))
    ax.set_xticklabels([f"{angle:g}" for angle in angles], fontsize=8)
    ax.grid(axis="x", visible=False)
    ax.yaxis.set_major_locator(mpl.ticker.MaxNLocator(integer=True))
    ax.set_title(title)
    return ax


def plot_cells(
    grid, kind, angle, *, magnitude=None, no_locus, directed, chaos, ax: Axes | None = None
) -> Axes:
    """Every cell's kind, and the direction of those that have one (Figures 2.5, 2.6).

    Parameters
    ----------
    grid : ground.GridMap
    kind : ndarray of int, shape (rows, columns)
    angle : ndarray, shape (rows, columns)
        Radians.
    magnitude : ndarray, shape (rows, columns), optional
        Thicker where more walked.
    no_locus, directed, chaos : int
        What the kinds are called.
    ax : matplotlib.axes.Axes, optional
    """
    ax = axes_or_new(ax)
    shades = np.ones((*grid.shape, 3))
    shades[kind == chaos] = mpl.colors.to_rgb(CHAOS)
    shades[kind == no_locus] = 1.0
    ax.imshow(shades, origin="lower", extent=_extent(grid), zorder=0)
    rows, columns = np.nonzero(kind == directed)
    if len(rows):
        x, y = grid.place_of(rows, columns)
        at = angle[rows, columns]
        half = 0.46 * grid.cell * np.stack([np.cos(at), np.sin(at)], axis=1)
        middle = np.stack([x, y], axis=1)
        if magnitude is None:
            widths = 1.4
        else:
            held = magnitude[rows, columns]
            widths = 0.6 + 2.4 * held / held.max()
        lines = mpl.collections.LineCollection(
            np.stack([middle - half, middle + half], axis=1),
            colors=INK,
            lw=widths,
        )
        ax.add_collection(lines)
    ax.grid(False)
    return ax


def cells_legend(ax: Axes, **options) -> None:
    """Say what `plot_cells` drew, beside what else has a label on the axes."""
    handles, _ = ax.get_legend_handles_labels()
    handles += [
        plt.Line2D([], [], color=INK, lw=1.6, label="direction of a cell (thick: more walks)"),
        mpl.patches.Patch(fc=CHAOS, label="chaos cell"),
    ]
    ax.legend(handles=handles, **options)


def plot_band(
    grid: GridMap, order: np.ndarray, thin: np.ndarray | None = None, *, ax: Axes | None = None
) -> Axes:
    """The path band, lighter the later a cell joined, and its thinned line (Figure 2.6).

    Parameters
    ----------
    grid : ground.GridMap
    order : ndarray of int, shape (rows, columns)
        In which step each cell joined; negative where it did not.
    thin : ndarray of bool, shape (rows, columns), optional
    ax : matplotlib.axes.Axes, optional
    """
    ax = axes_or_new(ax)
    shown = np.ma.masked_less(order, 0)
    image = ax.imshow(shown, origin="lower", extent=_extent(grid), cmap="viridis", vmin=0, zorder=1)
    if thin is not None:
        x, y = grid.place_of(*np.nonzero(thin))
        ax.plot(x, y, "s", color=UPPER, ms=3.2, label="thinned", zorder=3)
    ax.grid(False)
    return image


def plot_votes(grid, votes, *, humps=None, colourbar=True, ax: Axes | None = None) -> Axes:
    """Votes from above, darker where more perpendiculars pass, with the humps.

    Parameters
    ----------
    grid : ground.GridMap
    votes : ndarray, shape (rows, columns)
    humps : pandas.DataFrame, optional
        ``x, y, votes``.
    colourbar : bool, optional
    ax : matplotlib.axes.Axes, optional
    """
    ax = axes_or_new(ax)
    image = ax.imshow(
        votes, origin="lower", extent=_extent(grid), cmap=DENSITY, vmin=0, vmax=max(votes.max(), 1)
    )
    if humps is not None and len(humps):
        ax.plot(
            humps[X], humps[Y], "^", ms=10, mfc=UPPER, mec="white", mew=1.2, ls="", label="hump"
        )
    if colourbar:
        ax.figure.colorbar(image, ax=ax, label="perpendiculars", shrink=0.8)
    ax.grid(False)
    return ax


def plot_mesh(grid, votes, *, humps=None, most=60, ax: Axes | None = None) -> Axes:
    """The 3-D mesh of the votes (Figure 2.11).

    Parameters
    ----------
    grid : ground.GridMap
    votes : ndarray, shape (rows, columns)
    humps : pandas.DataFrame, optional
        ``row, column, x, y, votes``.
    most : int, optional
        Cells drawn along a side at most; a finer mesh is thinned.
    ax : mpl_toolkits.mplot3d.axes3d.Axes3D, optional
    """
    if ax is None:
        _, ax = plt.subplots(subplot_kw={"projection": "3d"})
    x, y = np.meshgrid(*grid.centres())
    rows, columns = (max(1, -(-size // most)) for size in votes.shape)
    ax.plot_surface(
        x,
        y,
        votes,
        rstride=rows,
        cstride=columns,
        cmap=DENSITY,
        vmin=0,
        edgecolor=INK,
        linewidth=0.2,
        antialiased=False,
    )
    if humps is not None:
        for hump in humps.itertuples():
            ax.text(
                hump.x,
                hump.y,
                1.04 * hump.votes,
                f"({hump.row}, {hump.column})",
                ha="center",
                zorder=9,
                fontsize=9,
            )
    ax.set(xlabel="x (metres)", ylabel="y (metres)", zlabel="perpendiculars")
    left, bottom, right, top = grid.area
    wide = right - left
    ax.set_box_aspect((wide, max(top - bottom, 0.4 * wide), 0.45 * wide), zoom=1.1)
    ax.xaxis.labelpad = 10
    ax.locator_params(axis="x", nbins=5)
    ax.locator_params(axis="y", nbins=3)
    return ax


def plot_cameras(
    cameras, model, *, method="exact", cones=True, label=None, ax: Axes | None = None
) -> Axes:
    """Cameras on a map; a cone shows what a fixed one sees, a ring how far a panning one.

    Parameters
    ----------
    cameras : pandas.DataFrame
        ``x, y, heading`` (degrees counter-clockwise from the x axis).
    model : coverage.CameraModel
    method : str, optional
        Whose colour and marker.
    cones : bool, optional
    label : str, optional
    ax : matplotlib.axes.Axes, optional
    """
    ax = axes_or_new(ax)
    colour = CHOICE_COLOURS[method]
    half = model.field_of_view / 2
    for camera in cameras.itertuples() if cones else ():
        middle = (camera.x, camera.y)
        ends = (0, 360) if model.pans else (camera.heading - half, camera.heading + half)
        reach = mpl.patches.Wedge(middle, model.reach, *ends, ec=colour, lw=0.8, ls=":")
        # Rings of cameras that pan cover most of a map: no tint.
        reach.set(facecolor="none" if model.pans else (colour, 0.12), zorder=0.6)
        ax.add_patch(reach)
    ax.plot(
        cameras[X],
        cameras[Y],
        CHOICE_MARKERS[method],
        color=colour,
        mec="white",
        mew=1.0,
        ms=10,
        ls="",
        zorder=6,
        label=label,
    )
    return ax


def plot_forbidden(grid, forbidden, *, ax: Axes | None = None) -> Axes:
    """Hatch the cells where no camera may stand."""
    ax = axes_or_new(ax)
    rows, columns = np.nonzero(forbidden)
    x, y = grid.place_of(rows, columns)
    corners = np.stack([x, y], axis=1) - grid.cell / 2
    squares = [plt.Rectangle(corner, grid.cell, grid.cell) for corner in corners]
    ax.add_collection(
        mpl.collections.PatchCollection(
            squares, facecolor="none", edgecolor=PALE, hatch="////", lw=0, zorder=0.6
        )
    )
    return ax


def plot_served(targets, served, *, ax: Axes | None = None) -> Axes:
    """Walker-seconds: dark where some chosen camera sees them square-on, pale elsewhere."""
    ax = axes_or_new(ax)
    served = np.asarray(served, bool)
    for seen, size in ((False, 3), (True, 5)):
        shown = targets[served == seen]
        ax.plot(shown[X], shown[Y], ".", color=SERVED_COLOURS[seen], ms=size, zorder=1)
    return ax


def plot_sights(
    cameras: pd.DataFrame, targets: pd.DataFrame, seen: np.ndarray, *, most: int = 16, ax=None
) -> Axes:
    """Lines of sight from cameras to what they see.

    Parameters
    ----------
    cameras, targets : pandas.DataFrame
        ``x, y``.
    seen : ndarray of bool, shape (targets, cameras)
    most : int, optional
        Lines drawn a camera at most, to targets spread over those seen.
    ax : matplotlib.axes.Axes, optional
    """
    ax = axes_or_new(ax)
    ends = targets[[X, Y]].to_numpy(float)
    lines = [
        (place, end)
        for place, own in zip(cameras[[X, Y]].to_numpy(float), np.transpose(seen), strict=True)
        for end in ends[own][:: max(1, -(-np.count_nonzero(own) // most))]
    ]
    ax.add_collection(
        mpl.collections.LineCollection(lines, colors=GREY, lw=0.7, alpha=0.8, zorder=0.9)
    )
    return ax


def served_legend(figure: Figure, *, reach: float | None = None) -> None:
    """Say below several maps what their dots are, and lines if cameras with a `reach` are drawn."""
    handles = [
        plt.Line2D([], [], ls="", marker=".", ms=9, color=SERVED_COLOURS[seen], label=name)
        for seen, name in ((True, "walker seen square-on"), (False, "walker not seen so"))
    ]
    if reach is not None:
        handles += [
            plt.Line2D([], [], color=GREY, lw=0.9, label="line of sight, square-on (some)"),
            plt.Line2D([], [], color=GREY, ls=":", label=f"reach of a camera, {reach:g} m"),
        ]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))


def plot_shares(table, *, ax: Axes | None = None) -> Axes:
    """Shares with intervals, one row a scene, one marker a method.

    Parameters
    ----------
    table : pandas.DataFrame
        ``scene, method, share, low, high``.
    ax : matplotlib.axes.Axes, optional
    """
    ax = axes_or_new(ax)
    scenes = list(dict.fromkeys(table["scene"]))
    methods = list(dict.fromkeys(table["method"]))
    for place, method in enumerate(methods):
        rows = table[table["method"] == method].set_index("scene").reindex(scenes)
        at = np.arange(len(scenes)) + 0.7 * ((place + 0.5) / len(methods) - 0.5)
        low = rows["low"].fillna(rows["share"])
        high = rows["high"].fillna(rows["share"])
        ax.hlines(at, low, high, color=CHOICE_COLOURS[method], lw=1.6)
        ax.plot(
            rows["share"],
            at,
            CHOICE_MARKERS[method],
            color=CHOICE_COLOURS[method],
            ls="",
            ms=6,
            label=method,
        )
    ax.set(yticks=np.arange(len(scenes)), ylim=(len(scenes) - 0.5, -0.5), xlim=(0, 1))
    ax.set_yticklabels(scenes)
    ax.grid(axis="y", visible=False)
    ax.set_xlabel("walker-seconds seen square-on (share)")
    ax.legend(ncols=len(methods), loc="lower center", bbox_to_anchor=(0.5, 1.0), columnspacing=1.2)
    return ax


def _extent(grid):
    left, bottom, right, top = grid.area
    return left, right, bottom, top


def _middle(pattern):
    row, column = np.nonzero(pattern)
    return np.array([column.mean() + 0.5, row.mean() + 0.5])
