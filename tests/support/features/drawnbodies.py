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
def _open_folder() -> tempfile.TemporaryDirectory[str]:
    """Have bodies written once in a process, into a folder that goes with it."""
    folder = tempfile.TemporaryDirectory()
    write_bodies(Path(folder.name), *DRAWN[:-1], "--error", "0.004")
    torn = Path(folder.name) / "torn"
    faults = ("--crossings", "0.001", "--flips", "0.3", "--clutter", "--soup")
    write_bodies(torn, "sedan", "--error", "0.004", *faults)
    for path in torn.iterdir():
        path.rename(path.parents[1] / path.name.replace("sedan", DRAWN[-1]))
    return folder


def find_body(name: str, ending: str) -> Path:
    """Return a file of one of `DRAWN`: ``.obj``, ``.strokes.json`` or ``.network.json``."""
    return Path(_open_folder().name) / f"{name}{ending}"


def write_bodies(folder: Path, *arguments: str) -> Path:
    """Have the script write bodies into a folder."""
    car_bodies().main(["--resolution", COARSE, "--out", str(folder), *arguments])
    return folder
