"""The panels of the benchmark: thresholds, what counts as a pair, and pairs one by one."""

from collections.abc import Mapping
from functools import cache
from typing import Any

import ipywidgets
import numpy as np
import traitlets

from mcnlab.checks import require_count, require_number
from mcnlab.compass import NAMES
from mcnlab.datasets.recording import Recording
from mcnlab.occlusion import scores
from mcnlab.occlusion.benchmark import DEFAULT, METHODS, Judged
from mcnlab.occlusion.forecasters import ConstantVelocity, Forecast, Perspective, Thesis
from mcnlab.occlusion.pairs import RULES, Pairs, Rules, find_pairs
from mcnlab.plotting import pairs as plots
from mcnlab.plotting.benchmark import draw_curve, draw_point, frame_shares
from mcnlab.plotting.style import FORECAST_COLOURS, INK, PALE
from mcnlab.synthetic.crossings import make_crossings
from mcnlab.walking.speed import NAMES as SPEED_NAMES
from mcnlab.widgets.panel import LABEL_WIDTH, Panel, choices, decimal_slider, menu, slider

CROSSING_PEOPLE, CROSSING_SECONDS = 25, 15.0  # few enough to be judged anew at every move
STEP = 0.1  # of the clock, seconds
MOST = 300  # pairs that can be leafed through
_TWO: dict[str, Any] = {
    "columns": 2,
    "figsize": (9.5, 3.7),
    "margins": {"left": 0.08, "bottom": 0.17, "top": 0.9},
}
_MARKS = {"constant-velocity": "◆", "perspective": "●"}  # as in the picture


def threshold_panel(judged: Judged) -> Panel:
    """A probability threshold on the precision-recall curve, and what the answers come to.

    Parameters
    ----------
    judged : occlusion.benchmark.Judged

    Examples
    --------
    >>> from mcnlab.occlusion import find_pairs, judge
    >>> from mcnlab.occlusion.benchmark import compare
    >>> from mcnlab.synthetic import make_crossings
    >>> tables = [
    ...     compare(find_pairs(make_crossings(people=12, seconds=8.0, seed=seed)), name=name)
    ...     for seed, name in enumerate(["one", "two"])
    ... ]
    >>> panel = threshold_panel(judge(tables, draws=2))
    >>> panel.controls["recording"].options
    ('one', 'two')
    """

    @cache
    def curve_of(recording, method):
        table = judged.of(recording)
        occludes = table["occludes"].to_numpy()
        probability = table[f"{method}.probability"].to_numpy()
        return occludes, probability, scores.curve_of(occludes, probability)

    def draw(left, right, recording, method, threshold):
        occludes, probability, curve = curve_of(recording, method)
        found = _score(left, occludes, probability, threshold, method)
        frame_shares(left)
        colour = FORECAST_COLOURS[method]
        for values, style in ((curve.precision, "--"), (curve.recall, ":"), (curve.f1, "-")):
            # From one probability down to the next the answers are those of the higher one.
            right.plot(curve.threshold, values, ls=style, color=colour, drawstyle="steps-post")
        chosen = judged.thresholds.loc[recording, method]
        right.axvline(chosen, color=PALE, lw=4)
        right.axvline(threshold, color=INK, lw=1)
        right.set(xlim=(-0.01, 1.01), ylim=(0, 1.04), xlabel="threshold")
        right.set_title("F1 –   precision - -   recall ···", fontsize=10)
        precision = "none" if found.precision is None else f"{found.precision:.2f}"
        return (
            f"{len(occludes)} pairs: <b>{found.hits}</b> found, <b>{found.misses}</b> missed, "
            f"<b>{found.false_alarms}</b> false alarms; precision {precision}, recall "
            f"{found.recall:.2f}, F1 <b>{found.f1:.3f}</b>; other recordings chose "
            f"{chosen:.2f} (grey)"
        )

    return Panel(
        draw,
        {
            "recording": menu("recording", list(judged.recordings)),
            "method": choices("forecaster", METHODS, value=DEFAULT),
            "threshold": decimal_slider("threshold: yes from", 0.0, 1.0, 0.5, step=0.01),
        },
        **_TWO,
    )


