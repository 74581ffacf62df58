from .direction import measure_phase_space
from .gait import measure_gait
from .heading import measure_headings
from .phase import measure_phases
from .speed import bin_speeds

__all__ = [
    "bin_speeds",
    "measure_gait",
    "measure_headings",
    "measure_phase_space",
    "measure_phases",
]
