# Bound by rust/python/src/ingest.rs.
import numpy as np
from numpy.typing import NDArray

from ingest.census import UInt64Array
from patterndb.core.halfedge import Index

def random_pairs(n: int) -> UInt64Array:
    """(n, 2) uint64 fixed pseudo-random numbers."""

def hash_symbols(code: NDArray[np.unsignedinteger], n: int) -> tuple[np.uint64, np.uint64]:
    """128-bit hash of the first n symbols of a code, or bytes of a packed one."""

def find(keys: UInt64Array, a: Index, b: Index) -> Index:
    """Slot of key (a, b) in an open-addressing table, or ``-1 - slot`` of where it belongs.

    keys: (2^k, 2) uint64; an empty slot is (0, 0).
    """

def double_set(keys: UInt64Array) -> UInt64Array:
    """The same set in a table of twice the size."""

def double_map(
    keys: UInt64Array, values: NDArray[np.int32]
) -> tuple[UInt64Array, NDArray[np.int32]]:
    """The same map in a table of twice the size."""
