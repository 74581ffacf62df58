"""From boxes to direction, heading and speed (thesis section 3.2)."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
