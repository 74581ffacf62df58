"""Gait in a box: width over time, its rhythm, and from where that shows."""

import numpy as np
from matplotlib.axes import Axes

from mcnlab.plotting.style import INK, LOWER, PALE, UPPER, WALK_COLOURS, axes_or_new

REAL, MADE, NOISY, CUT = WALK_COLOURS.values()


def plot_width(
    seconds, width, *, events=None, colour=REAL, title="", ax: Axes | None = None
) -> Axes:
    """A box's width against time, with heel strikes and mid-swings (Figure 2.2).

    Parameters
    ----------
    seconds, width : array_like, shape (n,)
    events : tuple of array_like, optional
        The times of heel strikes and of mid-swings, seconds.
    colour : colour, optional
    title : str, optional
    ax : matplotlib.axes.Axes, optional
    """
    ax = axes_or_new(ax)
    seconds, width = np.asarray(seconds, float), np.asarray(width, float)
    ax.plot(seconds, width, color=colour)
    if events is not None:
        for times, marker, mark, name in (
            (events[0], "^", UPPER, "heel strike"),
            (events[1], "v", INK, "mid-swing"),
        ):
            ax.plot(times, np.interp(times, seconds, width), marker, color=mark, ls="", label=name)
    ax.set(xlabel="time (s)", ylabel="box width (pixels)", title=title)
    ax.set_ylim(0, None)
    return ax


def plot_rhythm(
    lags, correlation, *, period=None, colour=REAL, title="", ax: Axes | None = None
) -> Axes:
    """An autocorrelation against its lag, with the step's period.

    Parameters
    ----------
    lags : array_like, shape (n,)
        Seconds.
    correlation : array_like, shape (n,)
    period : gait.Period, optional
    colour : colour, optional
    title : str, optional
    ax : matplotlib.axes.Axes, optional
    """
    ax = axes_or_new(ax)
    ax.axhline(0, color=PALE, lw=1)
    ax.plot(lags, correlation, color=colour)
    if period is not None and period.step > 0:
        name = f"step {period.step:.2f} s" if period.detectable else "no rhythm found"
        ax.plot(
            period.step,
            period.peak,
            "o",
            color=UPPER,
            mfc=UPPER if period.detectable else "white",
            ls="",
            label=name,
        )
        ax.legend(loc="lower right")
    ax.set(xlabel="lag (s)", ylabel="autocorrelation", ylim=(-1.3, 1.05), title=title)
    return ax


def plot_by_angle(tables, value, *, low=None, high=None, ylabel="", ax: Axes | None = None) -> Axes:
    """A quantity against the view angle, one line or set of points a table.

    Parameters
    ----------
    tables : dict
        Name → (table with ``angle`` and `value`, colour, marker, line style).
    value : str
    low, high : str, optional
        Columns with an interval's ends.
    ylabel : str, optional
    ax : matplotlib.axes.Axes, optional
    """
    ax = axes_or_new(ax)
    for name, (table, colour, marker, style) in tables.items():
        ax.plot(
            table["angle"],
            table[value],
            marker=marker,
            ls=style,
            color=colour,
            label=name,
            zorder=3,
        )
        if low is not None:
            ax.vlines(table["angle"], table[low], table[high], color=colour, alpha=0.5, lw=1.4)
    ax.set(
        xlabel="view angle σ (degrees; 0 = frontal, 90 = square-on)",
        ylabel=ylabel,
        xticks=np.arange(0, 91, 15),
    )
    return ax


def plot_timeline(watch, frame_rate, *, cameras, ax: Axes | None = None) -> Axes:
    """Which camera is awake when: a bar a camera, dark while it watches (section 2.2.5).

    Parameters
    ----------
    watch : pandas.DataFrame
        ``frame, camera, awake``.
    frame_rate : float
    cameras : int
    ax : matplotlib.axes.Axes, optional
    """
    ax = axes_or_new(ax)
    for camera in range(cameras):
        rows = watch[watch["camera"] == camera].sort_values("frame")
        time, awake = rows["frame"].to_numpy() / frame_rate, rows["awake"].to_numpy(bool)
        edges = np.flatnonzero(np.diff(np.r_[False, awake, False].astype(int)))
        spans = [
            (time[start], time[min(stop, len(time) - 1)] - time[start])
            for start, stop in zip(edges[::2], edges[1::2], strict=True)
        ]
        ax.broken_barh(spans, (camera - 0.35, 0.7), color=LOWER)
    ax.set(
        yticks=range(cameras),
        yticklabels=[f"camera {number + 1}" for number in range(cameras)],
        xlabel="time (s)",
        ylim=(cameras - 0.5, -0.5),
    )
    ax.grid(axis="y", visible=False)
    return ax
