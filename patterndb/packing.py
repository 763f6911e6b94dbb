"""Small integers as bytes: seven bits a byte, the high bit saying that more follow.

Nearly every number in a code or a label is below 128, so most take one byte.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

#: Numbers must stay below this, so that they unpack into 32 bits.
LIMIT = 1 << 31


def pack(values: NDArray[np.integer] | Sequence[int]) -> bytes:
    """The numbers, each in 0..LIMIT - 1, as bytes."""
    array = np.asarray(values, dtype=np.int64)
    if not len(array):
        return b""
    if array.max() < 128 and array.min() >= 0:
        return array.astype(np.uint8).tobytes()
    if array.min() < 0 or array.max() >= LIMIT:
        raise ValueError(f"numbers must lie in 0..{LIMIT - 1}")
    out = bytearray()
    for value in array.tolist():
        while value >= 128:
            out.append(value & 127 | 128)
            value >>= 7
        out.append(value)
    return bytes(out)


def unpack(data: bytes) -> NDArray[np.int32]:
    """The numbers packed in ``data``, (n,) int32. Raises ValueError if it ends in the middle."""
    raw = np.frombuffer(data, np.uint8)
    last = raw < 128
    if last.all():
        return raw.astype(np.int32)
    if not last[-1]:
        raise ValueError("packed numbers end in the middle of one")
    start = np.r_[0, np.flatnonzero(last)[:-1] + 1]
    place = np.arange(len(raw)) - np.repeat(start, np.diff(np.r_[start, len(raw)]))
    return np.add.reduceat((raw & 127).astype(np.int64) << (7 * place), start).astype(np.int32)


def pack_many(
    flat: NDArray[np.integer], offsets: NDArray[np.integer] | Sequence[int]
) -> list[bytes]:
    """``flat[offsets[i]:offsets[i + 1]]`` packed, for every i."""
    cuts = np.asarray(offsets).tolist()
    if len(flat) and not 0 <= flat.min() <= flat.max() < 128:
        return [pack(flat[a:b]) for a, b in itertools.pairwise(cuts)]
    raw = flat.astype(np.uint8).tobytes()
    return [raw[a:b] for a, b in itertools.pairwise(cuts)]


def unpack_many(blobs: Sequence[bytes]) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """The numbers of many blobs in one array, and the (n + 1,) offsets that part them."""
    data = b"".join(blobs)
    last = np.r_[0, np.cumsum(np.frombuffer(data, np.uint8) < 128)]
    ends = np.cumsum([len(blob) for blob in blobs], dtype=np.int64)
    return unpack(data), last[np.r_[0, ends].astype(np.int64)].astype(np.int64)
