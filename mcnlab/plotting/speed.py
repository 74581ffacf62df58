"""Apparent speed: windows over distance, true speed by level, levels by direction.

A level has its colour and its marker everywhere.
"""

import matplotlib.ticker
import numpy as np
from matplotlib.axes import Axes

from mcnlab.compass import DIRECTIONS
from mcnlab.compass import NAMES as WAYS
from mcnlab.plotting.style import INK, SPEED_COLOURS, SPEED_HATCHES, SPEED_MARKERS, axes_or_new
from mcnlab.regression import fit_lines_robust
from mcnlab.walking.speed import FAST, LEVELS, NAMES, SLOW


def plot_law(
    speeds=(0.7, 1.4, 2.8),
    *,
    field_of_view=60.0,
    near=2.0,
    far=40.0,
    slow=SLOW,
    fast=FAST,
    ax: Axes | None = None,
) -> Axes:
    """p of somebody who walks across the view, against his distance: p = f·v/Z.

    Parameters
    ----------
    speeds : sequence of float, optional
        True speeds, m/s.
    field_of_view : float, optional
        Of the camera, degrees across.
    near, far : float, optional
        Range of the distance, metres.
    slow, fast : float, optional
        Thresholds, shares of the frame's width; each level's band has its colour.
    ax : matplotlib.axes.Axes, optional
    """
    ax = axes_or_new(ax)
    distance = np.geomspace(near, far, 200)
    widths = 0.5 / np.tan(np.radians(field_of_view) / 2)  # focal length in frame widths
    bounds = (0.002, slow, fast, 1.0)
    for level, low, high in zip(LEVELS, bounds[:-1], bounds[1:], strict=True):
        ax.axhspan(100 * low, 100 * high, color=SPEED_COLOURS[level], alpha=0.22, lw=0)
        middle = 100 * np.sqrt(low * high)
        ax.text(
            0.985, middle, NAMES[level], transform=ax.get_yaxis_transform(), ha="right", va="center"
        )
    for speed, style in zip(speeds, ("-", "--", "-.", ":"), strict=False):
        share = 100 * widths * speed / distance
        ax.plot(distance, share, color=INK, ls=style, label=f"{speed:g} m/s")
    _distance_axis(ax)
    ax.set(
        yscale="log",
        ylim=(0.2, 100),
        xlim=(near, far),
        ylabel="p (% of the frame's width)",
    )
    _log_ticks(ax.yaxis)
    ax.legend(title="true speed", loc="lower left", ncols=len(speeds))
    return ax


def plot_by_distance(
    distance,
    values,
    level,
    *,
    ylabel,
    title="",
    cuts=(),
    fit=False,
    legend=True,
    ax: Axes | None = None,
) -> Axes:
    """One marker a window: a measure of speed against the walker's distance, both logarithmic.

    Parameters
    ----------
    distance, values : array_like, shape (n,)
        Metres, and the measure; windows where it is 0 have no place on the scale.
    level : array_like, shape (n,)
        1, 2, 3.
    ylabel : str
        The measure and its unit.
    title : str, optional
    cuts : sequence of float, optional
        Where the levels meet, in the measure's unit.
    fit : bool, optional
        Draw the robust line, and say its slope in the title.
    legend : bool, optional
    ax : matplotlib.axes.Axes, optional
    """
    ax = axes_or_new(ax)
    distance, values, level = (np.asarray(held) for held in (distance, values, level))
    shown = values > 0
    for one in LEVELS:
        at = shown & (level == one)
        ax.plot(
            distance[at],
            values[at],
            ls="",
            marker=SPEED_MARKERS[one],
            ms=4,
            mec="white",
            mew=0.3,
            color=SPEED_COLOURS[one],
            label=NAMES[one],
        )
    for cut in cuts:
        if cut > 0:
            ax.axhline(cut, color=INK, lw=0.9, ls="--")
    if fit and len(np.unique(distance[shown])) > 1:
        line = fit_lines_robust(np.log(distance[shown]), np.log(values[shown]))[0]
        ends = np.array([distance[shown].min(), distance[shown].max()])
        ax.plot(ends, np.exp(line.at(np.log(ends))), color=INK, lw=1.6)
        slope = f"slope {line.slope:+.2f}".replace("-", "−")
        title = f"{title}: {slope}" if title else slope
    ax.set(xlabel="distance (m)", ylabel=ylabel, title=title)
    if not shown.any():  # a logarithmic axis needs something to scale by
        ax.text(0.5, 0.5, "no such window", transform=ax.transAxes, ha="center", va="center")
        return ax
    ax.set_yscale("log")
    _distance_axis(ax)
    _log_ticks(ax.yaxis)
    if legend:
        ax.legend(title="level")
    return ax


