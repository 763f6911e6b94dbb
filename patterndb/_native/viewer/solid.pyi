# Bound by rust/python/src/viewer.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points

Grid = NDArray[np.float32]

def fill_triangles(corners: Points, colours: Grid, depth: Grid, image: Grid) -> None:
    """Paint triangles over what is there, in place; the nearer wins.

    corners: (t, 3, 3) float64 x to the right, y down, both in pixels, and depth, greater is
    nearer. colours: (t, 3, 3) float32 of the corners, blended between. depth: (h, w) float32,
    -inf where nothing is yet. image: (h, w, 3) float32. The pixel (i, j) is seen at its middle,
    x = j + 0.5, y = i + 0.5.
    """
