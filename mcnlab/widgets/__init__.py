"""Live control panels: sliders over thresholds, a figure and a number that follow.

The only package that knows ipywidgets.
"""

from mcnlab.widgets.benchmark import pair_panel, rules_panel, threshold_panel
from mcnlab.widgets.occlusion import TablePicker, occlusion_panel
from mcnlab.widgets.panel import CellPicker, Panel
from mcnlab.widgets.placement import choice_panel, vote_panel
from mcnlab.widgets.vision import flow_panel
from mcnlab.widgets.walking import (
    gait_panel,
    heading_panel,
    mirror_panel,
    phase_panel,
    separator_panel,
    silhouette_panel,
    speed_panel,
)

__all__ = [
    "CellPicker",
    "Panel",
    "TablePicker",
    "choice_panel",
    "flow_panel",
    "gait_panel",
    "heading_panel",
    "mirror_panel",
    "occlusion_panel",
    "pair_panel",
    "phase_panel",
    "rules_panel",
    "separator_panel",
    "silhouette_panel",
    "speed_panel",
    "threshold_panel",
    "vote_panel",
]
