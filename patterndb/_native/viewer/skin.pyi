# Bound by rust/python/src/viewer.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats, Points

Grid = NDArray[np.float32]

def blended(
    triangles: Int32Array,
    offsets: NDArray[np.int64],
    around: Int32Array,
    unit: Points,
    area: Floats,
    smooth: float,
    creased: float,
) -> Points:
    """See :func:`smooth_normals`; around: triangles of vertex v from offsets[v] on."""

def seen(
    corners: Points,
    normals: Points,
    axes: Points,
    focus: Points,
    scale: float,
    key: Points,
    fill: Points,
    lights: tuple[float, float, float, float],
) -> tuple[Points, Grid]:
    """Corners as they are seen, and how bright (t, 3) each is: a normal that points away from
    the side that is seen counts as if it were turned.
    """
