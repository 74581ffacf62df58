"""Drawing: every ``plot_…`` takes ``ax=None`` and returns the Axes it drew on."""

from mcnlab.plotting.style import (
    GROUP_COLOURS,
    INK,
    METHOD_COLOURS,
    PALE,
    UPPER,
    use_style,
)
from mcnlab.plotting.walks import (
    colour_of,
    group_legend,
    marker_of,
    plot_against_truth,
    plot_boxes,
    plot_curves,
    plot_directions,
    plot_heading_errors,
    plot_horizon,
    plot_lines,
    plot_mask,
    plot_phase,
    plot_phase_space,
    plot_phases,
)

__all__ = [
    "GROUP_COLOURS",
    "INK",
    "METHOD_COLOURS",
    "PALE",
    "UPPER",
    "colour_of",
    "group_legend",
    "marker_of",
    "plot_against_truth",
    "plot_boxes",
    "plot_curves",
    "plot_directions",
    "plot_heading_errors",
    "plot_horizon",
    "plot_lines",
    "plot_mask",
    "plot_phase",
    "plot_phase_space",
    "plot_phases",
    "use_style",
]
