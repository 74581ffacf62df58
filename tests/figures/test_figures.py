"""Figures are tested by what is drawn on them, not by how they look."""

import matplotlib

matplotlib.use("Agg")

import re

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex

from mcnlab import compass, figures
from mcnlab.cameras.floor import GridMap
from mcnlab.cameras.visibility import CameraModel
from mcnlab.control import pan_tilt
from mcnlab.datasets.scene import Scene
from mcnlab.errors import ArgumentError
from mcnlab.figures.placement import draw_cells
from mcnlab.figures.registry import FIGURES, NOTEBOOKS, draw
from mcnlab.figures.walking import example_walk
from mcnlab.placement import cells
from mcnlab.placement.site import choose_cameras, judge_cameras, prepare_site
from mcnlab.placement.votes import place_by_votes
from mcnlab.plotting import vision
from mcnlab.plotting.gait import plot_rhythm
from mcnlab.plotting.placement import plot_cameras, plot_histogram, plot_mesh
from mcnlab.plotting.style import GROUP_COLOURS, LOWER, UPPER
from mcnlab.plotting.walking import colour_of
from mcnlab.statistics import Estimate
from mcnlab.synthetic.corridor import make_corridor
from mcnlab.synthetic.shifts import make_motion
from mcnlab.synthetic.walkers import make_walks
from mcnlab.vision import flow, recordings
from mcnlab.vision.silhouettes import measure_sequence
from mcnlab.walking import direction, evaluation, gait, heading, phase, viewpoint

THESIS = [
    *(f"2.{number}" for number in range(1, 12)),
    *(f"3.{number}" for number in range(2, 14)),
    *(f"table-3.{number}" for number in range(1, 4)),
    *("3.14", "3.15"),
]


@pytest.fixture(scope="module")
def casia():
    """CASIA A, mirrored, from the bundled table."""
    return recordings.casia_a()


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
    registered = [number for number, entry in FIGURES.items() if entry.section]
    assert sorted(registered) == sorted(THESIS)


def test_every_figure_says_what_it_asks_and_what_is_seen():
    for entry in FIGURES.values():
        assert entry.claim, entry.number
        assert entry.finding or entry.ids, entry.number
        assert entry.notebook in NOTEBOOKS, entry.number


def test_unknown_figure_is_named():
    with pytest.raises(ArgumentError, match=r"9\.9"):
        draw("9.9")


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


def test_heading_errors_are_drawn_at_their_direction(casia):
    headings = heading.measure_headings(casia, focal_length=450)
    _, _, errors = evaluation.judge_headings(casia, headings)
    ax = draw("heading", casia, {"whole walks": (headings, errors)}).axes[0]
    truth = evaluation.truth_of(casia, headings["sequence"])
    dots = [line for line in ax.lines if line.get_linestyle() == "None"]
    for way, line in zip(range(1, 9), dots, strict=True):
        np.testing.assert_array_equal(line.get_ydata(), np.sort(errors[truth == way]))
        assert np.abs(np.asarray(line.get_xdata()) - way).max() < 0.5


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
    grey = sorted(float(weights @ to_rgb(colour)) for colour in GROUP_COLOURS.values())
    # A twentieth of the range is about the least step that a print shows; markers help.
    assert np.diff(grey).min() > 0.05


# Chapter 2: from gait to camera places

CHAOS_RATIO = 0.3  # low, for a few walkers to make some chaos


@pytest.fixture(scope="module")
def corridor():
    """A few people in the made corridor: (scene, grid, placed)."""
    scene = make_corridor(walkers=40, seed=1)
    grid = GridMap.over(scene.area, cell=0.5)
    placed = place_by_votes(scene.traces, grid, n=2, chaos_ratio=CHAOS_RATIO)
    return scene, grid, placed


