# Bound by rust/python/src/query/holes.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats

def count_faces(twin: Int32Array, following: Int32Array, h: int) -> int:
    """Faces around the tail of a half-edge, 4 where the border is met."""

def measure_fans(
    points: Floats, corners: Int32Array, offsets: NDArray[np.int64], n_loop: int
) -> tuple[Floats, Floats]:
    """(L, 3) unit normals of the faces outside at each loop vertex, weighted by angle, 0 where
    there are none; (L,) radians that they take.
    """

def find_normals_beyond(
    points: Floats, corners: Int32Array, offsets: NDArray[np.int64], n_loop: int
) -> Floats:
    """(L, 3) unit normals of the faces across the loop's edges, 0 where there is none."""
