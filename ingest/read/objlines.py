"""OBJ lines, one at a time: the whole format, and a precise error for what is not in it."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np

from ingest.read.grammar import MAX_DIGITS, Fail, to_number
from ingest.read.limits import ReadLimits
from ingest.read.objrecords import SKIPPED_NUMERIC, SKIPPED_TEXT, ObjRecords

_CORNER = re.compile(rb"(-?[0-9]+)(?:/(?:-?[0-9]+)?(?:/(?:-?[0-9]+)?)?)?")
_SKIPPED = SKIPPED_NUMERIC | SKIPPED_TEXT
# Both pull in what is not in this file: skipping them would give half a mesh.
_OUTSIDE = {
    b"call": "'call' includes another file; paste that file in its place",
    b"csh": "'csh' runs a shell command, which no reader should; delete the line",
}


def parse_lines(chunk: bytes, first_line: int, limits: ReadLimits, fail: Fail) -> ObjRecords:
    """The records of a run of lines, or a failure at the first line that is none.

    ``chunk`` ends in a newline and holds neither CR nor NUL; ``first_line`` is the number
    of its first line in the file.

    A keyword that no part of the OBJ specification defines fails: it is more often a
    damaged ``v`` or ``f`` than an extension, and skipping a damaged one would renumber
    every vertex after it.
    """
    points: list[list[float]] = []
    indices: list[int] = []
    arities: list[int] = []
    seen: list[int] = []
    starts: list[int] = []
    for start, line, tokens in _statements(chunk, first_line, limits, fail):
        keyword = tokens[0]
        if keyword == b"v":
            points.append(_vertex(tokens[1:], line, fail))
        elif keyword in (b"f", b"fo"):  # fo, "face outline", is what version 2 called a face
            corners = _face(tokens[1:], line, limits, fail)
            indices += corners
            arities.append(len(corners))
            seen.append(len(points))
            starts.append(start)
        elif keyword in _OUTSIDE:
            fail(_OUTSIDE[keyword], line=line, token=keyword)
        elif keyword not in _SKIPPED:
            fail(
                "not an OBJ keyword; if it is a comment, start the line with '#'",
                line=line,
                token=keyword,
            )
    return ObjRecords(
        points=np.array(points, np.float64).reshape(-1, 3),
        indices=np.array(indices, np.int64),
        arities=np.array(arities, np.int64),
        seen=np.array(seen, np.int64),
        starts=np.array(starts, np.int64),
    )


def face_tokens(chunk: bytes, start: int, limits: ReadLimits, fail: Fail) -> list[bytes]:
    """The corners, as written, of the face whose line starts at byte ``start``."""
    for _, _, tokens in _statements(chunk[start:], 1, limits, fail):
        return tokens[1:]
    return []


def _statements(
    chunk: bytes, first_line: int, limits: ReadLimits, fail: Fail
) -> Iterator[tuple[int, int, list[bytes]]]:
    """Byte offset, line number and tokens of every statement, continued lines joined."""
    position, line = 0, first_line
    while position < len(chunk):
        start, number = position, line
        pieces: list[bytes] = []
        length = 0
        while True:
            end = chunk.index(b"\n", position)
            piece = chunk[position:end]
            length += len(piece)
            if length > limits.max_line_bytes:
                fail(
                    f"the line is longer than {limits.max_line_bytes:,} bytes; "
                    "is this a text file?",
                    line=number,
                    token=chunk[start : start + 80],
                )
            position, line = end + 1, line + 1
            # A comment ends its line for good: it may itself end in a backslash.
            comment = piece.find(b"#")
            if comment >= 0:
                piece = piece[:comment]
            continued = comment < 0 and piece.endswith(b"\\")
            if continued and not pieces and piece.split(None, 1)[0] in SKIPPED_TEXT:
                continued = False
            if not continued:
                pieces.append(piece)
                break
            if position >= len(chunk):
                fail("the file ends inside a continued line; is it cut short?", line=number)
            pieces.append(piece[:-1])
        tokens = b" ".join(pieces).split()
        if tokens:
            yield start, number, tokens


def _vertex(tokens: list[bytes], line: int, fail: Fail) -> list[float]:
    if len(tokens) not in (3, 4, 6, 7):
        fail(
            "a vertex has 3 numbers, 4 with a weight, 6 or 7 with a colour; "
            f"this one has {len(tokens)}",
            line=line,
            token=b" ".join(tokens),
        )
    return [to_number(token, fail, line) for token in tokens][:3]


def _face(tokens: list[bytes], line: int, limits: ReadLimits, fail: Fail) -> list[int]:
    if len(tokens) < 3:
        fail(
            f"a face has at least 3 corners, this one has {len(tokens)}; delete it",
            line=line,
            token=b" ".join(tokens),
        )
    if len(tokens) > limits.max_arity:
        fail(
            f"a face of {len(tokens)} corners, over the limit of {limits.max_arity}; "
            "split it, or raise ReadLimits.max_arity",
            line=line,
        )
    return [_corner(token, line, fail) for token in tokens]


def _corner(token: bytes, line: int, fail: Fail) -> int:
    match = _CORNER.fullmatch(token)
    if match is None:
        fail("not a corner; write v, v/vt, v//vn or v/vt/vn", line=line, token=token)
    digits = match[1].lstrip(b"-")
    if len(digits) > MAX_DIGITS:
        fail("no file holds so many vertices", line=line, token=token)
    index = int(match[1])
    if index == 0:
        fail("index 0: OBJ numbers vertices from 1", line=line, token=token)
    return index
