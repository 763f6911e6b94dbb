"""Packages whose names are loaded when they are asked for: what they need takes a moment that
``--help`` and reading a mesh must not wait for."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def load_late(
    package: str, homes: Mapping[str, str], earlier: Mapping[str, str] | None = None
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Make the ``__getattr__`` and ``__dir__`` of a package.

    homes: the module that each name is defined in. earlier: names that scripts may still have from
    earlier versions, and what they are now.
    """

    def get_attribute(name: str) -> Any:
        present = (earlier or {}).get(name, name)
        home = homes.get(present)
        if home is None:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        found = getattr(import_module(home), present)
        setattr(sys.modules[package], name, found)
        return found

    def list_names() -> list[str]:
        return sorted({*vars(sys.modules[package]), *homes})

    return get_attribute, list_names
