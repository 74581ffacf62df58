"""One pair in pictures: what becomes of two walkers, and what forecasters make of them.

Walkers are told apart by their lines, the left one solid and the right one dashed, and
forecasters by colour.  What is seen is black, and the truth with it.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes

from mcnlab.checks import require_choice, require_count
from mcnlab.datasets.recording import Recording
from mcnlab.errors import ArgumentError
from mcnlab.occlusion.benchmark import METHODS
from mcnlab.occlusion.motion import Ground, move_straight
from mcnlab.occlusion.pairs import Pairs
from mcnlab.occlusion.truth import cover_of
from mcnlab.plotting.style import (
    BAND,
    FORECAST_COLOURS,
    FORECAST_LINES,
    FORECAST_MARKERS,
    INK,
    PALE,
    TICKS,
    TRUTH,
    WALKER_LINES,
    axes_or_new,
    frame_axes,
)
from mcnlab.tables import H, W, X, Y

LANE = 0.11  # of the cover's axis, for each forecaster below it


class Story(NamedTuple):
    """What really becomes of one pair, the left walker first."""

    seconds: np.ndarray  # (t,), 0 at the moment
    seen: np.ndarray  # (2, t), where there is a box
    boxes: np.ndarray  # (2, t, 4): x, y, w, h, pixels; 0 where there is none
    cover: np.ndarray  # (t,); 0 where not both have a box
    order: tuple  # which of the pair's two is the left one, and which the right one
    late: float | None  # seconds until they occlude; None if they do not
    place: tuple | None  # where, pixels

    def nearest(self, seconds: float) -> int:
        """The column of the frame nearest to a time."""
        return int(np.argmin(np.abs(self.seconds - seconds)))


def follow_pair(recording: Recording, pairs: Pairs, number: int) -> Story:
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


def guess_boxes(
    pairs: Pairs, number: int, times: np.ndarray, methods: dict
) -> dict[str, np.ndarray]:
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
        method: np.stack([way.x - (way.w - 1) / 2, way.feet - way.h + 0.5, way.w, way.h], axis=-1)
        for method, way in ways.items()
    }


def guess_cover(
    pairs: Pairs, number: int, times: np.ndarray, methods: dict
) -> dict[str, np.ndarray]:
    """The cover that forecasters foresee on the mean path, method → shape (k,)."""
    return {
        method: cover_of(*np.moveaxis(boxes, (1, 2), (0, 1)))
        for method, boxes in guess_boxes(pairs, number, times, methods).items()
    }


def pick_forecasts(pairs: Pairs, number: int, forecasts: dict) -> dict[str, tuple]:
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


def plot_moment(story, seconds, *, guesses=None, places=None, ax: Axes | None = None) -> Axes:
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
        ax.plot(x, feet, color=TRUTH, lw=1, ls=style)
        if seen[at]:
            ax.plot(*_corners(boxes[at]), color=TRUTH, lw=2.2, ls=style)
    for method, foreseen in (guesses or {}).items():
        for box in foreseen:
            line = {"lw": 1.4, "ls": FORECAST_LINES[method], "color": FORECAST_COLOURS[method]}
            ax.plot(*_corners(box), label=method, **line)
    if story.place is not None and seconds > 0:
        ring = {"mfc": "none", "mec": TRUTH, "mew": 1.6, "ls": ""}
        ax.plot(*story.place, marker="o", ms=15, label="truth", **ring)
    for method, place in (places or {}).items():
        draw_forecaster(ax, place[0], place[1], method, ms=8)
    return ax


def draw_forecaster(ax, x, y, method, *, says=True, ms=7) -> None:
    """A forecaster's mark, hollow if it says no."""
    colour = FORECAST_COLOURS[method]
    face = {"mfc": colour, "mec": "white"} if says else {"mfc": "white", "mec": colour}
    marker = FORECAST_MARKERS[method]
    ax.plot([x], [y], ls="", marker=marker, ms=ms, mew=1.2, zorder=4, label=method, **face)


def _corners(box):
    """The outline of a box x, y, w, h: columns and rows."""
    x, y, w, h = box
    return np.array([x, x + w, x + w, x, x]), np.array([y, y, y + h, y + h, y])


def frame_story(ax, story, *, shape=1.0, frame=None) -> None:
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


def plot_cover(
    story, bound, *, guesses=None, forecasts=None, thresholds=None, now=None, ax: Axes | None = None
) -> Axes:
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
    ax.plot(story.seconds[both], story.cover[both], color=TRUTH, lw=2.2, label="truth")
    if story.late is not None:
        at = story.cover[story.nearest(story.late)]
        ax.plot(story.late, at, "o", ms=13, mfc="none", mec=TRUTH, mew=1.6)
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
        ax.axvline(now, color=INK, lw=1.2)
    ax.set(xlim=(story.seconds[0], story.seconds[-1] + 0.05), ylim=(bottom, 1.03))
    ax.set(xlabel="seconds from the moment", ylabel="cover", yticks=TICKS)
    return ax
