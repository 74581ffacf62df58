"""Published trajectories of real people, as scenes.

Each reader gives metres on the ground and drops nothing in silence: what it left out stands
in the scene's ``problems``.  None of the files tells where the walls are, so the scenes have
none, and their area is what the traces cover with a margin.

References
----------
Jülich corridors: J. Zhang, W. Klingsch, A. Schadschneider and A. Seyfried, "Transitions in
pedestrian fundamental diagrams of straight corridors and T-junctions", J. Statistical
Mechanics, 2011; "Ordering in bidirectional pedestrian flows …", ibid., 2012.
ETH: S. Pellegrini, A. Ess, K. Schindler and L. van Gool, "You'll never walk alone", ICCV 2009.
UCY: A. Lerner, Y. Chrysanthou and D. Lischinski, "Crowds by example", Computer Graphics Forum
26(3), 2007.
Edinburgh: B. Majecka, "Statistical models of pedestrian behaviour in the Forum", MSc thesis,
University of Edinburgh, 2009.
"""

import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
import pandas as pd

from mcnlab.checks import require_all
from mcnlab.datasets.reading import read_numbers, reading
from mcnlab.datasets.scene import Scene, area_of
from mcnlab.errors import DatasetError, McnError
from mcnlab.tables import FRAME, TRACE, TRACE_COLUMNS, X, Y

JUELICH_FRAME_RATE: Final = 16.0  # frames a second
ETH_UCY_RATE: Final = 2.5  # annotated steps a second
EDINBURGH_FRAME_RATE: Final = 9.0  # frames a second, about: the capture rate varied
EDINBURGH_PIXEL: Final = 0.0247  # metres on the ground
EDINBURGH_HEIGHT: Final = 480  # rows of the image, counted from the top
SHORTEST: Final = 1.0  # seconds; an Edinburgh detection that lasted less is noise
FASTEST: Final = 8.0  # m/s; an Edinburgh track that goes faster has jumped to someone else
FARTHEST: Final = 1e4  # metres; a place beyond is damage or a wrong unit
_TRACK: Final = re.compile(r"TRACK\.R(\d+)\s*=\s*\[([^=]*?\])\s*\]")


class SceneFile(NamedTuple):
    """A trajectory file that lies in a data folder."""

    name: str  # the dataset's own, lower case
    path: Path
    reader: Callable[[Path], Scene]

    def read(self) -> Scene:
        """The scene; raises `DatasetError` when the file is damaged."""
        return self.reader(self.path)


