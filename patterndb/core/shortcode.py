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

from patterndb._native.core.shortcode import name_once, name_twice
from patterndb._native.core.shortcode import pack_symbols as _pack_symbols
from patterndb.core.code import Code
from patterndb.core.packing import PackedRows, pack_many, unpack_many
from patterndb.errors import InvalidCodeError


def shorten(codes: Sequence[bytes]) -> list[bytes]:
    """The short codes of packed codes. Raises InvalidCodeError for what is none."""
    symbols, offsets = unpack_many(codes)
    numbers, ends, bad = name_once(symbols, offsets)
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
    flat, offsets, bad = name_twice(np.frombuffer(b"".join(short), np.uint8), ends)
    if bad >= 0:
        raise InvalidCodeError(f"what is stored of code {bad} of {len(short)} is no code", bad)
    return flat, offsets


def pack_symbols(symbols: Code, offsets: NDArray[np.int64]) -> PackedRows:
    """The packed codes of what :func:`restore` gives."""
    return PackedRows(*_pack_symbols(symbols, offsets))


def lengthen(short: Sequence[bytes]) -> list[bytes]:
    """The packed codes of short codes; raises as :func:`restore`."""
    return pack_symbols(*restore(short))[:]