def plot_by_level(true_speed, level, *, medians=None, ax: Axes | None = None) -> Axes:
    """True speeds within each level: every window, and the median with its interval.

    Parameters
    ----------
    true_speed : array_like, shape (n,)
        m/s.
    level : array_like, shape (n,)
        1, 2, 3.
    medians : dict, optional
        Level → `results.Estimate`, or None for an empty level; plain medians are drawn where
        it is not given.
    ax : matplotlib.axes.Axes, optional
    """
    ax = axes_or_new(ax)
    true_speed, level = np.asarray(true_speed), np.asarray(level)
    for one in LEVELS:
        values = np.sort(true_speed[level == one])
        if len(values) == 0:
            continue
        spread = 0.33 * (np.modf(np.arange(len(values)) * 0.618034)[0] * 2 - 1)
        ax.plot(
            one + spread,
            values,
            ls="",
            marker=SPEED_MARKERS[one],
            ms=3.5,
            color=SPEED_COLOURS[one],
            alpha=0.75,
        )
        held = None if medians is None else medians.get(one)
        middle = float(np.median(values)) if held is None else held.value
        ax.plot([one - 0.4, one + 0.4], [middle, middle], color=INK, lw=2.2)
        if held is not None and held.low is not None:
            bar = np.maximum([[middle - held.low], [held.high - middle]], 0)
            ax.errorbar([one], [middle], yerr=bar, color=INK, capsize=5, elinewidth=1.6)
    counts = [int((level == one).sum()) for one in LEVELS]
    ax.set(
        xticks=LEVELS,
        xticklabels=[
            f"{NAMES[one]}\n{count} windows" for one, count in zip(LEVELS, counts, strict=True)
        ],
        xlim=(0.4, 3.6),
        ylim=(0, max(1.05 * float(true_speed.max(initial=0)), 0.1)),
        ylabel="true speed (m/s)",
    )
    return ax


def plot_levels(directions, level, *, legend=True, ax: Axes | None = None) -> Axes:
    """What share of each direction's windows has which level, as stacked bars.

    Parameters
    ----------
    directions, level : array_like, shape (n,)
        1 … 8, and 1, 2, 3, one of each a window.
    legend : bool, optional
    ax : matplotlib.axes.Axes, optional
    """
    ax = axes_or_new(ax)
    directions, level = np.asarray(directions), np.asarray(level)
    whole = np.array([max((directions == way).sum(), 1) for way in DIRECTIONS])
    floor = np.zeros(len(DIRECTIONS))
    for one in LEVELS:
        share = np.array([((directions == way) & (level == one)).sum() for way in DIRECTIONS])
        share = share / whole
        ax.bar(
            DIRECTIONS,
            share,
            bottom=floor,
            color=SPEED_COLOURS[one],
            hatch=SPEED_HATCHES[one],
            edgecolor="white",
            label=NAMES[one],
        )
        floor = floor + share
    ax.set(
        xticks=DIRECTIONS,
        xticklabels=[f"{way}\n{WAYS[way]}" for way in DIRECTIONS],
        xlabel="true direction",
        ylabel="share of windows",
        ylim=(0, 1),
    )
    if legend:
        ax.legend(title="level", loc="center left", bbox_to_anchor=(1.0, 0.5))
    return ax


def _distance_axis(ax):
    ax.set(xscale="log", xlabel="distance (m)")
    _log_ticks(ax.xaxis)


def _log_ticks(axis):
    """Plain numbers on a logarithmic axis, few enough to be read."""
    axis.set_major_locator(matplotlib.ticker.LogLocator(subs=(1, 2, 5)))
    axis.set_major_formatter(matplotlib.ticker.FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    axis.set_minor_locator(matplotlib.ticker.NullLocator())
