from .motchallenge import read_sequence
from .recording import Recording
from .scene import Scene
from .trajectories import read_scenes
from .video import open_video

__all__ = [
    "Recording",
    "Scene",
    "open_video",
    "read_scenes",
    "read_sequence",
]
