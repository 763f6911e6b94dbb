"""What the programs of this folder that write scripts have in common."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

from sketching import Sketch

from ingest.formats import read_mesh
from patterndb.geometry.surface import Surface

HERE = Path(__file__).resolve().parent


def made(name: str, draw: Callable[[Sketch], None], mirror: int | None = None) -> None:
    """Write the script ``name`` for the surface that the command line names."""
    parser = argparse.ArgumentParser(description=f"Writes {name}.")
    parser.add_argument("surface", type=Path, help="OBJ file; the script names it as it is given")
    parser.add_argument("--out", type=Path, default=HERE, help="folder to write into")
    options = parser.parse_args()
    surface = Surface.from_polygons(read_mesh(options.surface)).orient()
    sketch = Sketch(surface, options.surface.as_posix(), mirror)
    draw(sketch)
    sketch.write(options.out / name)
