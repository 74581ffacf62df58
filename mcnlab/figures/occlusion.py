"""The figures of chapter 3, occlusion: the tables, the cases, and where the tables err."""

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from mcnlab.compass import DIRECTIONS, NAMES
from mcnlab.figures.registry import TABULATE, figure
from mcnlab.occlusion.composites import compose, compose_masks, start_frames
from mcnlab.plotting.occlusion import (
    RULE_LABELS,
    WALKER_COLOURS,
    plot_direction_table,
    plot_forecast,
    plot_speed_table,
)
from mcnlab.plotting.style import DENSITY, INK, PALE, frame_axes
from mcnlab.tables import FRAME, H, W, X, Y
from mcnlab.vision.recordings import silhouettes_of

_LEAST_WIDTH, _SHAPE = 352, 240 / 352  # pixels of a wide frame that are shown, and their shape
_STRIP = 0.16  # of the picture's height, below it
# What a composite's pixels look like: nobody, S1, S2, both.
_PAINT = mpl.colors.ListedColormap(["white", "#b7b7f5", "#f3c3ab", "#4a4a4a"])


@figure("table-3.1", section="3.3.1", notebook=TABULATE, ids=("occlusion.tables.cells_equal",))
def direction_table() -> Figure:
    """What two directions say.

    Claim
    -----
    64 pairs of directions: 21 occlude for certain, 25 do not, 18 depend on speed.

    Finding
    -------
    Made from the printed rules, every cell equals the printed one.
    """
    figure, ax = plt.subplots(figsize=(8.2, 7.4))
    plot_direction_table(ax)
    return figure


@figure("table-3.2", section="3.3.1", notebook=TABULATE, ids=("occlusion.tables.cells_equal",))
def speed_table_right() -> Figure:
    """What two speed levels say, both going right.

    Claim
    -----
    Going right, S1 is behind: time and place decide where it is the faster one.

    Finding
    -------
    Made from the rule, every cell equals the printed one.
    """
    figure, ax = plt.subplots(figsize=(5.2, 5.2))
    plot_speed_table("right", ax)
    return figure


@figure("table-3.3", section="3.3.1", notebook=TABULATE, ids=("occlusion.tables.cells_equal",))
def speed_table_left() -> Figure:
    """What two speed levels say, both going left.

    Claim
    -----
    Going left, S2 is behind: time and place decide where it is the faster one.

    Finding
    -------
    The mirror image of Table 3.2; every cell equals the printed one.
    """
    figure, ax = plt.subplots(figsize=(5.2, 5.2))
    plot_speed_table("left", ax)
    return figure


@figure("3.14", section="3.5", notebook=TABULATE, ids=("occlusion.cases.right",))
def cases_of_casia(judged, sources) -> Figure:
    """Cases of occlusion: two walks in one frame.

    Figure 3.14: the start, the decision and what really happens.

    Claim
    -----
    3 & 7 and 3 & 6, level v3 each: occlusion, successfully foreseen.

    Finding
    -------
    One composite stands for each case, chosen without a look at what happens; the notebook counts
    all that fit. Boxes cover each other before their centroids meet.

    Parameters
    ----------
    judged : pandas.DataFrame
        From `thesis_check.judge_cases`.
    sources : sequence of composing.Composites
        The same as there.
    """
    return _cases(judged[judged["figure"].str.startswith("3.14")], sources)


@figure(
    "3.15",
    section="3.5",
    notebook=TABULATE,
    ids=("occlusion.cases.right", "occlusion.cases.street.right"),
)
def cases_of_speed(judged, sources) -> Figure:
    """Cases of occlusion and of none.

    Figure 3.15: the start, the decision and what really happens; see Figure 3.14.

    Claim
    -----
    2 & 6, 3 & 7, and 3 & 3 with v3 and v1 occlude; 3 & 3 with v1 each do not.

    Finding
    -------
    The text of section 3.5 swaps (c) and (d); the captions are right. What nobody walks in CASIA
    A, such as v1 across the view, is taken from a made street.
    """
    return _cases(judged[judged["figure"].str.startswith("3.15")], sources)


@figure(
    "table-errors",
    notebook=TABULATE,
    ids=("occlusion.tables.right", "occlusion.tables.precision", "occlusion.tables.recall"),
)
def table_errors(counts) -> Figure:
    """Where the tables err.

    The 8×8 table of what happened, and of how often the tables and equations were wrong.

    Question
    --------
    What share of all composites occludes in each cell of Table 3.1?

    Finding
    -------
    Cells with a 1 fall short where walkers go along the line of sight, so that one leaves first;
    walkers of one level in a P cell may occlude all the same.

    Parameters
    ----------
    counts : pandas.DataFrame
        From `thesis_check.count_cells`.
    """
    figure, axes = plt.subplots(1, 2, figsize=(12.5, 5.9))
    cells = {name: counts[name].to_numpy().reshape(8, 8) for name in counts.columns[2:]}
    shares = {
        "occlude, of 100 composites": cells["occluded"],
        "tables and equations wrong, of 100": cells["n"] - cells["right"],
    }
    for ax, (title, part) in zip(axes, shares.items(), strict=True):
        share = np.ma.masked_array(part, cells["n"] == 0) / np.maximum(cells["n"], 1)
        _draw_shares(ax, share, cells)
        ax.set_title(title)
    return figure


