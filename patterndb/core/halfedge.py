"""Quad connectivity as half-edges: the one representation under everything else.

Half-edge ``h = 4 * quad + edge`` runs from the quad's corner ``edge`` to the next
one counter-clockwise. ``twin[h]`` is the half-edge on the other side, -1 on the
border. Corner ``h`` is the tail of half-edge ``h``.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from patterndb.system.kernels import kernel

Int32Array = NDArray[np.int32]
Int64Array = NDArray[np.int64]

#: What kernels take where they count or index: inside them an array's element is as good.
Index = Any


def next_edge(h: Index) -> Index:
    """The half-edge after h in its quad, counter-clockwise."""
    return (h & ~3) | ((h + 1) & 3)


def prev_edge(h: Index) -> Index:
    """The half-edge before h in its quad."""
    return (h & ~3) | ((h + 3) & 3)


@kernel
def fans(twin: Int32Array) -> tuple[Int32Array, int]:
    """Vertex of every corner, one per fan of edge-connected quads.

    twin: (4q,) int32. Returns (4q,) int32 vertex ids in order of first appearance and
    their number. Two fans that touch at one point of the file get two vertices.
    """
    n = len(twin)
    vertex = np.full(n, -1, np.int32)
    count = 0
    for h0 in range(n):
        if vertex[h0] >= 0:
            continue
        # Turn clockwise to the fan's first corner, or once round a closed fan.
        h = h0
        while True:
            t = twin[h]
            if t < 0:
                break
            h = next_edge(t)
            if h == h0:
                break
        first = h
        while True:
            vertex[h] = count
            h = twin[prev_edge(h)]
            if h < 0 or h == first:
                break
        count += 1
    return vertex, count


@kernel
def border_vertices(twin: Int32Array, vertex: Int32Array, n_vertices: int) -> NDArray[np.bool_]:
    """(n_vertices,) bool: does the vertex lie on a border edge?"""
    border = np.zeros(n_vertices, np.bool_)
    for h in range(len(twin)):
        if twin[h] < 0:
            border[vertex[h]] = True
            border[vertex[next_edge(h)]] = True
    return border


@kernel
def next_border_edge(twin: Int32Array, h: Index) -> Index:
    """The border half-edge that follows border half-edge h along the border."""
    h = next_edge(h)
    while twin[h] >= 0:
        h = next_edge(twin[h])
    return h
