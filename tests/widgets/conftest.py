"""What several tests of panels share: walks, places, and panels of them."""

import matplotlib

matplotlib.use("Agg")

import numpy as np
import pandas as pd
import pytest

from mcnlab import widgets
from mcnlab.cameras.visibility import CameraModel
from mcnlab.datasets.scene import Scene
from mcnlab.synthetic.corridor import make_corridor
from mcnlab.synthetic.shifts import make_motion
from mcnlab.synthetic.walkers import make_walks
from mcnlab.walking import viewpoint


@pytest.fixture(scope="module")
def masks():
    """A clean walk."""
    return make_walks(subjects=1, directions=(3,), seed=0)[0].masks


@pytest.fixture(scope="module")
def hall():
    """Four people who walk along y = 2, two each way, a metre a second."""
    along = 1 + np.arange(61) / 10
    walks = [
        pd.DataFrame(
            {
                "trace": f"w{number}",
                "frame": np.arange(61),
                "x": along[:: (-1) ** number],
                "y": 2 + 0.1 * number,
            }
        )
        for number in range(4)
    ]
    return Scene("hall", pd.concat(walks, ignore_index=True), 10, (0.0, 0.0, 8.0, 4.0))


@pytest.fixture(scope="module")
def corridor():
    """A few people in the made corridor."""
    return make_corridor(walkers=30, seed=1)


@pytest.fixture(scope="module")
def angled():
    """Two synthetic people from two view angles."""
    tables, truth = viewpoint.record_at_angles([0, 90], subjects=2)
    return tables[0], truth


@pytest.fixture(scope="module")
def moved():
    """Two frames of a made motion."""
    return make_motion("parting", shape=(48, 64))


MODEL = CameraModel(near=0.5, reach=4.0)


@pytest.fixture
def new_panel(hall, corridor, angled, moved):
    """new_panel(name): a panel on something made."""
    make = {
        "gait": lambda: widgets.gait_panel(*angled, frame_rate=25),
        "flow": lambda: widgets.flow_panel((moved.first, moved.second)),
        "vote": lambda: widgets.vote_panel(corridor),
        "choice": lambda: widgets.choice_panel(hall, model=MODEL),
        "occlusion": widgets.occlusion_panel,
    }
    return lambda name: make[name]()
