"""Flat drawings of disks: where to put every vertex so that one can read the quads.

Boundary on a strictly convex outline, interior by Tutte's barycentric map (Tutte 1963),
then relaxed for shape. Tutte's map draws every face convex only where the graph is
3-connected; quad disks often are not (an interior vertex of valence 2 suffices), so the
relaxation untangles, too. A disk with reflex corners is then let go of its convex outline,
and bends inward at them as far as no quad flips and the outline does not cross itself.
"""

# scipy has no types: what it returns is typed by the functions' own annotations.
# pyright: reportMissingTypeStubs=false, reportUnknownVariableType=false
# pyright: reportUnknownMemberType=false, reportUnknownArgumentType=false

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array
from scipy.sparse.linalg import spsolve

from patterndb._native.geometry.relaxation import relax_points
from patterndb.core.disk import Disk
from patterndb.geometry.points import Points

Complex = NDArray[np.complex128]

# Where a flat picture puts a disk's boundary: a polygon with one bulging edge per side.
#
# The outline is strictly convex, so that Tutte's theorem has its hypothesis and no quad on
# a side is squeezed flat: sides are shallow arcs, not straight lines. Three corners and more
# give a polygon inscribed in a circle; two a lens; one a teardrop; none a circle.

#: How far a side turns from end to end, in radians: enough to be strictly convex, too
#: little to be taken for a curve.
SIDE_TURN = math.radians(14.0)

#: The same for the two sides of a lens.
LENS_TURN = math.radians(105.0)

#: Sides are drawn as long as this power of their number of edges: 0 would draw a regular
#: polygon, 1 the true proportions, in which a side of one edge beside one of 20 is lost.
LENGTH_POWER = 0.5

#: No side is drawn longer than this part of all the others together (the triangle
#: inequality wants < 1; near 1 the polygon is a sliver).
LONGEST_SIDE = 0.7

#: Every cut takes two long sides and a short one three tenths of the way to their limit.
MOST_CUTS = 200


@dataclass(frozen=True, slots=True)
class Outline:
    """The boundary as complex-linear combinations of a few handles.

    handles: (k,) complex128 points: the N corners, then one control point per side, which
             is a quadratic Bezier arc; where N < 2 all boundary vertices.
    ends:    (P, 3) int32 the handles that a boundary vertex hangs on.
    weights: (P, 3) float64; vertex j lies at the sum of weights[j] * handles[ends[j]].
    """

    handles: NDArray[np.complex128]
    ends: NDArray[np.int32]
    weights: NDArray[np.float64]

    def points(self) -> NDArray[np.complex128]:
        """(P,) complex128 boundary vertices."""
        return (self.weights * self.handles[self.ends]).sum(axis=1)


def make_outline(disk: Disk) -> Outline:
    """Make the strictly convex outline, counter-clockwise, side 0 at the bottom."""
    n = disk.n_sides
    if n < 2:
        points = _teardrop(disk) if n == 1 and disk.corner_counts()[0] == 1 else _circle(disk)
        count = np.arange(len(points), dtype=np.int32)
        weights = np.tile(np.array([1.0, 0.0, 0.0]), (len(points), 1))
        return Outline(points, np.stack([count] * 3, axis=1), weights)
    if n == 2:
        corners, turn = np.array([-1.0 + 0.0j, 1.0 + 0.0j]), LENS_TURN
    else:
        corners, turn = _inscribed(_drawn_lengths(disk.side_lengths())), SIDE_TURN
        corners *= np.exp(-1j * np.angle(corners[1] - corners[0]))
    chords = np.roll(corners, -1) - corners
    controls = corners + chords * (0.5 - 0.5j * math.tan(turn / 2.0))
    ends = np.empty((disk.perimeter, 3), np.int32)
    weights = np.empty((disk.perimeter, 3))
    for s, side in enumerate(disk.sides()):
        t = np.linspace(0.0, 1.0, len(side))[:-1]
        ends[side[:-1]] = s, n + s, (s + 1) % n
        weights[side[:-1]] = np.stack([(1.0 - t) ** 2, 2.0 * t * (1.0 - t), t**2], axis=1)
    return Outline(np.concatenate([corners, controls]), ends, weights)


