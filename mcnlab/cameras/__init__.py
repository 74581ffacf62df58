"""Cameras and the ground: lens and pose, homographies, the grid map, who sees what."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
