"""Scenes that the tests of placement share."""

import numpy as np
import pandas as pd
import pytest

from mcnlab.datasets.scene import Scene
from mcnlab.synthetic.corridor import make_corridor
from mcnlab.tables import FRAME, TRACE, X, Y

RATE = 10.0


def trace(name, x, y, *, start=0):
    """One walker's places, a frame each."""
    return pd.DataFrame({TRACE: name, FRAME: start + np.arange(len(x)), X: x, Y: y})


@pytest.fixture(scope="module")
def hall():
    """Six people who walk along y = 3, some this way and some that, a metre a second."""
    along = 1 + np.arange(101) / RATE
    walks = [
        trace(f"w{number}", along[:: (-1) ** number], np.full(101, 3 + 0.02 * number), start=number)
        for number in range(6)
    ]
    return Scene("hall", pd.concat(walks, ignore_index=True), RATE, (0.0, 0.0, 12.0, 6.0))


@pytest.fixture(scope="module")
def ring():
    """Four people who walk round (4.25, 4.25), in the middle of cell (8, 8), at 2 to 2.6 m."""
    angle = np.arange(0, 2 * np.pi, 1.2 / 2.3 / RATE)
    middle = 4.25
    walks = [
        trace(f"w{number}", middle + radius * np.cos(angle), middle + radius * np.sin(angle))
        for number, radius in enumerate((2.0, 2.2, 2.4, 2.6))
    ]
    return Scene("ring", pd.concat(walks, ignore_index=True), RATE, (0.0, 0.0, 8.5, 8.5))


@pytest.fixture(scope="module")
def corridor():
    """A few people in the corridor."""
    return make_corridor(walkers=16, seed=3)
