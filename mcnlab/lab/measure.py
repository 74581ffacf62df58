"""Measuring recordings into the tables that are bundled: ``python -m mcnlab measure``."""

import os
from pathlib import Path
from typing import Final

import pandas as pd

from mcnlab.datasets import casia, motchallenge, pets
from mcnlab.datasets.catalogue import MOTCHALLENGE, TUD
from mcnlab.datasets.kept import write_tables
from mcnlab.errors import DatasetError
from mcnlab.files import sha256_of, write_whole
from mcnlab.occlusion.benchmark import compare_sequences
from mcnlab.tables import SEQUENCE
from mcnlab.vision.recordings import TRACES, measure_casia_a
from mcnlab.walking.outdoors import HEADINGS, SPEEDS

# What is measured by `Kept.measure`, folder by folder.
KEPT: Final = {pets.PETS: (HEADINGS, SPEEDS["pets"], TRACES), TUD: (SPEEDS["tud"],)}

# Dataset and credit, for the notes of provenance.
NOTES: Final = {
    casia.NAME: (
        "CASIA Dataset A, silhouettes",
        "L. Wang, T. Tan, H. Ning and W. Hu, Silhouette analysis-based gait recognition for human "
        "identification, IEEE TPAMI 25(12), 2003",
    ),
    pets.PETS: (
        "PETS 2009 S2.L1 View 1: headings, speeds, traces of feet",
        "J. Ferryman and A. Shahrokni, PETS2009: Dataset and challenge, 2009; world positions "
        "from MOTChallenge 2015 (CC BY-NC-SA 3.0)",
    ),
    TUD: (
        "TUD-Stadtmitte: speeds",
        "M. Andriluka, S. Roth and B. Schiele, Monocular 3D pose estimation and tracking by "
        "detection, CVPR 2010; boxes and world positions from MOTChallenge 2015 "
        "(CC BY-NC-SA 3.0)",
    ),
    MOTCHALLENGE: (
        "MOTChallenge: forecasts of occlusion, and what came of them",
        "A. Milan, L. Leal-Taixé, I. Reid, S. Roth and K. Schindler, MOT16: A benchmark for "
        "multi-object tracking, 2016; L. Leal-Taixé, A. Milan, I. Reid, S. Roth and K. "
        "Schindler, MOTChallenge 2015, 2015 (CC BY-NC-SA 3.0)",
    ),
}


def measure_all(
    folder: str | os.PathLike, out: str | os.PathLike, *, progress: bool = False
) -> list[Path]:
    """Measure what lies in `folder` and write the tables that are bundled.

    Parameters
    ----------
    folder : path-like
        Laid out as ``MCNLAB_DATA``.
    out : path-like
        Gets ``casia-a/``, ``pets2009/``, ``tud-stadtmitte/`` and ``motchallenge/``, each with
        its tables and ``provenance.json``.
    progress : bool, optional
        Show a progress bar.

    Returns
    -------
    list of pathlib.Path
        The files written.

    Raises
    ------
    DatasetError
        When the folder holds none of these datasets, or a sequence is damaged.
    """
    folder, out = Path(folder), Path(out)
    written = []
    if (folder / casia.NAME / "silhouettes").is_dir():
        written += _write_casia_a(folder / casia.NAME, out / casia.NAME, progress=progress)
    for place, kept in KEPT.items():
        held = [one for one in kept if one.lies_in(folder)]
        tables = {
            f"{name}.csv.gz": table
            for one in held
            for name, table in zip(one.names, one.measured(folder), strict=True)
        }
        files = dict.fromkeys(path for one in held for path in one.files(folder))
        if tables:
            written += _write(out / place, tables, files, root=folder)
    if (folder / MOTCHALLENGE).is_dir():
        written += _write_pairs(folder / MOTCHALLENGE, out / MOTCHALLENGE)
    if not written:
        raise DatasetError(
            f"folder {str(folder)!r} holds neither {casia.NAME}/silhouettes nor "
            f"{pets.PETS}/PETS2009-S2L1.xml nor {MOTCHALLENGE}; name the folder that "
            "holds them."
        )
    return written


def _write(out, tables, files, *, root, **facts):
    """Write a dataset's tables with what is known of it and its files' checksum."""
    dataset, credit = NOTES[out.name]
    checksum = {"sha256 of the sources": sha256_of(files, root=root)}
    return write_tables(out, tables, {"dataset": dataset, "credit": credit, **facts, **checksum})


def _write_casia_a(folder, out, *, progress):
    recording = measure_casia_a(folder, progress=progress)
    images = [path for sequence in casia.find_sequences(folder) for path in sequence.paths]
    dataset, credit = NOTES[casia.NAME]
    facts = {
        "dataset": dataset,
        "credit": credit,
        "sequences": len(recording.sequences),
        "subjects": int(recording.subjects.nunique()),
        "frames": len(images),
        "left out": list(recording.problems),
        "sha256 of the images": sha256_of(images, root=folder),
    }
    written = write_tables(out, {"boxes.csv.gz": recording.boxes}, facts)
    labels = recording.directions.rename_axis(SEQUENCE).to_csv(lineterminator="\n")
    return [*written, write_whole(out / "directions.csv", labels)]


def _write_pairs(folder, out):
    """What forecasters said of the pairs in MOTChallenge sequences, without anybody's boxes."""
    tables, problems = compare_sequences(folder)
    if not tables:
        return []
    files = [path / "gt" / "gt.txt" for path in motchallenge.find_sequences(folder)]
    facts = {
        "sequences": [table["recording"].iloc[0] for table in tables],
        "left out": list(problems),
    }
    table = pd.concat(tables, ignore_index=True)
    return _write(out, {"pairs.csv.gz": table}, files, root=folder, **facts)
