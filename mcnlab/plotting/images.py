"""Frames and what was found in them: flow, silhouettes, feet."""

import numpy as np

from mcnlab.plotting.style import PALE, UPPER, axes_or_new


def plot_frame(frame, *, title="", feet=None, ax=None):
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


def plot_flow(colours, wheel, *, largest, title="", ax=None):
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
