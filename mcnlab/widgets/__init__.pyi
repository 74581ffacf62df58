from .benchmark import pair_panel, rules_panel, threshold_panel
from .occlusion import occlusion_panel
from .placement import choice_panel, vote_panel
from .vision import flow_panel
from .walking import (
    gait_panel,
    heading_panel,
    mirror_panel,
    phase_panel,
    separator_panel,
    silhouette_panel,
    speed_panel,
)

__all__ = [
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
