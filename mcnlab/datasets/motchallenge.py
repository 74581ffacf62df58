"""People boxed by hand in the MOTChallenge benchmark's format.

A sequence is a folder that holds ``gt/gt.txt`` and ``seqinfo.ini``.  The truth comes in two
formats, told apart by what the file holds:

nine columns (MOT16, MOT17, MOT20)
    ``frame, id, left, top, width, height, conf, class, visibility``.  Class 1 is a pedestrian;
    the others are vehicles, static people, reflections and the like.  A class of −1 throughout
    means that the classes are not known: everyone counts.
ten columns (MOT15)
    ``frame, id, left, top, width, height, conf, X, Y, Z``, world metres, or −1 where they are
    not known.  Everyone is a pedestrian.

Some tools append a tenth column to the first format.  Ten columns are taken for that when every
row has a whole number of at least 1 for the class and a visibility from 0 to 1; no one's world
metres are like that.  In both formats rows with conf 0 are to be ignored.

Some of the cameras move: see `vision.camera_motion`.

References
----------
L. Leal-Taixé, A. Milan, I. Reid, S. Roth and K. Schindler, "MOTChallenge 2015: Towards a
benchmark for multi-target tracking", arXiv:1504.01942.
A. Milan, L. Leal-Taixé, I. Reid, S. Roth and K. Schindler, "MOT16: A benchmark for
multi-object tracking", arXiv:1603.00831.
P. Dendorfer et al., "MOT20: A benchmark for multi object tracking in crowded scenes",
arXiv:2003.09003.
"""

import configparser
import os
import re
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd

from mcnlab.datasets.reading import NUMBER, line_of, read_numbers, reading
from mcnlab.datasets.recording import Recording
from mcnlab.errors import DatasetError, McnError
from mcnlab.tables import (
    CX,
    CY,
    FRAME,
    FRAME_LIMIT,
    PIXEL_LIMIT,
    SEQUENCE,
    SUBJECT,
    WORLD_X,
    WORLD_Y,
    H,
    W,
    X,
    Y,
)

PEDESTRIAN: Final = 1  # of the classes of MOT16, MOT17 and MOT20
_FIELDS: Final = ("frame", "id", "left", "top", "width", "height", "conf")
_LAYOUTS: Final = {
    9: f"{', '.join(_FIELDS)}, class, visibility",
    10: f"{', '.join(_FIELDS)}, X, Y, Z",
}
_FRAME, _ID, _LEFT, _TOP, _WIDTH, _HEIGHT, _CONF, _CLASS, _VISIBILITY = range(9)
_WORLD_X, _WORLD_Y = 7, 8
_INFO: Final = ("frameRate", "imWidth", "imHeight")  # the keys of seqinfo.ini that are needed
FARTHEST: Final = 1e9  # metres
_ID_LIMIT: Final = 2.0**53  # beyond, whole numbers are rounded


def find_sequences(folder: str | os.PathLike) -> list[Path]:
    """The sequences of a folder whose truth is there.

    Parameters
    ----------
    folder : path-like
        Holds ``<NAME>/gt/gt.txt`` and ``<NAME>/seqinfo.ini``.

    Returns
    -------
    list of Path
        The sequences' folders, sorted; empty when there is none.  Folders without
        ``gt/gt.txt``, such as the benchmark's test sequences, are not among them;
        `read_sequences` names them.

    Raises
    ------
    DatasetError
        When the folder does not exist.
    """
    return [path for path in _folders(folder) if _truth_of(path).exists()]


def read_sequence(folder: str | os.PathLike) -> Recording:
    """The pedestrians of one sequence, as a recording of one camera.

    Boxes may reach beyond the frame; they are kept as annotated, in the file's own pixels
    (the benchmark counts them from 1).

    Parameters
    ----------
    folder : path-like
        Holds ``gt/gt.txt`` and ``seqinfo.ini``.

    Returns
    -------
    Recording
        Named after the folder, in lower case.  A sequence is a person, ordered by id; frames
        are those of the file, from 1.

    Raises
    ------
    DatasetError
        When a file is missing or damaged, or there is no pedestrian; the message names the
        line and the column.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     (Path(folder) / "gt").mkdir()
    ...     _ = (Path(folder) / "gt" / "gt.txt").write_text("1,7,10,20,30,40,1,1,1")
    ...     info = "[Sequence]\\nframeRate=30\\nimWidth=640\\nimHeight=480"
    ...     _ = (Path(folder) / "seqinfo.ini").write_text(info)
    ...     read_sequence(folder).boxes[["sequence", "frame", "x", "w"]].to_numpy().tolist()
    [['7', 1, 10.0, 30.0]]
    """
    folder = Path(folder)
    path = _truth_of(folder)
    values = read_numbers(path, _LAYOUTS)
    people = values[:, _CONF] > 0
    classes = _has_classes(values)
    if classes:
        people &= values[:, _CLASS] == PEDESTRIAN
    _check_rows(path, values, people, classes=classes)
    order = np.lexsort((values[:, _FRAME], values[:, _ID]))
    held = values[order[people[order]]]
    numbers, codes = np.unique(held[:, _ID], return_inverse=True)
    names = np.array([str(int(number)) for number in numbers], dtype=object)
    boxes = pd.DataFrame(
        {
            SEQUENCE: names[codes],
            SUBJECT: names[codes],
            FRAME: held[:, _FRAME].astype(np.int64),
            X: held[:, _LEFT],
            Y: held[:, _TOP],
            W: held[:, _WIDTH],
            H: held[:, _HEIGHT],
            CX: held[:, _LEFT] + held[:, _WIDTH] / 2,
            CY: held[:, _TOP] + held[:, _HEIGHT] / 2,
        }
    )
    frame_rate, width, height = _read_info(folder / "seqinfo.ini")
    # A folder given as "." has a name, too, once it is resolved.
    return Recording(folder.resolve().name.lower(), boxes, frame_rate, width, height)


