# Bound by rust/python/src/ingest.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array

def collapse_all(vertex: Int32Array, twin: Int32Array, n_vertices: int) -> NDArray[np.bool_]:
    """Collapse in place; return (q,) bool, the quads that are left."""
