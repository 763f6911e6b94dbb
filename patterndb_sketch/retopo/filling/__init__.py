"""Filling: from a network of curves to quads.

:mod:`.counting` chooses how many edges every chain has, :mod:`.choosing` a fill for every patch
from the pattern database, :mod:`.placing` lays it on the ground, and :mod:`.meshing` welds the
patches to one mesh. :mod:`.choice` is what the network keeps of it.
"""

from patterndb_sketch.retopo.filling.choice import Choice, Filling, Flow
from patterndb_sketch.retopo.filling.edgecounts import (
    changed,
    chosen_anew,
    counted,
    freed,
    lengths,
    strip,
)
from patterndb_sketch.retopo.filling.fills import (
    filling_of,
    let_go,
    ranked,
    stepped,
    suits,
    taken,
    with_flow,
    without_flows,
)
from patterndb_sketch.retopo.filling.mesh import (
    Cache,
    FilledNetwork,
    RetopoMesh,
    completed,
    irregular_vertices,
    open_edges,
    welded,
)
from patterndb_sketch.retopo.filling.placing import Placed, border, divided, placed

__all__ = [
    "Cache",
    "Choice",
    "FilledNetwork",
    "Filling",
    "Flow",
    "Placed",
    "RetopoMesh",
    "border",
    "changed",
    "chosen_anew",
    "completed",
    "counted",
    "divided",
    "filling_of",
    "freed",
    "irregular_vertices",
    "lengths",
    "let_go",
    "open_edges",
    "placed",
    "ranked",
    "stepped",
    "strip",
    "suits",
    "taken",
    "welded",
    "with_flow",
    "without_flows",
]
