"""The tool that switches symmetry on and off."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from patterndb_sketch.retopo.arguments import Argument, Flag, Vector
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.network.structure import SYMMETRY
from patterndb_sketch.retopo.symmetry import (
    Plane,
    begin_symmetry,
    cut_half,
    end_symmetry,
    propose_plane,
)
from patterndb_sketch.retopo.tool import Control, Result, Tool, ToolWork


def _act(work: ToolWork, a: dict[str, Any]) -> Result:
    now = work.state.plane
    named = a["point"] is not None or a["normal"] is not None
    if not a["on"]:
        if named or a["find"]:
            raise InvalidRetopoError("switching symmetry off needs no plane; leave it out")
        if now is None:
            raise RefusedError("symmetry is off already")
        return _switch_off(work, now)
    if now is not None:
        raise RefusedError("symmetry is on already; switch it off first")
    if a["find"] and named:
        raise InvalidRetopoError("symmetry needs either find, or point and normal")
    if a["find"]:
        plane = propose_plane(work.ground).plane
    else:
        point = (0.0, 0.0, 0.0) if a["point"] is None else a["point"]
        normal = (1.0, 0.0, 0.0) if a["normal"] is None else a["normal"]
        plane = Plane.of(point, normal)
    half = cut_half(work.ground, plane)
    edit = begin_symmetry(work.network, half, work.state.sizes.sampling)
    return Result(replace(work.state, network=edit.network, plane=plane), edit.notes)


def _switch_off(work: ToolWork, plane: Plane) -> Result:
    chains = work.network.chains.values()
    if not any(SYMMETRY in chain.marks for chain in chains):
        # The plane misses the surface: there is no seam, and nothing to mirror across it.
        return Result(replace(work.state, plane=None))
    edit = end_symmetry(work.network, work.whole, work.state.sizes, plane)
    return Result(replace(work.state, network=edit.network, plane=None), edit.notes)


SYMMETRY_TOOL = Tool(
    "symmetry",
    "Work on one side of a plane, and get both; or switch that off.",
    {
        "on": Argument(Flag(), "on or off", True),
        "point": Argument(Vector(), "of the plane; [0, 0, 0] if left out", None),
        "normal": Argument(
            Vector(direction=True), "to the side that is worked on; x if left out", None
        ),
        "find": Argument(Flag(), "take the surface's own plane", False),
    },
    _act,
    position=230,
    control=Control("M", "mirror", "work on one half, and get both"),
)
