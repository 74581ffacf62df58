"""The thesis's occlusion tables as charts, a cell as two walkers, a forecast over a frame.

Everything is drawn as the camera sees it: away is up, right is right, and S1, the walker with
the lesser abscissa, is on the left.  S1 is drawn solid and S2 dashed; what the tables say is
told apart by lightness, so it survives a grey print.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch, Rectangle
from matplotlib.patheffects import withStroke

from mcnlab.compass import DIRECTIONS, NAMES, heading_of
from mcnlab.errors import ArgumentError
from mcnlab.occlusion.thesis import (
    APART,
    BY_SPEED,
    CERTAIN,
    SIDES,
    Walker,
    direction_table,
    foresee,
    look_up,
    speed_table,
)
from mcnlab.plotting.style import (
    GREY,
    INK,
    LOWER,
    PALE,
    SKY,
    UPPER,
    WALKER_LINES,
    axes_or_new,
    frame_axes,
)
from mcnlab.walking.speed import LEVELS
from mcnlab.walking.speed import NAMES as SPEED_NAMES

RULE_COLOURS = {APART: "#f1f3f5", BY_SPEED: "#f2b134", CERTAIN: "#1d5fa8"}
RULE_INK = {APART: GREY, BY_SPEED: INK, CERTAIN: "white"}
RULE_LABELS = {APART: "0", BY_SPEED: "P(O|S)", CERTAIN: "1"}
RULE_MEANINGS = {APART: "no occlusion", BY_SPEED: "speed decides", CERTAIN: "certain occlusion"}
WALKER_COLOURS = (LOWER, UPPER)  # S1, S2
FORESEEN = SKY
FRAME_WIDTH, FRAME_HEIGHT = 352, 240  # of the drawn picture, as CASIA A's
PACES = {1: 0.008, 2: 0.04, 3: 0.08}  # one speed within each level, in frame widths a second
_HALO = (withStroke(linewidth=4, foreground="white"),)
_OUTLINE = (withStroke(linewidth=6, foreground="white"),)
_PAPER = {"boxstyle": "round,pad=0.2", "fc": "white", "ec": "none", "alpha": 0.85}


def plot_direction_table(ax: Axes | None = None, marked=None) -> Axes:
    """Table 3.1 as a chart: what two directions say.

    Parameters
    ----------
    ax : matplotlib.axes.Axes, optional
    marked : (int, int), optional
        D(S1) and D(S2) of a cell to frame.
    """
    if marked is not None:
        _check_cell(marked)
    ax = _table_axes(ax, (7.2, 6.6))
    table = direction_table()
    for one in DIRECTIONS:
        for two in DIRECTIONS:
            _draw_cell(ax, two, one, table[one - 1, two - 1])
    for direction in DIRECTIONS:
        angle = np.radians(heading_of(direction))
        way = 0.28 * np.array([np.sin(angle), -np.cos(angle)])  # rows run downwards
        for number, centre in enumerate([(-0.05, direction), (direction, 0.0)]):
            _draw_arrow(ax, centre - way, centre + way, number, size=13, lw=1.8)
        ax.text(-0.5, direction, f"{direction}  {NAMES[direction]}", ha="right", va="center")
        ax.text(direction, -0.5, f"{direction}", ha="center", va="center")
    ax.text(4.5, -0.95, "D(S2), the walker on the right", ha="center", color=UPPER)
    ax.text(-2.75, 4.5, "D(S1), the walker on the left", rotation=90, va="center", color=LOWER)
    ax.set(xlim=(-3.0, 8.6), ylim=(8.6, -1.2))
    if marked is not None:
        _mark(ax, marked)
    _rule_legend(ax, (APART, BY_SPEED, CERTAIN))
    return ax


def plot_speed_table(side, ax: Axes | None = None, marked=None) -> Axes:
    """Table 3.2 or 3.3 as a chart: what two speed levels say of walkers going the same way.

    Parameters
    ----------
    side : {"right", "left"}
        Both in directions 2, 3, 4 (Table 3.2) or in 6, 7, 8 (Table 3.3).
    ax : matplotlib.axes.Axes, optional
    marked : (int, int), optional
        V(S1) and V(S2) of a cell to frame.
    """
    table = speed_table(side)
    if marked is not None:
        _check_cell(marked, choices=LEVELS, what="speed levels")
    ax = _table_axes(ax, (4.6, 4.8))
    sign = 1 if side == "right" else -1
    for one in LEVELS:
        for two in LEVELS:
            rule = BY_SPEED if table[one - 1, two - 1] else APART
            _draw_cell(ax, two, one, rule, label="C" if rule == BY_SPEED else "0")
    for level in LEVELS:
        # Longer arrows for the faster.
        half = np.array([sign * (0.04 + 0.1 * level), 0.0])
        for number, centre in enumerate([(0.05, level), (level, 0.25)]):
            _draw_arrow(ax, centre - half, centre + half, number, size=13, lw=1.8)
        ax.text(-0.4, level, SPEED_NAMES[level], ha="right", va="center")
        ax.text(level, 0.0, SPEED_NAMES[level], ha="center", va="center")
    behind = "S1" if side == "right" else "S2"
    way = ", ".join(map(str, SIDES[side]))
    ax.text(2.0, -0.28, "V(S2), on the right", ha="center", color=UPPER)
    ax.text(-0.85, 2.0, "V(S1), on the left", rotation=90, va="center", color=LOWER)
    ax.set(xlim=(-0.95, 3.55), ylim=(3.55, -0.45))
    name = "3.2" if side == "right" else "3.3"
    ax.set_title(f"Table {name}: both in {way}, {behind} is behind")
    if marked is not None:
        _mark(ax, marked)
    meanings = {APART: RULE_MEANINGS[APART], BY_SPEED: "C: time and place decide"}
    _rule_legend(ax, meanings, meanings=meanings)
    return ax


def plot_two_walkers(direction1, direction2, level1, level2, ax: Axes | None = None) -> Axes:
    """One cell of the tables as two walkers in the camera's picture.

    Each has an arrow to where it is after three seconds, with a dot a second.  The paces,
    one within each speed level, and the starting places are made up; what is said below
    them is `occlusion.foresee` for these two.

    Parameters
    ----------
    direction1, direction2 : int
        D(S1) and D(S2), 1 … 8.
    level1, level2 : int
        V(S1) and V(S2), 1 … 3.
    ax : matplotlib.axes.Axes, optional
    """
    rule = int(look_up(direction1, direction2, level1, level2))
    ax = axes_or_new(ax)
    frame_axes(ax, FRAME_WIDTH, FRAME_HEIGHT)
    walkers = [
        made_walker(x, y, direction, level)
        for x, y, direction, level in zip(
            (0.34 * FRAME_WIDTH, 0.66 * FRAME_WIDTH),
            (0.47 * FRAME_HEIGHT, 0.53 * FRAME_HEIGHT),  # so that arrows do not cover each other
            (direction1, direction2),
            (level1, level2),
            strict=True,
        )
    ]
    said = foresee(*walkers, frame_width=FRAME_WIDTH, frame_height=FRAME_HEIGHT)
    for number, walker in enumerate(walkers):
        start, way = np.array([walker.x, walker.y]), np.array([walker.vx, walker.vy])
        slow = (level1, level2)[number] == LEVELS[0]  # an arrow with no room for dots
        _draw_arrow(ax, start, start + 3 * way, number, size=7 if slow else 12, lw=2)
        if not slow:
            dots = start + np.array([[1], [2]]) * way
            ax.plot(*dots.T, "o", ms=6, color=WALKER_COLOURS[number], mec="white", zorder=4.5)
    boxes = [(float(w.x) - 14, float(w.y) - 36, 28, 72) for w in walkers]
    plot_forecast(
        boxes,
        (direction1, direction2),
        (level1, level2),
        seconds=float(said.seconds),
        place=(float(said.x), float(said.y)),
        ax=ax,
    )
    what = RULE_MEANINGS[rule]
    if rule == BY_SPEED:
        what = "by speed: they meet" if said.occludes else "by speed, but outside the frame: none"
    ax.set_title(what)
    ax.set_xlabel("arrows: the next 3 s; dots: after 1 s and 2 s", fontsize=8)
    return ax


def plot_forecast(
    boxes, directions, levels, *, seconds, place, observed=None, ax: Axes | None = None
) -> Axes:
    """Two boxes with their directions and speeds, and the occlusion that is foreseen.

    To be drawn over a frame, so `ax` should show one already.

    Parameters
    ----------
    boxes : array_like, shape (2, 4)
        x, y, w, h of two walkers, pixels, in either order.
    directions, levels : array_like of int, shape (2,)
        D and V of the same two.
    seconds : float
        From now; inf for never.
    place : (float, float)
        Pixels.
    observed : (float, float, float), optional
        Seconds from now, x and y of the occlusion that there really was.
    ax : matplotlib.axes.Axes, optional
    """
    boxes = np.asarray(boxes, dtype=float)
    if boxes.shape != (2, 4) or not np.isfinite(boxes).all() or (boxes[:, 2:] <= 0).any():
        raise ArgumentError("boxes must be two finite boxes x, y, w, h; w and h are positive.")
    if len(directions) != 2 or len(levels) != 2:
        raise ArgumentError("directions and levels must hold one number a box: two each.")
    # Written so that NaN is refused, too.
    if not seconds >= 0 or (np.isfinite(seconds) and not np.isfinite(place).all()):
        raise ArgumentError(
            f"seconds is {seconds} and place {place}; pass seconds from now, at least 0 or "
            "inf for never, and a finite place."
        )
    if observed is not None and (np.shape(observed) != (3,) or not np.isfinite(observed).all()):
        raise ArgumentError(f"observed is {observed}; pass finite seconds, x and y.")
    if ax is None:
        ax = axes_or_new(ax)
        low, high = boxes[:, :2].min(axis=0), (boxes[:, :2] + boxes[:, 2:]).max(axis=0)
        frame_axes(ax, *high)
        ax.set(xlim=(low[0] - 40, high[0] + 40), ylim=(high[1] + 50, low[1] - 40))
    order = np.argsort(boxes[:, 0] + boxes[:, 2] / 2, kind="stable")
    for number, at in enumerate(order):
        _draw_box(
            ax, boxes[at], number, f"S{number + 1}  D{int(directions[at])}  V{int(levels[at])}"
        )
    if np.isfinite(seconds):
        shown, outside = _into_view(ax, place)
        said = f"foreseen in {seconds:.1f} s" + (", outside the frame" if outside else "")
        ax.plot(*shown, "X", ms=11, color=FORESEEN, mec=INK, mew=1.2, zorder=6, label=said)
    else:
        ax.plot([], [], ls="", label="foreseen: no occlusion")
    if observed is not None:
        late, *where = observed
        ring = {"mfc": "none", "mec": INK, "mew": 2, "ls": "", "path_effects": _HALO}
        shown, _ = _into_view(ax, where)
        ax.plot(*shown, marker="o", ms=15, zorder=6, label=f"observed in {late:.1f} s", **ring)
    legend = ax.legend(
        loc="lower center",
        frameon=True,
        framealpha=0.85,
        edgecolor="none",
        ncols=2,
        handlelength=1.2 if np.isfinite(seconds) or observed is not None else 0,
        markerscale=0.7,
    )
    legend.set_zorder(7)
    return ax


def _check_cell(cell, *, choices=DIRECTIONS, what="directions"):
    """Raise `ArgumentError` unless `cell` is two of `choices`."""
    if np.shape(cell) != (2,) or not np.isin(cell, choices).all():
        raise ArgumentError(
            f"marked is {cell!r}; pass two {what} {choices[0]} to {choices[-1]}, S1's first."
        )


def _table_axes(ax, size):
    """Axes without frame or ticks, of a new figure of that size if need be."""
    if ax is None:
        ax = plt.subplots(figsize=size)[1]
    ax.set_aspect("equal")
    ax.axis("off")
    return ax


def _draw_cell(ax, column, row, rule, *, label=None):
    """One cell: its fill and its label."""
    ax.add_patch(
        Rectangle((column - 0.5, row - 0.5), 1, 1, fc=RULE_COLOURS[rule], ec="white", lw=2)
    )
    label = RULE_LABELS[rule] if label is None else label
    ax.text(column, row, label, ha="center", va="center", color=RULE_INK[rule])


def _draw_arrow(ax, start, end, number, *, size, lw):
    """An arrow of S1 (`number` 0) or S2 (1)."""
    ax.annotate(
        "",
        xy=end,
        xytext=start,
        zorder=4,  # over the boxes
        arrowprops={
            "arrowstyle": "-|>",
            "color": WALKER_COLOURS[number],
            "lw": lw,
            "mutation_scale": size,
            "shrinkA": 0,
            "shrinkB": 0,
        },
    )


def _mark(ax, cell):
    """A heavy frame around the cell (row, column)."""
    row, column = cell
    ax.add_patch(
        Rectangle(
            (column - 0.5, row - 0.5),
            1,
            1,
            fill=False,
            ec=INK,
            lw=3,
            zorder=5,
            gid="marked",
            path_effects=_OUTLINE,
        )
    )


def _rule_legend(ax, rules, *, meanings=None):
    """What the fills mean, below the table."""
    if meanings is None:
        meanings = {rule: f"{RULE_LABELS[rule]}: {RULE_MEANINGS[rule]}" for rule in rules}
    handles = [Patch(fc=RULE_COLOURS[rule], ec=PALE, label=meanings[rule]) for rule in rules]
    ax.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, 0.0), ncols=len(rules))


def made_walker(x: float, y: float, direction: int, level: int) -> Walker:
    """A walker at a place who walks as its direction and speed level say."""
    pixels = PACES[int(level)] * FRAME_WIDTH
    angle = np.radians(heading_of(direction))
    way = pixels * np.sin(angle), -pixels * np.cos(angle)
    return Walker(x, y, int(direction), pixels, *way)


def _draw_box(ax, box, number, label):
    """S1's box with its label above it, or S2's with its label below."""
    x, y, w, h = box
    ax.add_patch(
        Rectangle(
            (x, y),
            w,
            h,
            fill=False,
            ec=WALKER_COLOURS[number],
            ls=WALKER_LINES[number],
            lw=2,
            path_effects=_HALO,
            zorder=3,
        )
    )
    above = number == 0
    place, _ = _into_view(ax, (x + w / 2, y if above else y + h), margin=0.08)
    ax.annotate(
        label,
        place,
        xytext=(0, 4 if above else -4),
        textcoords="offset points",
        ha="center",
        va="bottom" if above else "top",
        color=WALKER_COLOURS[number],
        fontsize=9,
        fontweight="bold",
        bbox=_PAPER,
        zorder=5,
    )


def _into_view(ax, place, *, margin=0.02):
    """The point of the axes' view nearest to `place`, and whether `place` lies outside it."""
    limits = np.array([sorted(ax.get_xlim()), sorted(ax.get_ylim())])
    place = np.asarray(place, dtype=float)
    outside = bool((place < limits[:, 0]).any() or (place > limits[:, 1]).any())
    border = margin * np.ptp(limits, axis=1)
    return np.clip(place, limits[:, 0] + border, limits[:, 1] - border), outside
