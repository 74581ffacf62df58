"""Foresight in pictures: scores, curves, calibration, and what experience says.

A forecaster has the same colour, marker and line everywhere.
"""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize, TwoSlopeNorm
from matplotlib.patches import Rectangle
from matplotlib.patheffects import withStroke

from mcnlab.checks import require_choice, require_count
from mcnlab.errors import ArgumentError
from mcnlab.occlusion import scores
from mcnlab.occlusion.benchmark import DEFAULT, METHODS, Judged
from mcnlab.occlusion.scores import Scores
from mcnlab.plotting.occlusion import RULE_COLOURS, RULE_INK, RULE_LABELS
from mcnlab.plotting.style import (
    BAND,
    DENSITY,
    FORECAST_COLOURS,
    FORECAST_LINES,
    FORECAST_MARKERS,
    GREY,
    INK,
    PALE,
    TICKS,
    UPPER,
    axes_or_new,
)
from mcnlab.statistics import wilson_interval

LEAST = 20  # pairs, with fewer a cell says nothing
FEW = 10  # pairs, with fewer a share is drawn pale
RARE = 0.05  # where a smaller share occludes, a reliability diagram has logarithmic axes
_HALO = (withStroke(linewidth=3.6, foreground="white"),)
_STEP = 0.18  # between the forecasters of one recording, rows


def plot_scores(judged, measure, *, label, middle=None, ax: Axes | None = None) -> Axes:
    """A score of every forecaster on every recording, one row a recording.

    Recordings made by moving cameras stand last, on grey.

    Parameters
    ----------
    judged : foresight.Judged
    measure : str
        A field of `scores.Scores`.
    label : str
        Its name and unit.
    middle : dict, optional
        (recording, method) → low and high of what to draw as a pale bar; for errors, their
        middle half.
    ax : matplotlib.axes.Axes, optional
    """
    require_choice("measure", measure, Scores._fields)
    ax = axes_or_new(ax)
    names = judged.recordings
    for number, method in enumerate(METHODS):
        colour = FORECAST_COLOURS[method]
        rows = np.arange(len(names)) + _STEP * (number - (len(METHODS) - 1) / 2)
        found = [getattr(judged.scores[name, method], measure) for name in names]
        if middle:
            bars = [
                (row, *middle[name, method])
                for row, name in zip(rows, names, strict=True)
                if middle.get((name, method)) is not None
            ]
            for row, low, high in bars:
                ax.plot([low, high], [row, row], color=colour, lw=6, alpha=0.3, zorder=1.5)
        held = [(one, row) for one, row in zip(found, rows, strict=True) if one.value is not None]
        sure = [(one, row) for one, row in held if one.low is not None]
        if sure:
            ends = ([one.low for one, _ in sure], [one.high for one, _ in sure])
            ax.hlines([row for _, row in sure], *ends, color=colour, lw=1.4)
        ax.plot(
            [one.value for one, _ in held],
            [row for _, row in held],
            ls="",
            marker=FORECAST_MARKERS[method],
            ms=7 if method == DEFAULT else 5.5,
            color=colour,
            label=method,
        )
        for one, row in zip(found, rows, strict=True):
            if one.value is None:
                place = ax.get_yaxis_transform()
                ax.text(0.01, row, "none", transform=place, va="center", fontsize=7, color=colour)
    for row, name in enumerate(names):
        if judged.moving[name]:
            ax.axhspan(row - 0.5, row + 0.5, color=BAND, zorder=0)
    ax.set_yticks(np.arange(len(names)), [describe_recording(judged, name) for name in names])
    ax.set(xlabel=label, ylim=(len(names) - 0.5, -0.5), xlim=(0, None))
    ax.grid(axis="y", visible=False)
    ax.tick_params(axis="y", length=0)
    return ax


def describe_recording(judged: Judged, name: str) -> str:
    """A recording's name, how many pairs it has and how many of 100 occlude."""
    table = judged.of(name)
    moving = ", moving camera" if judged.moving[name] else ""
    share = _percent(table["occludes"].mean())
    return f"{shorten(name)}\n{len(table)} pairs, {share} % occlude{moving}"


def shorten(name: str, most: int = 26) -> str:
    """A name of at most `most` letters: a longer one loses its middle."""
    if len(name) <= most:
        return name
    return f"{name[: most - most // 3 - 1]}…{name[-(most // 3) :]}"


def plot_precision_recall(table, thresholds, *, ax: Axes | None = None) -> Axes:
    """Precision against recall, a point where each forecaster says yes at its threshold.

    The area under a curve is its average precision.  A forecaster that says but yes or no is
    a point alone.  Pale lines join places of one F1, which stands on the right.

    Parameters
    ----------
    table : pandas.DataFrame
        Pairs of one recording with ``<method>.probability``.
    thresholds : mapping
        Method → threshold, for the methods to draw.
    ax : matplotlib.axes.Axes, optional
    """
    ax = axes_or_new(ax)
    for f1 in (0.2, 0.4, 0.6, 0.8):
        recall = np.linspace(f1 / (2 - f1), 1, 40)
        ax.plot(recall, f1 * recall / (2 * recall - f1), color=PALE, lw=0.7, zorder=0.5)
        ax.text(1.03, f1 / (2 - f1), f"{f1:g}", va="center", fontsize=6.5, color=GREY)
    for method, threshold in thresholds.items():
        probability = table[f"{method}.probability"].to_numpy()
        draw_curve(ax, table["occludes"], probability, method)
        found = scores.count_answers(table["occludes"], probability, threshold)
        if found.precision is not None:
            draw_point(ax, found, method)
    frame_shares(ax)
    return ax