@pytest.fixture(scope="module")
def hall():
    """Four people who walk along the lower row of a place without walls."""
    along = 0.1 + np.arange(60) / 10
    walks = [
        pd.DataFrame(
            {"trace": f"w{number}", "frame": np.arange(60), "x": along, "y": 0.3 + 0.1 * number}
        )
        for number in range(4)
    ]
    scene = Scene("hall", pd.concat(walks, ignore_index=True), 10, (0.0, 0.0, 6.0, 3.0))
    grid = GridMap.over(scene.area, cell=1.0)
    return scene, grid, place_by_votes(scene.traces, grid, n=1)


@pytest.fixture(scope="module")
def angled():
    """Synthetic walks of two people from three view angles: (boxes, truth)."""
    tables, truth = viewpoint.record_at_angles([0, 45, 90], subjects=2)
    return tables[0], truth


def labelled(ax):
    """The lines of axes by their labels."""
    return {line.get_label(): line for line in ax.lines}


def segments(ax):
    """Of every collection of lines on axes: its number of segments."""
    return [len(c.get_segments()) for c in ax.collections if isinstance(c, LineCollection)]


def bars(ax):
    """The heights of the bars on axes."""
    return [bar.get_height() for bar in ax.patches]


def test_a_gait_cycle_runs_from_heel_strike_to_heel_strike_of_one_foot():
    masks = recordings.example_masks(3)
    axes = draw("2.1", masks, frame_rate=25, count=9).axes
    boxes = measure_sequence(masks).set_index("frame")
    events = gait.find_events(boxes.index, boxes["w"], frame_rate=25)
    times = [float(ax.get_title(loc="left").split()[0]) for ax in axes]
    assert times[0] == 0
    strides = np.subtract(events.heel_strikes[2:], events.heel_strikes[:-2]) / 25
    assert np.abs(strides - times[-1]).min() < 0.005  # the title's two decimals
    names = [ax.get_xlabel() for ax in axes]
    assert [name for name in names if name] == ["heel strike", "mid-swing"] * 2 + ["heel strike"]
    for ax in axes:
        mask, box = 255 - np.asarray(ax.images[0].get_array()), ax.patches[0]
        frame = next(at for at, one in enumerate(masks) if np.array_equal(one, mask)) + 1
        row = boxes.loc[frame]
        assert (box.get_width(), box.get_height()) == (row["w"], row["h"])
        assert (box.get_x() + 0.5, box.get_y() + 0.5) == (row["x"], row["y"])


def test_a_gait_cycle_shows_the_masks_it_measured_though_the_first_are_empty():
    masks = make_walks(subjects=1, directions=(3,), seed=0)[0].masks
    late = np.concatenate([np.zeros_like(masks[:7]), masks])
    for ax, other in zip(
        draw("2.1", masks, frame_rate=25).axes,
        draw("2.1", late, frame_rate=25).axes,
        strict=True,
    ):
        np.testing.assert_array_equal(ax.images[0].get_array(), other.images[0].get_array())


@pytest.mark.parametrize("subjects", ["all", "one"])
def test_widths_are_those_of_the_walks_and_marked_square_on(casia, angled, subjects):
    boxes, truth = angled
    if subjects == "one":
        name = casia.subjects.iloc[0]
        own = casia.subjects.index[casia.subjects == name]
        casia = casia.with_boxes(
            casia.boxes[casia.boxes["sequence"].isin(own)].reset_index(drop=True),
            directions=casia.directions[own],
            copies=casia.copies & set(own),
        )
        boxes = boxes[boxes["subject"] == "s01"]
        truth = truth[truth["subject"] == "s01"]
    axes = np.reshape(draw("2.2", casia, boxes, truth).axes, (2, 3))
    for column, angle in enumerate((0, 45, 90)):
        # The first that comes towards the camera, or crosses.
        at = truth[(truth["angle"] == angle) & truth["heading"].between(90, 270)]
        made = boxes[boxes["sequence"] == at.index[0]]
        np.testing.assert_array_equal(axes[1, column].lines[0].get_ydata(), made["w"])
        real = axes[0, column].lines[0].get_ydata()
        drawn = [
            name
            for name, walk in casia.boxes.groupby("sequence")
            if len(walk) == len(real) and (walk["w"].to_numpy() == real).all()
        ]
        assert viewpoint.view_angle_of(casia.directions[drawn[0]]) == angle
        assert len(axes[0, column].lines) == (3 if angle == 90 else 1)
    found = gait.find_events(made["frame"], made["w"], frame_rate=25)
    marks, first = labelled(axes[1, 2]), made["frame"].iloc[0]
    strikes = (found.heel_strikes - first) / 25
    np.testing.assert_allclose(marks["heel strike"].get_xdata(), strikes)
    swings = made.set_index("frame").loc[found.mid_swings, "w"]
    np.testing.assert_allclose(marks["mid-swing"].get_ydata(), swings)


