"""Placing: where the vertices of a fill lie, in the plane, in space or on a surface.

Read strands (the strips of quads that strokes pull), laplace (interior vertices at the means of
their neighbours), leastsquares (other linear systems), region (what a boundary encloses on a
surface), projection (surfaces and planes to be placed on, rounds of smoothing and projection),
untangle (flipped quads), flow (how well strands follow strokes), and placement, which has
:func:`place`. Fills of holes, retopology, drafts and grids of parallelograms are placed by the same
steps. Placing takes whatever has a fill's quads and sides
(:class:`query.placing.strands.SidedDisk`), and knows nothing of patterns.

Names are loaded when they are asked for: scipy, which only some need, takes a moment.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from patterndb.system.lazy import lazy_exports

if TYPE_CHECKING:
    from patterndb.geometry.quadshape import quality
    from patterndb.geometry.surface import Surface
    from query.placing.flow import measure_flow_distance
    from query.placing.laplace import lay_flat
    from query.placing.placement import Placement, place
    from query.placing.region import Region, enclose_region
    from query.placing.strands import Strand, find_loops, find_strand

__all__ = [
    "Placement",
    "Region",
    "Strand",
    "Surface",
    "enclose_region",
    "find_loops",
    "find_strand",
    "lay_flat",
    "measure_flow_distance",
    "place",
    "quality",
]

_HOME = {
    "Placement": "query.placing.placement",
    "Region": "query.placing.region",
    "Strand": "query.placing.strands",
    "Surface": "patterndb.geometry.surface",
    "enclose_region": "query.placing.region",
    "find_loops": "query.placing.strands",
    "find_strand": "query.placing.strands",
    "lay_flat": "query.placing.laplace",
    "measure_flow_distance": "query.placing.flow",
    "place": "query.placing.placement",
    "quality": "patterndb.geometry.quadshape",
}

__getattr__, __dir__ = lazy_exports(__name__, _HOME)
