"""Tessellation: the pieces of a patch as triangles, and what can be asked of them."""

from sketch.surfacing.tessellation.interior import MAX_INNER
from sketch.surfacing.tessellation.intersections import self_intersections
from sketch.surfacing.tessellation.minimalarea import MAX_VERTICES, minimal_area
from sketch.surfacing.tessellation.picking import Canvas, Drawn, Pick, draw, pick
from sketch.surfacing.tessellation.piece import Tessellation, tessellate
from sketch.surfacing.tessellation.pieces import PatchMesh, patch_of_least_area, tessellate_patch
from sketch.surfacing.tessellation.triangles import area

__all__ = [
    "MAX_INNER",
    "MAX_VERTICES",
    "Canvas",
    "Drawn",
    "PatchMesh",
    "Pick",
    "Tessellation",
    "area",
    "draw",
    "minimal_area",
    "patch_of_least_area",
    "pick",
    "self_intersections",
    "tessellate",
    "tessellate_patch",
]
