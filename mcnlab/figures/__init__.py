"""The figures by number: ``show("3.12", …)`` draws the thesis's Figure 3.12.

A notebook shows each figure that it covers; a reproduction keeps the picture as
``figure-3.12.png``.  Figures that go beyond the thesis have names instead of numbers.
Every module of this package enters its own figures when it is imported, and all are.
"""

import importlib
import pkgutil

from mcnlab.figures.registry import show

__all__ = ["show"]

for _found in pkgutil.iter_modules(__path__):
    importlib.import_module(f"{__name__}.{_found.name}")
