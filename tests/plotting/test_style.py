"""Colours can be told apart: by the colour-blind, in grey, and on white."""

from itertools import combinations

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from skimage.color import deltaE_ciede2000, rgb2lab

from mcnlab.plotting import style
from mcnlab.plotting.occlusion import FORESEEN, RULE_COLOURS, RULE_INK, WALKER_COLOURS

# Machado, Oliveira and Fernandes (2009), severity 1; they act on linear RGB.
BLINDNESS = {
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
}

PALETTES = {name: colours for name, colours in vars(style).items() if name.endswith("_COLOURS")} | {
    "forecasts and the truth": style.FORECAST_COLOURS | {"truth": style.TRUTH},
    "bounds": dict(upper=style.UPPER, lower=style.LOWER, mean=style.MEAN),
    "walkers and the occlusion foreseen": dict(enumerate((*WALKER_COLOURS, FORESEEN))),
}
FILLS = {"rules": RULE_COLOURS}  # with their letter inside


def linear(colour):
    """Linear RGB of a colour."""
    values = np.array(to_rgb(colour))
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def seen(colour, matrix):
    """CIELAB of what a viewer sees in place of a colour."""
    values = np.clip(np.asarray(matrix) @ linear(colour), 0, 1)
    curved = 1.055 * values ** (1 / 2.4) - 0.055
    return rgb2lab(np.where(values <= 0.0031308, 12.92 * values, curved))


def luminance(colour):
    return linear(colour) @ [0.2126, 0.7152, 0.0722]


def contrast(one, two):
    """The contrast of WCAG 2."""
    low, high = sorted((luminance(one), luminance(two)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("blindness", BLINDNESS)
@pytest.mark.parametrize("name", [*PALETTES, *FILLS])
def test_the_colour_blind_can_tell_colours_apart(name, blindness):
    colours = {**PALETTES, **FILLS}[name]
    matrix = BLINDNESS[blindness]
    near = {
        (one, two): float(deltaE_ciede2000(seen(colours[one], matrix), seen(colours[two], matrix)))
        for one, two in combinations(colours, 2)
    }
    assert {pair: delta for pair, delta in near.items() if delta < 20} == {}


@pytest.mark.parametrize("name", PALETTES)
def test_every_colour_can_be_seen_on_white(name):
    low = {key: contrast(held, "white") for key, held in PALETTES[name].items()}
    assert {key: held for key, held in low.items() if held < 3} == {}


@pytest.mark.parametrize("colour", [style.INK, style.GREY, style.FAINT, style.UPPER, style.LOWER])
def test_lines_and_text_can_be_seen_on_white(colour):
    assert contrast(colour, "white") >= 3


def test_letters_can_be_read_on_their_fills():
    for rule, fill in RULE_COLOURS.items():
        assert contrast(RULE_INK[rule], fill) >= 4.5


def test_hues_are_told_apart_in_grey():
    hues = (style.NIGHT, style.BROWN, style.BLUE, style.ROSE, style.ORANGE, style.SKY)
    lightness = sorted(seen(colour, np.eye(3))[0] for colour in hues)
    assert np.diff(lightness).min() > 8
    for name, colours in vars(style).items():
        # None but the hues, and the green of those who are served with its counterpart.
        if name.endswith("_COLOURS") and name != "SERVED_COLOURS":
            assert set(colours.values()) <= set(hues), name


def test_the_look_is_set(monkeypatch):
    import matplotlib as mpl

    with mpl.rc_context():
        style.use_style()
        assert mpl.rcParams["savefig.dpi"] == 150
        assert mpl.rcParams["figure.constrained_layout.use"]
