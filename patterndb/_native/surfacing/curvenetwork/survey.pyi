# Bound by rust/python/src/surfacing.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats, Points

def select_seam_joins(
    points: Points,
    starts: Int64Array,
    along: Floats,
    closed: NDArray[np.bool_],
    curves: Int64Array,
    lengths: Floats,
    gaps: Floats,
    ways: Floats,
    beside: NDArray[np.bool_],
    some: Int64Array,
    by_pair: Int64Array,
    begin: Int64Array,
    end: Int64Array,
    reaches: Floats,
) -> NDArray[np.bool_]:
    """(m,) which joins are not part of the meeting of a nearer one beyond a closed curve's seam.

    curves, lengths, gaps: of the joins. ways: (m, 2) how far their places are from the seam.
    beside: (m, 2) which places may be parted from others by it; some: (k,) the joins with such a
    place. by_pair[begin[i]:end[i]]: the joins of the same two curves as join some[i].
    """