def frame_shares(ax) -> None:
    """Make axes those of precision against recall."""
    ax.set(xlim=(0, 1.02), ylim=(0, 1.04), xlabel="recall", ylabel="precision")
    ax.set(xticks=TICKS, yticks=TICKS)


def draw_curve(ax, occludes, probability, method) -> None:
    """The curve of a forecaster that says more than yes and no; precision holds up to a recall."""
    if np.isin(probability, (0, 1)).all():
        return
    curve = scores.curve_of(occludes, probability)
    ax.plot(
        np.r_[0, curve.recall],
        np.r_[curve.precision[0], curve.precision],
        drawstyle="steps-pre",
        color=FORECAST_COLOURS[method],
        ls=FORECAST_LINES[method],
        lw=1.8 if method == DEFAULT else 1.4,
    )


def draw_point(ax, found, method) -> None:
    """Where a forecaster's yes and no lead."""
    ax.plot(
        [found.recall],
        [found.precision],
        ls="",
        marker=FORECAST_MARKERS[method],
        ms=9,
        color=FORECAST_COLOURS[method],
        mec="white",
        mew=1.2,
        zorder=4,
        label=method,
    )


def plot_reliability(table, methods, *, ax: Axes | None = None) -> Axes:
    """What happened against what was said to be its probability; Wilson's intervals.

    Where hardly any pair occludes the axes are logarithmic; what is 0 is drawn hollow at the
    edge.  Shares of less than `FEW` pairs are pale and not joined to the others.

    Parameters
    ----------
    table : pandas.DataFrame
        Pairs of one recording with ``<method>.probability``.
    methods : sequence of str
    ax : matplotlib.axes.Axes, optional
    """
    ax = axes_or_new(ax)
    found = {
        method: scores.reliability_of(table["occludes"], table[f"{method}.probability"])
        for method in methods
    }
    logarithmic = table["occludes"].mean() < RARE
    numbers = [held[["probability", "share"]].to_numpy().ravel() for held in found.values()]
    values = np.concatenate(numbers)
    # The power of ten below all that is above 0.
    floor = 10.0 ** np.floor(np.log10(values[values > 0].min())) if logarithmic else 0.0
    ax.plot([floor, 1], [floor, 1], color=PALE, lw=1, zorder=0.5)
    for method, held in found.items():
        colour, marker = FORECAST_COLOURS[method], FORECAST_MARKERS[method]
        many = held["n"] >= FEW
        for rows, alpha, line in (
            (held[many], 1.0, FORECAST_LINES[method]),
            (held[~many], 0.3, ""),
        ):
            x, y = (np.maximum(rows[name], floor) for name in ("probability", "share"))
            style = {"color": colour, "marker": marker, "ms": 5, "alpha": alpha}
            ax.vlines(
                x,
                np.maximum(rows["share_low"], floor),
                rows["share_high"],
                color=colour,
                lw=1.2,
                alpha=alpha,
            )
            ax.plot(x, y, ls=line, label=method if line else None, **style)
            edge = (rows["probability"] < floor) | (rows["share"] < floor)
            ax.plot(x[edge], y[edge], ls="", mfc="white", **style)
    scale = "log" if logarithmic else "linear"
    reach = (floor, 1.3) if logarithmic else (-0.03, 1.03)
    ax.set(xscale=scale, yscale=scale, xlim=reach, ylim=reach)
    if not logarithmic:
        ax.set(xticks=TICKS, yticks=TICKS)
    ax.set(xlabel="probability that was said", ylabel="share that occludes")
    return ax


