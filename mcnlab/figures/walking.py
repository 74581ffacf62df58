"""The figures of chapter 3, motion: from boxes to one of eight directions."""

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from mcnlab.compass import DIRECTIONS
from mcnlab.datasets.mirror import SUFFIX
from mcnlab.datasets.recording import Recording
from mcnlab.errors import ArgumentError, SilhouetteError
from mcnlab.figures.registry import MIRROR, SEPARATE, START, TRACE, figure
from mcnlab.plotting.style import BLUE, FAINT, INK, NIGHT, SKY, UPPER
from mcnlab.plotting.walking import (
    colour_of,
    direction_style,
    group_legend,
    plot_boxes,
    plot_curves,
    plot_directions,
    plot_mask,
    plot_phase,
    plot_phase_space,
    plot_phases,
)
from mcnlab.tables import FRAME, SEQUENCE, SUBJECT, H, W
from mcnlab.vision.silhouettes import close_gaps, find_body, rectify_with_flow
from mcnlab.walking import phase
from mcnlab.walking.direction import LinearSeparators, group_of
from mcnlab.walking.evaluation import truth_of


@figure("3.2", section="3.2.1", notebook=START)
def directions() -> Figure:
    """Eight directions of motion.

    Claim
    -----
    Eight directions, 45° apart, are enough to foresee occlusion.

    Finding
    -------
    Numbered clockwise from away; the figure itself is lost, the tables agree with this reading.
    """
    figure, ax = plt.subplots(figsize=(5, 5))
    plot_directions(ax)
    return figure


@figure("mirror", notebook=MIRROR, ids=("casia-a.videos", "casia-a.videos_per_direction"))
def mirroring(recording, mirrored) -> Figure:
    """Mirroring makes eight directions out of six.

    Videos a direction before and after mirroring, and one walk beside its mirror image.

    Claim
    -----
    320 videos, 40 in each direction, by mirroring the 45° walks (section 3.1).

    Finding
    -------
    Two walks a subject and direction, 16 videos a subject, as in the thesis; how many subjects
    depends on the data at hand.
    """
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.6), width_ratios=(1, 1.2))
    before = np.bincount(truth_of(recording), minlength=9)[1:]
    after = np.bincount(truth_of(mirrored), minlength=9)[1:]
    colours = [colour_of(direction) for direction in DIRECTIONS]
    left.bar(DIRECTIONS, after, color="white", edgecolor=colours, hatch="///", label="mirrored")
    left.bar(DIRECTIONS, before, color=colours, label="filmed")
    left.set(xlabel="direction", ylabel="videos", xticks=DIRECTIONS, title="Videos a direction")
    left.set_ylim(0, 1.25 * after.max())
    left.legend(loc="upper right", ncols=2)
    copy = sorted(mirrored.copies)[0]
    original = copy.removesuffix(SUFFIX)
    for name in (original, copy):
        plot_boxes(
            mirrored.sequence(name),
            frame_width=mirrored.frame_width,
            frame_height=mirrored.frame_height,
            every=12,
            direction=int(mirrored.directions[name]),
            ax=right,
        )
    right.axvline((mirrored.frame_width - 1) / 2, color=INK, lw=0.8, ls=":")
    right.set_title(f"{original} and its mirror image")
    return figure


@figure("3.3", section="3.2.1", notebook=TRACE)
def box_patterns(recording, *, subject=None) -> Figure:
    """How a walker's box changes.

    Figure 3.3: boxes in each of the eight directions, of one subject if given.

    Claim
    -----
    Size and place of the box together make a pattern that is unique to each direction.

    Finding
    -------
    Left and right differ in place only: their sizes are mirror images.
    """
    figure, axes = plt.subplots(2, 4, figsize=(11, 4.4))
    for direction, ax in zip(DIRECTIONS, axes.flat, strict=True):
        plot_boxes(
            example_walk(recording, direction, subject=subject),
            frame_width=recording.frame_width,
            frame_height=recording.frame_height,
            every=10,
            direction=direction,
            ax=ax,
        )
    return figure


@figure("3.4", section="3.2.1", notebook=TRACE)
def height_curves(recording, *, subject=None) -> Figure:
    """Height against frame number.

    Figure 3.4: four directions.

    Claim
    -----
    Height stays level across the view, grows toward the camera and shrinks away from it.

    Finding
    -------
    So it does, with a ripple of a few pixels at every step.
    """
    return _curves(recording, H, subject)


@figure("3.5", section="3.2.1", notebook=TRACE)
def width_curves(recording, *, subject=None) -> Figure:
    """Width against frame number.

    Figure 3.5: four directions.

    Claim
    -----
    Across the view, width swings with the legs at regular intervals.

    Finding
    -------
    It swings in every oblique view too, and hides the slope that it is to show.
    """
    return _curves(recording, W, subject)


