"""Measuring recordings into the tables that are bundled: ``python -m mcnlab measure``."""

from pathlib import Path

import pandas as pd

from mcnlab.datasets import casia, motchallenge, pets
from mcnlab.datasets.catalogue import MOTCHALLENGE, TUD, pets_files, pets_video_files, tud_files
from mcnlab.datasets.kept import _write_tables
from mcnlab.errors import DatasetError
from mcnlab.files import sha256_of, write_whole
from mcnlab.occlusion.benchmark import compare_sequences
from mcnlab.tables import SEQUENCE
from mcnlab.vision.recordings import measure_casia_a, measure_pets2009_traces
from mcnlab.walking.outdoors import measure_pets2009, measure_pets2009_speeds, measure_tud_speeds


def measure_all(folder, out, *, progress=False):
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
        source = folder / casia.NAME
        recording = measure_casia_a(source, progress=progress)
        images = [path for sequence in casia.find_sequences(source) for path in sequence.paths]
        written += _write_tables(
            out / casia.NAME,
            {"boxes.csv.gz": recording.boxes},
            {
                "dataset": "CASIA Dataset A, silhouettes",
                "credit": "L. Wang, T. Tan, H. Ning and W. Hu, Silhouette analysis-based gait "
                "recognition for human identification, IEEE TPAMI 25(12), 2003",
                "sequences": len(recording.sequences),
                "subjects": int(recording.subjects.nunique()),
                "frames": len(images),
                "left out": list(recording.problems),
                "sha256 of the images": sha256_of(images, root=source),
            },
        )
        labels = recording.directions.rename_axis(SEQUENCE).to_csv(lineterminator="\n")
        written.append(write_whole(out / casia.NAME / "directions.csv", labels))
    tables, files = {}, []
    if all(path.is_file() for path in pets_files(folder)):
        tables["headings.csv.gz"] = measure_pets2009(folder)
        tables["speeds.csv.gz"] = measure_pets2009_speeds(folder)
        files += pets_files(folder)
    if all(path.is_file() for path in pets_video_files(folder)):
        tables["traces.csv.gz"], tables["feet.csv.gz"] = measure_pets2009_traces(folder)
        files += [path for path in pets_video_files(folder) if path not in files]
    if tables:
        written += _write_tables(
            out / pets.PETS,
            tables,
            {
                "dataset": "PETS 2009 S2.L1 View 1: headings, speeds, traces of feet",
                "credit": "J. Ferryman and A. Shahrokni, PETS2009: Dataset and challenge, 2009; "
                "world positions from MOTChallenge 2015 (CC BY-NC-SA 3.0)",
                "sha256 of the sources": sha256_of(files, root=folder),
            },
        )
    if all(path.is_file() for path in tud_files(folder)):
        written += _write_tables(
            out / TUD,
            {"speeds.csv.gz": measure_tud_speeds(folder)},
            {
                "dataset": "TUD-Stadtmitte: speeds",
                "credit": "M. Andriluka, S. Roth and B. Schiele, Monocular 3D pose estimation and "
                "tracking by detection, CVPR 2010; boxes and world positions from MOTChallenge "
                "2015 (CC BY-NC-SA 3.0)",
                "sha256 of the sources": sha256_of(tud_files(folder), root=folder),
            },
        )
    if (folder / MOTCHALLENGE).is_dir():
        written += _write_pairs(folder / MOTCHALLENGE, out / MOTCHALLENGE)
    if not written:
        raise DatasetError(
            f"folder {str(folder)!r} holds neither {casia.NAME}/silhouettes nor "
            f"{pets.PETS}/PETS2009-S2L1.xml nor {MOTCHALLENGE}; name the folder that "
            "holds them."
        )
    return written


def _write_pairs(folder, out):
    """What forecasters said of the pairs in MOTChallenge sequences, without anybody's boxes."""
    tables, problems = compare_sequences(folder)
    if not tables:
        return []
    paths = [path / "gt" / "gt.txt" for path in motchallenge.find_sequences(folder)]
    return _write_tables(
        out,
        {"pairs.csv.gz": pd.concat(tables, ignore_index=True)},
        {
            "dataset": "MOTChallenge: forecasts of occlusion, and what came of them",
            "credit": "A. Milan, L. Leal-Taixé, I. Reid, S. Roth and K. Schindler, MOT16: A "
            "benchmark for multi-object tracking, 2016; L. Leal-Taixé, A. Milan, I. Reid, S. Roth "
            "and K. Schindler, MOTChallenge 2015, 2015 (CC BY-NC-SA 3.0)",
            "sequences": [table["recording"].iloc[0] for table in tables],
            "left out": list(problems),
            "sha256 of the sources": sha256_of(paths, root=folder),
        },
    )
