"""The data that every notebook starts from: measured anew, or what came with mcnlab.

With the environment variable ``MCNLAB_DATA`` naming a folder of recordings, whatever lies
there is measured in full.  Without it, the tables in ``data/`` stand in: measurements that
this package made of the same recordings (``python -m mcnlab measure``), whose images are
not ours to hand on.
"""

import os
from pathlib import Path
from typing import Any, Final

import pandas as pd

from mcnlab.datasets import casia, pets
from mcnlab.datasets.reading import reading
from mcnlab.errors import DatasetError

BUNDLED = Path(__file__).resolve().parents[2] / "data"
VARIABLE: Final = "MCNLAB_DATA"
TUD: Final = "tud-stadtmitte"
MOTCHALLENGE: Final = "motchallenge"


def data_folder() -> Path | None:
    """The folder that ``MCNLAB_DATA`` names, or None.

    Raises
    ------
    DatasetError
        When the variable names something that is not a folder.
    """
    value = os.environ.get(VARIABLE)
    if not value:
        return None
    folder = Path(value).expanduser()
    if not folder.is_dir():
        raise DatasetError(
            f"{VARIABLE} is {value!r}, which is not a folder; name one laid out as the README "
            "says, or unset it."
        )
    return folder


def dataset_folder(name: str, *, holds: str = "") -> Path | None:
    """A dataset's folder under ``MCNLAB_DATA``, or None where it, or what it `holds`, is not."""
    folder = data_folder()
    return folder / name if folder is not None and (folder / name / holds).is_dir() else None


def casia_a_folder() -> Path | None:
    """The folder of CASIA A silhouettes under ``MCNLAB_DATA``, or None."""
    return dataset_folder(casia.NAME, holds="silhouettes")


def read_table(path: str | os.PathLike, **options: Any) -> pd.DataFrame:
    """A CSV table, or `DatasetError` naming the file."""
    with reading(Path(path), "a table of those in the checkout's data/"):
        return pd.read_csv(path, **options)


def pets_files(folder: str | os.PathLike) -> list[Path]:
    """Boxes, calibration and world positions of PETS 2009 under a data folder."""
    folder = Path(folder)
    return [
        folder / pets.PETS / "PETS2009-S2L1.xml",
        folder / pets.PETS / "View_001.xml",
        folder / MOTCHALLENGE / "PETS09-S2L1" / "gt" / "gt.txt",
    ]


def tud_files(folder: str | os.PathLike) -> list[Path]:
    """Boxes with world positions, and the frame, of TUD-Stadtmitte under a data folder."""
    held = Path(folder) / MOTCHALLENGE / "TUD-Stadtmitte"
    return [held / "gt" / "gt.txt", held / "seqinfo.ini"]


def pets_video_files(folder: str | os.PathLike) -> list[Path]:
    """Video, calibration and world positions of PETS 2009 under a data folder."""
    folder = Path(folder)
    return [folder / pets.PETS / "vtest.mp4", *pets_files(folder)[1:]]
