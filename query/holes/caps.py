"""Caps: is what belongs in a hole flat, or does the surface go on smoothly across it?

A tube's end, a missing side of a box and the base of a figure have flat faces; a hole in a cheek
has not. Only the mesh outside the boundary is looked at: whether the boundary is planar, at which
angles the faces outside leave its plane, and whether they bend towards a dome.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats
from patterndb.geometry.quadshape import NO_AREA
from query.holes.loops import Hole
from query.holes.options import Shape
from query.holes.regular import build_regular_fill
from query.holes.topology import MeshTopology


@dataclass(frozen=True, slots=True, eq=False)
class RimPlane:
    """The least-squares plane of a boundary.

    centre: (3,) the mean of its vertices. normal: (3,) unit, such that the boundary runs
    counter-clockwise. diameter: the greatest distance between two of its vertices.
    off: the greatest distance of a vertex from the plane, as a part of the diameter.
    """

    centre: Floats
    normal: Floats
    diameter: float
    off: float

    @classmethod
    def of(cls, points: Floats) -> RimPlane:
        """The plane of a boundary (L, 3)."""
        centre = points.mean(axis=0)
        spokes = points - centre
        normal = np.linalg.svd(spokes, full_matrices=False)[2][2]
        area = np.cross(spokes, np.roll(spokes, -1, axis=0)).sum(axis=0)
        if area @ normal < 0:
            normal = -normal
        squares = (spokes * spokes).sum(axis=1)
        apart = squares[:, None] + squares[None] - 2 * (spokes @ spokes.T)
        diameter = float(np.sqrt(max(apart.max(), 0.0)))
        off = float(np.abs(spokes @ normal).max())
        return cls(centre, normal, diameter, off / diameter if diameter > 0 else 0.0)

    def measure_area(self, points: Floats) -> float:
        """Measure the area that a boundary (L, 3) has in the plane."""
        spokes = points - self.centre
        area = np.cross(spokes, np.roll(spokes, -1, axis=0)).sum(axis=0)
        return float(area @ self.normal) / 2

    def measure_radius(self, points: Floats) -> float:
        """Measure twice the area of a boundary (L, 3) by its length, a circle's radius."""
        length = float(np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1).sum())
        return 2 * self.measure_area(points) / length if length > 0 else 0.0

    def project(self, points: Floats) -> Floats:
        """The nearest points (k, 3) of the plane."""
        return points - np.outer((points - self.centre) @ self.normal, self.normal)


@dataclass(frozen=True, slots=True, eq=False)
class OuterSlopes:
    """How the faces outside leave the plane of a boundary.

    angle: (e,) radians from the plane, outwards, to the face at each edge that has one: 0 goes on
           in the plane, pi / 2 leaves it at a right angle, more leads back below the hole. Most of
           them are positive.
    turn:  (e,) radians by which the next face away from the hole leaves it at a greater angle; nan
           where there is none. depth: (e,) the distance between the middles of the two faces.
    """

    angle: Floats
    turn: Floats
    depth: Floats


def measure_walls(hole: Hole, plane: RimPlane) -> OuterSlopes:
    """Measure the faces outside at the edges of a hole, and those behind them."""
    t = hole.topology
    points = t.mesh.points
    edges = hole.edges[hole.edges >= 0]
    # The edge outside runs clockwise.
    outward = np.cross(plane.normal, points[t.head[edges]] - points[t.tail[edges]])
    size = np.linalg.norm(outward, axis=1)
    edges, outward, size = edges[size > 0], outward[size > 0], size[size > 0]
    outward /= size[:, None]
    angle, middle = _leave_plane(t, edges, plane, outward)
    # Behind a quad, unless the hole replaces what is there.
    opposite = t.twin[t.next[t.next[edges]]]
    face = t.face[edges]
    behind = (opposite >= 0) & (t.start[face + 1] - t.start[face] == 4)
    behind &= ~np.isin(t.face[opposite], hole.removed)
    turn, depth = np.full(len(edges), np.nan), np.full(len(edges), np.nan)
    next_angle, next_middle = _leave_plane(t, opposite[behind], plane, outward[behind])
    turn[behind] = (next_angle - angle[behind] + np.pi) % (2 * np.pi) - np.pi
    depth[behind] = np.linalg.norm(next_middle - middle[behind], axis=1)
    if len(angle) and np.sin(angle).mean() < 0:
        angle, turn = -angle, -turn
    return OuterSlopes(angle, turn, depth)


