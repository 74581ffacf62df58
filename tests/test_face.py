"""The faces of the rooms: few names, each there, typed, and shown by an example."""

import ast
import importlib
import inspect
import pkgutil
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
MODULES = sorted(
    found.name
    for found in pkgutil.walk_packages(mcnlab.__path__, "mcnlab.")
    if not found.name.endswith("__main__")
)


def untyped(name, called):
    """What a function leaves without a type."""
    signature = inspect.signature(called)
    missing = [
        f"{name}({one.name})"
        for one in signature.parameters.values()
        if one.annotation is one.empty and one.name not in ("self", "cls")
    ]
    if not inspect.isclass(called) and signature.return_annotation is signature.empty:
        missing.append(f"{name} → ?")
    return missing


def public_functions(module):
    """Name → each public function, method and property that a module defines."""
    for name, held in vars(module).items():
        if name.startswith("_") or getattr(held, "__module__", None) != module.__name__:
            continue
        if inspect.isfunction(held):
            yield name, held
        elif inspect.isclass(held):
            for inner, kept in vars(held).items():
                made = kept.fget if isinstance(kept, property) else kept
                made = getattr(made, "func", getattr(made, "__func__", made))
                own = getattr(made, "__module__", None) == module.__name__
                if not inner.startswith("_") and inspect.isfunction(made) and own:
                    yield f"{name}.{inner}", made


@pytest.mark.parametrize(("room", "name"), FACE)
def test_a_name_is_there_with_types_and_an_example(room, name):
    held = getattr(importlib.import_module(f"mcnlab.{room}"), name)
    said = inspect.getdoc(held)
    assert said
    assert "Examples\n--------\n" in said
    assert ">>> " in said.split("Examples\n--------\n")[1]
    assert not untyped(name, held)


def test_a_face_lists_what_it_holds():
    for path in STUBS:
        room = importlib.import_module(f"mcnlab.{path.parent.name}")
        names = [name for where, name in FACE if where == path.parent.name]
        assert sorted(room.__all__) == sorted(names) == sorted(dir(room)), path


def test_the_faces_are_small():
    assert len(FACE) == len(set(FACE)) <= 60
    assert len([one for one in PACKAGE.glob("*.py") if one.name != "__init__.py"]) <= 12


@pytest.mark.parametrize("name", MODULES)
def test_public_functions_say_what_they_return(name):
    module = importlib.import_module(name)
    functions = dict(public_functions(module))
    missing = [
        one
        for one, held in functions.items()
        if inspect.signature(held).return_annotation is inspect.Signature.empty
    ]
    assert not missing
