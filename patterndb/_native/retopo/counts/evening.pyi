# Bound by rust/python/src/retopo.rs.
from patterndb.core.halfedge import Int32Array

def tie_sides(
    first_side: Int32Array,
    first_chain: Int32Array,
    chains: Int32Array,
    pinned: Int32Array,
    least: Int32Array,
) -> Int32Array:
    """Label every chain (c,) by the smallest chain of its strip.

    first_side: (p + 1,) where the sides of each patch begin; first_chain: (s + 1,) where the chains
    of each side begin in ``chains``. Opposite sides of a patch of four are tied where each is a
    single chain; not where chains are pinned to different counts, or one to fewer edges than the
    other needs. pinned: (c,) the count of each chain that the user chose, or 0. least: (c,) the
    fewest edges of each.
    """
