# Bound by rust/python/src/features.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Points

#: (rows, columns) uint64, a number to every cell of 8 x 8 pixels: bit 8 y + x of it is the pixel at
#: x, y in the cell.
Picture = NDArray[np.uint64]

def read_ring(picture: Picture, x: Index, y: Index) -> int:
    """The eight neighbours as bits, counter-clockwise from the right (y up)."""

def dilate(picture: Picture) -> Picture:
    """Every pixel that is set, or touches one that is, by a side or a corner."""

def erode(picture: Picture, first: Picture) -> None:
    """Takes one layer off a picture, in place, but no pixel of ``first``, and no part or hole
    comes, goes or changes.

    The layer is what touches background at the beginning, by a side or a corner, just as
    dilation adds it. Pixels are looked at one by one, since two of a bridge may not go at once,
    and twice, since those at corners can go only after those at sides.
    """

def render_edges(
    points: Points, first: Int32Array, rows: int, columns: int
) -> tuple[Picture, Int32Array, Int32Array, Int32Array]:
    """The picture (rows, columns) of the edges from points first[i] to first[i] + 1, in pixels.

    All pixels that an edge passes through are set. For each cell the edges in it, in a list:
    head (rows * columns,) its first entry or -1; edge (n,) by number; link (n,) the next entry.
    """

def close_gaps(picture: Picture, rounds: int) -> Picture:
    """Return the picture after some dilations, then as many erosions."""

def find_outer_contour(picture: Picture, x: float, y: float) -> Int32Array:
    """(n, 2) the pixels of the outer contour nearest to a place, counter-clockwise.

    Source: feature curve recovery paper, section 4.3.2. Differs from the paper: it steps from
    cell to cell, to the next pixel that is set on the cell's border. That takes two parts in one
    cell for one, so the contour is followed through the cells, and cells only speed it up.
    """
