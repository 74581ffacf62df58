"""What goes wrong when a walker is cut out of a picture, put into clean silhouettes.

Specks, holes, limbs that match the background, frames without any body, an obstacle in
front: each can be turned up by itself, on synthetic silhouettes or on recorded ones.
"""

from dataclasses import dataclass, replace
from typing import Final

import cv2
import numpy as np

from mcnlab.checks import require_count, require_kind, require_number
from mcnlab.errors import ArgumentError

# Where limbs are in the body's box: (left, top, right, bottom) as shares of its width and
# height.
LIMB_REGIONS: Final = {
    "left lower leg": (0.0, 0.72, 0.5, 1.0),
    "right lower leg": (0.5, 0.72, 1.0, 1.0),
    "left arm": (0.0, 0.20, 0.25, 0.55),
    "right arm": (0.75, 0.20, 1.0, 0.55),
}

# A component belongs to the body when it has at least this share of the largest one's area.
_BODY_PART: Final = 0.1


def _require_sizes(name, sizes):
    """Raise `ArgumentError` unless `sizes` is (least, greatest) in whole pixels."""
    if not isinstance(sizes, tuple | list) or len(sizes) != 2:
        raise ArgumentError(f"{name} is {sizes!r}; pass (least, greatest) in pixels.")
    least = require_count(f"{name}'s least", sizes[0], low=1)
    require_count(f"{name}'s greatest", sizes[1], low=least)


@dataclass(frozen=True)
class SegmentationNoise:
    """How much of which noise.

    Attributes
    ----------
    specks : float
        Mean number a frame of white blobs, anywhere in the frame.
    speck_size : (int, int)
        Least and greatest side of a speck, pixels.
    holes : float
        Mean number a frame of black blobs, centred on a pixel of the body.
    hole_size : (int, int)
        Least and greatest side of a hole, pixels.
    cut_limbs : int
        How many limbs of `LIMB_REGIONS` are cut away.  A limb is lost for one run of
        frames, as clothes match the background for as long as it is the same.
    cut_share : float
        How long that run is, as a share of the walk.
    missing : float
        Share of the frames that lose everything, rounded to whole frames.
    occluder : (int, int, int, int), optional
        Left, top, width, height in pixels of an obstacle that hides what is behind it.
    """

    specks: float = 0.0
    speck_size: tuple = (1, 4)
    holes: float = 0.0
    hole_size: tuple = (2, 6)
    cut_limbs: int = 0
    cut_share: float = 0.5
    missing: float = 0.0
    occluder: tuple | None = None

    def __post_init__(self) -> None:
        require_number("specks", self.specks, low=0, unit="specks a frame")
        require_number("holes", self.holes, low=0, unit="holes a frame")
        _require_sizes("speck_size", self.speck_size)
        _require_sizes("hole_size", self.hole_size)
        if require_count("cut_limbs", self.cut_limbs) > len(LIMB_REGIONS):
            raise ArgumentError(
                f"cut_limbs is {self.cut_limbs}; pass at most {len(LIMB_REGIONS)}, "
                "a body has no more to lose."
            )
        require_number("cut_share", self.cut_share, low=0, high=1)
        require_number("missing", self.missing, low=0, high=1)
        if self.occluder is not None:
            if not isinstance(self.occluder, tuple | list) or len(self.occluder) != 4:
                raise ArgumentError(
                    f"occluder is {self.occluder!r}; pass (left, top, width, height) in pixels."
                )
            for name, value, low in zip(
                ("left", "top", "width", "height"), self.occluder, (0, 0, 1, 1), strict=True
            ):
                require_count(f"occluder's {name}", value, low=low)

    def scaled(self, level: float) -> "SegmentationNoise":
        """The same kind of noise, more or less of it.

        Parameters
        ----------
        level : float
            Multiplies the numbers and shares, up to what is possible.  Sizes and the
            occluder stay as they are, except that 0 leaves no noise at all.

        Returns
        -------
        SegmentationNoise
        """
        require_number("level", level, low=0)
        return replace(
            self,
            specks=self.specks * level,
            holes=self.holes * level,
            cut_limbs=min(round(self.cut_limbs * level), len(LIMB_REGIONS)),
            missing=min(self.missing * level, 1.0),
            occluder=self.occluder if level > 0 else None,
        )


# About what the silhouettes of CASIA A show: a blob apart from the body in every other
# frame, and two holes in three frames.
CASIA_LIKE: Final = SegmentationNoise(specks=0.5, speck_size=(3, 8), holes=0.7, hole_size=(3, 8))


