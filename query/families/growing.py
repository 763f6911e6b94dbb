"""Growing patterns: glue a strip of quads onto a pattern's boundary, reduce, and go on.

Peeling the strip off a side between two convex corners turns interior vertices of valence 3
into convex corners and those of valence 5 into reflex ones: the number of irregular and
reflex vertices never grows. So from one quad, strips glued back reach every pattern with few
of them, whoever made it. A strip may end between two quads of one polychord, so polychords are
made wider first. There is no proof that none is missed; the tests hold the result against
patterns found otherwise.

Source: own. The definitions are those of Marcias et al. 2015, section 3.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from patterndb.core.buffers import copy_items
from patterndb.core.code import Code, border_count, smallest_code
from patterndb.core.halfedge import Index, Int32Array, fans, next_border_edge, next_edge
from patterndb.core.reduction import NEVER_FULL, ReductionWork, dissolve, reduction_work
from patterndb.system.kernels import kernel

#: How a strip may lie: from one boundary vertex to another (or once round to itself),
#: all round, or all round with a corner quad of its own.
OPEN, RING, CORNER_RING = 0, 1, 2


@kernel
def widen_polychords(twin: Int32Array, width: int, wide: Int32Array) -> int:
    """Write the half-edges of the pattern with every polychord ``width`` wide.

    twin: (4q,) int32; wide: (>= 4 * q * width**2,) int32. Returns the number of quads.
    """
    per_quad = width * width
    for f in range(len(twin) // 4):
        for j in range(width):
            for i in range(width):
                cell = 4 * (f * per_quad + j * width + i)
                wide[cell + 1] = cell + 4 + 3
                wide[cell + 2] = cell + 4 * width
                wide[cell + 3] = cell - 4 + 1
                wide[cell] = cell - 4 * width + 2
    for h in range(len(twin)):
        for t in range(width):
            other = -1
            if twin[h] >= 0:
                other = _edge_of_cell(twin[h], width - 1 - t, width)
            wide[_edge_of_cell(h, t, width)] = other
    return per_quad * (len(twin) // 4)


@kernel
def _edge_of_cell(h: int, t: int, width: int) -> int:
    """Part t, counter-clockwise, of the pattern's half-edge h."""
    e = h & 3
    i, j = t, 0
    if e == 1:
        i, j = width - 1, t
    elif e == 2:
        i, j = width - 1 - t, width - 1
    elif e == 3:
        i, j = 0, width - 1 - t
    return 4 * ((h >> 2) * width * width + j * width + i) + e


@kernel
def write_border(
    twin: Int32Array, n_quads: int, loop: Int32Array, count: Int32Array
) -> tuple[int, int]:
    """Write the border half-edges in order and the quads at their tails.

    twin: (>= 4 * n_quads,); loop, count: (>= 4 * n_quads,) int32. Returns (edges of the
    border, how many of the tails are reflex corners).
    """
    first = 0
    while twin[first] >= 0:
        first += 1
    n = 0
    n_reflex = 0
    h = first
    while True:
        loop[n] = h
        count[n] = border_count(twin, h)
        n_reflex += count[n] > 2
        n += 1
        h = next_border_edge(twin, h)
        if h == first:
            return n, n_reflex


@kernel
def glue_strip(
    twin: Int32Array,
    n_quads: int,
    loop: Int32Array,
    perimeter: int,
    first: int,
    length: int,
    kind: int,
) -> int:
    """Glue a strip of ``length`` quads onto the border from vertex ``first``, in place.

    twin: (>= 4 * (n_quads + length + 1),), what lies beyond the quads is overwritten.
    loop: of :func:`write_border`. Returns the new number of quads. :func:`unglue_strip` takes the
    strip off.
    """
    for i in range(length):
        h = loop[(first + i) % perimeter]
        new = 4 * (n_quads + i)
        twin[h] = new
        twin[new] = h
        twin[new + 1] = new - 4 + 3
        twin[new + 2] = -1
        twin[new + 3] = new + 4 + 1
    start = 4 * n_quads + 1
    end = 4 * (n_quads + length - 1) + 3
    if kind == OPEN:
        twin[start] = -1
        twin[end] = -1
        return n_quads + length
    if kind == RING:
        twin[start] = end
        twin[end] = start
        return n_quads + length
    corner = 4 * (n_quads + length)
    twin[corner] = start
    twin[start] = corner
    twin[corner + 1] = end
    twin[end] = corner + 1
    twin[corner + 2] = -1
    twin[corner + 3] = -1
    return n_quads + length + 1


