# Bound by rust/python/src/viewer.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points

def paint_shapes(
    pixels: NDArray[np.float32],
    points: Points,
    contours: NDArray[np.int64],
    shapes: NDArray[np.int64],
    colours: NDArray[np.float32],
) -> None:
    """Paint shapes over the pixels, in order.

    pixels: (h, w, 3). points: (m, 2). contours: where each contour's points begin, and their end.
    shapes: (n + 1,) where each shape's contours begin. colours: (n, 3).
    """