def _draw_shares(ax, share, cells):
    """Shares as shades and numbers, what the thesis prints in each cell's corner."""
    ax.imshow(share, cmap=DENSITY, vmin=0, vmax=1, extent=(0.5, 8.5, 8.5, 0.5))
    for row, one in enumerate(DIRECTIONS):
        for column, two in enumerate(DIRECTIONS):
            empty = cells["n"][row, column] == 0
            dark = not empty and share[row, column] > 0.55
            ink = "white" if dark else INK
            text = "–" if empty else f"{100 * share[row, column]:.0f}"
            ax.text(two, one + 0.1, text, ha="center", va="center", color=ink, fontsize=11)
            code = RULE_LABELS[int(cells["printed"][row, column])]
            ax.text(two - 0.44, one - 0.3, code[0], va="center", color=ink, fontsize=8)
    ax.set(
        xticks=DIRECTIONS,
        yticks=DIRECTIONS,
        yticklabels=[f"{direction} {NAMES[direction]}" for direction in DIRECTIONS],
        xlabel="D(S2), on the right; small: Table 3.1, P for P(O|S)",
        ylabel="D(S1), on the left",
    )
    ax.grid(False)
    ax.tick_params(length=0)


def _cases(judged, sources):
    figure, axes = plt.subplots(len(judged), 3, figsize=(12, 2.95 * len(judged)), squeeze=False)
    figure.get_layout_engine().set(h_pad=0.08, w_pad=0.06)
    for row, strip in zip(judged.to_dict("records"), axes, strict=True):
        draw_case(row, sources[row["source"]].recording, strip)
    return figure


def draw_case(row, recording, axes) -> None:
    """One case: the first frame with both, the decision, and what really happens.

    Parameters
    ----------
    row : mapping
        From `thesis_check.judge_cases`.
    recording : Recording
        That it is from.
    axes : sequence of matplotlib.axes.Axes
        Three.
    """
    both = compose(recording, row["first"], row["second"], shift=row["shift"])
    names = (row["second"], row["first"]) if row["swapped"] else (row["first"], row["second"])
    happens = np.isfinite(row["seconds"])
    later = row["seconds"] if happens else row["left"]
    rate = recording.frame_rate
    last = row["frame"] + round(later * rate)
    frames = (max(start_frames(row["shift"])), row["frame"], last)
    titles = (
        f"{row['figure']}  {row['data']}, frame {frames[0]}",
        f"frame {frames[1]}: the decision",
        f"frame {last}: " + ("it happens" if happens else "the video ends"),
    )
    images = _paint(row, recording, names, frames)
    boxes = np.array([[_box_at(both, name, frame) for name in names] for frame in frames])
    for ax, shown, title, image in zip(axes, boxes, titles, images, strict=True):
        if image is not None:
            ax.imshow(image, cmap=_PAINT, vmin=0, vmax=3)
        _show_part(ax, recording, boxes.reshape(-1, 4))
        ax.set_title(title, fontsize=10)
        if ax is axes[0]:
            _outline(ax, shown)
            continue
        plot_forecast(
            shown,
            (row["direction1"], row["direction2"]),
            (row["level1"], row["level2"]),
            seconds=row["said_seconds"],
            place=(row["said_x"], row["said_y"]),
            observed=(later, row["x"], row["y"]) if happens and ax is axes[2] else None,
            ax=ax,
        )


def _show_part(ax, recording, boxes):
    """The part of the frame where they walk, and below it a strip to write on.

    CASIA A's frame is shown whole, of a wider one as much as is needed.
    """
    width, height = recording.frame_width, recording.frame_height
    low, high = boxes[:, :2].min(axis=0), (boxes[:, :2] + boxes[:, 2:]).max(axis=0)
    wide = min(width, max(_LEAST_WIDTH, 1.3 * (high - low)[0], 1.5 * (high - low)[1] / _SHAPE))
    tall = min(height, wide * _SHAPE)
    middle = (low + high) / 2
    left = np.clip(middle[0] - wide / 2, 0, width - wide)
    top = np.clip(middle[1] - tall / 2, 0, height - tall)
    frame_axes(ax, wide, tall)
    ax.set(xlim=(left, left + wide), ylim=(top + (1 + _STRIP) * tall, top))
    for spine in ax.spines.values():
        spine.set_visible(False)
    edge = {"fill": False, "ec": PALE, "lw": 1, "clip_on": False}
    ax.add_patch(plt.Rectangle((left, top), wide, tall, **edge))


def _box_at(both, name, frame):
    rows = both.sequence(name)
    return rows.loc[rows[FRAME] == frame, [X, Y, W, H]].to_numpy(float)[0]


def _outline(ax, boxes):
    """Both boxes, S1 solid and S2 dashed."""
    for (x, y, w, h), colour, style in zip(boxes, WALKER_COLOURS, ("-", "--"), strict=True):
        line = {"fill": False, "ec": colour, "lw": 1.6, "ls": style}
        ax.add_patch(plt.Rectangle((x - 0.5, y - 0.5), w, h, **line))


def _paint(row, recording, names, frames):
    """Which pixels are S1's, S2's and both's in each frame; None where nobody has images."""
    starts = dict(zip((row["first"], row["second"]), start_frames(row["shift"]), strict=True))
    masks = []
    for name in names:
        own = int(recording.sequence(name)[FRAME].iloc[0])
        masks.append(silhouettes_of(recording, name, np.array(frames) - starts[name] + own))
    if any(mask is None for mask in masks):
        return [None] * len(frames)
    return compose_masks(*masks)