def test_the_rhythm_is_drawn_with_its_period(casia):
    axes = draw("rhythm", casia).axes
    for ax, way in zip(axes, (5, 4, 3), strict=True):
        walk = example_walk(casia, way)
        lags, correlation, period = gait.rhythm_of(walk, frame_rate=casia.frame_rate)
        np.testing.assert_array_equal(ax.lines[1].get_xdata(), lags)
        np.testing.assert_array_equal(ax.lines[1].get_ydata(), correlation)
        assert (ax.lines[2].get_xdata()[0], ax.lines[2].get_ydata()[0]) == period[:2]
        assert (ax.lines[2].get_label() == "no rhythm found") == (not period.detectable)


def test_a_curve_without_a_peak_is_drawn_without_one():
    ax = plot_rhythm([0, 0.1], [1.0, 0.5], period=gait.Period(0.0, 0.0, 0.0, 1.0, False))
    assert len(ax.lines) == 2


def test_view_angles_are_drawn_with_intervals():
    table = pd.DataFrame(
        {
            "angle": [0.0, 45.0, 90.0],
            "peak": [0.1, 0.5, 0.9],
            "peak_low": [0.0, 0.4, 0.8],
            "peak_high": [0.2, 0.6, 0.95],
            "share": [0.0, 0.5, 1.0],
            "low": [0.0, 0.3, 0.9],
            "high": [0.1, 0.7, 1.0],
        }
    )
    tables = [
        table,
        table.assign(share=table["share"] / 2),
        table.assign(share=table["share"] / 3),
        table.assign(peak=table["peak"] / 2),
    ]
    left, right = draw("view-angle", *tables).axes
    for ax, value, low in ((left, "peak", "peak_low"), (right, "share", "low")):
        assert segments(ax) == [3, 3, 3, 3]
        for one, line, rise in zip(tables, ax.lines, ax.collections, strict=True):
            np.testing.assert_array_equal(line.get_xdata(), one["angle"])
            np.testing.assert_array_equal(line.get_ydata(), one[value])
            np.testing.assert_array_equal([s[0][1] for s in rise.get_segments()], one[low])


def test_loci_are_one_line_a_walker_over_the_grid(corridor):
    scene, grid, _ = corridor
    ax = draw("2.3", scene, grid).axes[0]
    assert segments(ax) == [len(scene.walls), grid.columns + 1, grid.rows + 1, 40]
    drawn = np.concatenate(ax.collections[-1].get_segments())
    np.testing.assert_array_equal(drawn, scene.traces[["x", "y"]])
    assert ax.get_title(loc="left").startswith("40 walkers, cells of 0.5 m")
    assert (*ax.get_xlim(), *ax.get_ylim()) == (0, 11.5, 0, 5)


