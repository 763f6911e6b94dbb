"""Boundaries and strokes from JSON files.

    {"sides": [[[0, 0, 0], [4, 0, 0]], [[4, 0, 0], [4, 3, 1]], [[4, 3, 1], [0, 0, 0]]],
     "corners": ["convex", "convex", "convex"],
     "edge_length": 1.0,
     "strokes": [[[2, 0, 0], [4, 1, 0.3]], {"points": [[3, 1, 0], [3, 2, 0.5]], "loop": true}]}

sides: a polyline per side, counter-clockwise, each from the end of the one before. corners:
"convex" or "reflex", or "c" or "r", one where each side begins; convex if left out, [] for one
closed side. One of lengths, the edges of every side; edge_length, about how long an edge shall be;
and "vertices": true, where the points are the boundary's vertices and stay where they are, bit for
bit, instead of vertices at equal distances along each side. strokes: polylines, or objects that
say whether they are loops, and may name the edges where they end: {"ends": [[0, 1], [2, 1]]}.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from msgspec import UNSET, Meta, UnsetType

from patterndb.errors import InvalidBoundaryError, PatternDBError
from patterndb.system.documents import (
    JsonModel,
    JsonValue,
    Number,
    Polyline,
    complete_points,
    name_file,
    parse_json,
    read_limited,
)
from query.boundary import Boundary, CornerKind
from query.stroke import Stroke

#: Bytes that a file may have: a boundary of 2,000 edges in its finest print has some 200,000.
MAX_BYTES = 32_000_000

Corner = Annotated[Literal["convex", "c", "reflex", "r"], Meta(description='"convex" or "reflex"')]
BoundaryEdgeEntry = Annotated[
    tuple[int, int], Meta(description="an edge of the boundary, [side, edge]")
]
Whole = Annotated[int, Meta(description="a whole number of edges")]


class StrokeEntries(JsonModel):
    points: Polyline | None = None
    loop: bool = False
    ends: list[BoundaryEdgeEntry] | None = None


class BoundaryEntries(JsonModel):
    sides: Annotated[
        list[Polyline], Meta(extra={"missing": "a list with a polyline for every side"})
    ]
    corners: list[Corner] | UnsetType = UNSET
    lengths: list[Whole] | UnsetType = UNSET
    edge_length: Number | UnsetType = UNSET
    vertices: bool = False
    strokes: Any = None


def read_boundary(path: Path | str) -> tuple[Boundary, list[Stroke]]:
    """The boundary in a JSON file, its vertices placed, and the strokes drawn with it.

    Raises InvalidBoundaryError that names the file and the place in it ("sides[2][0][1]"),
    says what is wrong there and what would mend it; OSError as reading does.
    """
    path = Path(path)
    with name_file(path, InvalidBoundaryError):
        return parse_boundary(_content(path))


def read_strokes(path: Path | str, boundary: Boundary) -> list[Stroke]:
    """The strokes in a JSON file of their own: a list, or an object with "strokes" alone.

    boundary: the one they are drawn on, whose vertices are placed. Raises as
    :func:`read_boundary` does.
    """
    path = Path(path)
    with name_file(path, InvalidBoundaryError):
        document = _document(_content(path))
        if document.is_object:
            return _strokes(boundary, document.entries(("strokes",)).get("strokes"))
        return _strokes(boundary, JsonValue(document.value, "strokes", document.error))


def parse_boundary(data: bytes | str) -> tuple[Boundary, list[Stroke]]:
    """As :func:`read_boundary`, of the file's content; messages do not name a file."""
    return read_document(_document(data))


def read_document(document: JsonValue) -> tuple[Boundary, list[Stroke]]:
    """As :func:`parse_boundary`, of a document that is read already; its error is raised."""
    entries = document.read(BoundaryEntries, 'an object such as {"sides": [...], "edge_length": 1}')
    boundary = _boundary(entries)
    return boundary, _strokes(boundary, document.entries().get("strokes"))


def _content(path: Path) -> bytes:
    return read_limited(path, MAX_BYTES, InvalidBoundaryError, "give fewer points")


def _document(data: bytes | str) -> JsonValue:
    return parse_json(data, InvalidBoundaryError, "a boundary")


def _boundary(entries: BoundaryEntries) -> Boundary:
    corners: list[CornerKind] | None = None
    if entries.corners is not UNSET:
        corners = ["reflex" if kind in ("reflex", "r") else "convex" for kind in entries.corners]
    sides = [complete_points(side) for side in entries.sides]
    lengths = None if entries.lengths is UNSET else entries.lengths
    edge_length = None if entries.edge_length is UNSET else entries.edge_length
    if entries.vertices:
        boundary = Boundary.from_vertices(sides, corners=corners)
        _refuse_other_edges(boundary, lengths, edge_length)
        return boundary
    if (lengths is None) == (edge_length is None):
        raise InvalidBoundaryError(
            'give either "lengths", the edges of every side, or "edge_length", how long an edge '
            f"shall be; there {'is neither' if lengths is None else 'are both'}. Where the points "
            'are the vertices themselves, say "vertices": true instead'
        )
    return Boundary.from_polylines(sides, lengths=lengths, edge_length=edge_length, corners=corners)


def _refuse_other_edges(
    boundary: Boundary, lengths: list[int] | None, edge_length: float | None
) -> None:
    """InvalidBoundaryError where a document counts edges otherwise than its vertices do."""
    if edge_length is not None:
        raise InvalidBoundaryError(
            'edge_length would place vertices anew, but "vertices" is true, and they stay as they '
            "are; leave one of the two out"
        )
    if lengths is None:
        return
    if len(lengths) != len(boundary.lengths):
        raise InvalidBoundaryError(
            f"lengths are {len(lengths)}, but there are {len(boundary.lengths)} sides; leave them "
            'out: "vertices" is true, and the points tell'
        )
    for side, (asked, given) in enumerate(zip(lengths, boundary.lengths, strict=True)):
        if asked != given:
            raise InvalidBoundaryError(
                f"lengths[{side}]: {asked} edges, but the {given + 1} vertices of side {side} are "
                f"the ends of {given}; give {given}, or leave lengths out, or leave "
                '"vertices" out to have vertices placed anew at equal distances'
            )


def _stroke(boundary: Boundary, entries: StrokeEntries, points: list[list[float]] | None) -> Stroke:
    if entries.loop:
        return Stroke.loop(points)
    if entries.ends is None:
        if points is None:
            raise InvalidBoundaryError(
                '"points" is missing: the stroke as drawn, or "ends", [[side, edge], [side, edge]]'
            )
        return Stroke.drawn(boundary, points)
    if len(entries.ends) != 2:
        raise InvalidBoundaryError('"ends" are two edges, [[side, edge], [side, edge]]')
    line = None if points is None else np.array(points, np.float64)
    stroke = Stroke(entries.ends[0], entries.ends[1], line)
    stroke.refuse_unless_on(boundary)
    return stroke


def _strokes(boundary: Boundary, drawn: JsonValue | None) -> list[Stroke]:
    strokes: list[Stroke] = []
    if drawn is None:
        return strokes
    for i, one in enumerate(drawn.read(list[Polyline | StrokeEntries])):
        entries = StrokeEntries(points=one) if isinstance(one, list) else one
        loop = entries.loop
        points = None if entries.points is None else complete_points(entries.points)
        try:
            strokes.append(_stroke(boundary, entries, points))
        except PatternDBError as error:
            hint = "" if loop else '; a loop is written {"points": [...], "loop": true}'
            drawn.at(i).fail(f"{error}{hint}")
    return strokes
