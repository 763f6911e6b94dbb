"""Questions of one line: a boundary and its strokes, as batch files and the service take them.

    3,5,4,6
    {"sides": [3, 5, 4, 6], "corners": ["c", "c", "r", "c"], "strokes": [[[0, 1], [2, 1]]]}
    {"sides": [[[0, 0], [4, 0]], [[4, 0], [4, 3]], [[4, 3], [0, 0]]], "lengths": [4, 3, 5]}

The first two count edges: a stroke is two edges, each [side, edge], and loops a number. The third
has points: it is what a boundary file holds (:mod:`query.boundaryfile`), on one line. An object may
have options of :class:`query.request.FillRequest`, too: {"sides": [3, 5, 4, 6], "max_quads": 40}.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any, cast

from patterndb.errors import InvalidBoundaryError, PatternDBError
from patterndb.system.documents import JsonValue, parse_json
from patterndb.system.requests import list_options
from query.boundary import Boundary, CornerKind
from query.boundaryfile import read_document
from query.request import FillRequest
from query.stroke import Stroke

#: How a corner may be written.
CORNER_KINDS: dict[str, CornerKind] = {
    "c": "convex",
    "convex": "convex",
    "r": "reflex",
    "reflex": "reflex",
}

#: Options that a question may have: not strokes, which have a form of their own, nor threads.
OPTIONS = tuple(name for name in list_options(FillRequest) if name not in ("strokes", "threads"))

#: Entries of a question that counts edges.
COUNTED_ENTRIES = ("sides", "corners", "strokes", "loops")

#: Most loops that a question may ask for: a fill of MAX_PERIMETER edges has no more.
MOST_LOOPS = 1_000


def parse_line(line: str) -> tuple[Boundary, list[Stroke]]:
    """Parse a line of a batch file: the boundary and its strokes.

    Raises InvalidBoundaryError or InvalidQueryError, saying what is wrong with it.
    """
    text = line.strip()
    if not text.startswith("{"):
        return Boundary(_whole_numbers(text.split(","), "the line")), []
    try:
        document = parse_json(text, InvalidBoundaryError, "a boundary")
    except InvalidBoundaryError as error:
        raise InvalidBoundaryError(f"the line is not JSON: {error}") from None
    return read_question(document.value)


def read_id(line: str | bytes) -> dict[str, object]:
    """Read the entry "id" of a line of a batch file, of any kind; {} without one.

    The answer repeats it.
    """
    return _read_entries(line, ("id",))


def read_options(line: str | bytes) -> dict[str, Any]:
    """Read the options of a line of a batch file; those of a FillRequest by their names."""
    return _read_entries(line, OPTIONS)


def _read_entries(line: str | bytes, names: Iterable[str]) -> dict[str, Any]:
    """Read those of some entries that a line has.

    Nothing is raised for a line that is not JSON: reading its question does that.
    """
    try:
        document: object = json.loads(line)
    except (ValueError, RecursionError):
        return {}
    if not isinstance(document, dict):
        return {}
    entries = cast("dict[str, Any]", document)
    return {name: entries[name] for name in names if name in entries}


def has_points(document: object) -> bool:
    """Is this the document of a boundary with points, rather than with counts of edges?"""
    sides = cast("dict[str, Any]", document).get("sides") if isinstance(document, dict) else None
    return isinstance(sides, list) and bool(sides) and isinstance(sides[0], list)


def read_question(document: object) -> tuple[Boundary, list[Stroke]]:
    """Read the boundary and the strokes of a document, as JSON gives it.

    Options are passed over: see :func:`read_options`. So is what else a document that counts edges
    says, such as the mesh that a boundary comes from. Raises as :func:`parse_line` does.
    """
    if has_points(document):
        entries = cast("dict[str, Any]", document)
        # The id of the line and the options do not belong to the boundary.
        asked = {name: value for name, value in entries.items() if name not in ("id", *OPTIONS)}
        return read_document(JsonValue(asked, "", InvalidBoundaryError))
    if not isinstance(document, dict):
        raise InvalidBoundaryError('a question is an object such as {"sides": [3, 5, 4, 6]}')
    entries = cast("dict[str, Any]", document)
    sides = _whole_numbers(_list(entries, "sides"), "sides")
    corners: list[CornerKind] | None = None
    if entries.get("corners") is not None:
        kinds = _list(entries, "corners")
        bad = [kind for kind in kinds if not isinstance(kind, str) or kind not in CORNER_KINDS]
        if bad:
            raise InvalidBoundaryError(f'corner {bad[0]!r} is neither "convex" nor "reflex"')
        corners = [CORNER_KINDS[kind] for kind in kinds]
    strokes = [_stroke(stroke, at) for at, stroke in enumerate(_list(entries, "strokes", []))]
    loops = entries.get("loops", 0)
    if isinstance(loops, bool) or not isinstance(loops, int) or not 0 <= loops <= MOST_LOOPS:
        raise InvalidBoundaryError(
            f"loops is {loops!r}; give a whole number from 0 to {MOST_LOOPS:,}"
        )
    return Boundary(sides, corners), strokes + [Stroke.loop() for _ in range(loops)]


def _list(document: dict[str, Any], name: str, default: list[Any] | None = None) -> list[Any]:
    value = document.get(name, default)
    if not isinstance(value, list):
        raise InvalidBoundaryError(f"{name} is {value!r}; give a list")
    return cast("list[Any]", value)


def _whole_numbers(values: list[Any], name: str) -> list[int]:
    numbers: list[int] = []
    for value in values:
        try:
            number = int(value)
            whole = not isinstance(value, bool) and number == float(value)
        except (TypeError, ValueError, OverflowError):
            whole, number = False, 0
        if not whole:
            raise InvalidBoundaryError(f"{value!r} in {name} is no whole number of edges")
        numbers.append(number)
    return numbers


def _stroke(value: Any, at: int) -> Stroke:
    try:
        (a, i), (b, j) = value
        ends = _whole_numbers([a, i, b, j], f"stroke {at}")
    except (TypeError, ValueError) as error:
        if isinstance(error, PatternDBError):
            raise
        raise InvalidBoundaryError(
            f"stroke {at} is {value!r}; write [[side, edge], [side, edge]]"
        ) from None
    return Stroke((ends[0], ends[1]), (ends[2], ends[3]))
