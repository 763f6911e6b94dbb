"""Wavefront OBJ files.

Polygons keep their arity and the file's own vertex numbers: texture coordinates and
normals are not looked at, so no vertex is split at a seam.

The text is read in chunks. A chunk is matched against one expression for the ordinary lines of
the format; if it matches as a whole, its numbers are known to be well formed and are converted
wholesale (``_parse_chunk``). If not, it is read line by line (``_parse_lines``), which knows the
whole format and can say what is wrong.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ingest.formats import grammar
from ingest.formats.files import MIB, ReadLimits, assemble, explain_arity
from ingest.formats.grammar import BLANK, MAX_DIGITS, NUMBER, Fail, make_fail, to_number
from ingest.formats.meshformat import MeshFormat
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.system.obj import format_obj

# Large enough that the work per chunk is in numpy, small enough for its arrays to stay in
# the cache, and for one extraordinary line to cost little.
CHUNK_BYTES = 2 * MIB
# Statements over numbers: they may be continued over lines with a backslash.
_SKIPPED_NUMERIC = frozenset(
    b"vt vn vp l p s mg lod bevel c_interp d_interp "
    b"vw vc "  # no part of the specification: weights of joints, colours of vertices
    b"cstype deg bmat step curv curv2 surf parm trim hole scrv sp end con "
    b"ctech stech res bsp bzp cdc cdp".split()
)
# Statements over names, in which a backslash is a character: a Windows path that ends in one
# must not swallow the face on the next line.
# Tags (t) are OpenSubdiv's: creases and corners.
_SKIPPED_TEXT = frozenset(b"g o usemtl mtllib usemap maplib shadow_obj trace_obj t".split())


def parse_obj(data: bytes, path: str | Path, limits: ReadLimits) -> PolygonMesh:
    """The mesh an OBJ file holds.

    data: the whole file; path: its name, for messages only.

    A face may name a vertex that is defined further down, as long as the file defines it;
    a negative index counts back from the vertices read so far, as the specification says.
    Of a vertex with a weight (x y z w) the position is x y z as written: the weight
    concerns rational curves alone.

    Raises MeshFileError with the line and the token at fault.
    """
    fail = make_fail(path)
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        fail("the text is UTF-16; save it as UTF-8", line=1)
    text = grammar.normalise_newlines(data.removeprefix(b"\xef\xbb\xbf"))
    grammar.refuse_nul(text, fail)

    begins: list[int] = []
    runs: list[_ObjRecords] = []
    line, counted = 1, 0  # the line that starts at byte `counted`
    for begin, end in _chunks(text):
        chunk = text[begin:end]
        records = _parse_chunk(chunk, limits)
        if records is None:
            line, counted = line + text.count(b"\n", counted, begin), begin
            records = _parse_lines(chunk, line, limits, fail)
        begins.append(begin)
        runs.append(records)

    points = np.concatenate([run.points for run in runs])
    written = np.concatenate([run.indices for run in runs])
    arities = np.concatenate([run.arities for run in runs])
    counts = [len(run.points) for run in runs]
    seen = np.concatenate(
        [run.seen + before for run, before in zip(runs, _before(counts), strict=True)]
    )
    starts = np.concatenate([run.starts + at for run, at in zip(runs, begins, strict=True)])
    corners = np.where(written > 0, written - 1, written + np.repeat(seen, arities))
    _check_range(corners, written, arities, seen, starts, len(points), text, limits, fail)
    return assemble(points, corners, arities, path, limits)


def _chunks(text: bytes) -> Iterator[tuple[int, int]]:
    """Byte ranges of whole lines, no line parted from the one that continues it."""
    begin = 0
    while begin < len(text):
        newline = text.find(b"\n", begin + CHUNK_BYTES)
        while newline >= 0 and text[newline - 1 : newline] == b"\\":
            newline = text.find(b"\n", newline + 1)
        end = len(text) if newline < 0 else newline + 1
        yield begin, end
        begin = end


def _before(counts: list[int]) -> list[int]:
    return [0, *np.cumsum(counts, dtype=np.int64)[:-1].tolist()]


def _check_range(
    corners: NDArray[np.int64],
    written: NDArray[np.int64],
    arities: NDArray[np.int64],
    seen: NDArray[np.int64],
    starts: NDArray[np.int64],
    n_points: int,
    text: bytes,
    limits: ReadLimits,
    fail: Fail,
) -> None:
    """Fail at the first corner that names no vertex."""
    wrong = (corners < 0) | (corners >= n_points)
    if not wrong.any():
        return
    corner = int(wrong.argmax())
    ends = np.cumsum(arities)
    face = int(np.searchsorted(ends, corner, side="right"))
    start = int(starts[face])
    token = _face_tokens(text, start, limits, fail)[corner - int(ends[face] - arities[face])]
    line = 1 + text.count(b"\n", 0, start)
    if written[corner] < 0:
        fail(
            f"the index reaches back before the first vertex: {seen[face]} were read so far",
            line=line,
            token=token,
        )
    fail(
        f"the face names a vertex that the file does not define: it has {n_points}",
        line=line,
        token=token,
    )


@dataclass(frozen=True, slots=True)
class _ObjRecords:
    """The vertices and faces of a run of lines.

    points:  (v, 3) float64.
    indices: (c,) int64, as written: from 1, or negative and relative.
    arities: (f,) int64, corners of every face.
    seen:    (f,) int64, vertices of this run read before the face.
    starts:  (f,) int64, byte offset in this run of the line the face starts on.
    """

    points: NDArray[np.float64]
    indices: NDArray[np.int64]
    arities: NDArray[np.int64]
    seen: NDArray[np.int64]
    starts: NDArray[np.int64]


FORMAT = MeshFormat(
    "OBJ",
    (".obj",),
    "Wavefront's, in text; polygons of any arity, read and written",
    parse_obj,
    lambda mesh: format_obj(mesh.points, mesh.faces()).encode(),
)


# Many lines at a time


def _ordinary_lines() -> re.Pattern[bytes]:
    reference = rb"(?:-?+[0-9]++)?"
    corner = rb"-?+[1-9][0-9]{0,8}+(?:/R(?:/R)?)?".replace(b"R", reference)
    number = BLANK + rb"++" + NUMBER
    # 3 numbers, 4 with a weight, 6 with a colour, 7 with both
    vertex = rb"v(?:N){3}(?:N(?:(?:N){2,3})?)?".replace(b"N", number)
    face = rb"f(?:" + BLANK + rb"++" + corner + rb"){3,}"
    # No backslash: it could continue the line.
    numeric = rb"(?:" + _either(_SKIPPED_NUMERIC) + rb")(?:" + BLANK + rb"[^\n\\]*+)?"
    text = rb"(?:" + _either(_SKIPPED_TEXT) + rb")(?:" + BLANK + rb"[^\n]*+)?"
    line = b"|".join([face, vertex, numeric, text, rb"#[^\n]*+", b""])
    return re.compile(rb"(?:(?:" + line + rb")" + BLANK + rb"*+\n)*")


def _either(keywords: frozenset[bytes]) -> bytes:
    # longest first, since the first alternative that matches is kept
    return b"|".join(sorted(keywords, key=len, reverse=True))


_ORDINARY_LINES = _ordinary_lines()
_VERTEX = re.compile(
    rb"^v[ \t\v\f]+([^ \t\v\f\n]+[ \t\v\f]+[^ \t\v\f\n]+[ \t\v\f]+[^ \t\v\f\n]+)", re.M
)
#: Weights and colours are not kept, and only looked at where they could be too large to be finite:
#: with an exponent of a hundred or more, or in a line so long that its digits alone may.
_LARGE_EXPONENT = re.compile(rb"^v[ \t\v\f][^\n]*[eE]\+?0*[1-9][0-9]{2}", re.M)
_LONG_VERTEX = 200
_FACE = re.compile(rb"^f[ \t\v\f]([^\n]*\n)", re.M)
_TEXTURE_AND_NORMAL = re.compile(rb"/[^ \t\v\f\n]*")


def _parse_chunk(chunk: bytes, limits: ReadLimits) -> _ObjRecords | None:
    """The records of a chunk of ordinary lines, or None if any line is out of the ordinary.

    ``chunk`` ends in a newline and holds neither CR nor NUL.
    """
    if _ORDINARY_LINES.fullmatch(chunk) is None:
        return None
    codes = np.frombuffer(chunk + b"\n", np.uint8)  # so that every line has a second byte
    ends = np.flatnonzero(codes[:-1] == ord("\n"))
    starts = np.concatenate(([0], ends[:-1] + 1))
    if (ends - starts).max() > limits.max_line_bytes:
        return None
    blank_second = (codes[starts + 1] <= ord(" ")) & (codes[starts] > ord(" "))
    is_vertex = blank_second & (codes[starts] == ord("v"))
    is_face = blank_second & (codes[starts] == ord("f"))

    if (is_vertex & (ends - starts >= _LONG_VERTEX)).any() or _LARGE_EXPONENT.search(chunk):
        return None
    points = grammar.parse_numbers(b"\n".join(_VERTEX.findall(chunk))).reshape(-1, 3)
    if not np.isfinite(points).all():
        return None
    faces = b"".join(_FACE.findall(chunk))
    arities = grammar.count_tokens(faces)
    if len(arities) and arities.max() > limits.max_arity:
        return None
    if b"/" in faces:
        faces = _TEXTURE_AND_NORMAL.sub(b"", faces)
    return _ObjRecords(
        points=points,
        indices=grammar.parse_integers(faces),
        arities=arities,
        seen=np.cumsum(is_vertex)[is_face],
        starts=starts[is_face],
    )


# One line at a time

_CORNER = re.compile(rb"(-?[0-9]+)(?:/(?:-?[0-9]+)?(?:/(?:-?[0-9]+)?)?)?")
_SKIPPED = _SKIPPED_NUMERIC | _SKIPPED_TEXT
# Both pull in what is not in this file: skipping them would give half a mesh.
_OUTSIDE = {
    b"call": "'call' includes another file; paste that file in its place",
    b"csh": "'csh' runs a shell command, which no reader should; delete the line",
}


def _parse_lines(chunk: bytes, first_line: int, limits: ReadLimits, fail: Fail) -> _ObjRecords:
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
    return _ObjRecords(
        points=np.array(points, np.float64).reshape(-1, 3),
        indices=np.array(indices, np.int64),
        arities=np.array(arities, np.int64),
        seen=np.array(seen, np.int64),
        starts=np.array(starts, np.int64),
    )


def _face_tokens(chunk: bytes, start: int, limits: ReadLimits, fail: Fail) -> list[bytes]:
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
            if continued and not pieces and piece.split(None, 1)[0] in _SKIPPED_TEXT:
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
    if not 3 <= len(tokens) <= limits.max_arity:
        fail(
            f"the face {explain_arity(len(tokens), limits)}",
            line=line,
            token=b" ".join(tokens[:16]),
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
