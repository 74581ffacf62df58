"""Optical flow: how far each pixel moved from one frame to the next.

The thesis's method (section 2.3) is Horn and Schunck's: a pixel keeps its grey level, and
the flow (u, v) is smooth.  What is least is the sum over all pixels of

    (I_x u + I_y v + I_t)² + α² (|∇u|² + |∇v|²).

`horn_schunck_plain` is that and no more; it is sound for motions up to about a pixel.
`horn_schunck` is for motions of any size: from coarse to fine, with warping.  The two terms
of its energy are the paper's, both quadratic; but between warps it filters the flow with a
5×5 median, which changes what is minimised (Sun, Roth and Black), and in each warp it takes a
limited number of relaxed iterations, which stop short of the least.  OpenCV's DIS and
Farnebäck stand beside them with the same interface, see `METHODS`.

A flow is an array (height, width, 2) of float32: dx to the right and dy down, in pixels a
frame.  A pixel at (x, y) of the first frame is at (x + dx, y + dy) in the second.

References
----------
B. K. P. Horn and B. G. Schunck, Determining optical flow, Artificial Intelligence 17, 1981.
D. Sun, S. Roth and M. J. Black, A quantitative analysis of current practices in optical
flow estimation and the principles behind them, Int. J. Computer Vision 106, 2014.
G. Farnebäck, Two-frame motion estimation based on polynomial expansion, SCIA 2003.
T. Kroeger, R. Timofte, D. Dai and L. Van Gool, Fast optical flow using dense inverse
search, ECCV 2016.
S. Baker et al., A database and evaluation methodology for optical flow, Int. J. Computer
Vision 92, 2011.
"""

from types import MappingProxyType
from typing import Final

import cv2
import numpy as np
from numpy.typing import ArrayLike

from mcnlab.checks import (
    require_array,
    require_choice,
    require_count,
    require_like,
    require_number,
)
from mcnlab.datasets.middlebury import UNKNOWN
from mcnlab.errors import ArgumentError

ALPHA: Final = 7.0  # grey levels of 255; the thesis names none

PRESETS: Final = MappingProxyType(
    {
        "ultrafast": cv2.DISOPTICAL_FLOW_PRESET_ULTRAFAST,
        "fast": cv2.DISOPTICAL_FLOW_PRESET_FAST,
        "medium": cv2.DISOPTICAL_FLOW_PRESET_MEDIUM,
    }
)

_MEAN: Final = (
    np.array([[1, 2, 1], [2, 0, 2], [1, 2, 1]], np.float32) / 12
)  # Horn and Schunck, section 8
_SLOPE: Final = (
    np.array([1, -8, 0, 8, -1], np.float32) / 12
)  # exact on polynomials to the fourth degree
_MIDDLE: Final = (
    np.array([3, -25, 150, 150, -25, 3], np.float32) / 256
)  # half-way, to the fifth degree
_ONE: Final = np.ones(1, np.float32)
_EDGE: Final = cv2.BORDER_REPLICATE
_COARSEST: Final = 16  # pixels, the least side of the coarsest level when levels are "auto"
_LONGEST: Final = 16383  # pixels a side: OpenCV's remap takes 32767, of twice the resolution
_MOST_LEVELS: Final = 10  # of Farnebäck's: the longest side halved to 32 pixels
# Beyond these an option has no use, and only costs time or gives no flow at all.
_MOST: Final = 100_000  # iterations
_MOST_WARPS: Final = 1000  # and median filters
_WIDEST: Final = 1000  # pixels, of a window
_BROADEST: Final = 10.0  # pixels, of weights over seven of them
_STIFFEST: Final = 1e6  # grey levels; 16 bits have 65,536
_CHECK_EVERY: Final = 5  # iterations between two looks at the update


