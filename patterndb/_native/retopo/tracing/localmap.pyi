# Bound by rust/python/src/retopo.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Points

def propose(
    vertices: Points, normals: Points, axes: Points, p: Index, q: Index, out: NDArray[np.float64]
) -> bool:
    """What p hands on to q: out (5,) becomes the step in (u, v) and the u axis at q.

    False if it has nothing to say: q is straight above p, or they face opposite ways.
    """

def spread_front(
    vertices: Points,
    normals: Points,
    star_start: Int32Array,
    star: Int32Array,
    seeds: Int32Array,
    seed_uv: Points,
    seed_axes: Points,
    seed_distance: NDArray[np.float64],
    distance: float,
    low: NDArray[np.float64],
    high: NDArray[np.float64],
) -> tuple[Int32Array, Points, NDArray[np.float64]]:
    """(m,) vertices in order of their distance, their (u, v) (m, 2) and distances (m,).

    seeds (s,) distinct vertices with their (u, v), u axes (s, 3) and distances; beyond the
    distance, or the box from low (2,) to high (2,), nothing is handed on.
    """

def find_mapped(
    triangles: Int32Array, vertices: Points, found: Int32Array, uv: Points, torn: float
) -> tuple[Int32Array, Int32Array]:
    """(k,) the triangles all of whose corners were found (m,), ascending; (k, 3) those corners
    as places in ``found``.

    Left out is a triangle with an edge more than ``torn`` times as long in (u, v) (m, 2) as it is.
    """

def file_triangles(uv: Points, corners: Int32Array) -> tuple[Points, Int32Array, Int32Array]:
    """A grid over the triangles (k, 3) of points uv (m, 2): its frame (3, 2), which is low
    corner, cell size and numbers of cells; and the triangles by cell: start, numbers.
    """

def find_containing(
    uv: Points,
    corners: Int32Array,
    distance: NDArray[np.float64],
    frame: Points,
    start: Int32Array,
    numbers: Int32Array,
    wanted: Points,
) -> tuple[Int32Array, Points]:
    """(n,) the triangle that contains each (u, v) wanted (n, 2), -1 without; (n, 3) weights.

    Of several the one of the least distance (m,), interpolated there.
    """
