"""Tell whether what lies on the left of a loop is a disk of the surface, which quads can fill.

A region with a hole of the surface within it, or a handle, is none: quads over it would hang in the
air.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.network.faces import SurfaceParts
from patterndb_sketch.retopo.network.flooding import CLEAR, flood_triangles, make_wall
from patterndb_sketch.retopo.wording import format_place
from query.placing import Region, enclose_region
from query.placing.region import find_void

#: Points of a loop that its region is found by: more cost time, and show nothing.
MOST_POINTS = 128


def explain_no_disk(surface: Surface, points: Points) -> str | None:
    """Why a closed polyline (n, 3) goes around no disk of the surface, as a sentence's part that
    names the place and how to mend it; None if it does."""
    some = np.ascontiguousarray(points[:: -(-len(points) // MOST_POINTS)])
    return explain_region(surface, enclose_region(surface, some), some)


def explain_region(surface: Surface, region: Region, points: Points) -> str | None:
    """As :func:`explain_no_disk`, of the region that was found by the points.

    None, too, where these leave the surface, or come nearer to each other than its triangles are
    large, so that nothing can be told.
    """
    if not region.separates:
        if not _is_one_piece(surface, points):
            return None
        return (
            f"the loop around it at {format_place(points[0])} parts no piece from the surface, but "
            "goes round a handle, or an opening; lead a curve across what is to be filled"
        )
    topology = surface.adjacency
    open_ones = np.diff(topology.side_start)[topology.edges[topology.border]] == 1
    void = find_void(region, surface, topology.border[open_ones], points)
    if void is not None:
        return (
            f"a border of the surface lies within it, at {format_place(void)}, joined to none of "
            "its sides; lead a curve from there to one of them"
        )
    inside = region.chosen.copy()
    inside[inside] = np.isnan(region.around)
    if inside.any() and _count_least_euler(surface, inside) < 1:
        return (
            f"a handle of the surface, or a hole, lies within the loop around it at "
            f"{format_place(points[0])}; lead a curve through it"
        )
    return None


#: Of the triangles beside a loop that are reached from its left, those on its right are as many, up
#: to this many times fewer or more, where it parts nothing.
ALIKE = 3


def _is_one_piece(surface: Surface, points: Points) -> bool:
    """Is what lies on the left of a loop (n, 3) certainly one piece with what lies on its right?"""
    wall = make_wall(surface, [(points, True)])
    _, side = wall.side_of(surface, wall.beside)
    if wall.gaps or not (side > CLEAR).any():
        return False
    found = flood_triangles(surface, wall.crossed, wall.beside[side > CLEAR], np.inf)
    assert found is not None
    reached = np.isin(wall.beside, found[0])
    left, right = int((side[reached] > CLEAR).sum()), int((side[reached] < -CLEAR).sum())
    return max(left, right) <= ALIKE * min(left, right)


def _count_least_euler(surface: Surface, inside: NDArray[np.bool_]) -> int:
    """The least Euler characteristic of the pieces that some triangles (t,) make."""
    name = np.cumsum(inside, dtype=np.int32) - 1
    across = surface.adjacency.across.reshape(-1, 3)[inside].ravel()
    face, side = across // 3, across % 3
    met = (across >= 0) & inside[face]
    own: Int32Array = np.where(met, 3 * name[face] + side, -1).astype(np.int32)
    return int(SurfaceParts.of_triangles(surface.triangles[inside], own).count_euler(own).min())
