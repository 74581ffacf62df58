"""The figures beyond section 3.2.1: heading in degrees, from perspective."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from mcnlab.figures.registry import READ, figure
from mcnlab.plotting.style import INK, PALE, UPPER
from mcnlab.plotting.walking import (
    colour_of,
    plot_against_truth,
    plot_heading_errors,
    plot_horizon,
    plot_lines,
)
from mcnlab.tables import SEQUENCE
from mcnlab.walking.evaluation import truth_of


@figure("geometry", notebook=READ)
def geometry() -> Figure:
    """The body as a ruler.

    A pinhole camera from the side: two places of one walker.

    Claim
    -----
    A body of height H, s pixels tall, stands f/s body heights away.

    Finding
    -------
    Similar triangles: s/f = H/Z. No calibration is needed but the focal length.
    """
    figure, ax = plt.subplots(figsize=(9, 3.6))
    focal, eye, stature = 1.2, 1.0, 1.7
    ax.plot([-0.2, 10], [0, 0], color=INK, lw=1)
    ax.plot([0, 10], [eye, eye], color=UPPER, ls="--", lw=1)
    ax.text(9.9, eye + 0.06, "horizon", ha="right", color=UPPER)
    ax.plot([focal, focal], [0.05, 2.0], color=PALE, lw=4)
    ax.text(focal, 2.06, "image, f before the pinhole", ha="center")
    for place, direction in ((4.0, 5), (8.0, 1)):
        colour = colour_of(direction)
        ax.plot([place, place], [0, stature], color=colour, lw=5, solid_capstyle="round")
        rows = [eye + focal * (level - eye) / place for level in (0, stature)]
        for level in (0, stature):
            ax.plot([0, place], [eye, level], color=colour, lw=0.8)
        ax.plot([focal, focal], rows, color=colour, lw=6, solid_capstyle="butt")
        ax.text(place, stature + 0.08, f"H at Z = {place:.0f} m", ha="center")
        ax.annotate(
            f"s = f·H/{place:.0f}",
            xy=(focal, rows[0]),
            xytext=(focal + 0.35, 0.12 if direction == 5 else 0.36),
            color=colour,
            va="center",
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.5},
            arrowprops={"arrowstyle": "-", "color": colour, "lw": 0.6},
        )
    ax.plot(0, eye, "o", color=INK)
    ax.text(-0.08, eye, "pinhole", ha="right", va="center")
    ax.set(xlim=(-0.9, 10.2), ylim=(-0.1, 2.3))
    ax.axis("off")
    return figure


@figure("horizon", notebook=READ)
def horizons(level_boxes, level_camera, high_boxes, high_camera) -> Figure:
    """The horizon from the walkers.

    Box height against foot row for a level and a high camera.

    Claim
    -----
    Box height is linear in the row of the feet; where it would be zero is the horizon.

    Finding
    -------
    Left a subject of CASIA A; right synthetic people under a camera 7 m up.
    """
    figure, axes = plt.subplots(1, 2, figsize=(11, 4))
    for ax, boxes, camera, name in (
        (axes[0], level_boxes, level_camera, "CASIA A"),
        (axes[1], high_boxes, high_camera, "synthetic, high camera"),
    ):
        plot_horizon(boxes, camera, ax=ax)
        seen = f"tilt {np.degrees(camera.tilt):.1f}°, {camera.feet:.2f} body heights up"
        ax.set_title(f"{name}: {'no horizon' if camera.horizon is None else seen}")
    return figure


@figure(
    "heading",
    notebook=READ,
    ids=(
        "direction.perspective.direction8",
        "direction.perspective.direction8.1s",
        "direction.perspective.direction8.0.5s",
        "direction.perspective.mae_deg",
    ),
)
def heading_errors(recording, errors_by_window) -> Figure:
    """Heading errors.

    Signed heading errors by true direction, for each window length.

    Question
    --------
    Without training, is every direction right?

    Parameters
    ----------
    recording : Recording
    errors_by_window : dict
        Title → (headings table, signed errors).
    """
    figure, axes = plt.subplots(
        len(errors_by_window), 1, figsize=(9, 2.9 * len(errors_by_window)), squeeze=False
    )
    for ax, (title, (headings, errors)) in zip(axes[:, 0], errors_by_window.items(), strict=True):
        truth = truth_of(recording, headings[SEQUENCE].to_numpy())
        plot_heading_errors(errors, truth, ax=ax)
        ax.set_title(title)
    for ax in axes[:-1, 0]:
        ax.set_xlabel("")
    return figure


@figure("focal-length", notebook=READ, ids=("direction.perspective.focal_length_from_pace",))
def focal_lengths(lengths, right, error, from_pace) -> Figure:
    """How much the focal length matters.

    Accuracy and mean error against the focal length assumed.

    Claim
    -----
    The focal length is the only thing that must be known.
    """
    figure, axes = plt.subplots(1, 2, figsize=(11, 4))
    plot_lines(lengths, {"perspective": right}, xlabel="focal length assumed (pixels)", ax=axes[0])
    plot_lines(
        lengths,
        {"perspective": error},
        xlabel="focal length assumed (pixels)",
        ylabel="mean heading error (degrees)",
        ax=axes[1],
    )
    for ax in axes:
        ax.axvline(from_pace, color=UPPER, ls="--", label="from the walkers' pace")
        ax.legend()
    axes[0].set_ylim(None, 1.01)
    axes[1].set_ylim(0, None)
    return figure


@figure(
    "windows",
    notebook=READ,
    ids=("direction.perspective.direction8.1s", "direction.perspective.direction8.0.5s"),
)
def window_lengths(seconds, estimates) -> Figure:
    """How long one must look.

    Accuracy against window length.

    Question
    --------
    How fast does accuracy fall when only part of the walk is seen?
    """
    figure, ax = plt.subplots()
    plot_lines(
        seconds, {"perspective": estimates}, xlabel="window (s)", ylabel="directions right", ax=ax
    )
    ax.set_ylim(None, 1.01)
    return figure


@figure("calibration", notebook=READ, ids=("direction.perspective.synthetic.coverage95",))
def calibrated(levels, estimates) -> Figure:
    """Are the intervals honest?

    Share of true headings inside the interval against its nominal level.

    Claim
    -----
    A 95 % interval should hold the true heading 95 % of the time.
    """
    figure, ax = plt.subplots(figsize=(5.5, 5))
    ax.plot([0, 1], [0, 1], color=INK, lw=0.8, ls=":", label="honest")
    plot_lines(
        levels,
        {"perspective": estimates},
        xlabel="nominal level of the interval",
        ylabel="share of true headings inside",
        ax=ax,
    )
    ax.set(xlim=(0, 1), ylim=(0, 1), aspect="equal")
    return figure


@figure("noise", notebook=READ, ids=("direction.perspective.synthetic.noise1",))
def under_noise(levels, estimates) -> Figure:
    """Accuracy under segmentation noise.

    Accuracy against noise level, three methods, synthetic walkers.

    Claim
    -----
    At level 1, 5 % of the frames are missing, 20 specks lie in each and a limb is cut.
    """
    figure, ax = plt.subplots()
    plot_lines(levels, estimates, xlabel="noise level", ax=ax)
    ax.set_ylim(None, 1.01)
    return figure


@figure(
    "pets",
    notebook=READ,
    ids=(
        "direction.perspective.pets.direction8",
        "direction.perspective.pets.within45",
        "direction.perspective.pets.mae_deg",
    ),
)
def pets(headings) -> Figure:
    """Outdoors, from above: PETS 2009.

    Heading from boxes against the true one, one-second windows.

    Claim
    -----
    The same code, unchanged, against world truth.
    """
    figure, ax = plt.subplots(figsize=(5.5, 5.5))
    plot_against_truth(headings["true_sight"], headings["sight"], ax=ax)
    return figure
