"""Occlusion foreseen: the thesis's tables and equations, pairs, forecasters, scores."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
