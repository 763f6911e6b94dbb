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
    from patterndb_sketch.curvenetwork.joining import network_of_polylines
    from patterndb_sketch.curvenetwork.network import InvalidNetworkError
    from patterndb_sketch.surfacing.cycles import FoundCycles, find_cycles
    from patterndb_sketch.surfacing.methods import SurfaceRequest
    from patterndb_sketch.surfacing.networkfile import read_drawing, write_network
    from patterndb_sketch.surfacing.openings import find_openings
    from patterndb_sketch.surfacing.patch import SurfacePatch, Surfacing
    from patterndb_sketch.surfacing.surfaces import surface

__all__ = [
    "FoundCycles",
    "InvalidNetworkError",
    "SurfacePatch",
    "SurfaceRequest",
    "Surfacing",
    "find_cycles",
    "find_openings",
    "network_of_polylines",
    "read_drawing",
    "surface",
    "write_network",
]

#: The module that defines each public name.
_HOMES = {
    "FoundCycles": "patterndb_sketch.surfacing.cycles",
    "InvalidNetworkError": "patterndb_sketch.curvenetwork.network",
    "SurfaceRequest": "patterndb_sketch.surfacing.methods",
    "SurfacePatch": "patterndb_sketch.surfacing.patch",
    "Surfacing": "patterndb_sketch.surfacing.patch",
    "find_cycles": "patterndb_sketch.surfacing.cycles",
    "find_openings": "patterndb_sketch.surfacing.openings",
    "network_of_polylines": "patterndb_sketch.curvenetwork.joining",
    "read_drawing": "patterndb_sketch.surfacing.networkfile",
    "surface": "patterndb_sketch.surfacing.surfaces",
    "write_network": "patterndb_sketch.surfacing.networkfile",
}

__getattr__, __dir__ = lazy_exports(__name__, _HOMES)
