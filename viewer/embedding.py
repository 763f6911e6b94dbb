"""Flat drawings of disks: where to put every vertex so that one can read the quads.

Boundary on a strictly convex outline, interior by Tutte's barycentric map (Tutte 1963),
then relaxed for shape. Tutte's map draws every face convex only where the graph is
3-connected; quad disks often are not (an interior vertex of valence 2 suffices), so the
relaxation untangles, too. A disk with reflex corners is then let go of its convex outline,
and bends inward at them as far as no quad flips and the outline does not cross itself.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array
from scipy.sparse.linalg import spsolve

from patterndb.core.disk import Disk
from patterndb.geometry.points import Points
from viewer.outline import Outline, convex_outline
from viewer.relax import relax

Complex = NDArray[np.complex128]

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


def embed(disk: Disk, *, bend: bool = True) -> Points:
    """Flat coordinates of a disk's vertices, for drawing.

    disk: any disk. bend: let the outline bend inward at reflex corners; otherwise it is
    strictly convex. Returns (n_vertices, 2) float64, side 0 at the bottom, boundary
    counter-clockwise, bounding box centred at the origin, its longer side 2. The same disk
    gives the same coordinates.

    Quads are neither flipped nor do they cross themselves, which ``flipped`` can confirm: it
    is minimised, not proven. Two vertices joined by two edges have no drawing with straight
    edges; what is returned then is the nearest found.
    """
    outline = convex_outline(disk)
    boundary = outline.points()
    start = _tutte(disk, boundary)
    angle = _wanted_angles(disk, boundary)
    size = math.sqrt(_area(boundary) / disk.n_quads)
    points = _relaxed(disk, outline, start, angle, size)
    if bend and disk.n_sides >= 2 and (disk.corner_counts() > 2).any():
        bent = _bent(disk, outline, points, size)
        points = points if bent is None else bent
    return _framed(points)


def flipped(quads: NDArray[np.int32], points: Points) -> NDArray[np.bool_]:
    """Which quads are drawn clockwise, crossing themselves, or without area.

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
        smallest = relax(y, n_handles, False, *fixed, angle, size, ROUNDS, STEPS, points)
        wrong = int(flipped(disk.quads, _pairs(points)).sum())
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
        relax(y, len(outline.handles), True, *fixed, angle, size, 1, steps, moved)
        sound = not flipped(disk.quads, _pairs(moved)).any()
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
    pairs = _pairs(points)
    low, high = pairs.min(axis=0), pairs.max(axis=0)
    return (pairs - (low + high) / 2.0) * (2.0 / (high - low).max())
