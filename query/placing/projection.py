"""Rounds of smoothing and projection that bring a fill to rest on a surface.

The fill wants what a rubber net wants: the least sum of squared edges, with its boundary held
and every other vertex on the surface. At rest the uniform Laplacian of each interior vertex
has no part along the surface. Every round solves for the best moves within the vertices'
tangent planes, all at once, and projects along the interpolated normals.

Within a reflex outline, over a fold or over far more than half of a ball, the net of the least
squared edges turns over somewhere. :func:`settle_whole` goes as far towards rest as the net stays
whole: where a round of smoothing would flip a quad, its vertices and those around them stay, and
the rest of the net goes on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb._native.query.placing.laplace import measure_edge_energy, relax_within
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.neighbours import Neighbours, mean_of_neighbours
from patterndb.geometry.points import Points, tangents, units
from patterndb.geometry.quadshape import flipped
from patterndb.geometry.surface import Surface
from query.placing.laplace import solve_harmonic
from query.placing.region import Region, is_curved, map_on_disk

#: At rest no vertex moves further in a round than this part of the fill's diagonal.
AT_REST = 1e-4

#: Rounds, at most. Smooth surfaces take four to eight.
ROUNDS = 60

#: Times that a round's moves are halved if they would stretch the net.
HALVINGS = 6


@dataclass(frozen=True, slots=True, eq=False)
class Rest:
    """vertices (v, 3); the rounds it took; the largest move of the last, as a part of the
    diagonal."""

    vertices: Points
    rounds: int
    move: float


def lay_on_region(region: Region, beside: Neighbours, points: Points) -> Points:
    """(v, 3) a first placing on a region; its boundary vertices are ``points`` (P, 3).

    A membrane over the boundary, projected along normals that are interpolated from the
    boundary. Where the region is curved so much that this might miss it, fill and region are
    laid on one disk instead.
    """
    p = len(points)
    if is_curved(region, points):
        spread = lay_on_disk(region, beside, points)
        if spread is not None:
            return spread
    vertices = solve_harmonic(beside, points)
    normals = units(solve_harmonic(beside, region.surface.nearest(points).normals))
    vertices[p:] = region.surface.along(vertices[p:], normals[p:]).points
    return vertices


def lay_on_disk(region: Region, beside: Neighbours, points: Points) -> Points | None:
    """(v, 3) fill and region laid on one disk: it folds nowhere, and the sizes of quads vary.

    None where the region is no disk.
    """
    if not region.separates:
        return None
    p = len(points)
    turn = 2.0 * np.pi * np.arange(p) / p
    disk = solve_harmonic(beside, np.stack([np.cos(turn), np.sin(turn)], axis=1))
    feet = map_on_disk(region, disk, p)
    if feet is None:
        return None
    vertices = feet.points
    vertices[:p] = points
    return vertices


def settle(
    surface: Surface, beside: Neighbours, vertices: Points, perimeter: int, rounds: int = ROUNDS
) -> Rest:
    """Smooth and project from ``vertices`` (v, 3), which lie on the surface, until at rest."""
    p = perimeter
    at = np.ascontiguousarray(vertices.copy())
    if len(at) == p:
        return Rest(at, 0, 0.0)
    diagonal = float(np.linalg.norm(np.ptp(at, axis=0)))
    stretch = measure_edge_energy(beside.start, beside.neighbour, at)
    done, largest = 0, np.inf
    while done < rounds and largest >= AT_REST:
        done += 1
        normals = find_normals(surface, beside, at)
        move = relax_within(beside.start, beside.neighbour, p, at, tangents(normals))
        moved, after = at, stretch
        for _ in range(HALVINGS + 1):
            moved = at + move
            moved[p:] = surface.along(moved[p:], normals[p:]).points
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


def find_normals(surface: Surface, beside: Neighbours, vertices: Points) -> Points:
    """(v, 3) the surface's normals at the vertices, each averaged with its neighbours'."""
    own = surface.nearest(vertices).normals
    return units(own + mean_of_neighbours(beside.start, beside.neighbour, own))


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


def settle_whole(
    surface: Surface, quads: Int32Array, beside: Neighbours, vertices: Points, perimeter: int
) -> Rest:
    """Smooth and project from ``vertices`` (v, 3) on the surface; no quad flips that was sound.

    The move told is that of the last round, 1e-4 or more where vertices had to be held back.
    """
    at = vertices
    wrong = _wrong(surface, quads, beside, at)
    stretch = measure_edge_energy(beside.start, beside.neighbour, at)
    done, largest = 0, np.inf
    while done < WHOLE_ROUNDS:
        done += 1
        rest = settle(surface, beside, at, perimeter, 1)
        moved, free = _held(surface, quads, beside, at, rest.vertices, wrong, perimeter)
        after = measure_edge_energy(beside.start, beside.neighbour, moved)
        largest = rest.move if free else max(rest.move, AT_REST)
        if after >= stretch:
            break
        gain = 1.0 - after / stretch
        at, stretch = moved, after
        if largest < AT_REST or gain < GAIN:
            break
    return Rest(at, done, largest)


def _held(
    surface: Surface,
    quads: Int32Array,
    beside: Neighbours,
    before: Points,
    after: Points,
    wrong: NDArray[np.bool_],
    perimeter: int,
) -> tuple[Points, bool]:
    """The vertices after a move, held back where quads would flip, and could all go?

    Vertices of such quads stay where they were, those further away go a part of their way that
    grows with each edge.
    """
    part = np.ones(len(before))
    moved = after
    for _ in range(HOLDS):
        worse = _wrong(surface, quads, beside, moved) & ~wrong
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
        moved[perimeter:] = surface.nearest(moved[perimeter:]).points
        moved[:perimeter] = before[:perimeter]
    return before, False


def _wrong(
    surface: Surface, quads: Int32Array, beside: Neighbours, vertices: Points
) -> NDArray[np.bool_]:
    return flipped(quads, vertices, find_normals(surface, beside, vertices))
