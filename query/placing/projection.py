"""Rounds of smoothing and projection that bring a fill to rest on a surface.

The fill wants what a rubber net wants: the least sum of squared edges, with its boundary held
and every other vertex on the surface. At rest the uniform Laplacian of each interior vertex
has no part along the surface. Every round solves for the best moves within the vertices'
tangent planes, all at once, and projects along the interpolated normals.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from patterndb.geometry.neighbours import Neighbours, mean_of_neighbours
from patterndb.geometry.points import Points, tangents, units
from patterndb.geometry.surface import Surface
from query.placing.laplace import edge_energy, harmonic, relax_within
from query.placing.region import Region, is_curved, mapped

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


def laid_on(region: Region, beside: Neighbours, points: Points) -> Points:
    """(v, 3) a first placing on a region; its boundary vertices are ``points`` (P, 3).

    A membrane over the boundary, projected along normals that are interpolated from the
    boundary. Where the region is curved so much that this might miss it, fill and region are
    laid on one disk instead.
    """
    p = len(points)
    if is_curved(region, points):
        spread = laid_on_disk(region, beside, points)
        if spread is not None:
            return spread
    vertices = harmonic(beside, points)
    normals = units(harmonic(beside, region.surface.nearest(points).normals))
    vertices[p:] = region.surface.along(vertices[p:], normals[p:]).points
    return vertices


def laid_on_disk(region: Region, beside: Neighbours, points: Points) -> Points | None:
    """(v, 3) fill and region laid on one disk: it folds nowhere, and the sizes of quads vary.

    None where the region is no disk.
    """
    if not region.separates:
        return None
    p = len(points)
    turn = 2.0 * np.pi * np.arange(p) / p
    disk = harmonic(beside, np.stack([np.cos(turn), np.sin(turn)], axis=1))
    feet = mapped(region, disk, p)
    if feet is None:
        return None
    vertices = feet.points
    vertices[:p] = points
    return vertices


def settled(
    surface: Surface, beside: Neighbours, vertices: Points, perimeter: int, rounds: int = ROUNDS
) -> Rest:
    """Smooth and project from ``vertices`` (v, 3), which lie on the surface, until at rest."""
    p = perimeter
    at = np.ascontiguousarray(vertices.copy())
    if len(at) == p:
        return Rest(at, 0, 0.0)
    diagonal = float(np.linalg.norm(np.ptp(at, axis=0)))
    stretch = edge_energy(beside.start, beside.neighbour, at)
    done, largest = 0, np.inf
    while done < rounds and largest >= AT_REST:
        done += 1
        normals = normals_at(surface, beside, at)
        move = relax_within(beside.start, beside.neighbour, p, at, tangents(normals))
        moved, after = at, stretch
        for _ in range(HALVINGS + 1):
            moved = at + move
            moved[p:] = surface.along(moved[p:], normals[p:]).points
            after = edge_energy(beside.start, beside.neighbour, moved)
            if after <= stretch:
                break
            move = move / 2.0
        else:
            # No part of the move shortens the net: it lies as tight as the triangles let it.
            moved, after = at, stretch
        largest = float(np.linalg.norm(moved - at, axis=1).max()) / diagonal
        at, stretch = moved, after
    return Rest(at, done, largest)


def normals_at(surface: Surface, beside: Neighbours, vertices: Points) -> Points:
    """(v, 3) the surface's normals at the vertices, each averaged with its neighbours'."""
    own = surface.nearest(vertices).normals
    return units(own + mean_of_neighbours(beside.start, beside.neighbour, own))
