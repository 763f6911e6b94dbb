# Bound by rust/python/src/surfacing.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int64Array

def solve_heights(
    at: Int64Array, tail: Int64Array, twin: Int64Array, boundary: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(v,) heights above the plane that solve Laplace's equation on a planar mesh.

    at: (v, 2); tail, twin: half-edges of its constrained Delaunay triangulation; boundary:
    (m,) heights of the first m vertices, which are kept. By conjugate gradients.

    The weights are the cotangents of the angles in the plane. On a constrained Delaunay
    triangulation none is negative, so that every height is a mean of its neighbours' heights:
    none is above the highest or below the lowest of the boundary. With them, a vertex in its
    place in the plane is at rest too; therefore only the heights are solved for, the surface
    is a graph over the plane, and no piece crosses itself. (Uniform weights would pull vertices
    across the boundary at concave corners.)

    Source: Pinkall and Polthier 1993, "Computing discrete minimal surfaces and their
    conjugates": the membrane's energy on the planar mesh, which for small heights is the area.
    """

def measure_stretch(
    at: Int64Array, tail: Int64Array, heights: NDArray[np.float64], step: float
) -> float:
    """How many times as large as in the plane a mesh is at these heights: the root of areas."""
