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

import json
import math
from pathlib import Path
from typing import Any, NoReturn

from patterndb.errors import InvalidBoundaryError, PatternDBError
from query.boundary import Boundary, CornerKind
from query.stroke import Stroke

#: Bytes that a file may have: a boundary of 2,000 edges in its finest print has some 200,000.
MAX_BYTES = 32_000_000

KEYS = ("sides", "corners", "lengths", "edge_length", "strokes")
STROKE_KEYS = ("points", "loop")

KINDS: dict[str, CornerKind] = {
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
        if isinstance(document, dict):
            _known(document, ("strokes",), "")
            document = document.get("strokes", [])
        return _strokes(boundary, document)
    except PatternDBError as error:
        raise InvalidBoundaryError(f"{path}: {error}") from None


def parse_boundary(data: bytes | str) -> tuple[Boundary, list[Stroke]]:
    """As :func:`read_boundary`, of the file's content; messages do not name a file."""
    document = _document(data)
    if not isinstance(document, dict):
        _refuse("", document, 'an object such as {"sides": [...], "edge_length": 1}')
    _known(document, KEYS, "")
    boundary = _boundary(document)
    return boundary, _strokes(boundary, document.get("strokes", []))


def _content(path: Path) -> bytes:
    with path.open("rb") as file:
        data = file.read(MAX_BYTES + 1)
    if len(data) > MAX_BYTES:
        raise InvalidBoundaryError(
            f"the file is larger than {MAX_BYTES:,} bytes; give fewer points"
        )
    return data


def _document(data: bytes | str) -> Any:
    try:
        return json.loads(data, object_pairs_hook=_object, parse_constant=_constant)
    except json.JSONDecodeError as error:
        raise InvalidBoundaryError(
            f"line {error.lineno}, column {error.colno}: this is no JSON: {error.msg}"
        ) from None
    except UnicodeDecodeError as error:
        raise InvalidBoundaryError(
            f"byte {error.start}: this is no JSON: the text is not UTF-8"
        ) from None
    except RecursionError:
        raise InvalidBoundaryError("this is nested deeper than a boundary is") from None
    except InvalidBoundaryError:
        raise
    except ValueError as error:
        # A whole number of more digits than Python reads.
        raise InvalidBoundaryError(f"this is no JSON that can be read: {error}") from None


def _strokes(boundary: Boundary, value: Any) -> list[Stroke]:
    drawn = _list(value, "strokes")
    return [_stroke(boundary, one, f"strokes[{i}]") for i, one in enumerate(drawn)]


def _boundary(document: dict[str, Any]) -> Boundary:
    if "sides" not in document:
        raise InvalidBoundaryError('"sides" is missing: a list with a polyline for every side')
    sides = [
        _polyline(side, f"sides[{i}]") for i, side in enumerate(_list(document["sides"], "sides"))
    ]
    corners: list[CornerKind] | None = None
    if "corners" in document:
        corners = []
        for i, kind in enumerate(_list(document["corners"], "corners")):
            if not isinstance(kind, str) or kind not in KINDS:
                _refuse(f"corners[{i}]", kind, '"convex" or "reflex"')
            corners.append(KINDS[kind])
    lengths: list[int] | None = None
    if "lengths" in document:
        lengths = []
        for i, length in enumerate(_list(document["lengths"], "lengths")):
            if isinstance(length, bool) or not isinstance(length, int | float) or length % 1:
                _refuse(f"lengths[{i}]", length, "a whole number of edges")
            lengths.append(int(length))
    edge_length: float | None = None
    if "edge_length" in document:
        edge_length = _number(document["edge_length"], "edge_length")
    if (lengths is None) == (edge_length is None):
        raise InvalidBoundaryError(
            'give either "lengths", the edges of every side, or "edge_length", how long an edge '
            f"shall be; there {'is neither' if lengths is None else 'are both'}"
        )
    return Boundary.from_polylines(sides, lengths=lengths, edge_length=edge_length, corners=corners)


def _stroke(boundary: Boundary, drawn: Any, where: str) -> Stroke:
    loop = False
    at = where
    if isinstance(drawn, dict):
        _known(drawn, STROKE_KEYS, f"{where}.")
        if "points" not in drawn:
            raise InvalidBoundaryError(f'{where}: "points" is missing: the stroke as drawn')
        loop = drawn.get("loop", False)
        if not isinstance(loop, bool):
            _refuse(f"{where}.loop", loop, "true or false")
        drawn, at = drawn["points"], f"{where}.points"
    points = _polyline(drawn, at)
    try:
        return Stroke.loop(points) if loop else Stroke.drawn(boundary, points)
    except PatternDBError as error:
        hint = "" if loop else '; a loop is written {"points": [...], "loop": true}'
        raise InvalidBoundaryError(f"{where}: {error}{hint}") from None


def _polyline(value: Any, where: str) -> list[list[float]]:
    points: list[list[float]] = []
    for i, point in enumerate(_list(value, where)):
        numbers = _list(point, f"{where}[{i}]", "a point [x, y, z]")
        if len(numbers) not in (2, 3):
            _refuse(f"{where}[{i}]", point, "a point [x, y, z]")
        place = [_number(x, f"{where}[{i}][{k}]") for k, x in enumerate(numbers)]
        points.append([*place, 0.0] if len(place) == 2 else place)
    if len(points) < 2:
        raise InvalidBoundaryError(f"{where}: a polyline needs two points or more")
    return points


def _number(value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        _refuse(where, value, "a number")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        _refuse(where, value, "a finite number")
    return number


def _list(value: Any, where: str, wanted: str = "a list") -> list[Any]:
    if not isinstance(value, list):
        _refuse(where, value, wanted)
    return value


def _known(value: dict[str, Any], keys: tuple[str, ...], prefix: str) -> None:
    for key in value:
        if key not in keys:
            raise InvalidBoundaryError(
                f"{prefix}{_shown(key)[1:-1]}: there is no such entry; entries are "
                f"{', '.join(keys)}"
            )


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in pairs:
        if key in found:
            raise InvalidBoundaryError(f"the entry {_shown(key)} is there twice")
        found[key] = value
    return found


def _constant(name: str) -> NoReturn:
    raise InvalidBoundaryError(f"{name} is no number that JSON has; every number must be finite")


def _refuse(where: str, value: Any, wanted: str) -> NoReturn:
    at = f"{where}: " if where else ""
    raise InvalidBoundaryError(f"{at}{_shown(value)} is not {wanted}")


def _shown(value: Any) -> str:
    text = json.dumps(value) if not isinstance(value, dict | list) else type(value).__name__
    text = {"dict": "an object", "list": "a list"}.get(text, text)
    return text if len(text) <= 40 else text[:39] + "…"
