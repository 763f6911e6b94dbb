"""Surface patches for curve networks: network -> cycles -> chords -> pieces -> mesh.

After Abbasinejad, Joshi, Amenta, Simons and Grimm, "Surface patches for 3D sketching" (2013).
"""

from patterndb_sketch.surfacing.cycles import FoundCycles, find_cycles
from patterndb_sketch.surfacing.joining.junctions import network_of_polylines
from patterndb_sketch.surfacing.methods import Settings, surface_loop
from patterndb_sketch.surfacing.naming import named_cycle
from patterndb_sketch.surfacing.network import (
    Curve,
    CurveNetwork,
    Cycle,
    Drawing,
    InvalidNetworkError,
)
from patterndb_sketch.surfacing.networkfile import (
    read_drawing,
    read_network,
    read_recorded_patches,
    write_network,
)
from patterndb_sketch.surfacing.patch import LoopSurface, SurfacePatch, Surfacing
from patterndb_sketch.surfacing.sampling import Loop, Sampling, default_spacing, loop_of, sample
from patterndb_sketch.surfacing.surface import GrowingSketch, LoopMemory, Stage, surface
from patterndb_sketch.surfacing.tessellation import Canvas

#: The name that CurveNetwork had at first.
Network = CurveNetwork

__all__ = [
    "Canvas",
    "Curve",
    "CurveNetwork",
    "Cycle",
    "Drawing",
    "FoundCycles",
    "GrowingSketch",
    "InvalidNetworkError",
    "Loop",
    "LoopMemory",
    "LoopSurface",
    "Network",
    "Sampling",
    "Settings",
    "Stage",
    "SurfacePatch",
    "Surfacing",
    "default_spacing",
    "find_cycles",
    "loop_of",
    "named_cycle",
    "network_of_polylines",
    "read_drawing",
    "read_network",
    "read_recorded_patches",
    "sample",
    "surface",
    "surface_loop",
    "write_network",
]
