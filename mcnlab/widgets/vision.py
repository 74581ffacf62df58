"""Live panel: thresholds of optical flow."""

import numpy as np

from mcnlab.plotting.vision import colour_flow, colour_legend, plot_flow, plot_frame
from mcnlab.vision import flow
from mcnlab.widgets.panel import Panel, choices, decimal_slider, slider


def flow_panel(frames: tuple[np.ndarray, np.ndarray]) -> Panel:
    """Horn and Schunck's weight, iterations and the speed threshold, on two frames.

    Parameters
    ----------
    frames : (ndarray, ndarray)
        Two grey frames of one size, one after the other.

    Examples
    --------
    >>> from mcnlab.synthetic.shifts import make_motion
    >>> moved = make_motion("parting", shape=(48, 64))
    >>> list(flow_panel((moved.first, moved.second)).controls)
    ['alpha', 'iterations', 'speed', 'pyramid']
    """
    first, second = frames
    wheel = colour_legend(48)

    def draw(left, right, alpha, iterations, speed, pyramid):
        find = flow.horn_schunck if pyramid else flow.horn_schunck_plain
        motion = find(first, second, alpha=alpha, iterations=iterations)
        mask = flow.moving_mask(motion, speed=speed)
        plot_flow(colour_flow(motion, largest=3.0), wheel, largest=3.0, ax=left)
        plot_frame(255 - mask, ax=right)
        return f"moving: <b>{np.mean(mask > 0):.1%}</b> of the pixels"

    return Panel(
        draw,
        {
            "alpha": decimal_slider("weight α (grey levels)", 1, 40, flow.ALPHA, step=1),
            "iterations": slider("iterations", 5, 200, 20, step=5),
            "speed": decimal_slider("speed (px a frame)", 0.1, 3, 0.5, step=0.1),
            "pyramid": choices("flow", [("pyramid", True), ("one level, as in 1981", False)]),
        },
        columns=2,
        figsize=(8, 2.9),
        margins={"left": 0.01, "right": 0.99, "bottom": 0.02, "top": 0.98, "wspace": 0.04},
    )
