"""The register of figures: by number, which notebook shows them and what judges them."""

import io
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt

from mcnlab.errors import ArgumentError
from mcnlab.files import write_whole
from mcnlab.plotting.style import use_style
from mcnlab.results import OUT

START = "start_here"
SQUARE, ABOVE = "see_gait_square_on", "trace_walkers_from_above"
VOTE, EXACT = "vote_for_camera_places", "place_cameras_exactly"
MIRROR, TRACE = "mirror_casia_a", "trace_silhouette_curves"
SEPARATE, READ = "separate_directions_in_phase_space", "read_heading_from_perspective"
SPEED = "bin_apparent_speed"
TABULATE = "tabulate_occlusion"
FORESEE = "foresee_occlusion"

# In reading order.
NOTEBOOKS = (
    START,
    SQUARE,
    ABOVE,
    VOTE,
    EXACT,
    MIRROR,
    TRACE,
    SEPARATE,
    READ,
    SPEED,
    TABULATE,
    FORESEE,
)


@dataclass(frozen=True)
class Entry:
    """One figure of the report.

    Attributes
    ----------
    number : str
        The thesis's number of a figure, ``"3.12"``, or of a table, ``"table-3.1"``; or a
        name.
    title : str
    section : str
        Of the thesis; empty beyond it.
    notebook : str
        Its file name without the ending.
    claim : str
        What the thesis says of it, in our words; or what the figure asks.
    finding : str
        What we see, where no result row says it.
    ids : tuple of str
        The result rows that judge it.
    draw : callable
        Returns the matplotlib figure.
    """

    number: str
    title: str
    section: str
    notebook: str
    claim: str
    finding: str
    ids: tuple
    draw: Callable

    @property
    def file(self):
        """The picture's file name."""
        return f"{self.number if self.is_table else 'figure-' + self.number}.png"

    @property
    def is_table(self):
        """Whether it is a table of the thesis."""
        return bool(self.section) and self.number.startswith("table-")

    @property
    def label(self):
        """What to call it: "Figure 3.12", "Table 3.1" or "Beyond"."""
        if not self.section:
            return "Beyond"
        return f"{'Table' if self.is_table else 'Figure'} {self.number.removeprefix('table-')}"

    @property
    def place(self):
        """Where the thesis shows it, to sort by; its tables follow Figure 3.13."""
        chapter, number = map(int, self.number.removeprefix("table-").split("."))
        return (chapter, 13, number) if self.is_table else (chapter, number, 0)


FIGURES: dict[str, Entry] = {}


def show(number, *args, **options):
    """Draw a figure, keep its picture if reproducing, and show it.

    Parameters
    ----------
    number : str
        As in ``FIGURES``: ``"3.12"``.
    *args, **options
        What the figure's function takes.

    Raises
    ------
    ArgumentError
        When there is no such figure.
    """
    drawn = draw(number, *args, **options)
    out = os.environ.get(OUT)
    if out:
        picture = io.BytesIO()
        # No date and no version: the same picture gives the same bytes.
        drawn.savefig(picture, format="png", metadata={"Software": None})
        write_whole(Path(out) / "figures" / FIGURES[number].file, picture.getvalue())
    plt.show()


def draw(number, *args, **options):
    """Draw a figure and return it."""
    if number not in FIGURES:
        raise ArgumentError(f"number is {number!r}; pass one of {', '.join(FIGURES)}.")
    use_style()
    return FIGURES[number].draw(*args, **options)


def figure(number, title, *, notebook, claim, section="", finding="", ids=()):
    """Enter the decorated function as the figure `number`; see `Entry`."""

    def register(function):
        FIGURES[number] = Entry(number, title, section, notebook, claim, finding, ids, function)
        return function

    return register
