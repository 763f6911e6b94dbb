"""Recognition: whether quads fill a boundary, which fill they are, and when two fills are the same.

A caller that has put quads together of parts, drawn them, or cut them out of a mesh, has a list of
quads whose boundary vertices have the first numbers. :func:`weld` joins them to half-edges and
checks that they are what a fill has to be; :func:`read_fill` reads them as a pattern, its widths
and orientation, the inverse of expansion. :func:`is_mesh` decides whether vertex numbers alone tell
quads apart, :func:`hash_quads` whether two fills are one, :func:`count_symmetries` counts the
symmetries of a fill.

Different fits are different fills, with one exception: where a polychord that crosses itself is
wider than 1, its copies never collapse, and two patterns, or one in two ways, may expand to the
same fill. :func:`read_fill` reads the narrowest of these patterns, and lists name a fill by it.
"""

from __future__ import annotations

import hashlib
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from patterndb._native.core.code import clockwise_start, code_starts, rooted_code
from patterndb._native.core.reduction import dissolve_straight, reduction_work
from patterndb._native.query.recognition import lengths, read_code, weld_quads
from patterndb.core.code import Code, canonical_code
from patterndb.core.halfedge import Int32Array
from patterndb.core.pattern import Pattern
from patterndb.core.quadmesh import QuadMesh
from patterndb.core.reduction import NEVER_FULL
from patterndb.errors import InvalidMeshError
from query.boundary import Boundary
from query.fill import Fill

#: What ``weld_quads`` finds wrong, by the number it returns.
FAULTS = (
    "",
    "a quad repeats a vertex",
    "two edges join the same two vertices",
    "a border edge does not run from a boundary vertex to the next, counter-clockwise",
    "the border is not the whole boundary",
    "the quads are not a disk",
)


def weld(quads: Int32Array, n_vertices: int, perimeter: int) -> Int32Array:
    """The half-edges (4q,) int32 of quads that fill a boundary.

    quads: (q, 4) int32, counter-clockwise, vertices 0..n_vertices - 1, all of them in use;
    0..perimeter - 1 run along the boundary counter-clockwise. Raises InvalidMeshError, with
    what is wrong, if the quads are not such a disk: if a quad repeats a vertex, two edges
    join the same two vertices, or the border is not that boundary.
    """
    quads = np.ascontiguousarray(quads, dtype=np.int32)
    used = np.bincount(quads.ravel(), minlength=n_vertices)
    if len(used) != n_vertices or not used.all():
        raise InvalidMeshError(
            f"the quads do not use each of the vertices 0..{n_vertices - 1}; number them again"
        )
    twin, fault = weld_quads(quads, n_vertices, perimeter)
    if fault:
        raise InvalidMeshError(f"no fill of a boundary of {perimeter} edges: {FAULTS[fault]}")
    return twin


def is_mesh(quads: Int32Array) -> bool:
    """Has every quad of (q, 4) four vertices, and do no two edges join the same two?

    Collapsing may draw two edges of a pattern together until they share both ends; only
    where a polychord across them is wider than 1 does such a pattern expand to a mesh.
    """
    corners = np.sort(quads, axis=1)
    # Two edges between the same vertices have two half-edges that run the same way.
    heads = np.roll(quads, -1, axis=1)
    edges = np.sort((quads.astype(np.int64) << 32 | heads).ravel())
    return bool((corners[:, 1:] != corners[:, :-1]).all() and (edges[1:] != edges[:-1]).all())


def hash_fill(fill: Fill, closed: bool) -> bytes:
    """Hash a fill: see :func:`hash_quads`."""
    twin, _ = weld_quads(fill.quads, fill.n_vertices, fill.perimeter)
    return hash_quads(fill.quads, twin, closed)


def hash_quads(quads: Int32Array, twin: Int32Array, closed: bool) -> bytes:
    """Hash quads, such that equal fills of one boundary, and only those, have equal hashes.

    quads: (q, 4), twin: (4q,) their half-edges. A digest of the code as read from boundary
    vertex 0. A closed side has no first vertex: there it is the smallest code from any.
    """
    return hashlib.blake2b(read_code(quads, twin, closed).tobytes(), digest_size=16).digest()


