"""Quads in place of triangles: cycles of a curve network filled by the pattern database."""

from patterndb_sketch.surfacing.quads.bridge import QuadPatch, fill_with_quads
from patterndb_sketch.surfacing.quads.counts import EvenEdges, even_edges
from patterndb_sketch.surfacing.quads.sides import boundary_of

__all__ = ["EvenEdges", "QuadPatch", "boundary_of", "even_edges", "fill_with_quads"]
