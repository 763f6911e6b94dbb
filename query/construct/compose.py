"""Compose: fills of parts become one mesh. Two fills across a chord are one fill.

Boundary and chord vertices get their numbers first. Then a part only has to be mapped onto
them, however it is turned, and parts join wherever they name the same vertices.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from patterndb.core.halfedge import Int32Array
from patterndb.system.kernels import kernel


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """A part of a mesh and the fill that lies in it.

    loop:  (n,) int32, the mesh's vertices along the part's boundary, counter-clockwise.
    quads: (q, 4) int32, counter-clockwise. Vertex i < n is loop[i]; interior ones follow.
    """

    loop: Int32Array
    quads: Int32Array


@kernel
def split(
    loop: Int32Array, start: int, end: int, inner: Int32Array
) -> tuple[Int32Array, Int32Array]:
    """The two loops into which a chord cuts a loop.

    The chord runs from position ``start`` of the loop over the vertices ``inner`` to
    position ``end``. The left loop begins at ``start``, follows the old loop to ``end`` and
    comes back along the chord; the right one begins at ``end``, follows the old loop to
    ``start`` and comes back. Positions may lie beyond the loop's length: they count on.
    """
    n = len(loop)
    there = (end - start) % n
    back = n - there
    left = np.empty(there + 1 + len(inner), np.int32)
    right = np.empty(back + 1 + len(inner), np.int32)
    for i in range(there + 1):
        left[i] = loop[(start + i) % n]
    for i in range(back + 1):
        right[i] = loop[(end + i) % n]
    for i in range(len(inner)):
        left[there + 1 + i] = inner[len(inner) - 1 - i]
        right[back + 1 + i] = inner[i]
    return left, right


def compose(parts: Iterable[Part], n_outline: int) -> tuple[Int32Array, int]:
    """((q, 4) int32 quads, number of vertices) of all the parts as one mesh.

    n_outline: boundary and chord vertices; the loops name 0..n_outline - 1. The parts'
    interior vertices get the numbers that follow. Whether the result is a mesh,
    :func:`query.weld.weld` tells: two parts that are each can still join two vertices by
    two edges.
    """
    pieces: list[Int32Array] = []
    fresh = n_outline
    for part in parts:
        n = len(part.loop)
        inner = int(part.quads.max()) + 1 - n
        name = np.concatenate([part.loop, np.arange(fresh, fresh + inner, dtype=np.int32)])
        pieces.append(name[part.quads])
        fresh += inner
    return np.concatenate(pieces), fresh
