"""Which camera is awake, and where it looks (thesis sections 2.2.5 and 3.4)."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
