"""Walks in an image: boxes, curves, phases and headings.

A direction's group has its colour, the direction its marker, which points the way the
walker goes.
"""

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.legend import Legend

from mcnlab.compass import DIRECTIONS, NAMES, heading_of, turn_between
from mcnlab.plotting.style import (
    FAINT,
    GROUP_COLOURS,
    INK,
    LOWER,
    MEAN,
    METHOD_COLOURS,
    METHOD_MARKERS,
    PALE,
    UPPER,
    axes_or_new,
    frame_axes,
)
from mcnlab.tables import FRAME, H, W, X, Y
from mcnlab.walking.direction import GROUP_NAMES, GROUPS, group_of

LEFT = (6, 7, 8)  # directions that go left
_ARROWHEAD = np.array([[0, 1.0], [0.75, -0.8], [0, -0.35], [-0.75, -0.8], [0, 1.0]])


def colour_of(direction: int) -> str:
    """The colour of a direction 1 … 8: its group's."""
    return GROUP_COLOURS[int(group_of(direction))]


def marker_of(direction: int) -> tuple | str:
    """The marker of a direction 1 … 8: an arrowhead that points the way."""
    angle = np.radians(heading_of(direction))
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return mpl.path.Path(_ARROWHEAD @ turn, closed=True)


def direction_style(direction: int, *, size: float = 6) -> dict:
    """How to draw a direction's points: colour and marker, hollow where it goes left."""
    colour = colour_of(direction)
    face = "none" if direction in LEFT else colour
    return {"color": colour, "marker": marker_of(direction), "mfc": face, "ms": size}


def plot_directions(ax: Axes | None = None) -> Axes:
    """The eight directions seen from above, the camera in the south (Figure 3.2)."""
    ax = axes_or_new(ax)
    for direction in DIRECTIONS:
        angle = np.radians(heading_of(direction))
        tip = np.array([np.sin(angle), np.cos(angle)])
        ax.annotate(
            "",
            xy=tip,
            xytext=(0, 0),
            arrowprops={"arrowstyle": "-|>", "lw": 2, "color": colour_of(direction)},
        )
        ax.text(
            *(1.28 * tip),
            f"{direction}\n{NAMES[direction]}",
            ha="center",
            va="center",
            color=INK,
            linespacing=1.1,
        )
    ax.plot(0, -1.95, marker="s", ms=14, color=INK)
    ax.plot(0, -1.80, marker="^", ms=9, color=INK)
    ax.text(0.16, -1.93, "camera", va="center")
    ax.plot([0, 0], [-1.7, -1.5], color=INK, lw=1, ls=":")
    ax.set(xlim=(-1.9, 1.9), ylim=(-2.1, 1.6), aspect="equal", title="Directions, from above")
    ax.axis("off")
    return ax


def plot_boxes(
    boxes, *, frame_width, frame_height, every=8, direction=None, ax: Axes | None = None
) -> Axes:
    """A walk's boxes in the frame, from pale (first) to dark (last)."""
    ax = axes_or_new(ax)
    shown = boxes.iloc[::every]
    colour = INK if direction is None else colour_of(direction)
    for share, row in zip(np.linspace(0.25, 1, len(shown)), shown.itertuples(), strict=True):
        ax.add_patch(
            plt.Rectangle((row.x, row.y), row.w, row.h, fill=False, ec=colour, alpha=share, lw=1.2)
        )
    last = shown.iloc[-1]
    ax.text(last[X] + last[W] / 2, last[Y] - 4, "last", ha="center", va="bottom", fontsize=8)
    frame_axes(ax, frame_width, frame_height)
    if direction is not None:
        ax.set_title(f"{direction}: {NAMES[direction]}")
    return ax


def plot_curves(walks, dimension, *, ax: Axes | None = None) -> Axes:
    """Box height or width against frame number, one curve a walk (Figures 3.4, 3.5).

    Parameters
    ----------
    walks : dict
        Direction → box table of one walk.
    dimension : {"h", "w"}
    ax : matplotlib.axes.Axes, optional
    """
    ax = axes_or_new(ax)
    for direction, boxes in walks.items():
        ax.plot(
            boxes[FRAME],
            boxes[dimension],
            color=colour_of(direction),
            marker=marker_of(direction),
            markevery=12,
            label=f"{direction} {NAMES[direction]}",
        )
    name = {"h": "height", "w": "width"}[dimension]
    ax.set(xlabel="frame", ylabel=f"box {name} (pixels)", ylim=(0, None))
    ax.legend(title="direction", ncols=2)
    return ax


