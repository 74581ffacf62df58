"""What several tests of figures share: recordings, places, and figures closed."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from mcnlab.cameras.floor import GridMap
from mcnlab.datasets.scene import Scene
from mcnlab.placement.votes import VoteRules, place_by_votes
from mcnlab.synthetic.corridor import make_corridor
from mcnlab.vision import recordings

CHAOS_RATIO = 0.3  # low, for a few walkers to make some chaos


@pytest.fixture(autouse=True)
def closed():
    """No figure outlives its test."""
    yield
    plt.close("all")


@pytest.fixture(scope="module")
def casia():
    """CASIA A, mirrored, from the bundled table."""
    return recordings.casia_a()


@pytest.fixture(scope="module")
def corridor():
    """A few people in the made corridor: (scene, grid, placed)."""
    scene = make_corridor(walkers=40, seed=1)
    grid = GridMap.over(scene.area, cell=0.5)
    placed = place_by_votes(scene.traces, grid, n=2, rules=VoteRules(chaos_ratio=CHAOS_RATIO))
    return scene, grid, placed


@pytest.fixture(scope="module")
def hall():
    """Four people who walk along the lower row of a place without walls."""
    along = 0.1 + np.arange(60) / 10
    walks = [
        pd.DataFrame(
            {"trace": f"w{number}", "frame": np.arange(60), "x": along, "y": 0.3 + 0.1 * number}
        )
        for number in range(4)
    ]
    scene = Scene("hall", pd.concat(walks, ignore_index=True), 10, (0.0, 0.0, 6.0, 3.0))
    grid = GridMap.over(scene.area, cell=1.0)
    return scene, grid, place_by_votes(scene.traces, grid, n=1)