def test_patterns_are_drawn_with_the_angle_inferred():
    axes = draw("2.4").axes
    examples = cells.example_patterns()
    for ax, (name, pattern) in zip(axes, examples.items(), strict=False):
        dark = ax.collections[0].get_array().reshape(8, 8) < 1
        np.testing.assert_array_equal(dark, pattern)
        if name.endswith("π/8"):
            angle = np.degrees(cells.infer_angle(pattern).angle)
            assert ax.get_title() == f"{angle:.0f}°"
            assert abs(angle - 22.5 * int(name[0])) < 22.5 / 2
            (x0, x1), (y0, y1) = ax.lines[0].get_data()
            assert np.degrees(np.arctan2(y1 - y0, x1 - x0)) == pytest.approx(angle)
            # Through the middle of the stroke, at most half a pixel off that of the cell.
            assert np.hypot((x0 + x1) / 2 - 4, (y0 + y1) / 2 - 4) <= np.hypot(0.5, 0.5)
        else:
            assert ax.get_title() == "no angle"
            assert not ax.lines
    assert len(examples) == 11
    assert not axes[11].axison


def test_three_kinds_of_cells_are_drawn_with_their_histograms(corridor):
    scene, grid, placed = corridor
    figure = draw("2.5", scene, grid, placed, chaos_ratio=CHAOS_RATIO)
    axes = np.reshape(figure.axes, (2, 3))
    walks = placed.cells.histograms.sum(axis=2)
    kinds = (cells.DIRECTED, cells.CHAOS, cells.NO_LOCUS)
    for (above, below), kind in zip(axes.T, kinds, strict=True):
        left, bottom = above.get_xlim()[0], above.get_ylim()[0]
        row, column = round(bottom / 0.5), round(left / 0.5)
        assert placed.cells.kind[row, column] == kind
        assert walks[row, column] == walks[placed.cells.kind == kind].max()
        np.testing.assert_array_equal(bars(below), placed.cells.histograms[row, column])
        top = walks[row, column] > 0
        levels = [line.get_ydata()[0] for line in below.lines]
        assert levels == ([CHAOS_RATIO * max(bars(below))] if top else [])


def test_a_kind_of_cell_that_is_not_there_is_said_to_be_missing(hall):
    axes = np.reshape(draw("2.5", *hall, chaos_ratio=0.8).axes, (2, 3))
    for ax in axes[:, 1]:
        assert [text.get_text() for text in ax.texts] == ["no such cell here"]
        assert not ax.axison
    assert bars(axes[1, 0]) == [4, 0, 0, 0, 0, 0, 0, 0]


def test_a_histogram_shows_the_chaos_rule():
    counts = [3, 5, 10, 2, 8, 0, 1, 0]
    ax = plot_histogram(counts, chaos_ratio=0.6, title="a cell")
    assert bars(ax) == counts
    assert [bar.get_x() + bar.get_width() / 2 for bar in ax.patches] == pytest.approx(
        [22.5 * number for number in range(8)]
    )
    assert list(ax.lines[0].get_ydata()) == [6, 6]
    colours = [to_hex(bar.get_facecolor()) for bar in ax.patches]
    assert colours[2] == UPPER
    assert {number for number, colour in enumerate(colours) if colour == LOWER} == {1, 3}
    assert ax.get_title(loc="left") == "a cell"
    around = plot_histogram([9, 1, 0, 0, 0, 0, 0, 2])
    colours = [to_hex(bar.get_facecolor()) for bar in around.patches]
    assert {number for number, colour in enumerate(colours) if colour == LOWER} == {1, 7}
    assert not plot_histogram(np.zeros(8, int)).lines


@pytest.mark.parametrize("place", ["corridor", "hall"])
def test_the_band_its_votes_and_the_places_are_drawn(request, place):
    scene, grid, placed = request.getfixturevalue(place)
    axes = draw("2.6", scene, grid, placed).axes
    order = cells.grow_band(placed.cells)
    shown = axes[0].images[0].get_array()
    np.testing.assert_array_equal(shown.mask, order < 0)
    np.testing.assert_array_equal(shown.compressed(), order[order >= 0])
    x, y = grid.place_of(*np.nonzero(cells.thin(order >= 0)))
    np.testing.assert_array_equal(labelled(axes[0])["thinned"].get_xydata(), np.c_[x, y])
    np.testing.assert_array_equal(axes[1].images[0].get_array(), placed.votes)
    assert axes[1].images[0].get_extent() == [0, grid.area[2], 0, grid.area[3]]
    np.testing.assert_array_equal(axes[2].lines[0].get_xydata(), placed.places[["x", "y"]])
    walls = [len(scene.walls)] if len(scene.walls) else []
    assert segments(axes[2]) == [*walls, np.count_nonzero(placed.cells.directed)]


