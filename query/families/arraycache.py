"""Arrays that take a while to make, kept in the user's cache folder between runs."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from patterndb.system.caches import read_cached, write_cached

Array = NDArray[Any]

#: What a file may hold, by number; little-endian on every machine.
DTYPES = ("|u1", "<u2", "<i4", "<i8", "|b1")

DIGEST_BYTES = 32


def load_or_make(name: str, make: Callable[[], Sequence[Array]]) -> list[Array]:
    """The arrays of that name: from the cache, else made and put there.

    name: a file name that tells apart whatever ``make`` may return, its version included. A
    file that is damaged, or is not of this name, is made anew. Where nothing can be written
    the arrays are made every time.
    """
    kept = read_cached(name)
    if kept is not None:
        arrays = _from_bytes(name, kept)
        if arrays is not None:
            return arrays
    arrays = list(make())
    write_cached(name, _to_bytes(name, arrays))
    return arrays


def _to_bytes(name: str, arrays: Sequence[Array]) -> bytes:
    head = [len(arrays)]
    body: list[bytes] = []
    for array in arrays:
        code = next(i for i, dtype in enumerate(DTYPES) if array.dtype == np.dtype(dtype))
        head += [code, array.ndim, *array.shape]
        body.append(np.ascontiguousarray(array, DTYPES[code]).tobytes())
    data = np.array([len(head), *head], "<i8").tobytes() + b"".join(body)
    return _digest(name, data) + data


def _from_bytes(name: str, kept: bytes) -> list[Array] | None:
    data = kept[DIGEST_BYTES:]
    if _digest(name, data) != kept[:DIGEST_BYTES]:
        return None
    size = int(np.frombuffer(data, "<i8", 1)[0])
    head = np.frombuffer(data, "<i8", size, 8).tolist()
    at = 8 * (1 + size)
    arrays: list[Array] = []
    read = 1
    for _ in range(head[0]):
        dtype = np.dtype(DTYPES[head[read]])
        shape = head[read + 2 : read + 2 + head[read + 1]]
        read += 2 + head[read + 1]
        count = int(np.prod(shape, dtype=np.int64))
        # A copy in the machine's own order, aligned and free to be written.
        array = np.frombuffer(data, dtype, count, at).reshape(shape)
        arrays.append(array.astype(dtype.newbyteorder("=")))
        at += count * dtype.itemsize
    return arrays


def _digest(name: str, data: bytes) -> bytes:
    return hashlib.blake2b(name.encode() + b"\0" + data, digest_size=DIGEST_BYTES).digest()
