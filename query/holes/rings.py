"""Fills that are paved from the loop inwards, ring by ring.

The quads at the loop's vertices determine all quads that touch the loop: a ring. What the ring
leaves is a loop, too. Where every vertex of it gets what makes it regular, the next ring follows,
and so on until a fill with one irregular vertex, or none, fits the rest. One ring alone leaves a
loop that a regular fill or a pattern of holes fills; so fills are found whose pattern no mesh has
shown.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats
from patterndb.system.kernels import kernel
from query.holes.regular import fill_walk

#: Part of artists' vertices at which c quads of the ring and 1 to 4 quads within it meet, by c = 1
#: to 6 (rows): measured behind the rims of 4,513 holes that scripts/cut_holes.py cut into 40 of the
#: meshes that scripts/train_holes.py learns from; what was not met counts as .001.
WITHIN = np.array(
    [
        [0.001, 0.624, 0.353, 0.022],
        [0.127, 0.858, 0.013, 0.002],
        [0.917, 0.071, 0.011, 0.001],
        [0.648, 0.349, 0.002, 0.001],
        [0.864, 0.134, 0.001, 0.001],
        [0.863, 0.135, 0.001, 0.001],
    ]
)

#: More rings than any loop has room for.
_ALL = 1_000_000


@dataclass(frozen=True, slots=True, eq=False)
class QuadRing:
    """The quads that touch a loop, and the loop that they leave.

    quads: (q, 4) int32, loop vertices 0..L-1, others from L on. inner: (m,) int32 the vertices of
    the loop that is left, in order; none where the ring fills the loop. counts: (m,) int32 quads of
    the ring at each. n_vertices: of loop and ring.
    """

    quads: Int32Array
    inner: Int32Array
    counts: Int32Array
    n_vertices: int

    def log_within(self) -> Floats:
        """(m, 4) log of the part of vertices that get 1 to 4 quads within."""
        return np.log(WITHIN[np.minimum(self.counts, len(WITHIN)) - 1])

    def join(self, quads: Int32Array) -> Int32Array:
        """(q, 4) the ring's quads, and those of a fill of the loop that is left, in its numbers."""
        m = len(self.inner)
        far = np.arange(max(int(quads.max()) + 1, m))
        names = np.where(far < m, self.inner[np.minimum(far, m - 1)], far - m + self.n_vertices)
        return np.concatenate([self.quads, names[quads]]).astype(np.int32)


def lay_ring(corners: Int32Array) -> QuadRing | None:
    """Return the ring of the quads at each vertex of a loop, none of which are joined needlessly.

    corners: (L,) 1 to 4, L even. None where there is no such ring.
    """
    quads, inner, counts, n_vertices = _pave(np.ascontiguousarray(corners, np.int32), 1)
    return QuadRing(quads, inner, counts, n_vertices) if n_vertices else None


def pave_loop(corners: Int32Array) -> tuple[Int32Array, int] | None:
    """Return the fill of rings that has these quads at each loop vertex: quads (q, 4) int32, loop
    vertices 0..L-1, inner ones after, and how many vertices; None where paving does not end.

    corners: (L,) 1 to 4, L even. Most fills with one irregular vertex inside are found so.
    """
    quads, inner, _, n_vertices = _pave(np.ascontiguousarray(corners, np.int32), _ALL)
    return (quads, n_vertices) if n_vertices and not len(inner) else None


