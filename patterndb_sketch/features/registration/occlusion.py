"""Which vertices of a template other components hide: a body's top beneath the roof."""

from __future__ import annotations

import numpy as np

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Bools, Points
from patterndb.geometry.trianglemesh import TriangleMesh
from patterndb_sketch.features.registration.template import Template

MIRROR = np.array([1.0, -1.0, 1.0])


def occluded(template: Template, points: Points, normals: Points) -> Bools:
    """(v,) bool, the free vertices that a component hides to which their own yields.

    points, normals: (v, 3) of the membrane. A vertex is hidden if the ray along its normal hits
    such a component, or if the ray against it first hits one from in front: then the vertex
    spans an opening, as a body's side does before a wheelhouse. Of a half that is mirrored, the
    other half hides too.

    Source: feature curve recovery paper, section 5.1.2. Differs from the paper: it does not say
    which way normals go; the ray along them alone never meets a wheelhouse, which is behind the
    side, and both ways alike would take the hood above a wheelhouse for hidden.
    """
    result = np.zeros(template.n_vertices, np.bool_)
    free = ~template.fixed & (normals != 0.0).any(axis=1)
    for number, part in enumerate(template.parts):
        mine = np.flatnonzero(free & (template.of_part == number))
        if not part.yields_to or not len(mine):
            continue
        mesh = TriangleMesh.from_corners(_triangles(template, points, part.yields_to))
        begin, along = points[mine], normals[mine]
        ahead = mesh.cast_rays(begin, along)[0] >= 0
        behind = mesh.cast_rays(begin, -along)[0]
        a, b, c = mesh.corners[behind].transpose(1, 0, 2)
        facing = np.einsum("nc,nc->n", np.cross(b - a, c - a), along) > 0.0
        result[mine] = ahead | ((behind >= 0) & facing)
    return result


def _triangles(template: Template, points: Points, parts: tuple[str, ...]) -> Points:
    """(t, 3, 3) the triangles of parts, turned as their quads are, and their mirror images."""
    quads: Int32Array = np.concatenate([template.part_quads(name) for name in parts])
    corners = points[np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])]
    if template.mirrored:
        corners = np.concatenate([corners, (corners * MIRROR)[:, ::-1]])
    return np.ascontiguousarray(corners)