def read_sequences(folder: str | os.PathLike) -> tuple[list[Recording], tuple[str, ...]]:
    """Read every sequence of a folder, each truth once.

    MOT17 holds each of its sequences three times, once for each public detector, with the same
    truth: of sequences with the same boxes the first is kept.

    Parameters
    ----------
    folder : path-like
        As in `find_sequences`.

    Returns
    -------
    recordings : list of Recording
        Sorted by folder.
    problems : tuple of str
        One sentence a folder that is left out: copies, damaged ones, ones without truth.

    Raises
    ------
    DatasetError
        When the folder does not exist.
    """
    recordings, problems, first, taken = [], [], {}, set()
    for path in _folders(folder):
        if not _truth_of(path).exists():
            problems.append(f"{path.name} is left out: it has no gt/gt.txt (a test sequence?).")
            continue
        try:
            recording = read_sequence(path)
        except McnError as fault:
            problems.append(f"{path.name} is left out: {fault}")
            continue
        key = _fingerprint(recording)
        if key in first:
            problems.append(f"{path.name} is left out: its boxes are those of {first[key]}.")
            continue
        if recording.name in taken:
            problems.append(f"{path.name} is left out: another is called {recording.name}, too.")
            continue
        first[key] = path.name
        taken.add(recording.name)
        recordings.append(recording)
    return recordings, tuple(problems)


def _folders(folder):
    """The folders in a folder, sorted by name; hidden ones are not looked at."""
    folder = Path(folder)
    if not folder.is_dir():
        raise DatasetError(
            f"{folder} is not a folder; pass the folder that holds the sequences' folders."
        )
    return sorted(
        path for path in folder.iterdir() if path.is_dir() and not path.name.startswith(".")
    )


def _truth_of(folder):
    return folder / "gt" / "gt.txt"


def _fingerprint(recording):
    """What two recordings share if and only if their boxes, people and clock are the same."""
    hashes = pd.util.hash_pandas_object(recording.boxes, index=False).to_numpy()
    size = recording.frame_rate, recording.frame_width, recording.frame_height
    return size, hashes.tobytes()


def _has_classes(values):
    """Whether the eighth column is a class: see the formats above."""
    kind, visibility = values[:, _CLASS], values[:, _VISIBILITY]
    if values.shape[1] == 9:
        return not (kind == -1).all()
    seen = (visibility >= 0) & (visibility <= 1)
    return bool((seen & (kind >= 1) & (kind == np.round(kind))).all())


def _check_rows(path, values, people, *, classes):
    """Raise on the first row that is no box; sizes and repeats matter for pedestrians only."""
    small = people & (values[:, [_WIDTH, _HEIGHT]] <= 0).T
    vast = np.abs(values[:, _LEFT : _HEIGHT + 1]) > PIXEL_LIMIT
    faults = [
        *((_LEFT + k, vast[:, k], "no image is that large") for k in range(4)),
        (_WIDTH, small[0], "a width is positive"),
        (_HEIGHT, small[1], "a height is positive"),
    ]
    if classes:
        kind = values[:, _CLASS]
        faults.append((_CLASS, kind != np.round(kind), "a class is a whole number"))
    _refuse(path, values, faults)
    if not people.any():
        raise DatasetError(
            f"{path} holds no pedestrian: no row with conf above 0"
            + (f" and class {PEDESTRIAN}" if classes else "")
            + "; restore it from the dataset."
        )
    _check_once(path, values, people)


