"""Moving a slider changes the picture and the accuracy, and says so when it cannot."""

import matplotlib

matplotlib.use("Agg")

import re
import threading
import time

import ipywidgets
import numpy as np
import pytest

from mcnlab import bundled, direction, evaluation, phase, widgets
from mcnlab.datasets.walkers import make_walks
from mcnlab.widgets.direction import _overlap


@pytest.fixture(scope="module")
def casia():
    """CASIA A, mirrored, from the bundled table."""
    return bundled.casia_a()


@pytest.fixture(scope="module")
def masks():
    """A clean walk."""
    return make_walks(subjects=1, directions=(3,), seed=0)[0].masks


def panels(casia, masks):
    """Every panel with a control and two values for it."""
    return {
        "silhouette": (widgets.silhouette_panel(masks), "specks", (0, 60)),
        "mirror": (widgets.mirror_panel(casia), "every", (5, 20)),
        "phase": (widgets.phase_panel(casia), "prominence", (1.0, 6.0)),
        "separator": (widgets.separator_panel(casia), "prominence", (1.0, 6.0)),
        "heading": (widgets.heading_panel(casia, focal_length=450), "window", (12, 25)),
    }


def test_a_moved_slider_redraws_the_picture(casia, masks):
    for name, (panel, control, values) in panels(casia, masks).items():
        pictures = []
        for value in values:
            panel.controls[control].value = value
            pictures.append(bytes(panel.picture.value))
            assert pictures[-1].startswith(b"\x89PNG"), name
        assert pictures[0] != pictures[1], name


@pytest.mark.parametrize("dimension", ["h", "w"])
def test_the_separator_panel_says_the_judged_accuracy(casia, dimension):
    panel = widgets.separator_panel(casia)
    panel.controls["dimension"].value = dimension
    panel.controls["prominence"].value = 3.0
    measured = phase.measure_phases(casia.boxes, prominence=3.0)[f"m_{dimension}"]
    resubstituted, left_out = evaluation.judge_phase(casia, measured)
    said = [float(value) for value in re.findall(r"<b>([\d.]+)</b>", panel.text.value)]
    assert said == [round(resubstituted.value, 4), round(left_out.value, 4)]


def test_the_heading_panel_says_the_judged_accuracy(casia):
    panel = widgets.heading_panel(casia, focal_length=450)
    panel.controls["focal_length"].value = 380
    from mcnlab import perspective

    own = casia.without_copies()
    headings = perspective.measure_headings(own, focal_length=380, window=25)
    right, _, _ = evaluation.judge_headings(own, headings)
    assert f"<b>{right.value:.3f}</b>" in panel.text.value


def test_what_cannot_be_is_said_in_words(casia, masks):
    panel = widgets.silhouette_panel(masks)
    assert "100%" in _with(panel, specks=0, holes=0, limbs=0, min_area=1).text.value
    few = casia.with_boxes(
        casia.boxes[casia.boxes["sequence"] == casia.sequences[0]].head(10).reset_index(drop=True),
        directions=casia.directions[casia.sequences[:1]],
        copies=frozenset(),
    )
    assert "ArgumentError" in widgets.heading_panel(few, focal_length=450).text.value


def test_readers_without_a_kernel_see_the_picture(masks):
    panel = widgets.silhouette_panel(masks)
    assert "image/png" in panel._repr_mimebundle_()


def test_moves_from_several_threads_take_turns():
    """JupyterLab may deliver two moves at once; no picture may be half of another."""
    inside, most = [], []

    def draw(ax, value):
        inside.append(value)
        most.append(len(inside))
        time.sleep(0.01)
        ax.plot([0, value])
        inside.pop()
        return str(value)

    panel = widgets.Panel(draw, {"value": ipywidgets.IntSlider(value=0, max=100)})
    threads = [
        threading.Thread(target=setattr, args=(panel.controls["value"], "value", value))
        for value in range(1, 9)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert max(most) == 1
    assert panel.text.value == str(panel.controls["value"].value)


def test_mirror_panel_offers_the_oblique_walks(casia):
    panel = widgets.mirror_panel(casia)
    offered = panel.controls["sequence"].options
    assert set(direction.group_of(casia.directions[list(offered)])) == {2, 4}
    name = panel.controls["sequence"].value
    assert f"in direction {casia.directions[name]}" in panel.text.value


def _with(panel, **values):
    for name, value in values.items():
        panel.controls[name].value = value
    return panel


def test_overlap_is_intersection_over_union(masks):
    from mcnlab.silhouettes import find_body

    body = find_body(masks[0])
    assert _overlap(body, body) == 1
    far = np.roll(masks[0], 120, axis=1)
    assert _overlap(body, find_body(far)) == 0
