"""OBJ lines, many at a time.

A chunk of text is matched against one expression for the ordinary lines of the format;
if it matches as a whole, its numbers are known to be well formed and are converted
wholesale. If not, the chunk is left to :mod:`ingest.read.objlines`, which knows the
whole format and can say what is wrong.
"""

from __future__ import annotations

import re

import numpy as np

from ingest.read import grammar
from ingest.read.grammar import BLANK, NUMBER
from ingest.read.limits import ReadLimits
from ingest.read.objrecords import SKIPPED_NUMERIC, SKIPPED_TEXT, ObjRecords


def _ordinary_lines() -> re.Pattern[bytes]:
    reference = rb"(?:-?+[0-9]++)?"
    corner = rb"-?+[1-9][0-9]{0,8}+(?:/R(?:/R)?)?".replace(b"R", reference)
    number = BLANK + rb"++" + NUMBER
    # 3 numbers, 4 with a weight, 6 with a colour, 7 with both
    vertex = rb"v(?:N){3}(?:N(?:(?:N){2,3})?)?".replace(b"N", number)
    face = rb"f(?:" + BLANK + rb"++" + corner + rb"){3,}"
    # No backslash: it could continue the line.
    numeric = rb"(?:" + _either(SKIPPED_NUMERIC) + rb")(?:" + BLANK + rb"[^\n\\]*+)?"
    text = rb"(?:" + _either(SKIPPED_TEXT) + rb")(?:" + BLANK + rb"[^\n]*+)?"
    line = b"|".join([face, vertex, numeric, text, rb"#[^\n]*+", b""])
    return re.compile(rb"(?:(?:" + line + rb")" + BLANK + rb"*+\n)*")


def _either(keywords: frozenset[bytes]) -> bytes:
    # longest first, since the first alternative that matches is kept
    return b"|".join(sorted(keywords, key=len, reverse=True))


_ORDINARY_LINES = _ordinary_lines()
_VERTEX = re.compile(
    rb"^v[ \t\v\f]+([^ \t\v\f\n]+[ \t\v\f]+[^ \t\v\f\n]+[ \t\v\f]+[^ \t\v\f\n]+)", re.M
)
_FACE = re.compile(rb"^f[ \t\v\f]([^\n]*\n)", re.M)
_TEXTURE_AND_NORMAL = re.compile(rb"/[^ \t\v\f\n]*")


def parse_chunk(chunk: bytes, limits: ReadLimits) -> ObjRecords | None:
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

    points = grammar.numbers(b"\n".join(_VERTEX.findall(chunk))).reshape(-1, 3)
    if not np.isfinite(points).all():
        return None
    faces = b"".join(_FACE.findall(chunk))
    arities = grammar.tokens_per_line(faces)
    if len(arities) and arities.max() > limits.max_arity:
        return None
    if b"/" in faces:
        faces = _TEXTURE_AND_NORMAL.sub(b"", faces)
    return ObjRecords(
        points=points,
        indices=grammar.integers(faces),
        arities=arities,
        seen=np.cumsum(is_vertex)[is_face],
        starts=starts[is_face],
    )
