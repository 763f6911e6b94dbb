"""Collapsing one polychord of a mesh in work: may it be, and doing it.

The mesh is changed in place, so that a collapse costs what lies around the polychord and not
what the mesh has in all.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array


class Work(NamedTuple):
    """The mesh in work. Corners of a vertex form a ring by ``after`` and ``before``.

    vertex, twin, after, before: (4q,) int32; corner: (v,) int32 one corner of each vertex;
    valence: (v,) int32; border: (v,) bool; alive: (q,) bool. dirty: (2q,) bool strands
    (2 * quad + direction) that may collapse or have not been looked at since something
    changed beside them. stamp: (1,) int64; seen: (v,) int64; passed: (q,) int64.
    merged: (v,) int32 the vertex that each stamped one goes into. uses: (v,) int32.
    """

    vertex: Int32Array
    twin: Int32Array
    after: Int32Array
    before: Int32Array
    corner: Int32Array
    valence: Int32Array
    border: NDArray[np.bool_]
    alive: NDArray[np.bool_]
    dirty: NDArray[np.bool_]
    stamp: NDArray[np.int64]
    seen: NDArray[np.int64]
    passed: NDArray[np.int64]
    merged: Int32Array
    counted: NDArray[np.int64]
    uses: Int32Array
