"""The faces of the rooms: few names, each there."""

import ast
import importlib
import inspect
from pathlib import Path

import pytest

import mcnlab

PACKAGE = Path(mcnlab.__file__).parent
STUBS = sorted(PACKAGE.glob("*/__init__.pyi"))
# The figures' face is no stub: all its modules enter their figures when it is imported.
FACE = [("figures", "show")] + [
    (path.parent.name, alias.name)
    for path in STUBS
    for node in ast.parse(path.read_text()).body
    if isinstance(node, ast.ImportFrom)
    for alias in node.names
]


@pytest.mark.parametrize(("room", "name"), FACE)
def test_a_name_is_there_and_says_what_it_is(room, name):
    assert inspect.getdoc(getattr(importlib.import_module(f"mcnlab.{room}"), name))


def test_a_face_lists_what_it_holds():
    for path in STUBS:
        room = importlib.import_module(f"mcnlab.{path.parent.name}")
        names = [name for where, name in FACE if where == path.parent.name]
        assert sorted(room.__all__) == sorted(names) == sorted(dir(room)), path


def test_the_faces_are_small():
    assert len(FACE) == len(set(FACE)) <= 60
    assert len([one for one in PACKAGE.glob("*.py") if one.name != "__init__.py"]) <= 12
