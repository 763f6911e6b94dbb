"""Projectors, first placings on them, and rounds of smoothing and projection.

A projector is what a fill is placed on: a surface, a plane, or nothing in space. On a surface the
fill wants what a rubber net wants: the least sum of squared edges, with its boundary held and every
other vertex on the surface. At rest the uniform Laplacian of each interior vertex has no part along
the surface. Every round solves for the best moves within the vertices' tangent planes, all at once,
and projects along the interpolated normals.

Within a reflex outline, over a fold or over far more than half of a ball, the net of the least
squared edges turns over somewhere. :func:`settle_whole` goes as far towards rest as the net stays
whole: where a round of smoothing would flip a quad, its vertices and those around them stay, and
the rest of the net goes on.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from patterndb._native.query.placing.laplace import measure_edge_energy, relax_within
from patterndb.geometry.neighbours import mean_of_neighbours
from patterndb.geometry.points import Points, tangents, units
from patterndb.geometry.quadshape import flipped, own_normals, plane_normal
from patterndb.geometry.surface import Surface
from query.placing.laplace import HeldQuads
from query.placing.region import Region, is_curved, map_on_disk

#: At rest no vertex moves further in a round than this part of the fill's diagonal.
AT_REST = 1e-4

#: Rounds, at most. Smooth surfaces take four to eight.
ROUNDS = 60

#: Times that a round's moves are halved if they would stretch the net.
HALVINGS = 6


class Projector(Protocol):
    """What the vertices of quads are placed on."""

    def find_normals(self, vertices: Points) -> Points:
        """Find (v, 3) unit normals, along which quads with vertices (v, 3) are seen."""
        ...

    def project(self, points: Points, normals: Points) -> Points:
        """Project points (n, 3) along unit normals (n, 3)."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceProjector:
    """Places quads on a surface, seen along its normals, each averaged with its neighbours'."""

    surface: Surface
    net: HeldQuads

    def find_normals(self, vertices: Points) -> Points:
        beside, own = self.net.neighbours, self.surface.nearest(vertices).normals
        return units(own + mean_of_neighbours(beside.start, beside.neighbour, own))

    def project(self, points: Points, normals: Points) -> Points:
        return self.surface.along(points, normals).points

    def find_flipped(self, vertices: Points) -> NDArray[np.bool_]:
        """(q,) which quads are flipped."""
        return flipped(self.net.quads, vertices, self.find_normals(vertices))


@dataclass(frozen=True, slots=True, eq=False)
class SpaceProjector:
    """Places quads in space, seen along the plane's normal (3,), or along their own.

    Means of points in a plane lie in it, so that nothing is projected.
    """

    net: HeldQuads
    plane: Points | None

    def find_normals(self, vertices: Points) -> Points:
        if self.plane is not None:
            return np.tile(self.plane, (len(vertices), 1))
        return own_normals(self.net.quads, vertices, self.net.neighbours)

    def project(self, points: Points, normals: Points) -> Points:
        return points


def make_projector(net: HeldQuads, points: Points, region: Region | None) -> Projector:
    """Make what a fill within a boundary (P, 3) is placed on."""
    if region is not None:
        return SurfaceProjector(region.surface, net)
    return SpaceProjector(net, plane_normal(points))


@dataclass(frozen=True, slots=True, eq=False)
class Rest:
    """vertices (v, 3); the rounds it took; the largest move of the last, as a part of the
    diagonal."""

    vertices: Points
    rounds: int
    move: float


def lay_membrane(
    net: HeldQuads,
    points: Points,
    normals: Points,
    project: Callable[[Points, Points], Points],
) -> Points:
    """(v, 3) a membrane over held points (P, 3), each other vertex projected by itself.

    It is projected along normals that are interpolated from those of the held points (P, 3).
    """
    p = len(points)
    vertices, up = net.place_harmonic(points), units(net.place_harmonic(normals))
    vertices[p:] = project(vertices[p:], up[p:])
    return vertices


def lay_on_region(region: Region, net: HeldQuads, points: Points) -> Points:
    """(v, 3) a first placing on a region; its boundary vertices are ``points`` (P, 3).

    Where the region is curved so much that a membrane might miss it, fill and region are laid on
    one disk instead.
    """
    if is_curved(region, points):
        spread = lay_on_disk(region, net, points)
        if spread is not None:
            return spread
    surface = region.surface
    projector = SurfaceProjector(surface, net)
    return lay_membrane(net, points, surface.nearest(points).normals, projector.project)


