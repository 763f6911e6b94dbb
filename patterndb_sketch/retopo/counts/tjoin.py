"""Find minimum-weight T-joins: the cheapest edges, an odd number at exactly the nodes of T.

Edmonds and Johnson, "Matching, Euler tours and the Chinese postman" (1973): the nodes of T are
paired along shortest paths by a minimum-weight perfect matching. Here all pairs are looked at, so
that the join is the cheapest there is.

The matching in a complete graph is exact, by blossoms: Edmonds, "Paths, trees, and flowers" (1965),
with dual variables and one forest of all single vertices at a time, as described by Galil,
"Efficient algorithms for finding maximum matching in graphs" (1986). A *node* is a vertex or a
blossom: an odd cycle of nodes, shrunk. The top nodes are those in no blossom. In the forest, even
nodes lie at even distance from a single one, odd nodes at odd distance; the others are out of it.

Edges are compared at vertices: every vertex keeps its tightest edge to an even vertex of another
top node. Edges within a blossom drop out by themselves when it forms, so that no edges between
nodes are stored.

Own, because of its speed in large networks: ``rustworkx.max_weight_matching`` 0.18 came to the same
joins in all of 784 problems of benchmarks/retopo_counts.py, in 30 ms for 10 where 106 patches of
200 are odd, but in 7.9 s for 0.5 where 512 of 1000 are (on a machine that others used too).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components, dijkstra

from patterndb._native.retopo.counts.tjoin import match
from patterndb.core.halfedge import Int32Array, Int64Array
from patterndb.geometry.points import Bools
from patterndb_sketch.retopo.errors import InvalidRetopoError

#: No path; small enough that matching takes it as a weight.
UNREACHED = 1 << 56

#: Weights are doubled, and so are sums of two: above this they might not fit in 63 bits.
MOST_WEIGHT = 1 << 58


@dataclass(frozen=True, slots=True, eq=False)
class Join:
    """A minimum-weight T-join.

    edges: (e,) bool, the edges in it.
    left:  nodes of T in components of the graph with an odd number of such nodes, one each:
           no join can serve all of them. The join is the best one for the others.
    """

    edges: Bools
    left: Int32Array


def find_cheapest_join(n_nodes: int, ends: Int32Array, costs: Int64Array, odd: Bools) -> Join:
    """Find the cheapest edges that change the parity of exactly the odd nodes.

    ends: (e, 2) int32 nodes of every edge, parallel edges and loops (which do nothing) allowed;
    costs: (e,) int64 >= 0, their sum below UNREACHED and that along a path below 2^53; odd:
    (n_nodes,) bool. Of several least joins it is always the same one.
    """
    component = label_components(n_nodes, ends)
    wanted = np.flatnonzero(odd)
    alone = np.bincount(component[wanted], minlength=n_nodes)[component[wanted]] % 2 == 1
    # The last node of T in a component that has an odd number of them.
    _, first = np.unique(component[wanted][::-1], return_index=True)
    last = np.zeros(len(wanted), np.bool_)
    last[len(wanted) - 1 - first] = True
    left = wanted[alone & last].astype(np.int32)
    wanted = wanted[~(alone & last)]
    chosen = np.zeros(len(ends), np.bool_)
    if not len(wanted):
        return Join(chosen, left)
    # Of parallel edges the cheapest, and the first of these.
    low, high = ends.min(axis=1).astype(np.int64), ends.max(axis=1)
    name = low * n_nodes + high
    order = np.lexsort((costs, name))
    edges = order[np.r_[True, np.diff(name[order]) != 0] & (low != high)[order]]
    # 32 bits: before SciPy 1.15 its shortest paths take no others.
    places = low[edges].astype(np.int32), high[edges].astype(np.int32)
    graph = csr_array((costs[edges].astype(np.float64), places), (n_nodes, n_nodes))
    lengths, before = dijkstra(graph, directed=False, indices=wanted, return_predecessors=True)
    weights = np.where(np.isfinite(lengths), lengths, UNREACHED).astype(np.int64)
    edge_of = dict(zip(name[edges].tolist(), edges.tolist(), strict=True))
    for i, j in enumerate(pair_cheaply(weights[:, wanted])):
        if i < j:
            node = int(wanted[j])
            while node != wanted[i]:
                previous = int(before[i, node])
                edge = edge_of[min(node, previous) * n_nodes + max(node, previous)]
                # Two paths that share an edge need it neither way.
                chosen[edge] = not chosen[edge]
                node = previous
    return Join(chosen, left)


def label_components(n_nodes: int, ends: Int32Array) -> Int32Array:
    """(n_nodes,) of every node the smallest node that edges (e, 2) join it to."""
    edges = coo_array((np.ones(len(ends), np.bool_), (ends[:, 0], ends[:, 1])), (n_nodes, n_nodes))
    count, group = connected_components(edges, directed=False)
    smallest = np.full(count, n_nodes, np.int32)
    np.minimum.at(smallest, group, np.arange(n_nodes, dtype=np.int32))
    return smallest[group]


def pair_cheaply(weights: Int64Array) -> Int32Array:
    """Pair vertices such that the sum of weights is least: (n,) int32, of every vertex its partner.

    weights: (n, n) int64, symmetric, >= 0 and at most MOST_WEIGHT; the diagonal counts for
    nothing. Of several least matchings it is always the same one. Raises InvalidRetopoError for
    an odd n and for other weights.
    """
    n = len(weights)
    if n % 2:
        raise InvalidRetopoError(f"{n} vertices cannot be paired; their number must be even")
    if n == 0:
        return np.empty(0, np.int32)
    if weights.min() < 0 or weights.max() > MOST_WEIGHT:
        raise InvalidRetopoError("a weight is below 0 or above MOST_WEIGHT; scale the weights")
    return match(np.ascontiguousarray(weights, np.int64))


#: Where a node is in the forest.
OUT, EVEN, ODD = 0, 1, 2
