"""The figures of section 2.3: from an overhead video to traces on the grid map."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator

from mcnlab.cameras.homography import project
from mcnlab.figures.registry import ABOVE, figure
from mcnlab.plotting import vision
from mcnlab.plotting.placement import plot_ground, plot_traces
from mcnlab.plotting.style import FINDER_COLOURS, FLOW_COLOURS, FLOW_HATCHES, INK, UPPER
from mcnlab.plotting.vision import plot_flow, plot_frame
from mcnlab.tables import TRACE, X, Y

WHEEL = 64  # pixels


@figure("2.7", section="2.3", notebook=ABOVE)
def corridor_sequence(frames, *, frame_rate, count=6) -> Figure:
    """Corridor sequence.

    Figure 2.7: frames of the sequence, evenly spaced.

    Claim
    -----
    The corridor, filmed from the top floor.

    Finding
    -------
    The hall's video is not published; this is our own corridor, rendered, with truth.
    """
    figure, axes = plt.subplots(2, (count + 1) // 2, figsize=(11, 4.5))
    for ax in axes.flat[count:]:
        ax.axis("off")
    for ax, place in zip(axes.flat, np.linspace(0, len(frames) - 1, count), strict=False):
        plot_frame(frames[int(place)], title=f"{int(place) / frame_rate:.1f} s", ax=ax)
    return figure


@figure("2.8", section="2.3", notebook=ABOVE)
def flow_to_feet(frame, motion, mask, feet) -> Figure:
    """From optical flow to the bottom of the silhouette.

    Figure 2.8: (a) a frame, (b) its flow, (c) moving silhouettes and their feet.

    Claim
    -----
    Horn and Schunck's flow, made binary, shows the walkers; their lowest point is traced.

    Finding
    -------
    It does, for those who move; slow feet and still people are lost.
    """
    figure, axes = plt.subplots(1, 3, figsize=(12, 2.7))
    plot_frame(frame, title="(a) frame", ax=axes[0])
    draw_flow(motion, title="(b) optical flow, Horn–Schunck", ax=axes[1])
    plot_frame(255 - mask, title="(c) silhouettes and feet", feet=feet, ax=axes[2])
    return figure


@figure("finders", notebook=ABOVE)
def finders(frame, motions, masks) -> Figure:
    """Ways to find who moves.

    The same frame by every flow, and the silhouettes by every finder.

    Question
    --------
    What would one use today in place of Horn and Schunck?

    Finding
    -------
    Background subtraction keeps to the bodies; flow spreads over the floor about them.

    Parameters
    ----------
    frame : ndarray, shape (height, width)
    motions : dict
        Name → flow; above.
    masks : dict
        Name → mask; below.
    """
    columns = max(len(motions), len(masks))
    figure, axes = plt.subplots(2, columns, figsize=(3.2 * columns, 4.5), squeeze=False)
    largest = max(np.percentile(np.hypot(*np.moveaxis(m, -1, 0)), 99.8) for m in motions.values())
    for ax in axes[0, len(motions) :]:
        plot_frame(frame, title="frame", ax=ax)
    for ax, (name, motion) in zip(axes[0], motions.items(), strict=False):
        draw_flow(motion, largest=largest, title=f"flow: {name}", ax=ax)
    for ax in axes[1, len(masks) :]:
        ax.axis("off")
    for ax, (name, mask) in zip(axes[1], masks.items(), strict=False):
        plot_frame(255 - mask, title=f"moving: {name}", ax=ax)
    return figure


@figure(
    "2.9",
    section="2.3",
    notebook=ABOVE,
    ids=(
        "placement.corridor.background.recall",
        "placement.corridor.background.median_error_m",
        "placement.corridor.horn-schunck.recall",
        "placement.corridor.horn-schunck.median_error_m",
    ),
)
def traces_on_map(frame, homography, traces, truth, grid) -> Figure:
    """Traces over the view and on the grid map.

    Figure 2.9: traces over the overhead view, and on the grid map beside the truth.

    Claim
    -----
    A homography takes the traces to the grid map.

    Parameters
    ----------
    frame : ndarray, shape (height, width)
    homography : ndarray, shape (3, 3)
        Image to ground.
    traces : pandas.DataFrame
        Metres.
    truth : Scene
        True feet.
    grid : GridMap
    """
    figure, (left, right) = plt.subplots(1, 2, figsize=(12, 3.9), width_ratios=(1, 1.5))
    pixels = project(np.linalg.inv(homography), traces[[X, Y]].to_numpy())
    plot_frame(frame, title="overhead view", ax=left)
    plot_traces(
        traces.assign(**{X: pixels[:, 0], Y: pixels[:, 1]}),
        colour="#7fd3ff",
        alpha=0.7,
        lw=1.0,
        ax=left,
    )
    plot_ground(grid.area, walls=truth.walls, grid=grid, ax=right)
    colours = FINDER_COLOURS
    plot_traces(truth.traces, colour=colours["truth"], lw=1.6, label="truth", ax=right)
    plot_traces(
        traces, colour=colours["background"], alpha=0.9, label="background subtraction", ax=right
    )
    right.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    return figure


@figure(
    "flow-errors",
    notebook=ABOVE,
    ids=("flow.turning.horn-schunck.epe", "flow.turning.farneback.epe"),
)
def flow_errors(errors, examples) -> Figure:
    """End-point errors.

    Errors of every method on every sequence; a flow and its truth.

    Question
    --------
    How far is each flow from the truth, on average?

    Parameters
    ----------
    errors : pandas.DataFrame
        One row a sequence, one column a method, pixels.
    examples : tuple
        Name of a sequence, its true flow, and Horn and Schunck's.
    """
    name, truth, ours = examples
    figure = plt.figure(figsize=(11.5, 3.8))
    grid = figure.add_gridspec(1, 3, width_ratios=(1.5, 1, 1))
    bars = figure.add_subplot(grid[0])
    methods = list(errors.columns)
    for place, method in enumerate(methods):
        at = np.arange(len(errors)) + 0.8 * ((place + 0.5) / len(methods) - 0.5)
        bars.bar(
            at,
            errors[method],
            width=0.72 / len(methods),
            color=FLOW_COLOURS[method],
            hatch=FLOW_HATCHES[method],
            edgecolor="white",
            label=method,
        )
    bars.set_xticks(np.arange(len(errors)), errors.index, fontsize=8)
    bars.set(ylabel="end-point error (pixels)", yscale="log")
    bars.yaxis.set_minor_locator(LogLocator(subs=(2, 5)))
    for write in (bars.yaxis.set_major_formatter, bars.yaxis.set_minor_formatter):
        write(FuncFormatter(lambda value, _: f"{value:g}"))
    bars.grid(axis="x", visible=False)
    bars.legend(fontsize=8, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    known = np.isfinite(truth).all(axis=2)
    largest = float(np.hypot(truth[known][:, 0], truth[known][:, 1]).max())
    shown = np.where(known[..., None], truth, 0.0).astype(np.float32)
    draw_flow(shown, largest=largest, title=f"{name}: truth", ax=figure.add_subplot(grid[1]))
    title = f"{name}: Horn–Schunck, pyramid"
    draw_flow(ours, largest=largest, title=title, ax=figure.add_subplot(grid[2]))
    return figure


@figure(
    "pets-traces",
    notebook=ABOVE,
    ids=tuple(
        f"placement.pets.{method}.{name}"
        for method in ("background", "horn-schunck")
        for name in ("recall", "precision", "median_error_m")
    ),
)
def pets_traces(points, scores) -> Figure:
    """Real people on the ground.

    PETS 2009: traces by two finders, and how they score.

    Question
    --------
    How well do video and calibration alone tell where people's feet are?

    Parameters
    ----------
    points : dict
        Method → trace table with ``matched``.
    scores : dict
        Method → dict of name → Estimate.
    """
    columns = len(points) + 1
    figure, axes = plt.subplots(1, columns, figsize=(4 * columns, 4.3))
    everything = [table[[X, Y]].to_numpy() for table in points.values()]
    low = np.min([values.min(axis=0) for values in everything], axis=0) - 0.5
    high = np.max([values.max(axis=0) for values in everything], axis=0) + 0.5
    for ax, (method, table) in zip(axes[:-1], points.items(), strict=True):
        plot_ground((*low, *high), ax=ax)
        plot_traces(table, colour=FINDER_COLOURS[method], alpha=0.7, label="trace", ax=ax)
        wrong = table[~table["matched"].astype(bool)]
        ax.plot(wrong[X], wrong[Y], ".", ms=2.5, color=UPPER, label="nobody within 1 m")
        ax.set_title(f"{method}: {table[TRACE].nunique()} traces")
    for ax in axes[1:-1]:
        ax.set_ylabel("")
    axes[0].legend(loc="upper right", fontsize=8)
    right = axes[-1]
    names = ("recall", "precision")
    for place, (method, score) in enumerate(scores.items()):
        at = np.arange(len(names)) + 0.8 * ((place + 0.5) / len(scores) - 0.5)
        values = [score[name] for name in names]
        colour = FINDER_COLOURS[method]
        hatch = ("", "///", "...", "\\\\\\")[place % 4]
        label = f"{method}\n(median {score['median_error_m'].value:.2f} m)"
        shares = [value.value for value in values]
        width = 0.72 / len(scores)
        right.bar(
            at, shares, width=width, color=colour, hatch=hatch, edgecolor="white", label=label
        )
        lows = [value.value if value.low is None else value.low for value in values]
        highs = [value.value if value.high is None else value.high for value in values]
        right.vlines(at, lows, highs, color=INK)
    right.set_xticks(range(len(names)), names)
    right.set(ylim=(0, 1), ylabel="share within 1 m, second half of the video")
    right.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, fontsize=8)
    right.grid(axis="x", visible=False)
    return figure


def draw_flow(motion: np.ndarray, *, title: str, largest: float | None = None, ax: Axes) -> None:
    """A flow with its wheel; the fastest pixels, but for stray ones, at the rim."""
    if largest is None:
        largest = float(np.percentile(np.hypot(motion[..., 0], motion[..., 1]), 99.8))
    largest = max(largest, 0.1)
    colours = vision.colour_flow(motion, largest=largest)
    wheel = vision.colour_legend(WHEEL)
    return plot_flow(colours, wheel, largest=largest, title=title, ax=ax)
