# Bound by rust/python/src/query/marks/bestmarked.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
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
    lengths: Int32Array,
    asked: Int32Array,
    cap: int,
    most: int,
    base: Int32Array,
    start: NDArray[np.int64],
    unmarked: Int32Array,
    signature: Int32Array,
    counts: NDArray[np.uint8],
    convex: Int32Array,
    reflex: Int32Array,
    class_start: NDArray[np.int64],
    class_i: Int32Array,
    class_j: Int32Array,
    component: Int16Array,
    colour: Int16Array,
) -> tuple[int, int, int, int, Int32Array]:
    """Of :func:`query.marks.bestmarked.find_best_marked`: the first row that fits.

    lengths: (N,) edges of each side; asked: (N,) quads at each corner; most: -1 for any. The
    others are of :class:`query.marks.bestmarked.MarkedIndex`. Returns (row of the index, or -1;
    orientation of its signature, N and more being mirrored; irregular vertices; those on the
    boundary; (m,) slack of every class).
    """

def spread_strand_widths(
    label: NDArray[np.int16],
    rotation: int,
    reflected: bool,
    class_i: Int32Array,
    class_j: Int32Array,
    class_n: Int32Array,
    slack: Int32Array,
    n_sides: int,
) -> Int32Array:
    """(n,) int32 width of every strand of a row, each class's slack spread evenly.

    label, rotation, reflected: of the row, see :class:`query.marks.marked.MarkedClass`; slack:
    (m,) of the classes of its signature.
    """
