"""Places on the ground, as drawn."""

import numpy as np
import pandas as pd
import pytest
from matplotlib.colors import to_hex

from mcnlab.cameras.floor import GridMap
from mcnlab.cameras.visibility import CameraModel
from mcnlab.plotting.placement import plot_cameras, plot_histogram, plot_mesh, plot_sights
from mcnlab.plotting.style import LOWER, UPPER


def bars(ax):
    """The heights of the bars on axes."""
    return [bar.get_height() for bar in ax.patches]


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


def test_a_fine_mesh_is_thinned_but_keeps_its_edges():
    grid = GridMap(0.0, 0.0, 50, 130, 0.1)
    votes = np.add.outer(np.arange(50), np.arange(130))
    ax = plot_mesh(grid, votes, most=24)
    ax.figure.canvas.draw()
    faces = len(ax.collections[0].get_paths())
    assert 10**2 < faces <= 24**2
    assert tuple(ax.zz_dataLim.intervalx) == (0, 49 + 129)


def test_a_panning_camera_has_a_ring_where_a_fixed_one_has_a_cone():
    cameras = pd.DataFrame({"x": [1.0, 4.0], "y": [2.0, 2.0], "heading": [90.0, 0.0]})
    ax = plot_cameras(cameras, CameraModel(reach=3.0, pans=True))
    assert [(patch.r, patch.theta2 - patch.theta1) for patch in ax.patches] == [(3, 360)] * 2
    ax = plot_cameras(cameras, CameraModel(reach=3.0, field_of_view=60.0))
    assert [(patch.theta1, patch.theta2) for patch in ax.patches] == [(60, 120), (-30, 30)]
    assert not plot_cameras(cameras, CameraModel(reach=3.0), cones=False).patches


def test_lines_of_sight_lead_from_cameras_to_whom_they_see():
    cameras = pd.DataFrame({"x": [0.0, 5.0], "y": [0.0, 5.0]})
    targets = pd.DataFrame({"x": np.arange(10.0), "y": 1.0})
    seen = np.zeros((10, 2), bool)
    seen[:7, 0] = True
    ax = plot_sights(cameras, targets, seen, most=4)
    lines = np.array(ax.collections[0].get_segments())
    np.testing.assert_array_equal(lines[:, 0], [[0, 0]] * 4)
    np.testing.assert_array_equal(lines[:, 1], [[0, 1], [2, 1], [4, 1], [6, 1]])
