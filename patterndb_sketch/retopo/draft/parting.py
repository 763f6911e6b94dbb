"""Part a surface where it touches itself in single vertices, for a draft to be made of it.

Meshes of modelling programs have them where vertices were merged by their distance. A field sees
no disk around such a vertex, and no triangle or edge is concerned: each of the fans of triangles
that meet there gets a vertex of its own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points
from patterndb_sketch.retopo.ground import Ground
from patterndb_sketch.retopo.network.faces import GroundParts

#: A fan's new vertex lies inward from where the fans touch by this part of its edges: more than
#: rounding, by which vertices would be taken for one again, and less than anybody sees.
INWARD = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class PartedGround:
    """ground: with the same triangles. touching: (k,) int32, vertices where fans had met."""

    ground: Ground
    touching: Int32Array


def part_touching(ground: Ground) -> PartedGround:
    """The ground with a vertex for each fan of triangles; itself, where no fans touch.

    Vertices of edges that more than two triangles have stay as they are: which of these belong
    together is not known.
    """
    corner = ground.triangles.ravel().astype(np.int64)
    fan = GroundParts.of(ground).fan
    pairs = np.unique(np.stack([corner, fan], axis=1), axis=0)
    fans = np.bincount(pairs[:, 0], minlength=len(ground.vertices))
    crowded = np.diff(ground.topology.side_start) > 2
    fans[ground.topology.ends[crowded].ravel()] = 1
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


def _find_middle(ground: Ground, corners: NDArray[np.intp]) -> Points:
    """(3,) the middle of what is opposite these corners."""
    triangle, e = corners // 3, corners % 3
    opposite = ground.triangles[triangle[:, None], (e[:, None] + [1, 2]) % 3]
    return ground.vertices[opposite].mean(axis=(0, 1))
