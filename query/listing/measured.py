"""What is measured on whole fills, for the orders that need it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from patterndb.core.code import rooted_code
from patterndb.core.quadmesh import QuadMesh
from query.boundary import Boundary
from query.fill import Fill
from query.listing.ranking import Order
from query.stroke import Stroke


def measured(
    order: Order, fill: Fill, boundary: Boundary, strokes: Sequence[Stroke], tolerance: int
) -> tuple[float, Fill]:
    """A number by which the fill is sorted, smallest first, and the fill with what was found.

    "flow": the distance of the strokes to their strands (Marcias et al. 2015, section 4,
    "Sorting"), after a first placing; "quality": the squared deviation of the quads' angles from
    90 degrees, likewise; "small": the quads; "symmetric": the symmetries of the boundary that
    the fill has too, the most first.
    """
    if order == "small":
        return float(fill.n_quads), fill
    if order == "symmetric":
        return -float(symmetries(fill, boundary)), fill
    # Imported here because placing needs scipy, which other orders need not wait for.
    from query.placing import flow_distance, laid, quality

    assert boundary.points is not None, "the engine refuses these orders without points"
    vertices = laid(fill, boundary.points)
    if order == "quality":
        return quality(fill.quads, vertices), fill
    drawn = [stroke for stroke in strokes if stroke.points is not None]
    distance = flow_distance(fill, vertices, drawn, tolerance)
    return distance, replace(fill, flow_distance=distance)


def symmetries(fill: Fill, boundary: Boundary) -> int:
    """How many rotations and reflections of the boundary map the fill onto itself, at least 1.

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
