"""The figures of the benchmark: who foresees occlusion best, how surely, and one pair's story."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from mcnlab.errors import ArgumentError
from mcnlab.figures.registry import FORESEE, figure
from mcnlab.occlusion.benchmark import DEFAULT, METHODS
from mcnlab.occlusion.thesis import APART, BY_SPEED, SIDES, direction_table, speed_table
from mcnlab.plotting.benchmark import (
    LEAST,
    describe_recording,
    draw_shares_bar,
    most_of,
    plot_precision_recall,
    plot_reliability,
    plot_rules_by_cell,
    plot_scores,
    plot_shares_by_cell,
    shorten,
)
from mcnlab.plotting.pairs import (
    follow_pair,
    frame_story,
    guess_boxes,
    guess_cover,
    pick_forecasts,
    plot_cover,
    plot_moment,
)
from mcnlab.plotting.style import (
    BAND,
    FORECAST_COLOURS,
    FORECAST_LINES,
    FORECAST_MARKERS,
    TRUTH,
    WALKER_LINES,
)

_ALWAYS = ("composites", "crossings")  # recordings that every run has
_MOST_COLUMNS = 5


def _ids(*measures, methods=METHODS):
    return tuple(
        f"occlusion.{name}.{method}.{measure}"
        for measure in measures
        for name in _ALWAYS
        for method in methods
    )


@figure(
    "foresight-scores",
    notebook=FORESEE,
    ids=(
        *_ids("f1"),
        *(f"occlusion.mean.{method}.f1" for method in METHODS),
        *(f"occlusion.mean.gain.{method}.f1" for method in METHODS if method != DEFAULT),
    ),
)
def scores(judged) -> Figure:
    """Who foresees occlusion best.

    F1 and average precision of every forecaster on every recording.

    Question
    --------
    How well does each forecaster do on recordings that it has not learned from?

    Parameters
    ----------
    judged : foresight.Judged
    """
    figure, axes = _two_by_rows(judged)
    for ax, (measure, label) in zip(
        axes, {"f1": "F1", "ap": "average precision"}.items(), strict=True
    ):
        plot_scores(judged, measure, label=f"{label}, 95 % interval", ax=ax)
        ax.set(xlim=(0, 1.02))
    _legend(figure, *axes[0].get_legend_handles_labels())
    return figure


@figure("foresight-curves", notebook=FORESEE, ids=_ids("ap", methods=METHODS[1:]))
def curves(judged) -> Figure:
    """Precision against recall.

    Precision against recall, one picture a recording, with the thresholds' points.

    Question
    --------
    What does one more occlusion found cost in false alarms, and is the threshold that other
    recordings chose a good one here?

    Parameters
    ----------
    judged : foresight.Judged
    """
    figure, axes = _one_each(judged)
    for name, ax in axes.items():
        thresholds = dict(judged.thresholds.loc[name, list(METHODS)])
        plot_precision_recall(judged.of(name), thresholds, ax=ax)
    _outer_labels(axes)
    figure.supxlabel("marks: the threshold that others chose; pale: lines of one F1", fontsize=9)
    _legend(figure, _handles(METHODS, points=("thesis",)), METHODS)
    return figure


@figure(
    "foresight-calibration", notebook=FORESEE, ids=_ids("calibration_error", methods=METHODS[1:])
)
def calibration(judged) -> Figure:
    """Does what is said to be likely happen as often?

    Reliability of the forecasters that say a probability, one picture a recording.

    Question
    --------
    Of pairs that are said to occlude with some probability, does that share occlude?

    Parameters
    ----------
    judged : foresight.Judged
    """
    figure, axes = _one_each(judged)
    methods = METHODS[1:]
    for name, ax in axes.items():
        plot_reliability(judged.of(name), methods, ax=ax)
        error = judged.scores[name, DEFAULT].calibration_error.value
        axes_of = " (logarithmic)" if ax.get_xscale() == "log" else ""
        said = f"{ax.get_title(loc='left')}\n{DEFAULT}: error {error:.3f}{axes_of}"
        ax.set_title(said, fontsize=9)
    _outer_labels(axes)
    _legend(figure, _handles(methods), methods)
    return figure


@figure("foresight-errors", notebook=FORESEE, ids=_ids("time_error_s", "place_error"))
def errors(judged) -> Figure:
    """How far off are time and place?

    Errors of time and place over true positives: medians, intervals and middle halves.

    Question
    --------
    Where a forecaster rightly says yes, how wrong is it about when and where?

    Parameters
    ----------
    judged : foresight.Judged
    """
    figure, axes = _two_by_rows(judged)
    for ax, (measure, label) in zip(
        axes,
        {
            "time_error_s": "time error (s)",
            "place_error": "place error (body heights)",
        }.items(),
        strict=True,
    ):
        middle = {
            (name, method): _middle_half(judged, name, method, measure)
            for name in judged.recordings
            for method in METHODS
        }
        plot_scores(judged, measure, label=label, middle=middle, ax=ax)
    figure.supxlabel(
        "marks: medians over true positives; thin: their 95 % intervals; broad: the middle half",
        fontsize=9,
    )
    _legend(figure, *axes[0].get_legend_handles_labels())
    return figure


@figure("learned-table", notebook=FORESEE)
def learned_table(experience, *, least=LEAST) -> Figure:
    """The thesis's tables and what experience says.

    Table 3.1 with Tables 3.2 and 3.3 below, and beside them the same, counted.

    Question
    --------
    Do the pairs occlude that Tables 3.1 to 3.3 say will?

    Finding
    -------
    Framed cells disagree with the rule: more occlude than on the average where it says 0, or fewer
    where it says 1.

    Parameters
    ----------
    experience : dict
        Title → `benchmark.Experience`.
    least : int, optional
        Cells with fewer pairs are hatched.

    Raises
    ------
    ArgumentError
        When there is no experience, or one without pairs.
    """
    for title, held in experience.items():
        if not held.pairs.any():
            raise ArgumentError(f"experience {title!r} holds no pair; leave it out.")
    if not experience:
        raise ArgumentError("experience is empty; pass at least one title and its counts.")
    columns = 1 + len(experience)
    figure = plt.figure(figsize=(3.7 * columns, 7.2))
    figure.get_layout_engine().set(w_pad=0.08, h_pad=0.08)
    grid = figure.add_gridspec(3, 2 * columns, height_ratios=(8, 3.6, 0.3))
    bars = []
    rule = direction_table()
    speeds = {side: np.where(speed_table(side), BY_SPEED, APART) for side in SIDES}
    for column, (title, held) in enumerate({"": None, **experience}.items()):
        large = figure.add_subplot(grid[0, 2 * column : 2 * column + 2])
        small = [figure.add_subplot(grid[1, 2 * column + place]) for place in (0, 1)]
        if held is None:
            plot_rules_by_cell(rule, ax=large)
            large.set_title("the thesis: 0 never, 1 certain, P by speed", fontsize=10)
            for ax, side in zip(small, SIDES, strict=True):
                plot_rules_by_cell(speeds[side], ax=ax)
        else:
            mean = held.occluding.sum() / held.pairs.sum()
            counted = [held.by_direction(), *(held.by_speed(side) for side in SIDES)]
            top = max((most_of(*both, least=least) for both in counted), default=mean)
            for ax, (n, hits), ruled in zip(
                (large, *small), counted, (rule, *speeds.values()), strict=True
            ):
                plot_shares_by_cell(n, hits, ruled, mean=mean, least=least, top=top, ax=ax)
            large.set_title(f"{shorten(title, 22)}: mean {100 * mean:.1f} %", fontsize=10)
            bars.append((large, grid[2, 2 * column : 2 * column + 2]))
        large.set(xlabel="D(S2), on the right", ylabel="D(S1), on the left")
        for ax, side in zip(small, SIDES, strict=True):
            ax.set_title(f"both going {side}", fontsize=9, fontweight="normal")
            ax.set(xlabel="V(S2)", ylabel="V(S1)" if side == "right" else "")
    for ax, place in bars:
        draw_shares_bar(ax, figure.add_subplot(place))
    figure.supxlabel(
        "C: time and place decide; middle of the shades: the mean; "
        f"hatched: fewer than {least} pairs\n"
        "framed: more occlude than on average where the rule says 0 (▲), fewer where it says 1 "
        "(▼); a hollow mark may be chance",
        fontsize=9,
    )
    return figure


@figure("foresight-pair", notebook=FORESEE)
def pair(recording, pairs, number, forecasts, *, thresholds=None) -> Figure:
    """One pair: what was seen, what was foreseen, what happened.

    Four moments of one pair, and how much the two cover each other over time.

    Question
    --------
    What do the forecasters make of one second of two walkers?

    Finding
    -------
    Boxes in colour are foreseen, black ones are true.

    Parameters
    ----------
    recording : Recording
        That the pairs are from.
    pairs : pairs.Pairs
    number : int
        Which pair, from 0.
    forecasts : dict
        Method → `forecasters.Forecast` of all pairs.
    thresholds : mapping, optional
        Method → threshold of a yes; 1/2 if not given.

    Raises
    ------
    ArgumentError
        When there is no such pair, the recording is another one, or a forecast is of other
        pairs.
    """
    story = follow_pair(recording, pairs, number)
    said = pick_forecasts(pairs, number, forecasts)
    last = DEFAULT if DEFAULT in said else list(said)[-1]
    foreseen, horizon = said[last][1], pairs.rules.horizon
    late = horizon if story.late is None else story.late
    moments = (
        (f"{story.seconds[0]:.1f} s".replace("-", "−"), story.seconds[0]),
        ("0 s: the moment", 0.0),
        (f"{foreseen:.1f} s: as {last} foresees", foreseen),
        (f"{late:.1f} s: they {'do not ' if story.late is None else ''}occlude", late),
    )
    figure = plt.figure(figsize=(13, 6.6))
    grid = figure.add_gridspec(2, len(moments), height_ratios=(3.3, 2.4))
    # Whoever foresees it too late shows it last.
    for place, (title, seconds) in enumerate(sorted(moments, key=lambda held: held[1])):
        ax = figure.add_subplot(grid[0, place])
        guesses, places = {}, {}
        if seconds > 0:
            foreseen_boxes = guess_boxes(pairs, number, [seconds], said)
            guesses = {method: boxes[0] for method, boxes in foreseen_boxes.items()}
            places = {method: (x, y) for method, (_, _, x, y) in said.items()}
        plot_moment(story, seconds, guesses=guesses, places=places, ax=ax)
        frame_story(ax, story, shape=1.1, frame=(recording.frame_width, recording.frame_height))
        ax.set_title(title, fontsize=10)
    below = figure.add_subplot(grid[1, :])
    times = horizon * np.arange(1, 61) / 60
    paths = guess_cover(pairs, number, times, said)
    plot_cover(
        story,
        pairs.rules.cover,
        guesses={method: (times, cover) for method, cover in paths.items()},
        forecasts=said,
        thresholds=thresholds,
        ax=below,
    )
    below.set_title("cover, true and foreseen; below: who says what, and when", fontsize=10)
    walkers = [plt.Line2D([], [], color=TRUTH, lw=2.2, ls=style) for style in WALKER_LINES]
    named = [method if method in paths else f"{method}: place only" for method in said]
    _legend(
        figure,
        [*walkers, *_handles(said, points=set(said) - set(paths))],
        ["true box, left walker", "true box, right walker", *named],
    )
    return figure


def _two_by_rows(judged):
    """Two axes side by side, as high as there are recordings, with one list of names."""
    height = 1.3 + 0.62 * len(judged.recordings)
    return plt.subplots(1, 2, figsize=(11, height), sharey=True)


def _one_each(judged):
    """Axes for every recording, by name; as square as may be."""
    names = judged.recordings
    columns = min(len(names), max(3, int(np.ceil(np.sqrt(len(names))))), _MOST_COLUMNS)
    rows = -(-len(names) // columns)
    figure, axes = plt.subplots(
        rows, columns, figsize=(max(3.1 * columns, 7), 3.1 * rows + 0.4), squeeze=False
    )
    for ax in axes.flat[len(names) :]:
        ax.remove()
    axes = dict(zip(names, axes.flat, strict=False))
    for name, ax in axes.items():
        said = describe_recording(judged, name).replace("moving camera", "moving")
        ax.set_title(said, fontsize=8.5)
        if judged.moving[name]:
            ax.set_facecolor(BAND)
    return figure, axes


def _outer_labels(axes):
    """Leave what the axes measure to the leftmost and the lowest."""
    held = list(axes.values())
    for ax in held:
        spec = ax.get_subplotspec()
        below = spec.num1 + spec.get_gridspec().ncols
        if not spec.is_first_col():
            ax.set_ylabel("")
        if below < len(held):
            ax.set_xlabel("")


def _handles(methods, *, points=()):
    """Legend entries: line and marker, or a marker alone."""
    return [
        plt.Line2D(
            [],
            [],
            color=FORECAST_COLOURS[method],
            marker=FORECAST_MARKERS[method],
            ls="" if method in points else FORECAST_LINES[method],
        )
        for method in methods
    ]


def _legend(figure, handles, labels):
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), handlelength=2.6)


def _middle_half(judged, name, method, measure):
    """The quartiles of a method's errors over its true positives; None without any."""
    table = judged.of(name)
    said = table[f"{method}.probability"] >= judged.thresholds.loc[name, method]
    right = table[table["occludes"] & said]
    if right.empty:
        return None
    if measure == "place_error":
        errors = right[f"{method}.place_error"]
    else:
        errors = (right[f"{method}.seconds"] - right["seconds"]).abs()
    return tuple(np.percentile(errors, [25, 75]))
