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
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components, dijkstra

from patterndb.core.halfedge import Int32Array, Int64Array
from patterndb.geometry.points import Bools
from patterndb.system.kernels import kernel
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
    return _match(np.ascontiguousarray(weights, np.int64))


#: Where a node is in the forest.
OUT, EVEN, ODD = 0, 1, 2


class Forest(NamedTuple):
    """n vertices and room for n // 2 blossoms, m nodes in all; blossom b is node n + b.

    weight: (n, n) twice the weights.
    dual: (n,) of vertices; dual[u] + dual[v] <= weight[u, v] where the top nodes differ, equal
        along edges of forest and matching.
    surplus: (m,) of blossoms, >= 0: twice what their inner edges may exceed their weight by.
    mate, top, tightest: (n,) partner or -1; top node; the even vertex of the tightest edge or -1.
    up, base, label: (m,) the blossom a node lies in, or -1; the vertex that is not matched
        within; OUT, EVEN or ODD.
    entry: (m, 2) of an odd node: the edge of the forest to it, (vertex before, vertex in it).
    n_kids, kids: (n // 2,) and (n // 2, n) the nodes in the cycle of a blossom, from the one with
        the base; n_kids is 0 where the blossom is not in use.
    links: (n // 2, n, 2) the edge from a kid to the next: (vertex in it, vertex in the next).
    """

    weight: Int64Array
    dual: Int64Array
    surplus: Int64Array
    mate: Int32Array
    top: Int32Array
    tightest: Int32Array
    up: Int32Array
    base: Int32Array
    label: Int32Array
    entry: Int32Array
    n_kids: Int32Array
    kids: Int32Array
    links: Int32Array


@kernel
def offer(f: Forest, u: int) -> None:
    """Tell all vertices of other nodes about the even vertex u."""
    for v in range(len(f.mate)):
        if f.top[v] == f.top[u]:
            continue
        t = f.tightest[v]
        # What is in one node with v is of no use to it any more.
        if (
            t < 0
            or f.top[t] == f.top[v]
            or (f.weight[u, v] - f.dual[u] < f.weight[t, v] - f.dual[t])
        ):
            f.tightest[v] = u


@kernel
def make_even(f: Forest, x: int) -> None:
    f.label[x] = EVEN
    for v in range(len(f.mate)):
        if f.top[v] == x:
            offer(f, v)


@kernel
def _kid_with(f: Forest, b: int, v: int) -> int:
    """The place, in the cycle of blossom b, of the node that holds vertex v."""
    x = v
    while f.up[x] != b:
        x = f.up[x]
    i = 0
    while f.kids[b - len(f.mate), i] != x:
        i += 1
    return i


@kernel
def rebase(f: Forest, node: int, vertex: int) -> None:
    """Match within a node so that it is the vertex that is left for an edge outwards."""
    n = len(f.mate)
    if node < n:
        return
    todo = np.empty((len(f.up), 2), np.int32)
    todo[0, 0] = node
    todo[0, 1] = vertex
    count = 1
    while count:
        count -= 1
        b = todo[count, 0]
        v = todo[count, 1]
        row = b - n
        k = f.n_kids[row]
        j = _kid_with(f, b, v)
        f.base[b] = v
        if f.kids[row, j] >= n:
            todo[count, 0] = f.kids[row, j]
            todo[count, 1] = v
            count += 1
        # Kids 1 and 2 are matched, 3 and 4, and so on. From an even place the pairs go round
        # downwards, from an odd one upwards, until they take in the kid that was the base.
        i = 0 if j % 2 == 0 else j + 1
        end = j if j % 2 == 0 else k
        while i < end:
            for side in range(2):
                kid = f.kids[row, (i + side) % k]
                inner = f.links[row, i, side]
                f.mate[inner] = f.links[row, i, 1 - side]
                if kid >= n:
                    todo[count, 0] = kid
                    todo[count, 1] = inner
                    count += 1
            i += 2
        f.kids[row, :k] = np.roll(f.kids[row, :k], -j)
        for side in range(2):
            f.links[row, :k, side] = np.roll(f.links[row, :k, side], -j)


