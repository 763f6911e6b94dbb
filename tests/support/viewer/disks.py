"""Small disks for the viewer's tests, and a plain expansion to widen them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from patterndb.core.disk import Disk
from patterndb.core.pattern import Pattern
from patterndb.core.quadmesh import QuadMesh

ONE_QUAD = [[0, 1, 2, 3]]
TWO_QUADS = [[0, 1, 4, 5], [1, 2, 3, 4]]
DOUBLET = [[0, 1, 2, 4], [0, 4, 2, 3]]
TWO_DOUBLETS = [[0, 1, 2, 4], [0, 4, 2, 5], [0, 5, 2, 3]]
TRIANGLE = [[0, 1, 6, 5], [1, 2, 3, 6], [6, 3, 4, 5]]
PENTAGON = [[0, 2 * i + 1, 2 * i + 2, (2 * i + 2) % 10 + 1] for i in range(5)]
RING = [[0, 1, 2, 3], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]]
L_SHAPE = [[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6]]
PLUS = [[0, 1, 2, 3], [1, 0, 4, 5], [2, 1, 6, 7], [3, 2, 8, 9], [0, 3, 10, 11]]
ALL = {
    "one quad": ONE_QUAD,
    "two quads": TWO_QUADS,
    "doublet": DOUBLET,
    "two doublets": TWO_DOUBLETS,
    "triangle": TRIANGLE,
    "pentagon": PENTAGON,
    "ring": RING,
    "L": L_SHAPE,
    "plus": PLUS,
}


def disk(quads: Sequence[Sequence[int]]) -> Disk:
    """The disk of these quads."""
    return Disk.from_twin(QuadMesh.from_quads(quads).twin)


def pattern(quads: Sequence[Sequence[int]], frequency: int = 0) -> Pattern:
    """The pattern of these quads, which are reduced."""
    found = Pattern.from_disk(QuadMesh.from_quads(quads).twin)
    return Pattern.from_trusted_code(found.code, frequency=frequency)


def expand(pattern: Pattern, widths: Sequence[int]) -> Disk:
    """Every quad as a grid, glued along the pattern's edges."""
    twin, of_edge = pattern.twin(), pattern.polychords().of_edge
    corner = pattern.disk().quads
    names: dict[tuple[object, ...], int] = {}

    def vertex(q: int, i: int, j: int, m: int, n: int) -> int:
        """Vertex i of m along edge 0, j of n along edge 1."""
        at_corner = {(0, 0): 0, (m, 0): 1, (m, n): 2, (0, n): 3}.get((i, j))
        if at_corner is not None:
            key: tuple[object, ...] = ("corner", int(corner[q, at_corner]))
        elif i in (0, m) or j in (0, n):
            e, t, of = (
                (0, i, m)
                if j == 0
                else (1, j, n)
                if i == m
                else (2, m - i, m)
                if j == n
                else (3, n - j, n)
            )
            h = 4 * q + e
            other = int(twin[h])
            key = ("edge", other, of - t) if 0 <= other < h else ("edge", h, t)
        else:
            key = ("inner", q, i, j)
        return names.setdefault(key, len(names))

    quads = []
    for q in range(pattern.n_quads):
        m, n = widths[of_edge[4 * q]], widths[of_edge[4 * q + 1]]
        for j in range(n):
            for i in range(m):
                around = ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))
                quads.append([vertex(q, a, b, m, n) for a, b in around])
    return Disk.from_twin(QuadMesh.from_quads(np.array(quads)).twin, 0)


def refined(quads: Sequence[Sequence[int]], times: int) -> Disk:
    """Every quad as a grid of times by times."""
    one = Pattern.from_disk(QuadMesh.from_quads(quads).twin)
    return expand(one, [times] * (one.n_chords + one.n_loops))
