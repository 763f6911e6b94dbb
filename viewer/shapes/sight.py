"""A shape as it is seen: where its curves are, and which of them are in sight."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import find_nearest_on
from patterndb.geometry.surface import Surface
from viewer.camera import View
from viewer.retopo.pointing import pick_surface
from viewer.shapes.skin import ShapeSkin

#: What is so much deeper than the surface in front of it, in points, is still in sight.
DEEP = 2.0

#: Where the surface is looked up around a place, in points.
AROUND = np.array([(0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])

#: Polylines are cut so finely to see where they vanish, in points.
STEP = 2.0

#: Runs of curves in sight that are shorter than this, in points, are glimpses through seams.
GLIMPSE = 8.0


@dataclass(frozen=True, slots=True)
class Near:
    """What of a curve is near to the pointer: its number, the nearest vertex in it, and how many
    points away it is."""

    line: int
    place: int
    away: float


@dataclass(frozen=True, eq=False)
class ShapeInView:
    """A shape in a view.

    points: (n, 3) of the shape. room: width and height of the view, in points.
    """

    skin: ShapeSkin
    points: Points
    view: View
    room: tuple[float, float]

    def is_of(self, points: Points, view: View, room: tuple[float, float]) -> bool:
        """Is this what would be seen of a shape in a view?"""
        same = self.points is points or np.array_equal(self.points, points)
        return same and self.view is view and self.room == room

    @cached_property
    def seen(self) -> Points:
        """(n, 3) the vertices in points from the middle of the view, and nearness."""
        return self.view.seen(self.points)

    @cached_property
    def lines(self) -> list[Points]:
        """Every curve (k, 3) likewise."""
        return [self.seen[line.vertices] for line in self.skin.lines]

    @cached_property
    def normals(self) -> Points:
        """(4 q, 3) at the corners of faces, in space."""
        return self.skin.normals(self.points)

    @cached_property
    def outline(self) -> Points:
        """(k, 2, 3) the lines along which the shape turns away, as they are seen."""
        lines = self.skin.outline(self.points, self.normals, self.view.axes[2])
        return self.view.seen(lines)

    @cached_property
    def _surface(self) -> Surface:
        """What hides curves."""
        return Surface(self.points, self.skin.vertices.astype(np.int32))

    def visible(self, seen: Points) -> NDArray[np.bool_]:
        """(...) which of (..., 3) places, as seen from the middle of the view, are in sight: the
        surface is no nearer there, or a point beside, where it may turn away."""
        flat = seen.reshape(-1, 3)
        front = np.full(len(flat), np.inf)
        for offset in AROUND:
            feet = pick_surface(self.view, self._surface, flat[:, :2] + offset)
            near = np.where(feet.found, self.view.seen(feet.points)[:, 2], -np.inf)
            front = np.minimum(front, near)
        half = np.array(self.room) / 2.0
        inside = (np.abs(flat[:, :2]) <= half).all(axis=1)
        return (inside & (flat[:, 2] >= front - DEEP)).reshape(seen.shape[:-1])

    def nearest(self, x: float, y: float, within: float) -> Near | None:
        """The curve in sight that is nearest to a place of the view, None if none is so near."""
        found = [find_nearest_on(line[:, :2], (x, y)) for line in self.lines]
        for number in sorted(range(len(found)), key=lambda number: found[number][0]):
            away, k, t = found[number]
            if away > within:
                return None
            line = self.lines[number]
            after = min(k + 1, len(line) - 1)
            at = line[k] * (1.0 - t) + line[after] * t
            if self.visible(at[None])[0]:
                return Near(number, k if t < 0.5 else after, away)
        return None

    @cached_property
    def drawing(self) -> list[Points]:
        """The shape as a drawing of lines (k, 3): what is in sight of its outline and curves."""
        outline = self.outline[self.visible(self.outline.mean(axis=1))]
        return [*outline, *(run for line in self.lines for run in self._runs(line))]

    def _runs(self, line: Points) -> list[Points]:
        """What is in sight of a polyline as it is seen."""
        fine, own = refine_line(line, STEP)
        shown = self.visible(fine)
        cuts = np.flatnonzero(np.diff(shown.astype(np.int8))) + 1
        runs: list[Points] = []
        for places in np.split(np.arange(len(fine)), cuts):
            if shown[places[0]] and _length(fine[places]) > GLIMPSE:
                kept = own[places]
                kept[[0, -1]] = True
                runs.append(fine[places[kept]])
        return runs


def refine_line(line: Points, step: float) -> tuple[Points, NDArray[np.bool_]]:
    """A polyline (k, 3) as it is seen with a point (m, 3) every so many points of the picture;
    and which (m,) of these are its own."""
    along = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(line[:, :2], axis=0), axis=1))]
    count = int(np.ceil(along[-1] / step))
    if count < 2:
        return line, np.ones(len(line), np.bool_)
    at = np.unique(np.r_[along, np.linspace(0.0, along[-1], count + 1)])
    fine = np.stack([np.interp(at, along, line[:, c]) for c in range(3)], axis=1)
    return fine, np.isin(at, along)


def _length(line: Points) -> float:
    return float(np.linalg.norm(np.diff(line[:, :2], axis=0), axis=1).sum())


# Pulls: from where the pointer goes to where a curve shall go in space.

#: An axis that is seen shorter than this part of itself points at the viewer: nobody can tell how
#: far along it a pull goes.
END_ON = 0.15


@dataclass(frozen=True, slots=True)
class Grab:
    """A curve in hand: its number, the nearest vertex in it, and where it was pressed."""

    line: int
    place: int
    pressed: tuple[float, float]


def find_displacement(view: View, dx: float, dy: float, axis: int | None) -> Points | None:
    """Find (3,) what a pull by so many points of the picture means in space.

    In the plane of the screen, or along an axis: as far as the pull goes along the axis as it is
    seen. None if that points at the viewer.
    """
    if axis is None:
        return (dx * view.axes[0] + dy * view.axes[1]) / view.scale
    seen = view.axes[:2, axis]
    size = float(seen @ seen)
    if size < END_ON**2:
        return None
    offset = np.zeros(3)
    offset[axis] = (dx * seen[0] + dy * seen[1]) / (size * view.scale)
    return offset