@kernel
def _pave(corners: Int32Array, rings: int) -> tuple[Int32Array, Int32Array, Int32Array, int]:
    """Lay rings: quads, the loop that is left, the quads at each vertex of it, and how many
    vertices; 0 where that cannot be.

    A ring is laid quad by quad along a front, which is the loop at first. A vertex of the loop that
    lacks one quad gets it between the front's edges before and after; where none does, a quad is
    laid behind an edge of the front. Before the next ring, vertices with four quads are closed: the
    two edges of the front there become one.
    """
    n = len(corners)
    none = np.empty((0, 4), np.int32)
    nothing = np.empty(0, np.int32)
    most = n * n // 8 + 4 * n
    room = n + 2 * most + 2
    after = np.empty(room, np.int32)
    before = np.empty(room, np.int32)
    lacking = np.zeros(room, np.int32)  # of vertices of the ring's loop: quads that are to come
    met = np.zeros(room, np.int32)  # of others: quads that came
    due = np.zeros(room, np.bool_)
    same = np.arange(room).astype(np.int32)
    quads = np.empty((most + 1, 4), np.int32)
    for i in range(n):
        after[i], before[i] = (i + 1) % n, (i - 1) % n
        lacking[i] = corners[i]
        due[i] = True
    length = n
    head = 0
    top = n
    count = 0
    laid = 0
    while length > 0:
        if count >= most:
            return none, nothing, nothing, 0
        v = -1
        one = -1
        w = head
        for _ in range(length):
            if due[w]:
                v = w
                if lacking[w] == 1:
                    one = w
                    break
            w = after[w]
        if v < 0:
            laid += 1
            if laid == rings:
                break
            names = np.empty(length, np.int32)
            lack = np.empty(length, np.int32)
            turn = 0
            w = head
            for i in range(length):
                names[i], lack[i] = w, 4 - met[w]
                turn += 2 - lack[i]
                w = after[w]
            if turn <= 0:
                return none, nothing, nothing, 0
            if 3 <= turn <= 5:
                found, joined, n_found = _fill_rest(names, lack, turn - 4)
                if n_found and count + len(found) <= most:
                    for i in range(len(joined)):
                        same[joined[i, 0]] = joined[i, 1]
                    for f in range(len(found)):
                        for e in range(4):
                            a = found[f, e]
                            quads[count, e] = a if a >= 0 else top - 1 - a
                        count += 1
                    top += n_found - 1
                    length = 0
                    break
            w = head
            steps = 0
            while length > 2 and steps < length:
                if met[w] < 4:
                    w = after[w]
                    steps += 1
                    continue
                u, x = before[w], after[w]
                met[u] += met[x]
                same[x] = u
                after[u] = after[x]
                before[after[x]] = u
                length -= 2
                head = w = u
                steps = 0
            if length <= 2:
                length = 0
                break
            w = head
            for _ in range(length):
                due[w] = True
                lacking[w] = 4 - met[w]
                w = after[w]
            if length == 4:
                u, x = before[head], after[head]
                quads[count, 0], quads[count, 1] = u, head
                quads[count, 2], quads[count, 3] = x, after[x]
                count += 1
                length = 0
            continue
        sound = True
        if one < 0:
            w, x, y = after[v], top, top + 1
            top += 2
            quads[count, 0], quads[count, 1], quads[count, 2], quads[count, 3] = v, w, y, x
            after[v], before[x] = x, v
            after[x], before[y] = y, x
            after[y], before[w] = w, y
            length += 2
            met[x] = met[y] = 1
            lacking[v] -= 1
            if due[w]:
                lacking[w] -= 1
                sound = lacking[w] > 0
            else:
                met[w] += 1
            head = v
        else:
            v = one
            if length > 4:
                # Of three in a row that lack one quad each, it is that of the middle one.
                for _ in range(2):
                    a, b = after[v], after[after[v]]
                    if due[a] and lacking[a] == 1 and due[b] and lacking[b] == 1:
                        v = a
                    else:
                        break
                a, b = before[v], after[v]
                c = before[a]
                if (
                    due[a]
                    and lacking[a] == 1
                    and due[c]
                    and lacking[c] == 1
                    and not (due[b] and lacking[b] == 1)
                ):
                    v = a
            u, w = before[v], after[v]
            last = due[u] and lacking[u] == 1
            following = due[w] and lacking[w] == 1
            if length == 4:
                p = after[w]
                for a in (u, w, p):
                    if due[a] and lacking[a] != 1:
                        sound = False
                length = 0
            elif last and following:
                # What is before and after these three is one vertex.
                p, twin = before[u], after[w]
                left, right = before[p], after[twin]
                if due[twin]:
                    p, twin = twin, p
                if due[twin]:
                    return none, nothing, nothing, 0
                same[twin] = p
                after[left], before[p] = p, left
                after[p], before[right] = right, p
                length -= 4
                if due[p]:
                    lacking[p] -= met[twin] + 1
                    sound = lacking[p] > 0
                else:
                    met[p] += met[twin] + 1
                head = p
            else:
                # The front's edge between two vertices becomes the quad's fourth side.
                if last:
                    p = before[u]
                    start, end = p, w
                    length -= 2
                elif following:
                    p = after[w]
                    start, end = u, p
                    length -= 2
                else:
                    p = top
                    top += 1
                    met[p] = 1
                    after[u], before[p] = p, u
                    after[p], before[w] = w, p
                    start, end = u, w
                if last or following:
                    after[start], before[end] = end, start
                for a in (start, end):
                    if due[a]:
                        lacking[a] -= 1
                        sound = sound and lacking[a] > 0
                    else:
                        met[a] += 1
                head = end
            quads[count, 0], quads[count, 1] = u, v
            quads[count, 2], quads[count, 3] = w, p
        count += 1
        if not sound:
            return none, nothing, nothing, 0
        if 0 < length <= 2:
            w = head
            for _ in range(length):
                if due[w]:
                    return none, nothing, nothing, 0
                w = after[w]
            length = 0
    for a in range(top):
        while same[a] != same[same[a]]:
            same[a] = same[same[a]]
    number = np.full(top, -1, np.int32)
    number[:n] = np.arange(n)
    n_vertices = n
    for a in range(n, top):
        if same[a] == a:
            number[a] = n_vertices
            n_vertices += 1
    for f in range(count):
        for e in range(4):
            quads[f, e] = number[same[quads[f, e]]]
    inner = np.empty(length, np.int32)
    counts = np.empty(length, np.int32)
    w = head
    for i in range(length):
        inner[i] = number[w]
        counts[i] = met[w]
        w = after[w]
    return quads[:count], inner, counts, n_vertices


