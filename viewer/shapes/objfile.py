"""Shapes as OBJ files."""

from __future__ import annotations

from pathlib import Path

from patterndb.system.files import replace_file
from patterndb.system.obj import format_obj
from viewer.shapes.shaping import Shaping


def write_obj(path: Path, shaping: Shaping) -> None:
    """Write the shape that is shown; every number reads back as it was.

    The vertices are in the model's order, so that files of one model can be compared, and laid
    on each other. Raises OSError as writing does.
    """
    sigmas = " ".join(f"{value:.4g}" for value in shaping.sigmas.tolist())
    comments = (
        f"a shape of a model of {len(shaping.shapes.names)} shapes",
        f"modes in standard deviations: {sigmas}",
    )
    replace_file(path, format_obj(shaping.points, shaping.skin.quads.tolist(), comments=comments))
