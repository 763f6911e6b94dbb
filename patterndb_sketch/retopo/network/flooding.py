"""The surface beside curves: the triangles on one side, and whether they are a disk.

Curves run over the surface and not along its edges, so a triangle is to their left, to their right,
or crossed. Flooding begins beside crossed triangles and does not pass them. Quads can fill what
lies on the left of a loop if it is a disk: over a hole of the surface, or a handle, they would hang
in the air.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from patterndb._native.retopo.network.flooding import flood
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points, units
from patterndb.geometry.surface import Surface, SurfacePoints
from patterndb_sketch.retopo.network.faces import SurfaceParts
from patterndb_sketch.retopo.wording import format_place
from query.placing import Region, enclose_region
from query.placing.region import find_void

#: How often steps of a curve between triangles that do not touch are halved before the curve is
#: taken to leave the surface there.
HALVINGS = 12

#: A triangle is beside a curve, for certain, if it is at more than this sine from its tangent.
CLEAR = 0.3


@dataclass(frozen=True, slots=True, eq=False)
class WallGap:
    """Where a curve leaves the surface: from one part of it to another that does not touch it.

    curve: which one. triangles: (2,) where it leaves, and where it is back. point: (3,) before.
    """

    curve: int
    triangles: Int32Array
    point: Points


@dataclass(frozen=True, slots=True, eq=False)
class Wall:
    """Curves as walls on a surface.

    crossed: (t,) bool, the triangles that they cross.
    points:  (n, 3) of them, lefts: (n, 3) unit directions to their left, curve: (n,) which one.
    beside:  (k,) triangles beside crossed ones.
    gaps:    places where curves leave the surface, so that nothing stops there.
    """

    crossed: NDArray[np.bool_]
    points: Points
    lefts: Points
    curve: Int32Array
    beside: Int32Array
    gaps: tuple[WallGap, ...] = ()

    def side_of(
        self, surface: Surface, triangles: Int32Array
    ) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
        """Of (k,) triangles the nearest of the points, and how far to the left of the curve their
        middles are there, as a sine: below 0 to the right."""
        if len(triangles) == 0:
            return np.empty(0, np.intp), np.empty(0)
        middle = surface.vertices[surface.triangles[triangles]].mean(axis=1)
        sample = np.asarray(KDTree(self.points).query(middle)[1], np.intp)
        away = units(middle - self.points[sample])
        return sample, np.einsum("nc,nc->n", away, self.lefts[sample])


def make_wall(surface: Surface, curves: Sequence[tuple[Points, bool]]) -> Wall:
    """Of polylines (n, 3), each with whether it is closed (and does not repeat its first point)."""
    crossed = np.zeros(len(surface.triangles), np.bool_)
    found: list[tuple[Points, Points]] = []
    gaps: list[WallGap] = []
    for k, (points, closed) in enumerate(curves):
        at, lefts, left = _cross_triangles(surface, points, closed, crossed)
        found.append((at, lefts))
        gaps += [WallGap(k, triangles, point) for triangles, point in left]
    points = np.concatenate([at for at, _ in found])
    lefts = np.concatenate([left for _, left in found])
    curve = np.repeat(np.arange(len(found), dtype=np.int32), [len(at) for at, _ in found])
    walls = np.flatnonzero(crossed)
    sides = (3 * walls[:, None] + np.arange(3)).ravel()
    across = surface.adjacency.across[sides]
    beside = np.unique(across[across >= 0] // 3)
    beside = beside[~crossed[beside]].astype(np.int32)
    return Wall(crossed, points, lefts, curve, beside, tuple(gaps))


def find_gap(surface: Surface, wall: Wall, inside: NDArray[np.bool_]) -> WallGap | None:
    """A gap that the triangles inside (t,) bool touch: there the wall does not hold them."""
    if not wall.gaps:
        return None
    near = np.zeros(len(surface.vertices), np.bool_)
    near[surface.triangles[inside]] = True
    return next((gap for gap in wall.gaps if near[surface.triangles[gap.triangles]].any()), None)


def _cross_triangles(
    surface: Surface, points: Points, closed: bool, crossed: NDArray[np.bool_]
) -> tuple[Points, Points, list[tuple[Int32Array, Points]]]:
    """Mark the triangles that a polyline crosses; its points and directions to the left, and the
    triangles between which, and the points where, it leaves the surface."""
    line, feet, apart = _follow_surface(surface, points, closed)
    a, common = _compare_neighbours(surface, feet)
    gaps = [(feet.triangles[k : k + 2], line[k]) for k in apart]
    crossed[feet.triangles] = True
    # Triangles that touch in a vertex alone: the fan around it closes the gap.
    lone = np.flatnonzero(common.sum(axis=1) == 1)
    corners = np.unique(a[lone][common[lone]])
    if len(corners):
        around = np.zeros(len(surface.vertices), np.bool_)
        around[corners] = True
        crossed |= around[surface.triangles].any(axis=1)
    along = np.empty_like(line)
    along[1:-1] = line[2:] - line[:-2]
    along[0], along[-1] = line[1] - line[0], line[-1] - line[-2]
    if closed:
        along[0] = along[-1] = line[1] - line[-2]
    return feet.points, units(np.cross(feet.normals, along)), gaps


def find_leaps(surface: Surface, points: Points, closed: bool) -> Points:
    """(k, 3) where a polyline (n, 3) leaves the surface for another part of it."""
    line, _, apart = _follow_surface(surface, points, closed)
    return line[apart]


def _follow_surface(
    surface: Surface, points: Points, closed: bool
) -> tuple[Points, SurfacePoints, NDArray[np.intp]]:
    """A polyline with points so near to each other that neighbours lie on triangles that touch,
    its feet, and the points after which they never do."""
    line = np.concatenate([points, points[:1]]) if closed else points
    feet = surface.nearest(line)
    apart = np.flatnonzero(~_compare_neighbours(surface, feet)[1].any(axis=1))
    for _ in range(HALVINGS):
        if len(apart) == 0:
            break
        line = np.insert(line, apart + 1, 0.5 * (line[apart] + line[apart + 1]), axis=0)
        feet = surface.nearest(line)
        apart = np.flatnonzero(~_compare_neighbours(surface, feet)[1].any(axis=1))
    return line, feet, apart


def _compare_neighbours(
    surface: Surface, feet: SurfacePoints
) -> tuple[Int32Array, NDArray[np.bool_]]:
    """(n - 1, 3) the corners of the triangle of every foot but the last, and (n - 1, 3) which of
    them the next foot's triangle has, too."""
    a, b = (surface.triangles[f] for f in (feet.triangles[:-1], feet.triangles[1:]))
    return a, (a[:, :, None] == b[:, None, :]).any(axis=2)


def flood_triangles(
    surface: Surface, crossed: NDArray[np.bool_], seeds: Int32Array, most: float
) -> tuple[Int32Array, float] | None:
    """(k,) the triangles around some that no wall parts from them, and their area.

    None as soon as the area is more than ``most``: then it costs no more than that.
    """
    at = np.ascontiguousarray(seeds, np.int32)
    inside, area = flood(surface.adjacency.across, crossed, surface.areas, at, most)
    return None if area > most else (inside, area)


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
