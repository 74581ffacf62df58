from .benchmark import judge, learn
from .composites import compose_all
from .pairs import find_pairs, watch
from .thesis import direction_table, foresee, speed_table

__all__ = [
    "compose_all",
    "direction_table",
    "find_pairs",
    "foresee",
    "judge",
    "learn",
    "speed_table",
    "watch",
]
