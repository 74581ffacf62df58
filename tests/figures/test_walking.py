"""The figures of chapter 3, motion, are tested by what is drawn on them."""

import numpy as np
import pytest

from mcnlab import compass
from mcnlab.figures.registry import draw
from mcnlab.figures.walking import example_walk
from mcnlab.plotting.walking import colour_of
from mcnlab.synthetic.walkers import make_walks
from mcnlab.vision import recordings
from mcnlab.walking import direction, evaluation, phase


@pytest.fixture(scope="module")
def measured(casia):
    """Phases of every walk."""
    return phase.measure_phases(casia.boxes)


@pytest.fixture(scope="module")
def space(casia):
    """The phase space of every walk."""
    return direction.measure_phase_space(casia)


def test_eight_directions_are_labelled_clockwise():
    ax = draw("3.2").axes[0]
    at = {
        int(text.get_text()[0]): text.get_position() for text in ax.texts if "\n" in text.get_text()
    }
    for number, (x, y) in at.items():
        angle = np.degrees(np.arctan2(x, y)) % 360
        assert angle == pytest.approx(45 * (number - 1))


def test_curves_hold_the_walks_heights(casia):
    ax = draw("3.4", casia).axes[0]
    for line, way in zip(ax.lines, (1, 3, 4, 5), strict=True):
        walk = example_walk(casia, way)
        np.testing.assert_array_equal(line.get_ydata(), walk["h"])
        np.testing.assert_array_equal(line.get_xdata(), walk["frame"])
        assert line.get_color() == colour_of(way)
    assert "pixels" in ax.get_ylabel()


def test_boxes_are_drawn_where_they_are(casia):
    axes = draw("3.3", casia).axes
    walk = example_walk(casia, 1)
    first = axes[0].patches[0]
    assert (*first.get_xy(), first.get_width(), first.get_height()) == tuple(
        walk.iloc[0][["x", "y", "w", "h"]]
    )


@pytest.mark.parametrize(("number", "column"), [("3.12", "m_h"), ("3.13", "m_w")])
def test_phases_and_separators_are_drawn(casia, measured, number, column):
    ax = draw(number, casia, measured).axes[0]
    truth = evaluation.truth_of(casia)
    drawn = {line.get_label(): line.get_ydata() for line in ax.lines}
    for way, name in compass.NAMES.items():
        np.testing.assert_array_equal(drawn[f"{way} {name}"], measured[column][truth == way])
    levels = sorted(line.get_ydata()[0] for line in ax.lines if line.get_linestyle() == "--")
    fitted = direction.LinearSeparators().fit(measured[column], direction.group_of(truth))
    np.testing.assert_array_equal(levels, fitted.cuts_)


def test_mean_line_lies_midway_between_the_envelopes(casia):
    ax = draw("3.10", example_walk(casia, 6)).axes[1]
    lines = {line.get_label().split(",")[0]: line.get_ydata() for line in ax.lines}
    middle = (lines["upper envelope"] + lines["lower envelope"]) / 2
    np.testing.assert_allclose(lines["phase"], middle)


def test_soft_extrema_are_on_the_wrong_side_of_the_regression(casia):
    walk = example_walk(casia, 6)
    found = phase.measure_phase(walk["frame"].to_numpy(), walk["w"].to_numpy())
    lines = {line.get_label(): line for line in draw("3.9", walk).axes[0].lines}
    np.testing.assert_array_equal(lines["soft"].get_xdata(), found.frames[found.soft])
    for at in found.soft:
        side = found.curve[at] - found.trend.at(found.frames[at])
        inner = found.curve[at] - np.median(found.curve[max(0, at - 2) : at + 3])
        assert side * inner <= 0


def test_masks_are_drawn_dark_and_boxed():
    masks = make_walks(subjects=1, directions=(6,), seed=1)[0].masks
    axes = draw("3.7", masks).axes
    box = axes[5].patches[0]
    ys, xs = np.nonzero(axes[5].images[0].get_array() == 0)
    assert box.get_x() == pytest.approx(xs.min() - 0.5)
    assert box.get_y() == pytest.approx(ys.min() - 0.5)
    assert box.get_width() == pytest.approx(np.ptp(xs) + 1, abs=2)  # closing may bridge a pixel
    assert box.get_height() == pytest.approx(np.ptp(ys) + 1, abs=2)


def test_rectified_frames_lose_their_specks():
    first, second = recordings.example_masks(3), recordings.example_masks(5)
    axes = draw("3.6", first, second).axes
    for raw, mended in zip(axes[0:5], axes[5:10], strict=True):
        import cv2

        def pieces(ax):
            ink = (np.asarray(ax.images[0].get_array()) == 0).astype(np.uint8)
            return cv2.connectedComponents(ink, connectivity=8)[0] - 1

        assert pieces(mended) <= pieces(raw)


def test_near_walker_is_the_tallest_in_direction_3(casia):
    axes = draw("3.11", casia).axes
    mean = casia.boxes.groupby("sequence")["h"].mean()
    right = mean[casia.directions.index[casia.directions == 3]]
    assert right.idxmax() in axes[0].get_title(loc="left")
    assert right.idxmin() in axes[1].get_title(loc="left")


def test_mirror_bars_count_videos(casia):
    filmed = casia.without_copies()
    ax = draw("mirror", filmed, casia).axes[0]
    heights = [bar.get_height() for bar in ax.patches]
    np.testing.assert_array_equal(heights[:8], np.bincount(evaluation.truth_of(casia))[1:])
    np.testing.assert_array_equal(
        heights[8:], np.bincount(evaluation.truth_of(filmed), minlength=9)[1:]
    )


def test_phase_space_is_a_ring_in_the_order_of_directions(casia, space):
    ax = draw("phase-space", casia, space).axes[0]
    turns = []
    for line in ax.lines:
        x, y = np.median(line.get_xdata()), np.median(line.get_ydata())
        turns.append(np.degrees(np.arctan2(x, -4 * y)) % 360)  # growth 0.2/s ~ speed 0.8/s
    errors = compass.turn_between(np.array(turns), compass.heading_of(np.arange(1, 9)))
    assert np.abs(errors).max() < 22.5


def test_slope_growth_and_threshold_figures_hold_their_data(casia, measured, space):
    figure = draw("slope", casia, measured, space)
    for ax, values in zip(figure.axes, (measured["m_h"], space["height_growth"]), strict=True):
        drawn = np.concatenate([line.get_ydata() for line in ax.lines])
        np.testing.assert_array_equal(np.sort(drawn), np.sort(values))
    drawn = np.concatenate(
        [line.get_ydata() for line in draw("growth", casia, space).axes[0].lines[:8]]
    )
    np.testing.assert_array_equal(np.sort(drawn), np.sort(space["height_growth"]))
    sweep = evaluation.sweep_thresholds(casia, prominences=[1, 8], spacings=[5])
    ax = draw("thresholds", sweep, {"height": 0.9375, "width": 0.8375}).axes[0]
    np.testing.assert_array_equal(ax.lines[1].get_ydata(), sweep["height"][:2])
    assert ax.lines[-1].get_ydata()[0] == 0.9375
