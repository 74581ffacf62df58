"""From video to boxes and traces: silhouettes, optical flow, feet (thesis sections 2.3, 3.1)."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
