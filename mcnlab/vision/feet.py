"""Who moves in a video, and where their feet are in the image.

The thesis's chain (section 2.3, Figure 2.8): optical flow → binary silhouettes → the bottom
of each moving silhouette.  Background subtraction stands beside the flow, because that is
what one would pick today.

Silhouettes of people who walk together melt into one, and one person's falls to pieces; so
a silhouette is not taken for a person.  How tall a person appears at each place is known
from the calibration, or learnt from the silhouettes themselves, and people are laid over the
foreground one by one until it is explained.

References
----------
B. K. P. Horn and B. G. Schunck, "Determining optical flow", Artificial Intelligence 17, 1981.
Z. Zivkovic, "Improved adaptive Gaussian mixture model for background subtraction", ICPR 2004.
F. Fleuret et al., "Multicamera people tracking with a probabilistic occupancy map", IEEE
TPAMI 30(2), 2008: people as boxes of known size that explain the foreground.
"""

from collections.abc import Callable, Iterable, Iterator
from inspect import signature
from typing import Any, NamedTuple

import cv2
import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from mcnlab.checks import (
    require_array,
    require_choice,
    require_count,
    require_kind,
    require_number,
)
from mcnlab.datasets.video import Video
from mcnlab.errors import ArgumentError, McnError, SilhouetteError
from mcnlab.regression import fit_lines_robust
from mcnlab.tables import FRAME, H, W, X, Y
from mcnlab.vision import flow

BACKGROUND = "background"
METHODS = (BACKGROUND, *flow.METHODS)
IMAGE_X, IMAGE_Y = "image_x", "image_y"  # pixels, of a foot on the ground
# Flow that keeps to people's outlines: few iterations, in each of which it spreads by a pixel.
SHARP = {"horn-schunck-plain": {"alpha": 25.0, "iterations": 5}}
SHADOW = 127  # OpenCV's mark for a shadow in a MOG2 mask
SMALLEST = 8.0  # pixels; a person less tall is not looked for
COARSEST = 0.25  # metres a pixel; where the ground is seen less finely, feet are not looked for
# A person in a silhouette image is a box as wide as the trunk: arms and legs swing beyond it
# and are cleared away with the person.  Set on the first half of PETS 2009 S2.L1, like the
# defaults of `flow_masks` and `link`.
TRUNK = 0.49  # metres
SPAN = 1.5  # trunk widths that belong to a person
LEAST_FILL = 0.45  # share of the trunk's box that must be foreground
LEAST_NEW = 0.25  # share that must not be explained by others
STRIDE = 2  # pixels between the places tried


def background_masks(
    video: Video,
    *,
    threshold: float = 16.0,
    shadow: float = 0.5,
    learning_rate: float = 0.0005,
    warm_up: int | None = None,
) -> Iterator[np.ndarray]:
    """Moving silhouettes by background subtraction (MOG2), shadows left out.

    The video is run through twice: first to learn the background, from every third frame,
    then to subtract it.  So people who are there from the start are seen, too.

    Parameters
    ----------
    video : Video
        Or anything with its ``n_frames`` and ``frames``.
    threshold : float, optional
        Squared distance, in variances, beyond which a pixel is foreground.
    shadow : float, optional
        A pixel that keeps its hue and at least this share of its brightness is taken for
        a shadow; 1 for no shadows, if people in grey are lost.
    learning_rate : float, optional
        Share of the background renewed each frame in the second run: small, so that people
        may rest without becoming background.
    warm_up : int, optional
        Frames to learn from; all if not given.

    Yields
    ------
    ndarray of uint8, shape (height, width)
        255 where something moves, 0 elsewhere; one a frame.
    """
    threshold = require_number("threshold", threshold, above=0)
    shadow = require_number("shadow", shadow, above=0, high=1)
    learning_rate = require_number("learning_rate", learning_rate, low=0, high=1)
    stop = video.n_frames if warm_up is None else require_count("warm_up", warm_up, low=1)
    return _subtract(video, threshold, shadow, learning_rate, min(stop, video.n_frames))


