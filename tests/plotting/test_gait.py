"""Gait in a box, as drawn."""

from mcnlab.plotting.gait import plot_rhythm
from mcnlab.walking import gait


def test_a_curve_without_a_peak_is_drawn_without_one():
    ax = plot_rhythm([0, 0.1], [1.0, 0.5], period=gait.Period(0.0, 0.0, 0.0, 1.0, False))
    assert len(ax.lines) == 2
