from .camera import Camera
from .floor import GridMap
from .homography import find_homography, project
from .horizon import estimate_camera
from .visibility import CameraModel

__all__ = [
    "Camera",
    "CameraModel",
    "GridMap",
    "estimate_camera",
    "find_homography",
    "project",
]
