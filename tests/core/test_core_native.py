"""The compiled core: its stubs name what it has, and what goes wrong in it is an error."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import patterndb
from patterndb import _native
from patterndb._native.core.halfedge import fans

STUBS = Path(patterndb.__file__).parent / "_native"


def list_stubs() -> dict[str, dict[str, list[str]]]:
    """Parameters of each function of the stubs, by module."""
    found: dict[str, dict[str, list[str]]] = {}
    for path in sorted(STUBS.rglob("*.pyi")):
        place = path.relative_to(STUBS.parent).with_suffix("")
        name = ".".join(("patterndb", *place.parts)).removesuffix(".__init__")
        found[name] = {
            node.name: [one.arg for one in (*node.args.posonlyargs, *node.args.args)]
            for node in ast.parse(path.read_text(encoding="utf-8")).body
            if isinstance(node, ast.FunctionDef)
        }
    return found


def walk_modules(module: ModuleType) -> Iterator[ModuleType]:
    yield module
    for held in vars(module).values():
        if isinstance(held, ModuleType):
            yield from walk_modules(held)


def test_the_stubs_are_of_what_is_bound() -> None:
    stubs = list_stubs()
    bound = {
        module.__name__: {
            name: list(inspect.signature(held).parameters)
            for name, held in vars(module).items()
            if callable(held) and not name.startswith("__")
        }
        for module in walk_modules(_native)
    }
    assert bound == stubs


def test_every_function_of_the_stubs_has_a_docstring() -> None:
    for path in STUBS.rglob("*.pyi"):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.FunctionDef):
                assert ast.get_docstring(node), f"{path.name}: {node.name}"


def test_modules_can_be_imported_from() -> None:
    for name in list_stubs():
        assert import_module(name).__name__ == name


def test_an_index_out_of_bounds_is_an_error() -> None:
    # A twin that no quad mesh has: PanicException would pass by "except Exception".
    with pytest.raises(RuntimeError, match=r"internal error in the compiled core, at .*\.rs:\d+"):
        fans(np.array([4, 400, 4000, 40000], np.int32))
