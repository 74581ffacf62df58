"""The panel of optical flow says how much moves."""

import numpy as np

from mcnlab import widgets
from mcnlab.vision import flow


def moved_to(panel, **values):
    """A panel after its controls were moved."""
    for name, value in values.items():
        panel.controls[name].value = value
    return panel


def test_the_flow_panel_says_how_much_moves(new_panel, moved):
    panel = moved_to(new_panel("flow"), alpha=10.0, iterations=30, speed=1.0)
    motion = flow.horn_schunck(moved.first, moved.second, alpha=10.0, iterations=30)
    mask = flow.moving_mask(motion, speed=1.0)
    assert f"<b>{np.mean(mask > 0):.1%}</b>" in panel.text.value
    np.testing.assert_array_equal(panel._axes[1].images[0].get_array() == 0, mask > 0)
    moved_to(panel, pyramid=False)
    motion = flow.horn_schunck_plain(moved.first, moved.second, alpha=10.0, iterations=30)
    assert f"<b>{np.mean(flow.moving_mask(motion, speed=1.0) > 0):.1%}</b>" in panel.text.value


def test_frames_of_two_sizes_are_answered_in_words(moved):
    panel = widgets.flow_panel((moved.first, moved.second[:-1]))
    assert "ArgumentError" in panel.text.value