def rules_panel(recording: Recording | None = None, *, threshold: float = 0.5) -> Panel:
    """What counts as a pair and as occlusion, and what it does to two forecasters.

    Parameters
    ----------
    recording : Recording, optional
        A short one; a few synthetic people who cross a square if not given.
    threshold : float, optional
        Probability of a yes.

    Examples
    --------
    >>> panel = rules_panel()
    >>> {name: control.value for name, control in panel.controls.items()}
    {'observed': 1.0, 'horizon': 3.0, 'cover': 0.3}
    """
    if recording is None:
        recording = make_crossings(people=CROSSING_PEOPLE, seconds=CROSSING_SECONDS)
    threshold = require_number("threshold", threshold, low=0, high=1)

    def draw(left, right, **rules):
        pairs = find_pairs(recording, rules=Rules(**rules))
        horizon = pairs.rules.horizon
        frame_shares(left)
        left.set_title(f"marks: yes from {threshold:g}", fontsize=10)
        right.set(xlabel="seconds until they occlude", ylabel="pairs", xlim=(0, horizon))
        right.set_title("black: all that occlude; dashed: found", fontsize=10)
        counts = f"{len(pairs)} pairs, <b>{pairs.occludes.mean():.1%}</b> occlude"
        if not pairs.occludes.any():
            return f"{counts}: nothing to foresee"
        said = []
        edges = np.linspace(0, horizon, 11)
        late = np.histogram(pairs.seconds[pairs.occludes], edges)[0]
        _steps(right, edges, late, INK, "-")
        for forecaster in (ConstantVelocity(), Perspective()):
            name = forecaster.name
            probability = forecaster.forecast(pairs).probability
            found = _score(left, pairs.occludes, probability, threshold, name)
            hit = pairs.seconds[pairs.occludes & (probability >= threshold)]
            colour = FORECAST_COLOURS[name]
            _steps(right, edges, np.histogram(hit, edges)[0], colour, "--")
            precise = scores.average_precision(pairs.occludes, probability)
            mark = f'<span style="color: {colour}">{_MARKS[name]}</span>'
            said.append(f"{name} {mark}: F1 <b>{found.f1:.2f}</b>, AP <b>{precise:.2f}</b>")
        right.set_ylim(0, 1.05 * late.max())
        return f"{counts}; {'; '.join(said)}"

    return Panel(
        draw,
        {
            "observed": decimal_slider("observed (s)", 0.2, 2.0, RULES.observed, step=0.2),
            "horizon": decimal_slider("horizon (s)", 0.5, 5.0, RULES.horizon, step=0.5),
            "cover": decimal_slider("occludes: cover over", 0.05, 0.9, RULES.cover, step=0.05),
        },
        **_TWO,
    )


