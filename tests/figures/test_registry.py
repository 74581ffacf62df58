"""The register of figures: what each says, and what a reproduction keeps."""

import matplotlib.pyplot as plt
import pytest

from mcnlab import figures
from mcnlab.errors import ArgumentError
from mcnlab.figures import registry
from mcnlab.figures.registry import FIGURES, NOTEBOOKS, draw

THESIS = [
    *(f"2.{number}" for number in range(1, 12)),
    *(f"3.{number}" for number in range(2, 14)),
    *(f"table-3.{number}" for number in range(1, 4)),
    *("3.14", "3.15"),
]


def test_every_thesis_figure_of_the_section_is_registered():
    registered = [number for number, entry in FIGURES.items() if entry.section]
    assert sorted(registered) == sorted(THESIS)


def test_every_figure_says_what_it_asks_and_what_is_seen():
    for entry in FIGURES.values():
        assert entry.title, entry.number
        assert not entry.title.endswith("."), entry.number
        assert entry.claim, entry.number
        assert entry.finding or entry.ids, entry.number
        assert entry.notebook in NOTEBOOKS, entry.number


def test_unknown_figure_is_named():
    with pytest.raises(ArgumentError, match=r"9\.9"):
        draw("9.9")


def test_a_reproduction_keeps_the_picture_and_repeats_it(tmp_path, monkeypatch):
    monkeypatch.setenv("MCNLAB_OUT", str(tmp_path))
    monkeypatch.setattr(plt, "show", lambda: None)
    figures.show("geometry")
    first = (tmp_path / "figures" / "figure-geometry.png").read_bytes()
    figures.show("geometry")
    assert (tmp_path / "figures" / "figure-geometry.png").read_bytes() == first
    assert [path.name for path in (tmp_path / "figures").iterdir()] == ["figure-geometry.png"]


def test_texts_are_read_from_the_docstring(monkeypatch):
    monkeypatch.setattr(registry, "FIGURES", {})

    @registry.figure("9.9", notebook="start_here", section="9", ids=("a.b",))
    def made():
        """A title.

        What is drawn.

        Claim
        -----
        That lines
        are joined.

        Finding
        -------
        So they are.

        Parameters
        ----------
        none
        """

    entry = registry.FIGURES["9.9"]
    assert (entry.title, entry.claim, entry.finding) == (
        "A title",
        "That lines are joined.",
        "So they are.",
    )
    assert (entry.section, entry.notebook, entry.ids, entry.draw) == (
        *("9", "start_here", ("a.b",)),
        made,
    )


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (None, "first line must be the title"),
        ("Claim\n-----\nNo title.", "first line must be the title"),
        ("A title\nof two lines.\n\nClaim\n-----\nSaid.", "blank line"),
        ("A title.", "0 sections Claim or Question"),
        ("A title.\n\nClaim\n-----\nOne.\n\nQuestion\n--------\nTwo?", "2 sections"),
        ("A title.\n\nClaim\n-----\n\nFinding\n-------\nSeen.", "section is empty"),
        ("Title.\n\nClaim\n---\nA.\n\nFinding\n---\nB.\n\nFinding\n---\nC.", "2 sections"),
    ],
)
def test_a_docstring_of_no_figure_is_refused(monkeypatch, text, fault):
    monkeypatch.setattr(registry, "FIGURES", {})

    def made():
        pass

    made.__doc__ = text
    with pytest.raises(ArgumentError, match=f"made.*{fault}"):
        registry.figure("9.9", notebook="start_here")(made)
    assert not registry.FIGURES