def _leave_plane(
    topology: MeshTopology, edges: Int32Array, plane: RimPlane, outward: Floats
) -> tuple[Floats, Floats]:
    """(e,) angles at which the faces of half-edges leave a plane, and (e, 3) their middles."""
    t, points = topology, topology.mesh.points
    face = t.face[edges]
    size = t.start[face + 1] - t.start[face]
    row = np.repeat(np.arange(len(edges)), size)
    corner = np.arange(len(row)) - np.repeat(np.cumsum(size) - size, size) + t.start[face][row]
    middle = np.zeros((len(edges), 3))
    np.add.at(middle, row, points[t.tail[corner]])
    middle /= size[:, None]
    a, b = points[t.tail[edges]], points[t.head[edges]]
    along = b - a
    into = middle - (a + b) / 2
    part = (into * along).sum(axis=1) / np.maximum((along * along).sum(axis=1), 1e-300)
    into -= along * part[:, None]
    return np.arctan2(-into @ plane.normal, (into * outward).sum(axis=1)), middle


#: A boundary this near to its plane, as a part of its diameter, is planar; one this near where all
#: faces outside leave its plane steeply, by STEEP radians on either side. By benchmarks/caps.py, as
#: the numbers below.
PLANAR, NEARLY_PLANAR, STEEP = 0.01, 0.04, np.radians(45.0)

#: A face outside that leaves the plane by less, in radians, may go on in it: such a hole is one in
#: a flat part of a mesh, and what its boundary and the faces outside ask for is ranked as ever.
APART = np.radians(20.0)

#: Where a dome meets the plane, it leaves it at these angles, in radians.
DOME_ANGLES = (np.radians(3.0), np.radians(110.0))

#: A dome has no crease: the next face turns by at most this, in radians; and by about as much at
#: all edges: the mean is this many times the standard deviation.
DOME_TURN, DOME_EVEN = np.radians(40.0), 3.0

#: A sphere's curvature, times the radius of the boundary, is the sine of the angle at which faces
#: leave the plane. That of a dome is this many times as much, at least and at most.
DOME_ROUND = (0.5, 2.0)


@dataclass(frozen=True, slots=True, eq=False)
class FlatCap:
    """Where a flat fill lies. apart: does the boundary alone show what belongs there? All faces
    outside leave the plane, or all of them are one, as around a window in the wall of a plan."""

    plane: RimPlane
    apart: bool


def find_cap(hole: Hole, shape: Shape = "auto") -> FlatCap | None:
    """Where the fills of a hole are to lie flat; None where they go on smoothly."""
    if shape == "smooth":
        return None
    points = hole.points
    plane = RimPlane.of(points)
    slit = plane.measure_area(points) <= NO_AREA * plane.diameter**2
    if shape == "auto" and (slit or plane.off > NEARLY_PLANAR):
        return None
    walls = measure_walls(hole, plane)
    least = float(np.abs(np.sin(walls.angle)).min()) if len(walls.angle) else 0.0
    is_flat = plane.off <= PLANAR or least >= np.sin(STEEP)
    if shape == "auto" and (not is_flat or _is_dome(walls, plane.measure_radius(points))):
        return None
    outside = hole.topology.face[hole.edges[hole.edges >= 0]]
    within_one = len(outside) > 0 and bool((outside == outside[0]).all())
    return FlatCap(plane, within_one or least >= np.sin(APART))


def _is_dome(walls: OuterSlopes, radius: float) -> bool:
    """Do the faces outside bend as those of a sphere that closes over the hole?"""
    known = np.isfinite(walls.turn)
    if 2 * int(known.sum()) < len(known) or not known.any():
        return False
    turn = float(walls.turn[known].mean())
    # At the boundary, half a turn before the middle of the faces.
    angle = float(walls.angle.mean()) - turn / 2
    if not DOME_ANGLES[0] <= angle <= DOME_ANGLES[1] or not 0 < turn <= DOME_TURN:
        return False
    if DOME_EVEN * float(walls.turn[known].std()) > turn:
        return False
    depth = float(walls.depth[known].mean())
    return DOME_ROUND[0] <= turn / max(depth, 1e-300) * radius / np.sin(angle) <= DOME_ROUND[1]


#: A boundary turns at a vertex whose angle, in its plane, is off a straight one by more than TURN;
#: it is convex where none turns back by more than BACK radians.
TURN, BACK = np.radians(65.0), np.radians(20.0)

#: 4 pi times the area of a round boundary, by the square of its length, is at least this.
ROUND = 0.8

#: What the squared logarithm of the ratio of two sides of a grid weighs against squared radians at
#: the vertices of the boundary; and of a round one, where some turn a little more than others.
EQUAL_SIDES, EQUAL_SIDES_ROUND = 0.25, 10.0

#: Costs of grids nearer than this are equal: rounding and a turned mesh choose no other grid.
ALIKE = 1e-6

#: Fewest edges around for a ring of quads along the boundary, and for two.
ONE_RING, TWO_RINGS = 8, 16


