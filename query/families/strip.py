"""Strips of quads, glued onto the border of a pattern whose polychords are made wider."""

from __future__ import annotations

from patterndb.core.code import border_count
from patterndb.core.halfedge import Int32Array, next_border_edge
from patterndb.system.kernels import kernel

#: How a strip may lie: from one boundary vertex to another (or once round to itself),
#: all round, or all round with a corner quad of its own.
OPEN, RING, CORNER_RING = 0, 1, 2


@kernel
def widen(twin: Int32Array, width: int, wide: Int32Array) -> int:
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
def border(twin: Int32Array, n_quads: int, loop: Int32Array, count: Int32Array) -> tuple[int, int]:
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
def glue(
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
    loop: of :func:`border`. Returns the new number of quads. :func:`unglue` takes the
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
def unglue(twin: Int32Array, loop: Int32Array, perimeter: int, first: int, length: int) -> None:
    """Make the border what it was before :func:`glue`."""
    for i in range(length):
        twin[loop[(first + i) % perimeter]] = -1