def plot_shares_by_cell(
    pairs, occluding, rule, *, mean, least=LEAST, top=None, ax: Axes | None = None
) -> Axes:
    """What share of pairs occludes in each cell of a table, against what the thesis says.

    The mean is in the middle of the shades, dark above it.  A triangle marks where experience
    disagrees: upwards where the rule says no and more than the mean occlude, downwards where
    it says certainly and fewer do; hollow where Wilson's interval holds the mean.

    Parameters
    ----------
    pairs, occluding : array_like of int, shape (k, k)
        Rows S1, columns S2.
    rule : array_like of int, shape (k, k)
        `occlusion.APART`, `CERTAIN` or `BY_SPEED`.
    mean : float
        Share of all pairs that occludes.
    least : int, optional
        Cells with fewer pairs are hatched.
    top : float, optional
        The share with the darkest shade; the largest drawn, if not given.
    ax : matplotlib.axes.Axes, optional

    Raises
    ------
    ArgumentError
        When shapes differ or a share is none.
    """
    pairs, occluding, rule = (np.asarray(held) for held in (pairs, occluding, rule))
    if not pairs.shape == occluding.shape == rule.shape or pairs.ndim != 2:
        raise ArgumentError(
            f"pairs, occluding and rule have shapes {pairs.shape}, {occluding.shape} and "
            f"{rule.shape}; pass three tables of one shape."
        )
    if ((occluding < 0) | (occluding > pairs)).any():
        raise ArgumentError("occluding holds more than pairs, or fewer than none; count again.")
    ax = axes_or_new(ax)
    enough = pairs >= require_count("least", least, low=1)
    share = np.ma.masked_array(occluding / np.maximum(pairs, 1), ~enough)
    size = len(rule)
    extent = (0.5, size + 0.5, size + 0.5, 0.5)
    top = most_of(pairs, occluding, least=least) if top is None else top
    ax.imshow(share, cmap=DENSITY, norm=_norm(mean, max(top, mean)), extent=extent)
    for row, column in np.ndindex(rule.shape):
        at, n, code = (column + 1, row + 1), int(pairs[row, column]), int(rule[row, column])
        if enough[row, column]:
            _mark_disagreement(ax, at, share[row, column], n, code, mean)
        else:
            edge = {"fill": False, "hatch": "////", "ec": PALE, "lw": 0}
            ax.add_patch(Rectangle((at[0] - 0.5, at[1] - 0.5), 1, 1, **edge))
    _table_frame(ax, size)
    return ax


def most_of(pairs: np.ndarray, occluding: np.ndarray, *, least: int = LEAST) -> float:
    """The largest share that occludes in a cell of at least so many pairs; 0 without one."""
    return float(np.max((occluding / np.maximum(pairs, 1))[pairs >= least], initial=0.0))


def draw_shares_bar(ax: Axes, bar: Axes) -> None:
    """The bar that says which shares `plot_shares_by_cell` drew on axes, in per cent."""
    image = ax.images[0]
    norm = image.norm
    ticks = sorted({norm.vmin, getattr(norm, "vcenter", norm.vmin), norm.vmax})
    drawn = ax.figure.colorbar(image, cax=bar, orientation="horizontal", label="pairs that occlude")
    drawn.set_ticks(ticks, labels=[f"{_percent(share)} %" for share in ticks])


def _norm(mean, top):
    """The mean is in the middle of the shades, whatever it is."""
    return TwoSlopeNorm(mean, 0, top) if 0 < mean < top else Normalize(0, max(top, 1e-9))


def plot_rules_by_cell(rule, *, ax: Axes | None = None) -> Axes:
    """What the thesis says, laid out as `plot_shares_by_cell`."""
    ax = axes_or_new(ax)
    rule = np.asarray(rule)
    size = len(rule)
    for row, column in np.ndindex(rule.shape):
        code = int(rule[row, column])
        where = (column + 0.5, row + 0.5)
        ax.add_patch(Rectangle(where, 1, 1, fc=RULE_COLOURS[code], ec="white", lw=1.5))
        said = {"ha": "center", "va": "center", "color": RULE_INK[code], "fontsize": 10}
        ax.text(column + 1, row + 1, _letter(code, size), **said)
    ax.set_aspect("equal")
    _table_frame(ax, size)
    return ax


def _letter(code, size):
    """What a table prints in its cells: P(O|S) is one letter here, C in the tables of speeds."""
    letter = RULE_LABELS[code][0]
    return "C" if letter == "P" and size == 3 else letter


def _percent(share):
    """A share in per cent, with as many digits as a cell holds."""
    if 0 < share < 0.00095:
        return f"{100 * share:.1g}"
    return f"{100 * share:.1f}" if 0 < share < 0.0995 else f"{100 * share:.0f}"


def _mark_disagreement(ax, at, share, n, code, mean):
    apart, certain = (RULE_LABELS[code][0] == letter for letter in "01")
    if not (apart and share > mean) and not (certain and share < mean):
        return
    low, high = wilson_interval(share, n)
    sure = not low <= mean <= high
    left, top, side = at[0] - 0.46, at[1] - 0.46, 0.92
    ax.add_patch(
        Rectangle((left, top), side, side, fill=False, ec=UPPER, lw=1.8, path_effects=_HALO)
    )
    ax.plot(
        *at,
        marker="^" if apart else "v",
        ms=9,
        mfc=INK if sure else "white",
        mec="white" if sure else INK,
        mew=1.1,
        ls="",
        gid=f"{'more' if apart else 'fewer'} than the rule says",
    )


def _table_frame(ax, size):
    ax.set(xlim=(0.5, size + 0.5), ylim=(size + 0.5, 0.5))
    ax.set(xticks=range(1, size + 1), yticks=range(1, size + 1))
    ax.grid(False)
    ax.tick_params(length=0)
    for spine in ax.spines.values():
        spine.set(visible=True, color=PALE)
