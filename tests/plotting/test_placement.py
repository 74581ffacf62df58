"""Places on the ground, as drawn."""

import numpy as np
import pandas as pd
import pytest
from matplotlib.colors import to_hex

from mcnlab.cameras.floor import GridMap
from mcnlab.cameras.visibility import CameraModel
from mcnlab.plotting.placement import plot_cameras, plot_histogram, plot_mesh
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
    assert [patch.get_radius() for patch in ax.patches] == [3, 3]
    assert not plot_cameras(cameras, CameraModel(reach=3.0), cones=False).patches
