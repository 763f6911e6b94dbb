"""OFF files, the object file format of Geomview, in text.

    OFF
    # vertices, faces, edges (which nobody counts)
    4 1 0
    0 0 0
    ...
    4  0 1 2 3

A vertex and a face have a line of their own each, for only so can a number too many or too few
be noticed where it is. Comments run from # to the end of the line. Vertices of COFF, NOFF and
STOFF files have colours, normals and texture coordinates too, those of CNOFF two of these; they
are not looked at, nor are the colours that may follow a face.

Source: http://www.geomview.org/docs/html/OFF.html
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from ingest.formats import grammar
from ingest.formats.files import ReadLimits, assemble, explain_arity, explain_index
from ingest.formats.grammar import MAX_DIGITS, NUMBER, SHORT_NATURAL, Fail, make_fail, to_number
from ingest.formats.meshformat import MeshFormat
from patterndb.core.polygonmesh import PolygonMesh

_KEYWORD = re.compile(rb"(ST)?(C)?(N)?(4)?(n)?OFF")
#: How many numbers may say the colour of a face: an index, or three or four shares.
_COLOUR_LENGTHS = (0, 1, 3, 4)
#: The fewest bytes of a vertex, "0 0 0", and of a face, "3 0 0 0", with their newlines.
_VERTEX_BYTES, _FACE_BYTES = 6, 8

_COMMENT = re.compile(rb"#[^\n]*")
_NUMBER_LINES = grammar.compile_lines(NUMBER)
_NATURAL_LINES = grammar.compile_lines(SHORT_NATURAL)


def parse_off(data: bytes, path: str | Path, limits: ReadLimits) -> PolygonMesh:
    """The mesh an OFF file holds.

    data: the whole file; path: its name, for messages only.

    Raises MeshFileError with the line and the token at fault; also for binary files, and for
    points of four or n coordinates.
    """
    fail = make_fail(path)
    rows = _Rows(data, limits, fail)
    lengths = _read_keyword(rows, fail)
    n_points, n_faces = _read_counts(rows, len(data), fail)
    points = _read_points(rows, n_points, lengths, fail)
    first_face = rows.at
    corners, arities = _read_faces(rows, n_faces, limits, fail)
    if rows.at < len(rows.lines):
        line, tokens = rows.take("", 0, 0)
        fail("more lines than the counts promise; correct them", line=line, token=tokens[0])
    wrong = corners >= n_points
    if wrong.any():
        corner = int(wrong.argmax())
        face = int(np.searchsorted(np.cumsum(arities), corner, side="right"))
        fail(
            f"face {face} names vertex {corners[corner]}, {explain_index(corners, n_points)}",
            line=int(rows.lines[first_face + face]) + 1,
            token=str(corners[corner]).encode(),
        )
    return assemble(points, corners, arities, path, limits)


def format_off(mesh: PolygonMesh) -> bytes:
    """Return the mesh as the bytes of an OFF file."""
    lines = ["OFF", f"{len(mesh.points)} {mesh.n_faces} 0"]
    lines += [f"{x!r} {y!r} {z!r}" for x, y, z in mesh.points.tolist()]
    lines += [" ".join(map(str, [len(face), *face])) for face in mesh.faces()]
    return ("\n".join(lines) + "\n").encode()


FORMAT = MeshFormat(
    "OFF",
    (".off",),
    "Geomview's object file format, in text; polygons of any arity, read and written",
    parse_off,
    format_off,
)


class _Rows:
    """The lines of a file that hold anything, comments taken off.

    lines: (n,) their places among all lines, from 0. widths: (n,) tokens on each. at: the next.
    """

    def __init__(self, data: bytes, limits: ReadLimits, fail: Fail) -> None:
        if re.match(rb"\s*[A-Za-z0-9]*OFF\s+BINARY\s", data[:80]):
            fail("the file is a binary OFF file; export it as text", line=1)
        text = grammar.normalise_newlines(data.removeprefix(b"\xef\xbb\xbf"))
        grammar.refuse_nul(text, fail)
        ends = np.flatnonzero(np.frombuffer(text, np.uint8) == ord("\n"))
        lengths = np.diff(ends, prepend=-1)
        if lengths.max() > limits.max_line_bytes + 1:
            fail(
                f"the line is longer than {limits.max_line_bytes:,} bytes",
                line=int(lengths.argmax()) + 1,
            )
        if b"#" in text:
            text = _COMMENT.sub(b"", text)
            ends = np.flatnonzero(np.frombuffer(text, np.uint8) == ord("\n"))
        widths = grammar.count_tokens(text)
        self.lines: NDArray[np.int64] = np.flatnonzero(widths)
        self.widths: NDArray[np.int64] = widths[self.lines]
        self.at = 0
        self._text = text
        self._begins = np.concatenate(([0], ends + 1))
        self._fail = fail
        self._waiting: tuple[int, list[bytes]] | None = None

    def take(self, what: str, row: int, count: int) -> tuple[int, list[bytes]]:
        """Number and tokens of the next line, which holds ``what`` number ``row`` of ``count``."""
        if self._waiting is not None:
            held, self._waiting = self._waiting, None
            return held
        if self.at >= len(self.lines):
            promised = f" of the {count:,} its counts promise" if count else ""
            self._fail(
                f"the file ends at {what}{promised}; is it cut short?".replace("#", str(row)),
                line=len(self._begins) - 1,
            )
        line = int(self.lines[self.at])
        self.at += 1
        return line + 1, self._text[self._begins[line] : self._begins[line + 1]].split()

    def put_back(self, line: int, tokens: list[bytes]) -> None:
        """Leave the tokens for the next :meth:`take`, as if they had a line of their own."""
        self._waiting = line, tokens

    def peek_block(self, count: int) -> tuple[bytes, NDArray[np.int64]] | None:
        """The text of the next ``count`` lines and the tokens on each, if there are as many."""
        last = self.at + count
        if not count or last > len(self.lines):
            return None
        begin = self._begins[self.lines[self.at]]
        end = self._begins[self.lines[last - 1] + 1]
        return self._text[begin:end], self.widths[self.at : last]


@dataclass(frozen=True, slots=True)
class _Lengths:
    """How many numbers a vertex may have, and what they are, for messages."""

    allowed: tuple[int, ...]
    what: str


def _read_keyword(rows: _Rows, fail: Fail) -> _Lengths:
    line, tokens = rows.take("its first line, OFF", 0, 0)
    match = _KEYWORD.fullmatch(tokens[0])
    if match is None:
        fail("not an OFF file: its first word must be OFF", line=line, token=tokens[0][:16])
    texture, colour, normal, four, n = match.groups()
    if four or n:
        fail("points of more than three coordinates are not read", line=line, token=tokens[0])
    if tokens[1:]:
        rows.put_back(line, tokens[1:])
    least = 3 + 2 * bool(texture) + 3 * bool(normal)
    # A colour has four numbers by the description of the format; many write three.
    allowed = (least + 3, least + 4) if colour else (least,)
    parts = [b"normal"] * bool(normal) + [b"colour"] * bool(colour)
    parts += [b"texture coordinates"] * bool(texture)
    said = b" and ".join(parts).decode()
    return _Lengths(allowed, f" with its {said}" if said else "")


def _read_counts(rows: _Rows, n_bytes: int, fail: Fail) -> tuple[int, int]:
    line, tokens = rows.take("its counts", 0, 0)
    if len(tokens) not in (2, 3):
        fail(
            "the counts are three numbers: vertices, faces and edges",
            line=line,
            token=b" ".join(tokens[:16]),
        )
    for token in tokens:
        if not token.isdigit() or len(token) > MAX_DIGITS:
            fail("a count must be a natural number", line=line, token=token)
    n_points, n_faces = int(tokens[0]), int(tokens[1])
    if not n_faces:
        fail("the file holds no faces; export polygons, not points", line=line)
    # The newline of the last line may be missing.
    needed = n_points * _VERTEX_BYTES + n_faces * _FACE_BYTES
    if needed > n_bytes + 1:
        fail(
            f"the counts promise at least {needed:,} bytes, but the file has {n_bytes:,}; "
            "is it cut short?",
            line=line,
            token=b" ".join(tokens),
        )
    return n_points, n_faces


def _read_points(rows: _Rows, count: int, lengths: _Lengths, fail: Fail) -> NDArray[np.float64]:
    block = rows.peek_block(count)
    if block is not None and _NUMBER_LINES.fullmatch(block[0]):
        text, widths = block
        if np.isin(widths, lengths.allowed).all():
            numbers = grammar.parse_numbers(text)
            # Colours, too: what is no number is told of them as of coordinates.
            if np.isfinite(numbers).all():
                firsts = np.cumsum(widths) - widths
                rows.at += count
                return numbers[firsts[:, None] + np.arange(3)]
    points = np.empty((count, 3))
    for row in range(count):
        line, tokens = rows.take("vertex #", row, count)
        if len(tokens) not in lengths.allowed:
            allowed = " or ".join(map(str, lengths.allowed))
            fail(
                f"a vertex{lengths.what} has {allowed} numbers, this one has {len(tokens)}; "
                "a file whose vertices have colours begins with COFF, with normals NOFF",
                line=line,
                token=b" ".join(tokens[:16]),
            )
        points[row] = [to_number(token, fail, line) for token in tokens][:3]
    return points


def _read_faces(
    rows: _Rows, count: int, limits: ReadLimits, fail: Fail
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Corners (c,) and arities (f,) of the next ``count`` lines."""
    block = rows.peek_block(count)
    if block is not None and _NATURAL_LINES.fullmatch(block[0]):
        text, widths = block
        values = grammar.parse_integers(text)
        firsts = np.cumsum(widths) - widths
        arities = values[firsts]
        sound = (arities >= 3) & (arities <= limits.max_arity)
        if (sound & np.isin(widths - 1 - arities, _COLOUR_LENGTHS)).all():
            rows.at += count
            rank = np.arange(arities.sum()) - np.repeat(np.cumsum(arities) - arities, arities)
            return values[np.repeat(firsts + 1, arities) + rank], arities
    corners: list[int] = []
    sizes: list[int] = []
    for row in range(count):
        line, tokens = rows.take("face #", row, count)
        arity = _to_natural(tokens[0], fail, line, "the number of corners")
        if not 3 <= arity <= limits.max_arity:
            fail(f"face {row} {explain_arity(arity, limits)}", line=line, token=tokens[0])
        colour = tokens[1 + arity :]
        if len(tokens) < 1 + arity or len(colour) not in _COLOUR_LENGTHS:
            _fail_at_face(row, arity, line, tokens, fail)
        corners += [
            _to_natural(token, fail, line, "a vertex index") for token in tokens[1 : 1 + arity]
        ]
        for token in colour:
            to_number(token, fail, line)
        sizes.append(arity)
    return np.array(corners, np.int64), np.array(sizes, np.int64)


def _fail_at_face(row: int, arity: int, line: int, tokens: list[bytes], fail: Fail) -> NoReturn:
    fail(
        f"face {row} of {arity} corners is {arity} vertices, and a colour of 1, 3 or 4 numbers or "
        f"none; here {len(tokens) - 1} numbers follow",
        line=line,
        token=b" ".join(tokens[:16]),
    )


def _to_natural(token: bytes, fail: Fail, line: int, what: str) -> int:
    if not token.isdigit() or len(token) > MAX_DIGITS:
        fail(f"{what} must be a natural number", line=line, token=token)
    return int(token)
