"""The panels of chapter 3, motion: from silhouettes to headings."""

from dataclasses import replace

import ipywidgets
import numpy as np
import pandas as pd

from mcnlab.cameras import horizon
from mcnlab.datasets.mirror import OBLIQUE, SUFFIX, mirror_boxes, mirror_direction
from mcnlab.datasets.recording import Recording
from mcnlab.errors import ArgumentError, SilhouetteError
from mcnlab.plotting import walking as plots
from mcnlab.plotting.gait import plot_width
from mcnlab.plotting.speed import plot_by_distance, plot_by_level
from mcnlab.plotting.style import METHOD_COLOURS, UPPER
from mcnlab.synthetic.noise import SegmentationNoise, add_noise
from mcnlab.tables import FRAME, SEQUENCE, H, W
from mcnlab.vision.silhouettes import MIN_AREA, find_body
from mcnlab.walking import gait, heading, phase
from mcnlab.walking.direction import LinearSeparators, group_of, leave_one_subject_out
from mcnlab.walking.evaluation import judge_headings, truth_of
from mcnlab.walking.speed import FAST, LEVELS, NAMES, SECONDS, SLOW, level_of, misordered
from mcnlab.widgets.panel import Panel, choices, decimal_slider, label, menu, slider


def silhouette_panel(masks: np.ndarray, *, seed: int = 0) -> Panel:
    """Turn up the noise on a walk and watch the box: minimum blob area, specks, holes, limbs.

    Parameters
    ----------
    masks : ndarray, shape (frames, height, width)
        A clean walk; its own boxes are the truth.
    seed : int, optional
        Of the noise.

    Examples
    --------
    >>> from mcnlab.synthetic import make_walks
    >>> panel = silhouette_panel(make_walks(subjects=1, directions=(3,), seed=0)[0].masks)
    >>> for name in ("specks", "holes", "limbs"):
    ...     panel.controls[name].value = 0
    >>> panel.text.value
    'box right (overlap of 0.8 or more) in <b>100%</b> of 12 frames'
    """
    sample = np.unique(np.linspace(0, len(masks) - 1, 12).astype(int))
    truth = {index: find_body(masks[index]) for index in sample}

    def draw(left, right, frame, min_area, specks, holes, limbs):
        noise = SegmentationNoise(specks=specks, holes=holes, cut_limbs=limbs, cut_share=1.0)
        noisy = dict(zip(sample, add_noise(masks[sample], noise, seed=seed), strict=True))
        index = min(sample, key=lambda held: abs(held - frame))
        box, overlaps = None, []
        for held, mask in noisy.items():
            try:
                body = find_body(mask, min_area=min_area)
            except SilhouetteError:
                overlaps.append(0.0)
                continue
            overlaps.append(_overlap(body, truth[held]))
            if held == index:
                box = (body.x, body.y, body.w, body.h)
        plots.plot_mask(noisy[index], box=box, title=f"frame {index + 1}", ax=left)
        right.plot(sample + 1, overlaps, "o-", color=METHOD_COLOURS["perspective"])
        right.set(xlabel="frame", ylabel="overlap of box and true box", ylim=(0, 1.05))
        good = np.mean(np.array(overlaps) >= 0.8)
        return f"box right (overlap of 0.8 or more) in <b>{good:.0%}</b> of {len(sample)} frames"

    return Panel(
        draw,
        {
            "frame": slider("frame", 0, len(masks) - 1, len(masks) // 2),
            "min_area": slider("min blob area (px)", 1, 200, MIN_AREA),
            "specks": slider("specks a frame", 0, 60, 20),
            "holes": slider("holes a frame", 0, 20, 4),
            "limbs": slider("limbs cut", 0, 4, 1),
        },
        columns=2,
    )


def mirror_panel(recording: Recording) -> Panel:
    """Pick a walk and see its boxes beside their mirror image.

    Parameters
    ----------
    recording : Recording
        With labels.

    Examples
    --------
    >>> from mcnlab.vision import casia_a
    >>> mirror_panel(casia_a()).text.value
    '93 frames in direction 6; mirrored, direction 4'
    """
    oblique = [name for name in recording.sequences if recording.directions[name] in OBLIQUE]

    def draw(left, right, sequence, every):
        boxes = recording.sequence(sequence)
        direction = int(recording.directions[sequence])
        mirrored = mirror_direction(direction)
        width = recording.frame_width
        twin = mirror_boxes(boxes, frame_width=width)
        frame = {"frame_width": width, "frame_height": recording.frame_height, "every": every}
        plots.plot_boxes(boxes, direction=direction, ax=left, **frame)
        plots.plot_boxes(twin, direction=mirrored, ax=right, **frame)
        return f"{len(boxes)} frames in direction {direction}; mirrored, direction {mirrored}"

    return Panel(
        draw,
        {
            "sequence": menu("walk", oblique),
            "every": slider("every … frames", 2, 30, 10),
        },
        columns=2,
    )


def phase_panel(recording: Recording) -> Panel:
    """Thresholds of the thesis's phase over one walk's curve; accuracy over all walks.

    Parameters
    ----------
    recording : Recording
        With labels.

    Examples
    --------
    >>> from mcnlab.vision import casia_a
    >>> list(phase_panel(casia_a()).controls)
    ['sequence', 'dimension', 'prominence', 'spacing', 'soft_rule']
    """
    judge = _PhaseJudge(recording)

    def draw(ax, sequence, dimension, **thresholds):
        boxes = judge.walks[sequence]
        found = phase.measure_phase(
            boxes[FRAME].to_numpy(), boxes[dimension].to_numpy(), **thresholds
        )
        plots.plot_phase(
            found,
            dimension=dimension,
            parts=("extrema", "soft", "envelope", "mean"),
            legend=False,  # it stands in the figures above, and takes as long as the rest
            ax=ax,
        )
        said = judge.measure(dimension, thresholds)[-1]
        return f"phase {found.mean.slope:+.2f} pixels a frame; {said}"

    return Panel(
        draw,
        {"sequence": menu("walk", list(judge.walks)), **_phase_controls()},
    )


def separator_panel(recording: Recording) -> Panel:
    """Thresholds of the thesis's phase over Figure 3.12 or 3.13, and its accuracy.

    Parameters
    ----------
    recording : Recording
        With labels.

    Examples
    --------
    >>> from mcnlab.vision import casia_a
    >>> separator_panel(casia_a()).text.value.split(" by ")[0]
    'groups right: <b>0.8705</b>'
    """
    judge = _PhaseJudge(recording)

    def draw(ax, dimension, **thresholds):
        values, separators, said = judge.measure(dimension, thresholds)
        plots.plot_phases(
            values,
            judge.truth,
            separators=separators,
            label=f"m_{dimension} (pixels a frame)",
            legend=False,  # it stands in the figures above, and takes as long as the rest
            ax=ax,
        )
        return said

    return Panel(draw, _phase_controls())


def heading_panel(recording: Recording, *, focal_length: float) -> Panel:
    """Focal length and window length over heading errors, and the accuracy.

    Parameters
    ----------
    recording : Recording
        With labels.  Mirrored copies are left out: they repeat what their walks say.
    focal_length : float
        Pixels, to begin with.

    Examples
    --------
    >>> from mcnlab.vision import casia_a
    >>> heading_panel(casia_a(), focal_length=450).text.value.split(" [")[0]
    'directions right: <b>0.998</b>'
    """
    own = recording.without_copies()
    # The horizon does not depend on the focal length: it is found once.
    found = horizon.estimate_cameras(own, focal_length=focal_length)

    def draw(ax, focal_length, window):
        cameras = {name: replace(held, focal_length=focal_length) for name, held in found.items()}
        headings = heading.measure_headings(
            own, focal_length=focal_length, window=window, cameras=cameras
        )
        right, error, errors = judge_headings(own, headings)
        truth = truth_of(own, headings["sequence"].to_numpy())
        plots.plot_heading_errors(errors, truth, ax=ax)
        return (
            f"directions right: <b>{right.value:.3f}</b> [{right.low:.3f}, {right.high:.3f}], "
            f"mean error <b>{error.value:.1f}°</b>, {len(headings)} windows"
        )

    return Panel(
        draw,
        {
            "focal_length": slider("focal length (px)", 200, 800, int(focal_length), step=10),
            "window": slider("window (frames)", 6, 50, round(recording.frame_rate)),
        },
    )


class _PhaseJudge:
    """The thesis's phase of every walk, quickly enough for a slider.

    A mirrored copy has its walk's phase; only filmed walks are measured, and each
    oblique one counts twice, as in the thesis.
    """

    def __init__(self, recording):
        own = recording.without_copies()
        self.boxes = own.boxes
        self.walks = {name: own.sequence(name) for name in own.sequences}
        names = np.array(own.sequences, dtype=object)
        copied = [name for name in names if name + SUFFIX in recording.copies]
        self.order = np.r_[np.arange(len(names)), np.flatnonzero(np.isin(names, copied))]
        truth = truth_of(own)
        twins = mirror_direction(truth[self.order[len(names) :]])
        self.truth = np.r_[truth, twins]
        self.groups = group_of(self.truth)
        self.subjects = own.subjects.to_numpy()[self.order]

    def measure(self, dimension, thresholds):
        """The phases, the separators between them, and in words how often they are right."""
        measured = phase.measure_phases(self.boxes, dimensions=(dimension,), **thresholds)
        values = measured[f"m_{dimension}"].to_numpy()[self.order]
        separators = LinearSeparators().fit(values, self.groups)
        fitted = (separators.predict(values) == self.groups).mean()
        left_out = leave_one_subject_out(LinearSeparators(), values, self.groups, self.subjects)
        return (
            values,
            separators,
            f"groups right: <b>{fitted:.4f}</b> by resubstitution, as in the thesis; "
            f"<b>{(left_out == self.groups).mean():.4f}</b> leaving one subject out",
        )


def _phase_controls():
    return {
        "dimension": choices("curve", [("height", H), ("width", W)]),
        "prominence": decimal_slider("prominence (px)", 0, 10, phase.PROMINENCE, step=0.5),
        "spacing": slider("spacing (frames)", 1, 15, phase.SPACING),
        "soft_rule": choices("soft extrema", [("drop", "line"), ("keep", "keep")]),
    }


def _overlap(body, true):
    """Intersection over union of two boxes."""
    wide = min(body.x + body.w, true.x + true.w) - max(body.x, true.x)
    high = min(body.y + body.h, true.y + true.h) - max(body.y, true.y)
    shared = max(wide, 0) * max(high, 0)
    return shared / (body.w * body.h + true.w * true.h - shared)


def gait_panel(boxes: pd.DataFrame, truth: pd.DataFrame, *, frame_rate: float) -> Panel:
    """Turn a synthetic walker and watch his box's width and its rhythm.

    Parameters
    ----------
    boxes : pandas.DataFrame
        From `viewpoint.record_at_angles`.
    truth : pandas.DataFrame
        Its walks: ``subject, angle, step_s``.
    frame_rate : float

    Examples
    --------
    >>> from mcnlab.walking.viewpoint import record_at_angles
    >>> boxes, truth = record_at_angles([0, 90], subjects=1)
    >>> gait_panel(boxes[0], truth, frame_rate=25).controls["angle"].options
    (0, 90)
    """
    walks = dict(list(boxes.groupby(SEQUENCE, sort=False)))
    truth = truth.loc[list(walks)]
    angles = sorted(truth["angle"].unique())

    def draw(left, right, subject, angle):
        at = min(angles, key=lambda held: abs(held - angle))
        there = truth.index[(truth["angle"] == at) & (truth["subject"] == subject)]
        if len(there) == 0:
            raise ArgumentError(f"angle: {subject} has no walk at {at:g}°; pick another.")
        name = there[0]
        walk = walks[name]
        seconds = (walk["frame"] - walk["frame"].iloc[0]) / frame_rate
        plot_width(seconds, walk[W], colour=METHOD_COLOURS["growth"], ax=left)
        left.set_ylim(0, 1.05 * boxes[W].max())
        lags, correlation, period = gait.rhythm_of(walk, frame_rate=frame_rate)
        right.plot(lags, correlation, color=METHOD_COLOURS["growth"])
        if period.step > 0:
            right.plot(period.step, period.peak, "o", color=UPPER)
        right.set(xlim=(0, 1.6), ylim=(-1, 1), xlabel="lag (s)", ylabel="autocorrelation")
        found = f"step <b>{period.step:.2f} s</b>" if period.detectable else "<b>no rhythm</b>"
        return (
            f"σ = {at:g}°: {found} (true step {truth.step_s[name]:.2f} s), "
            f"autocorrelation {period.peak:.2f}, p = {period.p_value:.3f}"
        )

    return Panel(
        draw,
        {
            "subject": menu("walker", sorted(truth["subject"].unique())),
            "angle": ipywidgets.SelectionSlider(
                options=[int(held) for held in angles],
                value=int(min(angles, key=lambda held: abs(held - 60))),
                **label("view angle (°)"),
            ),
        },
        columns=2,
        margins={"wspace": 0.35},
    )


def speed_panel(tables: dict[str, pd.DataFrame]) -> Panel:
    """Thresholds and window length over windows by distance, and true speed by level.

    Parameters
    ----------
    tables : dict
        Title → table of `speed.compare_speeds`, with windows of one second and, if the
        first has them, of other lengths.

    Examples
    --------
    >>> from mcnlab.walking.outdoors import apparent_speeds
    >>> panel = speed_panel({"PETS 2009": apparent_speeds("pets")})
    >>> list(panel.controls)
    ['where', 'seconds', 'slow', 'fast']
    """
    titles = list(tables)
    lengths = sorted(tables[titles[0]]["seconds"].unique())

    def draw(left, right, where, seconds, slow, fast):
        table = tables[where][tables[where]["seconds"] == seconds]
        right.set_xticks([])  # nothing is said of the levels if the thresholds are refused
        level = level_of(table["share"], frame_width=1, slow=slow / 100, fast=fast / 100)
        plot_by_distance(
            table["distance"],
            100 * table["share"],
            level,
            ylabel="p (% of the frame's width)",
            cuts=(slow, fast),
            legend=False,  # the right-hand picture names the levels
            ax=left,
        )
        speed = table["true_speed"].to_numpy()
        plot_by_level(speed, level, ax=right)
        said = ", ".join(
            f"{NAMES[one]} <b>{np.median(speed[level == one]):.2f} m/s</b>"
            if (level == one).any()
            else f"{NAMES[one]} <b>no window</b>"
            for one in LEVELS
        )
        # No interval: it would cost more than the rest.
        wrong = misordered(speed, level, table["sequence"], draws=1)
        overlap = "" if wrong is None else f"; v2 truly faster than v3: <b>{wrong.value:.0%}</b>"
        return f"{len(table)} windows; median {said}{overlap}"

    return Panel(
        draw,
        {
            "where": choices("walkers", titles),
            "seconds": choices(
                "window", [(f"{length:g} s", length) for length in lengths], value=SECONDS
            ),
            "slow": decimal_slider("slow: v1 up to (%)", 0, 10, 100 * SLOW, step=0.25),
            "fast": decimal_slider("fast: v2 up to (%)", 0, 20, 100 * FAST, step=0.25),
        },
        columns=2,
        figsize=(10, 4),
        margins={"left": 0.08, "wspace": 0.25},
    )
