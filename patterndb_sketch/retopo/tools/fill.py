"""The tools for which fill a patch has: flow lines, and the choice from its list."""

from __future__ import annotations

from typing import Any

import numpy as np

from patterndb_sketch.retopo.arguments import AT, Argument, Number, PointList, Vector
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.filling import (
    add_flow,
    clear_flows,
    complete_counts,
    step_fill,
    take_fill,
)
from patterndb_sketch.retopo.filling.location import find_patch
from patterndb_sketch.retopo.tool import Control, Result, Tool, ToolWork


def _flow(work: ToolWork, a: dict[str, Any]) -> Result:
    if (a["points"] is None) == (a["clear"] is None):
        raise InvalidRetopoError("flow needs one of points, and clear: a point in the patch")
    if a["points"] is not None:
        drawn = work.clean_stroke_here(a["points"], "the line")
        patch = find_patch(work.network, work.surface, drawn.points[len(drawn.points) // 2])
        line = drawn.points
        if drawn.closed:
            line = np.concatenate([line, line[:1]])
        return work.keep_network(add_flow(work.network, patch, line))
    return work.keep_network(
        clear_flows(work.network, find_patch(work.network, work.surface, a["clear"]))
    )


FLOW = Tool(
    "flow",
    "Draw a line within a patch that its edges are to follow, or clear a patch's lines.",
    {
        "points": Argument(PointList(), "the line", None),
        "clear": Argument(Vector(), "a point in the patch", None),
    },
    _flow,
    position=120,
    control=Control("w", "flow", "draw where edges are to flow    click: clear", "within", "patch"),
)


def _choose(work: ToolWork, a: dict[str, Any]) -> Result:
    if (a["by"] is None) == (a["number"] is None):
        raise InvalidRetopoError("choose needs by, how many on in the list, or number")
    network, notes = complete_counts(work.network, work.state.sizes.edge)
    patch = find_patch(network, work.surface, a["at"])
    if a["by"] is not None:
        return work.keep_network(step_fill(network, patch, work.source, a["by"]), notes)
    return work.keep_network(take_fill(network, patch, work.source, a["number"]), notes)


CHOOSE = Tool(
    "choose",
    "Take another fill of a patch's list.",
    {
        "at": AT,
        "by": Argument(Number(-1000, 1000, whole=True), "how many on in the list", None),
        "number": Argument(
            Number(0, 1000, whole=True), "its number in the list", None, option=False
        ),
    },
    _choose,
    position=130,
    control=Control(
        "y",
        "fill",
        "click a patch: its next fill    n b: next, before",
        target="patch",
        fixed=(("by", 1),),
    ),
)
