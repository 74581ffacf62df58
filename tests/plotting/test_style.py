"""Colours can be told apart: in grey, by the colour-blind, and on white."""

import numpy as np

from mcnlab.plotting.style import GROUP_COLOURS


def test_groups_are_told_apart_in_grey():
    from matplotlib.colors import to_rgb

    weights = np.array([0.2126, 0.7152, 0.0722])
    grey = sorted(float(weights @ to_rgb(colour)) for colour in GROUP_COLOURS.values())
    # A twentieth of the range is about the least step that a print shows; markers help.
    assert np.diff(grey).min() > 0.05