def test_directions_are_drawn_in_their_cells(corridor):
    _, grid, placed = corridor
    ax = draw_cells(grid, placed.cells, ax=plt.subplots()[1])
    rows, columns = np.nonzero(placed.cells.directed)
    lines = np.array(ax.collections[0].get_segments())
    x, y = grid.place_of(rows, columns)
    np.testing.assert_allclose(lines.mean(axis=1), np.c_[x, y])
    along = lines[:, 1] - lines[:, 0]
    np.testing.assert_allclose(
        np.arctan2(along[:, 1], along[:, 0]), placed.cells.angle[rows, columns]
    )
    # The thickest where most walked; chaos cells are shaded, nothing else is.
    widths = ax.collections[0].get_linewidths()
    assert np.argmax(widths) == np.argmax(placed.cells.magnitude[rows, columns])
    shaded = (np.asarray(ax.images[0].get_array()) < 1).any(axis=2)
    np.testing.assert_array_equal(shaded, placed.cells.kind == cells.CHAOS)
    assert shaded.any()


@pytest.mark.parametrize(("place", "walks"), [("corridor", 15), ("corridor", 4), ("hall", 15)])
def test_the_sample_cell_has_about_as_many_walks_as_asked(request, place, walks):
    scene, grid, placed = request.getfixturevalue(place)
    figure = draw("2.10", scene, grid, placed, chaos_ratio=0.8, walks=walks)
    left, right = figure.axes
    row, column = (int(part) for part in re.findall(r"\d+", left.get_title(loc="left")))
    assert placed.cells.kind[row, column] == cells.DIRECTED
    counts = placed.cells.histograms[row, column]
    np.testing.assert_array_equal(bars(right), counts)
    assert right.lines[0].get_ydata()[0] == 0.8 * counts.max()
    assert right.get_title(loc="left") == f"{counts.sum()} walks"
    held = placed.cells.histograms.sum(axis=2)[placed.cells.directed]
    assert abs(counts.sum() - walks) == np.abs(held - walks).min()
    assert left.get_xlim() == pytest.approx((column * grid.cell, (column + 1) * grid.cell))


def test_the_mesh_is_as_high_as_the_votes_and_names_its_humps(corridor):
    scene, grid, placed = corridor
    solid, flat, *_ = draw("2.11", scene, grid, placed).axes
    assert tuple(solid.zz_dataLim.intervalx) == (placed.votes.min(), placed.votes.max())
    across, up = grid.centres()
    assert tuple(solid.xy_dataLim.intervalx) == (across[0], across[-1])
    assert tuple(solid.xy_dataLim.intervaly) == (up[0], up[-1])
    humps = placed.humps
    named = [text.get_text() for text in solid.texts]
    assert named == [f"({hump.row}, {hump.column})" for hump in humps.itertuples()]
    np.testing.assert_array_equal(labelled(flat)["hump"].get_xydata(), humps[["x", "y"]])
    np.testing.assert_array_equal(flat.images[0].get_array(), placed.votes)


def test_a_fine_mesh_is_thinned_but_keeps_its_edges():
    grid = GridMap(0.0, 0.0, 50, 130, 0.1)
    votes = np.add.outer(np.arange(50), np.arange(130))
    ax = plot_mesh(grid, votes, most=24)
    ax.figure.canvas.draw()
    faces = len(ax.collections[0].get_paths())
    assert 10**2 < faces <= 24**2
    assert tuple(ax.zz_dataLim.intervalx) == (0, 49 + 129)


