"""Codes as the database stores them: each edge between two quads is named once, and not twice.

A code (:mod:`patterndb.core.code`) names the edge across from every edge. Where that comes later in
the code it is stored, as the number of places ahead; where it came before it follows from what was
stored there; on the border 0 is stored. Numbers are packed, seven bits a byte, and nearly all take
one: a short code is about half as long as a packed one. There is one short code for every code.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from patterndb.core.code import MAX_QUADS, Code
from patterndb.core.packing import PackedRows, pack_many, unpack_many
from patterndb.errors import InvalidCodeError
from patterndb.system.kernels import kernel


def shorten(codes: Sequence[bytes]) -> list[bytes]:
    """The short codes of packed codes. Raises InvalidCodeError for what is none."""
    symbols, offsets = unpack_many(codes)
    numbers, ends, bad = _name_once(symbols, offsets)
    if bad >= 0:
        raise InvalidCodeError(f"code {bad} of {len(codes)} does not pair its edges", bad)
    return pack_many(numbers, ends)


def restore(short: Sequence[bytes]) -> tuple[Code, NDArray[np.int64]]:
    """The symbols of short codes in one uint16 array, and the (n + 1,) offsets that part them.

    The symbols pair all edges; whether they are the canonical code of a disk is for
    :func:`patterndb.core.description.describe_symbols` to say. Raises InvalidCodeError, with its
    row, for what is no short code.
    """
    ends = np.zeros(len(short) + 1, np.int64)
    np.cumsum(np.fromiter(map(len, short), np.int64, len(short)), out=ends[1:])
    flat, offsets, bad = _name_twice(np.frombuffer(b"".join(short), np.uint8), ends)
    if bad >= 0:
        raise InvalidCodeError(f"what is stored of code {bad} of {len(short)} is no code", bad)
    return flat, offsets


def pack_symbols(symbols: Code, offsets: NDArray[np.int64]) -> PackedRows:
    """The packed codes of what :func:`restore` gives."""
    return PackedRows(*_pack_symbols(symbols, offsets))


def lengthen(short: Sequence[bytes]) -> list[bytes]:
    """The packed codes of short codes; raises as :func:`restore`."""
    return pack_symbols(*restore(short))[:]


@kernel
def _name_once(
    symbols: NDArray[np.int32], offsets: NDArray[np.int64]
) -> tuple[NDArray[np.int32], NDArray[np.int64], int]:
    """What is stored of codes, the (n + 1,) ends of each, and the first that is none, or -1."""
    n = len(offsets) - 1
    numbers = np.empty(len(symbols), np.int32)
    ends = np.zeros(n + 1, np.int64)
    at = 0
    for i in range(n):
        begin = offsets[i]
        size = offsets[i + 1] - begin
        if size == 0 or size % 4:
            return numbers[:at], ends, i
        for h in range(size):
            t = symbols[begin + h] - 1
            if t < -1 or t >= size or t == h or (t >= 0 and symbols[begin + t] - 1 != h):
                return numbers[:at], ends, i
            if t < 0:
                numbers[at] = 0
                at += 1
            elif t > h:
                numbers[at] = t - h
                at += 1
        ends[i + 1] = at
    return numbers[:at], ends, -1


@kernel
def _name_twice(
    raw: NDArray[np.uint8], ends: NDArray[np.int64]
) -> tuple[Code, NDArray[np.int64], int]:
    """Symbols of short codes, their offsets, and the first row that is no short code, or -1."""
    n = len(ends) - 1
    # Every byte is a number or a part of one, and a number names two edges at most.
    flat = np.zeros(2 * len(raw), np.uint16)
    named = np.zeros(2 * len(raw), np.bool_)
    offsets = np.zeros(n + 1, np.int64)
    for i in range(n):
        begin = offsets[i]
        most = min(2 * (ends[i + 1] - ends[i]), 4 * MAX_QUADS)
        at = ends[i]
        h = 0
        count = 0
        while True:
            if h < most and named[begin + h]:
                h += 1
                continue
            if at == ends[i + 1]:
                break
            if h >= most:
                return flat[:0], offsets, i
            ahead = np.int64(0)
            shift = 0
            while True:
                byte = np.int64(raw[at])
                at += 1
                ahead |= (byte & 127) << shift
                shift += 7
                if byte < 128:
                    break
                if at == ends[i + 1] or shift > 14:
                    return flat[:0], offsets, i
            # A last byte of 0 would be a second way to write the number.
            if shift > 7 and byte == 0:
                return flat[:0], offsets, i
            named[begin + h] = True
            count += 1
            if ahead:
                t = h + ahead
                if t >= most or named[begin + t]:
                    return flat[:0], offsets, i
                named[begin + t] = True
                count += 1
                flat[begin + h] = t + 1
                flat[begin + t] = h + 1
            h += 1
        # All edges up to the last are named, of whole quads.
        if h == 0 or h % 4 or count != h:
            return flat[:0], offsets, i
        offsets[i + 1] = begin + h
    return flat[: offsets[n]].copy(), offsets, -1


@kernel
def _pack_symbols(
    symbols: Code, offsets: NDArray[np.int64]
) -> tuple[NDArray[np.uint8], NDArray[np.int64]]:
    """Symbols seven bits a byte, as :mod:`patterndb.core.packing` has them, and the rows' ends."""
    ends = np.zeros(len(offsets), np.int64)
    raw = np.empty(3 * len(symbols), np.uint8)
    at = 0
    for i in range(len(offsets) - 1):
        for k in range(offsets[i], offsets[i + 1]):
            symbol = symbols[k]
            while symbol > 127:
                raw[at] = symbol & 127 | 128
                symbol >>= 7
                at += 1
            raw[at] = symbol
            at += 1
        ends[i + 1] = at
    return raw[:at].copy(), ends
