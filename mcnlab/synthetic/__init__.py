"""What is made, with truth: walkers, crossings, a street, a corridor, noise and shifts."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
