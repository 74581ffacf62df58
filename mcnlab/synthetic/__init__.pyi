from .corridor import make_corridor
from .crossings import make_crossings
from .noise import add_noise
from .overhead import render_corridor
from .street import make_street
from .walkers import make_walks

__all__ = [
    "add_noise",
    "make_corridor",
    "make_crossings",
    "make_street",
    "make_walks",
    "render_corridor",
]