def _subtract(video, threshold, shadow, learning_rate, stop):
    model = cv2.createBackgroundSubtractorMOG2(varThreshold=threshold, detectShadows=shadow < 1)
    model.setShadowThreshold(shadow)
    for number, frame in enumerate(video.frames(0, stop, colour=True)):
        if number % 3 == 0:
            model.apply(frame)
    for frame in video.frames(colour=True):
        mask = np.uint8(255) * (model.apply(frame, learningRate=learning_rate) > SHADOW)
        mask = cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((2, 2), np.uint8))
        yield cv2.morphologyEx(mask, cv2.MORPH_CLOSE, _disc(3))


def flow_masks(
    video: Video,
    *,
    method: str = "horn-schunck-plain",
    speed: float = 0.5,
    closing: int = 5,
    **options: Any,
) -> Iterator[np.ndarray]:
    """Moving silhouettes by optical flow: the thesis's way (section 2.3, Figure 2.8).

    A frame's flow is that to the next frame, the last one's that to the one before.  Who
    stands still has none and is not seen.

    The default is Horn and Schunck's method of 1981 with the few iterations of `SHARP`:
    flow spreads by a pixel in each, beyond the people's outlines and over the ground before
    their feet.  The other methods have the defaults of `flow`; "horn-schunck" is the pyramid.

    Parameters
    ----------
    video : Video
        Or anything with its ``frames``.
    method : str, optional
        One of `flow.METHODS`.
    speed : float, optional
        The least speed that counts as motion, pixels a frame of the video.
    closing : int, optional
        Diameter of the disc that closes gaps in the binary image, pixels; 0 for none.
    **options
        For the method, such as ``alpha`` and ``iterations``; they go before those in `SHARP`.

    Yields
    ------
    ndarray of uint8, shape (height, width)
        255 where something moves, 0 elsewhere; one a frame.
    """
    require_choice("method", method, tuple(flow.METHODS))
    speed = require_number("speed", speed, above=0, unit="pixels a frame")
    closing = require_count("closing", closing)
    if video.n_frames < 2:
        raise ArgumentError("video has one frame; movement needs at least two.")
    check_mask_options(method, options)
    options = {**SHARP.get(method, {}), **options}
    return _threshold_flow(video, flow.METHODS[method], speed, closing, options)


def _threshold_flow(video, method, speed, closing, options):
    def mask_of(first, second):
        mask = flow.moving_mask(method(first, second, **options), speed=speed)
        return cv2.morphologyEx(mask, cv2.MORPH_CLOSE, _disc(closing)) if closing > 1 else mask

    frames = video.frames()
    earlier = next(frames)
    for frame in frames:
        yield mask_of(earlier, frame)
        earlier, before = frame, earlier
    yield mask_of(earlier, before)


def moving_masks(video: Video, *, method: str = BACKGROUND, **options: Any) -> Iterator[np.ndarray]:
    """`background_masks` or `flow_masks`, by the name of the method, one of `METHODS`."""
    if not hasattr(video, "frames") or not hasattr(video, "n_frames"):
        raise ArgumentError(f"video is a {type(video).__name__}; pass what open_video gives.")
    check_mask_options(method, options)
    if method == BACKGROUND:
        return background_masks(video, **options)
    return flow_masks(video, method=method, **options)


def check_mask_options(method: str, options: Iterable[str]) -> None:
    """Raise `ArgumentError` unless `method` is one of `METHODS` and has all of the options."""
    require_choice("method", method, METHODS)
    if method == BACKGROUND:
        allowed = list(signature(background_masks).parameters)[1:]  # after the video
    else:
        found_by = list(signature(flow.METHODS[method]).parameters)[2:]  # after the two frames
        allowed = ["speed", "closing", *found_by]
    bogus = [name for name in options if name not in allowed]
    if bogus:
        raise ArgumentError(
            f"{method!r} has no option {bogus[0]!r}; pass any of {', '.join(allowed)}."
        )


def _disc(diameter):
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (diameter, diameter))


class PersonSizes(NamedTuple):
    """How large a person appears whose feet are at each pixel; 0 where none are looked for."""

    tall: np.ndarray  # (rows, columns) pixels
    wide: np.ndarray  # (rows, columns) pixels, of the trunk