def horn_schunck(
    first: ArrayLike,
    second: ArrayLike,
    *,
    alpha: float = ALPHA,
    iterations: int = 15,
    levels: int | str = "auto",
    warps: int = 2,
    tolerance: float = 1e-3,
    presmooth: float = 0.5,
    median: int = 2,
    relaxation: float = 1.6,
) -> np.ndarray:
    """Horn and Schunck's flow from coarse to fine, for motions of many pixels.

    Each level of a pyramid starts from the flow of the coarser one, warps the second frame
    back by it and solves for the flow anew, `warps` times.  A pixel that the flow carries
    out of the frame is no evidence, its neighbours decide.

    Added to the paper, after Sun, Roth and Black: warping, slopes that are the mean of both
    frames', and the median filter.  The two terms of the energy stay as in the paper, but
    filtered flows are not those that make it least.

    Parameters
    ----------
    first, second : array_like, shape (height, width)
        Grey frames, of integers or floats.
    alpha : float, optional
        Weight of smoothness, in grey levels: where the grey level's slope is `alpha` a
        pixel, the neighbours' mean and the pixel's own evidence count the same.  The
        default is for grey levels to 255; the thesis names none.
    iterations : int, optional
        At most so many in each warp.
    levels : int or "auto", optional
        Levels of the pyramid, each half as large; 1 is the frames alone.  "auto" goes on
        while the shorter side of the coarsest is at least 16 pixels.
    warps : int, optional
        Warps in each level.
    tolerance : float, optional
        Iterations of a warp stop when no pixel's flow changes by more in one of them,
        pixels; looked at in every fifth; 0 never stops early.
    presmooth : float, optional
        Standard deviation of a Gaussian blur of both frames, pixels; 0 for none.
    median : int, optional
        How often the flow is filtered with a 5×5 median after each warp.
    relaxation : float, optional
        Step towards the iteration's result, in (0, 2): above 1 each iteration goes on in
        the direction of the last (second-order Richardson), which arrives sooner at the
        same solution; 1 is the paper's iteration.

    Returns
    -------
    ndarray of float32, shape (height, width, 2)
        dx, dy in pixels.  Frames without any contrast, or without change, give no motion,
        to rounding: the smoothest flow that contradicts nothing.

    Raises
    ------
    ArgumentError
        When the frames are not two grey images of one size with finite values, or an
        option is out of range.

    Examples
    --------
    Ripples that move three pixels to the right.

    >>> import numpy as np
    >>> y, x = np.mgrid[:64, :64]
    >>> first, second = (100 + 50 * np.sin(x / 5 - at) * np.cos(y / 7) for at in (0, 0.6))
    >>> round(float(horn_schunck(first, second)[32, 32, 0]), 1)
    3.0
    """
    first, second = _check_frames(first, second)
    alpha = require_number("alpha", alpha, above=0, high=_STIFFEST, unit="grey levels")
    require_count("iterations", iterations, low=1, high=_MOST)
    require_count("warps", warps, low=1, high=_MOST_WARPS)
    require_count("median", median, low=0, high=_MOST_WARPS)
    require_number("tolerance", tolerance, low=0, unit="pixels")
    presmooth = require_number("presmooth", presmooth, low=0, high=100, unit="pixels")
    if require_number("relaxation", relaxation, above=0) >= 2:
        raise ArgumentError(f"relaxation is {relaxation}; pass a number below 2.")
    levels = _check_levels(levels, first.shape)

    # Grey levels in units of alpha: the weight of smoothness is then 1.
    frames = _in_units_of(alpha, first, second)
    if presmooth > 0:
        frames = [cv2.GaussianBlur(f, (0, 0), presmooth, borderType=_EDGE) for f in frames]
    pyramid = [frames]
    for _ in range(levels - 1):
        pyramid.append([cv2.pyrDown(frame) for frame in pyramid[-1]])

    u = v = np.zeros(pyramid[-1][0].shape, np.float32)
    for near, far in reversed(pyramid):
        if u.shape != near.shape:
            # pyrDown keeps every other pixel, so a length doubles whatever the sizes are.
            u, v = (2 * cv2.pyrUp(part, dstsize=near.shape[::-1]) for part in (u, v))
        slopes, fine = _slopes(near), None
        space = np.empty((10, *near.shape), np.float32)  # fresh memory costs more than sums
        for _ in range(warps):
            warped, inside = far, None
            if u.any() or v.any():
                fine = _doubled(far) if fine is None else fine
                warped, inside = _warp(fine, u, v)
            evidence = _evidence(near, warped, inside, slopes, u, v)
            u, v = _iterate(u, v, evidence, space, iterations, tolerance, relaxation)
            for _ in range(median):
                u, v = cv2.medianBlur(u, 5), cv2.medianBlur(v, 5)
    return cv2.merge([u, v])


