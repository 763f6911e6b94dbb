"""The bridge from loops to the pattern database: quads within a loop, placed on its patch."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from patterndb.errors import InvalidBoundaryError, InvalidMeshError
from patterndb.geometry.points import Points
from patterndb.geometry.quadshape import find_turned_corners
from patterndb_sketch.curvenetwork.network import InvalidNetworkError
from patterndb_sketch.curvenetwork.polylines import measure_angles
from patterndb_sketch.surfacing.sampling import Loop
from query import Fill, fills
from query.boundary import Boundary, CornerKind
from query.engine import PatternSource
from query.placing import Placement, Region, Surface, lay_flat, place, quality

#: Fills that the squarest is chosen from, the first in the order of what artists did.
POOL = 20

#: What a further irregular vertex must gain in quality, in the radians squared of
#: :func:`query.placing.quality`: every angle 9 degrees nearer to a right one.
PRICE_OF_IRREGULAR = 0.1

#: Of the fills chosen from, so many are placed until one has no flipped quad and no turned corner.
PLACED = 4

#: Interior angles in radians at which a fill has as poor quads with a corner as without: half way
#: between one quad, square at 90 degrees, and two, at 180; and between two and three, at 270.
CONVEX_BELOW = math.radians(135)
REFLEX_ABOVE = math.radians(225)


@dataclass(frozen=True, slots=True)
class QuadPatch:
    """Quads within a loop of n vertices.

    points:      (k, 3) float64, the vertices inside.
    quads:       (f, 4) int64, in the loop's sense. An index below n is a position in the loop,
                 n + i is row i of ``points``. They make a disk with the loop as its boundary.
    pattern:     the name of the fill's pattern.
    origin:      where that is from, as :class:`query.Fill` has it.
    n_irregular: vertices, inside and on the loop, whose number of quads is not what their place
                 asks for.
    n_flipped:   quads that lie upside down on the patch, or cross themselves.
    n_turned:    quads with a corner of more than 180 degrees, see
                 :func:`patterndb.geometry.quadshape.find_turned_corners`.
    note:        what a user should know of it; "" if there is nothing to say.
    """

    points: Points = field(repr=False)
    quads: NDArray[np.int64] = field(repr=False)
    pattern: str
    origin: str
    n_irregular: int
    n_flipped: int
    n_turned: int
    note: str


def fill_with_quads(
    db: PatternSource, loop: Loop, points: Points, triangles: NDArray[np.integer]
) -> QuadPatch:
    """The loop filled by the pattern database, its quads on the patch given.

    points: (v, 3) float64, the loop's n first; triangles: (t, 3) a disk within the loop, in the
    loop's sense. Vertices inside lie on it; those of the loop stay as they are.

    Of the first POOL fills in the order of what artists did (:func:`query.fills`) the one whose
    quads are squarest over the loop, an irregular vertex more counting as PRICE_OF_IRREGULAR;
    the next ones if it has flipped quads or turned corners once it is placed.

    Raises InvalidNetworkError, saying why, where no quads can fill the loop, and for triangles
    that do not fill it in its sense.
    """
    _refuse_unless_within(loop, triangles)
    boundary, start = boundary_of(loop, points, triangles)
    try:
        region = _region(len(loop.points), points, triangles, start)
    except InvalidMeshError as error:
        raise InvalidNetworkError(f"the loop's patch cannot carry quads: {error}") from error
    fill, placed, n_turned = _best(db, boundary, region)
    n, inner = boundary.perimeter, fill.n_vertices - boundary.perimeter
    position = np.r_[(np.arange(n) + start) % n, n + np.arange(inner)].astype(np.int64)
    notes: list[str] = []
    if len(placed.flipped):
        notes.append(f"{len(placed.flipped)} of {fill.n_quads} quads are flipped")
    if n_turned:
        notes.append(f"{n_turned} of {fill.n_quads} quads have a turned corner")
    if not placed.at_rest:
        notes.append("smoothing of the quads on their patch was broken off")
    return QuadPatch(
        np.ascontiguousarray(placed.vertices[n:]),
        position[fill.quads],
        fill.pattern.name,
        fill.origin,
        fill.n_irregular,
        len(placed.flipped),
        n_turned,
        "; ".join(notes),
    )


def _best(db: PatternSource, boundary: Boundary, region: Region) -> tuple[Fill, Placement, int]:
    """The fill, where it lies, and how many of its quads have a turned corner there."""
    pool = list(fills(db, boundary, limit=POOL, order="artist"))
    at = boundary.points
    assert pool and at is not None, "every boundary of even length has a fill"
    costs = [
        quality(fill.quads, lay_flat(fill, at)) + PRICE_OF_IRREGULAR * fill.n_irregular
        for fill in pool
    ]
    tried: list[tuple[Fill, Placement, int]] = []
    for i in islice(np.argsort(costs, kind="stable").tolist(), PLACED):
        placed = place(pool[i], at, region)
        turned = int(find_turned_corners(pool[i].quads, placed.vertices).any(axis=1).sum())
        tried.append((pool[i], placed, turned))
        if not len(placed.flipped) and not turned:
            break
    # The first of equals.
    return min(tried, key=lambda one: (len(one[1].flipped), one[2]))


def _region(n: int, points: Points, triangles: NDArray[np.integer], start: int) -> Region:
    """The patch as what its loop encloses, without a search for what that is."""
    surface = Surface.from_arrays(points, triangles)
    rim = surface.border_sides
    tail = surface.triangles.ravel()[rim]
    head = np.roll(surface.triangles, -1, axis=1).ravel()[rim]
    outer = (tail < n) & (head < n)
    rim, tail, head = rim[outer], tail[outer], head[outer]
    # Where around the loop its edges lie, as angles: a triangle with two of them is between.
    middle = tail - start + (head - tail) % n / 2.0
    turn = np.zeros(len(surface.triangles), np.complex128)
    np.add.at(turn, rim // 3, np.exp(2j * np.pi * middle / n))
    around = np.where(turn != 0.0, np.angle(turn) / (2.0 * np.pi) % 1.0 * n, np.nan)
    return Region(surface, 1.0, around, True, np.ones(len(around), np.bool_))


def _refuse_unless_within(loop: Loop, triangles: NDArray[np.integer]) -> None:
    n = len(loop.points)
    tail, head = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    along = tail[(tail < n) & (head == (tail + 1) % n)]
    missing = np.setdiff1d(np.arange(n), along)
    if len(missing):
        raise InvalidNetworkError(
            f"the triangles have no edge from vertex {missing[0]} of the loop to the next; they "
            "must fill the loop, counter-clockwise in its sense"
        )


def measure_interior_angles(
    n: int, points: Points, triangles: NDArray[np.integer]
) -> NDArray[np.float64]:
    """(n,) the angle inside a patch at each of its n boundary vertices, in radians, from 0 on.

    points: (v, 3), the boundary's first. triangles: (t, 3) of the patch. The angle is the sum of
    the triangles' there: it is measured along the surface, so that no plane need be chosen for
    a loop that has none.
    """
    corner = points[triangles]
    angle = np.zeros(len(points))
    for e in range(3):
        out, back = corner[:, (e + 1) % 3] - corner[:, e], corner[:, (e + 2) % 3] - corner[:, e]
        np.add.at(angle, triangles[:, e], measure_angles(out, back))
    return angle[:n]


def find_sides(
    loop: Loop, points: Points, triangles: NDArray[np.integer]
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Find the corners between the sides of a loop of n vertices: (n,) convex, (n,) reflex.

    points: (v, 3), the loop's first; triangles: (t, 3), a patch within the loop. A corner of the
    loop is one here if its interior angle is below CONVEX_BELOW or above REFLEX_ABOVE.

    Not every turning by more than 20 degrees, which chords take for a corner, is one here: a turn
    by 25 degrees leaves a single quad with an angle of 155 where two have 77 each. The bounds lie
    half way between what suits one, two and three quads.
    """
    angle = measure_interior_angles(len(loop.points), points, triangles)
    return loop.corners & (angle < CONVEX_BELOW), loop.corners & (angle > REFLEX_ABOVE)


def boundary_of(loop: Loop, points: Points, triangles: NDArray[np.integer]) -> tuple[Boundary, int]:
    """The boundary that a fill of the loop has, and the position in the loop where it begins.

    points: (v, 3), the loop's first; triangles: (t, 3), a patch within the loop. Boundary
    vertex i is position (start + i) % n of the loop, in the loop's sense. Its corners are those
    that :func:`find_sides` finds; a loop without any is one closed side, which fills have a ring of
    quads along.

    Raises InvalidNetworkError, saying what would mend it, for loops that no quads can fill: with
    an odd number of vertices, fewer than 4, or more than 2,000.
    """
    n = len(loop.points)
    convex, reflex = find_sides(loop, points, triangles)
    at = np.flatnonzero(convex | reflex)
    try:
        if not len(at):
            return Boundary.closed(n, loop.points), 0
        lengths = np.diff(np.r_[at, at[0] + n])
        kinds: list[CornerKind] = ["convex" if convex[i] else "reflex" for i in at]
        start = int(at[0])
        return Boundary(lengths.tolist(), kinds, np.roll(loop.points, -start, axis=0)), start
    except InvalidBoundaryError as error:
        raise InvalidNetworkError(f"no quads can fill a loop of {n} vertices: {error}") from error
