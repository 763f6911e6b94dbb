"""Marks on a pattern's boundary, and the strands that they split its polychords into.

A mark lies on a boundary vertex, or at a *slot* inside a boundary edge, where it parts the
polychord that crosses the edge. The slots of a polychord are ordered across it; its two ends
see the same order, reversed. On one polychord with m marks, any sequence of slots is a
choice, each with a mark at the one end, the other, or both: no other partings matter.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from patterndb.core.code import Code, border_count, clockwise_start, rooted_code
from patterndb.core.halfedge import Index, Int32Array, next_border_edge
from patterndb.core.polychord import trace
from patterndb.system.kernels import kernel

#: Bits of an edge's slots in one number: more marks than that on one polychord are refused.
MOST_SLOTS = 12


@dataclass(frozen=True, slots=True, eq=False)
class Partings:
    """All ways to set up to m marks into the slots of one polychord, fewest marks first.

    marks: (a,) int32 how many marks; parting 0 has none.
    slots: (a,) int32 how many slots; there is one strand more.
    near, far: (a,) int32 bit s is set where slot s has a mark at the polychord's first end,
        and at its other end; slots are counted across it as its first end sees them.
    """

    marks: Int32Array
    slots: Int32Array
    near: Int32Array
    far: Int32Array

    @classmethod
    def up_to(cls, most: int) -> Partings:
        """Those with at most ``most`` marks: 2.41**most of them, about."""
        rows = [(0, 0, 0, 0)]
        level = rows
        for s in range(most):
            level = [
                (marks + more, s + 1, near | a << s, far | b << s)
                for marks, _, near, far in level
                for more, a, b in ((1, 1, 0), (1, 0, 1), (2, 1, 1))
                if marks + more <= most
            ]
            rows = rows + level
        columns = np.array(sorted(rows), np.int32).T.copy()
        return cls(columns[0], columns[1], columns[2], columns[3])


class Rim(NamedTuple):
    """The boundary of a pattern of P edges.

    quads: (P,) int32 number of quads at each boundary vertex, from corner 0 on.
    chord: (P,) int32 polychord that crosses each edge, in label order.
    near, far: (n,) int32 first and other edge that each polychord ends on.
    shift, reflected: (g,) int32 and bool, the symmetries: vertex i looks like vertex
        shift + i, or, reflected, like shift - i, and edge i like edge shift - i - 1.
    """

    quads: Int32Array
    chord: Int32Array
    near: Int32Array
    far: Int32Array
    shift: Int32Array
    reflected: NDArray[np.bool_]


@kernel
def rim(code: Code) -> Rim:
    """The boundary of the pattern of a canonical code, (4q,) uint16."""
    size = len(code)
    q = size // 4
    twin = code.astype(np.int32) - 1
    loop = np.empty(size, np.int32)
    perimeter = 0
    h = 0
    while True:
        loop[perimeter] = h
        perimeter += 1
        h = next_border_edge(twin, h)
        if h == 0:
            break
    of_edge, n_open, n_total = trace(twin)
    name = np.full(n_total, -1, np.int32)
    quads = np.empty(perimeter, np.int32)
    chord = np.empty(perimeter, np.int32)
    near = np.empty(n_open, np.int32)
    far = np.empty(n_open, np.int32)
    fresh = 0
    for i in range(perimeter):
        quads[i] = border_count(twin, loop[i])
        c = of_edge[loop[i]]
        if name[c] < 0:
            name[c] = fresh
            near[fresh] = i
            fresh += 1
        else:
            far[name[c]] = i
        chord[i] = name[c]
    shift = np.empty(2 * perimeter, np.int32)
    reflected = np.empty(2 * perimeter, np.bool_)
    number = np.empty(q, np.int32)
    entry = np.empty(q, np.int32)
    order = np.empty(q, np.int32)
    seen = np.empty(size, np.uint16)
    n = 0
    for i in range(perimeter):
        if quads[i] != quads[0]:
            continue
        for clockwise in (False, True):
            seen[:] = code
            start = clockwise_start(twin, loop[i]) if clockwise else loop[i]
            if rooted_code(twin, q, start, clockwise, seen, number, entry, order, True) == 0:
                shift[n] = i
                reflected[n] = clockwise
                n += 1
    return Rim(quads, chord, near, far, shift[:n].copy(), reflected[:n].copy())


@kernel
def mirrored_bits(bits: Index, n: Index) -> Index:
    """The lowest n bits in reverse order."""
    result = 0
    for s in range(n):
        result |= (bits >> s & 1) << (n - 1 - s)
    return result


@kernel
def is_first_image(
    pattern: Rim, at_vertex: NDArray[np.bool_], slots: Int32Array, bits: Int32Array
) -> bool:
    """Does no symmetry of the pattern take the marks to a smaller image?

    at_vertex: (P,) bool; slots, bits: (P,) int32 slots of every edge and which of them have
    marks, counter-clockwise. Of all images of a choice exactly one passes.
    """
    perimeter = len(slots)
    for g in range(len(pattern.shift)):
        for i in range(perimeter):
            if pattern.reflected[g]:
                v = (pattern.shift[g] - i) % perimeter
                e = (pattern.shift[g] - i - 1) % perimeter
                other = mirrored_bits(bits[e], slots[e])
            else:
                v = (pattern.shift[g] + i) % perimeter
                e = v
                other = bits[e]
            mine = (int(at_vertex[i]), slots[i], bits[i])
            theirs = (int(at_vertex[v]), slots[e], other)
            if theirs < mine:
                return False
            if theirs > mine:
                break
    return True
