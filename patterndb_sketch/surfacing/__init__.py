"""Surfaces of curve networks: network -> cycles -> chords -> pieces -> mesh.

Read network (curves, nodes, cycles) and naming (cycles by the names of their curves); networkfile
with files/, and joining/: how a network is read, and how drawn curves become one; cycles/: which
closed walks are patches; sampling: the vertices that patches share; methods: the ways to make a
patch, one table; chords/, tessellation/ and quads/: what these ways are made of; surfaces: the
surface of a loop, of a network and of a growing sketch; patch: what comes of it.

After Abbasinejad, Joshi, Amenta, Simons and Grimm, "Surface patches for 3D sketching" (2013).
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from patterndb_sketch.surfacing.cycles import FoundCycles, find_cycles
    from patterndb_sketch.surfacing.joining.junctions import network_of_polylines
    from patterndb_sketch.surfacing.naming import named_cycle
    from patterndb_sketch.surfacing.network import (
        Curve,
        CurveNetwork,
        Cycle,
        Drawing,
        InvalidNetworkError,
    )
    from patterndb_sketch.surfacing.network import (
        CurveNetwork as Network,
    )
    from patterndb_sketch.surfacing.networkfile import (
        read_drawing,
        read_network,
        read_recorded_patches,
        write_network,
    )
    from patterndb_sketch.surfacing.patch import LoopSurface, SurfacePatch, Surfacing
    from patterndb_sketch.surfacing.sampling import Loop, Sampling, default_spacing, loop_of, sample
    from patterndb_sketch.surfacing.surfaces import (
        GrowingSketch,
        LoopMemory,
        Settings,
        Stage,
        surface,
        surface_loop,
    )
    from patterndb_sketch.surfacing.tessellation import Canvas

#: Where each name stands: what is asked for is imported, and nothing else. The table of methods
#: must not wait for compiled kernels.
_HOME = {
    "FoundCycles": "cycles",
    "find_cycles": "cycles",
    "network_of_polylines": "joining.junctions",
    "named_cycle": "naming",
    "Curve": "network",
    "CurveNetwork": "network",
    "Cycle": "network",
    "Drawing": "network",
    "InvalidNetworkError": "network",
    "read_drawing": "networkfile",
    "read_network": "networkfile",
    "read_recorded_patches": "networkfile",
    "write_network": "networkfile",
    "LoopSurface": "patch",
    "SurfacePatch": "patch",
    "Surfacing": "patch",
    "Loop": "sampling",
    "Sampling": "sampling",
    "default_spacing": "sampling",
    "loop_of": "sampling",
    "sample": "sampling",
    "GrowingSketch": "surfaces",
    "LoopMemory": "surfaces",
    "Settings": "surfaces",
    "Stage": "surfaces",
    "surface": "surfaces",
    "surface_loop": "surfaces",
    "Canvas": "tessellation",
}

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


def __getattr__(name: str) -> Any:
    # The name that CurveNetwork had at first.
    wanted = "CurveNetwork" if name == "Network" else name
    if wanted not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[wanted]}"), wanted)