def plot_mask(mask, *, box=None, title="", ax: Axes | None = None) -> Axes:
    """A silhouette, dark on white, with its box."""
    ax = axes_or_new(ax)
    ax.imshow(255 - np.asarray(mask), vmin=0, vmax=255, cmap="gray")
    if box is not None:
        x, y, w, h = box
        ax.add_patch(plt.Rectangle((x - 0.5, y - 0.5), w, h, fill=False, ec=UPPER, lw=1.6))
    ax.set_title(title, fontsize=9, fontweight="normal")
    ax.set(xticks=[], yticks=[])
    ax.grid(False)
    for spine in ax.spines.values():
        spine.set(visible=True, color=PALE)
    return ax


def plot_phase(
    phase,
    *,
    dimension="h",
    parts=("extrema", "envelope", "mean"),
    legend=True,
    ax: Axes | None = None,
) -> Axes:
    """A curve with what the thesis lays over it (Figures 3.8 to 3.11).

    Parameters
    ----------
    phase : phase.Phase
    dimension : {"h", "w"}, optional
    parts : iterable of {"extrema", "soft", "trend", "envelope", "mean"}, optional
    legend : bool, optional
    ax : matplotlib.axes.Axes, optional
    """
    ax = axes_or_new(ax)
    name = {"h": "height", "w": "width"}[dimension]
    ax.plot(phase.frames, phase.curve, color=FAINT, label=f"box {name}")
    if "extrema" in parts:
        at = phase.maxima
        ax.plot(phase.frames[at], phase.curve[at], "^", color=UPPER, label="maxima")
        at = phase.minima
        ax.plot(phase.frames[at], phase.curve[at], "v", color=LOWER, label="minima")
    if "soft" in parts:
        at = phase.soft
        ax.plot(phase.frames[at], phase.curve[at], "x", color=INK, ms=7, mew=2, label="soft")
    for part, lines in {
        "trend": (("regression", phase.trend, INK, ":"),),
        "envelope": (
            ("upper envelope", phase.upper, UPPER, "-"),
            ("lower envelope", phase.lower, LOWER, "-"),
        ),
        "mean": ((f"phase, {phase.mean.slope:+.2f} px/frame", phase.mean, MEAN, "--"),),
    }.items():
        for label, line, colour, style in lines if part in parts else ():
            ends = phase.frames[[0, -1]]
            ax.plot(ends, line.at(ends), color=colour, ls=style, label=label)
    ax.set(xlabel="frame", ylabel=f"box {name} (pixels)")
    if legend:
        ax.legend()
    return ax


def plot_phases(
    phases,
    directions,
    *,
    separators=None,
    label="phase (pixels a frame)",
    legend=True,
    ax: Axes | None = None,
) -> Axes:
    """Phase against video, one marker a direction, separators as lines (3.12, 3.13).

    Parameters
    ----------
    phases : array_like, shape (n,)
    directions : array_like, shape (n,)
        1 … 8.
    separators : direction.LinearSeparators, optional
    label : str, optional
        The phase's name and unit.
    legend : bool, optional
    ax : matplotlib.axes.Axes, optional
    """
    ax = axes_or_new(ax)
    phases, directions = np.asarray(phases), np.asarray(directions)
    for direction in DIRECTIONS:
        values = phases[directions == direction]
        if len(values):
            aside = 0.2 if direction in LEFT else -0.2  # mirror images do not cover each other
            ax.plot(
                1 + aside + np.arange(len(values)),
                values,
                ls="",
                **direction_style(direction),
                label=f"{direction} {NAMES[direction]}",
            )
    if separators is not None:
        for cut in separators.cuts_[np.isfinite(separators.cuts_)]:
            ax.axhline(cut, color=INK, lw=1, ls="--")
    ax.set(xlabel="video of that direction", ylabel=label)
    if legend:
        ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), title="direction")
    return ax


def plot_phase_space(
    space, directions, *, x="sideways", y="height_growth", ax: Axes | None = None
) -> Axes:
    """Two phases of every walk against each other, one marker a direction."""
    ax = axes_or_new(ax)
    directions = np.asarray(directions)
    for direction in DIRECTIONS:
        rows = space[directions == direction]
        ax.plot(
            rows[x],
            rows[y],
            ls="",
            **direction_style(direction),
            label=f"{direction} {NAMES[direction]}",
        )
    ax.set(
        xlabel="sideways speed (body heights a second)",
        ylabel="relative growth of height (1/s)",
    )
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), title="direction")
    return ax


