"""Small bodies with their strokes and networks, as the tests of feature curves need them."""

from __future__ import annotations

import importlib.util
from functools import cache
from pathlib import Path
from types import ModuleType

from tests.support.shared import EXAMPLES

#: Edges of the bodies, as a factor; and the template that is laid onto them.
COARSE = "0.5"
TEMPLATE = "box:car?r=3"


@cache
def car_bodies() -> ModuleType:
    """The script that writes the bodies."""
    path = EXAMPLES / "car_bodies.py"
    spec = importlib.util.spec_from_file_location("car_bodies", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def write_bodies(folder: Path, *arguments: str) -> Path:
    """Have the script write bodies into a folder."""
    car_bodies().main([*arguments, "--resolution", COARSE, "--out", str(folder)])
    return folder
