from . import (
    cameras,
    control,
    datasets,
    figures,
    occlusion,
    placement,
    plotting,
    results,
    synthetic,
    vision,
    walking,
    widgets,
)

__version__: str

__all__ = [
    "cameras",
    "control",
    "datasets",
    "figures",
    "occlusion",
    "placement",
    "plotting",
    "results",
    "synthetic",
    "vision",
    "walking",
    "widgets",
]
