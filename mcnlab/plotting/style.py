"""The look that all figures share: the same thing has the same colour everywhere."""

from pathlib import Path

import matplotlib.pyplot as plt
from matplotlib.axes import Axes

# Six hues that everybody can tell apart: at least 20 (CIEDE2000) between any two for who lacks
# red or green cones, lightness 8 apart for a grey print, contrast 3 on white.  Within one figure
# a hue has one meaning; what figures have in common has the same hue in all of them.
NIGHT, BROWN, BLUE = "#27143b", "#621400", "#3030e0"
ROSE, ORANGE, SKY = "#b13b62", "#d84e00", "#149dd8"
TRUTH = NIGHT  # where forecasts or finders are held against it

# From away to toward; left and right of a group differ by marker.
GROUP_COLOURS = {1: NIGHT, 2: BLUE, 3: SKY, 4: ORANGE, 5: BROWN}

METHOD_COLOURS = {"thesis, height": ROSE, "growth": SKY, "perspective": BLUE}

METHOD_MARKERS = {
    "thesis, height": "s",
    "growth": "^",
    "perspective": "o",
}

# Ways to choose places; told apart by marker too.
CHOICE_COLOURS = {
    "votes": ROSE,
    "area": ORANGE,
    "random": NIGHT,
    "greedy": SKY,
    "swaps": BROWN,
    "exact": BLUE,
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
    "background": BLUE,
    "horn-schunck": ROSE,
    "dis": BROWN,
    "farneback": SKY,
    "truth": TRUTH,
}

# Optical flows.
FLOW_COLOURS = {
    "horn-schunck": ROSE,
    "horn-schunck-plain": ORANGE,
    "farneback": SKY,
    "dis": BROWN,
}

FLOW_HATCHES = {
    "horn-schunck": "",
    "horn-schunck-plain": "///",
    "farneback": "\\\\\\",
    "dis": "...",
}

# Speed levels v1, v2, v3: darker is faster; told apart in grey, by marker and by hatch too.
SPEED_COLOURS = {1: SKY, 2: ROSE, 3: NIGHT}
SPEED_MARKERS = {1: "o", 2: "^", 3: "s"}
SPEED_HATCHES = {1: "", 2: "//", 3: "xx"}

# Ways to foresee occlusion; the two of our own are the dark ones.
FORECAST_COLOURS = {
    "thesis": ROSE,
    "constant-velocity": ORANGE,
    "uncertain-velocity": SKY,
    "perspective": BLUE,
    "learned": BROWN,
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

# Walks: filmed, made, made with noise, made with a limb cut.
WALK_COLOURS = {"real": BLUE, "made": SKY, "noisy": ORANGE, "cut": BROWN}

# Walker-seconds that some camera sees square-on, and the others.
SERVED_COLOURS = {True: "#005c3f", False: "#8a9099"}

DENSITY = "YlGnBu"
INK, GREY = "#222222", "#62676f"  # text, small print
FAINT = SERVED_COLOURS[False]  # data that others are laid over
PALE = "#b8bcc2"  # edges, grids: nothing that has to be read
UPPER, LOWER, MEAN = ORANGE, BLUE, INK
BAND = "#eef0f3"  # behind what is set apart: moving cameras, the time observed
WALKER_LINES = ("-", "--")  # the left one (S1), the right one (S2)
TICKS = (0, 0.25, 0.5, 0.75, 1)  # of shares


def use_style() -> None:
    """Give every figure mcnlab's look.

    Examples
    --------
    >>> import matplotlib as mpl
    >>> from mcnlab.plotting import use_style
    >>> use_style()
    >>> mpl.rcParams["axes.titlelocation"]
    'left'
    """
    plt.style.use(str(Path(__file__).parents[1] / "mcnlab.mplstyle"))


def axes_or_new(ax: Axes | None) -> Axes:
    """`ax`, or the axes of a new figure."""
    return plt.subplots()[1] if ax is None else ax


def frame_axes(ax, frame_width, frame_height) -> None:
    """Make axes an image frame: y downwards, pixels square, a thin border."""
    ax.set(xlim=(0, frame_width), ylim=(frame_height, 0), aspect="equal", xticks=[], yticks=[])
    ax.grid(False)
    for spine in ax.spines.values():
        spine.set(visible=True, color=PALE)
