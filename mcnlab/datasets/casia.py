"""CASIA Dataset A: silhouettes of people walking at 0°, 45° and 90° to the image plane.

L. Wang, T. Tan, H. Ning and W. Hu, "Silhouette analysis-based gait recognition for
human identification", IEEE TPAMI 25(12), 2003.  A folder holds
``silhouettes/<subject>/<walk>/<subject>-<walk>-NNN.png`` and ``directions.csv``; any
subset of subjects will do.  A sequence is named ``<subject>-<walk>`` here.
"""

import os
import re
import struct
import zlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mcnlab.checks import require_array
from mcnlab.datasets.reading import reading
from mcnlab.errors import DatasetError
from mcnlab.files import write_whole
from mcnlab.tables import DIRECTION, SEQUENCE, SUBJECT

NAME = "casia-a"
FRAME_WIDTH, FRAME_HEIGHT = 352, 240  # pixels
FRAME_RATE = 25.0  # frames a second
_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_FILE_NAME = re.compile(r".+-(\d+)\.png")


@dataclass(frozen=True)
class SilhouetteSequence:
    """One walk's image files, in frame order.

    Attributes
    ----------
    name : str
        ``<subject>-<walk>``.
    subject : str
    paths : tuple of pathlib.Path
    """

    name: str
    subject: str
    paths: tuple[Path, ...]

    def read(self) -> np.ndarray:
        """Every frame, shape (frames, 240, 352), uint8, 0 or 255; raises as `frames`."""
        return np.stack(list(self.frames()))

    def frames(self) -> Iterator[np.ndarray]:
        """Yield frame after frame.

        Yields
        ------
        ndarray, shape (240, 352), uint8
            0 or 255.

        Raises
        ------
        DatasetError
            At the end, when any file is damaged, of another size or not binary, or a
            frame number is missing; the message names every fault.  What was yielded
            before is then not to be used.
        """
        faults = list(numbering_faults(self.paths))
        for path in self.paths:
            try:
                yield read_silhouette(path)
            except DatasetError as fault:
                faults.append(str(fault))
        if faults:
            raise DatasetError(
                f"sequence {self.name}: " + " ".join(faults) + " The sequence is left out; "
                "restore its files from the dataset."
            )


def find_sequences(folder: str | os.PathLike) -> list[SilhouetteSequence]:
    """The sequences lying in a CASIA Dataset A folder, ordered by name.

    Parameters
    ----------
    folder : path-like
        Holds ``silhouettes/<subject>/<walk>/*.png``.

    Returns
    -------
    list of SilhouetteSequence

    Raises
    ------
    DatasetError
        When the folder is missing or holds no PNG two levels below ``silhouettes``.
    """
    root = Path(folder) / "silhouettes"
    if not root.is_dir():
        raise DatasetError(
            f"folder {str(folder)!r} has no 'silhouettes' folder; pass the folder that holds "
            "silhouettes/<subject>/<walk>/*.png."
        )
    found = []
    for walk in sorted(path for path in root.glob("*/*") if path.is_dir()):
        paths = sorted(walk.glob("*.png"), key=lambda path: (_frame_number(path) or 0, path.name))
        if paths:
            name = f"{walk.parent.name}-{walk.name}"
            found.append(SilhouetteSequence(name, walk.parent.name, tuple(paths)))
    if not found:
        raise DatasetError(
            f"folder {str(root)!r} holds no silhouettes; expected <subject>/<walk>/*.png in it."
        )
    return found


def read_silhouette(path: str | os.PathLike) -> np.ndarray:
    """One silhouette image, checked.

    Parameters
    ----------
    path : path-like
        An 8-bit PNG of 352×240 pixels, each 0 or 255.

    Returns
    -------
    ndarray, shape (240, 352), uint8

    Raises
    ------
    DatasetError
        When the file is missing, not a whole PNG, of another size or not binary.
    """
    # A path is parsed once, not once more for every frame.
    path = path if isinstance(path, Path) else Path(path)
    try:
        with path.open("rb", buffering=0) as file:
            data = file.read()
    except OSError as fault:
        raise DatasetError(f"{path.name} cannot be read ({fault.strerror}).") from fault
    width, height = check_png(data, name=path.name)
    if (width, height) != (FRAME_WIDTH, FRAME_HEIGHT):
        raise DatasetError(
            f"{path.name} is {width}×{height} pixels, not {FRAME_WIDTH}×{FRAME_HEIGHT}."
        )
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_GRAYSCALE)
    if image is None or image.shape != (height, width):
        raise DatasetError(f"{path.name} cannot be decoded as a PNG.")
    # The sum is 255 times the count just where every pixel but the black ones is white.
    if cv2.norm(image, cv2.NORM_L1) != 255 * cv2.countNonZero(image):
        grey = cv2.countNonZero(cv2.inRange(image, 1, 254))
        raise DatasetError(f"{path.name} has {grey} pixels that are neither 0 nor 255.")
    return image


