"""PLY files, text and binary.

Any elements and properties in any order; of all these, the coordinates of ``vertex`` and the
vertex lists of ``face`` are kept, the rest is only checked for its length.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ingest.formats.files import ReadLimits, assemble, explain_index
from ingest.formats.grammar import Fail, make_fail
from ingest.formats.meshformat import MeshFormat
from ingest.formats.plybody import BinaryBody, FaceRows, PlyBody, TextBody
from ingest.formats.plyheader import Element, Header, parse_header
from patterndb.core.polygonmesh import PolygonMesh


def parse_ply(data: bytes, path: str | Path, limits: ReadLimits) -> PolygonMesh:
    """The mesh a PLY file holds.

    data: the whole file; path: its name, for messages only.

    Raises MeshFileError with the line and token at fault, in a binary body with the element
    and the byte offset.
    """
    fail = make_fail(path)
    header = parse_header(data, limits, fail)
    _check_elements(header, len(data) - header.body, fail)
    body: PlyBody = (BinaryBody if header.order else TextBody)(data, header, limits, fail)
    points: NDArray[np.float64] | None = None
    faces: FaceRows | None = None
    for element in header.elements:
        if element.name == "vertex":
            points = body.points(element, _coordinates(element, fail))
        elif element.name == "face":
            faces = body.faces(element, _vertex_list(element, fail))
        elif element.count:
            body.skip(element)
    body.finish()
    if points is None or faces is None:
        fail("the header declares no vertex or no face element", line=header.lines)
    _check_range(faces, len(points), fail)
    return assemble(points, faces.corners, faces.arities, path, limits)


def format_ply(mesh: PolygonMesh) -> bytes:
    """Return the mesh as the bytes of a PLY file, in text."""
    lines = ["ply", "format ascii 1.0", f"element vertex {len(mesh.points)}"]
    lines += [f"property double {axis}" for axis in "xyz"]
    # Lists are as long as a byte can say but for a mesh that needs more.
    count_type = "uchar" if mesh.arities().max(initial=0) < 256 else "uint"
    lines += [f"element face {mesh.n_faces}", f"property list {count_type} int vertex_indices"]
    lines.append("end_header")
    lines += [f"{x!r} {y!r} {z!r}" for x, y, z in mesh.points.tolist()]
    lines += [" ".join(map(str, [len(face), *face])) for face in mesh.faces()]
    return ("\n".join(lines) + "\n").encode()


FORMAT = MeshFormat(
    "PLY",
    (".ply",),
    "Stanford's, in text or binary; polygons of any arity, read, and written in text",
    parse_ply,
    format_ply,
)


def _check_elements(header: Header, body_bytes: int, fail: Fail) -> None:
    """Fail on what can be refused before the body is looked at."""
    for element in header.elements:
        if element.count and not element.properties:
            fail(f"element {element.name} has no properties", line=element.line)
        # A value takes its bytes in binary, a digit and a blank in text (the last newline
        # of the file may be missing).
        sizes = [prop.min_bytes if header.order else 2 for prop in element.properties]
        needed = element.count * sum(sizes)
        if needed > body_bytes + (0 if header.order else 1):
            fail(
                f"the header promises {element.count:,} of element {element.name}, at least "
                f"{needed:,} bytes, but only {body_bytes:,} follow it; is the file cut short?",
                line=element.line,
            )
        if element.name == "tristrips" and element.count:
            fail(
                "the faces are triangle strips, which hold no quads; export polygons",
                line=element.line,
            )
        if element.name == "face" and not element.count:
            fail("the file holds no faces; export polygons, not points", line=element.line)


def _coordinates(element: Element, fail: Fail) -> tuple[int, int, int]:
    columns: list[int] = []
    for name in ("x", "y", "z"):
        column = element.index_of(name)
        if column is None or element.properties[column].count_type is not None:
            fail(f"element vertex has no number {name}", line=element.line)
        columns.append(column)
    return columns[0], columns[1], columns[2]


def _vertex_list(element: Element, fail: Fail) -> int:
    position = element.index_of("vertex_indices", "vertex_index")
    if position is None:
        fail("element face has no list vertex_indices (or vertex_index)", line=element.line)
    prop = element.properties[position]
    if prop.count_type is None or prop.type.startswith("f"):
        fail(f"{prop.name} must be a list of an integer type", line=element.line)
    return position


def _check_range(faces: FaceRows, n_points: int, fail: Fail) -> None:
    wrong = (faces.corners < 0) | (faces.corners >= n_points)
    if wrong.any():
        corner = int(wrong.argmax())
        face = int(np.searchsorted(np.cumsum(faces.arities), corner, side="right"))
        line, where = faces.place(face)
        index = faces.corners[corner]
        fail(
            f"{where} names vertex {index}, {explain_index(faces.corners, n_points)}",
            line=line,
            token=str(index).encode(),
        )
