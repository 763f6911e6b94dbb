"""Fills and surfaces as OBJ files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from patterndb.system.deadline import run_until_late
from patterndb.system.files import replace_file
from patterndb.system.obj import face_lines, format_obj, join_lines, vertex_lines
from patterndb_app.cli.text import printable

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from patterndb.core.disk import Disk
    from patterndb_sketch.surfacing import Surfacing
    from query import Boundary, Fill


def write_flat_fill(path: Path, fill: Fill, boundary: Boundary) -> None:
    """Write the fill in the plane z = 0, as pictures show it: boundary vertices first, from
    corner 0 on, then the interior ones; quads counter-clockwise."""
    lengths = " ".join(str(n) for n in boundary.lengths)
    comments = (
        f"fill of a boundary with sides {lengths}",
        f"pattern {fill.pattern.name}, widths {' '.join(str(w) for w in fill.widths)}",
    )
    write_flat_disk(path, fill.disk(), comments)


def write_flat_disk(path: Path, disk: Disk, comments: Sequence[str]) -> None:
    """Write a disk in the plane z = 0, as pictures show it: boundary vertices first.

    Raises TimeLimitError where the thread's deadline passes before it is laid out.
    """
    # Imported here because only pictures and files need places for vertices.
    from patterndb.geometry.embedding import embed_disk

    def format_disk() -> str:
        return join_lines(
            [
                *(f"# {comment}" for comment in comments),
                *(f"v {x:.6f} {y:.6f} 0" for x, y in embed_disk(disk).tolist()),
                *face_lines(disk.quads.tolist()),
            ]
        )

    replace_file(path, run_until_late(format_disk, f"{path} was written"))


def write_placed_fill(path: Path, fill: Fill, vertices: NDArray[np.float64]) -> None:
    """Write a fill placed in space; vertices: (v, 3). Every number reads back as it was."""
    lengths = " ".join(str(n) for n in fill.lengths)
    comments = (
        f"fill of a boundary with sides {lengths}, its vertices first",
        f"pattern {fill.pattern.name}, widths {' '.join(str(w) for w in fill.widths)}",
    )
    replace_file(path, format_obj(vertices, fill.quads.tolist(), comments=comments))


def write_surface(path: Path, surfacing: Surfacing) -> None:
    """Write the surface of a network, a group per patch, named by its curves and its method.

    Neighbouring patches share vertices. Every number reads back as it was.
    """
    faces = [face for patch in surfacing.patches for face in patch.faces]
    used = np.unique(np.concatenate([np.zeros(0, np.int64), *(face.ravel() for face in faces)]))
    name = np.zeros(len(surfacing.points), np.int64)
    name[used] = np.arange(len(used))
    lines = [f"# surface of a curve network: {len(surfacing.patches)} patches"]
    lines += vertex_lines(surfacing.points[used])
    for number, patch in enumerate(surfacing.patches, 1):
        curves = " ".join(str(c) for c in surfacing.network.names(patch.cycle))
        lines.append(f"g patch_{number}")
        lines.append(f"# {patch.method or 'no method'}, curves {printable(curves)}")
        for face in patch.faces:
            lines += face_lines(name[face].tolist())
    replace_file(path, join_lines(lines))


def write_faces(
    path: Path,
    points: NDArray[np.float64],
    faces: Sequence[Sequence[int]],
    title: str,
    groups: Sequence[str] = (),
) -> None:
    """Write (v, 3) points and faces of any number of corners in their order, with a group wherever
    the names of groups, one for each face, change. Every number reads back as it was."""
    comments = (printable(title),)
    text = format_obj(points, faces, comments=comments, groups=groups)
    replace_file(path, text)
