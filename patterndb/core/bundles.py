"""Bundles: polychords of a disk that run side by side, with nothing irregular between them.

An expanded pattern has a bundle where the pattern has one polychord, so that bundles tell which
pattern a fill came from.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.core.disk import Disk
from patterndb.core.halfedge import Int32Array, next_edge
from patterndb.core.polychord import polychords
from patterndb.core.quadmesh import QuadMesh


def find_bundles(disk: Disk) -> Int32Array:
    """Find bundles of parallel polychords, as (q, 2) int32 through edges 0-2 and edges 1-3.

    Two polychords are parallel if between them runs a regular chain: closed or from one
    flat boundary vertex to another, through interior vertices of valence 4 only. Bundles
    are numbered by the first boundary edge they meet, those of loops after them, so that a
    reduced pattern and its expansions number them alike (and as Pattern.label does).
    """
    twin = QuadMesh.from_quads(disk.quads).twin
    of_edge = polychords(twin).of_edge
    root: NDArray[np.int64] = np.arange(int(of_edge.max()) + 1)
    for chain in _regular_chains(disk, twin):
        for h in chain:
            one = _find(root, int(of_edge[next_edge(h)]))
            other = _find(root, int(of_edge[next_edge(int(twin[h]))]))
            root[max(one, other)] = min(one, other)
    tail = disk.quads.ravel()
    border = np.flatnonzero(twin < 0)
    border = border[np.argsort(tail[border])]
    number: dict[int, int] = {}
    for c in (*of_edge[border].tolist(), *range(len(root))):
        number.setdefault(_find(root, c), len(number))
    name = np.array([number[_find(root, c)] for c in range(len(root))], np.int32)
    return name[of_edge].reshape(-1, 4)[:, :2]


def find_boundary_bundles(disk: Disk, bundle: Int32Array) -> Int32Array:
    """Find (P,) int32 bundle that meets every boundary edge, edge j leaving vertex j."""
    tail = disk.quads
    head = np.roll(tail, -1, axis=1)
    quad, edge = np.nonzero((tail < disk.perimeter) & (head == (tail + 1) % disk.perimeter))
    met = np.empty(disk.perimeter, np.int32)
    met[tail[quad, edge]] = bundle[quad, edge & 1]
    return met


def _regular_chains(disk: Disk, twin: Int32Array) -> list[list[int]]:
    """Half-edges of every regular chain; a chain may be found once from each end."""
    valence = disk.valence()
    tail = disk.quads.ravel()
    p = disk.perimeter

    def walk(h: int) -> list[int] | None:
        chain = [h]
        while True:
            head = int(tail[next_edge(chain[-1])])
            if head < p:
                return chain if valence[head] == 2 else None
            if valence[head] != 4:
                return None
            # Two quads on round the vertex is straight ahead.
            ahead = next_edge(int(twin[next_edge(chain[-1])]))
            if ahead == h:
                return chain
            if len(chain) > len(twin):
                return None
            chain.append(ahead)

    chains: list[list[int]] = []
    seen = np.zeros(len(twin), np.bool_)
    for from_boundary in (True, False):
        for h in np.flatnonzero(twin >= 0).tolist():
            v = int(tail[h])
            start = valence[v] == 2 if v < p else valence[v] == 4
            if (v < p) != from_boundary or not start or seen[h]:
                continue
            chain = walk(h)
            if chain is None or (not from_boundary and int(tail[next_edge(chain[-1])]) != v):
                continue
            seen[chain] = True
            chains.append(chain)
    return chains


def _find(root: NDArray[np.int64], c: int) -> int:
    while root[c] != c:
        c = int(root[c])
    return c
