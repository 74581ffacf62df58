"""Middlebury's optical flow: pairs of frames with the true motion of every pixel.

S. Baker, D. Scharstein, J. P. Lewis, S. Roth, M. J. Black and R. Szeliski, "A database and
evaluation methodology for optical flow", Int. J. Computer Vision 92, 2011.  A folder holds
``<sequence>/frame10.png``, ``frame11.png`` and ``flow10.flo``; any sequences will do.
"""

import os
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from mcnlab.datasets.casia import check_png
from mcnlab.datasets.reading import reading
from mcnlab.errors import DatasetError

NAME: Final = "middlebury-flow"
UNKNOWN: Final = 1e9  # pixels; a longer component marks a pixel without truth
FIRST, SECOND, TRUTH = "frame10.png", "frame11.png", "flow10.flo"
_MAGIC: Final = b"PIEH"  # 202021.25 as a little-endian float32
_LONGEST: Final = 99_999  # pixels a side; what Middlebury's own reader accepts


@dataclass(frozen=True)
class FlowSequence:
    """One scene: two frames and the true flow between them.

    Attributes
    ----------
    name : str
        The folder's name.
    folder : pathlib.Path
    """

    name: str
    folder: Path

    def read(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Both frames and the truth.

        Returns
        -------
        first, second : ndarray of uint8, shape (height, width)
            Grey.
        truth : ndarray of float32, shape (height, width, 2)
            dx, dy in pixels; NaN where it is not known.

        Raises
        ------
        DatasetError
            When a file is missing or damaged, or their sizes differ.
        """
        first = _read_grey(self.folder / FIRST)
        second = _read_grey(self.folder / SECOND)
        truth = read_flo(self.folder / TRUTH)
        sizes = {first.shape, second.shape, truth.shape[:2]}
        if len(sizes) > 1:
            raise DatasetError(
                f"sequence {self.name}: {FIRST} is {_size(first)} pixels, {SECOND} "
                f"{_size(second)} and {TRUTH} {_size(truth)}; restore its files from the dataset."
            )
        return first, second, truth


def find_sequences(folder: str | os.PathLike) -> list[FlowSequence]:
    """The sequences lying in a Middlebury flow folder, ordered by name.

    Parameters
    ----------
    folder : path-like
        Holds ``<sequence>/frame10.png``, ``frame11.png`` and ``flow10.flo``; folders without
        any of the three are not looked at.

    Returns
    -------
    list of FlowSequence

    Raises
    ------
    DatasetError
        When the folder is missing, or no folder in it holds one of the three files, or
        one holds some of them only.
    """
    root = Path(folder)
    if not root.is_dir():
        raise DatasetError(
            f"folder {str(root)!r} is missing; pass the folder that holds <sequence>/{TRUTH}."
        )
    found = []
    for inner in sorted(path for path in root.iterdir() if path.is_dir()):
        missing = [name for name in (FIRST, SECOND, TRUTH) if not (inner / name).is_file()]
        if len(missing) == 3:
            continue
        if missing:
            raise DatasetError(
                f"sequence {inner.name} lacks {', '.join(missing)}; restore it or remove the "
                "folder."
            )
        found.append(FlowSequence(inner.name, inner))
    if not found:
        raise DatasetError(
            f"folder {str(root)!r} holds no sequences; expected <sequence>/{FIRST}, {SECOND} and "
            f"{TRUTH} in it."
        )
    return found


def read_flo(path: str | os.PathLike) -> np.ndarray:
    """A true flow in Middlebury's format.

    Parameters
    ----------
    path : path-like
        ``PIEH``, width and height as int32, then dx, dy of each pixel as float32, row by
        row; all little-endian.

    Returns
    -------
    ndarray of float32, shape (height, width, 2)
        dx, dy in pixels; both NaN where the truth is not known.

    Raises
    ------
    DatasetError
        When the file is missing, not of this format, or too short or long for its size.
    """
    path = Path(path)
    data = _read_bytes(path)
    if data[:4] != _MAGIC:
        raise DatasetError(f"{path} is not a flow file: it does not begin with 'PIEH'; restore it.")
    if len(data) < 12:
        raise DatasetError(f"{path} is truncated: it ends after {len(data)} bytes; restore it.")
    width, height = struct.unpack_from("<ii", data, 4)
    if not (0 < width <= _LONGEST and 0 < height <= _LONGEST):
        raise DatasetError(f"{path} says it is {width}×{height} pixels; restore it.")
    wanted = 12 + 8 * width * height
    if len(data) != wanted:
        fault = "is truncated" if len(data) < wanted else "is too long"
        raise DatasetError(
            f"{path} {fault}: {width}×{height} pixels take {wanted} bytes, it has {len(data)}; "
            "restore it."
        )
    flow = np.frombuffer(data, "<f4", offset=12).reshape(height, width, 2).astype(np.float32)
    flow[~(np.abs(flow) <= UNKNOWN).all(axis=-1)] = np.nan
    return flow


def _read_grey(path):
    data = _read_bytes(path)
    width, height = check_png(data, name=str(path))
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_GRAYSCALE)
    if image is None or image.shape != (height, width):
        raise DatasetError(f"{path} cannot be decoded as a PNG; restore it.")
    return image


def _read_bytes(path):
    with reading(path, "the dataset's file"):
        return path.read_bytes()


def _size(image):
    return f"{image.shape[1]}×{image.shape[0]}"