@figure("3.6", section="3.2.1 (a)", notebook=TRACE)
def rectified_frames(first, second) -> Figure:
    """Frame rectification and removal of unwanted blobs.

    Figure 3.6: two sequences of masks as they come, and mended.

    Claim
    -----
    The largest connected component is the subject; optical flow mends the segmentation.

    Finding
    -------
    The largest component alone loses heads and legs; fragments in one column with it are kept
    here, and the flow's vote brings back what is lost for a frame or two.
    """
    figure, axes = plt.subplots(4, 5, figsize=(11, 6.6))
    for masks, rows, name in ((first, axes[:2], "sequence 1"), (second, axes[2:], "sequence 2")):
        mended = rectify_with_flow(masks)
        for index, raw, clean in zip(_measurable(mended, 5), *rows, strict=True):
            plot_mask(masks[index], title=f"{name}, frame {index + 1}", ax=raw)
            plot_mask(find_body(mended[index]).mask, title="mended", ax=clean)
    return figure


@figure("3.7", section="3.2.1 (b)", notebook=TRACE)
def tracked_frames(masks) -> Figure:
    """Morphological operations and tracking.

    Figure 3.7: noise removed and closed above, boxed below.

    Claim
    -----
    A box fitted to the mended silhouette follows the subject.

    Finding
    -------
    Direction 6: what is no body removed and gaps closed above, boxed below.
    """
    figure, axes = plt.subplots(2, 5, figsize=(11, 3.5))
    for index, above, below in zip(_measurable(masks, 5), *axes, strict=True):
        body = find_body(masks[index])
        closed = close_gaps(body.mask)
        plot_mask(closed, title=f"frame {index + 1}", ax=above)
        plot_mask(closed, box=(body.x, body.y, body.w, body.h), ax=below)
    return figure


@figure("3.8", section="3.2.1 (c)", notebook=TRACE)
def envelope(walk, **thresholds) -> Figure:
    """Envelope over the plot.

    Claim
    -----
    Maxima and minima of a gait cycle bound the curve between two lines.

    Finding
    -------
    They are regressions: the extrema scatter about them, and single ones lie outside.
    """
    figure, ax = plt.subplots()
    plot_phase(_phase(walk, W, thresholds), dimension="w", parts=("extrema", "envelope"), ax=ax)
    return figure


@figure("3.9", section="3.2.1 (c)", notebook=TRACE)
def soft_extrema(walk, **thresholds) -> Figure:
    """Detection and removal of soft extrema.

    Figure 3.9: (a) with soft extrema, (b) without.

    Claim
    -----
    A maximum below the regression line, or a minimum above it, is misplaced.

    Finding
    -------
    The rule drops ripples on the wrong side of the regression line.
    """
    figure, axes = plt.subplots(1, 2, figsize=(11, 4), sharey=True)
    found = _phase(walk, W, thresholds)
    for ax, parts, title in zip(
        axes,
        (("extrema", "soft", "trend"), ("extrema", "trend")),
        ("(a) with soft extrema", "(b) without"),
        strict=True,
    ):
        plot_phase(found, dimension="w", parts=parts, ax=ax)
        ax.set_title(title)
    return figure


@figure("3.10", section="3.2.1 (c)", notebook=TRACE)
def average_line(walk, **thresholds) -> Figure:
    """Envelope and average line.

    Figure 3.10: (a) envelope, (b) the average line with it.

    Claim
    -----
    The line midway between the two envelope lines is the walk's phase.

    Finding
    -------
    Drawn as defined; its slope is m_w here.
    """
    figure, axes = plt.subplots(1, 2, figsize=(11, 4), sharey=True)
    found = _phase(walk, W, thresholds)
    plot_phase(found, dimension="w", parts=("extrema", "envelope"), ax=axes[0])
    plot_phase(found, dimension="w", parts=("envelope", "mean"), ax=axes[1])
    axes[0].set_title("(a) envelope")
    axes[1].set_title("(b) average line: the phase")
    return figure


@figure("3.11", section="3.2.1 (d)", notebook=TRACE)
def near_and_far(recording, **thresholds) -> Figure:
    """Near and far in one direction.

    Figure 3.11: the tallest and the smallest walker in direction 3.

    Claim
    -----
    Distance changes the span of the graph but not its phase.

    Finding
    -------
    True where the phase is about zero, as in direction 3; elsewhere the slope grows with nearness
    (see the slope figure).
    """
    figure, axes = plt.subplots(1, 2, figsize=(11, 4), sharey=True)
    mean = recording.boxes.groupby(SEQUENCE, sort=False)[H].mean()
    right = mean[recording.directions[mean.index] == 3]
    for ax, name, title in zip(
        axes, (right.idxmax(), right.idxmin()), ("(a) closer", "(b) farther"), strict=True
    ):
        found = _phase(recording.sequence(name), W, thresholds)
        plot_phase(found, dimension="w", parts=("envelope", "mean"), ax=ax)
        ax.set_title(f"{title}: {name}, {mean[name]:.0f} pixels tall")
    return figure


