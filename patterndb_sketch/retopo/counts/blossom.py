"""Blossoms: odd cycles of a matching that are shrunk into one node, and opened again.

The parts of a minimum-weight perfect matching (:mod:`patterndb_sketch.retopo.counts.matching`) that deal with
what lies within a node.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from patterndb.core.halfedge import Int32Array, Int64Array
from patterndb.system.kernels import kernel

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
