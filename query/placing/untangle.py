"""Untangling: moves vertices within their tangent planes until no quad is flipped.

Uniform means flip nothing inside a convex outline if the graph is 3-connected (Tutte 1963).
Quad disks need not be, outlines may be reflex, and surfaces bend. There an energy is minimised,
over the surroundings of every tangle by itself: only vertices near a flipped quad move, and a
tangle that cannot be opened keeps no other from it.

The energy is that of Garanzha et al. 2021, "Foldover-free maps in 50 lines of code": every corner
of every quad is a triangle whose energy blows up as its area falls to zero; the blow-up is smoothed
while a triangle is flipped, and sharpened step by step. Differs from the source: the triangles lie
on a surface and are measured against its normals, and where sharpening no longer opens triangles it
ends.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.neighbours import Neighbours
from patterndb.geometry.points import Points, tangents, units
from patterndb.geometry.quadshape import flipped
from patterndb.system.kernels import kernel

#: Edges from a flipped quad within which vertices may move, tried in this order; the last
#: stands for all.
REACHES = (2, 5, 10**6)

#: Quads around a tangle to a flipped one, at least: with fewer there is no room to open it.
ROOM = 3

#: Times that triangles which stay flipped are given up: their quads may be concave there.
GIVE_UPS = 3

#: Where untangling moves no vertex further than this part of what is placed, it would move none
#: the next time either. Measured: it moves by a part of an edge, or by rounding.
UNMOVED = 1e-12


def untangle(
    quads: Int32Array,
    vertices: Points,
    normals: Points,
    fixed: int,
    beside: Neighbours,
    reaches: Sequence[int] = REACHES,
) -> Points:
    """(v, 3) vertices with as few flipped quads as can be found, from those given.

    normals: (v, 3) unit normals, see :func:`patterndb.geometry.quadshape.flipped`. Vertices before
    ``fixed`` do not move, others only in the plane across their normal, and no further than one of
    ``reaches`` from a flipped quad, the first that will do. Where no quad is flipped the vertices
    come back as they are.
    """
    at = np.ascontiguousarray(vertices.copy())
    wrong = flipped(quads, at, normals)
    frames = tangents(normals)
    up = units(normals[quads].sum(axis=1))
    for reach in reaches:
        if not wrong.any():
            break
        free = _within(quads, wrong, reach, beside)
        free[:fixed] = False
        if not free.any():
            continue
        wanted = _wanted(quads, free, beside)
        for tangle in _tangles(quads, wanted, free):
            inside = wrong[tangle]
            roomy = len(tangle) >= ROOM * inside.sum() or reach == reaches[-1]
            if not inside.any() or not roomy:
                continue
            left = np.inf if reach == REACHES[-1] else LEFT
            _open(quads[tangle], at, normals, frames, up[tangle], free, wanted[tangle], left)
            wrong[tangle] = flipped(quads[tangle], at, normals)
    return at


def _open(
    quads: Int32Array,
    vertices: Points,
    normals: Points,
    frames: Points,
    up: Points,
    free: NDArray[np.bool_],
    wanted: NDArray[np.bool_],
    left_over: float,
) -> None:
    """Untangle quads (q, 4), moving their free vertices in place, if fewer are flipped then."""
    used, own = np.unique(quads, return_inverse=True)
    own = np.ascontiguousarray(own.reshape(-1, 4).astype(np.int32))
    at, up = np.ascontiguousarray(vertices[used]), np.ascontiguousarray(up)
    turns, upright = np.ascontiguousarray(frames[used]), normals[used]
    moving = np.flatnonzero(free[used]).astype(np.int32)
    corner = at[own]
    size = float(np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2).mean())
    if size == 0.0:
        return
    best, fewest = at, int(flipped(own, at, upright).sum())
    start = at
    for _ in range(GIVE_UPS + 1):
        part = np.flatnonzero(wanted.any(axis=1))
        if len(part) == 0:
            break
        tried = start.copy()
        minimise_energy(
            np.ascontiguousarray(own[part]),
            np.ascontiguousarray(wanted[part]),
            np.ascontiguousarray(up[part]),
            moving,
            turns,
            size,
            tried,
            left_over,
        )
        remain = int(flipped(own, tried, upright).sum())
        if remain < fewest:
            best, fewest = tried, remain
        given_up = wanted & (_areas(own, tried, up) <= 0.0)
        if not remain or not given_up.any():
            break
        wanted = wanted & ~given_up
        start = tried
    vertices[used[moving]] = best[moving]


def _tangles(
    quads: Int32Array, wanted: NDArray[np.bool_], free: NDArray[np.bool_]
) -> Iterator[Int32Array]:
    """The quads that take part, in pieces that have no free vertex in common."""
    part = np.flatnonzero(wanted.any(axis=1)).astype(np.int32)
    piece = find_pieces(quads[part], free)
    for one in np.unique(piece):
        yield part[piece == one]


@kernel
def find_pieces(quads: Int32Array, free: NDArray[np.bool_]) -> Int32Array:
    """(q,) int32 names of the pieces that quads are in: those with a free vertex in common are
    in one. Every quad has a free vertex."""
    root = np.arange(len(free)).astype(np.int32)
    for f in range(len(quads)):
        first = -1
        for e in range(4):
            at = quads[f, e]
            if not free[at]:
                continue
            while root[at] != at:
                root[at] = root[root[at]]
                at = root[at]
            if first < 0:
                first = at
            elif at != first:
                low, high = min(first, at), max(first, at)
                root[high] = low
                first = low
    found = np.empty(len(quads), np.int32)
    for f in range(len(quads)):
        for e in range(4):
            at = quads[f, e]
            if free[at]:
                while root[at] != at:
                    at = root[at]
                found[f] = at
                break
    return found


def _within(
    quads: Int32Array, wrong: NDArray[np.bool_], reach: int, beside: Neighbours
) -> NDArray[np.bool_]:
    """(v,) vertices at most ``reach`` quads away from a wrong one."""
    near = np.zeros(beside.n_vertices, np.bool_)
    near[quads[wrong]] = True
    for _ in range(reach):
        met = near[quads].any(axis=1)
        grown = near.copy()
        grown[quads[met]] = True
        if (grown == near).all():
            break
        near = grown
    return near


def _wanted(quads: Int32Array, free: NDArray[np.bool_], beside: Neighbours) -> NDArray[np.bool_]:
    """(q, 4) the corners that shall have an area, among those that can change theirs.

    Of the two corners at an interior vertex of two quads one is always concave.
    """
    moves = free[quads]
    changes = moves | np.roll(moves, -1, axis=1) | np.roll(moves, 1, axis=1)
    degree = np.diff(beside.start)
    return changes & ((degree > 2) | ~free)[quads]


def _areas(quads: Int32Array, vertices: Points, up: Points) -> NDArray[np.float64]:
    corner = vertices[quads]
    leaving = np.roll(corner, -1, axis=1) - corner
    entering = np.roll(corner, 1, axis=1) - corner
    return np.einsum("qec,qc->qe", np.cross(leaving, entering), up)


#: Rounds of sharpening, and L-BFGS steps in each.
ROUNDS = 14
STEPS = 60

#: From round to round the blow-up is smoothed over this part of the area before, at least.
SHARPENED = 0.3

#: Two rounds leave this part of the flipped corners, at most, or there are too few vertices around
#: to open them: those that succeed leave less than half. Of MANY corners, or fewer, it is no sign;
#: nor over a whole fill, where ways are long and success may come late.
LEFT = 0.75
MANY = 40

#: Steps that L-BFGS remembers.
MEMORY = 8


@kernel
def compute_energy(
    quads: Int32Array,
    wanted: NDArray[np.bool_],
    up: Points,
    size: float,
    epsilon: float,
    points: Points,
    force: Points,
) -> tuple[float, float]:
    """The energy of all wanted corners, its gradient into ``force`` (v, 3), and the smallest
    area of a corner, in squared sizes."""
    force[:] = 0.0
    total = 0.0
    smallest = np.inf
    for f in range(len(quads)):
        nx, ny, nz = up[f, 0], up[f, 1], up[f, 2]
        for e in range(4):
            if not wanted[f, e]:
                continue
            i = quads[f, e]
            j = quads[f, (e + 1) & 3]
            k = quads[f, (e + 3) & 3]
            ux = (points[j, 0] - points[i, 0]) / size
            uy = (points[j, 1] - points[i, 1]) / size
            uz = (points[j, 2] - points[i, 2]) / size
            vx = (points[k, 0] - points[i, 0]) / size
            vy = (points[k, 1] - points[i, 1]) / size
            vz = (points[k, 2] - points[i, 2]) / size
            area = nx * (uy * vz - uz * vy) + ny * (uz * vx - ux * vz) + nz * (ux * vy - uy * vx)
            smallest = min(smallest, area)
            root = math.sqrt(area * area + epsilon * epsilon)
            smooth = 0.5 * (area + root)
            if area < 0.0:
                smooth = 0.5 * epsilon * epsilon / (root - area)
            norm = 0.5 * (ux * ux + uy * uy + uz * uz + vx * vx + vy * vy + vz * vz)
            total += norm / smooth
            per_norm = 1.0 / (smooth * size)
            per_area = -norm / (smooth * root * size)
            # The area's gradient by u is v x n, by v it is n x u.
            ax = per_norm * ux + per_area * (vy * nz - vz * ny)
            ay = per_norm * uy + per_area * (vz * nx - vx * nz)
            az = per_norm * uz + per_area * (vx * ny - vy * nx)
            bx = per_norm * vx + per_area * (ny * uz - nz * uy)
            by = per_norm * vy + per_area * (nz * ux - nx * uz)
            bz = per_norm * vz + per_area * (nx * uy - ny * ux)
            force[j, 0] += ax
            force[j, 1] += ay
            force[j, 2] += az
            force[k, 0] += bx
            force[k, 1] += by
            force[k, 2] += bz
            force[i, 0] -= ax + bx
            force[i, 1] -= ay + by
            force[i, 2] -= az + bz
    return total, smallest


@kernel
def count_flipped_corners(
    quads: Int32Array, wanted: NDArray[np.bool_], up: Points, points: Points
) -> int:
    """How many wanted corners have no positive area."""
    count = 0
    for f in range(len(quads)):
        for e in range(4):
            if wanted[f, e]:
                count += _area(quads, f, e, up, points) <= 0.0
    return count


@kernel(inline="always")
def _area(quads: Int32Array, f: int, e: int, up: Points, points: Points) -> float:
    i = quads[f, e]
    j = quads[f, (e + 1) & 3]
    k = quads[f, (e + 3) & 3]
    ux = points[j, 0] - points[i, 0]
    uy = points[j, 1] - points[i, 1]
    uz = points[j, 2] - points[i, 2]
    vx = points[k, 0] - points[i, 0]
    vy = points[k, 1] - points[i, 1]
    vz = points[k, 2] - points[i, 2]
    return (
        up[f, 0] * (uy * vz - uz * vy)
        + up[f, 1] * (uz * vx - ux * vz)
        + up[f, 2] * (ux * vy - uy * vx)
    )


@kernel
def _to_plane(free: Int32Array, frames: Points, force: Points, gradient: Points) -> None:
    for m in range(len(free)):
        for f in range(2):
            total = 0.0
            for c in range(3):
                total += frames[free[m], f, c] * force[free[m], c]
            gradient[2 * m + f] = total


@kernel
def _from_plane(
    free: Int32Array, frames: Points, origin: Points, at: Points, points: Points
) -> None:
    for m in range(len(free)):
        i = free[m]
        for c in range(3):
            points[i, c] = (
                origin[m, c] + at[2 * m] * frames[i, 0, c] + at[2 * m + 1] * frames[i, 1, c]
            )


@kernel
def _dot(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    total = 0.0
    for i in range(len(a)):
        total += a[i] * b[i]
    return total


@kernel
def _add(to: NDArray[np.float64], factor: float, what: NDArray[np.float64]) -> None:
    for i in range(len(to)):
        to[i] += factor * what[i]


@kernel
def _descend(
    gradient: NDArray[np.float64],
    move: Points,
    change: Points,
    curvature: NDArray[np.float64],
    kept: int,
    size: float,
    direction: NDArray[np.float64],
) -> None:
    """The L-BFGS direction, by the two loops (Nocedal and Wright 2006, algorithm 7.4)."""
    alpha = np.zeros(MEMORY)
    largest = 1e-30
    for i in range(len(gradient)):
        direction[i] = -gradient[i]
        largest = max(largest, abs(gradient[i]))
    for m in range(kept - 1, max(kept - MEMORY, 0) - 1, -1):
        s = m % MEMORY
        alpha[s] = _dot(move[s], direction) / curvature[s]
        _add(direction, -alpha[s], change[s])
    scale = 0.1 * size / largest
    if kept:
        s = (kept - 1) % MEMORY
        scale = curvature[s] / _dot(change[s], change[s])
    for i in range(len(direction)):
        direction[i] *= scale
    for m in range(max(kept - MEMORY, 0), kept):
        s = m % MEMORY
        _add(direction, alpha[s] - _dot(change[s], direction) / curvature[s], move[s])


@kernel
def minimise_energy(
    quads: Int32Array,
    wanted: NDArray[np.bool_],
    up: Points,
    free: Int32Array,
    frames: Points,
    size: float,
    points: Points,
    left_over: float = LEFT,
) -> float:
    """Minimise :func:`compute_energy` over the free vertices, in place; the smallest area left.

    Once a round begins without a flipped corner it is the last, and keeps it so. Where rounds no
    longer help it ends, too.
    """
    n = 2 * len(free)
    origin = np.empty((len(free), 3))
    for m in range(len(free)):
        for c in range(3):
            origin[m, c] = points[free[m], c]
    at = np.zeros(n)
    trial = np.empty(n)
    direction = np.empty(n)
    gradient = np.empty(n)
    trial_gradient = np.empty(n)
    force = np.empty_like(points)
    move = np.empty((MEMORY, n))
    change = np.empty((MEMORY, n))
    curvature = np.empty(MEMORY)
    _, smallest = compute_energy(quads, wanted, up, size, 1.0, points, force)
    blunt = 1.0
    left = np.empty(ROUNDS, np.int64)
    for done in range(ROUNDS):
        sound = smallest > 1e-6
        # What has collapsed to no area at all must be opened before the blow-up is sharp.
        epsilon = 1e-5 if sound else max(blunt, math.sqrt(1e-9 + 0.04 * smallest * smallest))
        blunt *= SHARPENED
        value, smallest = compute_energy(quads, wanted, up, size, epsilon, points, force)
        _to_plane(free, frames, force, gradient)
        kept = 0
        for _ in range(STEPS):
            _descend(gradient, move, change, curvature, kept, size, direction)
            descent = _dot(gradient, direction)
            if descent >= 0.0:
                if kept == 0:
                    break
                kept = 0
                continue
            step = 1.0
            found = value
            area = smallest
            accepted = False
            for _ in range(30):
                for i in range(n):
                    trial[i] = at[i] + step * direction[i]
                _from_plane(free, frames, origin, trial, points)
                found, area = compute_energy(quads, wanted, up, size, epsilon, points, force)
                if found <= value + 1e-4 * step * descent and (area > 0.0 or not sound):
                    accepted = True
                    break
                step *= 0.5
            if not accepted:
                break
            _to_plane(free, frames, force, trial_gradient)
            s = kept % MEMORY
            for i in range(n):
                move[s, i] = trial[i] - at[i]
                change[s, i] = trial_gradient[i] - gradient[i]
                at[i] = trial[i]
                gradient[i] = trial_gradient[i]
            curvature[s] = _dot(move[s], change[s])
            if curvature[s] > 1e-14 * _dot(change[s], change[s]) * size * size:
                kept += 1
            settled = value - found <= 1e-6 * found
            value, smallest = found, area
            if settled:
                break
        _from_plane(free, frames, origin, at, points)
        left[done] = count_flipped_corners(quads, wanted, up, points)
        if sound or (done > 1 and left[done] > max(MANY, left_over * left[done - 2])):
            break
    _, smallest = compute_energy(quads, wanted, up, size, 1e-5, points, force)
    return smallest