@figure(
    "3.12",
    section="3.2.1 (e)",
    notebook=SEPARATE,
    ids=("direction.height.phase5.resubstitution", "direction.height.phase5.loso"),
)
def phases_by_height(recording, measured) -> Figure:
    """Directions by height.

    Figure 3.12: m_h against video.

    Claim
    -----
    Best-fitting linear separators on m_h tell the direction in 93.75 % of 320 videos.
    """
    return _phase_figure(recording, measured["m_h"], "m_h, slope of height (pixels a frame)")


@figure(
    "3.13",
    section="3.2.1 (e)",
    notebook=SEPARATE,
    ids=("direction.width.phase5.resubstitution", "direction.width.phase5.loso"),
)
def phases_by_width(recording, measured) -> Figure:
    """Directions by width.

    Figure 3.13: m_w against video.

    Claim
    -----
    Best-fitting linear separators on m_w tell the direction in 83.75 % of 320 videos.
    """
    return _phase_figure(recording, measured["m_w"], "m_w, slope of width (pixels a frame)")


@figure(
    "thresholds",
    notebook=SEPARATE,
    ids=("direction.height.phase5.best_of_sweep", "direction.width.phase5.best_of_sweep"),
)
def thresholds(sweep, claims) -> Figure:
    """What the rules for extrema could have given.

    Resubstitution against prominence, one line a spacing and soft rule.

    Question
    --------
    The thesis names no rule for extrema. Does some rule reach its accuracies?

    Parameters
    ----------
    sweep : pandas.DataFrame
        From `evaluation.sweep_thresholds`.
    claims : dict
        ``height`` and ``width``: the thesis's accuracies.
    """
    figure, axes = plt.subplots(1, 2, figsize=(11, 4), sharey=True)
    shades = dict(zip(sorted(sweep["spacing"].unique()), (NIGHT, BLUE, SKY), strict=False))
    for ax, (name, claim) in zip(axes, claims.items(), strict=True):
        for (rule, spacing), rows in sweep.groupby(["soft_rule", "spacing"]):
            ax.plot(
                rows["prominence"],
                rows[name],
                color=shades.get(spacing, FAINT),
                ls="-" if rule == "line" else ":",
                marker="o",
                ms=3,
                label=f"{'drop' if rule == 'line' else 'keep'} soft, spacing {spacing}",
            )
        ax.axhline(claim, color=UPPER, ls="--", label="thesis")
        ax.set(xlabel="prominence (pixels)", title=f"{name}: the thesis has {claim}")
    axes[0].set_ylabel("groups right by resubstitution (share)")
    axes[1].legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


@figure("growth", notebook=SEPARATE, ids=("direction.height-growth.phase5.loso",))
def phases_by_growth(recording, space) -> Figure:
    """The relative growth of height.

    Relative growth against video, with its separators.

    Question
    --------
    Does a phase that does not depend on distance separate the five groups better?
    """
    return _phase_figure(recording, space["height_growth"], "relative growth of height (1/s)")


@figure("slope", notebook=SEPARATE)
def slope_and_distance(recording, measured, space) -> Figure:
    """Why the slope depends on distance.

    Raw slope and relative growth against mean box height, walks along the view.

    Claim
    -----
    The thesis calls the slope distance-invariant (section 3.2.1 (d)).

    Finding
    -------
    It is not: in one direction a taller image means a steeper slope. The relative growth depends
    on it less.
    """
    figure, axes = plt.subplots(1, 2, figsize=(11, 4))
    mean = recording.boxes.groupby(SEQUENCE, sort=False)[H].mean()
    truth = truth_of(recording)
    for ax, values, label in (
        (axes[0], measured["m_h"], "m_h (pixels a frame)"),
        (axes[1], space["height_growth"], "relative growth of height (1/s)"),
    ):
        for direction in DIRECTIONS:
            at = truth == direction
            ax.plot(
                mean.to_numpy()[at],
                values.to_numpy()[at],
                ls="",
                **direction_style(direction),
            )
        ax.set(xlabel="mean box height (pixels)", ylabel=label)
    group_legend(axes[1])
    axes[0].set_title("slope: fans out with nearness")
    axes[1].set_title("relative growth: less so")
    return figure


