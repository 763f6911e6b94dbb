# Bound by rust/python/src/ingest.rs.
import numpy as np
from numpy.typing import NDArray

from ingest.census import UInt64Array
from patterndb.core.halfedge import Int32Array

def hash_rows(raw: NDArray[np.uint8], ends: NDArray[np.int64]) -> UInt64Array:
    """(n, 2) the hashes of packed codes."""

def pack_faces(
    quads: Int32Array, sizes: Int32Array, faces: NDArray[np.int64]
) -> tuple[NDArray[np.uint8], NDArray[np.int64]]:
    """Pack the examples of patterns, one after the other, as schema.sql says, by
    the faces (q,) of quads; and where each ends.
    """
