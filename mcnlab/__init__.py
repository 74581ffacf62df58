"""mcnlab: smart surveillance through multi-camera networks, as an executable thesis.

The science of R. Raman, *Study on Models for Smart Surveillance through
Multi-Camera Networks* (NIT Rourkela, 2013), re-run, measured on real people, and
taken further.  Import the module you need (``from mcnlab import phase``); nothing
heavy is imported before that.
"""

__version__ = "0.1.0"
