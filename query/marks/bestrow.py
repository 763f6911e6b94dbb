"""Kernels of :mod:`.bestmarked`: the first row that fits, and how wide its strands are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.system.kernels import kernel
from query.solving.colouring import balanced
from query.solving.matching import search
from query.solving.transport import integral, transport


@kernel
def best_row(
    lengths: Int32Array,
    asked: Int32Array,
    cap: int,
    most: int,
    base: Int32Array,
    start: NDArray[np.int64],
    unmarked: Int32Array,
    signature: Int32Array,
    counts: NDArray[np.uint8],
    convex: Int32Array,
    reflex: Int32Array,
    class_start: NDArray[np.int64],
    class_i: Int32Array,
    class_j: Int32Array,
    component: Int32Array,
    colour: Int32Array,
) -> tuple[int, int, int, int, Int32Array]:
    """Kernel of :func:`query.marks.bestmarked.best_marked`.

    lengths: (N,) edges of each side; asked: (N,) quads at each corner; most: -1 for any. The
    others are of :class:`query.marks.bestmarked.MarkedIndex`. Returns (row of the index, or -1;
    orientation of its signature, N and more being mirrored; irregular vertices; those on the
    boundary; (m,) slack of every class).
    """
    n = len(lengths)
    perimeter = lengths.sum()
    seen = np.empty((2 * n, n), np.int32)
    wanted = np.empty((2 * n, n), np.int32)
    n_convex = 0
    n_reflex = 0
    for s in range(n):
        n_convex += asked[s] == 1
        n_reflex += asked[s] == 3
        for r in range(n):
            seen[r, s] = lengths[(s - r) % n]
            wanted[r, s] = asked[(s - r) % n]
            seen[n + r, s] = lengths[(r - s) % n]
            wanted[n + r, s] = asked[(r + 1 - s) % n]
    m = n * (n + 1) // 2
    class_n = np.ones(m, np.int32)
    closed = np.zeros(m, np.bool_)
    side_scratch = np.empty((5, n), np.int32)
    class_scratch = np.empty((3, m), np.int32)
    flow = np.empty((2, m), np.int32)
    solution = np.empty((1, m), np.int32)
    slack = np.empty(n, np.int32)
    # Orientations in which a signature has been found not to fit.
    failed = np.zeros(len(base), np.uint64)
    highest = len(start) - 2 + cap
    if most >= 0:
        highest = min(highest, most)
    for total in range(highest + 1):
        for on_boundary in range(min(cap, total) + 1):
            inside = total - on_boundary
            if inside > len(start) - 2:
                continue
            for u in range(start[inside], start[inside + 1]):
                # So many marks must fall where another count is asked for.
                off = on_boundary - unmarked[u]
                if off < 0 or n - min(convex[u], n_convex) - min(reflex[u], n_reflex) > off + (
                    n - n_convex - n_reflex
                ):
                    continue
                s = signature[u]
                ends = 0
                for i in range(n):
                    ends += base[s, i]
                if ends > perimeter:
                    continue
                first = class_start[s]
                last = class_start[s + 1]
                for o in range(2 * n):
                    if failed[s] >> np.uint64(o) & np.uint64(1):
                        continue
                    here = 0
                    for i in range(n):
                        here += counts[u, i] != wanted[o, i]
                    if here != off:
                        continue
                    if _fits(
                        seen[o],
                        base[s],
                        class_i[first:last],
                        class_j[first:last],
                        class_n,
                        component[s],
                        colour[s],
                        closed,
                        slack,
                        side_scratch,
                        class_scratch,
                        flow,
                        solution,
                    ):
                        value = solution[0, : last - first].copy()
                        return u, o, total, on_boundary, value
                    failed[s] |= np.uint64(1) << np.uint64(o)
    return -1, 0, 0, 0, np.empty(0, np.int32)


@kernel
def _fits(
    lengths: Int32Array,
    base: Int32Array,
    class_i: Int32Array,
    class_j: Int32Array,
    class_n: Int32Array,
    component: Int32Array,
    colour: Int32Array,
    closed: NDArray[np.bool_],
    slack: Int32Array,
    side_scratch: Int32Array,
    class_scratch: Int32Array,
    flow: Int32Array,
    solution: Int32Array,
) -> bool:
    """Can a system meet the lengths? Then the slack of its classes is in ``solution``."""
    m = len(class_i)
    for s in range(len(lengths)):
        slack[s] = lengths[s] - base[s]
        if slack[s] < 0:
            return False
    if not balanced(slack, component, colour, side_scratch[0]):
        return False
    closed[:m] = False
    if not transport(slack, class_i, class_j, m, closed, flow, side_scratch):
        return False
    if integral(flow, m):
        for k in range(m):
            solution[0, k] = (flow[0, k] + flow[1, k]) // 2
        return True
    # The search need not come to a class that must be 0.
    solution[:] = 0
    found, _ = search(
        slack, class_i, class_j, class_n, m, 0, solution, closed, side_scratch, class_scratch
    )
    return found > 0


@kernel
def strand_widths(
    label: NDArray[np.int16],
    rotation: int,
    reflected: bool,
    class_i: Int32Array,
    class_j: Int32Array,
    class_n: Int32Array,
    slack: Int32Array,
    n_sides: int,
) -> Int32Array:
    """(n,) int32 width of every strand of a row, each class's slack spread evenly.

    label, rotation, reflected: of the row, see :class:`query.marks.marked.MarkedClass`; slack:
    (m,) of the classes of its signature.
    """
    n = (len(label) - n_sides) // 2
    i_of = np.full(n, -1, np.int32)
    j_of = np.empty(n, np.int32)
    at = 0
    for side in range(n_sides):
        i = (rotation - side if reflected else side - rotation) % n_sides
        for k in range(at + 1, at + 1 + label[at]):
            strand = label[k]
            if i_of[strand] < 0:
                i_of[strand] = i
            else:
                j_of[strand] = i
        at += 1 + label[at]
    width = np.empty(n, np.int32)
    left = slack.copy()
    parts = class_n.copy()
    for strand in range(n):
        i = min(i_of[strand], j_of[strand])
        j = max(i_of[strand], j_of[strand])
        k = 0
        while class_i[k] != i or class_j[k] != j:
            k += 1
        share = -(-left[k] // parts[k])
        width[strand] = 1 + share
        left[k] -= share
        parts[k] -= 1
    return width
