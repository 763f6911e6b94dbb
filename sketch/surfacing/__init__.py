"""Surface patches for curve networks: network -> cycles -> chords -> pieces -> mesh.

After Abbasinejad, Joshi, Amenta, Simons and Grimm, "Surface patches for 3D sketching" (2013).
"""

from sketch.surfacing.cycles import FoundCycles, find_cycles
from sketch.surfacing.drawing import Drawing
from sketch.surfacing.errors import InvalidNetworkError
from sketch.surfacing.growing import GrowingSketch, Stage
from sketch.surfacing.joining.junctions import network_of_polylines
from sketch.surfacing.memory import Memory
from sketch.surfacing.naming import named_cycle
from sketch.surfacing.network import Curve, Cycle, Network
from sketch.surfacing.networkfile import (
    read_drawing,
    read_network,
    read_recorded_patches,
    write_network,
)
from sketch.surfacing.patch import LoopSurface, Patch, Surfacing
from sketch.surfacing.sampling import Loop, Sampling, default_spacing, loop_of, sample
from sketch.surfacing.surface import surface
from sketch.surfacing.surfaceloop import Settings, surface_loop
from sketch.surfacing.tessellation import Canvas

__all__ = [
    "Canvas",
    "Curve",
    "Cycle",
    "Drawing",
    "FoundCycles",
    "GrowingSketch",
    "InvalidNetworkError",
    "Loop",
    "LoopSurface",
    "Memory",
    "Network",
    "Patch",
    "Sampling",
    "Settings",
    "Stage",
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
