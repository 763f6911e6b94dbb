"""Lay a placed fill of a hole on a surface, and pull its strands onto drawn strokes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from query.placing.placement import place, pull_placed
from query.placing.region import Region, enclose_region
from query.stroke import Stroke

#: A rim that lies farther off the surface than this part of its mean edge encloses nothing there.
FAR_OFF = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class LoopDisk:
    """A fill of a loop as a quad disk of one side; see :class:`query.placing.strands.SidedDisk`."""

    quads: Int32Array
    n_vertices: int
    perimeter: int

    @property
    def lengths(self) -> tuple[int, ...]:
        """The one side, all around."""
        return (self.perimeter,)


@dataclass(frozen=True, slots=True, eq=False)
class HoleGround:
    """What the fills of one hole are laid on and pulled to.

    loop: (L, 3) the hole's rim. surface: what new vertices lie on, or None. region: what the rim
    encloses there; None where the rim does not lie on it. strokes: strands as strokes on side 0.
    tolerance: edges that a strand's end may be off its stroke.
    """

    loop: Points
    surface: Surface | None
    region: Region | None
    strokes: tuple[Stroke, ...]
    tolerance: int

    @classmethod
    def make(
        cls, loop: Points, surface: Surface | None, strokes: Sequence[Stroke], tolerance: int
    ) -> HoleGround | None:
        """Prepare the ground of a hole's fills; None where there is nothing to lay them on."""
        drawn = tuple(stroke for stroke in strokes if stroke.points is not None)
        if surface is None and not drawn:
            return None
        region = None if surface is None else _choose_region(surface, loop)
        return cls(loop, surface, region, drawn, tolerance)

    def lay(self, quads: Int32Array, points: Points) -> Points:
        """Lay the inner vertices (k, 3) of a fill.

        quads: (q, 4) int32, loop vertices 0..L-1, inner ones after.
        """
        n = len(self.loop)
        if not len(points):
            return points
        disk = LoopDisk(quads, n + len(points), n)
        if self.region is not None:
            placed = place(disk, self.loop, self.region, self.strokes, tolerance=self.tolerance)
            return placed.vertices[n:]
        if self.strokes:
            vertices = np.vstack([self.loop, points])
            points = pull_placed(disk, vertices, self.strokes, tolerance=self.tolerance)[n:]
        return points if self.surface is None else self.surface.nearest(points).points


def _choose_region(surface: Surface, loop: Points) -> Region | None:
    """The smaller part of the surface that a rim encloses: which way the triangles of a scan turn
    tells nothing of the mesh."""
    edge = float(np.linalg.norm(loop - np.roll(loop, 1, axis=0), axis=1).mean())
    off = np.linalg.norm(surface.nearest(loop).points - loop, axis=1)
    if float(off.max()) > FAR_OFF * edge:
        return None
    turned = Surface.from_arrays(surface.vertices, surface.triangles[:, ::-1])
    found = [enclose_region(one, loop) for one in (surface, turned)]
    separate = [region for region in found if region.separates]
    return min(separate, key=lambda region: region.share, default=None)
