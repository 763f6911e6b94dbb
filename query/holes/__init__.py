"""Holes of meshes: found, filled with quads vertex for vertex, and welded.

Read :mod:`loops` (where a mesh is open), :mod:`coincidence` and :mod:`flaws` (what else is wrong
with it), :mod:`surroundings` (what is known around a loop),
:mod:`context` (farther out, and across), :mod:`corners` (how many quads each loop vertex will get),
:mod:`regular` (fills without irregular vertices inside), :mod:`patterns` (what holes reduce to,
laid into the loop), :mod:`candidates` (those, and fills of
the likely assignments), :mod:`shape` (placing and measuring one), :mod:`twin` (the mirror image of
a hole), :mod:`caps` (is what belongs there flat?), :mod:`laying` (in a plane, on a surface, along
strokes), :mod:`odd` (ways out where no quads fit), and :mod:`filling` (all of it, in order).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from patterndb.system.lazy import lazy_exports

if TYPE_CHECKING:
    from query.holes.filling import HoleFill, HoleFills, choose_hole, fill_holes, weld_fills
    from query.holes.flaws import list_mesh_flaws
    from query.holes.loops import Hole, MeshTopology, find_holes, hole_of_faces, hole_of_loop
    from query.holes.odd import EvenWay, list_even_ways, make_loops_even

__all__ = [
    "EvenWay",
    "Hole",
    "HoleFill",
    "HoleFills",
    "MeshTopology",
    "choose_hole",
    "fill_holes",
    "find_holes",
    "hole_of_faces",
    "hole_of_loop",
    "list_even_ways",
    "list_mesh_flaws",
    "make_loops_even",
    "weld_fills",
]

# Filling needs solvers, which finding need not wait for.
_HOMES = {
    "HoleFill": "query.holes.filling",
    "HoleFills": "query.holes.filling",
    "choose_hole": "query.holes.filling",
    "fill_holes": "query.holes.filling",
    "weld_fills": "query.holes.filling",
    "list_mesh_flaws": "query.holes.flaws",
    "Hole": "query.holes.loops",
    "MeshTopology": "query.holes.loops",
    "find_holes": "query.holes.loops",
    "hole_of_faces": "query.holes.loops",
    "hole_of_loop": "query.holes.loops",
    "EvenWay": "query.holes.odd",
    "list_even_ways": "query.holes.odd",
    "make_loops_even": "query.holes.odd",
}

__getattr__, __dir__ = lazy_exports(__name__, _HOMES)
