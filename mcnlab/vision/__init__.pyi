from .flow import horn_schunck
from .recordings import casia_a, pets2009_scene, scenes
from .silhouettes import measure_sequence
from .traces import trace_video

__all__ = [
    "casia_a",
    "horn_schunck",
    "measure_sequence",
    "pets2009_scene",
    "scenes",
    "trace_video",
]