def horn_schunck_plain(
    first: ArrayLike,
    second: ArrayLike,
    *,
    alpha: float = ALPHA,
    iterations: int = 100,
    tolerance: float = 0.0,
    presmooth: float = 0.5,
) -> np.ndarray:
    """Horn and Schunck's flow as in 1981: one level, their iteration, from rest.

    Each iteration puts the neighbours' mean flow in each pixel's place and corrects it by
    the pixel's own evidence (their section 12).  Slopes are taken over five pixels of both
    frames, where the paper takes the differences within a 2×2×2 cube.

    Parameters
    ----------
    first, second, alpha, presmooth
        As in `horn_schunck`.
    iterations : int, optional
        At most so many; flow spreads by a pixel in each.
    tolerance : float, optional
        As in `horn_schunck`; 0 never stops early.

    Returns
    -------
    ndarray of float32, shape (height, width, 2)
        dx, dy in pixels.

    Raises
    ------
    ArgumentError
        As in `horn_schunck`.
    """
    return horn_schunck(
        first,
        second,
        alpha=alpha,
        iterations=iterations,
        levels=1,
        warps=1,
        tolerance=tolerance,
        presmooth=presmooth,
        median=0,
        relaxation=1.0,
    )


def dis(first: ArrayLike, second: ArrayLike, *, preset: str = "medium") -> np.ndarray:
    """Dense inverse search (Kroeger et al.), OpenCV's.

    Parameters
    ----------
    first, second : array_like, shape (height, width)
        Grey frames, 0 … 255, at least 12 pixels a side; rounded to whole grey levels.
    preset : {"ultrafast", "fast", "medium"}, optional
        OpenCV's compromises between speed and accuracy.

    Returns
    -------
    ndarray of float32, shape (height, width, 2)
        dx, dy in pixels.

    Raises
    ------
    ArgumentError
        As in `horn_schunck`, and when grey levels are not 0 … 255.
    """
    require_choice("preset", preset, tuple(PRESETS))
    first, second = _check_8bit(*_check_frames(first, second))
    if min(first.shape) < 12:
        raise ArgumentError(
            f"first has shape {first.shape}; DIS needs at least 12 pixels a side: enlarge it."
        )
    try:
        return cv2.DISOpticalFlow_create(PRESETS[preset]).calc(first, second, None)
    except cv2.error as fault:
        raise ArgumentError(
            f"first has shape {first.shape}, too long and narrow for DIS; cut it in pieces."
        ) from fault


def farneback(
    first: ArrayLike,
    second: ArrayLike,
    *,
    levels: int = 5,
    window: int = 15,
    iterations: int = 10,
    neighbourhood: int = 5,
    spread: float = 1.1,
) -> np.ndarray:
    """Farnebäck's polynomial expansion, OpenCV's.

    Near the edges it may find a few hundredths of a pixel where nothing has changed.  The
    defaults are more accurate than those that OpenCV's samples use (levels=3,
    window=15, iterations=3, neighbourhood=5, spread=1.2), and slower.

    Parameters
    ----------
    first, second : array_like, shape (height, width)
        Grey frames, 0 … 255; rounded to whole grey levels.
    levels : int, optional
        Levels of the pyramid, each half as large, with the frames themselves, at most 10;
        OpenCV leaves out those shorter than 32 pixels.
    window : int, optional
        Side of the window that the flow is averaged over, 2 to 1000 pixels.
    iterations : int, optional
        In each level.
    neighbourhood : int, optional
        Side of the neighbourhood of the polynomial, pixels; 5 or 7.
    spread : float, optional
        Standard deviation of the Gaussian weights in it, pixels, at most 10.

    Returns
    -------
    ndarray of float32, shape (height, width, 2)
        dx, dy in pixels.

    Raises
    ------
    ArgumentError
        As in `dis`, and when an option is out of range.
    """
    require_count("levels", levels, low=1, high=_MOST_LEVELS)
    require_count("window", window, low=2, high=_WIDEST)
    require_count("iterations", iterations, low=1, high=_MOST)
    require_choice("neighbourhood", neighbourhood, (5, 7))
    spread = require_number("spread", spread, above=0, high=_BROADEST, unit="pixels")
    first, second = _check_8bit(*_check_frames(first, second))
    return cv2.calcOpticalFlowFarneback(
        first, second, None, 0.5, levels, window, iterations, neighbourhood, spread, 0
    )


# What a figure loops over: each takes two grey frames and gives a flow.
METHODS: Final = MappingProxyType(
    {
        "horn-schunck": horn_schunck,
        "horn-schunck-plain": horn_schunck_plain,
        "dis": dis,
        "farneback": farneback,
    }
)