def plot_heading_errors(
    errors, directions, *, limit=22.5, most=60.0, ax: Axes | None = None
) -> Axes:
    """Heading errors by true direction, with the band in which the direction is right.

    Errors beyond `most` degrees are drawn at the edge, and counted there.
    """
    ax = axes_or_new(ax)
    errors, directions = np.asarray(errors), np.asarray(directions)
    beyond = int(np.count_nonzero(np.abs(errors) > most))
    errors = np.clip(errors, -most, most)
    ax.axhspan(-limit, limit, color="#eef3f8", zorder=0)
    for direction in DIRECTIONS:
        values = np.sort(errors[directions == direction])
        if len(values):
            spread = np.linspace(-0.32, 0.32, len(values))
            ax.plot(
                direction + spread,
                values,
                ls="",
                **direction_style(direction, size=4),
            )
    ax.axhline(0, color=INK, lw=0.8)
    largest = max(1.15 * limit, 1.05 * float(np.abs(errors).max(initial=0)))
    ax.set(
        xticks=DIRECTIONS,
        xticklabels=[f"{direction}\n{NAMES[direction]}" for direction in DIRECTIONS],
        xlabel="true direction",
        ylabel="heading error (degrees)",
        xlim=(0.4, 8.6),
        ylim=(-largest, largest),
    )
    if beyond:
        note = f"{beyond} of {len(errors)} beyond ±{most:.0f}°, drawn at the edge"
        ax.text(0.99, 0.03, note, transform=ax.transAxes, ha="right", fontsize=8, color=INK)
    return ax


def plot_lines(
    x, curves, *, xlabel, ylabel="right answers (share)", ax: Axes | None = None
) -> Axes:
    """Accuracy, or another share, against one variable; intervals as bars.

    Parameters
    ----------
    x : array_like, shape (n,)
    curves : dict
        Method → list of `results.Estimate` or of floats, one an x.
    xlabel, ylabel : str
    ax : matplotlib.axes.Axes, optional
    """
    ax = axes_or_new(ax)
    x = np.asarray(x, dtype=float)
    for number, (method, estimates) in enumerate(curves.items()):
        values = np.array([getattr(one, "value", one) for one in estimates], dtype=float)
        style = {
            "color": METHOD_COLOURS.get(method, INK),
            "marker": METHOD_MARKERS.get(method, "o"),
            "label": method,
        }
        if all(getattr(one, "low", None) is not None for one in estimates):
            bars = [[one.value - one.low, one.high - one.value] for one in estimates]
            shift = 0.004 * np.ptp(x) * (number - (len(curves) - 1) / 2)
            # Rounding must not turn an empty bar negative.
            bars = np.maximum(np.array(bars).T, 0)
            ax.errorbar(x + shift, values, yerr=bars, capsize=2, elinewidth=1, **style)
        else:
            ax.plot(x, values, **style)
    ax.set(xlabel=xlabel, ylabel=ylabel)
    ax.legend()
    return ax


def plot_horizon(boxes, camera, *, ax: Axes | None = None) -> Axes:
    """Box height against the row of the feet, and the line that shows the horizon."""
    ax = axes_or_new(ax)
    feet = (boxes[Y] + boxes[H]).to_numpy()
    ax.plot(boxes[H], feet, ".", ms=3, color=GROUP_COLOURS[3], label="boxes")
    if camera.horizon is not None:
        reach = np.array([0.0, 1.05 * boxes[H].max()])
        ax.plot(reach, camera.horizon + camera.feet * reach, color=INK, label="fit")
        ax.axhline(camera.horizon, color=UPPER, ls="--", label=f"horizon, row {camera.horizon:.0f}")
    ax.invert_yaxis()
    ax.set(xlabel="box height (pixels)", ylabel="row of the feet (pixels)", xlim=(0, None))
    ax.legend()
    return ax


def plot_against_truth(true, said, *, ax: Axes | None = None) -> Axes:
    """Headings here against true headings, degrees, wrapped to one turn."""
    ax = axes_or_new(ax)
    true = np.asarray(true) % 360
    said = true + turn_between(said, true)
    ax.plot([0, 360], [0, 360], color=INK, lw=0.8)
    for side in (-45, 45):
        ax.plot([0, 360], [side, 360 + side], color=PALE, lw=0.8, ls="--")
    ax.plot(true, said, ".", color=METHOD_COLOURS["perspective"], ms=4, alpha=0.7)
    ticks = np.arange(0, 361, 45)
    ax.set(
        xticks=ticks,
        yticks=ticks,
        xlim=(0, 360),
        ylim=(-50, 410),
        xlabel="true heading against the line of sight (degrees)",
        ylabel="heading from boxes (degrees)",
        aspect="equal",
    )
    return ax


def group_legend(ax: Axes) -> Legend:
    """Legend entries for the five groups."""
    handles = [
        mpl.lines.Line2D([], [], color=GROUP_COLOURS[group], marker="o", ls="", label=name)
        for group, name in zip(GROUPS, GROUP_NAMES.values(), strict=True)
    ]
    ax.legend(handles=handles, title="direction")
    return ax
