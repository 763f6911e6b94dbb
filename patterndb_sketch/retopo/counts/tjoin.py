"""Minimum-weight T-join: the cheapest set of edges with an odd number at exactly the nodes of T.

Edmonds and Johnson, "Matching, Euler tours and the Chinese postman" (1973): the nodes of T are
paired along shortest paths by a minimum-weight perfect matching. Here all pairs are looked at, so
that the join is the cheapest there is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from patterndb.core.halfedge import Int32Array, Int64Array
from patterndb.geometry.points import Bools
from patterndb.system.kernels import kernel
from patterndb_sketch.retopo.counts.matching import min_weight_perfect_matching

#: No path; small enough that matching takes it as a weight.
UNREACHED = 1 << 56


@dataclass(frozen=True, slots=True, eq=False)
class Join:
    """A minimum-weight T-join.

    edges: (e,) bool, the edges in it.
    left:  nodes of T in components of the graph with an odd number of such nodes, one each:
           no join can serve all of them. The join is the best one for the others.
    """

    edges: Bools
    left: Int32Array


def min_weight_join(n_nodes: int, ends: Int32Array, costs: Int64Array, odd: Bools) -> Join:
    """The cheapest edges that change the parity of exactly the odd nodes.

    ends: (e, 2) int32 nodes of every edge, parallel edges and loops (which do nothing) allowed;
    costs: (e,) int64 >= 0, their sum below UNREACHED; odd: (n_nodes,) bool. Of several least
    joins it is always the same one.
    """
    component = components(n_nodes, ends)
    wanted = np.flatnonzero(odd)
    alone = np.bincount(component[wanted], minlength=n_nodes)[component[wanted]] % 2 == 1
    # The last node of T in a component that has an odd number of them.
    _, first = np.unique(component[wanted][::-1], return_index=True)
    last = np.zeros(len(wanted), np.bool_)
    last[len(wanted) - 1 - first] = True
    left = wanted[alone & last].astype(np.int32)
    wanted = wanted[~(alone & last)].astype(np.int32)
    first_arc, far, edge = _arcs(n_nodes, ends)
    lengths, by = _shortest(first_arc, far, edge, costs, wanted)
    mate = min_weight_perfect_matching(lengths[:, wanted])
    chosen = np.zeros(len(ends), np.bool_)
    for i, j in enumerate(mate):
        if i < j:
            node = int(wanted[j])
            while node != wanted[i]:
                at = int(by[i, node])
                # Two paths that share an edge need it neither way.
                chosen[at] = not chosen[at]
                node = int(ends[at, 0] + ends[at, 1] - node)
    return Join(chosen, left)


@kernel
def components(n_nodes: int, ends: Int32Array) -> Int32Array:
    """Of every node the smallest node that edges join it to."""
    root = np.arange(n_nodes).astype(np.int32)
    for k in range(len(ends)):
        a = ends[k, 0]
        b = ends[k, 1]
        while root[a] != a:
            root[a] = root[root[a]]
            a = root[a]
        while root[b] != b:
            root[b] = root[root[b]]
            b = root[b]
        root[max(a, b)] = min(a, b)
    for v in range(n_nodes):
        # Roots are smaller than what hangs on them, and done before.
        root[v] = root[root[v]]
    return root


@kernel
def _arcs(n_nodes: int, ends: Int32Array) -> tuple[Int32Array, Int32Array, Int32Array]:
    """For every node its far ends and edges, from first[node] on; loops are left out."""
    first = np.zeros(n_nodes + 1, np.int32)
    for k in range(len(ends)):
        if ends[k, 0] != ends[k, 1]:
            first[ends[k, 0] + 1] += 1
            first[ends[k, 1] + 1] += 1
    for v in range(n_nodes):
        first[v + 1] += first[v]
    free = first[:-1].copy()
    far = np.empty(first[-1], np.int32)
    edge = np.empty(first[-1], np.int32)
    for k in range(len(ends)):
        if ends[k, 0] != ends[k, 1]:
            for side in range(2):
                at = free[ends[k, side]]
                free[ends[k, side]] += 1
                far[at] = ends[k, 1 - side]
                edge[at] = k
    return first, far, edge


@kernel
def _shortest(
    first: Int32Array, far: Int32Array, edge: Int32Array, costs: Int64Array, sources: Int32Array
) -> tuple[Int64Array, Int32Array]:
    """(s, n) lengths from every source to every node, and the last edge of each path.

    Dijkstra's algorithm with a binary heap of nodes in which each knows its place.
    """
    n = len(first) - 1
    length = np.full((len(sources), n), UNREACHED, np.int64)
    by = np.full((len(sources), n), -1, np.int32)
    heap = np.empty(n, np.int32)
    place = np.empty(n, np.int32)
    for s in range(len(sources)):
        place[:] = -1
        length[s, sources[s]] = 0
        heap[0] = sources[s]
        place[sources[s]] = 0
        size = 1
        while size:
            v = heap[0]
            size -= 1
            if size:
                place[heap[size]] = 0
                heap[0] = heap[size]
                _sink(heap, place, length[s], size)
            for a in range(first[v], first[v + 1]):
                u = far[a]
                reached = length[s, v] + costs[edge[a]]
                if reached < length[s, u]:
                    length[s, u] = reached
                    by[s, u] = edge[a]
                    if place[u] < 0:
                        place[u] = size
                        heap[size] = u
                        size += 1
                    _rise(heap, place, length[s], int(place[u]))
    return length, by


@kernel
def _rise(heap: Int32Array, place: Int32Array, key: Int64Array, at: int) -> None:
    v = heap[at]
    while at > 0 and key[heap[(at - 1) // 2]] > key[v]:
        heap[at] = heap[(at - 1) // 2]
        place[heap[at]] = at
        at = (at - 1) // 2
    heap[at] = v
    place[v] = at


@kernel
def _sink(heap: Int32Array, place: Int32Array, key: Int64Array, size: int) -> None:
    at = 0
    v = heap[0]
    while 2 * at + 1 < size:
        child = 2 * at + 1
        if child + 1 < size and key[heap[child + 1]] < key[heap[child]]:
            child += 1
        if key[heap[child]] >= key[v]:
            break
        heap[at] = heap[child]
        place[heap[at]] = at
        at = child
    heap[at] = v
    place[v] = at