def end_point_error(flow: ArrayLike, truth: ArrayLike) -> float:
    """Mean distance between a flow's arrows' ends and the true ones.

    Parameters
    ----------
    flow : array_like, shape (height, width, 2)
        Pixels.
    truth : array_like, shape (height, width, 2)
        Pixels; NaN or beyond ±1e9 where it is not known.

    Returns
    -------
    float
        Pixels, over the pixels whose truth is known.

    Raises
    ------
    ArgumentError
        When the shapes differ, the flow is not finite, or no pixel's truth is known.
    """
    flow, truth = _check_truth(flow, truth)
    return float(np.linalg.norm(flow - truth, axis=-1).mean())


def moving_mask(flow: ArrayLike, *, speed: float) -> np.ndarray:
    """Where something moves.

    Parameters
    ----------
    flow : array_like, shape (height, width, 2)
        Pixels a frame.
    speed : float
        The least that counts as motion, pixels a frame.

    Returns
    -------
    ndarray of uint8, shape (height, width)
        255 where the flow is at least `speed` long, else 0.

    Raises
    ------
    ArgumentError
        When `flow` is no finite flow or `speed` is not positive.
    """
    flow = _check_flow("flow", flow, finite=True)
    speed = require_number("speed", speed, above=0, unit="pixels a frame")
    return np.where(np.hypot(flow[..., 0], flow[..., 1]) >= speed, np.uint8(255), np.uint8(0))


def _check_frames(first, second):
    """Both frames as arrays of finite real numbers of one size, or raise."""
    remedy = (
        f"one grey image (height, width) of finite numbers, at most {_LONGEST} pixels a side; "
        "cv2.cvtColor turns a colour image grey, cv2.inpaint fills gaps"
    )
    frames = []
    for name, frame in (("first", first), ("second", second)):
        require_array(name, frame, ("height", "width"), remedy=remedy)
        frame = np.asarray(frame)
        if frame.dtype.kind not in "uif" or frame.size == 0 or max(frame.shape) > _LONGEST:
            raise ArgumentError(f"{name} has shape {frame.shape} of {frame.dtype}; pass {remedy}.")
        frames.append(frame)
    require_like(frames[0], of="first", second=frames[1])
    return frames


def _check_8bit(first, second):
    """Both frames as uint8, or raise where they are not on the scale 0 … 255."""
    frames = []
    for name, frame in (("first", first), ("second", second)):
        if frame.dtype == np.uint8:
            frames.append(np.ascontiguousarray(frame))
            continue
        low, high = float(frame.min()), float(frame.max())
        # Rounding a scale of 0 … 1 would leave a black and white picture in silence.
        if low < 0 or high > 255 or (frame.dtype.kind == "f" and 0 < high <= 1 and low < high):
            raise ArgumentError(
                f"{name} holds grey levels from {low:g} to {high:g}; scale them to 0 … 255."
            )
        frames.append(np.ascontiguousarray(np.rint(frame).astype(np.uint8)))
    return frames


