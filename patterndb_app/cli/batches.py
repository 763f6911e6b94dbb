"""Many boundaries in one run: the lines of a batch file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from patterndb.errors import InvalidBoundaryError, PatternDBError
from patterndb_app.cli.failure import EXIT_BAD_INPUT, EXIT_NOTHING
from patterndb_app.cli.searching import KINDS
from patterndb_app.cli.text import plural, say, write_json, write_json_with

if TYPE_CHECKING:
    from patterndb.store import Database
    from query import Boundary, Stroke


def run_batch(path: Path, database: Database, arguments: dict[str, Any]) -> int:
    """Answer every line that is not empty with one line of JSON, in order.

    A line that cannot be read gets a document with "error" instead of "fills". Returns the exit
    code: that of bad input if there was such a line, that of nothing found if a boundary has
    no fill.
    """
    from query import fills
    from query.errors import InvalidQueryError

    asked = unreadable = unanswered = 0
    with path.open("rb") as lines:
        for number, line in enumerate(lines, 1):
            if not line.strip():
                continue
            asked += 1
            try:
                boundary, strokes = read_line(_text(line))
                found = fills(database, boundary, strokes=strokes, **arguments)
                listed = list(found)
            except (InvalidBoundaryError, InvalidQueryError) as error:
                unreadable += 1
                write_json({"line": number, "error": str(error)})
                continue
            unanswered += not listed
            document = {
                "line": number,
                "sides": list(boundary.lengths),
                "corners": list(boundary.corners),
                "truncated": found.truncated,
                "stopped": found.stopped,
                "reason": found.reason,
                "seconds": round(found.seconds, 4),
            }
            write_json_with(document, "fills", (fill.to_json() for fill in listed))
    say(
        f"{plural(asked, 'boundary', 'boundaries')}, {unanswered} without a fill, "
        f"{unreadable} that could not be read"
    )
    if unreadable:
        return EXIT_BAD_INPUT
    return EXIT_NOTHING if unanswered else 0


def _text(line: bytes) -> str:
    try:
        # Some editors begin a file with a mark that is no text.
        return line.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InvalidBoundaryError(f"the line is no UTF-8: {error}") from None


def read_line(line: str) -> tuple[Boundary, list[Stroke]]:
    """The boundary and the strokes of a line.

    Raises InvalidBoundaryError or InvalidQueryError, saying what is wrong with it.
    """
    from query import Boundary, Stroke

    text = line.strip()
    if not text.startswith("{"):
        return Boundary(_whole_numbers(text.split(","), "the line")), []
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InvalidBoundaryError(f"the line is no JSON: {error}") from None
    # What else a line says, such as the mesh that a boundary comes from, is no question.
    sides = _whole_numbers(_list(document, "sides"), "sides")
    corners = None
    if document.get("corners") is not None:
        kinds = _list(document, "corners")
        bad = [kind for kind in kinds if not isinstance(kind, str) or kind not in KINDS]
        if bad:
            raise InvalidBoundaryError(f'corner {bad[0]!r} is neither "convex" nor "reflex"')
        corners = tuple(KINDS[kind] for kind in kinds)
    strokes = [_stroke(stroke, at) for at, stroke in enumerate(_list(document, "strokes", []))]
    loops = document.get("loops", 0)
    if isinstance(loops, bool) or not isinstance(loops, int) or loops < 0:
        raise InvalidBoundaryError(f"loops is {loops!r}; give a whole number from 0")
    boundary = Boundary(sides, corners)  # pyright: ignore[reportArgumentType]
    return boundary, strokes + [Stroke.loop() for _ in range(loops)]


def _list(document: dict[str, Any], name: str, default: list[Any] | None = None) -> list[Any]:
    value = document.get(name, default)
    if not isinstance(value, list):
        raise InvalidBoundaryError(f"{name} is {value!r}; give a list")
    return value  # pyright: ignore[reportUnknownVariableType]


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
    from query import Stroke

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
