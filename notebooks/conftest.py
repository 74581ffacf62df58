"""How nbval checks the notebooks: on bundled data, against every kept output."""

import os
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def pytest_configure(config):
    """Let the kernels find the package, and nothing outside the repository."""
    os.environ.pop("MCNLAB_DATA", None)
    os.environ.pop("MCNLAB_OUT", None)
    held = os.environ.get("PYTHONPATH")
    os.environ["PYTHONPATH"] = os.pathsep.join([str(ROOT), *([held] if held else [])])
