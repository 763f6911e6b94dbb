"""Tools for the quads themselves: loops, irregular vertices, and where vertices lie."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from patterndb_sketch.retopo.arguments import Argument, Number, Vector
from patterndb_sketch.retopo.filling.location import patch_at
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tool import Result, Tool, Work
from patterndb_sketch.retopo.tools.insertloop import insert_loop
from patterndb_sketch.retopo.tools.movepair import move_pair
from patterndb_sketch.retopo.tools.vertexbrush import ROUNDS, brush, relax

#: Rounds of smoothing, at most, that a call may ask for.
MOST_ROUNDS = 100

RADIUS = Argument(Number(1e-12), "of the brush, in the surface's unit", None)


def _insert_loop(work: Work, a: dict[str, Any]) -> Result:
    foot = work.foot(a["at"])
    return work.edited(
        insert_loop(
            work.network,
            work.ground,
            work.source,
            work.state.sizes,
            foot.points[0],
            foot.normals[0],
        )
    )


def _move_pair(work: Work, a: dict[str, Any]) -> Result:
    start, end = work.foot(a["at"]), work.foot(a["to"])
    patch = patch_at(work.network, work.ground, a["at"])
    return work.edited(
        move_pair(
            work.network,
            work.ground,
            work.source,
            work.state.sizes,
            patch,
            start.points[0],
            end.points[0] - start.points[0],
        )
    )


def _brush(work: Work, a: dict[str, Any]) -> Result:
    start, end = work.foot(a["at"]), work.foot(a["to"])
    return work.edited(
        brush(
            work.network,
            work.ground,
            work.source,
            _sizes(work, "brush", a["radius"]),
            start.points[0],
            start.normals[0],
            end.points[0],
        )
    )


def _relax(work: Work, a: dict[str, Any]) -> Result:
    start = work.foot(a["at"])
    return work.edited(
        relax(
            work.network,
            work.ground,
            work.source,
            _sizes(work, "relax", a["radius"]),
            start.points[0],
            start.normals[0],
            a["rounds"],
        )
    )


def _sizes(work: Work, tool: str, radius: float | None) -> Sizes:
    """The sizes with the brush that a call asks for."""
    if radius is None:
        return work.state.sizes
    return replace(work.state.sizes, brush=work.length(f"{tool}: radius", radius))


TOPOLOGY: tuple[Tool, ...] = (
    Tool(
        "insertloop",
        "Insert an edge loop along the strip of quads through an edge.",
        {"at": Argument(Vector(), "a point of the surface near the edge")},
        _insert_loop,
    ),
    Tool(
        "movepair",
        "Move the two irregular vertices of a patch that are nearest, its border staying.",
        {
            "at": Argument(Vector(), "a point of the patch, near the pair"),
            "to": Argument(Vector(), "where it is dragged to"),
        },
        _move_pair,
    ),
    Tool(
        "brush",
        "Drag the quads' vertices under the brush; curves follow.",
        {
            "at": Argument(Vector(), "a point of the surface, the brush's middle"),
            "to": Argument(Vector(), "where it is dragged to"),
            "radius": RADIUS,
        },
        _brush,
    ),
    Tool(
        "relax",
        "Smooth the quads' vertices under the brush; curves follow.",
        {
            "at": Argument(Vector(), "a point of the surface, the brush's middle"),
            "radius": RADIUS,
            "rounds": Argument(Number(1, MOST_ROUNDS, whole=True), "of smoothing", ROUNDS),
        },
        _relax,
    ),
)
