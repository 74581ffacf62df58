"""Live control panels: sliders over thresholds, a figure and a number that follow.

The only package that knows ipywidgets.
"""

from mcnlab.widgets.direction import (
    heading_panel,
    mirror_panel,
    phase_panel,
    separator_panel,
    silhouette_panel,
)
from mcnlab.widgets.panel import Panel

__all__ = [
    "Panel",
    "heading_panel",
    "mirror_panel",
    "phase_panel",
    "separator_panel",
    "silhouette_panel",
]