def _check_levels(levels, shape):
    short = min(shape)
    if isinstance(levels, str):
        require_choice("levels", levels, ("auto",))
        return max(1, (short // _COARSEST).bit_length())
    # The coarsest level is then some 4 pixels or more.
    return require_count("levels", levels, low=1, high=max(1, (short // 4).bit_length()))


def _in_units_of(alpha, first, second):
    """Both frames as float32, black the darkest pixel of the first, in units of alpha."""
    black = float(first.min())
    with np.errstate(over="ignore"):
        frames = [
            np.ascontiguousarray((frame.astype(float) - black) / alpha, np.float32)
            for frame in (first, second)
        ]
    peak = max(float(np.abs(frame).max()) for frame in frames)
    # In float32 slopes far above alpha leave nothing of it, and flows are then wild.
    if not peak < 1e6:
        raise ArgumentError(
            f"alpha is {alpha:g} for grey levels of up to {peak * alpha:g}; pass a larger alpha or "
            "scale the frames down."
        )
    return frames


def _slopes(frame):
    """Slopes along x and y, a pixel."""
    return (
        cv2.sepFilter2D(frame, cv2.CV_32F, _SLOPE, _ONE, borderType=_EDGE),
        cv2.sepFilter2D(frame, cv2.CV_32F, _ONE, _SLOPE, borderType=_EDGE),
    )


def _doubled(frame):
    """The frame at twice the resolution; even rows and columns are the frame's own."""
    height, width = frame.shape
    fine = np.empty((2 * height, 2 * width), np.float32)
    fine[::2, ::2] = frame
    fine[::2, 1::2] = _between(frame, _MIDDLE, _ONE, (2, 0))
    fine[1::2, ::2] = _between(frame, _ONE, _MIDDLE, (0, 2))
    fine[1::2, 1::2] = _between(fine[::2, 1::2].copy(), _ONE, _MIDDLE, (0, 2))
    return fine


def _between(frame, along_x, along_y, anchor):
    return cv2.sepFilter2D(frame, cv2.CV_32F, along_x, along_y, anchor=anchor, borderType=_EDGE)


def _warp(fine, u, v):
    """The second frame warped back by (u, v), and which pixels are inside of it.

    OpenCV's cubic interpolation is off by up to 0.05 pixels and knows 32nds of a pixel
    only; linear interpolation at twice the resolution is better by far, and faster.
    """
    height, width = u.shape
    to_x = u + np.arange(width, dtype=np.float32)
    to_y = v + np.arange(height, dtype=np.float32)[:, None]
    inside = (to_x >= 0) & (to_x <= width - 1) & (to_y >= 0) & (to_y <= height - 1)
    to_x *= 2
    to_y *= 2
    return cv2.remap(fine, to_x, to_y, cv2.INTER_LINEAR, borderMode=_EDGE), inside


def _evidence(first, warped, inside, slopes, u, v):
    """What each pixel says of the flow: x·U + y·V + t = 0 for the whole flow (U, V).

    The second frame was warped back by (u, v), which the linear equation is good around;
    what is not `inside` of it (None: all is) says nothing.
    """
    x, y = (
        cv2.addWeighted(a, 0.5, b, 0.5, 0) for a, b in zip(slopes, _slopes(warped), strict=True)
    )
    t = warped - first
    t -= x * u
    t -= y * v
    if inside is not None:
        for part in (x, y, t):
            part *= inside
    return x, y, t


def _iterate(u, v, evidence, space, iterations, tolerance, relaxation):
    """Horn and Schunck's iteration from (u, v), grey levels in units of alpha.

    With g = (x, y) / sqrt(1 + x² + y²) and s = t / sqrt(1 + x² + y²), the mean flow w of the
    neighbours becomes w − g (g·w + s): five passes of multiply and add over the frame.
    All is done in `space`, ten arrays of the frame's shape, and the result lies there.
    """
    x, y, t = evidence
    scale, misfit, minus_x, minus_y, *flows = space
    cv2.multiply(x, x, dst=scale)
    cv2.accumulateProduct(y, y, scale)
    scale += 1
    np.sqrt(scale, out=scale)
    for part in (x, y, t):
        part /= scale
    np.negative(x, out=minus_x)
    np.negative(y, out=minus_y)
    last, now, new = flows[:2], flows[2:4], flows[4:]
    for flow, start in zip(now, (u, v), strict=True):
        np.copyto(flow, start)
    for step in range(iterations):
        for flow, mean in zip(now, new, strict=True):
            cv2.filter2D(flow, cv2.CV_32F, _MEAN, dst=mean, borderType=_EDGE)
        np.copyto(misfit, t)
        cv2.accumulateProduct(x, new[0], misfit)
        cv2.accumulateProduct(y, new[1], misfit)
        cv2.accumulateProduct(minus_x, misfit, new[0])
        cv2.accumulateProduct(minus_y, misfit, new[1])
        if step and relaxation != 1:
            for flow, before in zip(new, last, strict=True):
                cv2.addWeighted(flow, relaxation, before, 1 - relaxation, 0, dst=flow)
        last, now, new = now, new, last
        if tolerance > 0 and (step + 1) % _CHECK_EVERY == 0:
            change = max(cv2.norm(*pair, cv2.NORM_INF) for pair in zip(now, last, strict=True))
            if change <= tolerance:
                break
    return now


def _check_flow(name, flow, *, finite=False):
    return require_array(name, flow, ("height", "width", 2), finite=finite, least=1)


def _known(flow):
    return (np.abs(flow) <= UNKNOWN).all(axis=-1)


def _check_truth(flow, truth):
    """Flow and truth of the known pixels, each (n, 2)."""
    flow, truth = _check_flow("flow", flow), _check_flow("truth", truth)
    require_like(truth, of="truth", flow=flow)
    known = _known(truth)
    if not known.any():
        raise ArgumentError("truth is unknown in every pixel; pass one that knows some.")
    if not np.isfinite(flow[known]).all():
        raise ArgumentError("flow holds values that are not finite where the truth is known.")
    return flow[known], truth[known]
