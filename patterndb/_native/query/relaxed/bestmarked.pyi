# Bound by rust/python/src/query/relaxed.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from query.relaxed.bestmarked import MarkedIndex
from query.solving.systems import Int16Array

def colours(
    class_start: NDArray[np.int64], class_i: Int32Array, class_j: Int32Array, n_sides: int
) -> tuple[Int16Array, Int16Array]:
    """Return the component and the colour of each side, (s, n_sides) int16 each, for every
    signature.

    The classes of signature s join the sides class_i[k], class_j[k] for k from class_start[s] to
    class_start[s + 1]. A component with an odd cycle has no colours.
    """

def find_best_row(
    index: MarkedIndex, lengths: Int32Array, asked: Int32Array, cap: int, most: int | None
) -> tuple[int, int, int, int, Int32Array]:
    """Of :func:`query.relaxed.bestmarked.find_best_marked`: the first row that fits.

    lengths: (N,) edges of each side; asked: (N,) quads at each corner. Returns (row of the index,
    or -1; orientation of its signature, N and more being mirrored; irregular vertices; those on
    the boundary; (m,) slack of every class).
    """

def spread_strand_widths(
    row: tuple[NDArray[np.int16], int, bool, int],
    classes: tuple[Int32Array, Int32Array, Int32Array],
    slack: Int32Array,
) -> Int32Array:
    """(n,) int32 width of every strand of a row, each class's slack spread evenly.

    row: its label as a word, rotation, reflected and number of sides, see
    :class:`query.relaxed.corner_placement.MarkedClass`. classes: of its signature, the two sides of
    each and its number of strands; slack: (m,) of them.
    """
