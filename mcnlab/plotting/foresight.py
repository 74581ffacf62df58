"""Foresight in pictures: scores, curves, calibration, what experience says, and one pair.

A forecaster has the same colour, marker and line everywhere.  Where a pair is drawn, walkers
are told apart by their lines, the left one solid and the right one dashed, and forecasters by
colour.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from matplotlib.patches import Rectangle
from matplotlib.patheffects import withStroke

from mcnlab import scoring
from mcnlab.columns import H, W, X, Y
from mcnlab.errors import ArgumentError, require_choice, require_count
from mcnlab.foresight import DEFAULT, METHODS
from mcnlab.motion import Ground, move_straight
from mcnlab.pairs import cover_of
from mcnlab.plotting.occlusion import RULE_COLOURS, RULE_INK, RULE_LABELS
from mcnlab.plotting.style import (
    DENSITY,
    FORECAST_COLOURS,
    FORECAST_LINES,
    FORECAST_MARKERS,
    INK,
    PALE,
    UPPER,
    axes_or_new,
    frame_axes,
)
from mcnlab.results import wilson_interval

LEAST = 20  # pairs, with fewer a cell says nothing
FEW = 10  # pairs, with fewer a share is drawn pale
RARE = 0.05  # where a smaller share occludes, a reliability diagram has logarithmic axes
WALKER_LINES = ("-", "--")  # the left one, the right one
LANE = 0.11  # of the cover's axis, for each forecaster below it
TICKS = (0, 0.25, 0.5, 0.75, 1)
GREY = "#6b7078"  # of small print
BAND = "#eef0f3"  # behind what is set apart: moving cameras, the time observed
_HALO = (withStroke(linewidth=3.6, foreground="white"),)
_STEP = 0.18  # between the forecasters of one recording, rows


def plot_scores(judged, measure, *, label, middle=None, ax=None):
    """A score of every forecaster on every recording, one row a recording.

    Recordings made by moving cameras stand last, on grey.

    Parameters
    ----------
    judged : foresight.Judged
    measure : str
        A field of `scoring.Scores`.
    label : str
        Its name and unit.
    middle : dict, optional
        (recording, method) → low and high of what to draw as a pale bar; for errors, their
        middle half.
    ax : matplotlib.axes.Axes, optional
    """
    require_choice("measure", measure, scoring.Scores._fields)
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


def describe_recording(judged, name):
    """A recording's name, how many pairs it has and how many of 100 occlude."""
    table = judged.of(name)
    moving = ", moving camera" if judged.moving[name] else ""
    share = _percent(table["occludes"].mean())
    return f"{shorten(name)}\n{len(table)} pairs, {share} % occlude{moving}"


def shorten(name, most=26):
    """A name of at most `most` letters: a longer one loses its middle."""
    if len(name) <= most:
        return name
    return f"{name[: most - most // 3 - 1]}…{name[-(most // 3) :]}"


class Answers(NamedTuple):
    """What yes/no answers came to: pairs, and the shares that follow; None: no such share."""

    hits: int
    misses: int
    false_alarms: int
    precision: float | None
    recall: float
    f1: float


def count_answers(occludes, probability, threshold):
    """What becomes of pairs when those with at least `threshold` are told that they occlude."""
    occludes = np.asarray(occludes, dtype=bool)
    said = np.asarray(probability) >= threshold
    hits = int((occludes & said).sum())
    return Answers(
        hits,
        int(occludes.sum()) - hits,
        int(said.sum()) - hits,
        hits / int(said.sum()) if said.any() else None,
        hits / int(occludes.sum()),
        scoring.f1_of(occludes, said),
    )


def plot_precision_recall(table, thresholds, *, ax=None):
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
        found = count_answers(table["occludes"], probability, threshold)
        if found.precision is not None:
            draw_point(ax, found, method)
    frame_shares(ax)
    return ax


def frame_shares(ax):
    """Make axes those of precision against recall."""
    ax.set(xlim=(0, 1.02), ylim=(0, 1.04), xlabel="recall", ylabel="precision")
    ax.set(xticks=TICKS, yticks=TICKS)


def draw_curve(ax, occludes, probability, method):
    """The curve of a forecaster that says more than yes and no; precision holds up to a recall."""
    if np.isin(probability, (0, 1)).all():
        return
    curve = scoring.curve_of(occludes, probability)
    ax.plot(
        np.r_[0, curve.recall],
        np.r_[curve.precision[0], curve.precision],
        drawstyle="steps-pre",
        color=FORECAST_COLOURS[method],
        ls=FORECAST_LINES[method],
        lw=1.8 if method == DEFAULT else 1.4,
    )


