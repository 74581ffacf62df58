"""The look that all figures share: the same thing has the same colour everywhere."""

from pathlib import Path

import matplotlib.pyplot as plt

# From away to toward; told apart in grey too, by lightness and marker.
GROUP_COLOURS = {1: "#14213d", 2: "#1d5fa8", 3: "#3fb18f", 4: "#f2b134", 5: "#d1495b"}

METHOD_COLOURS = {
    "thesis, height": "#8d6a9f",
    "growth": "#3fb18f",
    "perspective": "#1d5fa8",
}

METHOD_MARKERS = {
    "thesis, height": "s",
    "growth": "^",
    "perspective": "o",
}

# Ways to choose places; told apart by marker too.
CHOICE_COLOURS = {
    "votes": "#8d6a9f",
    "area": "#f2b134",
    "random": "#8a9099",
    "greedy": "#3fb18f",
    "swaps": "#14213d",
    "exact": "#1d5fa8",
}

CHOICE_MARKERS = {
    "votes": "s",
    "area": "D",
    "random": "x",
    "greedy": "^",
    "swaps": "v",
    "exact": "o",
}

# Ways to find who moves.
FINDER_COLOURS = {
    "background": "#1d5fa8",
    "horn-schunck": "#8d6a9f",
    "dis": "#14213d",
    "farneback": "#3fb18f",
    "truth": "#222222",
}

# Optical flows.
FLOW_COLOURS = {
    "horn-schunck": "#8d6a9f",
    "horn-schunck-plain": "#c9b6d6",
    "farneback": "#3fb18f",
    "dis": "#14213d",
}

FLOW_HATCHES = {
    "horn-schunck": "",
    "horn-schunck-plain": "///",
    "farneback": "\\\\\\",
    "dis": "...",
}

# Speed levels v1, v2, v3: darker is faster; told apart in grey, by marker and by hatch too.
SPEED_COLOURS = {1: "#f0a63c", 2: "#c0436a", 3: "#3b1f5b"}
SPEED_MARKERS = {1: "o", 2: "^", 3: "s"}
SPEED_HATCHES = {1: "", 2: "//", 3: "xx"}

# Ways to foresee occlusion; the two of our own are the dark ones.
FORECAST_COLOURS = {
    "thesis": "#8d6a9f",
    "constant-velocity": "#f2b134",
    "uncertain-velocity": "#3fb18f",
    "perspective": "#1d5fa8",
    "learned": "#14213d",
}

FORECAST_MARKERS = {
    "thesis": "s",
    "constant-velocity": "D",
    "uncertain-velocity": "v",
    "perspective": "o",
    "learned": "^",
}

FORECAST_LINES = {
    "thesis": ":",
    "constant-velocity": "--",
    "uncertain-velocity": (0, (6, 1.5, 1.5, 1.5, 1.5, 1.5)),
    "perspective": "-.",
    "learned": "-",
}

DENSITY = "YlGnBu"
INK, PALE = "#222222", "#b8bcc2"
UPPER, LOWER, MEAN = "#d1495b", "#1d5fa8", "#222222"
BAND = "#eef0f3"  # behind what is set apart: moving cameras, the time observed
WALKER_LINES = ("-", "--")  # the left one (S1), the right one (S2)
TICKS = (0, 0.25, 0.5, 0.75, 1)  # of shares


def use_style():
    """Give every figure mcnlab's look."""
    plt.style.use(str(Path(__file__).parents[1] / "mcnlab.mplstyle"))


def axes_or_new(ax):
    """`ax`, or the axes of a new figure."""
    return plt.subplots()[1] if ax is None else ax


def frame_axes(ax, frame_width, frame_height):
    """Make axes an image frame: y downwards, pixels square, a thin border."""
    ax.set(xlim=(0, frame_width), ylim=(frame_height, 0), aspect="equal", xticks=[], yticks=[])
    ax.grid(False)
    for spine in ax.spines.values():
        spine.set(visible=True, color=PALE)
