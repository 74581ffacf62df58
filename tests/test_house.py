"""The house: modules import only from those above them, and nothing heavy too early."""

import ast
import subprocess
import sys
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent.parent / "mcnlab"
# From the ground up: a module may import from those before it.
HOUSE = [
    "errors",
    "checks",
    "columns",
    "files",
    "results",
    "lines",
    "ground",
    "datasets.recording",
    "datasets.scene",
    "datasets.casia",
    "datasets.mirror",
    "datasets.pedestrians",
    "datasets.motchallenge",
    "datasets.cameramotion",
    "datasets.trajectories",
    "datasets.video",
    "datasets.middlebury",
    "datasets.motions",
    "datasets.walkers",
    "datasets.crossings",
    "datasets.noise",
    "datasets.composites",
    "datasets.corridor",
    "datasets.overhead",
    "silhouettes",
    "flow",
    "feet",
    "traces",
    "cells",
    "placement",
    "coverage",
    "solvers",
    "covering",
    "control",
    "phase",
    "gait",
    "viewpoint",
    "direction",
    "perspective",
    "speed",
    "pace",
    "occlusion",
    "pairs",
    "motion",
    "prediction",
    "comparison",
    "bundled",
    "bundling",
    "scoring",
    "resampling",
    "evaluation",
    "composing",
    "verdicts",
    "cases",
    "siting",
    "foresight",
    "plotting.style",
    "plotting.walks",
    "plotting.speed",
    "plotting.occlusion",
    "plotting.foresight",
    "plotting.pairs",
    "plotting.gait",
    "plotting.places",
    "plotting.images",
    "figures.registry",
    "figures.direction",
    "figures.speed",
    "figures.occlusion",
    "figures.foresight",
    "figures.gait",
    "figures.tracing",
    "figures.voting",
    "figures.choosing",
    "widgets.panel",
    "widgets.direction",
    "widgets.speed",
    "widgets.occlusion",
    "widgets.foresight",
    "widgets.siting",
    "report",
    "reproduction",
    "peers",
    "bench",
]


def imports_of(path):
    """The mcnlab modules that a file imports, anywhere in it; of a package, all of them."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("mcnlab"):
            base = node.module.removeprefix("mcnlab").lstrip(".")
            for name in node.names:
                inner = f"{base}.{name.name}".lstrip(".")
                found.add(inner if inner in HOUSE else base)
    whole = {name for name in HOUSE if name.split(".")[0] in found}
    return (found - {name.split(".")[0] for name in whole} | whole) - {""}


def test_modules_import_only_from_above():
    files = {
        ".".join(path.relative_to(PACKAGE).with_suffix("").parts): path
        for path in PACKAGE.rglob("*.py")
        if not path.stem.startswith("__")
    }
    assert sorted(files) == sorted(HOUSE)
    for number, name in enumerate(HOUSE):
        assert imports_of(files[name]) <= set(HOUSE[:number]), name


def test_science_knows_neither_matplotlib_nor_ipywidgets():
    for name in HOUSE[: HOUSE.index("plotting.style")]:
        text = (PACKAGE / f"{name.replace('.', '/')}.py").read_text()
        assert "matplotlib" not in text, name
        assert "ipywidgets" not in text, name


def test_importing_the_package_imports_nothing_heavy():
    code = "import sys, mcnlab; print(' '.join(sorted(sys.modules)))"
    held = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    ).stdout.split()
    assert "mcnlab" in held
    assert not {"numpy", "pandas", "cv2", "scipy", "sklearn", "matplotlib"} & set(held)
