"""The figures of section 3.2.2: apparent speed, and what "apparent" costs."""

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from mcnlab.figures.registry import SPEED, figure
from mcnlab.plotting.speed import plot_by_distance, plot_by_level, plot_law, plot_levels
from mcnlab.walking.speed import FAST, PASSING, SLOW


@figure("apparent-law", notebook=SPEED)
def law(slow=SLOW, fast=FAST) -> Figure:
    """One walker, three levels.

    p against distance for three true speeds, over the levels.

    Claim
    -----
    How fast somebody seems depends on how near the camera he is (3.2.2).

    Finding
    -------
    p = f·v/Z: who walks at one speed passes through the levels by distance alone.
    """
    figure, ax = plt.subplots(figsize=(8, 4.2))
    plot_law(slow=slow, fast=fast, ax=ax)
    ax.set_title("Across the view of a camera 60° wide")
    return figure


@figure(
    "apparent-bins",
    notebook=SPEED,
    ids=(
        "speed.pets.v1.median_mps",
        "speed.pets.v2.median_mps",
        "speed.pets.v3.median_mps",
        "speed.pets.v2_faster_than_v3",
        "speed.pets.body_heights.v2_faster_than_v3",
        "speed.tud.v2_faster_than_v3",
        "speed.tud.body_heights.v2_faster_than_v3",
    ),
)
def true_speeds(tables, medians) -> Figure:
    """True speed within each level.

    True speeds by level, one picture a place.

    Question
    --------
    Does a higher level mean a faster walker?

    Parameters
    ----------
    tables : dict
        Title → table of `speed.compare_speeds` with ``level``.
    medians : dict
        Title → level → `results.Estimate` or None.
    """
    figure, axes = plt.subplots(1, len(tables), figsize=(5.5 * len(tables), 4.2), squeeze=False)
    for ax, (title, table) in zip(axes[0], tables.items(), strict=True):
        plot_by_level(table["true_speed"], table["level"], medians=medians[title], ax=ax)
        ax.set_title(title)
    return figure


@figure(
    "apparent-distance",
    notebook=SPEED,
    ids=(
        "speed.pets.pixels.distance_slope",
        "speed.pets.body_heights.distance_slope",
        "speed.pets.pixels.sideways_slope",
        "speed.pets.body_heights.sideways_slope",
        "speed.tud.pixels.sideways_slope",
        "speed.tud.body_heights.sideways_slope",
    ),
)
def against_distance(tables) -> Figure:
    """What distance does to speed, and what is left of it in body heights.

    Sideways speed over true sideways speed, against distance; a row a place.

    Claim
    -----
    Pixels a true metre, and body heights a true metre, against distance.

    Parameters
    ----------
    tables : dict
        Title → table of `speed.compare_speeds` with ``level``.
    """
    figure, axes = plt.subplots(
        len(tables), 2, figsize=(11, 3.7 * len(tables)), squeeze=False, sharex="row"
    )
    for line, (title, table) in zip(axes, tables.items(), strict=True):
        shown = table[table["true_sideways"] >= PASSING]
        for ax, name, label in zip(
            line,
            ("sideways", "body_heights_sideways"),
            ("pixels a true metre", "body heights a true metre"),
            strict=True,
        ):
            ratio = shown[name] / shown["true_sideways"]
            plot_by_distance(
                shown["distance"],
                ratio,
                shown["level"],
                ylabel=label,
                title=title,
                fit=True,
                legend=ax is axes[0, 0],
                ax=ax,
            )
        # Both as high, at least a decade: slopes can be compared.
        for ax in line if len(shown) else ():
            low, high = ax.get_ylim()
            middle, reach = (low * high) ** 0.5, max((high / low) ** 0.5, 3.0)
            ax.set_ylim(middle / reach, middle * reach)
    return figure


@figure(
    "casia-levels",
    notebook=SPEED,
    ids=(
        "speed.casia-a.d3.v3",
        "speed.casia-a.d6.v3",
        "speed.casia-a.d7.v3",
    ),
)
def casia_levels(directions, level) -> Figure:
    """The levels that CASIA A's walks get.

    Shares of the levels among the windows of each true direction.

    Claim
    -----
    Walkers in directions 3, 6 and 7 have level 3 (Figure 3.14).
    """
    figure, ax = plt.subplots(figsize=(9, 3.8))
    plot_levels(directions, level, ax=ax)
    return figure