def lay_on_disk(region: Region, net: HeldQuads, points: Points) -> Points | None:
    """(v, 3) fill and region laid on one disk: it folds nowhere, and the sizes of quads vary.

    None where the region is no disk.
    """
    if not region.separates:
        return None
    p = len(points)
    turn = 2.0 * np.pi * np.arange(p) / p
    disk = net.place_harmonic(np.stack([np.cos(turn), np.sin(turn)], axis=1))
    feet = map_on_disk(region, disk, p)
    if feet is None:
        return None
    vertices = feet.points
    vertices[:p] = points
    return vertices


def settle(projector: SurfaceProjector, vertices: Points, rounds: int = ROUNDS) -> Rest:
    """Smooth and project from ``vertices`` (v, 3), which lie on the surface, until at rest."""
    net = projector.net
    p, beside = net.n_held, net.neighbours
    at = np.ascontiguousarray(vertices.copy())
    if len(at) == p:
        return Rest(at, 0, 0.0)
    diagonal = float(np.linalg.norm(np.ptp(at, axis=0)))
    stretch = measure_edge_energy(beside.start, beside.neighbour, at)
    done, largest = 0, np.inf
    while done < rounds and largest >= AT_REST:
        done += 1
        normals = projector.find_normals(at)
        move = relax_within(beside.start, beside.neighbour, p, at, tangents(normals))
        moved, after = at, stretch
        for _ in range(HALVINGS + 1):
            moved = at + move
            moved[p:] = projector.project(moved[p:], normals[p:])
            after = measure_edge_energy(beside.start, beside.neighbour, moved)
            if after <= stretch:
                break
            move = move / 2.0
        else:
            # No part of the move shortens the net: it lies as tight as the triangles let it.
            moved, after = at, stretch
        largest = float(np.linalg.norm(moved - at, axis=1).max()) / diagonal
        at, stretch = moved, after
    return Rest(at, done, largest)


#: Rounds, at most.
WHOLE_ROUNDS = 30

#: A round that shortens the sum of squared edges by a smaller part than this is the last.
GAIN = 1e-3

#: Edges from a quad that would flip within which vertices are held back, and the further part of
#: their way that is left to them each time.
SPREAD = 8
SLOWER = 0.7

#: Times that vertices around quads that would flip are held back.
HOLDS = 8


def settle_whole(projector: SurfaceProjector, vertices: Points) -> Rest:
    """Smooth and project from ``vertices`` (v, 3) on the surface; no quad flips that was sound.

    The move that is returned is that of the last round, 1e-4 or more where vertices had to be held
    back.
    """
    beside = projector.net.neighbours
    at = vertices
    wrong = projector.find_flipped(at)
    stretch = measure_edge_energy(beside.start, beside.neighbour, at)
    done, largest = 0, np.inf
    while done < WHOLE_ROUNDS:
        done += 1
        rest = settle(projector, at, 1)
        moved, free = _hold_back(projector, at, rest.vertices, wrong)
        after = measure_edge_energy(beside.start, beside.neighbour, moved)
        largest = rest.move if free else max(rest.move, AT_REST)
        if after >= stretch:
            break
        gain = 1.0 - after / stretch
        at, stretch = moved, after
        if largest < AT_REST or gain < GAIN:
            break
    return Rest(at, done, largest)


def _hold_back(
    projector: SurfaceProjector, before: Points, after: Points, wrong: NDArray[np.bool_]
) -> tuple[Points, bool]:
    """The vertices after a move, held back where quads would flip, and could all go?

    Vertices of such quads stay where they were, those further away go a part of their way that
    grows with each edge.
    """
    quads, p = projector.net.quads, projector.net.n_held
    part = np.ones(len(before))
    moved = after
    for _ in range(HOLDS):
        worse = projector.find_flipped(moved) & ~wrong
        if not worse.any():
            return moved, bool(part.min() == 1.0)
        held = np.zeros(len(before))
        held[quads[worse]] = 1.0
        for step in range(1, SPREAD):
            around = held[quads].max(axis=1) >= 1.0 - (step - 1) / SPREAD
            near = quads[around]
            held[near] = np.maximum(held[near], 1.0 - step / SPREAD)
        part = np.minimum(part, 1.0 - held) * np.where(held > 0.0, SLOWER, 1.0)
        moved = before + part[:, None] * (after - before)
        moved[p:] = projector.surface.nearest(moved[p:]).points
        moved[:p] = before[:p]
    return before, False
