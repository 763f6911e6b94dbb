"""Filling: from a network of curves to quads.

:mod:`.counting` chooses how many edges every chain has, :mod:`.choosing` a fill for every patch
from the pattern database, :mod:`.placing` lays it on the ground, and :mod:`.meshing` welds the
patches to one mesh. :mod:`.choice` is what the network keeps of it.
"""

from patterndb_sketch.retopo.filling.choice import Choice, Filling, Flow
from patterndb_sketch.retopo.filling.edgecounts import (
    change_counts,
    choose_counts,
    complete_counts,
    find_strip,
    free_counts,
    side_lengths,
)
from patterndb_sketch.retopo.filling.fills import (
    add_flow,
    clear_flows,
    filling_of,
    has_suitable_fill,
    rank_fills,
    release_vertices,
    step_fill,
    take_fill,
)
from patterndb_sketch.retopo.filling.mesh import (
    FilledNetwork,
    PlacedCache,
    RetopoMesh,
    fill_network,
    find_irregular_vertices,
    find_open_edges,
    weld_fills,
)
from patterndb_sketch.retopo.filling.placing import (
    PlacedPatch,
    divide_chain,
    place_fill,
    trace_border,
)

__all__ = [
    "PlacedCache",
    "Choice",
    "FilledNetwork",
    "Filling",
    "Flow",
    "PlacedPatch",
    "RetopoMesh",
    "trace_border",
    "change_counts",
    "choose_counts",
    "fill_network",
    "complete_counts",
    "divide_chain",
    "filling_of",
    "free_counts",
    "find_irregular_vertices",
    "side_lengths",
    "release_vertices",
    "find_open_edges",
    "place_fill",
    "rank_fills",
    "step_fill",
    "find_strip",
    "has_suitable_fill",
    "take_fill",
    "weld_fills",
    "add_flow",
    "clear_flows",
]
