"""Minimum-weight perfect matching in a complete graph: the exact answer, by blossoms.

Edmonds, "Paths, trees, and flowers" (1965), with dual variables and one forest of all single
vertices at a time, as described by Galil, "Efficient algorithms for finding maximum matching in
graphs" (1986). A *node* is a vertex or a blossom: an odd cycle of nodes, shrunk. The
top nodes are those in no blossom. In the forest, even nodes lie at even distance from a single
one, odd nodes at odd distance; the others are out of it.

Edges are compared at vertices: every vertex keeps its tightest edge to an even vertex of another
top node. Edges within a blossom drop out by themselves when it forms, so that no edges between
nodes are stored.
"""

from __future__ import annotations

import numpy as np

from patterndb.core.halfedge import Int32Array, Int64Array
from patterndb.system.kernels import kernel
from patterndb_sketch.retopo.counts.blossom import (
    EVEN,
    ODD,
    OUT,
    Forest,
    make_even,
    offer,
    open_up,
    rebase,
    shrink,
)
from patterndb_sketch.retopo.errors import InvalidRetopoError

#: Weights are doubled, and so are sums of two: above this they might not fit in 63 bits.
MOST_WEIGHT = 1 << 58


def min_weight_perfect_matching(weights: Int64Array) -> Int32Array:
    """(n,) int32: of every vertex its partner, such that the sum of the weights is least.

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
    return _match(np.ascontiguousarray(weights, np.int64))


@kernel
def _match(weights: Int64Array) -> Int32Array:
    n = len(weights)
    m = n + n // 2
    doubled = 2 * weights
    least = doubled[0, 1]
    for u in range(n):
        for v in range(u):
            least = min(least, doubled[u, v])
    forest = Forest(
        doubled,
        # All equal: then the duals of even vertices keep one parity, and halves are whole.
        np.full(n, least // 2, np.int64),
        np.zeros(m, np.int64),
        np.full(n, -1, np.int32),
        np.arange(n).astype(np.int32),
        np.full(n, -1, np.int32),
        np.full(m, -1, np.int32),
        np.arange(m).astype(np.int32),
        np.zeros(m, np.int32),
        np.full((m, 2), -1, np.int32),
        np.zeros(n // 2, np.int32),
        np.empty((n // 2, n), np.int32),
        np.empty((n // 2, n, 2), np.int32),
    )
    for _ in range(n // 2):
        _grow(forest)
    return forest.mate


@kernel
def _grow(f: Forest) -> None:
    """Grow the forest of all single vertices until two more vertices can be matched."""
    n = len(f.mate)
    f.label[:] = OUT
    f.tightest[:] = -1
    for v in range(n):
        if f.mate[v] < 0:
            f.label[f.top[v]] = EVEN
    for v in range(n):
        if f.label[f.top[v]] == EVEN:
            offer(f, v)
    while True:
        step, at = _next_event(f)
        for v in range(n):
            kind = f.label[f.top[v]]
            if kind == EVEN:
                f.dual[v] += step
            elif kind == ODD:
                f.dual[v] -= step
        for b in range(n, len(f.up)):
            if f.n_kids[b - n] and f.up[b] < 0:
                if f.label[b] == EVEN:
                    f.surplus[b] += 2 * step
                elif f.label[b] == ODD:
                    f.surplus[b] -= 2 * step
        if at >= n:
            open_up(f, at)
            continue
        u = f.tightest[at]
        if f.label[f.top[at]] == OUT:
            _enter(f, u, at)
        elif _root(f, u) != _root(f, at):
            _flip(f, u, at)
            _flip(f, at, u)
            f.mate[u] = at
            f.mate[at] = u
            return
        else:
            shrink(f, u, at)


@kernel
def _next_event(f: Forest) -> tuple[int, int]:
    """By how much the duals may change, and the vertex, or odd blossom, that stops them."""
    n = len(f.mate)
    step = np.int64(-1)
    at = -1
    for v in range(n):
        kind = f.label[f.top[v]]
        if kind == ODD:
            continue
        u = f.tightest[v]
        if u >= 0 and f.top[u] == f.top[v]:
            u = _look(f, v)
        if u < 0:
            continue
        room = f.weight[u, v] - f.dual[u] - f.dual[v]
        if kind == EVEN:
            room //= 2
        if at < 0 or room < step:
            step = room
            at = v
    for b in range(n, len(f.up)):
        if f.n_kids[b - n] and f.up[b] < 0 and f.label[b] == ODD:
            room = f.surplus[b] // 2
            if at < 0 or room < step:
                step = room
                at = b
    return int(step), at


@kernel
def _look(f: Forest, v: int) -> int:
    """The tightest edge of v among all even vertices: the former one is within its node."""
    found = -1
    for u in range(len(f.mate)):
        if (
            f.label[f.top[u]] == EVEN
            and f.top[u] != f.top[v]
            and (found < 0 or f.weight[u, v] - f.dual[u] < f.weight[found, v] - f.dual[found])
        ):
            found = u
    f.tightest[v] = found
    return found


@kernel
def _enter(f: Forest, u: int, v: int) -> None:
    """A node out of the forest becomes odd, by the edge (u, v), and its partner even."""
    x = f.top[v]
    f.label[x] = ODD
    f.entry[x, 0] = u
    f.entry[x, 1] = v
    make_even(f, int(f.top[f.mate[f.base[x]]]))


@kernel
def _root(f: Forest, v: int) -> int:
    """The single vertex of the tree of an even vertex."""
    x = f.top[v]
    while f.mate[f.base[x]] >= 0:
        odd = f.top[f.mate[f.base[x]]]
        x = f.top[f.entry[odd, 0]]
    return int(f.base[x])


@kernel
def _flip(f: Forest, u: int, v: int) -> None:
    """Match along the tree from the even vertex u to its root, so that u is free for v."""
    while True:
        x = int(f.top[u])
        before = f.mate[f.base[x]]
        rebase(f, x, u)
        f.mate[u] = v
        if before < 0:
            return
        odd = int(f.top[before])
        u = int(f.entry[odd, 0])
        v = int(f.entry[odd, 1])
        rebase(f, odd, v)
        f.mate[v] = u
