"""The house: a room imports only from rooms above it, and nothing heavy too early."""

import ast
import subprocess
import sys
from graphlib import TopologicalSorter
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent.parent / "mcnlab"
# From the ground up: a room (a module or a package) may import from itself and those before it.
ROOMS = [
    "errors",
    "files",
    "checks",
    "compass",
    "tables",
    "regression",
    "statistics",
    "results",
    "cameras",
    "datasets",
    "synthetic",
    "placement",
    "vision",
    "walking",
    "occlusion",
    "control",
    "plotting",
    "figures",
    "widgets",
    "lab",
    "__main__",
]
SCIENCE = ROOMS[: ROOMS.index("plotting")]
FILES = {
    ".".join(path.relative_to(PACKAGE).with_suffix("").parts): path
    for path in sorted(PACKAGE.rglob("*.py"))
    if path.name != "__init__.py"
}


TESTS = PACKAGE.parent / "tests"
OF_THE_WHOLE = {"house", "face", "notebooks", "readme", "real_data"}
DRAWING = ("plotting", "figures", "widgets")
TOOLS = {"style", "registry", "panel"}  # of the drawing rooms


def imports_of(path):
    """The rooms and modules of mcnlab that a file imports, anywhere in it."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "mcnlab":
            base = node.module.removeprefix("mcnlab").lstrip(".")
            inner = {f"{base}.{name.name}".lstrip(".") for name in node.names}
            found |= {name if name in FILES or not base else base for name in inner}
    return found


def room_of(module):
    """The room that a module is or lies in."""
    return module.split(".")[0]


def test_every_file_lies_in_a_room():
    assert {room_of(name) for name in FILES} == set(ROOMS)


def test_rooms_import_only_from_above():
    for name, path in FILES.items():
        allowed = ROOMS[: ROOMS.index(room_of(name)) + 1]
        for other in imports_of(path) - {"__version__"}:
            assert room_of(other) in allowed, f"{name} imports {other}"


def test_no_circle_among_the_modules_of_a_room():
    graph = {name: imports_of(path) & set(FILES) for name, path in FILES.items()}
    assert len(list(TopologicalSorter(graph).static_order())) == len(FILES)


def test_science_knows_neither_matplotlib_nor_ipywidgets():
    for name, path in FILES.items():
        if room_of(name) in SCIENCE:
            text = path.read_text()
            assert "matplotlib" not in text, name
            assert "ipywidgets" not in text, name


def test_importing_the_package_imports_nothing_heavy():
    code = "import sys, mcnlab; print(' '.join(sorted(sys.modules)))"
    held = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    ).stdout.split()
    assert "mcnlab" in held
    assert not {"numpy", "pandas", "cv2", "scipy", "sklearn", "matplotlib"} & set(held)


def test_tests_mirror_the_package():
    for path in TESTS.rglob("test_*.py"):
        inner = path.relative_to(TESTS)
        if inner.parts[0] == "bench":
            continue
        module = ".".join((*inner.parts[:-1], path.stem.removeprefix("test_")))
        assert module in FILES or module in OF_THE_WHOLE, inner


def test_drawing_modules_are_named_after_what_they_draw():
    subjects = {part for name in FILES if room_of(name) in SCIENCE for part in name.split(".")}
    for name in FILES:
        if room_of(name) in DRAWING:
            assert name.split(".")[1] in subjects | TOOLS, name
