"""Videos: any file that OpenCV opens, a folder of frames, or frames in memory.

A video is read lazily and can be read again; its frames are 8-bit, grey or blue-green-red.
"""

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from mcnlab.checks import require_count, require_number
from mcnlab.errors import ArgumentError, DatasetError

IMAGES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm", ".ppm")


@dataclass(frozen=True, eq=False)
class Video:
    """Frames from one camera; iterate over it, as often as you like, for grey frames.

    Attributes
    ----------
    name : str
    frame_rate : float
        Frames a second.
    width, height : int
        Pixels.
    n_frames : int
        As the container says; reading raises `DatasetError` when there are fewer.
    source : Path, tuple of Path, or ndarray
        The file, the frames' files, or the frames themselves.
    """

    name: str
    frame_rate: float
    width: int
    height: int
    n_frames: int
    source: object = field(repr=False)

    def __len__(self):
        return self.n_frames

    def __iter__(self):
        return self.frames()

    def frames(
        self, start: int = 0, stop: int | None = None, *, colour: bool = False
    ) -> Iterator[np.ndarray]:
        """Yield frames `start` to `stop` − 1, in order.

        Parameters
        ----------
        start : int, optional
        stop : int, optional
            To the end if not given.
        colour : bool, optional
            Frames of shape (height, width, 3), blue first, instead of (height, width).

        Yields
        ------
        ndarray of uint8

        Raises
        ------
        ArgumentError
            When `start` or `stop` lies outside the video.
        DatasetError
            When the video ends early, or a frame cannot be read or has another size.
        """
        start = require_count("start", start)
        stop = self.n_frames if stop is None else require_count("stop", stop)
        if not start < stop <= self.n_frames:
            raise ArgumentError(
                f"start is {start} and stop {stop}; pass start < stop ≤ {self.n_frames}, the "
                f"number of frames in {self.name}."
            )
        return self._read(start, stop, colour)

    def _read(self, start, stop, colour):
        if isinstance(self.source, Path):
            frames = _decode(self.source, start, stop, self.n_frames)
        elif isinstance(self.source, tuple):
            frames = map(_read_image, self.source[start:stop])
        else:
            frames = self.source[start:stop]
        for number, frame in enumerate(frames, start):
            if frame.shape[:2] != (self.height, self.width):
                raise DatasetError(
                    f"{self.name}: frame {number} is {frame.shape[1]}×{frame.shape[0]} pixels, the "
                    f"first one {self.width}×{self.height}; bring all frames to one size."
                )
            if colour and frame.ndim == 2:
                yield cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR)
            elif not colour and frame.ndim == 3:
                yield cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
            else:
                yield frame


def open_video(
    source: str | os.PathLike | np.ndarray,
    *,
    frame_rate: float | None = None,
    name: str | None = None,
) -> Video:
    """Open a video.

    Parameters
    ----------
    source : path-like or ndarray
        A file that OpenCV opens; a folder of images, taken in natural order (2 before 10);
        or frames of uint8, shape (n, height, width) or (n, height, width, 3).
    frame_rate : float, optional
        Frames a second; the container's word if not given.  A container may be wrong, and
        a folder or an array says nothing.
    name : str, optional
        The file's or folder's name if not given.

    Returns
    -------
    Video

    Raises
    ------
    DatasetError
        When it cannot be opened, or has fewer than two frames.
    ArgumentError
        When the frame rate is not given and not known, or an array is not of frames.

    Examples
    --------
    >>> video = open_video(np.zeros((3, 24, 32), np.uint8), frame_rate=25.0)
    >>> video.width, video.height, len(video)
    (32, 24, 3)
    """
    path: Any  # or what an array is called
    if isinstance(source, np.ndarray):
        if source.dtype != np.uint8 or source.ndim not in (3, 4) or 0 in source.shape:
            raise ArgumentError(
                f"source is an array of {source.dtype}, shape {source.shape}; pass 8-bit frames, "
                "shape (n, height, width) or (n, height, width, 3)."
            )
        if source.ndim == 4 and source.shape[3] != 3:
            raise ArgumentError(
                f"source has {source.shape[3]} colours; pass blue, green and red, or grey frames "
                "of shape (n, height, width)."
            )
        first, count, held, path = source[0], len(source), source, name or "video"
    else:
        try:
            path = Path(source)
        except TypeError as fault:
            raise ArgumentError(
                f"source is a {type(source).__name__}; pass a path or an array of frames."
            ) from fault
        if path.is_dir():
            held = tuple(sorted(_images_in(path), key=_natural))
            if not held:
                raise DatasetError(f"{path} holds no images ({', '.join(IMAGES)}).")
            first, count = _read_image(held[0]), len(held)
        else:
            first, count, rate = _probe(path)
            held = path
            frame_rate = rate if frame_rate is None else frame_rate
    if frame_rate is None:
        raise ArgumentError(f"frame_rate is not known for {path}; pass it in frames a second.")
    frame_rate = require_number("frame_rate", frame_rate, above=0, unit="frames a second")
    if count < 2:
        raise DatasetError(f"{path} has one frame; movement needs at least two.")
    height, width = first.shape[:2]
    return Video(name or Path(path).stem, frame_rate, width, height, count, held)


def _probe(path):
    """The first frame, the number of frames and the frame rate of a file."""
    if not path.is_file():
        raise DatasetError(f"{path} is missing; name a video file or a folder of frames.")
    capture = _capture(path)
    try:
        sound, first = capture.read()
        if not sound:
            raise DatasetError(f"{path} opens, but its first frame cannot be read; restore it.")
        count = capture.get(cv2.CAP_PROP_FRAME_COUNT)
        rate = capture.get(cv2.CAP_PROP_FPS)
        if not 1 <= count < 1e9:  # the container does not say: count
            count = 1
            while capture.grab():
                count += 1
    finally:
        capture.release()
    return first, int(count), rate if np.isfinite(rate) and rate > 0 else None


def _capture(path):
    try:
        capture = cv2.VideoCapture(str(path))
    except cv2.error as fault:
        raise DatasetError(f"{path} cannot be opened as a video: {fault}.") from fault
    if not capture.isOpened():
        raise DatasetError(f"{path} cannot be opened as a video; check its format, or restore it.")
    return capture


def _decode(path, start, stop, promised):
    """Frames of a file; those before `start` are passed over, as seeking is not exact."""
    capture = _capture(path)
    try:
        for number in range(stop):
            if not capture.grab():
                break
            if number >= start:
                sound, frame = capture.retrieve()
                if not sound:
                    break
                yield frame
        else:
            return
        raise DatasetError(
            f"{path} ends early: frame {number} of the {promised} it promises cannot be read; "
            "restore it, or cut it to the frames that can."
        )
    finally:
        capture.release()


def _images_in(folder):
    return [item for item in folder.iterdir() if item.suffix.lower() in IMAGES and item.is_file()]


def _natural(path):
    """Sort key in which frame 2 comes before frame 10."""
    return [int(part) if part.isdigit() else part for part in re.split(r"([0-9]+)", path.name)]


def _read_image(path):
    frame = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if frame is None:
        raise DatasetError(f"{path} is not an image that can be read; restore it.")
    return frame
