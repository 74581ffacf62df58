"""The figures of traces, votes and places are tested by what is drawn on them."""

import re

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from matplotlib.collections import LineCollection

from mcnlab.cameras.visibility import CameraModel
from mcnlab.control import pan_tilt
from mcnlab.figures.placement import draw_cells
from mcnlab.figures.registry import draw
from mcnlab.placement import cells
from mcnlab.placement.site import choose_cameras, judge_cameras, prepare_site

CHAOS_RATIO = 0.3  # low, for a few walkers to make some chaos


def labelled(ax):
    """The lines of axes by their labels."""
    return {line.get_label(): line for line in ax.lines}


def segments(ax):
    """Of every collection of lines on axes: its number of segments."""
    return [len(c.get_segments()) for c in ax.collections if isinstance(c, LineCollection)]


def bars(ax):
    """The heights of the bars on axes."""
    return [bar.get_height() for bar in ax.patches]


@pytest.fixture(scope="module")
def site(hall):
    """The hall, made ready for choosing."""
    return prepare_site(hall[0], model=CameraModel(near=0.2, reach=3.0))


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


def test_real_votes_show_traces_cells_and_humps(hall):
    scene, grid, placed = hall
    axes = draw("votes-on-real-people", scene, grid, placed).axes
    assert segments(axes[0]) == [4]
    assert segments(axes[1]) == [np.count_nonzero(placed.cells.directed)]
    np.testing.assert_array_equal(labelled(axes[2])["hump"].get_xydata(), placed.humps[["x", "y"]])


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
