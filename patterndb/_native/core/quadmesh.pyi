# Bound by rust/python/src/core.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array

def flip_to_agree(quads: Int32Array, start: NDArray[np.int64], pairs: NDArray[np.int64]) -> None:
    """Flip quads in place, breadth-first from each component's first quad.

    A flip reverses the quad's corners, as reading it from the other side would.
    """

def components(twin: Int32Array) -> Int32Array:
    """Return the component of every quad (q,) int32, numbered by their first quads. twin: (4q,)
    int32.
    """
