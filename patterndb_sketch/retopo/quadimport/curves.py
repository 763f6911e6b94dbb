"""The curves between patches, as sequences of edges from corner to corner."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array, next_edge, prev_edge
from patterndb.system.kernels import kernel
from patterndb_sketch.retopo.network import HalfChain
from patterndb_sketch.retopo.quadimport.connectivity import Quads


@dataclass(frozen=True, slots=True, eq=False)
class Curves:
    """Of c curves; half-curve 2 k runs along curve k, 2 k + 1 back.

    edges: (m,) int32 half-edges, those of curve k from start[k] to start[k + 1], in order.
    start: (c + 1,) int32.
    half:  (4q,) int32 the half-curve that a half-edge is on, -1 for none.
    """

    edges: Int32Array
    start: Int32Array
    half: Int32Array

    def __len__(self) -> int:
        return len(self.start) - 1

    def of(self, curve: int) -> Int32Array:
        """(k,) half-edges along a curve."""
        return self.edges[self.start[curve] : self.start[curve + 1]]

    def count(self, half: HalfChain) -> int:
        """Edges along a half-curve."""
        return int(self.start[(half >> 1) + 1] - self.start[half >> 1])

    def first(self, mesh: Quads, half: HalfChain) -> int:
        """The half-edge that a half-curve begins with."""
        along = self.of(half >> 1)
        return int(mesh.twin[along[-1]]) if half & 1 else int(along[0])


def curves(mesh: Quads, marked: NDArray[np.bool_], corner: NDArray[np.bool_]) -> Curves:
    """Follow marked edges from corner to corner."""
    return Curves(*_followed(mesh.twin, mesh.tail, marked, corner))


def around_corners(mesh: Quads, corner: NDArray[np.bool_], found: Curves) -> dict[int, list[int]]:
    """The half-curves that leave every corner, by vertex, counter-clockwise.

    At a border the first has the mesh on its left, and the last on its right.
    """
    twin, tail = mesh.twin, mesh.tail
    leaving = np.full(len(mesh.points), -1, np.int64)
    every = np.arange(len(tail))
    leaving[tail[::-1]] = every[::-1]
    rim = every[twin < 0]
    leaving[tail[rim]] = rim
    result: dict[int, list[int]] = {}
    for vertex in np.flatnonzero(corner).tolist():
        first = h = int(leaving[vertex])
        ends: list[int] = []
        while True:
            ends.append(int(found.half[h]))
            back = int(prev_edge(h))
            h = int(twin[back])
            if h < 0:
                ends.append(int(found.half[back]) ^ 1)
            if h < 0 or h == first:
                break
        result[vertex] = ends
    return result


@kernel
def _followed(
    twin: Int32Array, tail: Int32Array, marked: NDArray[np.bool_], corner: NDArray[np.bool_]
) -> tuple[Int32Array, Int32Array, Int32Array]:
    half = np.full(len(twin), -1, np.int32)
    edges = np.empty(len(twin), np.int32)
    start = np.zeros(len(twin) + 1, np.int32)
    n, count = 0, 0
    for first in range(len(twin)):
        if not (marked[first] and corner[tail[first]]) or half[first] >= 0:
            continue
        h = first
        while True:
            edges[n] = h
            n += 1
            half[h] = 2 * count
            if twin[h] >= 0:
                half[twin[h]] = 2 * count + 1
            ahead = next_edge(h)
            if corner[tail[ahead]]:
                break
            h = next_edge(twin[ahead])
        count += 1
        start[count] = n
    return edges[:n].copy(), start[: count + 1].copy(), half
