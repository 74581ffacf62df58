"""The figures of section 2.3 are tested by what is drawn on them."""

import numpy as np
import pandas as pd
import pytest
from matplotlib.collections import LineCollection

from mcnlab.figures.registry import draw
from mcnlab.plotting import vision
from mcnlab.statistics import Estimate
from mcnlab.synthetic.shifts import make_motion
from mcnlab.vision import flow


def segments(ax):
    """Of every collection of lines on axes: its number of segments."""
    return [len(c.get_segments()) for c in ax.collections if isinstance(c, LineCollection)]


def bars(ax):
    """The heights of the bars on axes."""
    return [bar.get_height() for bar in ax.patches]


@pytest.fixture(scope="module")
def moved():
    """A frame, its flow and a mask."""
    motion = make_motion("parting", shape=(40, 60))
    return motion, flow.moving_mask(motion.truth, speed=1.0)


def test_frames_of_a_sequence_are_spread_over_it():
    frames = [np.full((8, 12), number, np.uint8) for number in range(51)]
    axes = draw("2.7", frames, frame_rate=10).axes
    assert [int(ax.images[0].get_array()[0, 0]) for ax in axes] == [0, 10, 20, 30, 40, 50]
    titles = [ax.get_title(loc="left") for ax in axes]
    assert titles == ["0.0 s", "1.0 s", "2.0 s", "3.0 s", "4.0 s", "5.0 s"]


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
