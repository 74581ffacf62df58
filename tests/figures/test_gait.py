"""The figures of sections 2.1 and 2.2 are tested by what is drawn on them."""

import numpy as np
import pandas as pd
import pytest
from matplotlib.collections import LineCollection

from mcnlab.figures.registry import draw
from mcnlab.figures.walking import example_walk
from mcnlab.synthetic.walkers import make_walks
from mcnlab.vision import recordings
from mcnlab.vision.silhouettes import measure_sequence
from mcnlab.walking import gait, viewpoint


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
