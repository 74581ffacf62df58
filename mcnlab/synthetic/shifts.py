"""Made pairs of frames whose flow is known exactly, where Middlebury's are not at hand."""

from types import MappingProxyType
from typing import Final, NamedTuple

import cv2
import numpy as np

from mcnlab.checks import require_choice, require_count
from mcnlab.errors import ArgumentError

_SCALES: Final = (1.5, 3, 6, 12, 24)  # pixels, the sizes of structure in the texture


class MadeMotion(NamedTuple):
    """Two frames and the true flow between them, as Middlebury's sequences have."""

    name: str
    first: np.ndarray  # uint8, shape (height, width)
    second: np.ndarray
    truth: np.ndarray  # float32, shape (height, width, 2): dx, dy in pixels


def _creeping(x, y):
    return np.full_like(x, 0.4), np.full_like(y, 0.3)


def _shifting(x, y):
    return np.full_like(x, 3.0), np.full_like(y, 2.0)


def _turning(x, y):
    # 2° about the middle, and 1 % towards the camera.
    cosine, sine = 1.01 * np.cos(np.radians(2)), 1.01 * np.sin(np.radians(2))
    return (cosine - 1) * x - sine * y, sine * x + (cosine - 1) * y


def _parting(x, y):
    # Two streams that pass each other, as walkers in a corridor do.
    return 2.0 * np.tanh(y / 12), np.zeros_like(y)


MOTIONS: Final = MappingProxyType(
    {"creeping": _creeping, "shifting": _shifting, "turning": _turning, "parting": _parting}
)


def make_motion(name: str, *, shape: tuple[int, int] = (240, 320), seed: int = 0) -> MadeMotion:
    """A textured picture, moved.

    Parameters
    ----------
    name : {"creeping", "shifting", "turning", "parting"}
        By (0.4, 0.3) pixels; by (3, 2) pixels; by 2° and 1 % about the middle; two streams
        of 2 pixels a frame past each other.
    shape : (int, int), optional
        Height and width, at least 16 pixels.
    seed : int, optional
        Of the texture.

    Returns
    -------
    MadeMotion
        The second frame at (x + dx, y + dy) shows what the first shows at (x, y).

    Raises
    ------
    ArgumentError
        When there is no such motion or the shape is too small.
    """
    require_choice("name", name, tuple(MOTIONS))
    from scipy.ndimage import map_coordinates

    if np.shape(shape) != (2,) or min(require_count("shape", side) for side in shape) < 16:
        raise ArgumentError(f"shape is {shape!r}; pass height and width, at least 16 pixels each.")
    height, width = shape
    rng = np.random.default_rng(require_count("seed", seed))
    # The texture reaches beyond the frame, so that nothing enters it from nowhere.
    margin = 16 + max(height, width) // 8
    picture = np.zeros((height + 2 * margin, width + 2 * margin))
    for size in _SCALES:
        noise = cv2.GaussianBlur(rng.standard_normal(picture.shape), (0, 0), size)
        picture += size**0.5 * noise / noise.std()
    picture = 255 * (picture - picture.min()) / np.ptp(picture)
    y, x = np.mgrid[:height, :width].astype(np.float64)
    dx, dy = MOTIONS[name](x - (width - 1) / 2, y - (height - 1) / 2)
    inner = (slice(margin, margin + height), slice(margin, margin + width))
    # The second frame is the picture; the first looks up where its pixels will be.
    # OpenCV's cubic kernel leans by up to 0.05 pixels; a spline of the fifth order does not.
    first = map_coordinates(picture, [y + dy + margin, x + dx + margin], order=5)
    first, second = (
        np.clip(np.rint(frame), 0, 255).astype(np.uint8) for frame in (first, picture[inner])
    )
    return MadeMotion(name, first, second, np.stack([dx, dy], axis=-1).astype(np.float32))