def test_real_votes_show_traces_cells_and_humps(hall):
    scene, grid, placed = hall
    axes = draw("votes-on-real-people", scene, grid, placed).axes
    assert segments(axes[0]) == [4]
    assert segments(axes[1]) == [np.count_nonzero(placed.cells.directed)]
    np.testing.assert_array_equal(labelled(axes[2])["hump"].get_xydata(), placed.humps[["x", "y"]])


def test_frames_of_a_sequence_are_spread_over_it():
    frames = [np.full((8, 12), number, np.uint8) for number in range(51)]
    axes = draw("2.7", frames, frame_rate=10).axes
    assert [int(ax.images[0].get_array()[0, 0]) for ax in axes] == [0, 10, 20, 30, 40, 50]
    titles = [ax.get_title(loc="left") for ax in axes]
    assert titles == ["0.0 s", "1.0 s", "2.0 s", "3.0 s", "4.0 s", "5.0 s"]


@pytest.fixture(scope="module")
def moved():
    """A frame, its flow and a mask."""
    motion = make_motion("parting", shape=(40, 60))
    return motion, flow.moving_mask(motion.truth, speed=1.0)


def test_flow_mask_and_feet_are_drawn(moved):
    motion, mask = moved
    feet = [[10.0, 30.0], [50.0, 12.0]]
    axes = draw("2.8", motion.first, motion.truth, mask, feet).axes
    np.testing.assert_array_equal(axes[0].images[0].get_array(), motion.first)
    largest = np.percentile(np.abs(motion.truth[..., 0]), 99.8)
    np.testing.assert_array_equal(
        axes[1].images[0].get_array(), vision.colour_flow(motion.truth, largest=largest)
    )
    assert axes[1].child_axes[0].get_title() == f"{largest:.1f} px"
    np.testing.assert_array_equal(axes[2].images[0].get_array() == 0, mask > 0)
    np.testing.assert_array_equal(axes[2].lines[0].get_xydata(), feet)
    none = draw("2.8", motion.first, np.zeros_like(motion.truth), mask, np.empty((0, 2)))
    assert not none.axes[2].lines
    assert (none.axes[1].images[0].get_array() == 255).all()  # rest is white


def test_finders_share_one_scale_of_speed(moved):
    motion, mask = moved
    motions = {"slow": motion.truth / 4, "fast": motion.truth}
    axes = draw("finders", motion.first, motions, {"a": mask, "b": mask, "c": mask}).axes
    titles = [ax.get_title(loc="left") for ax in axes[:6]]
    assert titles[:2] == ["flow: slow", "flow: fast"]
    assert titles[2:] == ["frame", "moving: a", "moving: b", "moving: c"]
    scales = {ax.child_axes[0].get_title() for ax in axes[:2]}
    assert len(scales) == 1


def test_traces_are_drawn_over_the_view_and_on_the_map(corridor):
    scene, grid, _ = corridor
    # 40 pixels a metre, y turned round.
    homography = np.linalg.inv(np.array([[40.0, 0, 10], [0, -40.0, 210], [0, 0, 1]]))
    seen = scene.traces[scene.traces["trace"].isin(scene.walkers[:3])].reset_index(drop=True)
    frame = np.zeros((216, 480), np.uint8)
    left, right = draw("2.9", frame, homography, seen, scene, grid).axes
    places = seen[["x", "y"]].to_numpy()
    drawn = np.concatenate(left.collections[0].get_segments())
    np.testing.assert_allclose(drawn, places * [40, -40] + [10, 210])
    assert segments(right) == [len(scene.walls), grid.columns + 1, grid.rows + 1, 40, 3]
    np.testing.assert_array_equal(np.concatenate(right.collections[-1].get_segments()), places)


