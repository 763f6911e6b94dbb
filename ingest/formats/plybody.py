"""The body of a PLY file, text or binary: the elements that its header promises.

In text every row has a line of its own. The format's description says so, and only so can a
number too many or too few be noticed where it is: read as one stream of numbers, it would
shift all that follow.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NoReturn, Protocol

import numpy as np
from numpy.typing import NDArray

from ingest.formats import grammar
from ingest.formats.files import ReadLimits, explain_arity
from ingest.formats.grammar import MAX_DIGITS, NUMBER, SHORT_NATURAL, Fail, to_number
from ingest.formats.plyheader import Element, Header


@dataclass(frozen=True, slots=True)
class FaceRows:
    """The faces of a PLY file.

    corners: (c,) int64, as written. arities: (f,) int64.
    place:   the line of face i (None in a binary file), and words that say where it is.
    """

    corners: NDArray[np.int64]
    arities: NDArray[np.int64]
    place: Callable[[int], tuple[int | None, str]]


class PlyBody(Protocol):
    """Reads the elements of a body, one after another, in the order of the header."""

    def points(self, element: Element, xyz: tuple[int, int, int]) -> NDArray[np.float64]:
        """(v, 3) the properties at the three positions, of every row; all finite."""
        ...

    def faces(self, element: Element, indices: int) -> FaceRows:
        """The lists of the property at the position, of every row; all of allowed length."""
        ...

    def skip(self, element: Element) -> None:
        """Pass over all rows."""
        ...

    def finish(self) -> None:
        """Fail if anything follows the last element."""
        ...


# Text


_NUMBER_LINES = grammar.compile_lines(NUMBER)
_NATURAL_LINES = grammar.compile_lines(SHORT_NATURAL)


class TextBody:
    """Reads the elements of a text body; see :class:`PlyBody`."""

    def __init__(self, data: bytes, header: Header, limits: ReadLimits, fail: Fail) -> None:
        self._text = grammar.normalise_newlines(data[header.body :])
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
            if (grammar.count_tokens(text) == width).all():
                points = grammar.parse_numbers(text).reshape(-1, width)[:, columns]
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
                    f"face {row} {explain_arity(arity, self._limits)}",
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
    values = grammar.parse_integers(text)
    widths = grammar.count_tokens(text)
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


# Binary, of either byte order


class BinaryBody:
    """Reads the elements of a binary body; see :class:`PlyBody`.

    Nothing is allocated by a number the file promises before that number is known to fit
    into the bytes that are left.
    """

    def __init__(self, data: bytes, header: Header, limits: ReadLimits, fail: Fail) -> None:
        self._data = data
        self._at = header.body
        self._order = header.order
        self._limits = limits
        self._fail = fail

    def points(self, element: Element, xyz: tuple[int, int, int]) -> NDArray[np.float64]:
        lengths = self._first_lengths(element)
        rows = self._uniform(element, lengths)
        if rows is not None:
            places = self._at + rows.itemsize * np.arange(element.count)
            points = _to_float64([rows[f"p{column}"] for column in xyz])
            self._at += rows.nbytes
        else:
            places = np.array([begin for begin, _ in self._walk(element, None)], np.int64)
            points = _to_float64([self._gather_scalar(element, places, column) for column in xyz])
        finite = np.isfinite(points).all(axis=1)
        if not finite.all():
            at = int(np.argmin(finite))
            self._fail(
                f"vertex {at} at byte {places[at]} is not finite: {points[at].tolist()}; repair it"
            )
        return points

    def faces(self, element: Element, indices: int) -> FaceRows:
        lengths = self._first_lengths(element)
        rows = self._uniform(element, lengths)
        if rows is not None:
            places = self._at + rows.itemsize * np.arange(element.count)
            arities = np.full(element.count, lengths[indices], np.int64)
            self._check_arities(arities, places)
            corners = rows[f"p{indices}"].astype(np.int64).ravel()
            self._at += rows.nbytes
        else:
            found = np.array(list(self._walk(element, indices)), np.int64).reshape(-1, 2)
            places = found[:, 0]
            arities = self._gather_counts(element, found[:, 1], indices)
            self._check_arities(arities, places)
            corners = self._gather_lists(element, found[:, 1], arities, indices)
        return FaceRows(
            corners, arities, place=lambda face: (None, f"face {face} at byte {places[face]}")
        )

    def skip(self, element: Element) -> None:
        rows = self._uniform(element, self._first_lengths(element))
        if rows is not None:
            self._at += rows.nbytes
        else:
            for _ in self._walk(element, None):
                pass

    def finish(self) -> None:
        rest = len(self._data) - self._at
        if rest:
            self._fail(
                f"{rest:,} bytes too many after the last element, from byte {self._at}; "
                "the header's counts or types do not fit the body"
            )

    def _check_arities(self, arities: NDArray[np.int64], places: NDArray[np.int64]) -> None:
        wrong = (arities < 3) | (arities > self._limits.max_arity)
        if wrong.any():
            face = int(wrong.argmax())
            self._fail(
                f"face {face} at byte {places[face]} "
                + explain_arity(int(arities[face]), self._limits)
            )

    def _cut_short(self, element: Element, row: int) -> str:
        return (
            f"the file ends at byte {len(self._data)} in {element.name} {row} of the "
            f"{element.count:,} its header promises; is it cut short?"
        )

    # Rows of one length

    def _first_lengths(self, element: Element) -> list[int]:
        """The length of every property in the first row: 1, or that of its list."""
        if not element.count:
            return [1] * len(element.properties)
        lengths: list[int] = []
        at = self._at
        for prop in element.properties:
            length = 1
            if prop.count_type is not None:
                size = np.dtype(prop.count_type).itemsize
                if at + size > len(self._data):
                    self._fail(self._cut_short(element, 0))
                count = np.frombuffer(self._data, self._order + prop.count_type, 1, at)
                length = self._length(int(count[0]), at)
                at += size
            at += length * np.dtype(prop.type).itemsize
            lengths.append(length)
        if at > len(self._data):
            self._fail(self._cut_short(element, 0))
        return lengths

    def _length(self, count: int, at: int) -> int:
        if count < 0:
            self._fail(f"a list of negative length {count} at byte {at}")
        return count

    def _uniform(self, element: Element, lengths: list[int]) -> NDArray[np.void] | None:
        """All rows, field ``p<i>`` for property i, if every row has the lengths of the first."""
        fields: list[tuple[str, str] | tuple[str, str, tuple[int]]] = []
        for i, (prop, length) in enumerate(zip(element.properties, lengths, strict=True)):
            if prop.count_type is None:
                fields.append((f"p{i}", self._order + prop.type))
            else:
                fields.append((f"n{i}", self._order + prop.count_type))
                fields.append((f"p{i}", self._order + prop.type, (length,)))
        dtype = np.dtype(fields)
        if dtype.itemsize * element.count > len(self._data) - self._at:
            if all(prop.count_type is None for prop in element.properties):
                row = (len(self._data) - self._at) // dtype.itemsize
                self._fail(self._cut_short(element, row))
            return None
        rows = np.frombuffer(self._data, dtype, element.count, self._at)
        for i, (prop, length) in enumerate(zip(element.properties, lengths, strict=True)):
            if prop.count_type is not None and (rows[f"n{i}"] != length).any():
                return None
        return rows

    # Rows of different lengths

    def _walk(self, element: Element, wanted: int | None) -> Iterator[tuple[int, int]]:
        """Byte offset of every row, and of the list at position ``wanted`` in it.

        A row's place depends on the lengths in all rows before it, so this one step is
        not vectorised; the values are gathered afterwards, all at once.
        """
        end = len(self._data)
        steps: list[tuple[int, struct.Struct, int, bool]] = []
        skip = 0
        for i, prop in enumerate(element.properties):
            size = np.dtype(prop.type).itemsize
            if prop.count_type is None:
                skip += size
            else:
                code = (self._order or "=") + _STRUCT_CODES[prop.count_type]
                steps.append((skip, struct.Struct(code), size, i == wanted))
                skip = 0
        at = self._at
        for row in range(element.count):
            begin = at
            place = 0
            for before, count_type, size, is_wanted in steps:
                at += before
                if at + count_type.size > end:
                    self._fail(self._cut_short(element, row))
                (count,) = count_type.unpack_from(self._data, at)
                if is_wanted:
                    place = at
                at += count_type.size + self._length(count, at) * size
            at += skip
            if at > end:
                self._fail(self._cut_short(element, row))
            yield begin, place
        self._at = at

    def _gather_scalar(
        self, element: Element, rows: NDArray[np.int64], column: int
    ) -> NDArray[Any]:
        """(n,) a scalar property of rows that hold lists; only possible ahead of the lists."""
        ahead = element.properties[:column]
        if any(prop.count_type is not None for prop in ahead):
            self._fail(
                "a coordinate after a list in the same element; put x, y and z first",
                line=element.line,
            )
        offset = sum(np.dtype(prop.type).itemsize for prop in ahead)
        return self._at_bytes(rows + offset, element.properties[column].type)

    def _gather_counts(
        self, element: Element, lists: NDArray[np.int64], indices: int
    ) -> NDArray[np.int64]:
        count_type = element.properties[indices].count_type
        assert count_type is not None
        return self._at_bytes(lists, count_type).astype(np.int64)

    def _gather_lists(
        self,
        element: Element,
        lists: NDArray[np.int64],
        arities: NDArray[np.int64],
        indices: int,
    ) -> NDArray[np.int64]:
        prop = element.properties[indices]
        size = np.dtype(prop.type).itemsize
        firsts = lists + prop.min_bytes
        ranks = np.arange(arities.sum()) - np.repeat(np.cumsum(arities) - arities, arities)
        return self._at_bytes(np.repeat(firsts, arities) + size * ranks, prop.type).astype(np.int64)

    def _at_bytes(self, places: NDArray[np.int64], type_: str) -> NDArray:
        """The values of one type at any byte offsets, aligned or not."""
        dtype = np.dtype(self._order + type_)
        values = np.empty(len(places), dtype)
        # One view of the data per alignment: each is an ordinary array to index into.
        for shift in range(min(dtype.itemsize, len(self._data))):
            chosen = places % dtype.itemsize == shift
            if chosen.any():
                length = (len(self._data) - shift) // dtype.itemsize
                view = np.frombuffer(self._data, dtype, length, shift)
                values[chosen] = view[places[chosen] // dtype.itemsize]
        return values


def _to_float64(columns: Sequence[NDArray[Any]]) -> NDArray[np.float64]:
    with np.errstate(invalid="ignore"):  # a signalling NaN; refused with the other NaNs
        return np.column_stack(columns).astype(np.float64)


_STRUCT_CODES = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I"}
