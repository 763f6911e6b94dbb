# Bound by rust/python/src/core.rs.
from patterndb.core.halfedge import Int32Array
from patterndb.core.reduction import ReductionWork

def reduction_work(n_vertices: int, max_quads: int) -> ReductionWork:
    """Scratch for patches of at most ``max_quads`` quads of a mesh with ``n_vertices``."""

def dissolve(
    n_quads: int,
    twin: Int32Array,
    vertex: Int32Array,
    count: Int32Array,
    full: Int32Array,
    work: ReductionWork,
) -> tuple[int, int]:
    """Reduce the disk ``twin``; return (quads, starting half-edges) of the pattern.

    twin, vertex: (>= 4 * n_quads,) int32 half-edges of the disk and the mesh vertex of
    each corner. count: per mesh vertex, the disk's quads at it. full: the count at which
    the vertex is interior (its valence in the mesh; NEVER_FULL on the mesh's border).
    The pattern is left in ``work.reduced`` and ``work.starts``.
    """

def dissolve_straight(
    n_quads: int,
    twin: Int32Array,
    vertex: Int32Array,
    count: Int32Array,
    full: Int32Array,
    work: ReductionWork,
) -> tuple[int, int]:
    """Reduce a disk as :func:`dissolve` does, and dissolve chains that cross themselves, too.

    Expanding what is left gives the disk back: on both sides of a straight chain lie copies of one
    polychord, wherever it goes.
    """
