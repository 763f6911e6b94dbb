"""The body of a binary PLY file, of either byte order."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ingest.read.grammar import Fail
from ingest.read.limits import ReadLimits
from ingest.read.plyheader import Element, Header
from ingest.read.plyrows import FaceRows


class BinaryBody:
    """Reads the elements of a binary body; see :class:`ingest.read.plyrows.Body`.

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
                f"face {face} at byte {places[face]} has {arities[face]} corners; "
                f"3 to {self._limits.max_arity} are allowed"
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