def draw_point(ax, found, method):
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


def plot_reliability(table, methods, *, ax=None):
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
        method: scoring.reliability_of(table["occludes"], table[f"{method}.probability"])
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


def plot_shares_by_cell(pairs, occluding, rule, *, mean, least=LEAST, ax=None):
    """What share of pairs occludes in each cell of a table, against what the thesis says.

    Dark is above the mean, pale below it.  A triangle marks where experience disagrees:
    upwards where the rule says no and more than the mean occlude, downwards where it says
    certainly and fewer do; hollow where Wilson's interval holds the mean.

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
    share = occluding / np.maximum(pairs, 1)
    # The mean is in the middle of the shades, whatever it is.
    top = max(np.max(share[enough], initial=0.0), mean)
    shade = np.ma.masked_array(_shade(share, mean, top), ~enough)
    size = len(rule)
    ax.imshow(shade, cmap=DENSITY, vmin=0, vmax=1, extent=(0.5, size + 0.5, size + 0.5, 0.5))
    for row, column in np.ndindex(rule.shape):
        at, n, code = (column + 1, row + 1), int(pairs[row, column]), int(rule[row, column])
        ink = "white" if enough[row, column] and shade[row, column] > 0.55 else INK
        corner = {"va": "center", "color": ink, "fontsize": 7.5}
        ax.text(at[0] - 0.44, at[1] - 0.3, _letter(code, size), **corner)
        if not enough[row, column]:
            edge = {"fill": False, "hatch": "////", "ec": PALE, "lw": 0}
            ax.add_patch(Rectangle((at[0] - 0.5, at[1] - 0.5), 1, 1, **edge))
        else:
            text = _percent(share[row, column])
            ax.text(*at, text, ha="center", va="center", color=ink, fontsize=9.5)
            _mark_disagreement(ax, at, share[row, column], n, code, mean)
        below = {"ha": "center", "va": "center", "color": ink, "fontsize": 6}
        ax.text(at[0], at[1] + 0.34, str(n), **below)
    _table_frame(ax, size)
    return ax


def plot_rules_by_cell(rule, *, ax=None):
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


def _shade(value, mean, top):
    """From 0 to 0.9, the mean half-way."""
    below = 0.45 * value / (mean if mean > 0 else 1.0)
    above = 0.45 + 0.45 * (value - mean) / (top - mean if top > mean else 1.0)
    return np.where(value <= mean, below, above)


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
    left, top, side = at[0] - 0.47, at[1] - 0.47, 0.94
    ax.add_patch(
        Rectangle((left, top), side, side, fill=False, ec=UPPER, lw=1.6, path_effects=_HALO)
    )
    ax.plot(
        at[0] + 0.33,
        at[1] - 0.31,
        marker="^" if apart else "v",
        ms=7,
        mfc=INK if sure else "white",
        mec="white" if sure else INK,
        mew=0.9,
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


class Story(NamedTuple):
    """What really becomes of one pair, the left walker first."""

    seconds: np.ndarray  # (t,), 0 at the moment
    seen: np.ndarray  # (2, t), where there is a box
    boxes: np.ndarray  # (2, t, 4): x, y, w, h, pixels; 0 where there is none
    cover: np.ndarray  # (t,); 0 where not both have a box
    order: tuple  # which of the pair's two is the left one, and which the right one
    late: float | None  # seconds until they occlude; None if they do not
    place: tuple | None  # where, pixels

    def nearest(self, seconds):
        """The column of the frame nearest to a time."""
        return int(np.argmin(np.abs(self.seconds - seconds)))


def follow_pair(recording, pairs, number):
    """What becomes of one pair, from the observed second to the horizon.

    Parameters
    ----------
    recording : Recording
        That the pairs are from.
    pairs : pairs.Pairs
    number : int
        Which pair, from 0.

    Returns
    -------
    Story

    Raises
    ------
    ArgumentError
        When there is no such pair, or the pairs are not of this recording.
    """
    number = require_count("number", number)
    if number >= len(pairs):
        raise ArgumentError(f"number is {number}; pass one of 0 to {len(pairs) - 1}.")
    stack, track, now = recording.stack, pairs.track[number], pairs.now[number]
    if pairs.name != recording.name or (pairs.track >= len(stack.start)).any():
        raise ArgumentError(
            f"pairs are of {pairs.name!r}, recording is {recording.name!r}; "
            "pass the recording that they were found in."
        )
    rate, rules = recording.frame_rate, pairs.rules
    offsets = np.arange(-round(rate * rules.observed) + 1, round(rate * rules.horizon) + 1)
    column = now[:, None] + offsets
    inside = (column >= 0) & (column < stack.valid.shape[1])
    column = np.where(inside, column, 0)
    seen = stack.valid[track[:, None], column] & inside
    boxes = np.stack([stack.curves[name][track[:, None], column] for name in (X, Y, W, H)], axis=-1)
    at = int(np.flatnonzero(offsets == 0)[0])
    middle = boxes[:, at, 0] + boxes[:, at, 2] / 2
    order = (0, 1) if middle[0] <= middle[1] else (1, 0)
    seen, boxes = seen[list(order)], np.where(seen[..., None], boxes, 0.0)[list(order)]
    both = seen.all(axis=0)
    safe = np.where(both[:, None], boxes, 1.0)
    cover = np.where(both, cover_of(*np.moveaxis(safe, -1, 1)), 0.0)
    occludes = bool(pairs.occludes[number])
    return Story(
        offsets / rate,
        seen,
        boxes,
        cover,
        order,
        float(pairs.seconds[number]) if occludes else None,
        (float(pairs.x[number]), float(pairs.y[number])) if occludes else None,
    )


def guess_boxes(pairs, number, times, methods):
    """Where forecasters see the two walkers of a pair, method → shape (k, 2, 4): x, y, w, h.

    The thesis foresees no boxes.  "learned" goes the way of "perspective", so the two make
    one entry.
    """
    walkers = pairs.walkers
    rows = pairs.who[number]
    own = {
        name: getattr(walkers, name)[rows]
        for name in ("seen", "x", "feet", "w", "h", "horizon", "rise")
    }
    walkers = replace(walkers, **own)
    ways = {}
    if "constant-velocity" in methods:
        ways["constant-velocity"] = move_straight(walkers, times)
    ours = [method for method in ("perspective", "learned") if method in methods]
    if ours:
        ways[ours[0]] = Ground.of(walkers).move(times)
    return {
        method: np.stack([way.x - way.w / 2, way.feet - way.h, way.w, way.h], axis=-1)
        for method, way in ways.items()
    }


def guess_cover(pairs, number, times, methods):
    """The cover that forecasters foresee on the mean path, method → shape (k,)."""
    return {
        method: cover_of(*np.moveaxis(boxes, (1, 2), (0, 1)))
        for method, boxes in guess_boxes(pairs, number, times, methods).items()
    }


def pick_forecasts(pairs, number, forecasts):
    """What forecasters say of one pair, method → probability, seconds, x, y.

    Raises
    ------
    ArgumentError
        When there is no forecast, a method is unknown, or a forecast is of other pairs.
    """
    if not forecasts:
        raise ArgumentError("forecasts is empty; pass at least one method and its Forecast.")
    for method, said in forecasts.items():
        require_choice("forecasts' method", method, METHODS)
        if any(np.shape(values) != (len(pairs),) for values in said):
            raise ArgumentError(
                f"forecasts[{method!r}] is not of these {len(pairs)} pairs; "
                "pass what its forecaster says of pairs."
            )
    return {
        method: tuple(float(values[number]) for values in said)
        for method, said in forecasts.items()
    }


def plot_moment(story, seconds, *, guesses=None, places=None, ax=None):
    """Both walkers at one time: their boxes, and where their feet came from.

    Parameters
    ----------
    story : Story
    seconds : float
        From the moment of the forecast.
    guesses : dict, optional
        Method → boxes that it foresees at that time, shape (2, 4): x, y, w, h.
    places : dict, optional
        Method → where it foresees that they meet, pixels.
    ax : matplotlib.axes.Axes, optional
        To be framed by `frame_story` before or after.
    """
    ax = axes_or_new(ax)
    at = story.nearest(seconds)
    for seen, boxes, style in zip(story.seen, story.boxes, WALKER_LINES, strict=True):
        here = np.flatnonzero(seen[: at + 1])
        x, feet = boxes[here, 0] + boxes[here, 2] / 2, boxes[here, 1] + boxes[here, 3]
        ax.plot(x, feet, color=INK, lw=1, ls=style)
        if seen[at]:
            ax.plot(*_corners(boxes[at]), color=INK, lw=2.2, ls=style)
    for method, foreseen in (guesses or {}).items():
        for box in foreseen:
            line = {"lw": 1.4, "ls": FORECAST_LINES[method], "color": FORECAST_COLOURS[method]}
            ax.plot(*_corners(box), label=method, **line)
    if story.place is not None and seconds > 0:
        ring = {"mfc": "none", "mec": INK, "mew": 1.6, "ls": ""}
        ax.plot(*story.place, marker="o", ms=15, label="truth", **ring)
    for method, place in (places or {}).items():
        draw_forecaster(ax, *place, method, ms=8)
    return ax


def draw_forecaster(ax, x, y, method, *, says=True, ms=7):
    """A forecaster's mark, hollow if it says no."""
    colour = FORECAST_COLOURS[method]
    face = {"mfc": colour, "mec": "white"} if says else {"mfc": "white", "mec": colour}
    marker = FORECAST_MARKERS[method]
    ax.plot([x], [y], ls="", marker=marker, ms=ms, mew=1.2, zorder=4, label=method, **face)


