"""What the tests of constructions share: a check of fills by plain Python."""

from __future__ import annotations

from collections import Counter, defaultdict

import numpy as np

from query import Boundary, Fill
from tests.support.query.cases import KIND

COUNT = {kind: count for count, kind in KIND.items()}


def asked_counts(boundary: Boundary) -> dict[int, int]:
    """Quads that each boundary vertex asks for."""
    asked = dict.fromkeys(range(boundary.perimeter), 2)
    at = 0
    for length, kind in zip(boundary.lengths, boundary.corners, strict=False):
        asked[at] = COUNT[kind]
        at += length
    return asked


def assert_fills(fill: Fill, boundary: Boundary) -> None:
    """Every invariant of a fill, strict or not, from its quads alone."""
    quads = fill.quads.tolist()
    assert fill.quads.dtype == np.int32
    assert fill.lengths == boundary.lengths
    assert all(len(set(quad)) == 4 for quad in quads)
    runs = [edge for q in quads for edge in zip(q, q[1:] + q[:1], strict=True)]
    edges = set(runs)
    assert len(edges) == len(runs), "two edges join the same two vertices"
    perimeter = boundary.perimeter
    border = {(a, b) for a, b in edges if (b, a) not in edges}
    assert border == {(i, (i + 1) % perimeter) for i in range(perimeter)}
    count = Counter(v for quad in quads for v in quad)
    assert set(count) == set(range(fill.n_vertices))
    assert fill.n_vertices - (len(edges) + perimeter) // 2 + len(quads) == 1
    around: dict[int, list[list[int]]] = defaultdict(list)
    for quad in quads:
        for v in quad:
            around[v].append(quad)
    assert all(one_fan(fan, v) for v, fan in around.items())
    asked = asked_counts(boundary)
    outer = sum(count[v] != k for v, k in asked.items())
    inner = sum(count[v] != 4 for v in range(perimeter, fill.n_vertices))
    assert (fill.n_irregular, fill.n_irregular_boundary) == (inner + outer, outer)
    assert all(count[v] > 2 for v in range(perimeter, fill.n_vertices))
    # Gauss-Bonnet.
    turn = sum(2 - count[v] for v in range(perimeter))
    assert turn + sum(4 - count[v] for v in range(perimeter, fill.n_vertices)) == 4


def one_fan(around: list[list[int]], v: int) -> bool:
    """Do the quads at a vertex hang together over edges at it?"""
    spokes = [{q[q.index(v) - 1], q[(q.index(v) + 1) % 4]} for q in around]
    reached = spokes.pop()
    while touching := [s for s in spokes if s & reached]:
        reached |= touching[0]
        spokes.remove(touching[0])
    return not spokes