def add_noise(masks: np.ndarray, noise: SegmentationNoise, *, seed: int) -> np.ndarray:
    """Silhouettes with noise.

    Parameters
    ----------
    masks : ndarray of uint8, shape (n, height, width)
        One walk: 255 on the body, 0 elsewhere.
    noise : SegmentationNoise
    seed : int
        The same seed gives the same noise, and each kind of noise is the same whatever
        the others are.

    Returns
    -------
    ndarray of uint8, shape (n, height, width)
        A copy.

    Raises
    ------
    ArgumentError
        When `masks` is no stack of binary images, or is smaller than a speck, or the
        occluder is outside the frame.

    Examples
    --------
    >>> masks = np.zeros((2, 40, 30), np.uint8)
    >>> masks[:, 10:30, 10:20] = 255
    >>> noisy = add_noise(masks, SegmentationNoise(occluder=(0, 20, 30, 10)), seed=0)
    >>> [int((mask > 0).sum()) for mask in (masks[0], noisy[0])]
    [200, 100]
    """
    require_kind("noise", noise, SegmentationNoise, "a SegmentationNoise")
    require_count("seed", seed)
    _require_masks(masks)
    n, height, width = masks.shape
    if noise.specks > 0 and noise.speck_size[1] > min(height, width):
        raise ArgumentError(
            f"speck_size reaches {noise.speck_size[1]} pixels but masks are {width} × {height}; "
            "make the specks smaller."
        )
    holes, limbs, specks, missing = (
        np.random.default_rng(child) for child in np.random.SeedSequence(seed).spawn(4)
    )
    noisy = masks.copy()
    if noise.holes > 0 or noise.cut_limbs > 0:
        boxes = [_body_box(mask) for mask in masks]
        _make_holes(noisy, boxes, noise, holes)
        _cut_limbs(noisy, boxes, noise, limbs)
    _scatter_specks(noisy, noise, specks)
    if noise.occluder is not None:
        left, top, w, h = noise.occluder
        if left >= width or top >= height:
            raise ArgumentError(
                f"occluder begins at ({left}, {top}), outside masks of {width} × {height} pixels; "
                "move it into the frame."
            )
        noisy[:, top : top + h, left : left + w] = 0
    noisy[missing.permutation(n)[: round(noise.missing * n)]] = 0
    return noisy


def _require_masks(masks):
    """Raise `ArgumentError` unless `masks` is a stack of binary images."""
    if not isinstance(masks, np.ndarray) or masks.dtype != np.uint8 or masks.ndim != 3:
        held = getattr(masks, "dtype", type(masks).__name__)
        raise ArgumentError(
            f"masks is {held} of shape {np.shape(masks)}; "
            "pass a uint8 array of shape (n, height, width)."
        )
    if masks.size == 0:
        raise ArgumentError(f"masks has the shape {masks.shape}; pass at least one image.")
    # In eight bits 255 + 1 is 0, so one comparison finds every other value.
    if (masks + np.uint8(1)).max() > 1:
        raise ArgumentError("masks holds values other than 0 and 255; threshold it first.")


def _body_box(mask):
    """Box (x, y, w, h) of the body: of the largest component and those of similar area."""
    x, y, w, h = cv2.boundingRect(mask)
    if w == 0:
        return 0, 0, 0, 0
    parts = cv2.connectedComponentsWithStats(mask[y : y + h, x : x + w])[2][1:]
    parts = parts[parts[:, cv2.CC_STAT_AREA] >= _BODY_PART * parts[:, cv2.CC_STAT_AREA].max()]
    low = parts[:, :2].min(axis=0)
    high = (parts[:, :2] + parts[:, 2:4]).max(axis=0)
    return x + int(low[0]), y + int(low[1]), int(high[0] - low[0]), int(high[1] - low[1])


def _make_holes(masks, boxes, noise, rng):
    """Blacken blobs on the body, in place."""
    counts = rng.poisson(noise.holes, len(masks))
    least, greatest = noise.hole_size
    sizes = iter(rng.integers(least, greatest + 1, (int(counts.sum()), 2)))
    places = iter(rng.random(int(counts.sum())))
    for mask, (x, y, w, h), count in zip(masks, boxes, counts, strict=True):
        if count == 0:
            continue
        body = mask[y : y + h, x : x + w]
        on = np.flatnonzero(body)
        for _ in range(count):
            (high, wide), place = next(sizes), next(places)
            if len(on) == 0:
                continue
            row, column = divmod(int(on[int(place * len(on))]), w)
            top, left = max(row - high // 2, 0), max(column - wide // 2, 0)
            body[top : top + high, left : left + wide] = 0


def _cut_limbs(masks, boxes, noise, rng):
    """Blacken limbs during one run of frames each, in place."""
    # All limbs are drawn whatever the number, so that more cuts include the fewer.
    order = rng.permutation(len(LIMB_REGIONS))
    starts = rng.random(len(LIMB_REGIONS))
    length = round(noise.cut_share * len(masks))
    regions = list(LIMB_REGIONS.values())
    for index in order[: noise.cut_limbs]:
        left, top, right, bottom = regions[index]
        first = int(starts[index] * (len(masks) - length + 1))
        for mask, (x, y, w, h) in zip(
            masks[first : first + length], boxes[first : first + length], strict=True
        ):
            rows = slice(y + round(top * h), y + round(bottom * h))
            mask[rows, x + round(left * w) : x + round(right * w)] = 0


def _scatter_specks(masks, noise, rng):
    """Whiten blobs anywhere, in place."""
    counts = rng.poisson(noise.specks, len(masks))
    least, greatest = noise.speck_size
    total = int(counts.sum())
    sizes = rng.integers(least, greatest + 1, (total, 2))
    corners = (rng.random((total, 2)) * (np.array(masks.shape[1:]) - sizes + 1)).astype(int)
    frames = np.repeat(np.arange(len(masks)), counts)
    for frame, (top, left), (high, wide) in zip(frames, corners, sizes, strict=True):
        masks[frame, top : top + high, left : left + wide] = 255
