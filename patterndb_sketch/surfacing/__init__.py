"""Surfaces of curve networks: network -> cycles -> chords -> pieces -> mesh.

Curve networks, and how drawn curves become one, are in :mod:`patterndb_sketch.curvenetwork`. Read
networkfile with files/: how a network is read; cycles/: which closed walks are patches; sampling:
the vertices that patches share; methods: the ways to make a patch, one table; chords/,
tessellation/ and quads/: what these ways are made of; fairing: patches that share normals;
surfaces: the surface of a loop, of a network and of a growing sketch; patch: its result; openings:
curves and rims that stay open; inking and edits: strokes on a surface as new curves, cycles
switched on and off.

After Abbasinejad, Joshi, Amenta, Simons and Grimm, "Surface patches for 3D sketching" (2013).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from patterndb.system.lazy import lazy_exports

if TYPE_CHECKING:
    from patterndb_sketch.curvenetwork.drawing import Drawing
    from patterndb_sketch.curvenetwork.joining import network_of_polylines
    from patterndb_sketch.curvenetwork.naming import named_cycle
    from patterndb_sketch.curvenetwork.network import (
        Curve,
        CurveNetwork,
        Cycle,
        InvalidNetworkError,
    )
    from patterndb_sketch.surfacing.cycles import FoundCycles, find_cycles
    from patterndb_sketch.surfacing.methods import SurfaceOptions
    from patterndb_sketch.surfacing.networkfile import (
        read_drawing,
        read_network,
        read_recorded_patches,
        write_network,
    )
    from patterndb_sketch.surfacing.openings import Openings, OpenRim, find_openings
    from patterndb_sketch.surfacing.patch import LoopSurface, SurfacePatch, Surfacing
    from patterndb_sketch.surfacing.sampling import (
        Loop,
        Sampling,
        default_spacing,
        loop_of,
        sample,
    )
    from patterndb_sketch.surfacing.surfaces import (
        GrowingSketch,
        LoopMemory,
        Stage,
        surface,
        surface_loop,
    )

#: Where each name stands: what is asked for is imported, and nothing else. The table of methods
#: must not wait for solvers.
_HOME = {
    "FoundCycles": "patterndb_sketch.surfacing.cycles",
    "find_cycles": "patterndb_sketch.surfacing.cycles",
    "network_of_polylines": "patterndb_sketch.curvenetwork.joining",
    "named_cycle": "patterndb_sketch.curvenetwork.naming",
    "Curve": "patterndb_sketch.curvenetwork.network",
    "CurveNetwork": "patterndb_sketch.curvenetwork.network",
    "Cycle": "patterndb_sketch.curvenetwork.network",
    "Drawing": "patterndb_sketch.curvenetwork.drawing",
    "InvalidNetworkError": "patterndb_sketch.curvenetwork.network",
    "read_drawing": "patterndb_sketch.surfacing.networkfile",
    "read_network": "patterndb_sketch.surfacing.networkfile",
    "read_recorded_patches": "patterndb_sketch.surfacing.networkfile",
    "write_network": "patterndb_sketch.surfacing.networkfile",
    "OpenRim": "patterndb_sketch.surfacing.openings",
    "Openings": "patterndb_sketch.surfacing.openings",
    "find_openings": "patterndb_sketch.surfacing.openings",
    "LoopSurface": "patterndb_sketch.surfacing.patch",
    "SurfacePatch": "patterndb_sketch.surfacing.patch",
    "Surfacing": "patterndb_sketch.surfacing.patch",
    "Loop": "patterndb_sketch.surfacing.sampling",
    "Sampling": "patterndb_sketch.surfacing.sampling",
    "default_spacing": "patterndb_sketch.surfacing.sampling",
    "loop_of": "patterndb_sketch.surfacing.sampling",
    "sample": "patterndb_sketch.surfacing.sampling",
    "GrowingSketch": "patterndb_sketch.surfacing.surfaces",
    "LoopMemory": "patterndb_sketch.surfacing.surfaces",
    "SurfaceOptions": "patterndb_sketch.surfacing.methods",
    "Stage": "patterndb_sketch.surfacing.surfaces",
    "surface": "patterndb_sketch.surfacing.surfaces",
    "surface_loop": "patterndb_sketch.surfacing.surfaces",
}

__all__ = [
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
    "OpenRim",
    "Openings",
    "Sampling",
    "Stage",
    "SurfaceOptions",
    "SurfacePatch",
    "Surfacing",
    "default_spacing",
    "find_cycles",
    "find_openings",
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

__getattr__, __dir__ = lazy_exports(__name__, _HOME)
