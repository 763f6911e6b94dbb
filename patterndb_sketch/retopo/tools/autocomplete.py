"""The autocompletion tool: what would close against the boundaries around a place.

It takes the list of :mod:`patterndb_sketch.retopo.tools.suggestions` from the surface to a plane,
and the one that is taken back into the network.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.arguments import AT, Argument, Number, optional_length
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.network import Edit, Network
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tool import Control, Result, Tool, ToolWork
from patterndb_sketch.retopo.tools.closing import (
    PlannedPatch,
    SurfaceBoundary,
    close_patch,
    find_boundaries,
    has_short_stretch,
    map_boundaries,
    measure_coarseness,
    sample_line,
)
from patterndb_sketch.retopo.tools.planar import find_fault
from patterndb_sketch.retopo.tools.suggestions import suggest_patches
from patterndb_sketch.retopo.tracing import MapExtent, spread_map


def find_completions(
    network: Network, surface: Surface, point: ArrayLike, normal: ArrayLike, sizes: Sizes
) -> list[PlannedPatch]:
    """What can be closed around a point of the surface: the largest quad first, then smaller
    ones, then triangles; nothing where no boundary is within the brush with its empty side towards
    the point, or within the snap radius.

    point, normal: (3,). Source: sketch-based quad meshes paper, section 5 and Fig. 11.
    Differs from the released program, which wants the point within the snap radius: where the
    brush that is shown reaches a border, something is expected.
    """
    at, up = np.asarray(point, np.float64), np.asarray(normal, np.float64)
    if at.shape != (3,) or up.shape != (3,) or not np.isfinite([at, up]).all():
        raise InvalidRetopoError("give a point and a normal, three finite numbers each")
    radius, snap = sizes.autocompletion, sizes.snap_within(sizes.autocompletion)
    edges = find_boundaries(network)
    start = _nearest(edges, at, up, snap, radius)
    if start is None:
        return []
    edge, k = start
    foot = surface.nearest_facing(edge.points[k : k + 1], edge.normals[k : k + 1])
    # v is to the left of the boundary, where nothing is.
    ahead = np.cross(foot.normals, _along(edge, k)[None])
    if not np.linalg.norm(ahead) > 0.0:
        return []

    def find_within(window: MapExtent) -> list[PlannedPatch]:
        onto = spread_map(surface, foot, ahead, window)
        boundaries, strokes = map_boundaries(network, edges, onto)

        def covered(line: Points) -> bool:
            return bool(onto.at(sample_line(line, sizes.sampling))[1].all())

        found = suggest_patches(boundaries, radius, snap, covered=covered)
        return [
            PlannedPatch(one.patch, tuple(edges), onto, one.case)
            for one in found
            if not has_short_stretch(one.patch)
            and find_fault(one.patch, [*boundaries, *strokes]) is None
        ]

    window = MapExtent.completion(radius)
    # Where triangles are coarse the usual extent has hardly one of them whole.
    return find_within(window) or find_within(window.widen(measure_coarseness(surface, foot)))


def autocomplete(
    network: Network,
    surface: Surface,
    point: ArrayLike,
    normal: ArrayLike,
    sizes: Sizes,
    choice: int = 0,
) -> Edit:
    """The network with a patch suggested around a point, the first or another by its number.

    Raises RefusedError if there are not so many.
    """
    found = find_completions(network, surface, point, normal, sizes)
    if not found:
        raise RefusedError(
            "nothing can be completed here; point nearer to the border of a patch, or take "
            "another radius"
        )
    if not 0 <= choice < len(found):
        raise RefusedError(
            f"there is no suggestion {choice} here; there are {len(found)}, from 0 on"
        )
    return close_patch(network, found[choice], sizes)


def _nearest(
    edges: list[SurfaceBoundary], point: Points, normal: Points, snap: float, radius: float
) -> tuple[SurfaceBoundary, int] | None:
    """The vertex of a boundary nearest to a point of the surface, on its side of it: within the
    snap radius, or within a radius where the point is on the boundary's empty side."""
    best, found = radius, None
    for edge in edges:
        offset = point - edge.points
        away = np.linalg.norm(offset, axis=1)
        ahead = np.cross(edge.normals, _directions(edge))
        beyond = (offset * ahead).sum(axis=1) < 0.0
        away[(edge.normals @ normal <= 0.0) | (beyond & (away > snap))] = np.inf
        k = int(np.argmin(away))
        if away[k] < best or (found is None and away[k] <= best):
            best, found = float(away[k]), (edge, k)
    return found


def _directions(edge: SurfaceBoundary) -> Points:
    """(n, 3) the directions in which a boundary passes its vertices."""
    if edge.closed:
        return np.roll(edge.points, -1, axis=0) - np.roll(edge.points, 1, axis=0)
    return np.gradient(edge.points, axis=0)


def _along(edge: SurfaceBoundary, k: int) -> Points:
    """(3,) the direction in which a boundary arrives at a vertex, or leaves its first."""
    if k or edge.closed:
        return edge.points[k] - edge.points[k - 1]
    return edge.points[1] - edge.points[0]


def _act(work: ToolWork, a: dict[str, Any]) -> Result:
    sizes = work.state.sizes
    if a["radius"] is not None:
        radius = work.check_length("autocomplete: radius", a["radius"])
        sizes = replace(sizes, autocompletion=radius)
    foot = work.find_foot(a["at"])
    point, normal = foot.points[0], foot.normals[0]
    found = autocomplete(work.network, work.surface, point, normal, sizes, a["choice"])
    return work.keep_edit(found)


AUTOCOMPLETE = Tool(
    "autocomplete",
    "Take a patch suggested at a point next to others.",
    {
        "at": AT,
        "choice": Argument(Number(0, 1000, whole=True), "0 for the largest quad", 0, option=False),
        "radius": optional_length("that is looked at"),
    },
    _act,
    position=30,
    snaps=True,
    control=Control(
        "a",
        "complete",
        "point next to a patch; click: take it    - +: larger, smaller",
        target="none",
        brush="autocompletion",
    ),
)
