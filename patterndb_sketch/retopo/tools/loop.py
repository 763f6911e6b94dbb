"""The loop tool: a plane cuts the surface, and the cut is a curve."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface, SurfacePoints
from patterndb_sketch.retopo.arguments import AT, Argument, Vector, optional_length
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network import Edit, Network
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tool import Control, Result, Tool, ToolWork
from patterndb_sketch.retopo.tools.stroke import insert_stroke
from patterndb_sketch.retopo.tracing import SurfaceCurve, cut_by_plane

#: A cut is given up when it is this many times as long as the line that the user drew across the
#: part. Source: the released program of Takayama et al. 2013.
TIMES_THE_LINE = 10.0


def cut_loop(
    network: Network,
    surface: Surface,
    sizes: Sizes,
    start: SurfacePoints,
    normal: ArrayLike,
    limit: float | None = None,
) -> Edit:
    """The network with the curve in which a plane cuts the surface, followed from one of its
    points: closed, or from border to border.

    start: one foot, which the plane passes. normal: (3,) the plane's. limit: length at which the
    cut is given up, None for never. Where it crosses chains both are cut.
    Raises RefusedError if the plane only touches the surface, or the cut is too long.
    """
    return insert_stroke(
        network, surface, sizes, preview_loop(surface, sizes, start, normal, limit)
    )


def preview_loop(
    surface: Surface,
    sizes: Sizes,
    start: SurfacePoints,
    normal: ArrayLike,
    limit: float | None = None,
) -> SurfaceCurve:
    """The curve that :func:`cut_loop` would add; raises as that does."""
    return cut_by_plane(surface, start, normal, limit).sample(surface, sizes.sampling)


def plane_of_line(begin: ArrayLike, end: ArrayLike, towards: ArrayLike) -> tuple[Points, float]:
    """The plane of a line drawn on the screen, as a normal (3,), and the limit for its cut.

    begin, end: (3,) the line's ends in space; towards: (3,) the direction in which the eye sees
    its middle. Raises RefusedError for a line of no length, or one seen end on.
    """
    line = np.asarray(end, np.float64) - np.asarray(begin, np.float64)
    normal = np.cross(line, np.asarray(towards, np.float64))
    if not np.linalg.norm(normal) > 0.0:
        raise RefusedError("the line across the part has no length; draw it longer")
    return normal, TIMES_THE_LINE * float(np.linalg.norm(line))


def _act(work: ToolWork, a: dict[str, Any]) -> Result:
    start = work.find_foot(a["at"])
    found = cut_loop(work.network, work.surface, work.state.sizes, start, a["normal"], a["limit"])
    return work.keep_edit(found)


LOOP = Tool(
    "loop",
    "Cut the surface by a plane: the cut is a curve.",
    {
        "at": AT,
        "normal": Argument(Vector(direction=True), "of the plane"),
        "limit": replace(optional_length("at which it is given up"), option=False),
    },
    _act,
    position=50,
    control=Control("l", "loop", "drag a line across a part: it is cut there", "plane", "none"),
)
