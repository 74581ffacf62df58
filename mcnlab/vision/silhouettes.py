"""From a binary mask to the walker's box, and from a sequence to a box table.

Thesis section 3.2.1 (a) and (b): unwanted blobs are removed, improper segmentation is
mended, and a bounding box is fitted to what is left.  The thesis keeps the largest
connected component.  Real silhouettes fall into head, torso and legs, so here the body
is the largest fragment *and* the fragments that stand in one column with it.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy.ndimage import median_filter

from mcnlab.checks import require_array, require_count
from mcnlab.errors import ArgumentError, DatasetError, SilhouetteError
from mcnlab.tables import AREA, CX, CY, FRAME, SEQUENCE, SUBJECT, H, W, X, Y

MIN_AREA = 12  # pixels: smaller fragments are specks
# How fragments make one body, in multiples of the body's larger side; set by eye on the
# fourteen subjects of CASIA A that are bundled.
_SIDE_GAP = 0.12  # a fragment further to the side is not the walker's
_GAP = 0.8  # a torso may be missing whole; no more than that
_REACH = 4.0  # a fragment bridges a gap of this many times its own size (root of area)
_OFF_COLUMN = 0.5  # a fragment's centroid off the body's by more is not the walker's
# A rest of this share of the body's height and area is a second walker.
_RIVAL_HEIGHT, _RIVAL_AREA = 0.6, 0.35
_NEIGHBOURS = 11  # frames, for what is expected of a frame from those around it
FLOW_LEAST = 16  # pixels: DIS flow works on patches of 8
_SUBPIXEL = 16  # centroids are kept to 1/16 pixel, which mirrors exactly


@dataclass(frozen=True)
class Body:
    """The walker in one mask.

    Attributes
    ----------
    x, y, w, h : int
        The bounding box, pixels.
    cx, cy : float
        The centroid of the body's pixels, to 1/16 pixel.
    area : int
        Pixels.
    fragments : int
        How many connected components make the body.
    mask : ndarray, shape (height, width), uint8
        The body alone, 0 or 255.
    """

    x: int
    y: int
    w: int
    h: int
    cx: float
    cy: float
    area: int
    fragments: int
    mask: np.ndarray


def find_body(mask: ArrayLike, *, min_area: int = MIN_AREA) -> Body:
    """The one walker in a binary image.

    Parameters
    ----------
    mask : array_like, shape (height, width)
        0 where background, one other value (or True) where foreground.
    min_area : int, optional
        Fragments of fewer pixels are specks.

    Returns
    -------
    Body

    Raises
    ------
    ArgumentError
        When `mask` is not a two-dimensional binary image.
    SilhouetteError
        When there is no walker, everything is foreground, or two walkers stand apart.

    Notes
    -----
    Two walkers closer to each other than an eighth of their height cannot be told from
    one, and are measured as one.
    """
    mask, window = _check_window(mask)
    found, chosen = _find_walker(mask, window, require_count("min_area", min_area, low=1))
    x, y, w, h, cx, cy, area = _box(found, chosen)
    kept = np.isin(found.labels, 1 + np.flatnonzero(chosen))
    clean = np.zeros(mask.shape, np.uint8)
    rows, cols = found.window
    clean[rows, cols][kept] = 255
    return Body(x, y, w, h, cx, cy, area, int(chosen.sum()), clean)


def measure_sequence(
    masks: Iterable[ArrayLike],
    *,
    sequence: str = "walk",
    subject: str = "walker",
    frames: ArrayLike | None = None,
    min_area: int = MIN_AREA,
) -> pd.DataFrame:
    """The box table of one walk.

    Each frame is measured by itself; where a box departs from the running median of
    its neighbours, the fragments are chosen again, inside the place that the neighbours
    foretell, and the better of the two stays.

    Parameters
    ----------
    masks : iterable of array_like, each (height, width)
        Binary silhouettes in frame order.
    sequence, subject : str, optional
        Names for the table.
    frames : sequence of int, optional
        Frame numbers, rising; 1, 2, 3, … if not given.
    min_area : int, optional
        Fragments of fewer pixels are specks.

    Returns
    -------
    pandas.DataFrame
        ``sequence, subject, frame, x, y, w, h, cx, cy, area``.  A frame without exactly
        one walker has no row.

    Raises
    ------
    ArgumentError
        When a mask is not binary, or `frames` does not fit.
    SilhouetteError
        When no frame shows a walker.

    Examples
    --------
    >>> masks = np.zeros((2, 60, 80), np.uint8)
    >>> masks[0, 10:50, 20:32] = masks[1, 10:50, 23:35] = 255
    >>> measure_sequence(masks)[["frame", "x", "y", "w", "h"]].to_numpy().tolist()
    [[1, 20, 10, 12, 40], [2, 23, 10, 12, 40]]
    """
    min_area = require_count("min_area", min_area, low=1)
    found, numbers, rows, fault = [], [], [], None
    for number, mask in enumerate(masks, start=1):
        numbers.append(number)
        try:
            checked, window = _check_window(mask)
            fragments, chosen = _find_walker(checked, window, min_area)
        except SilhouetteError as reason:
            fault = reason
            continue
        found.append(fragments)
        rows.append((number, *_box(fragments, chosen)))
    if not rows:
        raise SilhouetteError(
            f"masks: none of the {len(numbers)} frames shows one walker"
            + (f" (the last: {fault})" if fault else "")
            + "; pass a sequence with a walker in it."
        )
    table = np.array(rows)
    _mend(table, found, min_area)
    if frames is not None:
        frames = require_array("frames", frames, (len(numbers),), dtype=int)
        if (np.diff(frames) <= 0).any():
            raise ArgumentError("frames must rise; pass the frames' numbers in order of time.")
        table[:, 0] = frames[table[:, 0].astype(int) - 1]
    names = (FRAME, X, Y, W, H, CX, CY, AREA)
    measured = {
        name: column if name in (CX, CY) else column.astype(int)
        for name, column in zip(names, table.T.copy(), strict=True)
    }
    return pd.DataFrame({SEQUENCE: sequence, SUBJECT: subject, **measured})


def measure_sequences(
    sequences: list,
    *,
    min_area: int = MIN_AREA,
    n_jobs: int = -1,
    progress: bool = False,
) -> tuple[pd.DataFrame, tuple[str, ...]]:
    """The box table of many walks, on all cores.

    Parameters
    ----------
    sequences : list of SilhouetteSequence
        Anything with ``name``, ``subject`` and ``frames()``.
    min_area : int, optional
        As in `measure_sequence`.
    n_jobs : int, optional
        Processes, as joblib counts them; a Dask user sets joblib's backend.
    progress : bool, optional
        Show a progress bar.

    Returns
    -------
    boxes : pandas.DataFrame
    problems : tuple of str
        One sentence for each sequence that was left out, and why.

    Raises
    ------
    DatasetError
        When no sequence could be measured.
    """
    from joblib import Parallel, delayed
    from tqdm.auto import tqdm

    results = Parallel(n_jobs=n_jobs, return_as="generator")(
        delayed(_measure_or_explain)(sequence, min_area) for sequence in sequences
    )
    bar = tqdm(results, total=len(sequences), desc="measuring", unit="walk", disable=not progress)
    tables, problems = [], []
    for table, problem in bar:
        if problem is None:
            tables.append(table)
        else:
            problems.append(problem)
    if not tables:
        raise DatasetError(
            "sequences: none could be measured. "
            + (problems[0] if problems else "The list is empty.")
        )
    return pd.concat(tables, ignore_index=True), tuple(problems)


def close_gaps(mask: ArrayLike, *, size: int = 5) -> np.ndarray:
    """Bridge gaps narrower than `size` pixels: morphological closing with a disc.

    An even size counts as the next odd one: the disc needs a middle.
    """
    mask = check_mask(mask)
    size = require_count("size", size, low=1) | 1
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    padded = cv2.copyMakeBorder(mask, size, size, size, size, cv2.BORDER_CONSTANT, value=0)
    closed = cv2.morphologyEx(padded, cv2.MORPH_CLOSE, disc)
    return closed[size:-size, size:-size].copy()


def rectify_with_flow(
    masks: Iterable[ArrayLike], *, reach: int = 2, blur: float = 3.0
) -> np.ndarray:
    """Mend improper segmentation with optical flow (thesis 3.2.1 (a)).

    The silhouettes up to `reach` frames before and after are carried onto each frame
    along DIS optical flow, and the majority decides every pixel: a leg that is lost for
    a frame comes back, a speck that lasts one frame goes.

    Parameters
    ----------
    masks : array_like, shape (frames, height, width)
        Binary silhouettes.
    reach : int, optional
        Frames to each side.
    blur : float, optional
        Standard deviation, pixels, of the Gaussian that gives the binary images the
        gradient that flow needs.

    Returns
    -------
    ndarray, shape (frames, height, width), uint8
        0 or 255.

    Raises
    ------
    ArgumentError
        When `masks` are not binary images of one size, or fewer than two.
    """
    masks = [check_mask(mask) for mask in masks]
    reach = require_count("reach", reach, low=1)
    if len(masks) < 2 or len({mask.shape for mask in masks}) != 1:
        raise ArgumentError("masks must be at least two images of one size; flow needs neighbours.")
    height, width = masks[0].shape
    if min(height, width) < FLOW_LEAST:
        raise ArgumentError(
            f"masks are {width}×{height} pixels; flow needs {FLOW_LEAST} each way. Enlarge them."
        )
    smooth = [cv2.GaussianBlur(mask, (0, 0), blur) for mask in masks]
    flow = cv2.DISOpticalFlow_create(cv2.DISOPTICAL_FLOW_PRESET_FAST)
    grid = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1).astype(np.float32)
    mended = np.empty((len(masks), height, width), np.uint8)
    for here, mask in enumerate(masks):
        votes = (mask > 0).astype(np.float32)
        voters = 1
        for there in range(max(0, here - reach), min(len(masks), here + reach + 1)):
            if there == here:
                continue
            path = grid + flow.calc(smooth[here], smooth[there], None)
            carried = cv2.remap(masks[there], path[..., 0], path[..., 1], cv2.INTER_LINEAR)
            votes += carried / 255.0
            voters += 1
        mended[here] = 255 * (votes > voters / 2)
    return mended


def check_mask(mask: ArrayLike) -> np.ndarray:
    """`mask` as a contiguous uint8 image of 0 and 255, or `ArgumentError`."""
    return _check_window(mask)[0]


def _check_window(mask):
    """The image as `check_mask` gives it, and the (x, y, w, h) that holds its foreground."""
    image = np.asarray(mask)
    if image.ndim != 2 or image.size == 0:
        raise ArgumentError(f"mask has shape {image.shape}; pass an image (height, width).")
    if image.dtype == bool:
        image = image.astype(np.uint8) * 255
    if image.dtype != np.uint8 and not np.issubdtype(image.dtype, np.number):
        raise ArgumentError(f"mask has dtype {image.dtype}; pass a binary image of numbers.")
    if image.dtype == np.uint8:
        image = np.ascontiguousarray(image)
        # The sum is 255 times the count just where every pixel but the black ones is white.
        if cv2.norm(image, cv2.NORM_L1) == 255 * cv2.countNonZero(image):
            return image, cv2.boundingRect(image)
    values = np.unique(image)
    if len(values) > 2 or 0 not in values or not np.isfinite(values).all():
        raise ArgumentError(
            f"mask has {len(values)} grey levels ({values[0]} … {values[-1]}); "
            "pass a binary one: 0 for background, one other value for the walker."
        )
    image = (image != 0).astype(np.uint8) * 255
    return image, cv2.boundingRect(image)


def _find_walker(mask, window, min_area):
    """The fragments of a mask, and which of them are the walker."""
    found = _find_fragments(mask, window)
    _check_foreground(found, mask.shape, min_area)
    chosen = _join_fragments(found, min_area)
    _check_single(found, chosen)
    return found, chosen


class _Fragments(NamedTuple):
    """The connected components of a mask: boxes in frame coordinates, one row each."""

    left: np.ndarray
    top: np.ndarray
    right: np.ndarray  # exclusive
    bottom: np.ndarray  # exclusive
    area: np.ndarray
    centroid: np.ndarray  # (n, 2): column, row
    labels: np.ndarray  # of the window only
    window: tuple  # rows and columns that hold all foreground


def _find_fragments(mask, window):
    x, y, w, h = window
    # Only the window that holds foreground is labelled: a walker fills a tenth of a frame.
    window = (slice(y, y + h), slice(x, x + w))
    if w == 0:
        none = np.zeros(0, int)
        return _Fragments(none, none, none, none, none, np.zeros((0, 2)), np.zeros((0, 0)), window)
    # Labels of 16 bits are quicker, but would run over if a large window were all specks.
    kind = cv2.CV_16U if w * h < 4 * 2**16 else cv2.CV_32S
    _, labels, stats, centroids = cv2.connectedComponentsWithStats(
        mask[window], connectivity=8, ltype=kind
    )
    left, top, width, height, area = stats[1:].T
    return _Fragments(
        left + x,
        top + y,
        left + x + width,
        top + y + height,
        area,
        centroids[1:] + np.array([x, y]),
        labels,
        window,
    )


def _check_foreground(found, shape, min_area):
    if len(found.area) == 0 or found.area.max() < min_area:
        raise SilhouetteError(
            f"mask shows no walker: no fragment of {min_area} pixels or more; "
            "leave the frame out or lower min_area."
        )
    height, width = shape
    largest = found.area.argmax()
    wide = found.right[largest] - found.left[largest]
    high = found.bottom[largest] - found.top[largest]
    if wide >= 0.95 * width and high >= 0.95 * height and 2 * found.area[largest] >= width * height:
        raise SilhouetteError(
            "mask is foreground from edge to edge; is it inverted? Pass the walker as "
            "foreground on black."
        )


def _join_fragments(found, min_area):
    """Which fragments make the body: the largest, then whatever stands in its column."""
    if len(found.area) == 1:
        return np.ones(1, bool)
    large = found.area >= min_area
    seeds = found.area == found.area.max()
    if np.count_nonzero(large) <= 1:
        return seeds
    # Of equal seeds the one that gathers most, not the one more to the left: a mirrored
    # image must give the mirrored body.
    bodies = [_grow_body(found, seed, large) for seed in np.flatnonzero(seeds)]
    if len(bodies) == 1:
        return bodies[0]
    return max(bodies, key=lambda body: (found.area[body].sum(), found.bottom[body].max()))


def _grow_body(found, seed, large):
    chosen = np.zeros(len(found.area), bool)
    chosen[seed] = True
    size = np.sqrt(found.area)
    while True:
        left, top = found.left[chosen].min(), found.top[chosen].min()
        right, bottom = found.right[chosen].max(), found.bottom[chosen].max()
        weight = found.area[chosen]
        column = (found.centroid[chosen, 0] * weight).sum() / weight.sum()
        side = max(right - left, bottom - top)
        beside = np.maximum(found.left - right, left - found.right)
        above = np.maximum(found.top - bottom, top - found.bottom)
        joins = (
            large
            & ~chosen
            & (beside <= _SIDE_GAP * side)
            & (above <= np.minimum(_GAP * side, _REACH * size))
            & (np.abs(found.centroid[:, 0] - column) <= _OFF_COLUMN * side)
        )
        if not joins.any():
            return chosen
        chosen |= joins


def _check_single(found, chosen):
    if len(chosen) == 1 or chosen.all():
        return
    height = found.bottom[chosen].max() - found.top[chosen].min()
    rest = ~chosen
    rival = (
        rest
        & (found.bottom - found.top >= _RIVAL_HEIGHT * height)
        & (found.area >= _RIVAL_AREA * found.area[chosen].sum())
    )
    if rival.any():
        other = np.flatnonzero(rival)[0]
        raise SilhouetteError(
            f"mask shows two walkers, at columns {found.left[chosen].min()} and "
            f"{found.left[other]}; cut the image so that one is left."
        )


def _box(found, chosen):
    if len(chosen) == 1:
        left, top, right, bottom, area = (
            int(side[0]) for side in (found.left, found.top, found.right, found.bottom, found.area)
        )
        cx, cy = np.round(found.centroid[0] * _SUBPIXEL) / _SUBPIXEL
        return left, top, right - left, bottom - top, float(cx), float(cy), area
    left, top = int(found.left[chosen].min()), int(found.top[chosen].min())
    right, bottom = int(found.right[chosen].max()), int(found.bottom[chosen].max())
    weight = found.area[chosen]
    area = int(weight.sum())
    # Sums of pixel coordinates are whole: rounded, they do not hang on the order.
    centroid = np.round(found.centroid[chosen] * weight[:, None]).sum(axis=0) / area
    cx, cy = np.round(centroid * _SUBPIXEL) / _SUBPIXEL
    return left, top, right - left, bottom - top, float(cx), float(cy), area


def _mend(table, found, min_area):
    """Measure again, in place, the frames whose box departs from their neighbours'."""
    if len(table) < 5:
        return
    for _ in range(2):  # the second round profits from the medians of the first
        top, column = table[:, 2], table[:, 5]
        bottom = top + table[:, 4]
        usual_top, usual_bottom, usual_column = (
            median_filter(curve, _NEIGHBOURS, mode="nearest") for curve in (top, bottom, column)
        )
        height = usual_bottom - usual_top
        departs = (
            (np.abs(top - usual_top) > 0.06 * height)
            | (np.abs(bottom - usual_bottom) > 0.06 * height)
            | (np.abs(column - usual_column) > 0.15 * height)
        )
        for at in np.flatnonzero(departs):
            fragments = found[at]
            inside = np.abs(fragments.centroid[:, 0] - usual_column[at]) <= 0.35 * height[at]
            if not inside.any():
                continue
            slack = 0.05 * height[at]
            chosen = (
                inside
                & (fragments.top >= usual_top[at] - slack)
                & (fragments.bottom <= usual_bottom[at] + slack)
                & (2 * fragments.area >= min_area)
            )
            largest = np.where(inside, fragments.area, 0)
            chosen |= largest == largest.max()
            new = _box(fragments, chosen)
            missed = abs(top[at] - usual_top[at]) + abs(bottom[at] - usual_bottom[at])
            misses = abs(new[1] - usual_top[at]) + abs(new[1] + new[3] - usual_bottom[at])
            if misses < missed:
                table[at, 1:] = new


def _measure_or_explain(sequence, min_area):
    try:
        table = measure_sequence(
            sequence.frames(), sequence=sequence.name, subject=sequence.subject, min_area=min_area
        )
    except DatasetError as fault:
        return None, str(fault)  # names the sequence itself
    except SilhouetteError as fault:
        return None, f"sequence {sequence.name}: {fault}"
    return table, None
