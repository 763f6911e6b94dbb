"""Snapping: a call may say within which radius it finds what is near, for itself alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from patterndb_sketch.retopo.editor.arguments import Argument, Number
from patterndb_sketch.retopo.editor.tool import Result, Tool, Work

#: The argument's name.
SNAP = "snap"

#: Tools that find curves, corners or ends near to where they are pressed.
SNAPPING = frozenset(
    {
        "stroke", "spine", "autocomplete", "cylinder", "erase", "corner", "subdivide", "pull",
        "smooth", "redraw", "align", "insertloop",
    }
)  # fmt: skip


def snapping(tool: Tool) -> Tool:
    """A tool that may be told its snap radius; one that finds nothing near stays as it is.

    The radius takes the place of ``Sizes.snap`` for one call: a window reaches less when one
    looks from nearer by, and its calls are the same in a script, whatever the view was.
    """
    if tool.name not in SNAPPING:
        return tool
    radius = Argument(Number(1e-12), "for this call, in place of that of sizes", None)
    return replace(tool, arguments={**tool.arguments, SNAP: radius}, act=_within(tool))


def _within(tool: Tool) -> Callable[[Work, dict[str, Any]], Result]:
    def act(work: Work, a: dict[str, Any]) -> Result:
        snap = a[SNAP]
        if snap is None:
            return tool.act(work, a)
        sizes = work.state.sizes
        near = replace(sizes, snap=work.length(f"{tool.name}: {SNAP}", snap))
        result = tool.act(replace(work, state=replace(work.state, sizes=near)), a)
        return replace(result, state=replace(result.state, sizes=sizes))

    return act
