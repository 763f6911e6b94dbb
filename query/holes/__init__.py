"""Holes of meshes: found, filled with quads vertex for vertex, and welded.

Read in the order of the data: :mod:`topology` (the half-edges of a mesh, and its flaws),
:mod:`loops` (its holes), :mod:`neighbourhood` and :mod:`features` (the mesh around, measured),
:mod:`corners` (quads at each loop vertex), :mod:`patterns`, :mod:`regular` and :mod:`candidates`
(fills of the loop), :mod:`symmetry` (mirror images), :mod:`caps` (flat fills), :mod:`shape` and
:mod:`projection` (placing), :mod:`ranking`, and :mod:`filling`, which goes this way and returns
:mod:`fills`. :mod:`parity` has remedies for odd loops, :mod:`models` what was learned from artists.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from patterndb.system.lazy import lazy_exports

if TYPE_CHECKING:
    from query.holes.filling import fill_holes
    from query.holes.fills import HoleFill, HoleFills, weld_fills
    from query.holes.loops import Hole, choose_hole, find_holes, hole_of_faces, hole_of_loop
    from query.holes.options import HoleOptions
    from query.holes.parity import ParityFix, list_parity_fixes, make_loops_even
    from query.holes.topology import MeshTopology, list_mesh_flaws

__all__ = [
    "Hole",
    "HoleFill",
    "HoleFills",
    "HoleOptions",
    "MeshTopology",
    "ParityFix",
    "choose_hole",
    "fill_holes",
    "find_holes",
    "hole_of_faces",
    "hole_of_loop",
    "list_mesh_flaws",
    "list_parity_fixes",
    "make_loops_even",
    "weld_fills",
]

# Filling needs solvers, which finding need not wait for.
_HOMES = {
    "Hole": "query.holes.loops",
    "HoleFill": "query.holes.fills",
    "HoleFills": "query.holes.fills",
    "HoleOptions": "query.holes.options",
    "MeshTopology": "query.holes.topology",
    "ParityFix": "query.holes.parity",
    "choose_hole": "query.holes.loops",
    "fill_holes": "query.holes.filling",
    "find_holes": "query.holes.loops",
    "hole_of_faces": "query.holes.loops",
    "hole_of_loop": "query.holes.loops",
    "list_mesh_flaws": "query.holes.topology",
    "list_parity_fixes": "query.holes.parity",
    "make_loops_even": "query.holes.parity",
    "weld_fills": "query.holes.fills",
}

__getattr__, __dir__ = lazy_exports(__name__, _HOMES)
