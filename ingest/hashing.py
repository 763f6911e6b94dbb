"""128-bit hashes of sets and sequences, and open-addressing sets of them.

A set of quads is hashed as the exclusive or of its quads' random numbers (Zobrist), so
adding a quad is one operation. Patch counts are exact as long as no two of a mesh's
patches share a hash; with 128 bits and 10^8 patches that has a chance of 10^-23.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Index
from patterndb.system.kernels import kernel

UInt64Array = NDArray[np.uint64]

#: Share of slots in use at which a set doubles: linear probing stays short below it.
LOAD = 0.625


@kernel(inline="always")
def mix(x: np.uint64) -> np.uint64:
    """The finaliser of splitmix64: every input bit reaches every output bit."""
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return x ^ (x >> np.uint64(31))


@kernel
def random_pairs(n: int) -> UInt64Array:
    """(n, 2) uint64 fixed pseudo-random numbers."""
    pairs = np.empty((n, 2), np.uint64)
    for i in range(n):
        for lane in range(2):
            seed = np.uint64(2 * i + lane + 1) * np.uint64(0x9E3779B97F4A7C15)
            pairs[i, lane] = mix(mix(seed) + np.uint64(0xD1B54A32D192ED03))
    return pairs


@kernel(borrowing=True)
def hash_symbols(code: NDArray[np.unsignedinteger], n: int) -> tuple[np.uint64, np.uint64]:
    """128-bit hash of the first n symbols of a code, or bytes of a packed one."""
    a = np.uint64(0x243F6A8885A308D3) + np.uint64(n)
    b = np.uint64(0x13198A2E03707344) ^ np.uint64(n)
    for i in range(n):
        s = np.uint64(code[i]) + np.uint64(1)
        a = (a ^ s) * np.uint64(0x9FB21C651E98DF25)
        a ^= a >> np.uint64(28)
        b = (b + s) * np.uint64(0xD6E8FEB86659FD93)
        b ^= b >> np.uint64(32)
    return mix(a), mix(b)


@kernel(borrowing=True)
def find(keys: UInt64Array, a: Index, b: Index) -> Index:
    """Slot of key (a, b) in an open-addressing table, or ``-1 - slot`` of where it belongs.

    keys: (2^k, 2) uint64; an empty slot is (0, 0).
    """
    mask = np.int64(keys.shape[0] - 1)
    slot = np.int64(a & np.uint64(mask))
    while True:
        if keys[slot, 0] == a and keys[slot, 1] == b:
            return slot
        if keys[slot, 0] == 0 and keys[slot, 1] == 0:
            return -1 - slot
        slot = (slot + 1) & mask


@kernel(borrowing=True)
def has_slot(used: Index, keys: UInt64Array) -> bool:
    """Can one more be put into a table with so many keys, or has it to be doubled first?"""
    return used + 1 <= LOAD * keys.shape[0]


@kernel(borrowing=True)
def empty_keys(keys: UInt64Array) -> None:
    """Take all keys out of a table."""
    for i in range(keys.shape[0]):
        keys[i, 0] = 0
        keys[i, 1] = 0


@kernel
def double_set(keys: UInt64Array) -> UInt64Array:
    """The same set in a table of twice the size."""
    bigger = np.zeros((2 * keys.shape[0], 2), np.uint64)
    for i in range(keys.shape[0]):
        a, b = keys[i, 0], keys[i, 1]
        if a != 0 or b != 0:
            slot = -1 - find(bigger, a, b)
            bigger[slot, 0] = a
            bigger[slot, 1] = b
    return bigger


@kernel
def double_map(
    keys: UInt64Array, values: NDArray[np.int32]
) -> tuple[UInt64Array, NDArray[np.int32]]:
    """The same map in a table of twice the size."""
    bigger = np.zeros((2 * keys.shape[0], 2), np.uint64)
    moved = np.zeros(2 * keys.shape[0], np.int32)
    for i in range(keys.shape[0]):
        a, b = keys[i, 0], keys[i, 1]
        if a != 0 or b != 0:
            slot = -1 - find(bigger, a, b)
            bigger[slot, 0] = a
            bigger[slot, 1] = b
            moved[slot] = values[i]
    return bigger, moved
