"""Headings and speeds of real people outdoors, against where they truly walked."""

from pathlib import Path

import pandas as pd

from mcnlab.cameras.horizon import find_place
from mcnlab.checks import require_choice
from mcnlab.compass import turn_between
from mcnlab.datasets import motchallenge, pets
from mcnlab.datasets.catalogue import TUD, pets_files, tud_files
from mcnlab.datasets.kept import Kept
from mcnlab.tables import FRAME, SEQUENCE
from mcnlab.walking.heading import measure_headings
from mcnlab.walking.speed import compare_speeds
from mcnlab.walking.truth import true_headings

PETS_WINDOW = 7  # frames, one second
# Pixels, 1.2 frame widths: nothing is published.  Sideways speed does not need it.
TUD_FOCAL_LENGTH = 768.0
SPEED_SECONDS = (0.5, 1.0, 2.0)  # windows of the speed tables


def pets2009_headings() -> pd.DataFrame:
    """Headings of the people of PETS 2009, from boxes and from world truth.

    Returns
    -------
    pandas.DataFrame
        One row a one-second window (`heading.measure_headings`) with ``true_sight``
        (degrees), ``true_speed`` (m/s) and ``error`` (degrees).

    Raises
    ------
    DatasetError
        When files are missing or damaged.
    """
    return HEADINGS.tables()[0]


def measure_pets2009(folder: Path) -> pd.DataFrame:
    """Measure the headings of PETS 2009 from the recordings in `folder`."""
    boxes, calibration, positions = pets_files(folder)
    recording = pets.read_pets(boxes.parent)
    place = pets.read_tsai_place(calibration)
    world = motchallenge.read_mot_world(positions)
    headings = measure_headings(
        recording, focal_length=pets.PETS_FOCAL_LENGTH, window=PETS_WINDOW, shared="recording"
    )
    truth = true_headings(
        world, headings, place=place, window=PETS_WINDOW, frame_rate=recording.frame_rate
    )
    table = headings.join(truth)
    table["error"] = turn_between(table["sight"], table["true_sight"])
    return _as_kept(table)


def apparent_speeds(name: str) -> pd.DataFrame:
    """Apparent, relative and true speed of real people, window by window.

    Parameters
    ----------
    name : {"pets", "tud"}
        PETS 2009 S2.L1, View 1, or TUD-Stadtmitte.

    Returns
    -------
    pandas.DataFrame
        As of `speed.compare_speeds`, for windows of `SPEED_SECONDS`.

    Raises
    ------
    McnError
        When there is no such name, or files are missing or damaged.
    """
    return SPEEDS[require_choice("name", name, tuple(SPEEDS))].tables()[0]


def measure_pets2009_speeds(folder: Path) -> pd.DataFrame:
    """Measure the speeds of PETS 2009 from the recordings in `folder`."""
    boxes, calibration, positions = pets_files(folder)
    table = compare_speeds(
        pets.read_pets(boxes.parent),
        motchallenge.read_mot_world(positions),
        place=pets.read_tsai_place(calibration),
        focal_length=pets.PETS_FOCAL_LENGTH,
        seconds=SPEED_SECONDS,
    )
    return _as_kept(table)


def measure_tud_speeds(folder: Path) -> pd.DataFrame:
    """Measure the speeds of TUD-Stadtmitte from the recordings in `folder`."""
    positions = tud_files(folder)[0]
    recording = motchallenge.read_sequence(positions.parents[1])
    world = motchallenge.read_mot_world(positions)
    world[FRAME] += 1  # boxes count from 1, as their file does
    table = compare_speeds(
        recording,
        world,
        place=find_place(recording, world),
        focal_length=TUD_FOCAL_LENGTH,
        seconds=SPEED_SECONDS,
    )
    return _as_kept(table)


def _as_kept(table):
    """Measures rounded as they are kept, so that the bundled table and a new one agree."""
    places = dict.fromkeys(table.select_dtypes(float).columns, 4)
    return table.round(places | {"share": 6})


HEADINGS = Kept(pets.PETS, ("headings",), pets_files, measure_pets2009, text=(SEQUENCE,))
SPEEDS = {
    "pets": Kept(pets.PETS, ("speeds",), pets_files, measure_pets2009_speeds, text=(SEQUENCE,)),
    "tud": Kept(TUD, ("speeds",), tud_files, measure_tud_speeds, text=(SEQUENCE,)),
}
