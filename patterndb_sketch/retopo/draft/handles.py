"""Find the shortest loop around a handle of a surface, or through one: laces and thin bridges.

A tree of shortest paths from a root, and a tree of the triangles over the edges that it leaves,
leave two edges for each handle; each closes a loop that parts nothing. After Erickson and
Whittlesey 2005, "Greedy optimal homotopy and homology generators", with edges that reach furthest
from the root taken into the second tree first. From other roots loops are shorter: the ends of the
shortest ones so far are tried.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, dijkstra, minimum_spanning_tree

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points
from patterndb_sketch.retopo.draft.frames import TangentFrames

#: Loops whose ends are tried as roots.
TRIED = 4


@dataclass(frozen=True, slots=True, eq=False)
class HandleLoop:
    """length: of a loop along edges, about the shortest around its handle. middle: (3,) of it."""

    length: float
    middle: Points


def find_shortest_handle(mesh: TangentFrames) -> HandleLoop | None:
    """The shortest loop along edges that parts nothing; None where every loop does.

    Loops around borders part what is beyond them: a sheet with holes has no handle.
    """
    parts, part = connected_components(mesh.edge_graph, directed=False)
    used = np.unique(mesh.triangles)
    best: HandleLoop | None = None
    for number in range(parts):
        own = used[part[used] == number]
        if not len(own):
            continue
        found = sorted(_list_loops(mesh, int(own[0])), key=lambda loop: loop[0])
        for _, start, _ in found[:TRIED]:
            found += _list_loops(mesh, start)
        for length, _, loop in found:
            if best is None or length < best.length:
                best = HandleLoop(length, mesh.vertices[loop].mean(axis=0))
    return best


def _list_loops(mesh: TangentFrames, root: int) -> list[tuple[float, int, list[int]]]:
    """Two loops for each handle of the root's part: length, a vertex on it, and all of them."""
    far, before = dijkstra(mesh.edge_graph, indices=root, return_predecessors=True)
    ends = mesh.surface.adjacency.ends
    one, two = ends[:, 0], ends[:, 1]
    tree = (before[one] == two) | (before[two] == one)
    open_ = np.flatnonzero(~tree & np.isfinite(far[one]))
    size = np.linalg.norm(mesh.vertices[one[open_]] - mesh.vertices[two[open_]], axis=1)
    reach = far[one[open_]] + far[two[open_]] + size
    order = open_[np.argsort(-reach, kind="stable")]
    found: list[tuple[float, int, list[int]]] = []
    for edge in order[~_span_tree(_find_beside(mesh)[order])].tolist():
        loop = _close_loop(before, int(one[edge]), int(two[edge]))
        steps = mesh.vertices[loop] - mesh.vertices[np.roll(loop, -1)]
        found.append((float(np.linalg.norm(steps, axis=1).sum()), loop[0], loop))
    return found


def _span_tree(pairs: Int32Array) -> NDArray[np.bool_]:
    """(n,) which of pairs of numbers (n, 2), the first first, are a tree that spans all: each that
    joins what those before it do not (Kruskal 1956)."""
    low, high = pairs.min(axis=1), pairs.max(axis=1)
    rank = np.arange(1, len(pairs) + 1)
    # Of pairs that are given twice the second closes a ring of two.
    _, first = np.unique((low.astype(np.int64) << 32) | high, return_index=True)
    first = first[low[first] != high[first]]
    size = int(high.max(initial=-1)) + 1
    graph = coo_array((rank[first].astype(np.float64), (low[first], high[first])), (size, size))
    found = np.zeros(len(pairs), np.bool_)
    found[np.rint(minimum_spanning_tree(graph.tocsr()).data).astype(np.int64) - 1] = True
    return found


def _find_beside(mesh: TangentFrames) -> Int32Array:
    """(e, 2) the two triangles of every edge; beyond a border its loop, numbered after them."""
    adjacency, triangles = mesh.surface.adjacency, mesh.triangles
    n = len(triangles)
    border = adjacency.border
    tails = triangles.ravel()[border]
    heads = triangles[border // 3, (border % 3 + 1) % 3]
    after = {int(tail): k for k, tail in enumerate(tails.tolist())}
    ring = np.full(len(border), -1, np.int32)
    rings = 0
    for first in range(len(border)):
        k = first
        if ring[k] >= 0:
            continue
        while ring[k] < 0:
            ring[k] = rings
            k = after[int(heads[k])]
        rings += 1
    found = np.empty((len(adjacency.ends), 2), np.int32)
    start = adjacency.side_start[:-1]
    found[:, 0] = adjacency.sides[start] // 3
    found[:, 1] = adjacency.sides[adjacency.side_start[1:] - 1] // 3
    found[adjacency.edges[border], 1] = n + ring
    return found


def _close_loop(before: Int32Array, one: int, two: int) -> list[int]:
    """The vertices of two paths to a root and the edge between their ends, without what both
    have."""
    paths: list[list[int]] = []
    for vertex in (one, two):
        path = [vertex]
        while before[path[-1]] >= 0:
            path.append(int(before[path[-1]]))
        paths.append(path)
    here, there = paths
    while len(here) > 1 and len(there) > 1 and here[-2] == there[-2]:
        here.pop()
        there.pop()
    return [*here, *reversed(there[:-1])]
