"""What all tests of drawing share: no window, and figures closed."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import pytest

from mcnlab.plotting.style import use_style


@pytest.fixture(autouse=True)
def closed():
    """Each test draws with the package's look, and no figure outlives it."""
    use_style()
    yield
    plt.close("all")
