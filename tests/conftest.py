"""What several tests share: made-up boxes and silhouettes, and a shut door to recordings."""

import os
from pathlib import Path

import cv2
import numpy as np
import pandas as pd
import pytest
from hypothesis import settings
from hypothesis import strategies as st

from mcnlab.datasets.recording import Recording
from mcnlab.occlusion.composites import compose_all
from mcnlab.occlusion.forecasters import ConstantVelocity, Perspective, Thesis
from mcnlab.occlusion.pairs import find_pairs
from mcnlab.synthetic.crossings import make_crossings
from mcnlab.synthetic.street import make_street
from mcnlab.tables import BOX_COLUMNS, FRAME, MEASURES, H, W
from mcnlab.vision.recordings import casia_a

# Examples are drawn from the code alone, not at random, and a slow machine fails no test.
settings.register_profile("repeatable", deadline=None, derandomize=True, max_examples=100)
settings.load_profile("repeatable")

_RECORDINGS = os.environ.get("MCNLAB_DATA")  # before the tests hide it


@pytest.fixture(scope="session", autouse=True)
def _shut_before_anything_is_read():
    """Fixtures that a whole session or module shares read what is bundled, too."""
    for name in ("MCNLAB_DATA", "MCNLAB_OUT"):
        os.environ.pop(name, None)


@pytest.fixture(autouse=True)
def _nothing_from_outside(monkeypatch):
    """No test reads recordings or writes results because of the shell it was started from."""
    for name in ("MCNLAB_DATA", "MCNLAB_OUT"):
        monkeypatch.setenv(name, "")  # so that what a test sets is undone, too
        monkeypatch.delenv(name)


@pytest.fixture(scope="session")
def recordings():
    """The folder of real recordings; tests that ask for it are skipped without one."""
    if not _RECORDINGS:
        pytest.skip("MCNLAB_DATA is not set")
    return Path(_RECORDINGS).resolve()


@pytest.fixture(scope="session")
def make_boxes():
    """make_boxes(n, column=values, …): a sound box table of one walk, columns replaced."""

    def make(n=10, **columns):
        step = np.arange(n)
        sound = {
            "sequence": "walk",
            "subject": "walker",
            "frame": 1 + step,
            "x": 100.0 + 2 * step,
            "y": 60.0,
            "w": 40.0,
            "h": 100.0 + step,
            "cx": 120.0 + 2 * step,
            "cy": 110.0 + step / 2,
        }
        return pd.DataFrame({**sound, **columns}, index=range(n))

    return make


@pytest.fixture(scope="session")
def make_walks(make_boxes):
    """make_walks(name=(x, step), …): straight walks; the centre's first column, pixels a frame."""

    def make(**walks):
        step = np.arange(60)
        tables = [
            make_boxes(60, sequence=name, subject=name, x=x + by * step - 20, h=100.0).assign(
                cx=x + by * step, cy=110.0
            )
            for name, (x, by) in walks.items()
        ]
        return Recording("made", pd.concat(tables, ignore_index=True), 25.0, 640, 480)

    return make


@pytest.fixture(scope="session")
def casia():
    """CASIA A, mirrored, from the bundled table."""
    return casia_a()


@pytest.fixture(scope="session")
def composites(casia):
    """Every composite of CASIA A."""
    return compose_all(casia, focal_length=450)


@pytest.fixture(scope="session")
def street():
    """The made street's composites that begin together."""
    return compose_all(make_street().recording, focal_length=450, shifts=[0])


@pytest.fixture(scope="session")
def square():
    """A few people who cross a square."""
    return make_crossings(people=20, seconds=12.0, seed=3)


@pytest.fixture(scope="session")
def pairs(square):
    """Their pairs."""
    return find_pairs(square)


@pytest.fixture(scope="session")
def forecasts(pairs):
    """What the forecasters that learn nothing say of them."""
    return {one.name: one.forecast(pairs) for one in (Thesis(), ConstantVelocity(), Perspective())}


@pytest.fixture(scope="session")
def box_tables():
    """Strategy: box tables of one to three walks, sound or with a cell or two spoilt."""
    return _box_tables()


@st.composite
def _box_tables(draw):
    places = st.floats(-2000, 2000)
    sizes = st.one_of(st.floats(1, 500), st.integers(1, 500))
    rows = []
    for walk in range(draw(st.integers(1, 3))):
        frames = draw(st.lists(st.integers(0, 60), min_size=1, max_size=20, unique=True))
        steady = draw(st.booleans())  # half of the walks stand still
        box = [draw(sizes if name in (W, H) else places) for name in MEASURES]
        for frame in sorted(frames):
            if not steady:
                box = [
                    value + draw(st.floats(0, 5) if name in (W, H) else st.floats(-5, 5))
                    for name, value in zip(MEASURES, box, strict=True)
                ]
            rows.append([f"walk-{walk}", f"walker-{walk % 2}", frame, *box])
    spoilt = st.sampled_from([np.nan, np.inf, -np.inf, None, "text", "", "7", 0, -1, 0.5, 1e300])
    for _ in range(draw(st.sampled_from([0, 0, 1, 1, 2]))):
        row = draw(st.integers(0, len(rows) - 1))
        rows[row][draw(st.integers(0, len(BOX_COLUMNS) - 1))] = draw(spoilt)
    if draw(st.sampled_from([False, False, False, True])):
        rows.append(rows[draw(st.integers(0, len(rows) - 1))])
    table = pd.DataFrame(rows, columns=list(BOX_COLUMNS))
    drop = draw(st.sampled_from([None] * 9 + [FRAME, H]))
    return table if drop is None else table.drop(columns=drop)


@pytest.fixture(scope="session")
def draw_walker():
    """draw_walker(left, top, height, shape): a mask of head, torso and two legs in one piece."""

    def draw(left=100, top=40, height=120, shape=(240, 352)):
        mask = np.zeros(shape, np.uint8)
        unit = height // 12
        middle = left + 2 * unit
        mask[top : top + 2 * unit, middle - unit : middle + unit] = 255
        mask[top + 2 * unit : top + 7 * unit, left : left + 4 * unit] = 255
        mask[top + 7 * unit : top + height, left : left + unit] = 255
        mask[top + 7 * unit : top + height, left + 3 * unit : left + 4 * unit] = 255
        return mask

    return draw


@pytest.fixture(scope="session")
def encode_png():
    """encode_png(mask): the bytes of a PNG file."""
    return lambda mask: cv2.imencode(".png", mask)[1].tobytes()


@pytest.fixture
def casia_folder(tmp_path, draw_walker, encode_png):
    """A folder laid out as CASIA A: subjects abc and xyz, walks 00_1 and 45_1, 12 frames each."""
    labels = ["subject,sequence,direction"]
    for subject in ("abc", "xyz"):
        for walk, direction in (("00_1", 7), ("45_1", 6)):
            folder = tmp_path / "silhouettes" / subject / walk
            folder.mkdir(parents=True)
            labels.append(f"{subject},{walk},{direction}")
            for number in range(1, 13):
                mask = draw_walker(left=200 - 5 * number, height=96 + 12 * (number // 6))
                path = folder / f"{subject}-{walk}-{number:03d}.png"
                path.write_bytes(encode_png(mask))
    (tmp_path / "directions.csv").write_text("\n".join(labels) + "\n")
    return tmp_path