def _corners(box):
    """The outline of a box x, y, w, h: columns and rows."""
    x, y, w, h = box
    return np.array([x, x + w, x + w, x, x]), np.array([y, y, y + h, y + h, y])


def frame_story(ax, story, *, shape=1.0, frame=None):
    """Show the part of the image in which a pair's story takes place.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    story : Story
    shape : float, optional
        Height over width.
    frame : tuple of int, optional
        Width and height of the whole image, whose edge is drawn.
    """
    boxes = story.boxes[story.seen]
    low, high = boxes[:, :2].min(axis=0), (boxes[:, :2] + boxes[:, 2:]).max(axis=0)
    wide = 1.15 * max((high - low)[0], (high - low)[1] / shape)
    left, top = (low + high) / 2 - np.array([wide, wide * shape]) / 2
    frame_axes(ax, wide, wide * shape)
    ax.set(xlim=(left, left + wide), ylim=(top + wide * shape, top))
    if frame is not None:
        ax.plot(*_corners((-0.5, -0.5, *frame)), color=PALE, lw=1, zorder=0.5)


def plot_cover(story, bound, *, guesses=None, forecasts=None, thresholds=None, now=None, ax=None):
    """How much two walkers cover each other, and when each forecaster thinks that they will.

    Below the axis each forecaster has a lane; its mark stands at the time that it foresees,
    hollow if it says that they will not occlude.

    Parameters
    ----------
    story : Story
    bound : float
        The cover that makes an occlusion.
    guesses : dict, optional
        Method → times and the cover that it foresees then.
    forecasts : dict, optional
        Method → probability, seconds, x, y of this pair (`pick_forecasts`).
    thresholds : mapping, optional
        Method → threshold of a yes; 1/2 where there is none.
    now : float, optional
        A time to mark.
    ax : matplotlib.axes.Axes, optional
    """
    ax = axes_or_new(ax)
    forecasts, thresholds = forecasts or {}, {} if thresholds is None else thresholds
    bottom = -LANE * (len(forecasts) + 0.6) if forecasts else 0
    ax.axvspan(story.seconds[0], 0, color=BAND, zorder=0)
    ax.axhline(bound, color=INK, lw=0.8, ls=":")
    both = story.seen.all(axis=0)
    ax.plot(story.seconds[both], story.cover[both], color=INK, lw=2.2, label="truth")
    if story.late is not None:
        at = story.cover[story.nearest(story.late)]
        ax.plot(story.late, at, "o", ms=13, mfc="none", mec=INK, mew=1.6)
    for method, (times, cover) in (guesses or {}).items():
        line = {"lw": 1.3, "ls": FORECAST_LINES[method], "color": FORECAST_COLOURS[method]}
        ax.plot(times, cover, **line)
    for lane, (method, (probability, seconds, *_)) in enumerate(forecasts.items(), start=1):
        says = probability >= thresholds.get(method, 0.5)
        draw_forecaster(ax, seconds, -LANE * lane, method, says=says)
        late = seconds > story.seconds[-1] / 2
        text = f"{method}: {'yes' if says else 'no'}, {probability:.2f}"
        ax.annotate(
            text,
            (seconds, -LANE * lane),
            xytext=(-8 if late else 8, 0),
            textcoords="offset points",
            ha="right" if late else "left",
            va="center",
            fontsize=8,
        )
    if now is not None:
        ax.axvline(now, color=UPPER, lw=1.2)
    ax.set(xlim=(story.seconds[0], story.seconds[-1] + 0.05), ylim=(bottom, 1.03))
    ax.set(xlabel="seconds from the moment", ylabel="cover", yticks=TICKS)
    return ax