@kernel
def unglue_strip(
    twin: Int32Array, loop: Int32Array, perimeter: int, first: int, length: int
) -> None:
    """Make the border what it was before :func:`glue_strip`."""
    for i in range(length):
        twin[loop[(first + i) % perimeter]] = -1


#: Widest that polychords are made before a strip is glued on. A strip may end between two
#: quads of one polychord at either end of it, hence three wide.
WIDEST = 3


@kernel
def find_slot(
    code: Code,
    size: int,
    table: Int32Array,
    flat: Code,
    offsets: NDArray[np.int64],
) -> tuple[Index, bool]:
    """Where a code stands in the hash table, or would; and whether it does.

    table: (2**b,) int32 row of a code, -1 where free; row r is
    ``flat[offsets[r]:offsets[r + 1]]``.
    """
    key = np.uint64(14695981039346656037)
    for i in range(size):
        key = (key ^ np.uint64(code[i])) * np.uint64(1099511628211)
    key ^= key >> np.uint64(29)
    mask = len(table) - 1
    at = np.int64(key & np.uint64(mask))
    while table[at] >= 0:
        begin = offsets[table[at]]
        if offsets[table[at] + 1] - begin == size:
            i = 0
            while i < size and flat[begin + i] == code[i]:
                i += 1
            if i == size:
                return at, True
        at = (at + 1) & mask
    return at, False


class CodeWork(NamedTuple):
    """Scratch of :func:`write_reduced_code`: of the reduction, and of the codes' search."""

    reduction: ReductionWork
    number: Int32Array
    entry: Int32Array
    order: Int32Array
    other: Code


@kernel
def write_reduced_code(
    twin: Int32Array, n_quads: int, max_quads: int, work: CodeWork, code: Code
) -> int:
    """Write the canonical code of the pattern of a disk; return its length.

    twin: (>= 4 * n_quads,) int32; code: (>= 4 * max_quads,) uint16. A pattern of more than
    ``max_quads`` quads is not coded: the length returned is then 0.
    """
    disk = twin[: 4 * n_quads]
    vertex, n_vertices = fans(disk)
    count = np.zeros(n_vertices, np.int32)
    for h in range(len(disk)):
        count[vertex[h]] += 1
    full = count.copy()
    for h in range(len(disk)):
        if disk[h] < 0:
            full[vertex[h]] = NEVER_FULL
            full[vertex[next_edge(h)]] = NEVER_FULL
    m, n_starts = dissolve(n_quads, disk, vertex, count, full, work.reduction)
    if m > max_quads:
        return 0
    reduced, starts = work.reduction.reduced, work.reduction.starts
    number, entry, order, other = work.number, work.entry, work.order, work.other
    smallest_code(reduced, m, starts, n_starts, False, code, number, entry, order)
    smallest_code(reduced, m, starts, n_starts, True, other, number, entry, order)
    for i in range(4 * m):
        if other[i] != code[i]:
            if other[i] < code[i]:
                copy_items(other, 4 * m, code, 0)
            break
    return 4 * m


@kernel
def count_added(
    count: Int32Array,
    perimeter: int,
    first: int,
    length: int,
    kind: int,
    valence: int,
) -> tuple[bool, int, int]:
    """What a strip's ends do: (are they within bounds, irregular vertices, reflex corners).

    count: quads at the border's vertices before; the strip's inner vertices are not looked
    at. The numbers are what the ends add.
    """
    a = count[first]
    if kind == OPEN and length < perimeter:
        b = count[(first + length) % perimeter]
        return max(a, b) + 1 <= valence - 2, 0, int(a == 2) + int(b == 2)
    if kind == OPEN:
        return a + 2 <= valence - 2, 0, int(a <= 2)
    now = a + 2 if kind == RING else a + 3
    return now <= valence, int(now != 4), -int(a > 2)