def read_fill(quads: ArrayLike, boundary: Boundary, origin: str) -> Fill:
    """Return the fill that quads of a boundary are.

    quads: (q, 4) whole numbers, counter-clockwise; vertices 0..P - 1 are the boundary's in
    its order, interior ones follow without a gap. origin: where they come from, kept with
    the fill and its pattern. Expanding the fill's pattern with its widths, turned as it
    says, gives the same quads but for the numbers of the interior vertices. The pattern is
    what reduction leaves, where copies of a polychord that crosses itself become one, too: no
    other pattern expands to these quads with fewer. Its corners are those of the quads, not the
    boundary's. A pattern that is symmetric is read with the least rotation.

    Raises InvalidMeshError if the quads do not fill the boundary, InvalidCodeError if the
    pattern has more quads than a code can name.
    """
    array = np.ascontiguousarray(quads, dtype=np.int32)
    if array.ndim != 2 or array.shape[1] != 4 or not array.size or array.min() < 0:
        raise InvalidMeshError("quads must be (q, 4) vertex numbers >= 0, q >= 1")
    n_vertices = int(array.max()) + 1
    twin = weld(array, n_vertices, boundary.perimeter)
    return read_welded_fill(array, n_vertices, twin, boundary, origin)


def read_welded_fill(
    quads: Int32Array, n_vertices: int, twin: Int32Array, boundary: Boundary, origin: str
) -> Fill:
    """As :func:`read_fill`, for quads already welded: ``twin`` (4q,) is :func:`weld`'s answer."""
    perimeter = boundary.perimeter
    count = count_quads(quads, n_vertices)
    inner, outer = count_irregular(count, boundary)
    reduced, head, length = _reduced_with_lengths(quads, twin, count, perimeter)
    code, mirrored, _, _ = canonical_code(reduced)
    pattern = Pattern.from_trusted_code(code, origin=origin)
    of_edge = pattern.polychords().of_edge
    strict = outer == 0 and pattern.n_sides > 0
    found: list[tuple[int, tuple[int, ...]]] = []
    for of_half_edge in _list_readings(reduced, code, mirrored):
        along = length[of_half_edge]
        widths = np.empty(pattern.n_chords + pattern.n_loops, np.int64)
        widths[of_edge] = along
        # The half-edge of the quads where the pattern's boundary begins. In the mirror the
        # pattern begins where that edge ends.
        at = int(quads.ravel()[head[of_half_edge[0]]])
        first = (at + int(along[0]) if mirrored else -at) % perimeter
        sides = [int(widths[list(side)].sum()) for side in pattern.label]
        found.append((_rotation(sides, first, mirrored, strict), tuple(widths.tolist())))
    rotation, widths = min(found)
    return Fill(
        quads=quads,
        n_vertices=n_vertices,
        lengths=boundary.lengths,
        pattern=pattern,
        widths=widths,
        rotation=rotation,
        mirrored=mirrored,
        n_irregular=inner + outer,
        origin=origin,
        n_irregular_boundary=outer,
    )


def reread_fill(fill: Fill, boundary: Boundary) -> Fill:
    """Return a fill with the pattern, widths and orientation that :func:`read_fill` reads.

    A fill has several names where its pattern is symmetric, or is one that crosses itself, widened:
    whoever gets the quads alone is to find the same.
    """
    found = read_fill(fill.quads, boundary, fill.origin)
    pattern = fill.pattern
    if found.pattern != pattern:
        pattern = replace(found.pattern, frequency=pattern.frequency)
    return replace(
        fill,
        pattern=pattern,
        widths=found.widths,
        rotation=found.rotation,
        mirrored=found.mirrored,
    )


def count_quads(quads: Int32Array, n_vertices: int) -> Int32Array:
    """(n_vertices,) int32: the number of quads at every vertex."""
    return np.bincount(quads.ravel(), minlength=n_vertices).astype(np.int32)


def count_asked_quads(boundary: Boundary, n_vertices: int) -> Int32Array:
    """(n_vertices,) int32: the number of quads that the place of every vertex asks for.

    2 on a side, 1 at a convex corner, 3 at a reflex one; 4 inside, for the vertices that
    follow the boundary's.
    """
    asked = np.full(n_vertices, 4, np.int32)
    asked[: boundary.perimeter] = 2
    if boundary.n_sides:
        asked[list(boundary.side_starts[:-1])] = boundary.corner_counts
    return asked


def count_irregular(count: Int32Array, boundary: Boundary) -> tuple[int, int]:
    """How many (interior, boundary) vertices have not as many quads as their place asks for.

    count: (n_vertices,) quads at every vertex, the boundary's first.
    """
    off = count != count_asked_quads(boundary, len(count))
    outer = int(np.count_nonzero(off[: boundary.perimeter]))
    return int(np.count_nonzero(off)) - outer, outer


