"""When quads are a fill's, and when two fills are the same.

A caller who has put quads together of parts, or cut them out of a mesh, has a list of quads whose
boundary vertices have the first numbers. :func:`weld` joins them to half-edges and tells whether
they are what a fill has to be. :func:`is_mesh` tells whether vertex numbers alone tell quads apart,
:func:`hash_quads` whether two fills are one, :func:`count_symmetries` which symmetries a fill has.

Different fits are different fills, with one exception: where a polychord that crosses itself is
wider than 1, its copies never collapse, and two patterns, or one in two ways, may expand to the
same fill. :func:`query.recognise.as_fill` reads the narrowest of these patterns, and lists name a
fill by it.
"""

from __future__ import annotations

import hashlib

import numpy as np

from patterndb._native.core.code import rooted_code
from patterndb._native.query.identity import read_code, weld_quads
from patterndb.core.halfedge import Int32Array
from patterndb.core.quadmesh import QuadMesh
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
            f"the quads do not use each of the vertices 0..{n_vertices - 1}; number them anew"
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
