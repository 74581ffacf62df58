"""The figures by number: ``show("3.12", …)`` draws the thesis's Figure 3.12.

A notebook shows each figure that it covers; a reproduction keeps the picture as
``figure-3.12.png``.  Figures that go beyond the thesis have names instead of numbers.
"""

# Chapter by chapter; each module enters its figures.
from mcnlab.figures import (  # noqa: F401
    choosing,
    direction,
    foresight,
    gait,
    occlusion,
    speed,
    tracing,
    voting,
)
from mcnlab.figures.direction import example_walk
from mcnlab.figures.registry import FIGURES, NOTEBOOKS, START, draw, show

__all__ = ["FIGURES", "NOTEBOOKS", "START", "draw", "example_walk", "show"]