def _drawn_lengths(lengths: NDArray[np.int32]) -> NDArray[np.float64]:
    drawn = lengths.astype(np.float64) ** LENGTH_POWER
    # Cutting one side short may leave another too long beside it: they give way in turn.
    for _ in range(MOST_CUTS):
        longest = int(drawn.argmax())
        limit = LONGEST_SIDE * (drawn.sum() - drawn[longest])
        if drawn[longest] <= limit * (1.0 + 1e-9):
            break
        drawn[longest] = limit
    return drawn


def _inscribed(lengths: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Corners of the polygon with these side lengths whose corners lie on the unit circle.

    LONGEST_SIDE < 1 sees to it that there is one; where its longest side lies between the
    centre and the others, the centre is outside the polygon.
    """

    def half_angles(radius: float) -> NDArray[np.float64]:
        return np.arcsin(np.minimum(lengths / (2.0 * radius), 1.0))

    longest = int(lengths.argmax())
    smallest = float(lengths[longest]) / 2.0
    outside = float(half_angles(smallest).sum()) < math.pi

    def excess(radius: float) -> float:
        half = half_angles(radius)
        if outside:
            return float(half[longest] - (half.sum() - half[longest]))
        return float(half.sum()) - math.pi

    # The excess falls with the radius. A circle must be wide for a longest side that is almost
    # as long as the others together.
    low, high = smallest, float(lengths.sum())
    while excess(high) > 0.0:
        low, high = high, 2.0 * high
    for _ in range(60):
        middle = (low + high) / 2.0
        if excess(middle) > 0.0:
            low = middle
        else:
            high = middle
    angles = 2.0 * half_angles(high)
    if outside:
        angles[longest] = 2.0 * math.pi - (angles.sum() - angles[longest])
    at = np.concatenate([[0.0], np.cumsum(angles)[:-1]])
    return np.exp(1j * at)


def _circle(disk: Disk) -> NDArray[np.complex128]:
    """(P,) points on a circle, its bottom edge level; a lone reflex corner is not bent."""
    p = disk.perimeter
    return np.exp(2j * math.pi * ((np.arange(p) - 0.5) / p - 0.25))


def _teardrop(disk: Disk) -> NDArray[np.complex128]:
    """(P,) points at equal distances along a drop with a right angle on top.

    One Bezier loop: its control polygon is convex, so the curve is.
    """
    t = np.linspace(0.0, 1.0, 2001)
    handle = np.exp(-0.75j * math.pi)
    curve = 3.0 * (1.0 - t) ** 2 * t * handle - 3.0 * (1.0 - t) * t**2 * np.conj(handle)
    length = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(curve)))])
    at = np.arange(disk.perimeter) / disk.perimeter * length[-1]
    points: Complex = np.interp(at, length, curve.real) + 1j * np.interp(at, length, curve.imag)
    return np.roll(points, int(disk.corners[0]))


#: Rounds of untangling, and L-BFGS steps in each.
ROUNDS = 12
STEPS = 60

#: Times that triangles no drawing can keep unflipped are given up, see _relaxed.
GIVE_UPS = 4

#: Angles that a reflex corner may open to, in radians, tried in this order. A corner of four
#: quads would shut the slit it ends, and long arms would curl over one another.
OPENINGS = tuple(math.radians(a) for a in (305.0, 250.0, 220.0, 180.0))

#: A bent outline stays this far from itself, in typical edges.
CLEARANCE = 0.06

#: L-BFGS steps of the tries: as many as it takes; and for outlines that always end up across
#: themselves, at the last opening, so few that they stop on the way there.
LONG = 240
SHORT = (40, 24, 14, 8, 4)

#: Wanted angles are kept to this range, in radians: beyond it a triangle has no size.
ANGLES = (math.radians(25.0), math.radians(150.0))


def embed_disk(disk: Disk, *, bend: bool = True) -> Points:
    """Embed a disk: flat coordinates of its vertices, for drawing.

    disk: any disk. bend: let the outline bend inward at reflex corners; otherwise it is
    strictly convex. Returns (n_vertices, 2) float64, side 0 at the bottom, boundary
    counter-clockwise, bounding box centred at the origin, its longer side 2. The same disk
    gives the same coordinates.

    Quads are neither flipped nor do they cross themselves, which ``flipped`` can confirm: it
    is minimised, not proven. Two vertices joined by two edges have no drawing with straight
    edges; what is returned then is the nearest found.
    """
    outline = make_outline(disk)
    boundary = outline.points()
    start = _tutte(disk, boundary)
    angle = _wanted_angles(disk, boundary)
    size = math.sqrt(_area(boundary) / disk.n_quads)
    points = _relaxed(disk, outline, start, angle, size)
    if bend and disk.n_sides >= 2 and (disk.corner_counts() > 2).any():
        bent = _bent(disk, outline, points, size)
        points = points if bent is None else bent
    return _framed(points)


def find_flipped_quads(quads: NDArray[np.int32], points: Points) -> NDArray[np.bool_]:
    """Find which quads are drawn clockwise, crossing themselves, or without area.

    quads: (q, 4) int32; points: (v, 2). Returns (q,) bool. A quad is sound if one of its
    diagonals cuts it into two counter-clockwise triangles; it may be concave.
    """
    corner = points[quads]
    leaving = np.roll(corner, -1, axis=1) - corner
    entering = np.roll(corner, 1, axis=1) - corner
    cross = leaving[..., 0] * entering[..., 1] - leaving[..., 1] * entering[..., 0]
    longest = (leaving**2).sum(axis=2).max(axis=1, initial=0.0)
    positive = cross > 1e-9 * longest[:, None]
    return ~((positive[:, 0] & positive[:, 2]) | (positive[:, 1] & positive[:, 3]))


def _tutte(disk: Disk, boundary: Complex) -> Complex:
    """(v,) every interior vertex at the mean of its neighbours, boundary given."""
    p, v = disk.perimeter, disk.n_vertices
    points = np.concatenate([boundary, np.zeros(v - p, np.complex128)])
    if v == p:
        return points
    tail = disk.quads.ravel()
    head = np.roll(disk.quads, -1, axis=1).ravel()
    # An interior edge is met from both its quads, and both are wanted.
    inner = tail >= p
    row, col = tail[inner] - p, head[inner]
    degree = np.bincount(row, minlength=v - p).astype(np.float64)
    free = col >= p
    own = np.arange(v - p)
    values = np.concatenate([degree, np.full(int(free.sum()), -1.0)])
    place = np.concatenate([own, row[free]]), np.concatenate([own, col[free] - p])
    pull = np.zeros(v - p, np.complex128)
    np.add.at(pull, row[~free], boundary[col[~free]])
    solved: Any = spsolve(csc_array((values, place)), np.stack([pull.real, pull.imag], axis=1))
    points[p:] = solved[:, 0] + 1j * solved[:, 1]
    return points


def _wanted_angles(disk: Disk, boundary: Complex) -> NDArray[np.float64]:
    """(q, 4) every vertex's angle in equal parts; 0 where two quads would get 180 degrees."""
    valence = disk.valence()
    whole = np.full(disk.n_vertices, 2.0 * math.pi)
    ahead = np.roll(boundary, -1) - boundary
    behind = np.roll(boundary, 1) - boundary
    whole[: disk.perimeter] = np.angle(behind / ahead) % (2.0 * math.pi)
    share = np.clip(whole / valence, *ANGLES)
    share[disk.perimeter :][valence[disk.perimeter :] <= 2] = 0.0
    return share[disk.quads]


def _relaxed(
    disk: Disk, outline: Outline, start: Complex, angle: NDArray[np.float64], size: float
) -> Complex:
    """(v,) the drawing relaxed inside a fixed outline.

    A drawing in which every quad is convex need not exist. A triangle that stays flipped is
    left out of the energy (its quad may then be concave there: the triangles beside it keep
    it simple), and the rest is relaxed again.
    """
    best, fewest = start, disk.n_quads + 1
    angle = angle.copy()
    for _ in range(GIVE_UPS):
        y = np.concatenate([outline.handles, best[disk.perimeter :]])
        points = np.empty(disk.n_vertices, np.complex128)
        n_handles = len(outline.handles)
        fixed = (outline.ends, outline.weights, disk.quads)
        smallest = relax_points(y, n_handles, False, *fixed, angle, size, ROUNDS, STEPS, points)
        wrong = int(find_flipped_quads(disk.quads, _pairs(points)).sum())
        if wrong < fewest:
            best, fewest = points, wrong
        if smallest > 0.0 or fewest == 0:
            break
        corner = points[disk.quads]
        cross = (np.roll(corner, -1, axis=1) - corner).conj() * (
            np.roll(corner, 1, axis=1) - corner
        )
        angle[cross.imag <= 0.0] = 0.0
    return best


def _bent(disk: Disk, outline: Outline, points: Complex, size: float) -> Complex | None:
    """(v,) the drawing with its corners let go, level sides first; None if it cannot be.

    points: (v,) the convex drawing; size: its typical edge.
    """
    valence = disk.valence()
    p = disk.perimeter
    start = np.concatenate([outline.handles, points[p:]])
    fixed = (outline.ends, outline.weights, disk.quads)
    tries = [(opening, LONG) for opening in OPENINGS] + [(OPENINGS[-1], n) for n in SHORT]
    for opening, steps in tries:
        whole = np.full(disk.n_vertices, 2.0 * math.pi)
        whole[:p] = np.minimum(valence[:p] * 0.5 * math.pi, opening)
        share = np.clip(whole / valence, *ANGLES)
        share[p:][valence[p:] <= 2] = 0.0
        y, moved = start.copy(), np.empty_like(points)
        # What a narrowed corner gives up, the other corners of its quads take over: else
        # they go on asking for right angles, and the fan round it closes up again.
        lost = np.zeros(disk.n_vertices)
        lost[:p] = 0.5 * math.pi - share[:p]
        angle = share[disk.quads]
        taken = (lost[disk.quads].sum(axis=1, keepdims=True) - lost[disk.quads]) / 3.0
        angle = np.where(angle > 0.0, np.clip(angle + taken, *ANGLES), 0.0)
        relax_points(y, len(outline.handles), True, *fixed, angle, size, 1, steps, moved)
        sound = not find_flipped_quads(disk.quads, _pairs(moved)).any()
        if sound and _clearance(moved[:p]) > CLEARANCE * size:
            return moved * _upright(y[: disk.n_sides])
    return None


def _upright(corners: Complex) -> complex:
    """The rotation that makes most sides level or plumb, side 0 at the bottom."""
    sides = np.roll(corners, -1) - corners
    # The fourth power forgets which of the four axes a side follows.
    turn = float(np.angle((sides**4 / np.abs(sides) ** 3).sum())) / 4.0
    first = float(np.angle(sides[0])) - turn
    quarter = round(first / (0.5 * math.pi))
    return complex(np.exp(-1j * (turn + quarter * 0.5 * math.pi)))


def _clearance(loop: Complex) -> float:
    """How near a closed polygon, (n,) points, comes to itself; negative if it crosses."""
    a, b = loop, np.roll(loop, -1)
    along = b - a

    def side(of: Complex) -> NDArray[np.bool_]:
        return ((of[:, None] - a) * along.conj()).imag > 0.0

    # Row i, column j: edge i's ends lie on two sides of edge j.
    parted = side(a) != side(b)
    n = len(loop)
    number = np.arange(n)
    gap = (number[:, None] - number) % n
    if (parted & parted.T & (gap > 1) & (gap < n - 1)).any():
        return -1.0
    t = ((a[:, None] - a) / along).real.clip(0.0, 1.0)
    distance = np.abs(a[:, None] - (a + t * along))
    # A vertex lies on its own two edges.
    distance[gap <= 1] = np.inf
    return float(distance.min(initial=np.inf))


def _area(loop: Complex) -> float:
    return float((loop.conj() * np.roll(loop, -1)).imag.sum()) / 2.0


def _pairs(points: Complex) -> Points:
    return np.stack([points.real, points.imag], axis=1)


def _framed(points: Complex) -> Points:
    return frame_points(_pairs(points))


def frame_points(pairs: Points) -> Points:
    """Shift and scale points (v, 2) so that they lie within -1 to 1, their middle at 0."""
    low, high = pairs.min(axis=0), pairs.max(axis=0)
    return (pairs - (low + high) / 2.0) * (2.0 / (high - low).max())
