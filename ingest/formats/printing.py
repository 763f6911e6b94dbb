"""What formats of triangles for printers have in common: polygons cut, their sense kept."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from patterndb.core.polygonmesh import PolygonMesh

if TYPE_CHECKING:
    from patterndb.core.halfedge import Int32Array


def cut_polygons(mesh: PolygonMesh) -> Int32Array:
    """Cut the faces of a mesh into triangles (t, 3) that turn as the faces do.

    Of all ways to cut a face along its diagonals the one with the least area is taken.
    """
    # Imported here because compiled kernels take a moment that reading need not wait for.
    from patterndb.geometry.leastarea import triangulate_cheapest
    from patterndb.geometry.triangulation import SHORTER

    made = [np.zeros((0, 3), np.int32)]
    for face in mesh.faces():
        corners = np.array(face, np.int32)
        if len(corners) == 3:
            made.append(corners[None])
            continue
        cut = np.empty((len(corners) - 2, 3), np.int32)
        triangulate_cheapest(np.ascontiguousarray(mesh.points[corners]), SHORTER, 0.0, cut)
        made.append(corners[cut])
    return np.concatenate(made)
