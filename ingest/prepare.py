"""Preparing a mesh: polychords that only refine it are collapsed before patches are taken.

Irregular vertices come closer together, so patches of the same number of quads hold more
of them. A polychord is collapsed as in a patch (it does not cross itself, its chains are
simple and disjoint, one of them is regular), unless that would make a degenerate quad or an
edge of three quads. Around holes the outcome depends on the order; the polychord with the
smallest quad goes first, again and again, so that a mesh always gives one result.

Source: Marcias et al. 2015, section 3.2 ("Mesh preprocessing").
"""

from __future__ import annotations

import numpy as np

from patterndb._native.ingest.prepare import collapse_all
from patterndb.core.quadmesh import QuadMesh


def prepare(mesh: QuadMesh) -> QuadMesh:
    """The mesh with every polychord collapsed that may be.

    Its ``source`` and ``source_quad`` name vertices and quads as the given mesh's do. A
    component never vanishes.
    """
    quads = mesh.quads.copy()
    twin = mesh.twin.copy()
    alive = collapse_all(quads.ravel(), twin, mesh.n_vertices)
    kept = np.flatnonzero(alive)
    place = np.full(mesh.n_quads, -1, np.int32)
    place[kept] = np.arange(len(kept), dtype=np.int32)
    old = twin.reshape(-1, 4)[kept].ravel()
    new = np.where(old >= 0, 4 * place[old >> 2] + (old & 3), -1).astype(np.int32)
    return QuadMesh.from_twin(new, mesh.source[quads[kept]], mesh.source_quad[kept])
