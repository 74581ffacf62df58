"""What the figures of apparent speed draw."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from mcnlab.figures.registry import draw
from mcnlab.plotting.speed import plot_by_distance, plot_by_level
from mcnlab.plotting.style import SPEED_COLOURS, SPEED_HATCHES, SPEED_MARKERS
from mcnlab.statistics import Estimate
from mcnlab.vision import recordings
from mcnlab.walking import evaluation, outdoors, speed


@pytest.fixture(scope="module")
def tables():
    """Title → all windows of a place, from the bundled tables."""
    return {title: outdoors.apparent_speeds(title) for title in ("pets", "tud")}


@pytest.fixture(scope="module")
def seconds(tables):
    """Title → the one-second windows with their levels."""
    held = {title: table[table["seconds"] == 1] for title, table in tables.items()}
    return {
        title: table.assign(level=speed.level_of(table["share"], frame_width=1))
        for title, table in held.items()
    }


def lines_of(ax):
    """Label → line."""
    return {line.get_label(): line for line in ax.lines}


def test_the_law_is_drawn_where_it_runs():
    ax = draw("apparent-law").axes[0]
    for v in (0.7, 1.4, 2.8):
        line = lines_of(ax)[f"{v:g} m/s"]
        distance, share = line.get_xdata(), line.get_ydata()
        # 60° wide: at distance Z the frame is 2·Z·tan 30° wide.
        wide = 2 * distance * np.tan(np.radians(30))
        np.testing.assert_allclose(share, 100 * v / wide)


def test_the_bands_of_the_law_meet_at_the_thresholds():
    ax = draw("apparent-law", slow=0.02, fast=0.08).axes[0]
    edges = [(band.get_y(), band.get_y() + band.get_height()) for band in ax.patches]
    np.testing.assert_allclose([edges[0][1], edges[1][0]], 2)
    np.testing.assert_allclose([edges[1][1], edges[2][0]], 8)


def test_every_window_stands_at_its_level_and_speed(seconds):
    medians = {title: dict.fromkeys(speed.LEVELS) for title in seconds}
    drawn = draw("apparent-bins", seconds, medians)
    for ax, (title, table) in zip(drawn.axes, seconds.items(), strict=True):
        assert ax.get_title(loc="left") == title
        dots = [line for line in ax.lines if line.get_linestyle() == "None"]
        for level, line in zip(speed.LEVELS, dots, strict=True):
            own = table["true_speed"][table["level"] == level]
            np.testing.assert_array_equal(line.get_ydata(), np.sort(own))
            assert np.abs(line.get_xdata() - level).max() < 0.5
            assert line.get_marker() == SPEED_MARKERS[level]
            assert line.get_color() == SPEED_COLOURS[level]
        labels = [text.get_text() for text in ax.get_xticklabels()]
        assert labels[0] == f"v1\n{(table['level'] == 1).sum()} windows"


def test_medians_are_drawn_with_their_intervals():
    medians = {1: Estimate(0.4, 0.2, 0.7, 3), 2: None, 3: Estimate(2.0, None, None, 1)}
    ax = plot_by_level([0.3, 0.5, 2.0], [1, 1, 3], medians=medians)
    bars = [line.get_ydata() for line in ax.lines if line.get_linestyle() == "-"]
    assert [0.4, 0.4] in [list(bar) for bar in bars]
    assert [2.0, 2.0] in [list(bar) for bar in bars]
    (held,) = ax.containers
    ends = held.lines[2][0].get_segments()[0][:, 1]
    np.testing.assert_allclose(ends, [0.2, 0.7])


def test_an_empty_level_leaves_its_place_empty():
    ax = plot_by_level([1.0, 1.2], [2, 2])
    assert [text.get_text() for text in ax.get_xticklabels()] == [
        "v1\n0 windows",
        "v2\n2 windows",
        "v3\n0 windows",
    ]
    empty = plot_by_level([], [])
    assert not empty.lines


def test_the_ratio_to_true_speed_is_drawn_against_distance(seconds):
    drawn = draw("apparent-distance", seconds)
    table = seconds["pets"][seconds["pets"]["true_sideways"] >= speed.PASSING]
    for ax, name in zip(drawn.axes[:2], ("sideways", "body_heights_sideways"), strict=True):
        for level, label in speed.NAMES.items():
            own = table[(table["level"] == level) & (table[name] > 0)]
            line = lines_of(ax)[label]
            np.testing.assert_array_equal(line.get_xdata(), own["distance"])
            np.testing.assert_array_equal(line.get_ydata(), own[name] / own["true_sideways"])
        assert "metre" in ax.get_ylabel()
        assert ax.get_xlabel() == "distance (m)"


def test_the_title_says_the_slope_that_is_reported(seconds):
    drawn = draw("apparent-distance", seconds)
    rows = [
        (table, name)
        for table in seconds.values()
        for name in ("sideways", "body_heights_sideways")
    ]
    for ax, (table, name) in zip(drawn.axes, rows, strict=True):
        found = speed.distance_slope(
            table[name],
            table["true_sideways"],
            table["distance"],
            table["sequence"],
            least=speed.PASSING,
            draws=1,
        )
        said = ax.get_title(loc="left").split("slope ")[1].replace("−", "-")
        assert float(said) == pytest.approx(found.value, abs=0.0051)


def test_windows_at_one_distance_have_no_line():
    ax = plot_by_distance([10, 10], [1, 2], [2, 3], ylabel="p", fit=True)
    assert len(ax.lines) == len(speed.LEVELS)
    assert "slope" not in ax.get_title(loc="left")


def test_a_place_where_nobody_passes_is_said_so(seconds):
    still = seconds["tud"].assign(true_sideways=0.0)
    drawn = draw("apparent-distance", {"nobody": still})
    assert [ax.texts[0].get_text() for ax in drawn.axes] == ["no such window"] * 2
    drawn.canvas.draw()


def test_thresholds_are_drawn_where_they_are():
    ax = plot_by_distance([10, 20], [1, 2], [2, 3], ylabel="p", cuts=(1, 5))
    dashed = [line.get_ydata()[0] for line in ax.lines if line.get_linestyle() == "--"]
    assert dashed == [1, 5]


def test_bars_are_shares_of_a_direction():
    ax = draw("casia-levels", np.array([3, 3, 3, 3, 5]), np.array([3, 3, 3, 2, 1])).axes[0]
    heights = np.array([bar.get_height() for bar in ax.patches]).reshape(3, 8)
    assert heights[:, 2].tolist() == [0, 0.25, 0.75]
    assert heights[:, 4].tolist() == [1, 0, 0]
    assert heights[:, [0, 1, 3, 5, 6, 7]].sum() == 0
    floors = np.array([bar.get_y() for bar in ax.patches]).reshape(3, 8)
    np.testing.assert_allclose(floors[1:], np.cumsum(heights, axis=0)[:-1])


def test_casia_walks_fill_their_bars():
    casia = recordings.casia_a()
    walked = speed.bin_speeds(casia)
    true = evaluation.truth_of(casia, walked["sequence"])
    ax = draw("casia-levels", true, walked["level"]).axes[0]
    heights = np.array([bar.get_height() for bar in ax.patches]).reshape(3, 8)
    np.testing.assert_allclose(heights.sum(axis=0), 1)


def test_levels_are_told_apart_in_grey_by_marker_and_by_hatch():
    weights = np.array([0.2126, 0.7152, 0.0722])
    grey = [float(weights @ to_rgb(SPEED_COLOURS[level])) for level in speed.LEVELS]
    # A twentieth of the range is about the least step that a print shows; darker is faster.
    assert (np.diff(grey) < -0.05).all()
    assert len(set(SPEED_MARKERS.values())) == 3
    assert len(set(SPEED_HATCHES.values())) == 3