def write_silhouettes(
    folder: str | os.PathLike, subject: str, walk: str, masks: Iterable[ArrayLike]
) -> Path:
    """Write one walk's masks the way the dataset keeps them.

    Parameters
    ----------
    folder : path-like
        Gets ``silhouettes/<subject>/<walk>/<subject>-<walk>-NNN.png``.
    subject, walk : str
    masks : array_like, shape (frames, 240, 352)
        0 or 255.

    Returns
    -------
    pathlib.Path
        The walk's folder.
    """
    place = Path(folder) / "silhouettes" / subject / walk
    for number, mask in enumerate(masks, start=1):
        data = cv2.imencode(".png", np.asarray(mask, np.uint8))[1].tobytes()
        write_whole(place / f"{subject}-{walk}-{number:03d}.png", data)
    return place


def check_png(data: bytes, *, name: str) -> tuple[int, int]:
    """Width and height of a whole, undamaged PNG.

    OpenCV decodes a truncated file in silence, its lower rows black; the checksums of
    the chunks tell.

    Parameters
    ----------
    data : bytes
    name : str
        The file's name, for the message.

    Returns
    -------
    tuple of int
        Width and height, pixels.

    Raises
    ------
    DatasetError
        When the data is not a PNG, is cut short, or a chunk's checksum is wrong.
    """
    if data[:8] != _SIGNATURE:
        raise DatasetError(f"{name} is not a PNG file.")
    size, position, kind = None, 8, b""
    while kind != b"IEND":
        if position + 12 > len(data):
            raise DatasetError(f"{name} is truncated: it ends after {len(data)} bytes.")
        length, kind = struct.unpack_from(">I4s", data, position)
        end = position + 8 + length
        if end + 4 > len(data):
            raise DatasetError(f"{name} is truncated: it ends after {len(data)} bytes.")
        if zlib.crc32(data[position + 4 : end]) != struct.unpack_from(">I", data, end)[0]:
            raise DatasetError(f"{name} is damaged: a chunk's checksum is wrong.")
        if kind == b"IHDR" and length >= 8:
            size = struct.unpack_from(">II", data, position + 8)
        position = end + 4
    if size is None:
        raise DatasetError(f"{name} is damaged: it has no header.")
    return size


def numbering_faults(paths: Iterable[Path]) -> Iterator[str]:
    """Sentences naming what is wrong with the frame numbers of files in order."""
    numbers = [_frame_number(path) for path in paths]
    for path, number in zip(paths, numbers, strict=True):
        if number is None:
            yield f"{path.name} has no frame number at the end of its name."
    known = sorted(number for number in numbers if number is not None)
    if known:
        missing = sorted(set(range(1, known[-1] + 1)) - set(known))
        if missing:
            yield f"frame(s) {', '.join(map(str, missing[:8]))} missing."
        if len(known) != len(set(known)):
            yield "a frame number occurs twice."


def read_directions(path: str | os.PathLike) -> pd.Series:
    """The true direction of each sequence.

    Parameters
    ----------
    path : path-like
        A CSV with the columns ``sequence, direction`` and, in the dataset's own file,
        ``subject``; then the sequence is ``<subject>-<sequence>``.

    Returns
    -------
    pandas.Series
        Directions 1 … 8, indexed by sequence.

    Raises
    ------
    DatasetError
        When the file cannot be read as such a table.
    """
    with reading(Path(path), "a table subject,sequence,direction", "mend it"):
        table = pd.read_csv(path)
        names = table[SEQUENCE].astype(str)
        if SUBJECT in table:
            names = table[SUBJECT].astype(str) + "-" + names
        values = require_array("direction", table[DIRECTION], dtype=int, low=-1e9, high=1e9)
    return pd.Series(values, index=pd.Index(names, name=SEQUENCE), name=DIRECTION)


def _frame_number(path):
    match = _FILE_NAME.fullmatch(path.name)
    return int(match[1]) if match else None
