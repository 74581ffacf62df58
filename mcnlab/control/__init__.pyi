from .pan_tilt import PanTilt, simulate

__all__ = [
    "PanTilt",
    "simulate",
]
