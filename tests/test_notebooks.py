"""The notebooks, the README and the figure registry say the same, and are clean."""

import json
import re
from pathlib import Path

import pytest

from mcnlab.figures.registry import FIGURES, NOTEBOOKS, START

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / "notebooks"


def cells_of(name, kind="code"):
    """A notebook's cells of one kind."""
    held = json.loads((FOLDER / f"{name}.ipynb").read_text())
    return [cell for cell in held["cells"] if cell["cell_type"] == kind]


def text_of(cell):
    """A cell's source."""
    return "".join(cell["source"])


def test_the_registry_lists_just_the_notebooks_there_are():
    assert sorted(NOTEBOOKS) == sorted(path.stem for path in FOLDER.glob("*.ipynb"))


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_run_top_to_bottom_without_error_or_noise(name):
    cells = cells_of(name)
    assert [cell["execution_count"] for cell in cells] == list(range(1, len(cells) + 1))
    outputs = [output for cell in cells for output in cell["outputs"]]
    assert outputs
    assert not [output for output in outputs if output["output_type"] == "error"]
    assert not [output for output in outputs if output.get("name") == "stderr"]


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_no_metadata_that_changes_by_itself(name):
    held = json.loads((FOLDER / f"{name}.ipynb").read_text())
    assert set(held["metadata"]) == {"kernelspec"}
    assert all(set(cell["metadata"]) <= {"tags"} for cell in held["cells"])
    assert "widget-view+json" not in json.dumps(held)


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_plumbing_lives_in_the_package(name):
    for cell in cells_of(name):
        lines = [line for line in text_of(cell).splitlines() if line.strip()]
        imports = all(re.match(r"import|from|plotting\.use_style", line) for line in lines)
        assert imports or len(lines) <= 10, text_of(cell)


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_anatomy(name):
    prose = [text_of(cell) for cell in cells_of(name, "markdown")]
    code = cells_of(name)
    for part in ("What you'll do", "What you'll learn", "What you'll need"):
        assert part in prose[0], part
    for part in ("## On your own", "## In practice", "## Further reading"):
        assert part in prose[-1], part
    tags = [cell["metadata"].get("tags", []) for cell in code]
    assert tags[1] == ["parameters"]
    assert sum("results.show()" in text_of(cell) for cell in code) == 1
    live = [
        text_of(cell) for cell, held in zip(code, tags, strict=True) if "widgets." in text_of(cell)
    ]
    assert len(live) == 1
    assert "nbval-ignore-output" in tags[-1]
    # Only the live panel escapes the strict comparison.
    assert sum("nbval-ignore-output" in held for held in tags) == 1


def test_each_figure_is_shown_in_the_notebook_that_the_registry_names():
    shown = {}
    for name in NOTEBOOKS:
        for cell in cells_of(name):
            for number in re.findall(r'figures\.show\("([^"]+)"', text_of(cell)):
                assert number not in shown, f"{number} is shown twice"
                shown[number] = name
    assert shown == {number: entry.notebook for number, entry in FIGURES.items()}


def test_every_result_id_of_the_registry_is_reported():
    reported = set()
    for name in NOTEBOOKS:
        for cell in cells_of(name):
            for output in cell["outputs"]:
                printed = "".join(output.get("text", ""))
                reported |= set(re.findall(r"^([a-z][\w.-]+) +\|", printed, flags=re.MULTILINE))
    for entry in FIGURES.values():
        assert set(entry.ids) <= reported, entry.number


def test_the_readme_lists_every_thesis_figure_with_its_notebook():
    readme = (ROOT / "README.md").read_text()
    rows = re.findall(
        r"^\| ((?:Figure|Table)s? [^|]+?) \| .*?\]\(notebooks/(\w+)\.ipynb\)", readme, re.M
    )
    listed = {}
    for numbers, notebook in rows:
        kind = ""
        for number in numbers.split(", "):
            said = re.match(r"(Figure|Table)s? ", number)
            if said:
                kind, number = {"Figure": "", "Table": "table-"}[said[1]], number[said.end() :]
            first, _, last = number.partition("–")
            chapter, start = first.split(".")
            stop = (last or first).split(".")[1]
            for place in range(int(start), int(stop) + 1):
                listed[f"{kind}{chapter}.{place}"] = notebook
    assert listed == {number: entry.notebook for number, entry in FIGURES.items() if entry.section}


def test_the_index_notebook_links_all_notebooks_in_order():
    prose = "\n".join(text_of(cell) for cell in cells_of(START, "markdown"))
    assert tuple(re.findall(r"^\| \[\w+\]\((\w+)\.ipynb\)", prose, flags=re.MULTILINE)) == NOTEBOOKS


def test_both_commands_are_in_the_readme_and_the_makefile():
    readme, makefile = (ROOT / "README.md").read_text(), (ROOT / "Makefile").read_text()
    for command in ("reproduce", "test", "lab", "bench"):
        assert f"make {command}" in readme
        assert re.search(rf"^{command}:", makefile, flags=re.MULTILINE)
    assert "make test" in (ROOT / ".ci" / "run").read_text()


def test_the_environment_is_pinned_and_ends_with_the_package():
    lines = [
        line
        for line in (ROOT / "environment.txt").read_text().splitlines()
        if not line.startswith("#")
    ]
    assert lines[-1] == "-e ."
    assert all(re.fullmatch(r"[A-Za-z0-9_.\-]+==[\w.!+]+", line) for line in lines[:-1])
    pinned = {re.sub(r"[-_.]+", "-", line.split("==")[0]).lower() for line in lines[:-1]}
    project = (ROOT / "pyproject.toml").read_text()
    named = re.findall(r'^    "([A-Za-z0-9-]+)[<>=]', project, flags=re.MULTILINE)
    assert {name.lower() for name in named} <= pinned
