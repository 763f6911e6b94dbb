"""Tools that give curves another course: pull, smooth, redraw and align."""

from __future__ import annotations

from typing import Any

from patterndb_sketch.retopo.arguments import Argument, Flag, Line, Vector, Word
from patterndb_sketch.retopo.tool import Result, Tool, Work
from patterndb_sketch.retopo.tools.pull import held, release
from patterndb_sketch.retopo.tools.redraw import redraw
from patterndb_sketch.retopo.tools.salience import MODES
from patterndb_sketch.retopo.tools.smoothchain import smooth
from patterndb_sketch.retopo.tools.snakes import align

AT = Argument(Vector(), "a point near the curve, or its corner")


def _pull(work: Work, a: dict[str, Any]) -> Result:
    sizes = work.state.sizes
    start, end = work.foot(a["at"]), work.foot(a["to"])
    at = held(work.network, sizes, start.points[0], start.normals[0])
    return work.edited(
        release(work.network, work.ground, sizes, at, end.points[0], end.normals[0], a["smooth"])
    )


def _smooth(work: Work, a: dict[str, Any]) -> Result:
    foot = work.foot(a["at"])
    return work.edited(
        smooth(work.network, work.ground, work.state.sizes, foot.points[0], foot.normals[0])
    )


def _redraw(work: Work, a: dict[str, Any]) -> Result:
    drawn = work.stroke_here(a["points"], "the stroke", False)
    return work.edited(redraw(work.network, work.ground, work.state.sizes, drawn))


def _align(work: Work, a: dict[str, Any]) -> Result:
    foot = work.foot(a["at"])
    return work.edited(
        align(
            work.network,
            work.ground,
            work.state.sizes,
            work.salience(),
            foot.points[0],
            foot.normals[0],
            a["mode"],
        )
    )


SHAPING = (
    Tool(
        "pull",
        "Pull a corner, an open end or a curve to another place; its curves follow.",
        {
            "at": AT,
            "to": Argument(Vector(), "a point of the surface"),
            "smooth": Argument(Flag(), "no corner where an open end joins another", False),
        },
        _pull,
    ),
    Tool("smooth", "Smooth a curve between its ends.", {"at": AT}, _smooth),
    Tool(
        "redraw",
        "Draw a part of a curve anew, from one place on it to another.",
        {"points": Argument(Line(), "the stroke, on the surface")},
        _redraw,
    ),
    Tool(
        "align",
        "Move a curve or a corner onto the ridge or valley beside it.",
        {"at": AT, "mode": Argument(Word(MODES), "what it goes to", "both")},
        _align,
    ),
)
