"""Small integers as bytes: seven bits a byte, the high bit saying that more follow.

Nearly every number in a code or a label is below 128, so most take one byte.
"""

from __future__ import annotations

import itertools
import operator
from collections.abc import Iterator, Sequence
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from patterndb.errors import InvalidCodeError

#: Numbers must stay below this, so that they unpack into 32 bits.
LIMIT = 1 << 31


def pack(values: NDArray[np.integer] | Sequence[int]) -> bytes:
    """The numbers, each in 0..LIMIT - 1, as bytes. Raises ValueError for others."""
    array = np.asarray(values, dtype=np.int64)
    return pack_many(array, [0, len(array)])[0]


def pack_many(
    flat: NDArray[np.integer], offsets: NDArray[np.integer] | Sequence[int]
) -> list[bytes]:
    """``flat[offsets[i]:offsets[i + 1]]`` packed, for every i."""
    cuts = np.asarray(offsets)
    low, high = (int(flat.min()), int(flat.max())) if len(flat) else (0, 0)
    if low < 0 or high >= LIMIT:
        raise ValueError(f"numbers must lie in 0..{LIMIT - 1}")
    if high < 128:
        raw = flat.astype(np.uint8)
    else:
        values = flat.astype(np.int64)
        n_bytes = np.ones(len(values), np.int64)
        for bits in (7, 14, 21, 28):
            n_bytes += values >> bits != 0
        start = np.append(0, np.cumsum(n_bytes))
        raw = np.empty(start[-1], np.uint8)
        for k in range(int(n_bytes.max())):
            here = np.flatnonzero(n_bytes > k)
            more = np.where(n_bytes[here] > k + 1, 128, 0)
            raw[start[here] + k] = values[here] >> 7 * k & 127 | more
        cuts = start[cuts]
    data = raw.tobytes()
    return [data[a:b] for a, b in itertools.pairwise(cuts.tolist())]


def unpack(data: bytes) -> NDArray[np.int32]:
    """The numbers packed in ``data``, (n,) int32. Raises
    InvalidCodeError if it ends in the middle of one."""
    raw = np.frombuffer(data, np.uint8)
    last = raw < 128
    if last.all():
        return raw.astype(np.int32)
    if not last[-1]:
        raise InvalidCodeError("packed numbers end in the middle of one")
    end = np.flatnonzero(last)
    start = np.zeros(len(end), np.int64)
    start[1:] = end[:-1] + 1
    place = np.arange(len(raw)) - np.repeat(start, end - start + 1)
    return np.add.reduceat((raw & 127).astype(np.int64) << (7 * place), start).astype(np.int32)


def unpack_many(blobs: Sequence[bytes]) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """The numbers of many blobs in one array, and the (n + 1,) offsets that part them.

    Raises InvalidCodeError if one of them ends in the middle of a number.
    """
    if any(blob and blob[-1] > 127 for blob in blobs):
        raise InvalidCodeError("packed numbers end in the middle of one")
    data = b"".join(blobs)
    last = np.r_[0, np.cumsum(np.frombuffer(data, np.uint8) < 128)]
    ends = np.cumsum([len(blob) for blob in blobs], dtype=np.int64)
    return unpack(data), last[np.r_[0, ends].astype(np.int64)].astype(np.int64)


class PackedRows(Sequence[bytes]):
    """Bytes of many rows in one array, as a sequence of a ``bytes`` a row.

    Takes the place of a list where there are too many rows for an object each.
    """

    __slots__ = ("ends", "raw")

    def __init__(self, raw: NDArray[np.uint8], ends: NDArray[np.int64]) -> None:
        """raw: (b,) bytes of all rows. ends: (n + 1,); row i is ``raw[ends[i]:ends[i + 1]]``."""
        self.raw = raw
        self.ends = ends

    @classmethod
    def of(cls, rows: Sequence[bytes]) -> PackedRows:
        """Of the bytes of every row; the rows themselves if they are packed."""
        if isinstance(rows, PackedRows):
            return rows
        ends = np.zeros(len(rows) + 1, np.int64)
        np.cumsum(np.fromiter(map(len, rows), np.int64, len(rows)), out=ends[1:])
        return cls(np.frombuffer(b"".join(rows), np.uint8), ends)

    @classmethod
    def join(cls, parts: Sequence[PackedRows]) -> PackedRows:
        """The rows of several, one after the other."""
        sizes = [np.zeros(0, np.int64), *(np.diff(part.ends) for part in parts)]
        ends = np.zeros(sum(map(len, sizes)) + 1, np.int64)
        np.cumsum(np.concatenate(sizes), out=ends[1:])
        raw = [part.raw[part.ends[0] : part.ends[-1]] for part in parts]
        return cls(np.concatenate([np.zeros(0, np.uint8), *raw]), ends)

    def take(self, rows: NDArray[np.integer]) -> PackedRows:
        """The rows of these places, in this order."""
        sizes = np.diff(self.ends)[rows]
        ends = np.zeros(len(rows) + 1, np.int64)
        np.cumsum(sizes, out=ends[1:])
        return PackedRows(take_stretches(self.raw, self.ends[rows], sizes), ends)

    def __len__(self) -> int:
        return len(self.ends) - 1

    def __iter__(self) -> Iterator[bytes]:
        return iter(self[:])

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, PackedRows):
            return NotImplemented
        return np.array_equal(self.ends, other.ends) and np.array_equal(self.raw, other.raw)

    __hash__ = None  # pyright: ignore[reportAssignmentType]

    @overload
    def __getitem__(self, at: int) -> bytes: ...

    @overload
    def __getitem__(self, at: slice) -> list[bytes]: ...

    def __getitem__(self, at: int | slice) -> bytes | list[bytes]:
        if isinstance(at, slice):
            rows = range(*at.indices(len(self)))
            if rows.step != 1:
                return [self[i] for i in rows]
            cuts = self.ends[rows.start : rows.stop + 1] if rows else self.ends[:1]
            data = self.raw[cuts[0] : cuts[-1]].tobytes()
            return [data[a:b] for a, b in itertools.pairwise((cuts - cuts[0]).tolist())]
        row = operator.index(at)
        if not -len(self) <= row < len(self):
            raise IndexError(f"there are {len(self)} rows, and none has the number {at}")
        row %= len(self)
        return self.raw[self.ends[row] : self.ends[row + 1]].tobytes()


def take_rows(rows: Sequence[bytes], places: NDArray[np.integer]) -> Sequence[bytes]:
    """The rows of these places, in this order."""
    if isinstance(rows, PackedRows):
        return rows.take(places)
    chosen: list[bytes] = [rows[i] for i in places.tolist()]
    return chosen


#: Stretches that are taken at a time: their places are eight bytes for every number.
TAKEN_AT_ONCE = 1 << 14


def take_stretches(
    flat: NDArray[Any], starts: NDArray[np.integer], sizes: NDArray[np.integer]
) -> NDArray[Any]:
    """Take stretches of so many numbers from these places on, one after the other, of an array."""
    ends = np.zeros(len(sizes) + 1, np.int64)
    np.cumsum(sizes, out=ends[1:])
    taken = np.empty(ends[-1], flat.dtype)
    for at in range(0, len(sizes), TAKEN_AT_ONCE):
        some = slice(at, at + TAKEN_AT_ONCE)
        first, *_, last = ends[at : at + TAKEN_AT_ONCE + 1].tolist()
        shifts = np.repeat(starts[some] - ends[:-1][some], sizes[some])
        taken[first:last] = flat[np.arange(first, last) + shifts]
    return taken
