"""Figures are tested by what is drawn on them, not by how they look."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import pytest

from mcnlab import bundled, direction, evaluation, figures, perspective, phase, plotting
from mcnlab.datasets.walkers import make_walks
from mcnlab.errors import ArgumentError

THESIS = [f"3.{number}" for number in range(2, 14)]


@pytest.fixture(scope="module")
def casia():
    """CASIA A, mirrored, from the bundled table."""
    return bundled.casia_a()


@pytest.fixture(scope="module")
def measured(casia):
    """Phases of every walk."""
    return phase.measure_phases(casia.boxes)


@pytest.fixture(scope="module")
def space(casia):
    """The phase space of every walk."""
    return direction.measure_phase_space(casia)


@pytest.fixture(autouse=True)
def closed():
    """No figure outlives its test."""
    yield
    plt.close("all")


def test_every_thesis_figure_of_the_section_is_registered():
    assert [number for number, entry in figures.FIGURES.items() if entry.section] == THESIS


def test_every_figure_says_what_it_asks_and_what_is_seen():
    for entry in figures.FIGURES.values():
        assert entry.claim, entry.number
        assert entry.finding or entry.ids, entry.number
        assert entry.notebook in figures.NOTEBOOKS, entry.number


def test_unknown_figure_is_named():
    with pytest.raises(ArgumentError, match=r"9\.9"):
        figures.draw("9.9")


def test_eight_directions_are_labelled_clockwise():
    ax = figures.draw("3.2").axes[0]
    at = {
        int(text.get_text()[0]): text.get_position() for text in ax.texts if "\n" in text.get_text()
    }
    for number, (x, y) in at.items():
        angle = np.degrees(np.arctan2(x, y)) % 360
        assert angle == pytest.approx(45 * (number - 1))


def test_curves_hold_the_walks_heights(casia):
    ax = figures.draw("3.4", casia).axes[0]
    for line, way in zip(ax.lines, (1, 3, 4, 5), strict=True):
        walk = figures.example_walk(casia, way)
        np.testing.assert_array_equal(line.get_ydata(), walk["h"])
        np.testing.assert_array_equal(line.get_xdata(), walk["frame"])
        assert line.get_color() == plotting.colour_of(way)
    assert "pixels" in ax.get_ylabel()


def test_boxes_are_drawn_where_they_are(casia):
    axes = figures.draw("3.3", casia).axes
    walk = figures.example_walk(casia, 1)
    first = axes[0].patches[0]
    assert (*first.get_xy(), first.get_width(), first.get_height()) == tuple(
        walk.iloc[0][["x", "y", "w", "h"]]
    )


@pytest.mark.parametrize(("number", "column"), [("3.12", "m_h"), ("3.13", "m_w")])
def test_phases_and_separators_are_drawn(casia, measured, number, column):
    ax = figures.draw(number, casia, measured).axes[0]
    truth = evaluation.truth_of(casia)
    drawn = {line.get_label(): line.get_ydata() for line in ax.lines}
    for way, name in direction.NAMES.items():
        np.testing.assert_array_equal(drawn[f"{way} {name}"], measured[column][truth == way])
    levels = sorted(line.get_ydata()[0] for line in ax.lines if line.get_linestyle() == "--")
    fitted = direction.LinearSeparators().fit(measured[column], direction.group_of(truth))
    np.testing.assert_array_equal(levels, fitted.cuts_)


def test_mean_line_lies_midway_between_the_envelopes(casia):
    ax = figures.draw("3.10", figures.example_walk(casia, 6)).axes[1]
    lines = {line.get_label().split(",")[0]: line.get_ydata() for line in ax.lines}
    middle = (lines["upper envelope"] + lines["lower envelope"]) / 2
    np.testing.assert_allclose(lines["phase"], middle)


def test_soft_extrema_are_on_the_wrong_side_of_the_regression(casia):
    walk = figures.example_walk(casia, 6)
    found = phase.measure_phase(walk["frame"].to_numpy(), walk["w"].to_numpy())
    lines = {line.get_label(): line for line in figures.draw("3.9", walk).axes[0].lines}
    np.testing.assert_array_equal(lines["soft"].get_xdata(), found.frames[found.soft])
    for at in found.soft:
        side = found.curve[at] - found.trend.at(found.frames[at])
        inner = found.curve[at] - np.median(found.curve[max(0, at - 2) : at + 3])
        assert side * inner <= 0


def test_masks_are_drawn_dark_and_boxed():
    masks = make_walks(subjects=1, directions=(6,), seed=1)[0].masks
    axes = figures.draw("3.7", masks).axes
    box = axes[5].patches[0]
    ys, xs = np.nonzero(axes[5].images[0].get_array() == 0)
    assert box.get_x() == pytest.approx(xs.min() - 0.5)
    assert box.get_y() == pytest.approx(ys.min() - 0.5)
    assert box.get_width() == pytest.approx(np.ptp(xs) + 1, abs=2)  # closing may bridge a pixel
    assert box.get_height() == pytest.approx(np.ptp(ys) + 1, abs=2)


def test_rectified_frames_lose_their_specks():
    first, second = bundled.example_masks(3), bundled.example_masks(5)
    axes = figures.draw("3.6", first, second).axes
    for raw, mended in zip(axes[0:5], axes[5:10], strict=True):
        import cv2

        def pieces(ax):
            ink = (np.asarray(ax.images[0].get_array()) == 0).astype(np.uint8)
            return cv2.connectedComponents(ink, connectivity=8)[0] - 1

        assert pieces(mended) <= pieces(raw)


def test_near_walker_is_the_tallest_in_direction_3(casia):
    axes = figures.draw("3.11", casia).axes
    mean = casia.boxes.groupby("sequence")["h"].mean()
    right = mean[casia.directions.index[casia.directions == 3]]
    assert right.idxmax() in axes[0].get_title(loc="left")
    assert right.idxmin() in axes[1].get_title(loc="left")


def test_mirror_bars_count_videos(casia):
    filmed = casia.without_copies()
    ax = figures.draw("mirror", filmed, casia).axes[0]
    heights = [bar.get_height() for bar in ax.patches]
    np.testing.assert_array_equal(heights[:8], np.bincount(evaluation.truth_of(casia))[1:])
    np.testing.assert_array_equal(
        heights[8:], np.bincount(evaluation.truth_of(filmed), minlength=9)[1:]
    )


def test_phase_space_is_a_ring_in_the_order_of_directions(casia, space):
    ax = figures.draw("phase-space", casia, space).axes[0]
    turns = []
    for line in ax.lines:
        x, y = np.median(line.get_xdata()), np.median(line.get_ydata())
        turns.append(np.degrees(np.arctan2(x, -4 * y)) % 360)  # growth 0.2/s ~ speed 0.8/s
    errors = direction.turn_between(np.array(turns), direction.heading_of(np.arange(1, 9)))
    assert np.abs(errors).max() < 22.5


def test_heading_errors_are_drawn_at_their_direction(casia):
    headings = perspective.measure_headings(casia, focal_length=450)
    _, _, errors = evaluation.judge_headings(casia, headings)
    ax = figures.draw("heading", casia, {"whole walks": (headings, errors)}).axes[0]
    truth = evaluation.truth_of(casia, headings["sequence"])
    dots = [line for line in ax.lines if line.get_linestyle() == "None"]
    for way, line in zip(range(1, 9), dots, strict=True):
        np.testing.assert_array_equal(line.get_ydata(), np.sort(errors[truth == way]))
        assert np.abs(np.asarray(line.get_xdata()) - way).max() < 0.5


def test_slope_growth_and_threshold_figures_hold_their_data(casia, measured, space):
    figure = figures.draw("slope", casia, measured, space)
    for ax, values in zip(figure.axes, (measured["m_h"], space["height_growth"]), strict=True):
        drawn = np.concatenate([line.get_ydata() for line in ax.lines])
        np.testing.assert_array_equal(np.sort(drawn), np.sort(values))
    drawn = np.concatenate(
        [line.get_ydata() for line in figures.draw("growth", casia, space).axes[0].lines[:8]]
    )
    np.testing.assert_array_equal(np.sort(drawn), np.sort(space["height_growth"]))
    sweep = evaluation.sweep_thresholds(casia, prominences=[1, 8], spacings=[5])
    ax = figures.draw("thresholds", sweep, {"height": 0.9375, "width": 0.8375}).axes[0]
    np.testing.assert_array_equal(ax.lines[1].get_ydata(), sweep["height"][:2])
    assert ax.lines[-1].get_ydata()[0] == 0.9375


def test_a_reproduction_keeps_the_picture_and_repeats_it(tmp_path, monkeypatch):
    monkeypatch.setenv("MCNLAB_OUT", str(tmp_path))
    monkeypatch.setattr(plt, "show", lambda: None)
    figures.show("geometry")
    first = (tmp_path / "figures" / "figure-geometry.png").read_bytes()
    figures.show("geometry")
    assert (tmp_path / "figures" / "figure-geometry.png").read_bytes() == first
    assert [path.name for path in (tmp_path / "figures").iterdir()] == ["figure-geometry.png"]


def test_groups_are_told_apart_in_grey():
    from matplotlib.colors import to_rgb

    weights = np.array([0.2126, 0.7152, 0.0722])
    grey = sorted(float(weights @ to_rgb(colour)) for colour in plotting.GROUP_COLOURS.values())
    # A twentieth of the range is about the least step that a print shows; markers help.
    assert np.diff(grey).min() > 0.05
