"""Tessellation: the pieces of a patch as triangles, and what can be asked of them."""

from patterndb_sketch.surfacing.tessellation.piece import (
    MAX_INNER,
    MAX_VERTICES,
    PatchMesh,
    Tessellation,
    minimal_area,
    patch_of_least_area,
    tessellate,
    tessellate_patch,
    triangulate_flat,
)
from patterndb_sketch.surfacing.tessellation.triangles import area, find_self_intersections

__all__ = [
    "MAX_INNER",
    "MAX_VERTICES",
    "PatchMesh",
    "Tessellation",
    "area",
    "find_self_intersections",
    "minimal_area",
    "patch_of_least_area",
    "tessellate",
    "tessellate_patch",
    "triangulate_flat",
]