@kernel
def grow_patterns(most: int, valence: int, max_quads: int) -> tuple[Code, NDArray[np.int64]]:
    """All patterns that strips grow from one quad, as canonical codes.

    most: the most irregular interior vertices and reflex corners together; valence: the
    greatest of an interior vertex, two less at the boundary; max_quads: larger patterns are
    neither kept nor grown. Returns (flat uint16, (n + 1,) int64 offsets that part it).
    """
    # A pattern's border has at most 2 edges a quad and 2 more; a strip has a quad for each.
    room = WIDEST * WIDEST * max_quads + 2 * WIDEST * (max_quads + 1) + 1
    twin = np.empty(4 * room, np.int32)
    loop = np.empty(4 * room, np.int32)
    count = np.empty(4 * room, np.int32)
    code = np.empty(4 * max_quads, np.uint16)
    work = CodeWork(
        reduction_work(4 * room, room),
        np.empty(room, np.int32),
        np.empty(room, np.int32),
        np.empty(room, np.int32),
        np.empty(4 * max_quads, np.uint16),
    )
    # Row r is flat[offsets[r]:offsets[r + 1]]; row 0 is one quad, whose code is all zeros.
    table = np.full(1 << 12, -1, np.int32)
    flat = np.zeros(1 << 16, np.uint16)
    offsets = np.zeros(1 << 11, np.int64)
    offsets[1] = 4
    interior = np.zeros(1 << 11, np.int32)
    table[find_slot(flat, 4, table, flat, offsets)[0]] = 0
    n = 1
    row = 0
    while row < n:
        base = flat[offsets[row] : offsets[row + 1]].astype(np.int32) - 1
        inside = interior[row]
        _, n_reflex = write_border(base, len(base) // 4, loop, count)
        width = 1 + min(WIDEST - 1, most - inside - n_reflex)
        n_quads = widen_polychords(base, width, twin)
        perimeter, _ = write_border(twin, n_quads, loop, count)
        for first in range(perimeter):
            # The strip's inner vertices become interior ones.
            fresh = 0
            buried = 0
            for length in range(1, perimeter + 1):
                if length > 1:
                    k = count[(first + length - 1) % perimeter]
                    fresh += k != 2
                    buried += k > 2
                    # Neither falls again as the strip gets longer.
                    if k + 2 > valence or inside + n_reflex + fresh - buried > most:
                        break
                for kind in (OPEN, RING, CORNER_RING):
                    # A ring goes once round, and is the same from wherever it begins.
                    if kind != OPEN and (length < perimeter or (kind == RING and first > 0)):
                        continue
                    fits, irregular, reflex = count_added(
                        count, perimeter, first, length, kind, valence
                    )
                    inner = inside + fresh + irregular
                    if not fits or inner + n_reflex - buried + reflex > most:
                        continue
                    m = glue_strip(twin, n_quads, loop, perimeter, first, length, kind)
                    size = write_reduced_code(twin, m, max_quads, work, code)
                    unglue_strip(twin, loop, perimeter, first, length)
                    if size == 0:
                        continue
                    at, known = find_slot(code, size, table, flat, offsets)
                    if known:
                        continue
                    if offsets[n] + size > len(flat):
                        flat = np.concatenate((flat, np.zeros_like(flat)))
                    if n + 2 > len(offsets):
                        offsets = np.concatenate((offsets, np.zeros_like(offsets)))
                        interior = np.concatenate((interior, np.zeros_like(interior)))
                    copy_items(code, size, flat, offsets[n])
                    offsets[n + 1] = offsets[n] + size
                    interior[n] = inner
                    table[at] = n
                    n += 1
                    if 2 * n > len(table):
                        table = np.full(2 * len(table), -1, np.int32)
                        for r in range(n):
                            old = flat[offsets[r] : offsets[r + 1]]
                            table[find_slot(old, len(old), table, flat, offsets)[0]] = r
        row += 1
    return flat[: offsets[n]].copy(), offsets[: n + 1].copy()