def find_scenes(folder: str | os.PathLike) -> list[SceneFile]:
    """The trajectory files of a data folder, whichever there are.

    Parameters
    ----------
    folder : path-like
        Holds any of ``juelich-corridor/runs/*.txt``,
        ``juelich-corridor/two-cameras/*/*_combined_MB.txt``, ``eth-ucy/*/obsmat.txt`` and
        ``edinburgh/tracks.*.txt``.

    Returns
    -------
    list of SceneFile
        Sorted by name within each dataset; empty when there is none.

    Raises
    ------
    DatasetError
        When the folder does not exist.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise DatasetError(f"{folder} is not a folder; pass the folder that holds the datasets.")
    patterns = (
        ("juelich-corridor/runs/*.txt", read_juelich),
        ("juelich-corridor/two-cameras/*/*_combined_MB.txt", read_juelich),
        ("eth-ucy/*/obsmat.txt", read_eth_ucy),
        ("edinburgh/tracks.*.txt", read_edinburgh),
    )
    return [
        SceneFile(_name_of(path), path, reader)
        for pattern, reader in patterns
        for path in sorted(folder.glob(pattern))
    ]


def read_scenes(folder: str | os.PathLike) -> tuple[list[Scene], tuple[str, ...]]:
    """Read every trajectory file of a data folder; a damaged one is left out and named.

    Parameters
    ----------
    folder : path-like
        As in `find_scenes`.

    Returns
    -------
    scenes : list of Scene
    problems : tuple of str
        One sentence a file that could not be read.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder) / "juelich-corridor" / "runs" / "uo-1.txt"
    ...     path.parent.mkdir(parents=True)
    ...     _ = path.write_text("1 5 0 0 170\\n1 6 8 0 170")
    ...     scenes, problems = read_scenes(folder)
    >>> scenes[0].name, scenes[0].walkers, problems
    ('uo-1', ['1'], ())
    """
    scenes, problems = [], []
    for file in find_scenes(folder):
        try:
            scenes.append(file.read())
        except McnError as fault:
            problems.append(f"{file.name} is left out: {fault}")
    return scenes, tuple(problems)


def read_juelich(path: str | os.PathLike) -> Scene:
    """A run of the Jülich corridor experiments.

    The corridor's axis is y.  The places are those of the heads.  A run's name tells widths
    in centimetres: entrance, corridor and exit of a one-way run (``uo-100-180-180``), corridor
    and both entrances of a two-way run (``bo-360-050-050``).

    Parameters
    ----------
    path : path-like
        ``id frame x y z`` a line, centimetres, 16 frames a second; ``runs/*.txt`` or
        ``*_combined_MB.txt``.

    Returns
    -------
    Scene
        Named after the file.

    Raises
    ------
    DatasetError
        When the file is missing, is not such a table, or holds a person twice in a frame.
    """
    path = Path(path)
    values = read_numbers(path, {5: "id frame x y z"}, sep=r"\s+", comment="#")
    places = values[:, 2:4] / 100.0
    traces = _make_traces(path, who=values[:, 0], frame=values[:, 1], places=places)
    return _make_scene(path, traces, JUELICH_FRAME_RATE)


def read_eth_ucy(path: str | os.PathLike) -> Scene:
    """A scene of ETH or UCY.

    The rows come every few frames of the video: every 10th of 25 a second at the hotel and at
    Zara, every 6th of 15 a second at ETH, which is 2.5 a second each time.  Frames here count
    these steps, so that traces have no gaps and the frame rate is 2.5.

    Parameters
    ----------
    path : path-like
        The scene's folder or the ``obsmat.txt`` in it: ``frame id x z y vx vz vy`` a line,
        metres.

    Returns
    -------
    Scene
        Named after the folder.

    Raises
    ------
    DatasetError
        When the file is missing, is not such a table, holds a person twice in a frame, or
        its frame numbers do not step evenly.
    """
    path = Path(path)
    path = path if path.name == "obsmat.txt" else path / "obsmat.txt"
    layout = {8: "frame id x z y vx vz vy"}
    values = read_numbers(path, layout, sep=r"\s+", comment="#")
    traces = _make_traces(path, who=values[:, 1], frame=values[:, 0], places=values[:, [2, 4]])
    frame = traces[FRAME].to_numpy()
    same = traces[TRACE].to_numpy()[1:] == traces[TRACE].to_numpy()[:-1]
    gaps, count = np.unique(np.diff(frame)[same], return_counts=True)
    if len(gaps) == 0:
        raise DatasetError(f"{path} holds nobody for two frames; restore it from the dataset.")
    step = int(gaps[count.argmax()])
    uneven = (frame - frame.min()) % step != 0
    if uneven.any():
        raise DatasetError(
            f"{path} numbers most steps {step} frames apart, but not frame "
            f"{frame[np.argmax(uneven)]}; mend its frame numbers."
        )
    traces[FRAME] = (frame - frame.min()) // step
    return _make_scene(path, traces, ETH_UCY_RATE)


def read_edinburgh(path: str | os.PathLike) -> Scene:
    """A day of the Edinburgh Informatics Forum, seen from 23 m above.

    The tracks are a machine's and were never corrected.  Four rules, each counted in the
    scene's ``problems``: a track that breaks off or is empty is left out; of two detections of
    a track in one frame the first counts; a track that goes faster than 8 m/s from one
    detection to the next is cut there, for it has jumped to something else; what then lasts
    less than one second is dropped.

    Parameters
    ----------
    path : path-like
        ``TRACK.Rn=[[x y t];…];`` statements; pixels of 24.7 mm, rows counted from the top,
        about 9 frames a second.

    Returns
    -------
    Scene
        y points up the image.

    Raises
    ------
    DatasetError
        When the file is missing, holds no track, or a track is not rows of three numbers.
    """
    path = Path(path)
    with reading(path, "a file of tracks"):
        text = path.read_text(encoding="utf-8")
    tracks = _TRACK.findall(text)
    if not tracks:
        raise DatasetError(f"{path} holds no TRACK.Rn=[[x y t];…]; restore it from the dataset.")
    numbers = [int(number) for number, _ in tracks]
    if len(set(numbers)) != len(numbers):
        raise DatasetError(f"{path} holds a track number twice; keep one of each.")
    rows = [re.sub(r"[\[\]\s]+", " ", body).strip(" ;").split(";") for _, body in tracks]
    length = [len(row) for row in rows]
    with reading(path, "a file of tracks whose rows are three numbers, x y t"):
        values = np.array([place.split() for row in rows for place in row], dtype=float)
        values = values.reshape(sum(length), 3)
    remedy = "mend or drop that track"
    require_all(f"{path}: a number", values, np.isfinite(values), remedy, error=DatasetError)
    who = np.repeat(numbers, length)
    first = np.sort(np.unique(np.c_[who, values[:, 2]], axis=0, return_index=True)[1])
    who, values, repeated = who[first], values[first], len(who) - len(first)
    # Rows count from the top; the map's y goes up.
    places = np.c_[values[:, 0], EDINBURGH_HEIGHT - 1 - values[:, 1]] * EDINBURGH_PIXEL
    traces = _make_traces(path, who=who, frame=values[:, 2], places=places)
    traces, jumps = _cut_jumps(traces)
    span = traces.groupby(TRACE, sort=False)[FRAME].transform(
        lambda frame: frame.max() - frame.min()
    )
    lasting = span >= SHORTEST * EDINBURGH_FRAME_RATE
    short = traces.loc[~lasting, TRACE].nunique()
    if not lasting.any():
        raise DatasetError(f"{path} holds no track of {SHORTEST:g} s; restore it.")
    problems = [
        f"{path.name}: {count} {what}"
        for count, what in (
            (text.count("TRACK.R") - len(tracks), "tracks left out: empty or broken off"),
            (repeated, "detections left out: the track has another one in that frame"),
            (jumps, f"cuts where a track jumps faster than {FASTEST:g} m/s"),
            (short, f"tracks left out: shorter than {SHORTEST:g} s"),
        )
        if count
    ]
    traces = traces[lasting].reset_index(drop=True)
    return _make_scene(path, traces, EDINBURGH_FRAME_RATE, problems=tuple(problems))


def _name_of(path):
    """The dataset's own name of a trajectory file, lower case."""
    if path.name == "obsmat.txt":
        return path.resolve().parent.name.lower()
    if path.name.startswith("tracks."):
        return f"edinburgh-{path.stem.removeprefix('tracks.')}".lower()
    return path.stem.lower().removesuffix("_combined_mb")


def _make_scene(path, traces, frame_rate, *, problems=()):
    return Scene(
        name=_name_of(path),
        traces=traces,
        frame_rate=frame_rate,
        area=area_of(traces),
        source="published",
        problems=problems,
        # The parts of a track that was cut are one person's.
        people={name: name.split("-")[0] for name in traces[TRACE].unique() if "-" in name},
    )


def _make_traces(path, *, who, frame, places):
    """A trace table, ordered by person and frame; refuses what no recording can hold."""
    whole = (who == np.round(who)) & (frame == np.round(frame))
    sound = whole & (np.abs(places) < FARTHEST).all(axis=1) & (np.abs(frame) < 1e9)
    sound &= np.abs(who) < 1e9
    if not sound.all():
        row = int(np.flatnonzero(~sound)[0])
        raise DatasetError(
            f"{path}: person {who[row]:g} in frame {frame[row]:g} at {places[row, 0]:g}, "
            f"{places[row, 1]:g} m: numbers must be whole and places within a few kilometres; "
            "mend or drop it."
        )
    order = np.lexsort((frame, who))
    who, frame, places = who[order].astype(int), frame[order].astype(int), places[order]
    twice = (np.diff(who) == 0) & (np.diff(frame) == 0)
    if twice.any():
        row = int(np.argmax(twice))
        raise DatasetError(
            f"{path} holds person {who[row]} twice in frame {frame[row]}; keep one row of each."
        )
    columns = (who.astype(str), frame, places[:, 0], places[:, 1])
    return pd.DataFrame(dict(zip(TRACE_COLUMNS, columns, strict=True)))


def _cut_jumps(traces):
    """Cut traces where they go faster than anybody: the table and the number of cuts."""
    step = np.hypot(traces[X].diff(), traces[Y].diff()).to_numpy()[1:]
    seconds = traces[FRAME].diff().to_numpy()[1:] / EDINBURGH_FRAME_RATE
    name = traces[TRACE].to_numpy(dtype=object)
    cut = np.r_[False, (name[1:] == name[:-1]) & (step > FASTEST * seconds)]
    # The part's number within its track; part 0 keeps the track's name.
    part = pd.Series(cut).groupby(name, sort=False).cumsum().to_numpy()
    named = np.where(part == 0, name, name + "-" + part.astype(str).astype(object))
    return traces.assign(**{TRACE: named}), int(cut.sum())
