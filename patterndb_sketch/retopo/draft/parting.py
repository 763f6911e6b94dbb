"""Part a surface where it touches itself in vertices or along edges, for a draft to be made of it.

Meshes of modelling programs do where vertices were merged by their distance. A field sees no disk
around such a vertex: each of the fans of triangles that meet there gets a vertex of its own. Of
more than two triangles at an edge those go on together that are neighbours on the surface; an odd
one ends there in a border.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.errors import InvalidMeshError
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network.faces import SurfaceParts

#: A fan's new vertex lies inward from where the fans touch by this part of its edges: more than
#: rounding, by which vertices would be taken for one again, and less than anybody sees.
INWARD = 0.01

#: A triangle has three sides: in so many rounds each is divided.
MOST_ROUNDS = 4


@dataclass(frozen=True, slots=True, eq=False)
class PartedSurface:
    """surface: with the same triangles. touching: (k,) int32, vertices where fans had met."""

    surface: Surface
    touching: Int32Array


def part_touching(surface: Surface) -> PartedSurface:
    """The surface with a vertex for each fan of triangles; itself, where no fans touch.

    Raises RefusedError, with the place, where what is parted has one side only: sheets that were
    told apart by more than two triangles at an edge.
    """
    try:
        parted = _part_fans(surface)
        again = _divide_crowded(parted.surface)
    except InvalidMeshError as error:
        raise RefusedError(f"no draft: where parts of it touch, {error}") from error
    if again is parted.surface:
        return parted
    crowded = np.flatnonzero(np.diff(parted.surface.adjacency.side_start) > 2)
    ends = np.unique(parted.surface.adjacency.ends[crowded].ravel())
    ends = ends[ends < len(surface.vertices)]
    return PartedSurface(again, np.union1d(parted.touching, ends).astype(np.int32))


def _part_fans(surface: Surface) -> PartedSurface:
    """The same, for all but edges both of whose ends have their triangles in one fan."""
    corner = surface.triangles.ravel().astype(np.int64)
    fan = SurfaceParts.of(surface).fan
    pairs = np.unique(np.stack([corner, fan], axis=1), axis=0)
    fans = np.bincount(pairs[:, 0], minlength=len(surface.vertices))
    touching = np.flatnonzero(fans > 1).astype(np.int32)
    if not len(touching):
        return PartedSurface(surface, touching)
    vertices, more = surface.vertices.copy(), list[Points]()
    triangles = surface.triangles.copy().ravel()
    for vertex in touching.tolist():
        at = surface.vertices[vertex]
        for k, one in enumerate(pairs[pairs[:, 0] == vertex, 1].tolist()):
            mine = np.flatnonzero(fan == one)
            inward = at + INWARD * (_find_middle(surface, mine) - at)
            if k == 0:
                vertices[vertex] = inward
                continue
            triangles[mine] = len(vertices) + len(more)
            more.append(inward)
    parted = Surface.from_arrays(
        np.concatenate([vertices, more]), triangles.reshape(-1, 3)
    ).orient()
    return PartedSurface(parted, touching)


def _divide_crowded(surface: Surface) -> Surface:
    """The surface with a middle for each pair of triangles at edges of more than two whose ends are
    in one fan; itself, where there are none. Triangles with several such edges take rounds."""
    for _ in range(MOST_ROUNDS):
        topology = surface.adjacency
        crowded = np.flatnonzero(np.diff(topology.side_start) > 2)
        triangles, vertices = surface.triangles.tolist(), surface.vertices.tolist()
        changed: set[int] = set()
        for edge in crowded.tolist():
            sides = topology.sides[topology.side_start[edge] : topology.side_start[edge + 1]]
            if changed & {side // 3 for side in sides.tolist()}:
                # Divided already, by another side: in the next round.
                continue
            changed |= {side // 3 for side in sides.tolist()}
            middle: dict[int, int] = {}
            for side in sides.tolist():
                other = int(topology.across[side])
                pair = min(side, other) if other >= 0 else side
                a, b, c = surface.triangles[side // 3, (side % 3 + np.arange(3)) % 3].tolist()
                if pair not in middle:
                    own = [side] if other < 0 else [side, other]
                    at = topology.middles[edge]
                    opposite = [surface.triangles[s // 3, (s % 3 + 2) % 3] for s in own]
                    inward = surface.vertices[opposite].mean(axis=0)
                    middle[pair] = len(vertices)
                    vertices.append((at + INWARD * (inward - at)).tolist())
                triangles[side // 3] = [a, middle[pair], c]
                triangles.append([middle[pair], b, c])
        if not changed:
            return surface
        surface = Surface.from_arrays(np.array(vertices), np.array(triangles, np.int32)).orient()
    return surface


def _find_middle(surface: Surface, corners: NDArray[np.intp]) -> Points:
    """(3,) the middle of what is opposite these corners."""
    triangle, e = corners // 3, corners % 3
    opposite = surface.triangles[triangle[:, None], (e[:, None] + [1, 2]) % 3]
    return surface.vertices[opposite].mean(axis=(0, 1))
