"""The figures of sections 2.1 and 2.2: why a camera should stand square-on."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from mcnlab.errors import ArgumentError
from mcnlab.figures.registry import SQUARE, figure
from mcnlab.figures.walking import example_walk
from mcnlab.plotting.gait import CUT, MADE, NOISY, REAL, plot_by_angle, plot_rhythm, plot_width
from mcnlab.plotting.walking import plot_mask
from mcnlab.tables import FRAME, SEQUENCE, H, W
from mcnlab.vision.silhouettes import measure_sequence
from mcnlab.walking import gait, viewpoint

VIEWS = {0: "σ = 0, frontal", 45: "σ = π/4", 90: "σ = π/2, square-on"}


@figure("2.1", section="2.1", notebook=SQUARE)
def gait_cycle(masks, *, frame_rate, count=9) -> Figure:
    """A complete gait cycle.

    Figure 2.1: silhouettes over two steps, evenly spaced in time.

    Claim
    -----
    Heel strike, mid-swing, heel strike, mid-swing: two steps make one cycle.

    Finding
    -------
    From heel strike to the next heel strike of the same foot, seen square-on; the box is widest at
    heel strike.
    """
    boxes = measure_sequence(masks, sequence="walk", subject="walker").set_index(FRAME)
    events = gait.find_events(boxes.index, boxes[W], frame_rate=frame_rate)
    strikes = events.heel_strikes
    if len(strikes) < 3 or len(events.mid_swings) == 0:
        raise ArgumentError(
            f"masks show {len(strikes)} heel strikes; a cycle needs three. Pass a longer walk, "
            "seen from the side."
        )
    middle = len(strikes) // 2 - 1
    first, last = strikes[middle], strikes[middle + 2]
    frames = boxes.index[np.searchsorted(boxes.index, np.linspace(first, last, count))]
    figure, axes = plt.subplots(1, count, figsize=(11, 2.6))
    tall = boxes.loc[frames, H].max()
    for ax, frame in zip(axes, frames, strict=True):
        box = boxes.loc[frame]
        mask = masks[int(frame) - 1]  # frames are numbered from 1
        plot_mask(mask, box=(box.x, box.y, box.w, box.h), ax=ax)
        middle = box.x + box.w / 2
        ax.set(xlim=(middle - 0.4 * tall, middle + 0.4 * tall))
        ax.set(ylim=(box.y + box.h + 4, box.y + box.h - tall - 6))
        near = {
            "heel strike": np.abs(strikes - frame).min(),
            "mid-swing": np.abs(events.mid_swings - frame).min(),
        }
        name = min(near, key=near.get)
        ax.set_title(f"{(frame - first) / frame_rate:.2f} s", fontsize=9, fontweight="normal")
        ax.set_xlabel(name if near[name] <= (last - first) / count / 2 else "", fontsize=8)
    return figure


@figure(
    "2.2",
    section="2.2",
    notebook=SQUARE,
    ids=(
        "gait.casia-a.frontal.detectable",
        "gait.casia-a.oblique.detectable",
        "gait.casia-a.square-on.detectable",
    ),
)
def widths(recording, made, truth) -> Figure:
    """Box width from three view angles.

    Figure 2.2: a real walker (above) and a synthetic one (below) from 0, π/4 and π/2.

    Claim
    -----
    The gait cycle becomes detectable as the view turns from frontal to square-on, where heel
    strikes and mid-swings are plain peaks and troughs.
    """
    figure, axes = plt.subplots(2, 3, figsize=(11, 5), sharey="row")
    for column, (angle, name) in enumerate(VIEWS.items()):
        real = _walk_at(recording, angle)
        coming = np.cos(np.radians(truth["heading"])) < 1e-9
        there = truth.index[(truth["angle"] == angle) & coming]
        if len(there) == 0:
            raise ArgumentError(f"truth has no walk at {angle}°; record one there.")
        wanted = there[0]
        synthetic = made[made[SEQUENCE] == wanted]
        for ax, walk, colour in zip(axes[:, column], (real, synthetic), (REAL, MADE), strict=True):
            seconds = (walk[FRAME] - walk[FRAME].iloc[0]) / recording.frame_rate
            events = None
            if angle == 90:
                found = gait.find_events(walk[FRAME], walk[W], frame_rate=recording.frame_rate)
                events = [(times - walk[FRAME].iloc[0]) / recording.frame_rate for times in found]
            plot_width(seconds, walk[W], events=events, colour=colour, ax=ax)
        axes[0, column].set(title=name, xlabel="")
    for ax in axes[:, 1:].flat:
        ax.set_ylabel("")
    for row in axes:
        row[0].set_ylim(0, 1.1 * max(line.get_ydata().max() for ax in row for line in ax.lines))
    axes[0, 0].set_ylabel("real walker\nbox width (pixels)")
    axes[1, 0].set_ylabel("synthetic walker\nbox width (pixels)")
    axes[0, 2].legend(loc="lower right", ncols=2)
    return figure


@figure("rhythm", notebook=SQUARE)
def rhythm(recording) -> Figure:
    """The rhythm by autocorrelation.

    Autocorrelation of width over height of one real walk from each view angle.

    Question
    --------
    Is the box width like itself one step later?

    Finding
    -------
    Square-on it is, and the lag is the step's period; frontal, hardly.
    """
    figure, axes = plt.subplots(1, 3, figsize=(11, 3.2), sharey=True)
    for ax, (angle, name) in zip(axes, VIEWS.items(), strict=True):
        walk = _walk_at(recording, angle)
        lags, correlation, period = gait.rhythm_of(walk, frame_rate=recording.frame_rate)
        plot_rhythm(lags, correlation, period=period, title=name, ax=ax)
        ax.set_xlim(0, 1.6)
    for ax in axes[1:]:
        ax.set_ylabel("")
    return figure


@figure(
    "view-angle",
    notebook=SQUARE,
    ids=(
        "gait.synthetic.half_peak_off_square_deg",
        "gait.synthetic.right.90",
        "gait.synthetic.right.90.cut",
        "gait.synthetic.right.45",
    ),
)
def view_angles(clean, noisy, cut, real) -> Figure:
    """How the gait fades as the camera leaves the side.

    Rhythm and its detection against the view angle: synthetic, with noise, and real.

    Question
    --------
    How far from square-on may a camera stand?

    Parameters
    ----------
    clean, noisy, cut, real : pandas.DataFrame
        From `viewpoint.detectability`, with ``low`` and ``high`` of the share; `noisy` is like
        CASIA A's silhouettes, in `cut` a limb is missing all along.
    """
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 3.8))
    tables = {
        "synthetic": (clean, MADE, "^", "-"),
        "synthetic, noise like CASIA A's": (noisy, NOISY, "s", "--"),
        "synthetic, a limb cut": (cut, CUT, "v", ":"),
        "CASIA A": (real, REAL, "o", ""),
    }
    plot_by_angle(
        tables,
        "peak",
        low="peak_low",
        high="peak_high",
        ylabel="autocorrelation at the step\n(median and quartiles)",
        ax=left,
    )
    plot_by_angle(
        tables, "share", low="low", high="high", ylabel="walks with a rhythm (share)", ax=right
    )
    left.set_ylim(-0.2, 1)
    right.set_ylim(0, 1.05)
    left.legend(loc="upper left", fontsize=8)
    return figure


def _walk_at(recording, angle):
    """The boxes of the first walk at a view angle, coming rather than going."""
    directions = [way for way in (5, 4, 6, 3, 7, 1, 2, 8) if viewpoint.view_angle_of(way) == angle]
    there = set(recording.directions)
    return example_walk(recording, next((way for way in directions if way in there), directions[0]))