def pair_panel(
    recording: Recording,
    pairs: Pairs,
    forecasts: dict[str, Forecast] | None = None,
    *,
    thresholds: Mapping[str, float] | None = None,
    most: int = MOST,
) -> Panel:
    """Leaf through pairs and walk the clock on: what happens, and what was foreseen.

    Those that occlude or are said to come first, of these the ones near the camera.

    Parameters
    ----------
    recording : Recording
        That the pairs are from.
    pairs : occlusion.pairs.Pairs
    forecasts : dict, optional
        Method → `occlusion.forecasters.Forecast` of all pairs; of those that learn nothing
        if not given.
    thresholds : mapping, optional
        Method → threshold of a yes; 1/2 if not given.
    most : int, optional
        Pairs to leaf through.

    Raises
    ------
    ArgumentError
        When the recording is another one, or a forecast is of other pairs.

    Examples
    --------
    >>> from mcnlab.occlusion import find_pairs
    >>> from mcnlab.synthetic import make_crossings
    >>> square = make_crossings(people=20, seconds=12.0, seed=3)
    >>> panel = pair_panel(square, find_pairs(square), most=5)
    >>> panel.controls["place"].max
    5
    """
    thesis = Thesis()
    if forecasts is None:
        forecasts = {
            one.name: one.forecast(pairs) for one in (thesis, ConstantVelocity(), Perspective())
        }
    plots.follow_pair(recording, pairs, 0)
    plots.pick_forecasts(pairs, 0, forecasts)
    order = interesting(pairs, forecasts)[: require_count("most", most, low=1)]
    asked = thesis.explain(pairs)[1]
    times = pairs.rules.horizon * np.arange(1, 31) / 30
    size = (recording.frame_width, recording.frame_height)

    @cache
    def story_of(number):
        said = plots.pick_forecasts(pairs, number, forecasts)
        covers = plots.guess_cover(pairs, number, times, said)
        covers = {method: (times, cover) for method, cover in covers.items()}
        return plots.follow_pair(recording, pairs, number), said, covers

    def draw(left, right, place, seconds):
        number = int(order[place - 1])
        story, said, covers = story_of(number)
        guesses, places = {}, {}
        if seconds > 0:
            boxes = plots.guess_boxes(pairs, number, [seconds], said)
            guesses = {method: two[0] for method, two in boxes.items()}
            places = {method: (x, y) for method, (_, _, x, y) in said.items()}
        plots.plot_moment(story, seconds, guesses=guesses, places=places, ax=left)
        plots.frame_story(left, story, shape=0.8, frame=size)
        plots.plot_cover(
            story,
            pairs.rules.cover,
            guesses=covers,
            forecasts=said,
            thresholds=thresholds,
            now=seconds,
            ax=right,
        )
        return _tell(pairs, number, story, asked.iloc[number])

    clock = decimal_slider("seconds", -pairs.rules.observed, pairs.rules.horizon, 0.0, step=STEP)
    panel = Panel(
        draw,
        {"place": slider("pair", 1, len(order), 1), "seconds": clock},
        columns=2,
        figsize=(9.5, 3.9),
        margins={"left": 0.02, "bottom": 0.16, "top": 0.94},
    )
    panel.children = (_player(clock), *panel.children)
    return panel


def interesting(pairs: Pairs, forecasts: dict[str, Forecast]) -> np.ndarray:
    """Pairs in the order of interest: those that occlude or are said to first, near ones first.

    Parameters
    ----------
    pairs : occlusion.pairs.Pairs
    forecasts : dict
        Method → `occlusion.forecasters.Forecast`; the last one's word counts.

    Returns
    -------
    ndarray of int
        Numbers of pairs.
    """
    likely = list(forecasts.values())[-1].probability >= 0.5
    return np.lexsort((-pairs.body, ~(pairs.occludes | likely)))


def _player(clock):
    """A play button that moves a clock, at half the speed of life."""
    play = ipywidgets.Play(
        min=round(clock.min / STEP),
        max=round(clock.max / STEP),
        value=round(clock.value / STEP),
        interval=round(2000 * STEP),
        # Play says nothing of itself; it stands over the sliders that it moves.
        layout={"width": "300px", "margin": f"2px 2px 2px {LABEL_WIDTH + 8}px"},
    )
    traitlets.link(
        (play, "value"),
        (clock, "value"),
        transform=(lambda step: step * STEP, lambda seconds: round(seconds / STEP)),
    )
    return play


def _tell(pairs, number, story, asked):
    """One pair in words."""
    one, two = (pairs.people[number, which] for which in story.order)
    happens = "do not occlude"
    if story.late is not None:
        happens = (
            f"occlude in <b>{story.late:.2f} s</b> (ring) at "
            f"({story.place[0]:.0f}, {story.place[1]:.0f})"
        )
    tables = ", ".join(
        f"{walker} {NAMES[int(asked[f'direction{which}'])]} "
        f"{SPEED_NAMES[int(asked[f'level{which}'])]}"
        for which, walker in ((1, "S1"), (2, "S2"))
    )
    return (
        f"frame {pairs.frame[number]}, walkers {one} (solid) and {two} (dashed): they "
        f"{happens}; the thesis's tables are asked of {tables}"
    )


def _score(ax, occludes, probability, threshold, method):
    """How often a forecaster is right, drawn and counted."""
    found = scores.count_answers(occludes, probability, threshold)
    draw_curve(ax, occludes, probability, method)
    if found.precision is not None:
        draw_point(ax, found, method)
    return found


def _steps(ax, edges, counts, colour, style):
    """A histogram's outline."""
    ax.plot(np.repeat(edges, 2), np.r_[0, np.repeat(counts, 2), 0], color=colour, ls=style)