def trunk_widths(
    shape: tuple[int, int], to_ground: Callable, *, coarsest: float = COARSEST
) -> np.ndarray:
    """How wide a person's trunk appears, by the pixel of the feet.

    Parameters
    ----------
    shape : tuple of int
        Rows and columns of the image.
    to_ground : callable
        Image points (n, 2) → ground metres (n, 2), such as `Camera.to_ground`; it may
        raise `McnError` for points that see no ground.
    coarsest : float, optional
        Metres on the ground for one pixel: places that are seen less finely, and all that
        lie above them in the image, are too far away.

    Returns
    -------
    ndarray, shape (rows, columns)
        Pixels; 0 where it is too far away to look for feet.

    Raises
    ------
    ArgumentError
        When no place is near enough.
    """
    rows, columns = (require_count("shape", side, low=2) for side in shape)
    if not callable(to_ground):
        raise ArgumentError(
            f"to_ground is a {type(to_ground).__name__}; pass a function of image points, such as "
            "Camera.to_ground."
        )
    coarsest = require_number("coarsest", coarsest, above=0, unit="metres a pixel")
    x = np.arange(columns + 1.0)
    grid = np.full((rows + 1, columns + 1, 2), np.nan)
    for row in range(rows + 1):
        grid[row] = _ground_along(to_ground, np.c_[x, np.full(columns + 1, float(row))])
    down = np.linalg.norm(grid[1:, :-1] - grid[:-1, :-1], axis=2)
    across = np.linalg.norm(grid[:-1, 1:] - grid[:-1, :-1], axis=2)
    # From the bottom up: beyond the first place that is too far, all is.
    near = (np.maximum(down, across) <= coarsest)[::-1]
    near = np.logical_and.accumulate(near, axis=0)[::-1] & (across > 0)
    if not near.any():
        raise ArgumentError(
            f"coarsest is {coarsest:g} m a pixel, but no place in the image is seen as finely; "
            "pass more, or check that to_ground gives metres."
        )
    return np.divide(TRUNK, across, out=np.zeros((rows, columns)), where=near)


def _ground_along(to_ground, points):
    """The ground along a row of the image; NaN where it sees the sky."""
    whole = _ground_at(to_ground, points)
    if whole is not None:
        return whole
    ground = np.full(points.shape, np.nan)
    # The horizon of a camera that leans to one side runs across the row: from either end on,
    # as many points as lie on one side of it.
    for end in (slice(None), slice(None, None, -1)):
        seen, unseen = 0, len(points)
        while unseen - seen > 1:
            some = (seen + unseen) // 2 if seen else 1
            part = _ground_at(to_ground, points[end][:some])
            if part is None:
                unseen = some
            else:
                ground[end][:some] = part
                seen = some
    return ground


def _ground_at(to_ground, points):
    """The ground at some points; None where one of them sees the sky."""
    try:
        ground = to_ground(points)
    except McnError:
        return None
    remedy = "a function that gives x and y of each point"
    return require_array("to_ground", ground, points.shape, finite=False, remedy=remedy)


def person_sizes(widths: np.ndarray, height: Callable | float) -> PersonSizes:
    """How large a person appears, by the pixel of the feet.

    Parameters
    ----------
    widths : ndarray, shape (rows, columns)
        From `trunk_widths`.
    height : callable or float
        Image points (n, 2) → pixels, such as `Camera.height_at` or what `learn_height`
        gives; or pixels.

    Returns
    -------
    PersonSizes
        0 also where a person is less than `SMALLEST` pixels tall.

    Raises
    ------
    ArgumentError
        When `height` is not positive or gives values that are not finite, or a person is
        too small everywhere.
    """
    at = np.argwhere(widths > 0)[:, ::-1].astype(float)
    if callable(height):
        remedy = "a function that gives one finite number of pixels for each image point"
        values = require_array("height", height(at), (len(at),), remedy=remedy)
    else:
        values = np.full(len(at), require_number("height", height, above=0, unit="pixels"))
    if not (values >= SMALLEST).any():
        raise ArgumentError(
            f"height is less than {SMALLEST:g} pixels everywhere; nobody can be made out."
        )
    tall = np.zeros(widths.shape)
    tall[widths > 0] = np.where(values >= SMALLEST, values, 0.0)
    return PersonSizes(tall, np.where(tall > 0, widths, 0.0))


