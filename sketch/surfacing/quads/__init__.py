"""Quads in place of triangles: cycles of a curve network filled by the pattern database."""

from sketch.surfacing.quads.bridge import QuadPatch, fill_with_quads
from sketch.surfacing.quads.counts import EvenEdges, even_edges
from sketch.surfacing.quads.sides import boundary_of

__all__ = ["EvenEdges", "QuadPatch", "boundary_of", "even_edges", "fill_with_quads"]
