"""What the README shows runs as it stands there, and the commands it names are there."""

import os
import re
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from mcnlab.synthetic.crossings import make_crossings

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text()
SNIPPETS = re.findall(r"^```python\n(.*?)^```", README, flags=re.MULTILINE | re.DOTALL)


def write_boxes(path):
    """boxes.csv: people who cross a square, as a detector would box them."""
    make_crossings(people=20, seconds=14, frame_rate=30).boxes.to_csv(path, index=False)


def write_hall(path):
    """hall.mp4: three walkers in striped clothes on a grainy floor, ten seconds."""
    rng = np.random.default_rng(0)
    floor = cv2.GaussianBlur(rng.normal(110, 60, (360, 640)), (0, 0), 1.5)
    cloth = np.tile(np.repeat([210.0, 30.0], 6), 6)[:70, None] * np.ones(22)
    size = floor.shape[::-1]
    film = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"mp4v"), 10.0, size)
    assert film.isOpened()
    for number in range(100):
        frame = floor + rng.normal(0, 2, floor.shape)
        for row, start, pace in ((200, -40, 10), (250, 660, -10), (290, -200, 9)):
            left = start + pace * number
            if 0 <= left <= size[0] - 22:
                frame[row - 70 : row, left : left + 22] = cloth
        film.write(cv2.cvtColor(np.clip(frame, 0, 255).astype(np.uint8), cv2.COLOR_GRAY2BGR))
    film.release()


MADE = {"boxes.csv": write_boxes, "hall.mp4": write_hall}


def run(snippets, folder):
    """What snippets print, run one after the other by a Python of their own in a folder."""
    paths = [str(ROOT), os.environ.get("PYTHONPATH", "")]
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", "\n".join(snippets)],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("number", range(len(SNIPPETS)))
def test_every_snippet_runs(number, tmp_path):
    snippet = SNIPPETS[number]
    # A snippet that speaks of `mine` goes on where the one before it ended.
    goes_on = "mine" in snippet and "mine =" not in snippet
    snippets = [*([SNIPPETS[number - 1]] if goes_on else []), snippet]
    for name, write in MADE.items():
        if any(name in text for text in snippets):
            write(tmp_path / name)
    assert run(snippets, tmp_path).strip()


def test_every_make_command_is_a_rule_of_the_makefile():
    rules = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(), flags=re.MULTILINE))
    named = set(re.findall(r"`make ([a-z]+)|^make ([a-z]+)", README, flags=re.MULTILINE))
    assert {one or other for one, other in named} <= rules
    assert {"reproduce", "test", "lab", "bench", "docs", "notebooks"} <= rules


def test_every_command_of_the_package_is_there():
    named = set(re.findall(r"`python -m mcnlab (\w+)", README))
    said = subprocess.run(
        [sys.executable, "-m", "mcnlab", "--help"],
        cwd=ROOT,
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    commands = set(re.search(r"\{([\w,]+)\}", said)[1].split(","))
    assert named
    assert named <= commands


def test_every_linked_file_is_there():
    for target in re.findall(r"\]\(([^)#:]+)\)", README):
        assert (ROOT / target).exists(), target


def test_the_map_names_the_rooms_that_there_are():
    named = set(re.findall(r"`(\w+)`", README[README.index("| room |") : README.index("Beneath")]))
    assert named == {path.parent.name for path in ROOT.glob("mcnlab/*/__init__.py")}
