"""Part a surface where it touches itself in vertices or along edges, for a draft to be made of it.

Meshes of modelling programs do where vertices were merged by their distance. A field sees no disk
around such a vertex: each of the fans of triangles that meet there gets a vertex of its own. Of
more than two triangles at an edge those go on together that are neighbours on the ground; an odd
one ends there in a border.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.errors import InvalidMeshError
from patterndb.geometry.points import Points
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.ground import Ground
from patterndb_sketch.retopo.network.faces import GroundParts

#: A fan's new vertex lies inward from where the fans touch by this part of its edges: more than
#: rounding, by which vertices would be taken for one again, and less than anybody sees.
INWARD = 0.01

#: A triangle has three sides: in so many rounds each is divided.
MOST_ROUNDS = 4


@dataclass(frozen=True, slots=True, eq=False)
class PartedGround:
    """ground: with the same triangles. touching: (k,) int32, vertices where fans had met."""

    ground: Ground
    touching: Int32Array


def part_touching(ground: Ground) -> PartedGround:
    """The ground with a vertex for each fan of triangles; itself, where no fans touch.

    Raises RefusedError, with the place, where what is parted has one side only: sheets that were
    told apart by more than two triangles at an edge.
    """
    try:
        parted = _part_fans(ground)
        again = _divide_crowded(parted.ground)
    except InvalidMeshError as error:
        raise RefusedError(f"no draft: where parts of it touch, {error}") from error
    if again is parted.ground:
        return parted
    crowded = np.flatnonzero(np.diff(parted.ground.topology.side_start) > 2)
    ends = np.unique(parted.ground.topology.ends[crowded].ravel())
    ends = ends[ends < len(ground.vertices)]
    return PartedGround(again, np.union1d(parted.touching, ends).astype(np.int32))


def _part_fans(ground: Ground) -> PartedGround:
    """The same, for all but edges both of whose ends have their triangles in one fan."""
    corner = ground.triangles.ravel().astype(np.int64)
    fan = GroundParts.of(ground).fan
    pairs = np.unique(np.stack([corner, fan], axis=1), axis=0)
    fans = np.bincount(pairs[:, 0], minlength=len(ground.vertices))
    touching = np.flatnonzero(fans > 1).astype(np.int32)
    if not len(touching):
        return PartedGround(ground, touching)
    vertices, more = ground.vertices.copy(), list[Points]()
    triangles = ground.triangles.copy().ravel()
    for vertex in touching.tolist():
        at = ground.vertices[vertex]
        for k, one in enumerate(pairs[pairs[:, 0] == vertex, 1].tolist()):
            mine = np.flatnonzero(fan == one)
            inward = at + INWARD * (_find_middle(ground, mine) - at)
            if k == 0:
                vertices[vertex] = inward
                continue
            triangles[mine] = len(vertices) + len(more)
            more.append(inward)
    parted = Ground.of(np.concatenate([vertices, more]), triangles.reshape(-1, 3))
    return PartedGround(parted, touching)


def _divide_crowded(ground: Ground) -> Ground:
    """The ground with a middle for each pair of triangles at edges of more than two whose ends are
    in one fan; itself, where there are none. Triangles with several such edges take rounds."""
    for _ in range(MOST_ROUNDS):
        topology = ground.topology
        crowded = np.flatnonzero(np.diff(topology.side_start) > 2)
        triangles, vertices = ground.triangles.tolist(), ground.vertices.tolist()
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
                a, b, c = ground.triangles[side // 3, (side % 3 + np.arange(3)) % 3].tolist()
                if pair not in middle:
                    own = [side] if other < 0 else [side, other]
                    at = topology.middles[edge]
                    opposite = [ground.triangles[s // 3, (s % 3 + 2) % 3] for s in own]
                    inward = ground.vertices[opposite].mean(axis=0)
                    middle[pair] = len(vertices)
                    vertices.append((at + INWARD * (inward - at)).tolist())
                triangles[side // 3] = [a, middle[pair], c]
                triangles.append([middle[pair], b, c])
        if not changed:
            return ground
        ground = Ground.of(np.array(vertices), np.array(triangles, np.int32))
    return ground


def _find_middle(ground: Ground, corners: NDArray[np.intp]) -> Points:
    """(3,) the middle of what is opposite these corners."""
    triangle, e = corners // 3, corners % 3
    opposite = ground.triangles[triangle[:, None], (e[:, None] + [1, 2]) % 3]
    return ground.vertices[opposite].mean(axis=(0, 1))