def test_end_point_errors_are_bars_by_method(moved):
    motion, _ = moved
    errors = pd.DataFrame(
        [[0.1, 0.2, 0.3, 0.4], [0.5, 0.6, 0.7, 0.8]],
        index=["parting", "other"],
        columns=list(flow.METHODS),
    )
    truth = motion.truth.copy()
    truth[:4] = np.nan
    figure = draw("flow-errors", errors, ("parting", truth, motion.truth))
    chart, known, ours = figure.axes[:3]
    assert bars(chart) == errors.to_numpy().T.ravel().tolist()
    middles = [bar.get_x() + bar.get_width() / 2 for bar in chart.patches]
    assert [round(at) for at in middles] == [0, 1] * 4
    assert len({round(at, 6) for at in middles}) == 8
    assert (known.images[0].get_array()[:4] == 255).all()
    np.testing.assert_array_equal(known.images[0].get_array()[4:], ours.images[0].get_array()[4:])


def test_pets_traces_are_drawn_with_their_scores():
    points = pd.DataFrame(
        {
            "trace": ["a", "a", "b"],
            "frame": [0, 1, 0],
            "x": [0.0, 1.0, 5.0],
            "y": [0.0, 1.0, 5.0],
            "matched": [True, False, True],
        }
    )
    score = {
        "recall": Estimate(0.8, 0.7, 0.9, 5),
        "precision": Estimate(0.6, None, None, 1),
        "median_error_m": Estimate(0.25, 0.2, 0.3, 5),
    }
    figure = draw(
        "pets-traces",
        {"background": points, "horn-schunck": points},
        {"background": score, "horn-schunck": score},
    )
    for ax, name in zip(figure.axes, ("background", "horn-schunck"), strict=False):
        assert ax.get_title(loc="left") == f"{name}: 2 traces"
        assert segments(ax) == [2]
        np.testing.assert_array_equal(ax.lines[0].get_xydata(), [[1, 1]])
    assert bars(figure.axes[2]) == [0.8, 0.6] * 2
    whiskers = figure.axes[2].collections[0].get_segments()
    np.testing.assert_array_equal([s[:, 1] for s in whiskers], [[0.7, 0.9], [0.6, 0.6]])


@pytest.fixture(scope="module")
def site(hall):
    """The hall, made ready for choosing."""
    return prepare_site(hall[0], model=CameraModel(near=0.2, reach=3.0))


def test_plans_show_cameras_and_whom_they_see(site):
    chosen = {}
    for method in ("votes", "greedy", "exact"):
        cameras, _ = choose_cameras(site, method, 1)
        served = judge_cameras(cameras, site.targets, model=site.model)
        chosen[method] = cameras, served.mean(), served
    axes = draw("plans", site, chosen).axes
    for ax, (method, (cameras, share, served)) in zip(axes, chosen.items(), strict=False):
        pale, dark, stand = ax.lines[:3]  # the first map has a legend, too
        assert (len(pale.get_xdata()), len(dark.get_xdata())) == ((~served).sum(), served.sum())
        np.testing.assert_array_equal(stand.get_xydata(), cameras[["x", "y"]])
        assert ax.get_title(loc="left") == f"{method}: {share:.0%} of walker-seconds"
        cone = ax.patches[0]
        assert (cone.theta2 - cone.theta1, cone.r) == (60, 3)
        assert (cone.theta1 + cone.theta2) / 2 == cameras["heading"].iloc[0]
    assert not axes[3].axison


def test_a_panning_camera_has_a_ring_where_a_fixed_one_has_a_cone(site):
    cameras = site.cameras.head(2)
    ax = plot_cameras(cameras, CameraModel(reach=3.0, pans=True))
    assert [patch.get_radius() for patch in ax.patches] == [3, 3]
    assert not plot_cameras(cameras, site.model, cones=False).patches


