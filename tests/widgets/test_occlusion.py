"""The panel of the tables says what they and the equations say."""

import re

import numpy as np
import pytest

from mcnlab import widgets
from mcnlab.occlusion import thesis
from mcnlab.plotting.occlusion import made_walker


@pytest.fixture
def panel():
    """The panel, as it begins."""
    return widgets.occlusion_panel()


def test_a_pressed_cell_is_the_one_looked_at(panel):
    picker = panel.controls["cell"]
    picker._buttons[2, 6].click()
    assert picker.value == (2, 6)
    assert panel.text.value.startswith("S1 2 away-right, v3; S2 6 toward-left, v3")
    framed = [cell for cell, button in picker._buttons.items() if button.layout.border_top]
    assert framed == [(2, 6)]
    assert len(picker._buttons) == 64


@pytest.mark.parametrize(
    ("cell", "levels", "said"),
    [
        ((3, 7), (3, 3), "1: certain occlusion"),
        ((3, 3), (3, 1), "C: time and place decide"),
        ((3, 3), (1, 1), "P(O|S), and by speed 0: no occlusion"),
        ((7, 3), (3, 3), "0: no occlusion"),
        ((8, 7), (1, 3), "C: time and place decide"),
    ],
)
def test_the_panel_says_what_the_tables_say(panel, cell, levels, said):
    panel.controls["cell"].value = cell
    panel.controls["level1"].value, panel.controls["level2"].value = levels
    assert f"<b>{said}</b>" in panel.text.value
    assert ("t = " in panel.text.value) == said.startswith(("1", "C"))


def test_the_panel_says_the_time_of_the_equations(panel):
    panel.controls["cell"].value = (3, 3)
    panel.controls["level2"].value = 1
    one, two = (made_walker(x, 119.5, 3, level) for x, level in ((0.35 * 352, 3), (0.65 * 352, 1)))
    seconds = thesis.seconds_to_meet(two.x - one.x, one.pixels, two.pixels, same_way=True)
    (said,) = re.findall(r"<b>([\d.]+) s</b>", panel.text.value)
    assert float(said) == pytest.approx(float(seconds), abs=0.05)  # one decimal is said


def test_the_clock_moves_the_walkers(panel):
    axes = panel._axes[1]
    panel.controls["seconds"].value = 2.0
    walker = made_walker(0.35 * 352, 119.5, 3, 3)
    way = axes.lines[0].get_xydata()
    np.testing.assert_allclose(way[0], [walker.x, walker.y])
    np.testing.assert_allclose(way[1], [walker.x + 2 * walker.vx, walker.y])
