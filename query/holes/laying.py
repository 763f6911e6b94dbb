"""Lay a placed fill of a hole on a surface or in a plane, and pull its strands onto strokes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.neighbours import Neighbours
from patterndb.geometry.points import Points
from patterndb.geometry.quadshape import flipped
from patterndb.geometry.surface import Surface
from query.holes.caps import RimPlane, unfold
from query.holes.shape import count_flipped, place_fill
from query.holes.surroundings import Surroundings
from query.placing.laplace import solve_harmonic
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

    around: the hole's boundary and the mesh around it. surface: what new vertices lie on, or None.
    region: what the boundary encloses there; None where it does not lie on it. plane: what new
    vertices of a flat cap lie in, or None. tension: part of the way to a membrane that others are
    moved. strokes: strands as strokes on side 0. tolerance: edges that a strand's end may be off
    its stroke.
    """

    around: Surroundings
    surface: Surface | None
    region: Region | None
    plane: RimPlane | None
    tension: float
    strokes: tuple[Stroke, ...]
    tolerance: int

    @classmethod
    def make(
        cls,
        around: Surroundings,
        surface: Surface | None,
        plane: RimPlane | None,
        tension: float,
        strokes: Sequence[Stroke],
        tolerance: int,
    ) -> HoleGround:
        """Prepare the ground of a hole's fills."""
        drawn = tuple(stroke for stroke in strokes if stroke.points is not None)
        loop = around.points[: len(around.outside)]
        region = None if surface is None else _choose_region(surface, loop)
        return cls(around, surface, region, plane, tension, drawn, tolerance)

    @property
    def loop(self) -> Points:
        """(L, 3) the hole's boundary."""
        return self.around.points[: len(self.around.outside)]

    @property
    def moves(self) -> bool:
        """Does laying move vertices at all?"""
        laid = self.surface is not None or self.plane is not None
        return laid or self.tension > 0 or bool(self.strokes)

    def lay(self, quads: Int32Array, points: Points) -> Points:
        """Lay the inner vertices (k, 3) of a fill that is placed smoothly.

        quads: (q, 4) int32, loop vertices 0..L-1, inner ones after.
        """
        n = len(self.loop)
        if not len(points):
            return points
        disk = LoopDisk(quads, n + len(points), n)
        if self.plane is not None:
            return self._lay_flat(self.plane, disk)
        if self.region is not None:
            placed = place(disk, self.loop, self.region, self.strokes, tolerance=self.tolerance)
            return placed.vertices[n:]
        if self.tension:
            tight = solve_harmonic(Neighbours.of(quads, disk.n_vertices, n), self.loop)[n:]
            points = (1 - self.tension) * points + self.tension * tight
        if self.strokes:
            vertices = np.vstack([self.loop, points])
            points = pull_placed(disk, vertices, self.strokes, tolerance=self.tolerance)[n:]
        return points if self.surface is None else self.surface.nearest(points).points

    def count_flipped(self, quads: Int32Array, points: Points) -> int:
        """Count the quads of a fill that are turned over where its inner vertices (k, 3) lie."""
        if self.plane is None:
            return count_flipped(self.around, quads, points)
        vertices = np.vstack([self.loop, points])
        return int(flipped(quads, vertices, np.tile(self.plane.normal, (len(vertices), 1))).sum())

    def _lay_flat(self, plane: RimPlane, disk: LoopDisk) -> Points:
        """(k, 3) the inner vertices in a plane."""
        n, around = disk.perimeter, unfold(self.around, plane)
        points = plane.project(place_fill(around, disk.quads, disk.n_vertices).points)
        if self.count_flipped(disk.quads, points):
            points = plane.project(place(disk, around.points[:n]).vertices[n:])
        if self.strokes:
            vertices = np.vstack([around.points[:n], points])
            pulled = pull_placed(disk, vertices, self.strokes, tolerance=self.tolerance)
            points = plane.project(pulled[n:])
        # A boundary across an axis leaves no rounding along it.
        level = np.ptp(self.loop, axis=0) == 0
        points[:, level] = self.loop[0, level]
        return points


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
