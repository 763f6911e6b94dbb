"""Where the tests find what they share with other programs, and the meshes they learn from."""

from __future__ import annotations

import importlib.util
from functools import cache
from pathlib import Path
from types import ModuleType

CHECKOUT = Path(__file__).resolve().parents[2]
EXAMPLES = CHECKOUT / "examples"
DATA = CHECKOUT / "tests" / "data"
SHARED = CHECKOUT.parent / "shared"
GOLDEN = SHARED / "golden"
MESHES = SHARED / "data" / "meshes"


def list_shared(folder: Path, *names: str) -> list[Path]:
    """Return those of the files in a shared folder that are there: none in a clone alone."""
    return [folder / name for name in names if (folder / name).is_file()]


@cache
def oracle() -> ModuleType:
    """The slow program that counts patterns on its own, as a second opinion."""
    path = SHARED / "oracle" / "oracle.py"
    spec = importlib.util.spec_from_file_location("oracle", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
