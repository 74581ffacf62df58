"""Live control panels: sliders over thresholds, a figure and a number that follow.

The only package that knows ipywidgets.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
