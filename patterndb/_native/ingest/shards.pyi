# Bound by rust/python/src/ingest.rs.
import numpy as np

from patterndb.core.halfedge import Int32Array

def breadth_first(twin: Int32Array, root: int, inside: np.ndarray, part: Int32Array) -> Int32Array:
    """The quads of the part by distance from the root; unconnected ones follow theirs."""