@figure("phase-space", notebook=SEPARATE, ids=("direction.phase-space.direction8.loso",))
def phase_space(recording, space) -> Figure:
    """Eight directions in the phase space.

    Sideways speed against relative growth.

    Question
    --------
    Can linear separators tell all eight directions, left and right included?
    """
    figure, ax = plt.subplots(figsize=(8, 5))
    plot_phase_space(space, truth_of(recording, space.index), ax=ax)
    return figure


@figure("walkers", notebook=START)
def walkers(made, recording, real=None) -> Figure:
    """Synthetic walkers beside real ones.

    Synthetic silhouettes (and real ones if given) over their height and width curves.

    Question
    --------
    Are the walkers that we can make like those that were filmed?

    Finding
    -------
    Made walkers in colour over every real walk of that direction in grey.

    Parameters
    ----------
    made : list of SyntheticWalk
        One a direction.
    recording : Recording
        Real walks.
    real : list of ndarray, optional
        Real masks of the same directions.
    """
    rows = [(walk.masks, f"made, direction {walk.direction}") for walk in made]
    if real is not None:
        pairs = zip(real, made, rows, strict=True)
        rows = [
            row
            for masks, walk, row_made in pairs
            for row in ((masks, f"real, direction {walk.direction}"), row_made)
        ]
    figure = plt.figure(figsize=(11, 1.75 * len(rows) + 2.8))
    above, below = figure.subfigures(2, 1, height_ratios=(1.75 * len(rows), 2.8))
    axes = above.subplots(len(rows), 5, squeeze=False)
    for (masks, name), line in zip(rows, axes, strict=True):
        for index, ax in zip(np.linspace(4, len(masks) - 5, 5).astype(int), line, strict=True):
            plot_mask(masks[index], ax=ax)
        line[0].set_ylabel(name, fontsize=8)
    for walk, ax in zip(made, below.subplots(1, len(made)), strict=True):
        colour = colour_of(walk.direction)
        names = recording.directions.index[recording.directions == walk.direction]
        for name in names:
            boxes = recording.sequence(name)
            time = (boxes[FRAME] - boxes[FRAME].iloc[0]) / recording.frame_rate
            for dimension in (H, W):
                ax.plot(time, boxes[dimension], color=FAINT, lw=0.6)
        time = np.arange(len(walk.truth)) / walk.walk.frame_rate
        for dimension, style in ((H, "-"), (W, "--")):
            ax.plot(time, walk.truth[dimension], color=colour, ls=style, lw=2)
        ax.set(xlabel="time (s)", title=f"direction {walk.direction}", ylim=(0, None))
    below.axes[0].set_ylabel("height (solid),\nwidth (dashed), pixels")
    return figure


def example_walk(
    recording: Recording, direction: int, *, subject: str | None = None
) -> pd.DataFrame:
    """The boxes of one walk in a direction: the subject's, or the first there is.

    Raises
    ------
    ArgumentError
        When nobody walks that way.
    """
    names = recording.directions.index[recording.directions == direction]
    if subject is not None:
        names = [name for name in names if recording.subjects[name] == subject]
    if len(names) == 0:
        raise ArgumentError(
            f"direction is {direction}: no such walk"
            + (f" of subject {subject!r}" if subject else "")
            + f" in {recording.name}; pass another."
        )
    return recording.sequence(names[0])


def _measurable(masks, count):
    """Frames with one walker in them, evenly spread."""
    sound = []
    for index, mask in enumerate(masks):
        try:
            find_body(mask)
        except SilhouetteError:
            continue
        sound.append(index)
    if len(sound) < count:
        raise ArgumentError(f"masks show one walker in {len(sound)} frames; {count} are drawn.")
    places = np.linspace(0.04, 0.96, count) * (len(sound) - 1)
    return [sound[round(place)] for place in places]


def _curves(recording, dimension, subject):
    figure, ax = plt.subplots()
    walks = {
        direction: example_walk(recording, direction, subject=subject) for direction in (1, 3, 4, 5)
    }
    plot_curves(walks, dimension, ax=ax)
    ax.set_title(f"subject {walks[3][SUBJECT].iloc[0]}")
    return figure


def _phase(walk, dimension, thresholds):
    return phase.measure_phase(walk[FRAME].to_numpy(), walk[dimension].to_numpy(), **thresholds)


def _phase_figure(recording, values, label):
    truth = truth_of(recording)
    separators = LinearSeparators().fit(values.to_numpy(), group_of(truth))
    figure, ax = plt.subplots(figsize=(9, 4.8))
    plot_phases(values, truth, separators=separators, label=label, ax=ax)
    return figure
