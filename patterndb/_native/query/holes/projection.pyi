# Bound by rust/python/src/query/holes.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Floats

def neighbours(
    corners: NDArray[np.int64], offsets: NDArray[np.int64], quads: NDArray[np.int64], n_points: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Neighbours of every vertex along edges, once for each face that the edge borders."""

def laplacian_rows(
    points: Floats, start: NDArray[np.int64], beside: NDArray[np.int64], n_outer: int, n_loop: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], Floats, Floats]:
    """Rows of inner vertices, then of loop vertices: (row, column, weight) and right-hand sides
    (r, 3).
    """

def measure_fill(
    points: Floats,
    quads: NDArray[np.int64],
    corners: NDArray[np.int64],
    offsets: NDArray[np.int64],
    normals: Floats,
    beyond: Floats,
    n_loop: int,
    n_outer: int,
    scale: float,
    area: float,
) -> tuple[Floats, int]:
    """Measure a placed fill; see MEASURES, of which "bending" is left 0. Also the flipped quads."""