@pytest.mark.parametrize("scenes", [1, 2])
def test_shares_lie_in_the_row_of_their_scene(scenes):
    names = ["hall", "corridor"][:scenes]
    shares = pd.DataFrame(
        [
            {"scene": name, "method": method, "share": share, "low": share - 0.1, "high": 0.9}
            for name in names
            for method, share in (("votes", 0.3), ("exact", 0.6))
        ]
    )
    shares.loc[0, ["low", "high"]] = None  # one walker has no interval
    ax = draw("price-of-voting", shares).axes[0]
    assert [label.get_text() for label in ax.get_yticklabels()] == names
    for line, method in zip(ax.lines, ("votes", "exact"), strict=True):
        own = shares[shares["method"] == method]
        assert line.get_label() == method
        np.testing.assert_array_equal(line.get_xdata(), own["share"])
        assert [round(at) for at in line.get_ydata()] == list(range(scenes))
    spans = [[tuple(s[:, 0]) for s in c.get_segments()] for c in ax.collections]
    assert spans[0][0] == (0.3, 0.3)
    assert spans[1][0] == (0.5, 0.9)


def test_how_many_cameras_is_a_curve_a_method(hall):
    table = pd.DataFrame(
        {
            "method": ["votes", "exact"] * 2,
            "cameras": [1, 1, 2, 2],
            "share": [0.2, 0.3, 0.4, 0.7],
            "low": [0.1, None, 0.3, 0.6],
            "high": [0.3, None, 0.5, 0.8],
        }
    )
    axes = draw("how-many-cameras", {"hall": table}, required=0.6).axes
    assert len(axes) == 1
    assert list(axes[0].lines[0].get_ydata()) == [0.6, 0.6]
    for line in axes[0].lines[1:]:
        own = table[table["method"] == line.get_label()]
        np.testing.assert_array_equal(line.get_xdata(), own["cameras"])
        np.testing.assert_array_equal(line.get_ydata(), own["share"])
    assert list(axes[0].get_xticks()) == [1, 2]
    assert axes[0].get_title(loc="left") == "hall"


def test_demands_hatch_what_is_forbidden(site):
    forbidden = np.zeros(site.grid.shape, bool)
    forbidden[0, :3] = True
    served = np.zeros(len(site.targets), bool)
    cameras = site.cameras.head(2)
    variants = {"free": (cameras, served, None), "barred": (cameras, served, forbidden)}
    free, barred = draw("demands", site, variants).axes
    assert not free.collections
    corners = [path.vertices.min(axis=0) for path in barred.collections[0].get_paths()]
    np.testing.assert_allclose(corners, [[0, 0], [0.5, 0], [1, 0]])
    for ax, title in ((free, "free"), (barred, "barred")):
        assert ax.get_title(loc="left") == title
        np.testing.assert_array_equal(ax.lines[2].get_xydata(), cameras[["x", "y"]])


def test_master_and_slaves_show_who_is_awake(hall):
    scene = hall[0]
    slaves = [pan_tilt.PanTilt(3.0, 2.0, reach=2.5), pan_tilt.PanTilt(3.0, 2.5, reach=2.5)]
    watch = pan_tilt.simulate(scene.traces, slaves, frame_rate=10)
    figure = draw("master-and-slaves", watch, [10, 20], [0.5, 0.1], seconds=(1, 5))
    top, left, right = figure.axes
    assert top.get_xlim() == (1, 5)
    assert [label.get_text() for label in top.get_yticklabels()] == ["camera 1", "camera 2"]
    for camera, spans in enumerate(top.collections):
        rows = watch.table[watch.table["camera"] == camera]
        rows = rows[rows["frame"].between(10, 50)]
        edges = [(p.vertices[:, 0].min(), p.vertices[:, 0].max()) for p in spans.get_paths()]
        time = rows["frame"].to_numpy() / 10
        inside = [any(start <= at < stop for start, stop in edges) for at in time[:-1]]
        np.testing.assert_array_equal(inside, rows["awake"].to_numpy()[:-1])
    assert sum(bars(left)) == watch.table["awake"].sum()
    np.testing.assert_array_equal(right.lines[0].get_xydata(), [[10, 0.5], [20, 0.1]])
