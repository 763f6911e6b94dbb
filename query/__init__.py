"""Boundary -> fills: which patterns fit, with which widths, expanded to quads, ranked and placed.

Read it in this order:

    boundary, stroke    what is asked: sides and corners, and where the edge flow shall run
    request             the options of a query, and the filters among them
    contour             a boundary while it is drawn and changed
    drawingbase         the surface, or the plane, that it is drawn on
    orientation         the 2N ways in which a pattern can meet a boundary
    relaxed             complete families, and where a boundary's corners may fall on their patterns
    solving             widths that make patterns meet lengths and strokes
    construct           a fill put together of parts, where no pattern has one
    listing             the list of fills: tables, matches by rank, their merging, the orders
    engine              ``fills`` and ``best``, which put the question
    fill, expand        what a fill is, and how a pattern and its widths become one
    recognition         quads from elsewhere read as a fill; when two fills are one
    placing             where the vertices of a fill lie

Names are loaded when they are asked for: ``import query`` waits for no solver.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from patterndb.system.lazy import lazy_exports

if TYPE_CHECKING:
    from query.boundary import Boundary
    from query.engine import best, fills
    from query.fill import Fill
    from query.listing.fills import Fills
    from query.request import FillRequest
    from query.stroke import Stroke

__all__ = ["Boundary", "Fill", "FillRequest", "Fills", "Stroke", "best", "fills"]

_HOME = {
    "Boundary": "query.boundary",
    "Fill": "query.fill",
    "FillRequest": "query.request",
    "Fills": "query.listing.fills",
    "Stroke": "query.stroke",
    "best": "query.engine",
    "fills": "query.engine",
}

__getattr__, __dir__ = lazy_exports(__name__, _HOME)