def learn_height(masks: Iterable[np.ndarray], widths: np.ndarray) -> Callable:
    """How tall people appear, from the silhouettes themselves.

    On level ground height is linear in the row of the feet (`estimate_camera`).
    A robust line through all silhouettes that are as wide as one person leaves out groups,
    and fragments as far as they are the fewer.

    Parameters
    ----------
    masks : iterable of ndarray
        From `background_masks` or `flow_masks`; not 0 where something moves.
    widths : ndarray, shape (rows, columns)
        From `trunk_widths`.

    Returns
    -------
    callable
        Image points (n, 2) → pixels.

    Raises
    ------
    SilhouetteError
        When fewer than 20 such silhouettes are seen.
    ArgumentError
        When a mask is not finite or not of the shape of `widths`.
    """
    rows, columns = widths.shape
    boxes = [np.empty((0, 5), int)]
    for mask in masks:
        mask = _check_mask(mask, widths.shape, argument="widths")
        boxes.append(cv2.connectedComponentsWithStats(mask)[2][1:])
    left, top, wide, tall, _ = np.concatenate(boxes).T
    whole = (left > 0) & (left + wide < columns) & (top > 0) & (top + tall < rows)
    left, top, wide, tall = (edge[whole] for edge in (left, top, wide, tall))
    trunk = widths[top + tall - 1, left + wide // 2]
    # From a trunk alone to a full stride; taller than wide, as far as one looks across.
    single = (wide >= 0.7 * trunk) & (wide <= 2.0 * trunk) & (tall >= np.maximum(wide, SMALLEST))
    single &= trunk > 0
    if single.sum() < 20:
        raise SilhouetteError(
            f"masks show {single.sum()} silhouettes of one person, too few to learn from how tall "
            "people appear; pass height."
        )
    feet, tall = (top + tall)[single].astype(float), tall[single].astype(float)
    if np.ptp(feet) == 0:
        return lambda points: np.full(len(points), np.median(tall))
    line, _ = fit_lines_robust(feet, tall)
    return lambda points: line.at(np.asarray(points)[:, 1])


class FeetFinder:
    """Lays people over foregrounds; the places to try are worked out once.

    Parameters
    ----------
    sizes : PersonSizes
        From `person_sizes`.
    least_fill : float, optional
        Share of the trunk's box that must be foreground.
    least_new : float, optional
        Share that nobody else explains.
    """

    def __init__(self, sizes, *, least_fill=LEAST_FILL, least_new=LEAST_NEW):
        require_kind("sizes", sizes, PersonSizes, "what person_sizes gives")
        tall = require_array("sizes.tall", sizes.tall, ("rows", "columns"))
        wide = require_array("sizes.wide", sizes.wide, tall.shape)
        if not (tall > 0).any() or (wide[tall > 0] <= 0).any():
            raise ArgumentError(
                "sizes must be positive somewhere, and wide where tall is; see person_sizes."
            )
        self.shape = tall.shape
        self.least_fill = require_number("least_fill", least_fill, above=0, high=1)
        self.least_new = require_number("least_new", least_new, above=0, high=1)
        rows, columns = np.nonzero(tall[::STRIDE, ::STRIDE] > 0)
        y, x = STRIDE * rows, STRIDE * columns
        self.tall, wide = tall[y, x], wide[y, x]
        most_columns = self.shape[1]
        self.left = np.clip(np.rint(x - wide / 2), 0, most_columns).astype(int)
        self.right = np.clip(np.rint(x + wide / 2) + 1, 0, most_columns).astype(int)
        self.top = np.clip(np.rint(y + 1 - self.tall), 0, y).astype(int)
        self.bottom = y + 1
        # Shares are of the whole person: one who is half out of the frame counts half.
        self.area = self.tall * wide
        width = most_columns + 1
        self.corners = np.stack(
            [
                self.bottom * width + self.right,
                self.bottom * width + self.left,
                self.top * width + self.right,
                self.top * width + self.left,
            ]
        )

    def __call__(self, mask: ArrayLike) -> np.ndarray:
        """The feet in one mask; see `find_feet`."""
        mask = _check_mask(mask, self.shape)
        covered = self._count(mask, slice(None))
        tried = np.flatnonzero(covered >= self.least_fill * self.area)
        people = []
        empty = self.area[tried] - covered[tried]
        while len(tried):
            fresh = self._count(mask, tried)
            gain = np.where(
                fresh >= self.least_new * self.area[tried],
                (fresh - 0.5 * empty) / self.area[tried],
                -np.inf,
            )
            best = int(np.argmax(gain))
            if gain[best] == -np.inf:
                break
            people.append(self._take(mask, tried[best]))
        return np.array(people, dtype=float).reshape(-1, 4)

    def _count(self, mask, places):
        """Foreground pixels in the boxes of places."""
        total = cv2.integral(mask).ravel()
        south_east, south_west, north_east, north_west = self.corners[:, places]
        return total[south_east] - total[south_west] - total[north_east] + total[north_west]

    def _take(self, mask, place):
        """Measure one person's feet in the mask, and clear the person from it."""
        left, right, top, bottom = (
            int(edge[place]) for edge in (self.left, self.right, self.top, self.bottom)
        )
        tall, rows = self.tall[place], self.shape[0]
        across = mask[top:bottom, left:right].sum(axis=0, dtype=float)
        x = left + across @ np.arange(right - left) / across.sum()
        # The lowest foreground of the trunk's columns: down from the box while it goes on,
        # as people differ in height, else up to where it begins.
        lowest = min(rows, int(bottom + 0.12 * tall) + 1)
        some = mask[top:lowest, left:right].any(axis=1)
        end = bottom - top
        if some[end - 1]:
            gaps = np.flatnonzero(~some[end:])
            end = end + gaps[0] if len(gaps) else end
        else:
            end = int(np.flatnonzero(some[:end])[-1]) + 1
        y = top + end
        margin = int(np.rint((SPAN - 1) / 2 * (right - left)))
        head, sole = max(0, int(top - 0.1 * tall)), int(max(y, bottom) + 0.05 * tall)
        mask[head:sole, max(0, left - margin) : right + margin] = 0
        return x, y, right - left, tall


def find_feet(mask: ArrayLike, sizes: PersonSizes, **options: float) -> np.ndarray:
    """The bottom points of the people in one silhouette image (thesis section 2.3).

    People as tall as the calibration says are laid over the foreground one by one, each time
    where one explains most of what is not explained yet; so a group in one silhouette is
    taken apart, and fragments of one person are put together.

    Parameters
    ----------
    mask : array_like, shape (rows, columns)
        Not 0 where something moves.
    sizes : PersonSizes
        From `person_sizes`.
    **options
        For `FeetFinder`, which is the faster for many masks.

    Returns
    -------
    ndarray, shape (n, 4)
        x, y of the feet, width of the trunk and height, pixels; no rows where nobody moves.

    Raises
    ------
    ArgumentError
        When the mask is not finite or not of the shape of `sizes`.
    """
    return FeetFinder(sizes, **options)(mask)


def _check_mask(mask, shape, *, argument="sizes"):
    """A copy of `mask`: 1 where it is not 0; `argument` is what it must agree with."""
    remedy = f"finite numbers of the shape of {argument}, {shape}"
    return (require_array("mask", mask, shape, remedy=remedy) != 0).astype(np.uint8)


def detect_feet(
    masks: Iterable[np.ndarray], sizes: PersonSizes, to_ground: Callable, **options: float
) -> pd.DataFrame:
    """Feet in every frame, on the ground.

    Parameters
    ----------
    masks : iterable of ndarray
        From `background_masks` or `flow_masks`; the first one is frame 0.
    sizes : PersonSizes
        From `person_sizes`.
    to_ground : callable
        Image points (n, 2) → ground metres (n, 2).
    **options
        For `FeetFinder`.

    Returns
    -------
    pandas.DataFrame
        ``frame, x, y`` (metres), ``image_x, image_y, w, h`` (pixels).

    Raises
    ------
    SilhouetteError
        When nobody is seen to move.
    """
    finder = FeetFinder(sizes, **options)
    found = [finder(mask) for mask in masks]
    feet = np.concatenate([np.empty((0, 4)), *found])
    if len(feet) == 0:
        raise SilhouetteError(
            f"masks: nobody moved in {len(found)} frames, at the size that sizes gives; "
            "check the threshold, the sizes and the video."
        )
    ground = np.asarray(to_ground(feet[:, :2]), dtype=float)
    table = pd.DataFrame(feet, columns=[IMAGE_X, IMAGE_Y, W, H])
    table.insert(0, FRAME, np.repeat(np.arange(len(found)), [len(part) for part in found]))
    table.insert(1, X, ground[:, 0])
    table.insert(2, Y, ground[:, 1])
    return table
