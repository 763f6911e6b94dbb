"""The body of a PLY text file: one line per row.

The format's description gives each row its own line, and only so can a number too many or
too few be noticed where it is: read as one stream of numbers, it would shift all that follow.
"""

from __future__ import annotations

import re
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from ingest.read import grammar
from ingest.read.grammar import BLANK, MAX_DIGITS, NUMBER, SHORT_NATURAL, Fail, to_number
from ingest.read.limits import ReadLimits
from ingest.read.plyheader import Element, Header
from ingest.read.plyrows import FaceRows


def _lines_of(token: bytes) -> re.Pattern[bytes]:
    row = rb"(?:B*+T(?:B++T)*B*+\n)*".replace(b"B", BLANK)
    return re.compile(row.replace(b"T", rb"(?:" + token + rb")"))


_NUMBER_LINES = _lines_of(NUMBER)
_NATURAL_LINES = _lines_of(SHORT_NATURAL)


class TextBody:
    """Reads the elements of a text body; see :class:`ingest.read.plyrows.Body`."""

    def __init__(self, data: bytes, header: Header, limits: ReadLimits, fail: Fail) -> None:
        self._text = grammar.unix_newlines(data[header.body :])
        self._first_line = header.lines + 1
        self._limits = limits
        self._fail = fail
        grammar.refuse_nul(self._text, fail, self._first_line)
        ends = np.flatnonzero(np.frombuffer(self._text, np.uint8) == ord("\n"))
        self._begins = np.concatenate(([0], ends + 1))  # of every line, and of none after the last
        lengths = np.diff(self._begins)
        if lengths.max() > limits.max_line_bytes + 1:
            line = self._first_line + int(lengths.argmax())
            fail(f"the line is longer than {limits.max_line_bytes:,} bytes", line=line)
        self._line = 0  # the next to read

    def points(self, element: Element, xyz: tuple[int, int, int]) -> NDArray[np.float64]:
        columns = list(xyz)
        text = self._take_uniform(element, _NUMBER_LINES)
        if text is not None and all(prop.count_type is None for prop in element.properties):
            width = len(element.properties)
            if (grammar.tokens_per_line(text) == width).all():
                points = grammar.numbers(text).reshape(-1, width)[:, columns]
                if np.isfinite(points).all():
                    self._line += element.count
                    return points
        points = np.empty((element.count, 3))
        for row in range(element.count):
            line, tokens = self._next_line(element, row)
            starts = self._starts(element, line, tokens)
            points[row] = [to_number(tokens[starts[at]], self._fail, line) for at in columns]
        return points

    def faces(self, element: Element, indices: int) -> FaceRows:
        first_line = self._first_line + self._line
        text = self._take_uniform(element, _NATURAL_LINES)
        if text is not None:
            rows = _walk(text, element, indices)
            if rows is not None and self._allowed(rows[1]):
                self._line += element.count
                return FaceRows(*rows, place=lambda face: (first_line + face, f"face {face}"))
        lines: list[int] = []
        corners: list[int] = []
        arities: list[int] = []
        for row in range(element.count):
            line, tokens = self._next_line(element, row)
            start = self._starts(element, line, tokens)[indices]
            arity = int(tokens[start])
            if not 3 <= arity <= self._limits.max_arity:
                self._fail(
                    f"face {row} has {arity} corners; 3 to {self._limits.max_arity} are allowed",
                    line=line,
                    token=tokens[start],
                )
            corners += [
                self._natural(token, line, "a vertex index")
                for token in tokens[start + 1 : start + 1 + arity]
            ]
            arities.append(arity)
            lines.append(line)
        return FaceRows(
            np.array(corners, np.int64),
            np.array(arities, np.int64),
            place=lambda face: (lines[face], f"face {face}"),
        )

    def skip(self, element: Element) -> None:
        for row in range(element.count):
            line, tokens = self._next_line(element, row)
            self._starts(element, line, tokens)

    def finish(self) -> None:
        rest = self._text[self._begins[self._line] :]
        if rest.strip():
            blank = len(rest) - len(rest.lstrip())
            line = self._first_line + self._line + rest.count(b"\n", 0, blank)
            self._fail(
                "more lines than the header promises; correct its counts",
                line=line,
                token=rest.split(None, 1)[0],
            )

    def _take_uniform(self, element: Element, pattern: re.Pattern[bytes]) -> bytes | None:
        """The next ``count`` lines, if there are as many and each matches the pattern."""
        last = self._line + element.count
        if last >= len(self._begins):
            return None
        text = self._text[self._begins[self._line] : self._begins[last]]
        return text if pattern.fullmatch(text) else None

    def _allowed(self, arities: NDArray[np.int64]) -> bool:
        return bool(((arities >= 3) & (arities <= self._limits.max_arity)).all())

    def _next_line(self, element: Element, row: int) -> tuple[int, list[bytes]]:
        """Number and tokens of the next line that is not blank."""
        while self._line < len(self._begins) - 1:
            begin, end = self._begins[self._line : self._line + 2]
            self._line += 1
            tokens = self._text[begin:end].split()
            if tokens:
                return self._first_line + self._line - 1, tokens
        self._fail(
            f"the file ends at {element.name} {row} of the {element.count:,} "
            "its header promises; is it cut short?",
            line=self._first_line + self._line - 1,
        )

    def _starts(self, element: Element, line: int, tokens: list[bytes]) -> list[int]:
        """Where on the line each property starts; fails unless they fill it exactly."""
        starts: list[int] = []
        at = 0
        for prop in element.properties:
            starts.append(at)
            if at >= len(tokens):
                self._misfit(element, line, tokens)
            if prop.count_type is not None:
                at += self._natural(tokens[at], line, f"the length of list {prop.name}")
            at += 1
        if at != len(tokens):
            self._misfit(element, line, tokens)
        return starts

    def _misfit(self, element: Element, line: int, tokens: list[bytes]) -> NoReturn:
        names = " ".join(prop.name for prop in element.properties[:16])
        self._fail(
            f"the line does not hold exactly one {element.name} ({names}): "
            f"its {len(tokens)} values are too many or too few",
            line=line,
            token=b" ".join(tokens[:16]),
        )

    def _natural(self, token: bytes, line: int, what: str) -> int:
        if not token.isdigit() or len(token) > MAX_DIGITS:
            self._fail(f"{what} must be a natural number", line=line, token=token)
        return int(token)


def _walk(
    text: bytes, element: Element, indices: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]] | None:
    """Corners and arities of rows of natural numbers, one row a line; None if any row misfits.

    All rows step through the properties together, each from its own position.
    """
    values = grammar.integers(text)
    widths = grammar.tokens_per_line(text)
    ends = np.cumsum(widths)
    at = ends - widths
    corners = arities = np.empty(0, np.int64)
    for position, prop in enumerate(element.properties):
        if (at >= ends).any():
            return None
        if prop.count_type is not None:
            lengths = values[at]
            if (lengths > ends - at - 1).any():
                return None
            if position == indices:
                arities = lengths
                rank = np.arange(lengths.sum()) - np.repeat(np.cumsum(lengths) - lengths, lengths)
                corners = values[np.repeat(at + 1, lengths) + rank]
            at = at + lengths
        at = at + 1
    return (corners, arities) if (at == ends).all() else None