def _reduced_with_lengths(
    quads: Int32Array, twin: Int32Array, count: Int32Array, perimeter: int
) -> tuple[Int32Array, Int32Array, Int32Array]:
    """The pattern's half-edges, and for each the half-edge of the quads at which it begins
    and how many of them it stands for; each (4m,) int32."""
    q = len(quads)
    full = count.copy()
    full[:perimeter] = NEVER_FULL
    work = reduction_work(len(count), q)
    m = dissolve_straight(q, twin, quads.ravel(), count, full, work)[0]
    head = work.head[: 4 * m].copy()
    return work.reduced[: 4 * m].copy(), head, lengths(twin, head)


def _list_readings(reduced: Int32Array, code: Code, mirrored: bool) -> list[Int32Array]:
    """List the ways in which a reduced disk reads as its code, one for each of its symmetries:
    (4m,) int32, which half-edge of the disk each of the pattern's is."""
    m = len(reduced) // 4
    starts = np.empty(4 * m, np.int32)
    n_starts = code_starts(reduced, starts)
    number, entry, order = (np.empty(m, np.int32) for _ in range(3))
    step = 3 if mirrored else 1
    found: list[Int32Array] = []
    for start in starts[:n_starts].tolist():
        begin = clockwise_start(reduced, start) if mirrored else start
        if rooted_code(reduced, m, begin, mirrored, code, number, entry, order, True) == 0:
            edges = (entry[:, None] + step * np.arange(4)) & 3
            found.append((4 * order[:, None] + edges).ravel().astype(np.int32))
    return found


def _rotation(sides: list[int], first: int, mirrored: bool, strict: bool) -> int:
    """The fill's rotation, where boundary vertex 0 is vertex ``first`` of the expanded
    pattern's boundary: in sides if strict, else in edges."""
    if not strict:
        return (first - mirrored) % sum(sides)
    corner = np.r_[0, np.cumsum(sides)].tolist().index(first)
    return (corner - mirrored) % len(sides)


def count_symmetries(fill: Fill, boundary: Boundary) -> int:
    """Count the rotations and reflections of the boundary that map the fill onto itself: 1 or more.

    A rotation or reflection of the boundary takes sides to sides of the same length, and
    corners to corners of the same kind; of a closed side it is any.
    """
    mesh = QuadMesh.from_quads(fill.quads)
    border = np.flatnonzero(mesh.twin < 0)
    tails = fill.quads.ravel()[border]
    at = np.empty(fill.perimeter, np.int64)
    at[tails] = border
    q = fill.n_quads
    codes = [np.zeros(4 * q, np.int32), np.zeros(4 * q, np.int32)]
    number, entry, order = (np.empty(q, np.int32) for _ in range(3))

    def code(vertex: int, mirrored: bool, into: int) -> None:
        # Mirrored, the fill is read from the edge that ends at the vertex.
        start = at[(vertex - 1) % fill.perimeter] if mirrored else at[vertex]
        rooted_code(
            mesh.twin,
            q,
            int(start),
            mirrored,
            codes[into],  # pyright: ignore[reportArgumentType]
            number,
            entry,
            order,
            False,
        )

    code(0, False, 0)
    count = 0
    for vertex, mirrored in _boundary_symmetries(boundary):
        code(vertex, mirrored, 1)
        count += bool(np.array_equal(codes[0], codes[1]))
    return count


def _boundary_symmetries(boundary: Boundary) -> list[tuple[int, bool]]:
    """The vertices from which the boundary reads as from vertex 0, either way round."""
    n = boundary.n_sides
    if n == 0:
        return [(v, m) for v in range(boundary.perimeter) for m in (False, True)]
    lengths, kinds, starts = boundary.lengths, boundary.corners, boundary.side_starts
    found: list[tuple[int, bool]] = []
    for turn in range(n):
        ahead = [(turn + s) % n for s in range(n)]
        if all((lengths[a], kinds[a]) == (lengths[s], kinds[s]) for s, a in enumerate(ahead)):
            found.append((starts[turn], False))
        if all(
            (lengths[(turn - 1 - s) % n], kinds[(turn - s) % n]) == (lengths[s], kinds[s])
            for s in range(n)
        ):
            found.append((starts[turn], True))
    return found
