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
from numpy.typing import NDArray

from ingest.collapse import Work, begin, collapse, may_collapse, trace_strip
from patterndb.core.halfedge import Int32Array
from patterndb.core.quadmesh import QuadMesh
from patterndb.system.kernels import kernel


def prepare(mesh: QuadMesh) -> QuadMesh:
    """The mesh with every polychord collapsed that may be.

    Its ``source`` and ``source_quad`` name vertices and quads as the given mesh's do. A
    component never vanishes.
    """
    quads = mesh.quads.copy()
    twin = mesh.twin.copy()
    alive = _collapse_all(quads.ravel(), twin, mesh.n_vertices)
    kept = np.flatnonzero(alive)
    place = np.full(mesh.n_quads, -1, np.int32)
    place[kept] = np.arange(len(kept), dtype=np.int32)
    old = twin.reshape(-1, 4)[kept].ravel()
    new = np.where(old >= 0, 4 * place[old >> 2] + (old & 3), -1).astype(np.int32)
    return QuadMesh.from_twin(new, mesh.source[quads[kept]], mesh.source_quad[kept])


@kernel
def _collapse_all(vertex: Int32Array, twin: Int32Array, n_vertices: int) -> NDArray[np.bool_]:
    """Collapse in place; return (q,) bool, the quads that are left."""
    s = begin(vertex, twin, n_vertices)
    n = len(s.alive)
    # Edges by which each quad of the strip at hand is entered.
    strip = np.empty(n + 1, np.int32)
    at = 0
    while at < 2 * n:
        if not s.dirty[at] or not s.alive[at >> 1]:
            at += 1
            continue
        length, loop = trace_strip(4 * (at >> 1) + (at & 1), s, strip)
        if length > 0 and may_collapse(strip, length, loop, s):
            at = min(at, collapse(strip, length, loop, s))
        else:
            _settle(4 * (at >> 1) + (at & 1), s)
            at += 1
    return s.alive


@kernel
def _settle(h: int, s: Work) -> None:
    """Note that the polychord through edge h may not collapse as things stand."""
    start = h
    while s.twin[start] >= 0:
        start = s.twin[start] ^ 2
        if start == h:
            break
    g = start
    while True:
        s.dirty[2 * (g >> 2) + (g & 1)] = False
        g = s.twin[g ^ 2]
        if g < 0 or g == start:
            return
