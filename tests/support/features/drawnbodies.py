"""Small bodies with their strokes and networks, as the tests of feature curves need them."""

from __future__ import annotations

import importlib.util
import tempfile
from functools import cache
from pathlib import Path
from types import ModuleType

from tests.support.shared import EXAMPLES

#: Edges of the bodies, as a factor; and the template that is laid onto them.
COARSE = "0.5"
TEMPLATE = "box:car?r=3"

#: Bodies with rough strokes along their features: three clean ones, and one with all faults.
DRAWN = ("sedan", "wagon", "coupe", "torn-sedan")


@cache
def car_bodies() -> ModuleType:
    """The script that writes the bodies."""
    path = EXAMPLES / "car_bodies.py"
    spec = importlib.util.spec_from_file_location("car_bodies", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@cache
def _write_body(name: str) -> tempfile.TemporaryDirectory[str]:
    """Have a body written once in a process, into a folder that goes with it."""
    folder = tempfile.TemporaryDirectory()
    faults = ("--crossings", "0.001", "--flips", "0.3", "--clutter", "--soup")
    is_torn = name.startswith("torn-")
    body = name.removeprefix("torn-")
    write_bodies(Path(folder.name), body, "--error", "0.004", *(faults if is_torn else ()))
    return folder


def find_body(name: str, ending: str) -> Path:
    """Return a file of one of `DRAWN`: ``.obj``, ``.strokes.json`` or ``.network.json``.

    Not for parameters of tests: the body would be made whenever tests are collected.
    """
    return Path(_write_body(name).name) / f"{name.removeprefix('torn-')}{ending}"


def write_bodies(folder: Path, *arguments: str) -> Path:
    """Have the script write bodies into a folder."""
    car_bodies().main(["--resolution", COARSE, "--out", str(folder), *arguments])
    return folder
