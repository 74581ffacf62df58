"""mcnlab: smart surveillance through multi-camera networks, as an executable thesis.

The science of R. Raman, *Study on Models for Smart Surveillance through
Multi-Camera Networks* (NIT Rourkela, 2013), re-run, measured on real people, and
taken further.  Import the room you need (``from mcnlab import walking``) and use the
names of its face (``walking.measure_headings``); nothing heavy is imported before that.
"""

import lazy_loader

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
