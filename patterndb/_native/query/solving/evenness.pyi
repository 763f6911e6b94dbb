# Bound by rust/python/src/query/solving/evenness.rs.
from patterndb.core.halfedge import Int32Array

def even_cost(parts: int, value: int) -> int:
    """The least sum of (1 + s)**2 over ``parts`` integers s >= 0 that add up to ``value``."""

def list_splits(values: Int32Array, class_n: Int32Array, class_of: Int32Array) -> Int32Array:
    """All widths that split the slack of classes among their polychords, (k, n) int32.

    values: (r, m) rows of the slack of each class; those of one row are in lexicographic order.
    """