@kernel
def shrink(f: Forest, u: int, v: int) -> None:
    """The cycle that the edge (u, v) closes in a tree becomes a blossom, even."""
    n = len(f.mate)
    seen = np.zeros(len(f.up), np.bool_)
    x = f.top[u]
    while True:
        seen[x] = True
        if f.mate[f.base[x]] < 0:
            break
        x = f.top[f.entry[f.top[f.mate[f.base[x]]], 0]]
    stem = int(f.top[v])
    while not seen[stem]:
        stem = int(f.top[f.entry[f.top[f.mate[f.base[stem]]], 0]])
    row = 0
    while f.n_kids[row]:
        row += 1
    b = n + row
    kids = f.kids[row]
    links = f.links[row]
    # Down from the stem to u: found upwards, and turned round.
    k = _climb(f, int(f.top[u]), stem, kids, links, 0)
    down = kids[:k].copy()
    up = links[:k].copy()
    kids[0] = stem
    for i in range(k):
        kids[i + 1] = down[k - 1 - i]
        links[i, 0] = up[k - 1 - i, 1]
        links[i, 1] = up[k - 1 - i, 0]
    links[k, 0] = u
    links[k, 1] = v
    k = _climb(f, int(f.top[v]), stem, kids, links, k + 1)
    f.n_kids[row] = k
    f.base[b] = f.base[stem]
    f.up[b] = -1
    f.surplus[b] = 0
    f.label[b] = EVEN
    inside = np.zeros(len(f.up), np.bool_)
    for i in range(k):
        f.up[kids[i]] = b
        inside[kids[i]] = True
    were_odd = np.zeros(n, np.bool_)
    for w in range(n):
        if inside[f.top[w]]:
            were_odd[w] = f.label[f.top[w]] == ODD
            f.top[w] = b
    for w in range(n):
        if were_odd[w]:
            offer(f, w)


@kernel
def _climb(f: Forest, x: int, stem: int, kids: Int32Array, links: Int32Array, k: int) -> int:
    """Write the nodes from the even node x to below the stem, and their edges upwards, from k."""
    while x != stem:
        odd = f.top[f.mate[f.base[x]]]
        kids[k] = x
        links[k, 0] = f.base[x]
        links[k, 1] = f.mate[f.base[x]]
        kids[k + 1] = odd
        links[k + 1, 0] = f.entry[odd, 1]
        links[k + 1, 1] = f.entry[odd, 0]
        k += 2
        x = int(f.top[f.entry[odd, 0]])
    return k


@kernel
def open_up(f: Forest, b: int) -> None:
    """Dissolve an odd blossom without surplus: its kids are top nodes again."""
    n = len(f.mate)
    row = b - n
    k = f.n_kids[row]
    kids = f.kids[row]
    links = f.links[row]
    before = f.entry[b, 0]
    inside = f.entry[b, 1]
    j = _kid_with(f, b, inside)
    for i in range(k):
        f.label[kids[i]] = OUT
        f.up[kids[i]] = -1
    for v in range(n):
        if f.top[v] == b:
            x = v
            while f.up[x] >= 0:
                x = f.up[x]
            f.top[v] = x
    f.n_kids[row] = 0
    # From where the tree enters to the base, round the side that begins with a matched edge.
    way = -1 if j % 2 == 0 else 1
    while True:
        odd = kids[j]
        f.label[odd] = ODD
        f.entry[odd, 0] = before
        f.entry[odd, 1] = inside
        if j == 0:
            return
        even = (j + way) % k
        beyond = (j + 2 * way) % k
        if way < 0:
            before = links[beyond, 1]
            inside = links[beyond, 0]
        else:
            before = links[even, 0]
            inside = links[even, 1]
        make_even(f, int(kids[even]))
        j = beyond


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
