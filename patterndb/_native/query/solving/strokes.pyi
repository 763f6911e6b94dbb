# Bound by rust/python/src/query/solving/strokes.rs.
from patterndb.core.halfedge import Int32Array

def can_carry(
    edges: Int32Array, side_start: Int32Array, lengths: Int32Array, flow: Int32Array, tolerance: int
) -> bool:
    """Are there widths under which strands lie on all the strokes?

    Arguments as in :func:`find_carrying_widths`.
    """

def find_carrying_widths(
    edges: Int32Array,
    side_start: Int32Array,
    lengths: Int32Array,
    flow: Int32Array,
    tolerance: int,
    keep: int,
) -> Int32Array:
    """(k, n) int32, the ``keep`` best widths under which strands lie on all the strokes.

    edges: (2 n,) strand that crosses each edge; side_start: (N + 1,) where sides begin there;
    lengths: (N,) edges asked for; flow: (s, 4) of :func:`orient_strokes`, none for no strokes.
    All there are, if fewer than ``keep``; best first.
    """