def list_cap_quads(loop: Floats, plane: RimPlane, mirrors: Int32Array) -> list[Int32Array]:
    """Quads (q, 4) that artists put into a flat cap, likeliest first.

    loop: (L, 3), L even. mirrors: of the loop, see :func:`query.holes.symmetry.find_mirrors`; a
    grid follows one where it can.
    Where the boundary turns back, as that of an L does: quads without irregular vertices inside,
    with corners where it turns. Elsewhere a grid whose four corners are where the boundary turns,
    on a round one where its sides are most equal; and on a round one a ring of quads around a grid,
    a ring around a pole, and two rings around a grid. Vertices of the loop are 0..L-1, inner ones
    follow. The list is empty where these do not fit, as where there are three sharp corners.
    """
    n = len(loop)
    angles = _measure_angles(loop, plane)
    sharp = int((np.pi - angles > TURN).sum())
    if n % 2 or n < 4:
        return []
    if (angles - np.pi > BACK).any():
        turns = (np.pi - angles > TURN).astype(np.int32) - (angles - np.pi > TURN)
        made = build_regular_fill(2 - turns)
        return [] if made is None else [made[0]]
    if sharp == 3 or sharp > 4:
        return []
    after = np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1)
    is_round = sharp == 0
    is_round &= 4 * np.pi * plane.measure_area(loop) >= ROUND * float(after.sum()) ** 2
    grid = _choose_grid(angles, after, is_round, mirrors)
    found = [_make_rings(n, 0, grid)]
    if is_round:
        if n >= ONE_RING:
            found.append(_make_rings(n, 1, grid))
        if n > ONE_RING:
            found.append(_make_rings(n, 1, None))
        if n >= TWO_RINGS:
            found.append(_make_rings(n, 2, grid))
    return found


def _measure_angles(loop: Floats, plane: RimPlane) -> Floats:
    """(L,) angles of a boundary in its plane, 0 to 2 pi."""
    flat = plane.project(loop)
    after = np.roll(flat, -1, axis=0) - flat
    before = np.roll(flat, 1, axis=0) - flat
    sine = np.cross(after, before) @ plane.normal
    return np.arctan2(sine, (after * before).sum(axis=1)) % (2 * np.pi)


def _choose_grid(
    angles: Floats, after: Floats, is_round: bool, mirrors: Int32Array
) -> tuple[int, int]:
    """The first corner of the grid that fits a boundary best, and the edges of its first side.

    angles: (L,) of the boundary. after: (L,) lengths of its edges.
    """
    weight = EQUAL_SIDES_ROUND if is_round else EQUAL_SIDES
    n = len(angles)
    gain = (angles - np.pi / 2) ** 2 - (angles - np.pi) ** 2
    along = np.concatenate([[0.0], np.cumsum(np.tile(after, 2))])
    start = np.arange(n)
    best, least, followed = (0, 1), np.inf, False
    for a in range(1, n // 2):
        ends = np.array([start, start + a, start + n // 2, start + n // 2 + a, start + n])
        sides = np.log(np.maximum(np.diff(along[ends], axis=0), 1e-12 * along[-1]))
        ratios = (sides[0] - sides[2]) ** 2 + (sides[1] - sides[3]) ** 2
        ratios += (sides[0] + sides[2] - sides[1] - sides[3]) ** 2 / 4
        corners = ends[:4] % n
        cost = gain[corners].sum(axis=0) + weight * ratios
        follows = np.zeros(n, np.bool_)
        for s in mirrors.tolist():
            follows |= (np.sort((s - corners) % n, axis=0) == np.sort(corners, axis=0)).all(axis=0)
        if follows.any():
            cost[~follows] = np.inf
        at = int(np.flatnonzero(cost <= cost.min() + ALIKE)[0])
        if (follows[at], -cost[at]) > (followed, -(least - ALIKE)):
            best, least, followed = (at, a), float(cost[at]), bool(follows[at])
    return best


def _make_rings(n: int, rings: int, grid: tuple[int, int] | None) -> Int32Array:
    """Rings of quads along a loop of n edges, and a grid within, or quads around a pole."""
    quads: list[tuple[int, int, int, int]] = []
    for ring in range(rings):
        out, into = ring * n, (ring + 1) * n
        for i in range(n):
            j = (i + 1) % n
            quads.append((out + i, out + j, into + j, into + i))
    first, new = rings * n, (rings + 1) * n
    if grid is None:
        quads += [(first + i, first + i + 1, first + (i + 2) % n, new) for i in range(0, n, 2)]
        return np.array(quads, np.int32)
    start, a = grid
    b = n // 2 - a
    number: dict[tuple[int, int], int] = {}
    around = [(i, 0) for i in range(a)] + [(a, j) for j in range(b)]
    around += [(a - i, b) for i in range(a)] + [(0, b - j) for j in range(b)]
    for k, place in enumerate(around):
        number[place] = first + (start + k) % n
    for i in range(1, a):
        for j in range(1, b):
            number[i, j] = new
            new += 1
    for i in range(a):
        for j in range(b):
            corners = ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))
            p, q, r, s = (number[corner] for corner in corners)
            quads.append((p, q, r, s))
    return np.array(quads, np.int32)
