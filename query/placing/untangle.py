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

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb._native.query.placing.untangle import find_pieces, minimise_energy
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.neighbours import Neighbours
from patterndb.geometry.points import Points, tangents, units
from patterndb.geometry.quadshape import flipped
from query.placing.laplace import HeldQuads

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
    net: HeldQuads, vertices: Points, normals: Points, reaches: Sequence[int] = REACHES
) -> Points:
    """(v, 3) vertices with as few flipped quads as can be found, from those given.

    normals: (v, 3) unit normals, see :func:`patterndb.geometry.quadshape.flipped`. Held vertices do
    not move, others only in the plane across their normal, and no further than one of ``reaches``
    from a flipped quad, the first that will do. Where no quad is flipped the vertices come back as
    they are.
    """
    quads, beside = net.quads, net.neighbours
    at = np.ascontiguousarray(vertices.copy())
    wrong = flipped(quads, at, normals)
    frames = tangents(normals)
    up = units(normals[quads].sum(axis=1))
    for reach in reaches:
        if not wrong.any():
            break
        free = _within(quads, wrong, reach, beside)
        free[: net.n_held] = False
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


#: Takes (v, 3) vertices before and after untangling, and the normals (v, 3) along which they moved;
#: returns the vertices projected, and the normals there.
Reproject = Callable[[Points, Points, Points], tuple[Points, Points]]


@dataclass(frozen=True, slots=True)
class MendOptions:
    """How long untangling and projecting alternate.

    rounds: at most. reaches: see :func:`untangle`. hope: a round that leaves more than this part of
    the flipped quads is the last. still: so is one that moves no vertex further than this.
    """

    rounds: int
    still: float
    reaches: Sequence[int] = REACHES
    hope: float = np.inf


@dataclass(frozen=True, slots=True, eq=False)
class Mended:
    """vertices, normals: (v, 3) float64 those with the fewest flipped quads; flipped: how many."""

    vertices: Points
    normals: Points
    flipped: int


def mend(net: HeldQuads, start: Mended, reproject: Reproject, options: MendOptions) -> Mended:
    """Untangle and project in turn, for projecting may flip quads again.

    start: vertices, their normals, and the number of flipped quads that another placing must be
    below.
    """
    best, at, normals = start, start.vertices, start.normals
    for _ in range(options.rounds):
        if not best.flipped:
            break
        before = at
        moved = untangle(net, at, normals, options.reaches)
        at, normals = reproject(before, moved, normals)
        remain = int(flipped(net.quads, at, normals).sum())
        hopeless = remain > options.hope * best.flipped
        if remain < best.flipped:
            best = Mended(at, normals, remain)
        if hopeless or float(np.abs(at - before).max(initial=0.0)) <= options.still:
            break
    return best


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


#: Two rounds leave this part of the flipped corners, at most, or there are too few vertices around
#: to open them: those that succeed leave less than half. Of MANY corners, or fewer, it is no sign;
#: nor over a whole fill, where ways are long and success may come late.
LEFT = 0.75
MANY = 40

#: Steps that L-BFGS remembers.
MEMORY = 8
