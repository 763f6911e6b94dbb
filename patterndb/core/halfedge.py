"""Connectivity as half-edges: the one representation under everything else.

Of quads half-edge ``h = 4 * quad + edge`` runs from the quad's corner ``edge`` to the next
one counter-clockwise. ``twin[h]`` is the half-edge on the other side, -1 on the
border. Corner ``h`` is the tail of half-edge ``h``. Faces of other arities have half-edges by their
tails and heads; :func:`sort_by_edge` brings those of an edge together.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Int32Array = NDArray[np.int32]
Int64Array = NDArray[np.int64]

#: A half-edge, or an array of them.
Index = Any


def next_edge(h: Index) -> Index:
    """The half-edge after h in its quad, counter-clockwise."""
    return (h & ~3) | ((h + 1) & 3)


def prev_edge(h: Index) -> Index:
    """The half-edge before h in its quad."""
    return (h & ~3) | ((h + 3) & 3)


def edge_keys(tail: NDArray[np.integer], head: NDArray[np.integer]) -> Int64Array:
    """Return (h,) a number for each half-edge, the same for all half-edges of an edge."""
    low, high = np.minimum(tail, head), np.maximum(tail, head)
    return (low.astype(np.int64) << 32) | high


def sort_by_edge(
    tail: NDArray[np.integer], head: NDArray[np.integer]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Sort half-edges by their edges.

    Returns (h,) numbers of half-edges, edge after edge, of an edge in ascending order, and (e + 1,)
    where the half-edges of every edge begin.
    """
    keys = edge_keys(tail, head)
    order = np.argsort(keys, kind="stable")
    ranked = keys[order]
    first = np.flatnonzero(np.r_[True, ranked[1:] != ranked[:-1]]) if len(keys) else order
    return order, np.r_[first, len(keys)]


def list_pairs(tail: NDArray[np.integer], head: NDArray[np.integer]) -> NDArray[np.intp]:
    """List (p, 2) the two half-edges of every edge that has exactly two."""
    order, start = sort_by_edge(tail, head)
    two = start[:-1][np.diff(start) == 2]
    return np.stack([order[two], order[two + 1]], axis=1)
