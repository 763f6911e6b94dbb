"""What is wrong with a mesh that its holes alone do not show: sentences for people."""

from __future__ import annotations

import numpy as np

from patterndb.core.polygonmesh import PolygonMesh
from query.holes.coincidence import find_coincident_edges
from query.holes.loops import MeshTopology, explain_closed, explain_crowded


def list_mesh_flaws(mesh: PolygonMesh | MeshTopology) -> tuple[str, ...]:
    """List what somebody that fills holes of a mesh should know of it, a sentence each.

    Edges of more than two faces, faces that are turned against their neighbours, border edges that
    lie on each other though no vertex joins them, and that a mesh is closed. Vertices and faces
    count from 0. Raises InvalidMeshError for a one-sided mesh.
    """
    topology = mesh if isinstance(mesh, MeshTopology) else MeshTopology.of(mesh)
    border = np.flatnonzero((topology.twin < 0) & ~topology.crowded)
    notes: list[str] = []
    if not len(border):
        notes.append(explain_closed(topology))
    elif topology.crowded.any():
        notes.append(explain_crowded(topology))
    turned = np.flatnonzero(topology.flipped)
    if len(turned):
        are = "face is" if len(turned) == 1 else "faces are"
        notes.append(
            f"{len(turned):,} {are} turned against the others of the same part, such as face "
            f"{turned[0]}; holes are found as if all were turned alike, and a fill is turned as "
            "most faces beside it are"
        )
    partner, apart = find_coincident_edges(
        topology.mesh.points, topology.tail[border], topology.head[border]
    )
    lying = np.flatnonzero(partner >= 0)
    if len(lying):
        names = [
            f"{topology.tail[border[i]]} and {topology.head[border[i]]}"
            for i in (lying[0], partner[lying[0]])
        ]
        notes.append(
            f"{len(lying):,} of {len(border):,} border edges lie on another one, up to "
            f"{apart[lying].max():.3g} away, such as that between vertices {names[0]} on that "
            f"between {names[1]}: the mesh is open there, though no gap is seen; if it should not "
            "be, merge the vertices that lie at one place first"
        )
    return tuple(notes)
