# Bound by rust/python/src/retopo.rs.
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats
from patterndb_sketch.retopo.draft.crossfield import Complexes

def solve_laplacian(
    across: Int32Array,
    weight: Floats,
    turned: Complexes,
    pull: Floats,
    right: Complexes,
    start: Complexes,
) -> Complexes:
    """Solve (weights + pull) u - sum of weight * turned * the neighbour's u = right, by conjugate
    gradients, from a start.

    weight, turned: (3t,) of every side; turned brings the neighbour's value into the triangle.
    Not by a factorisation: it would ask a BLAS with threads of its own for thousands of tiny
    blocks, and these take a hundred times as long while other work is on.
    """
