"""Placing: where the vertices of a fill lie, in the plane, in space or on a surface.

Read strands (the strips of quads that strokes pull), laplace (interior vertices at the means of
their neighbours), region (what a boundary encloses on a surface), projection (rounds of smoothing
and projection), untangle (flipped quads), flow (how well strands follow strokes), and placement,
which has :func:`place`. Placing takes whatever has a fill's quads and sides
(:class:`query.placing.strands.SidedDisk`), and knows nothing of patterns.

Names are loaded when they are asked for: scipy, which only some need, takes a moment.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from patterndb.geometry.quadshape import quality
    from patterndb.geometry.surface import Surface
    from query.placing.flow import flow_distance
    from query.placing.laplace import laid
    from query.placing.placement import Placement, place
    from query.placing.region import Region, enclosed
    from query.placing.strands import Strand, loops, strand

__all__ = [
    "Placement",
    "Region",
    "Strand",
    "Surface",
    "enclosed",
    "flow_distance",
    "laid",
    "loops",
    "place",
    "quality",
    "strand",
]

_HOME = {
    "Placement": "query.placing.placement",
    "Region": "query.placing.region",
    "Strand": "query.placing.strands",
    "Surface": "patterndb.geometry.surface",
    "enclosed": "query.placing.region",
    "flow_distance": "query.placing.flow",
    "laid": "query.placing.laplace",
    "loops": "query.placing.strands",
    "place": "query.placing.placement",
    "quality": "patterndb.geometry.quadshape",
    "strand": "query.placing.strands",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = getattr(import_module(_HOME[name]), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