@kernel
def _fill_rest(names: Int32Array, lack: Int32Array, off: int) -> tuple[Int32Array, Int32Array, int]:
    """Fill a loop with one irregular vertex on it, or none: quads, pairs of vertices of the loop
    that become one, and 1 more than the number of new vertices; 0 where that cannot be.

    names: (m,) vertices of the loop, which new ones follow as -1, -2, ... lack: (m,) quads that
    each lacks to be regular. off: what the irregular one gets more; 0 for none.
    """
    m = len(names)
    empty = np.empty((0, 4), np.int32)
    at = np.empty(m, np.int32)
    due = np.empty(m, np.int32)
    joined = np.empty((m, 2), np.int32)
    for i in range(m if off else 1):
        at[:] = names
        due[:] = lack
        due[i] += off
        length, n_joined, j = m, 0, 0
        while j < length and length > 2:
            if due[j] != 0:
                j += 1
                continue
            # No quad is left for a vertex: the edges before and after it become one.
            u, x = (j - 1) % length, (j + 1) % length
            joined[n_joined, 0], joined[n_joined, 1] = at[x], at[u]
            n_joined += 1
            due[u] += due[x] - 4
            k = 0
            for h in range(length):
                if h != j and h != x:
                    at[k], due[k] = at[h], due[h]
                    k += 1
            length = k
            j = 0
        if length == 2:
            if due[0] == 0 and due[1] == 0:
                return empty, joined[:n_joined], 1
            continue
        if due[:length].min() < 1 or due[:length].max() > 4:
            continue
        found, n_found = fill_walk(due[:length].copy())
        if n_found:
            quads = np.empty((len(found), 4), np.int32)
            for f in range(len(found)):
                for e in range(4):
                    a = found[f, e]
                    quads[f, e] = at[a] if a < length else length - 1 - a
            return quads, joined[:n_joined], n_found - length + 1
    return empty, joined[:0], 0
