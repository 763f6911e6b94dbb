"""Boundaries and strokes from JSON files.

    {"sides": [[[0, 0, 0], [4, 0, 0]], [[4, 0, 0], [4, 3, 1]], [[4, 3, 1], [0, 0, 0]]],
     "corners": ["convex", "convex", "convex"],
     "edge_length": 1.0,
     "strokes": [[[2, 0, 0], [4, 1, 0.3]], {"points": [[3, 1, 0], [3, 2, 0.5]], "loop": true}]}

sides: a polyline per side, counter-clockwise, each from the end of the one before. corners:
"convex" or "reflex", or "c" or "r", one where each side begins; convex if left out, [] for one
closed side. Either lengths, the edges of every side, or edge_length, about how long an edge
shall be. strokes: polylines, or objects that say whether they are loops.
"""

from __future__ import annotations

from pathlib import Path

from patterndb.errors import InvalidBoundaryError, PatternDBError
from patterndb.system.documents import JsonValue, parse_json, read_limited
from query.boundary import Boundary, CornerKind
from query.stroke import Stroke

#: Bytes that a file may have: a boundary of 2,000 edges in its finest print has some 200,000.
MAX_BYTES = 32_000_000

KEYS = ("sides", "corners", "lengths", "edge_length", "strokes")
STROKE_KEYS = ("points", "loop")

KINDS: dict[object, CornerKind] = {
    "convex": "convex",
    "c": "convex",
    "reflex": "reflex",
    "r": "reflex",
}


def read_boundary(path: Path | str) -> tuple[Boundary, list[Stroke]]:
    """The boundary in a JSON file, its vertices placed, and the strokes drawn with it.

    Raises InvalidBoundaryError that names the file and the place in it ("sides[2][0][1]"),
    says what is wrong there and what would mend it; OSError as reading does.
    """
    path = Path(path)
    try:
        return parse_boundary(_content(path))
    except PatternDBError as error:
        raise InvalidBoundaryError(f"{path}: {error}") from None


def read_strokes(path: Path | str, boundary: Boundary) -> list[Stroke]:
    """The strokes in a JSON file of their own: a list, or an object with "strokes" alone.

    boundary: the one they are drawn on, whose vertices are placed. Raises as
    :func:`read_boundary` does.
    """
    path = Path(path)
    try:
        document = _document(_content(path))
        if not document.is_object:
            return _strokes(boundary, JsonValue(document.value, "strokes", document.error))
        return _strokes(boundary, document.entries(("strokes",)).get("strokes"))
    except PatternDBError as error:
        raise InvalidBoundaryError(f"{path}: {error}") from None


def parse_boundary(data: bytes | str) -> tuple[Boundary, list[Stroke]]:
    """As :func:`read_boundary`, of the file's content; messages do not name a file."""
    wanted = 'an object such as {"sides": [...], "edge_length": 1}'
    entries = _document(data).entries(KEYS, wanted)
    boundary = _boundary(entries)
    return boundary, _strokes(boundary, entries.get("strokes"))


def _content(path: Path) -> bytes:
    return read_limited(path, MAX_BYTES, InvalidBoundaryError, "give fewer points")


def _document(data: bytes | str) -> JsonValue:
    return parse_json(data, InvalidBoundaryError, "a boundary")


def _strokes(boundary: Boundary, drawn: JsonValue | None) -> list[Stroke]:
    return [] if drawn is None else [_stroke(boundary, one) for one in drawn.items()]


def _boundary(entries: dict[str, JsonValue]) -> Boundary:
    if "sides" not in entries:
        raise InvalidBoundaryError('"sides" is missing: a list with a polyline for every side')
    sides = [side.polyline() for side in entries["sides"].items()]
    corners: list[CornerKind] | None = None
    if "corners" in entries:
        corners = [_corner(kind) for kind in entries["corners"].items()]
    lengths: list[int] | None = None
    if "lengths" in entries:
        lengths = [one.whole("a whole number of edges") for one in entries["lengths"].items()]
    edge_length: float | None = None
    if "edge_length" in entries:
        edge_length = entries["edge_length"].number()
    if (lengths is None) == (edge_length is None):
        raise InvalidBoundaryError(
            'give either "lengths", the edges of every side, or "edge_length", how long an edge '
            f"shall be; there {'is neither' if lengths is None else 'are both'}"
        )
    return Boundary.from_polylines(sides, lengths=lengths, edge_length=edge_length, corners=corners)


def _corner(kind: JsonValue) -> CornerKind:
    if not isinstance(kind.value, str) or kind.value not in KINDS:
        kind.refuse('"convex" or "reflex"')
    return KINDS[kind.value]


def _stroke(boundary: Boundary, drawn: JsonValue) -> Stroke:
    loop = False
    line = drawn
    if drawn.is_object:
        entries = drawn.entries(STROKE_KEYS)
        if "points" not in entries:
            drawn.fail('"points" is missing: the stroke as drawn')
        loop = "loop" in entries and entries["loop"].truth()
        line = entries["points"]
    points = line.polyline()
    try:
        return Stroke.loop(points) if loop else Stroke.drawn(boundary, points)
    except PatternDBError as error:
        hint = "" if loop else '; a loop is written {"points": [...], "loop": true}'
        raise InvalidBoundaryError(f"{drawn.where}: {error}{hint}") from None
