"""The list of suggestions for a place, the largest first."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.tools.completion.cases import Suggestion, suggestion
from patterndb_sketch.retopo.tools.completion.sequence import Window, sequences
from patterndb_sketch.retopo.tools.plane import Boundary, fault

#: Windows that are looked at, from a tenth of the radius to all of it.
SIZES = 10

#: Tells of a line (n, 2) whether all of it is on the part of the surface that has a
#: parameterisation.
Covered = Callable[[Points], bool]


def everywhere(line: Points) -> bool:
    """The whole plane has a surface."""
    return bool(np.isfinite(line).all())


def suggested(
    boundaries: list[Boundary],
    size: float,
    *,
    triangle: bool = False,
    covered: Covered = everywhere,
) -> Suggestion | None:
    """The patch suggested by what a window of one size shows, or None if there is none."""
    found = suggestion(boundaries, sequences(boundaries, Window(size)), triangle=triangle)
    if found is None or fault(found.patch, boundaries) is not None:
        return None
    if not all(covered(curve) for curve in found.patch.curves):
        return None
    return replace(found, size=size)


def suggestions(
    boundaries: list[Boundary],
    radius: float,
    snap: float,
    *,
    covered: Covered = everywhere,
) -> list[Suggestion]:
    """Patches around the origin, best first: the largest quad, smaller quads, then triangles.

    boundaries: in the plane of a parameterisation about a vertex of one of them: u along that
    boundary, v into the empty side. radius: of what is looked at. snap: suggestions whose
    corners are this near to each other's are one.

    Differs from the released program, which shows the largest window's patch first even where
    it is a triangle; the paper says that the largest quadrangle is.
    """
    sizes = [radius * k / SIZES for k in range(SIZES, 0, -1)]
    quads: list[Suggestion] = []
    triangles: list[Suggestion] = []
    for asked in (False, True):
        for size in sizes:
            found = suggested(boundaries, size, triangle=asked, covered=covered)
            if found is None:
                continue
            kept = triangles if len(found.patch.corners) == 3 else quads
            if not any(_same(found, other, snap) for other in kept):
                kept.append(found)
    triangles.sort(key=lambda s: -s.size)
    return quads + triangles


def _same(a: Suggestion, b: Suggestion, snap: float) -> bool:
    """Are all corners within the snap radius of each other, in some rotation?"""
    one, other = a.patch.points, b.patch.points
    if len(one) != len(other):
        return False
    return any(
        bool((np.linalg.norm(one - np.roll(other, k, axis=0), axis=1) <= snap).all())
        for k in range(len(one))
    )
