"""STL files, binary, written for printers: triangles of single precision, nothing shared.

    80 bytes of header, the number of triangles (uint32), and for each its normal, its three corners
    (float32 each) and two bytes that mean nothing

All numbers are little-endian. Quads and other polygons are cut into triangles; what a pattern is
made of is lost, so that STL is not read.

Source: 3D Systems, "StereoLithography Interface Specification" (1989).
"""

from __future__ import annotations

import numpy as np

from ingest.formats.meshformat import MeshFormat, refuse_reading
from patterndb.core.polygonmesh import PolygonMesh

_HEADER = b"binary STL of patterndb".ljust(80)
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("unused", "<u2")])


def format_stl(mesh: PolygonMesh) -> bytes:
    """Return the mesh as the bytes of a binary STL file."""
    # Imported here because it takes a moment that reading need not wait for.
    from patterndb.geometry.points import units
    from patterndb.geometry.triangulation import cut_faces

    triangles, _ = cut_faces(mesh, fan_quads=False)
    corners = mesh.points[triangles]
    rows = np.zeros(len(corners), _TRIANGLE)
    rows["normal"] = units(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    rows["corners"] = corners
    return _HEADER + np.uint32(len(rows)).astype("<u4").tobytes() + rows.tobytes()


FORMAT = MeshFormat(
    "STL",
    (".stl",),
    "binary, for printers; polygons cut into triangles of single precision, written only",
    refuse_reading("STL"),
    format_stl,
)
