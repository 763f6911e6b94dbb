"""Filling: from a network of curves to quads.

Read :mod:`.choice` (what the network keeps of a patch's fill), :mod:`.edgecounts` (how many edges
every chain has), :mod:`.placing` (where a fill lies on the surface), :mod:`.fills` (which fill a
patch gets from the pattern database), :mod:`.location` (which patch a point is in),
:mod:`.mesh` (all patches welded to one mesh) and :mod:`.report`;
:mod:`.expansion` is for tools that make a fill's strips wider.
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
    fill_between,
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
    weld_patches,
)
from patterndb_sketch.retopo.filling.placing import (
    PlacedPatch,
    divide_chain,
    place_fill,
    trace_border,
)

__all__ = [
    "Choice",
    "FilledNetwork",
    "Filling",
    "Flow",
    "PlacedCache",
    "PlacedPatch",
    "RetopoMesh",
    "add_flow",
    "change_counts",
    "choose_counts",
    "clear_flows",
    "complete_counts",
    "divide_chain",
    "fill_between",
    "fill_network",
    "filling_of",
    "find_irregular_vertices",
    "find_open_edges",
    "find_strip",
    "free_counts",
    "has_suitable_fill",
    "place_fill",
    "rank_fills",
    "release_vertices",
    "side_lengths",
    "step_fill",
    "take_fill",
    "trace_border",
    "weld_patches",
]
