# Bound by rust/python/src/ingest.rs.
from ingest.census import UInt64Array

def random_pairs(n: int) -> UInt64Array:
    """(n, 2) uint64 fixed pseudo-random numbers."""
