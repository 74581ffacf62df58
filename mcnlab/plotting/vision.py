"""Frames and what was found in them: flow, silhouettes, feet."""

from typing import Final

import numpy as np
from matplotlib.axes import Axes

from mcnlab.checks import require_count, require_number
from mcnlab.errors import ArgumentError
from mcnlab.plotting.style import PALE, UPPER, axes_or_new
from mcnlab.vision.flow import _check_flow, _known


def plot_frame(frame, *, title="", feet=None, ax: Axes | None = None) -> Axes:
    """A grey or RGB frame, with the feet found in it.

    Parameters
    ----------
    frame : ndarray, shape (height, width) or (height, width, 3)
    title : str, optional
    feet : array_like, shape (n, 2), optional
        Pixels.
    ax : matplotlib.axes.Axes, optional
    """
    ax = axes_or_new(ax)
    grey = {"cmap": "gray", "vmin": 0, "vmax": 255} if np.ndim(frame) == 2 else {}
    ax.imshow(frame, **grey)
    if feet is not None and len(feet):
        feet = np.asarray(feet, float)
        ax.plot(feet[:, 0], feet[:, 1], "o", ms=6, mfc="none", mec=UPPER, mew=1.6, label="feet")
    height, width = np.shape(frame)[:2]
    ax.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5), xticks=[], yticks=[])
    ax.set_title(title, fontsize=10)
    ax.grid(False)
    for spine in ax.spines.values():
        spine.set(visible=True, color=PALE)
    return ax


def plot_flow(colours, wheel, *, largest, title="", ax: Axes | None = None) -> Axes:
    """A flow field in colour, with the wheel that says which colour goes where.

    Parameters
    ----------
    colours : ndarray of uint8, shape (height, width, 3)
    wheel : ndarray of uint8, shape (size, size, 3)
    largest : float
        Pixels a frame, at the wheel's rim.
    title : str, optional
    ax : matplotlib.axes.Axes, optional
    """
    ax = plot_frame(colours, title=title, ax=ax)
    inset = ax.inset_axes((0.8, 0.02, 0.18, 0.3), zorder=5)
    inset.imshow(wheel)
    inset.set_aspect("equal")
    inset.set_title(f"{largest:.1f} px", fontsize=7, fontweight="normal", loc="center", pad=2)
    inset.axis("off")
    return ax


# The colour wheel of Baker et al.: hues from red on, each run of so many steps.
_WHEEL_STEPS: Final = (15, 6, 4, 11, 13, 6)
_WHEEL: Final = ((1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1), (1, 0, 1), (1, 0, 0))


def colour_flow(flow: np.ndarray, *, largest: float | None = None) -> np.ndarray:
    """A flow in the colours of Middlebury (Baker et al.): hue is direction, strength speed.

    Parameters
    ----------
    flow : array_like, shape (height, width, 2)
        Pixels; NaN or beyond ±1e9 where it is not known.
    largest : float, optional
        Speed of full colour, pixels; faster is darker.  The fastest pixel's if not given.

    Returns
    -------
    ndarray of uint8, shape (height, width, 3)
        RGB: white is rest, red right, yellow down, cyan left, blue up, black not known.

    Raises
    ------
    ArgumentError
        When `flow` is no flow, knows no pixel, or `largest` is not positive.
    """
    flow = _check_flow("flow", flow)
    known = _known(flow)
    if not known.any():
        raise ArgumentError("flow holds no pixel that is known; pass a flow with finite values.")
    flow = np.where(known[..., None], flow, 0.0)
    speed = np.hypot(flow[..., 0], flow[..., 1])
    if largest is None:
        largest = float(speed.max()) or 1.0  # at rest everywhere: all white
    largest = require_number("largest", largest, above=0, unit="pixels")
    turn = np.arctan2(flow[..., 1], flow[..., 0]) / (2 * np.pi) % 1.0
    places = np.cumsum((0, *_WHEEL_STEPS)) / sum(_WHEEL_STEPS)
    hue = np.stack([np.interp(turn, places, channel) for channel in zip(*_WHEEL, strict=True)], -1)
    strength = (speed / largest)[..., None]
    colour = np.where(strength <= 1, 1 - strength * (1 - hue), 0.75 * hue)
    return np.where(known[..., None], np.rint(255 * colour), 0).astype(np.uint8)


def colour_legend(size: int) -> np.ndarray:
    """The colour wheel: what `colour_flow` paints an arrow from the middle to each pixel.

    Parameters
    ----------
    size : int
        Side of the image, pixels.

    Returns
    -------
    ndarray of uint8, shape (size, size, 3)
        RGB; the circle of full colour touches the sides, white beyond.

    Raises
    ------
    ArgumentError
        When `size` is not a whole number of at least 2.
    """
    size = require_count("size", size, low=2)
    steps = np.linspace(-1, 1, size)
    arrows = np.stack(np.meshgrid(steps, steps), axis=-1)
    wheel = colour_flow(arrows, largest=1.0)
    wheel[np.hypot(*arrows.T).T > 1] = 255
    return wheel
