"""The register of figures: by number, which notebook shows them and what judges them."""

import inspect
import io
import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

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
        What we see, where no result row says it; else empty.
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
    ids: tuple[str, ...]
    draw: Callable[..., Figure]

    @property
    def file(self) -> str:
        """The picture's file name."""
        return f"{self.number if self.is_table else 'figure-' + self.number}.png"

    @property
    def is_table(self) -> bool:
        """Whether it is a table of the thesis."""
        return bool(self.section) and self.number.startswith("table-")

    @property
    def label(self) -> str:
        """What to call it: "Figure 3.12", "Table 3.1" or "Beyond"."""
        if not self.section:
            return "Beyond"
        return f"{'Table' if self.is_table else 'Figure'} {self.number.removeprefix('table-')}"

    @property
    def place(self) -> tuple[int, int, int]:
        """Where the thesis shows it, to sort by; its tables follow Figure 3.13."""
        chapter, number = map(int, self.number.removeprefix("table-").split("."))
        return (chapter, 13, number) if self.is_table else (chapter, number, 0)


FIGURES: dict[str, Entry] = {}


def show(number: str, *args: Any, **options: Any) -> None:
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

    Examples
    --------
    >>> from mcnlab import figures
    >>> figures.show("3.2")  # no data needed; a notebook shows the picture
    """
    drawn = draw(number, *args, **options)
    out = os.environ.get(OUT)
    if out:
        picture = io.BytesIO()
        # No date and no version: the same picture gives the same bytes.
        drawn.savefig(picture, format="png", metadata={"Software": None})
        write_whole(Path(out) / "figures" / FIGURES[number].file, picture.getvalue())
    plt.show()


def draw(number: str, *args: Any, **options: Any) -> Figure:
    """Draw a figure and return it."""
    if number not in FIGURES:
        raise ArgumentError(f"number is {number!r}; pass one of {', '.join(FIGURES)}.")
    use_style()
    return FIGURES[number].draw(*args, **options)


def figure(
    number: str, *, notebook: str, section: str = "", ids: tuple[str, ...] = ()
) -> Callable[[Callable], Callable]:
    """Enter the decorated function as the figure `number`; see `Entry`.

    Its docstring says the rest: the first line is the title, ``Claim`` or ``Question`` holds
    the claim, and ``Finding``, if there is one, the finding.

    Raises
    ------
    ArgumentError
        When the docstring has no title, not just one of the two sections, or an empty one.
    """

    def register(function):
        title, claim, finding = _read_texts(function)
        FIGURES[number] = Entry(number, title, section, notebook, claim, finding, ids, function)
        return function

    return register


_HEADING = re.compile(r"^(\S.*)\n-+$", re.MULTILINE)


def _read_texts(function):
    """The title, claim and finding in a function's docstring."""
    text, *named = _HEADING.split(inspect.getdoc(function) or "")
    title, _, more = text.strip().partition("\n")
    bodies = {}
    for name, body in zip(named[::2], named[1::2], strict=True):
        bodies.setdefault(name, []).append(" ".join(body.strip().splitlines()))
    fault = ""
    if not title or more.partition("\n")[0].strip():
        fault = "the first line must be the title, and a blank line follow it"
    elif len(asked := bodies.get("Claim", []) + bodies.get("Question", [])) != 1:
        fault = f"it has {len(asked)} sections Claim or Question; write one"
    elif len(found := bodies.get("Finding", [])) > 1:
        fault = f"it has {len(found)} sections Finding; write one at most"
    elif not all(asked + found):
        fault = "a section is empty; write its text below the line"
    if fault:
        raise ArgumentError(f"{function.__qualname__} has a docstring of no figure: {fault}.")
    return title.removesuffix("."), asked[0], "".join(found)
