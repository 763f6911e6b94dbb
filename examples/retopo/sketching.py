"""Scripts of retopology from places with names: what make_*.py of this folder draw with.

A script holds points of curves, thousands of numbers. Here a surface's curves are told as an
artist tells them: a corner is seen from the front at (0.1, 0.4); a ring goes around the leg; a line
runs from the hoof over the flank to the spine. A line is the curve on the surface through its
corners that bends least. On a symmetric surface one half is told.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.geometry.polyline import arc_length, at_lengths
from patterndb.geometry.surface import Surface, SurfacePoints
from patterndb.system.files import replace_file
from patterndb_sketch.retopo.editor import Call
from patterndb_sketch.retopo.script import line_of
from patterndb_sketch.retopo.tracing import cut_by_plane, trace_geodesic

Points = NDArray[np.float64]

#: Distance of the points of a stroke in a script, and while a line is bent, as parts of the
#: surface's diagonal.
SPACING = 0.008
FINE = 0.004

#: Rounds of bending and projecting, and how far a round may go: the stiffness against the
#: pull back to where the curve was, in spacings to the fourth.
ROUNDS = 20
STIFFNESS = 2e3

#: Points that a ring is looked at in: half a degree apart.
AROUND = 720

#: Decimals of a script's coordinates, in diagonals: below what a picture shows.
DECIMALS = 5

MIRRORED = "'"


class Sketch:
    """Named places on a surface, and the calls that draw curves between them.

    mirror: 0, 1 or 2 if the surface is symmetric in that coordinate: everything off the plane is
    drawn twice, and the mirror image of "ear" is "ear'". Places within ``on_plane`` of it, a part
    of the diagonal, are taken to be on it.

    spacing, fine: as SPACING and FINE; set them smaller before lines that go around small things.
    rounds: as ROUNDS; 0 leaves shortest paths from place to place, for narrow folds, where a curve
    that is bent would come to lie on the other side.
    """

    def __init__(
        self, surface: Surface, file: str, mirror: int | None = None, on_plane: float = 0.004
    ) -> None:
        self.surface = surface
        self.file = file
        self.mirror = mirror
        self.reach = on_plane * surface.diagonal
        self.decimals = DECIMALS - round(np.log10(surface.diagonal))
        self.places: dict[str, Points] = {}
        self._middles: dict[frozenset[str], Points] = {}
        self.spacing = SPACING
        self.fine = FINE
        self.rounds = ROUNDS
        self.calls: list[Call] = []

    def seen(self, side: str, **places: Sequence[float]) -> None:
        """Name what is seen first from a side, "+x" to "-z", at the other two coordinates."""
        axis = "xyz".index(side[1])
        towards = np.zeros(3)
        towards[axis] = 1.0 if side[0] == "+" else -1.0
        far = 10.0 * self.surface.diagonal
        for name, at in places.items():
            point = np.insert(np.asarray(at, float), axis, 0.0)
            found = self.surface.project((point + far * towards)[None], towards[None], 2.0 * far)
            if len(found.missed) or len(found.lost):
                raise ValueError(f"{name} is beside the surface: seen from {side} at {list(at)}")
            self._name(name, found.points[0])

    def near(self, **places: Sequence[float]) -> None:
        """Name the points of the surface nearest to points in space."""
        for name, at in places.items():
            self._name(name, self.surface.nearest(np.asarray(at, float)[None]).points[0])

    def ring(
        self,
        at: ArrayLike,
        normal: ArrayLike,
        names: Mapping[str, Sequence[float]],
        inside: bool = False,
    ) -> None:
        """Cut the surface by the plane through its point nearest to ``at``, by the loop tool.

        names: places on the ring by the directions in which they lie from its middle. inside: the
        plane is through ``at`` itself, inside the body, and the ring what is first met there in
        the direction of the first name.
        """
        across = np.asarray(normal, float)
        middle = np.asarray(at, float)
        start = self.surface.nearest(middle[None])
        if inside:
            start = self._beyond(middle, across, next(iter(names.values())))
        cut = cut_by_plane(self.surface, start, across).round
        cut = at_lengths(cut, np.linspace(0.0, arc_length(cut)[-1], AROUND + 1)[:-1])
        self._name_around(cut, names)
        self._call("loop", at=start.points[0], normal=across)
        if self.mirror is not None and (np.abs(cut[:, self.mirror]) > self.reach).all():
            turn = self._turn()
            self._call("loop", at=start.points[0] * turn, normal=across * turn)

    def line(self, *names: str, closed: bool = False) -> None:
        """Draw the line through some places as one stroke, and its mirror image."""
        self._stroke(self._remembered(*names, closed=closed), closed)
        others = [self.mirrored(name) for name in names]
        if self.mirror is None or set(others) == set(names):
            return
        self._stroke(self._remembered(*others, closed=closed), closed)

    def curve(self, *names: str, closed: bool = False) -> Points:
        """(n, 3) the curve through some places that bends least; a closed one ends where it
        began."""
        at = [self.places[name] for name in names]
        if closed:
            at.append(at[0])
        feet = [self.surface.nearest(one[None]) for one in at]
        parts: list[Points] = []
        fixed = [0]
        for one, two in pairwise(feet):
            path = trace_geodesic(self.surface, one, two).points
            along = arc_length(path)
            count = max(3, round(float(along[-1]) / (self.fine * self.surface.diagonal)))
            even = at_lengths(path, np.linspace(0.0, along[-1], count + 1))
            parts.append(even[1:] if parts else even)
            fixed.append(fixed[-1] + count)
        return self._bent(np.concatenate(parts), np.array(fixed), closed)

    def halfway(self, **between: str) -> None:
        """Name the places halfway along pieces of curves, between two places next to each other:
        "one two"."""
        for name, ends in between.items():
            one, two = ends.split()
            self.near(**{name: self._middles[frozenset((one, two))].tolist()})

    def edges(self, between: str, count: int) -> None:
        """Pin how many edges the piece of a curve between two places next to each other has, and
        its mirror image: between is "one two"."""
        one, two = between.split()
        middle = self._middles[frozenset((one, two))]
        self._call("subdivide", at=middle, count=count)
        if {self.mirrored(one), self.mirrored(two)} != {one, two}:
            self._call("subdivide", at=middle * self._turn(), count=count)

    def caps(self, inside: Mapping[str, Sequence[float]], corners: Mapping[str, str]) -> None:
        """Make corners of a patch of places that other curves only end at from the other side.

        inside: points near places inside the patches, by names; corners: names, by the same.
        """
        for name, at in inside.items():
            self.near(**{name: at})
            for corner in corners[name].split():
                self.call("corner", at=corner, wedge=name)

    def call(self, tool: str, **arguments: object) -> None:
        """Any other call; an argument that is the name of a place is that place.

        It is made twice if the place has a mirror image.
        """
        self._call(tool, **{k: self._placed(v) for k, v in arguments.items()})
        names = [v for v in arguments.values() if isinstance(v, str) and v in self.places]
        if self.mirror is not None and any(self.mirrored(name) != name for name in names):
            turned = {
                k: self.mirrored(v) if isinstance(v, str) and v in self.places else v
                for k, v in arguments.items()
            }
            self._call(tool, **{k: self._placed(v) for k, v in turned.items()})

    def once(self, tool: str, **arguments: object) -> None:
        """A call that has no mirror image."""
        self._call(tool, **{k: self._placed(v) for k, v in arguments.items()})

    def write(self, path: Path) -> None:
        """Write the script."""
        lines = [line_of(Call("open", {"surface": self.file})), *map(line_of, self.calls)]
        replace_file(path, "\n".join(lines) + "\n")

    def mirrored(self, name: str) -> str:
        """The name of a place's mirror image; its own on the plane."""
        other = name[:-1] if name.endswith(MIRRORED) else name + MIRRORED
        return other if other in self.places else name

    def _name(self, name: str, point: Points) -> None:
        if name in self.places:
            raise ValueError(f"there are two places {name}")
        if self.mirror is not None:
            if abs(point[self.mirror]) <= self.reach:
                point = point.copy()
                point[self.mirror] = 0.0
                point = self.surface.nearest(point[None]).points[0]
            else:
                there = self.surface.nearest((point * self._turn())[None])
                self.places[name + MIRRORED] = there.points[0]
        self.places[name] = point

    def _remembered(self, *names: str, closed: bool) -> Points:
        curve = self.curve(*names, closed=closed)
        stops = [int(np.argmin(np.linalg.norm(curve - self.places[n], axis=1))) for n in names]
        if closed:
            names, stops = (*names, names[0]), [*stops, len(curve) - 1]
        for k in range(len(names) - 1):
            middle = curve[(stops[k] + stops[k + 1]) // 2]
            self._remember(names[k], names[k + 1], middle)
        return curve

    def _remember(self, one: str, two: str, middle: Points) -> None:
        self._middles[frozenset((one, two))] = middle

    def _beyond(self, at: Points, across: Points, way: Sequence[float]) -> SurfacePoints:
        """What is met first from a point inside, in the plane across which ``across`` stands."""
        towards = np.asarray(way, float)
        towards = towards - (towards @ across) / (across @ across) * across
        found = self.surface.project(at[None], towards[None], self.surface.diagonal)
        if (found.points[0] - at) @ towards < 0.0:
            raise ValueError(f"{at.tolist()} is outside the surface")
        return found

    def _name_around(self, ring: Points, names: Mapping[str, Sequence[float]]) -> None:
        """Name places on a closed curve (n, 3) by their directions from its middle."""
        out = ring - 0.5 * (ring.min(axis=0) + ring.max(axis=0))
        out /= np.linalg.norm(out, axis=1)[:, None]
        found: dict[int, str] = {}
        for name, way in names.items():
            k = int(np.argmax(out @ (np.asarray(way, float) / np.linalg.norm(way))))
            self._name(name, ring[k])
            found[k] = name
            other = self.mirrored(name)
            off = np.linalg.norm(ring - self.places[other], axis=1)
            if off.min() <= self.reach:
                found.setdefault(int(np.argmin(off)), other)
        order = sorted(found)
        for one, two in pairwise([*order, order[0] + len(ring)]):
            middle = ring[(one + two) // 2 % len(ring)]
            self._remember(found[one], found[two % len(ring)], middle)

    def _turn(self) -> Points:
        turn = np.ones(3)
        if self.mirror is not None:
            turn[self.mirror] = -1.0
        return turn

    def _placed(self, value: object) -> object:
        return self.places[value] if isinstance(value, str) and value in self.places else value

    def _call(self, tool: str, **arguments: object) -> None:
        rounded = {
            name: np.round(value, self.decimals) if isinstance(value, np.ndarray) else value
            for name, value in arguments.items()
        }
        self.calls.append(Call(tool, rounded))

    def _stroke(self, curve: Points, closed: bool) -> None:
        along = arc_length(curve)
        count = max(3, round(float(along[-1]) / (self.spacing * self.surface.diagonal)))
        even = at_lengths(curve, np.linspace(0.0, along[-1], count + 1))
        self._call("stroke", points=even[:-1] if closed else even, closed=closed)

    def _bent(self, at: Points, fixed: NDArray[np.intp], closed: bool) -> Points:
        """A polyline bent as little as its fixed points and the surface let it."""
        up = self.surface.nearest(at).normals
        free = np.setdiff1d(np.arange(len(at)), fixed)
        if len(at) < 4 or not len(free):
            return at
        for _ in range(self.rounds):
            bend = _second_differences(at, closed)
            matrix = np.eye(len(at)) + STIFFNESS * (bend.T @ bend)
            right = at[free] - matrix[np.ix_(free, fixed)] @ at[fixed]
            moved = at.copy()
            moved[free] = np.linalg.solve(matrix[np.ix_(free, free)], right)
            if closed:
                moved[-1] = moved[0]
            done = self.surface.project(moved, up, 0.1 * self.surface.diagonal)
            moved, up = done.points, done.normals
            moved[fixed] = at[fixed]
            at = moved
        return at


def _second_differences(at: Points, closed: bool) -> NDArray[np.float64]:
    """(k, n) rows that give the second differences of a polyline (n, 3), in its mean spacing."""
    n = len(at)
    step = np.linalg.norm(np.diff(at, axis=0), axis=1)
    step = np.maximum(step / step.mean(), 1e-3)
    rows = np.zeros((n if closed else n - 2, n))
    for k in range(1, n - 1):
        before, after = step[k - 1], step[k]
        rows[k - 1, k - 1 : k + 2] = 1 / before, -1 / before - 1 / after, 1 / after
    if closed:
        before, after = step[-1], step[0]
        rows[n - 2, [n - 2, 0, 1]] = 1 / before, -1 / before - 1 / after, 1 / after
    return rows
