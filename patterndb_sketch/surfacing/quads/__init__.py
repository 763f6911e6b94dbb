"""Quads in place of triangles: cycles of a curve network filled by the pattern database."""

from patterndb_sketch.surfacing.quads.bridge import QuadPatch, boundary_of, fill_with_quads
from patterndb_sketch.surfacing.quads.counts import EvenEdges, count_even_edges

__all__ = ["EvenEdges", "QuadPatch", "boundary_of", "count_even_edges", "fill_with_quads"]
