"""Other programs that fill a closed polyline: MeshLib's fillHole and CGAL's hole filling.

Only the benchmark asks for them (``pip install '.[benchmark]'``). CGAL's bindings are under
the GPL v3 or later, MeshLib under a licence of its own for non-commercial use, evaluation and
education: nothing outside this folder may import either. Conversions are not timed, only the
calls that fill.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from CGAL import CGAL_Polygon_mesh_processing as cgal
from CGAL.CGAL_Kernel import Point_3
from filling import Filling
from meshlib import mrmeshnumpy, mrmeshpy

from patterndb.geometry.points import Points

#: What MeshLib may hold small, by name; None is its own choice (circumscribed circles).
METRICS: dict[str, Callable[[mrmeshpy.Mesh, mrmeshpy.EdgeId], mrmeshpy.FillHoleMetric] | None] = {
    "default": None,
    "area": lambda mesh, _: mrmeshpy.getMinAreaMetric(mesh),
    "universal": lambda mesh, _: mrmeshpy.getUniversalMetric(mesh),
    "plane": mrmeshpy.getPlaneFillMetric,
}


def meshlib(points: Points, metric: str) -> Filling:
    """MeshLib's fillHole of the closed polyline (n, 3) with one of METRICS."""
    mesh = mrmeshpy.Mesh()
    corners = [mrmeshpy.Vector3f(*(float(x) for x in point)) for point in points]
    edge = mesh.addSeparateEdgeLoop(mrmeshpy.std_vector_Vector3_float(corners))
    parameters = mrmeshpy.FillHoleParams()
    chosen = METRICS[metric]
    started = time.process_time()
    if chosen is not None:
        parameters.metric = chosen(mesh, edge)
    mrmeshpy.fillHole(mesh, edge, parameters)
    seconds = time.process_time() - started
    triangles = np.array(mrmeshnumpy.getNumpyFaces(mesh.topology), np.int64)
    # A vertex may have been added; the loop's own are kept in double precision.
    vertices = np.array(mrmeshnumpy.getNumpyVerts(mesh), np.float64)
    vertices[: len(points)] = points
    return Filling(vertices, triangles, seconds)


def cgal_polyline(points: Points) -> Filling:
    """CGAL's triangulate_hole_polyline of the closed polyline (n, 3).

    Its refine and fair are not asked: they take the density of vertices from the surface around
    a hole. Around a cycle there is none, and they add no vertex (or crash).
    """
    corners = [Point_3(*(float(x) for x in point)) for point in points]
    found: list[cgal.Integer_triple] = []
    started = time.process_time()
    cgal.triangulate_hole_polyline(corners, found)
    seconds = time.process_time() - started
    triangles = np.array([(t.first, t.second, t.third) for t in found], np.int64).reshape(-1, 3)
    return Filling(points, triangles, seconds)


#: The peers by name.
PEERS: dict[str, Callable[[Points], Filling]] = {
    **{f"MeshLib {metric}": (lambda p, m=metric: meshlib(p, m)) for metric in METRICS},
    "CGAL": cgal_polyline,
}