def _refuse(path, values, faults):
    """Raise on the first row whose frame or id is none, or that one of the faults names.

    A fault is a column, which rows are wrong there, and why.
    """
    frame, number = values[:, _FRAME], values[:, _ID]
    faults = [
        (_FRAME, frame != np.round(frame), "frames are whole numbers"),
        (_FRAME, frame <= 0, "frames count from 1"),
        (_FRAME, frame > FRAME_LIMIT, "no video is that long"),
        (_ID, number != np.round(number), "ids are whole numbers"),
        (_ID, np.abs(number) >= _ID_LIMIT, "ids are smaller"),
        *faults,
    ]
    for column, wrong, reason in faults:
        if wrong.any():
            row = int(wrong.argmax())
            name = _LAYOUTS[values.shape[1]].split(", ")[column]
            raise DatasetError(
                f"{path} line {line_of(path, row)}, column {column + 1} ({name}) holds "
                f"{values[row, column]:.17g}; {reason}. Mend or drop that line."
            )


def _check_once(path, values, people):
    """Raise where one of the people has two rows in a frame."""
    frame, number = values[:, _FRAME], values[:, _ID]
    rows = np.flatnonzero(people)
    rows = rows[np.lexsort((rows, frame[rows], number[rows]))]
    again = (np.diff(frame[rows]) == 0) & (np.diff(number[rows]) == 0)
    if again.any():
        at = int(rows[1:][again].min())
        raise DatasetError(
            f"{path} line {line_of(path, at)} has person {number[at]:.0f} a second time in frame "
            f"{frame[at]:.0f}; keep one box a person and frame."
        )


def _read_info(path):
    """Frame rate, width and height from a seqinfo.ini."""
    parser = configparser.ConfigParser(interpolation=None, strict=False)
    with reading(path, "a seqinfo.ini", f"give it {', '.join(_INFO)} under [Sequence]"):
        parser.read_string(path.read_text(encoding="utf-8-sig"))
        section = parser["Sequence"]
    found = []
    for key in _INFO:
        text = section.get(key)
        if text is None:
            raise DatasetError(f"{path} lacks the key {key}; add it under [Sequence].")
        sound = NUMBER.fullmatch(text.encode()) and 0 < float(text) <= PIXEL_LIMIT
        whole = sound and (key == "frameRate" or float(text).is_integer())
        if not whole:
            kind = "number" if key == "frameRate" else "whole number"
            raise DatasetError(f"{path} has {key} = {text!r}; put a positive {kind} there.")
        found.append(float(text))
    frame_rate, width, height = found
    return frame_rate, int(width), int(height)


def read_mot_world(path: str | os.PathLike) -> pd.DataFrame:
    """World positions of a MOTChallenge ground-truth file that ends in metres (MOT15).

    Parameters
    ----------
    path : path-like
        ``frame, id, left, top, width, height, conf, X, Y, Z`` a line, frames from 1.

    Returns
    -------
    pandas.DataFrame
        ``sequence, frame, world_x, world_y``; frames from 0.

    Raises
    ------
    DatasetError
        When the file is missing, a line is not such a line, or a number is not finite.
    """
    path = Path(path)
    values = read_numbers(path, _LAYOUTS)
    far = np.abs(values[:, [_WORLD_X, _WORLD_Y]]) > FARTHEST
    _refuse(path, values, [(_WORLD_X + k, far[:, k], "no place is that far") for k in range(2)])
    _check_once(path, values, np.ones(len(values), bool))
    return pd.DataFrame(
        {
            SEQUENCE: values[:, _ID].astype(int).astype(str),
            FRAME: values[:, _FRAME].astype(int) - 1,
            WORLD_X: values[:, _WORLD_X],
            WORLD_Y: values[:, _WORLD_Y],
        }
    )


# Videos of MOT15 that MOT16 and MOT17 have annotated anew: eight of equal length.
_ANEW = {
    "venice-1": "mot-01",
    "venice-2": "mot-02",
    "eth-pedcross2": "mot-05",
    "eth-linthescher": "mot-06",
    "adl-rundle-1": "mot-07",
    "adl-rundle-3": "mot-08",
    "adl-rundle-6": "mot-09",
    "adl-rundle-8": "mot-10",
}

# The eight videos of MOT20 show three scenes.
_CROWDS = {1: "hall", 2: "hall", 7: "hall", 3: "night", 4: "night", 5: "night", 6: "day", 8: "day"}


def place_of(recording: str) -> str:
    """What recordings that may show the same people have in common, as a name.

    MOT16-02, MOT17-02-DPM, -FRCNN and -SDP and MOT15's Venice-2 are one video; MOT20 has eight
    videos of three scenes; all of PETS 2009 was acted on one campus by the same people.

    Parameters
    ----------
    recording : str
        A recording's name, in any case.
    """
    name = str(recording).lower()
    if found := re.fullmatch(r"mot1[67](?:det)?-0*(\d+)(-.*)?", name):
        return f"mot-{int(found[1]):02d}"
    if found := re.fullmatch(r"mot20(?:det)?-0*(\d+)(-.*)?", name):
        number = int(found[1])
        return f"mot20-{_CROWDS.get(number, number)}"
    if re.match(r"pets(20)?09", name):
        return "pets-2009"
    return _ANEW.get(name, name)
