"""How dense quads shall be: brush strokes on the surface, and lengths measured with them.

A density of 2 is edges half as long as the target, 0.5 edges twice as long. Where strokes lie over
one another, a later one is laid over what the earlier ones gave. All is kept as strokes, not as
values on the surface's vertices: a density is the same on any surface, and costs what was painted.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length

#: The least and the greatest density that strokes come to.
LEAST, MOST = 0.125, 8.0

#: Samples of a line are nearer to each other than this part of the smallest brush over it...
STEP = 0.25
#: ... but a segment is parted into so many at most.
MOST_STEPS = 256

#: Segments of a stroke that are measured from at once, where there are more pairs of a point and a
#: segment than these.
PIECE, FEW = 8, 10_000


@dataclass(frozen=True, slots=True, eq=False)
class Paint:
    """What a brush was drawn along.

    starts, ends: (s, 3) float64, its segments; a click is one without length. normals: (s, 3) of
    the surface there: what faces the other way, on the far side of a sheet, is not painted.
    radius: at which the brush ends; its effect falls evenly from the line to there.
    factor: that the density on the line is multiplied by, or, if it is set, what it is set to.
    """

    starts: Points = field(repr=False)
    ends: Points = field(repr=False)
    normals: Points = field(repr=False)
    radius: float
    factor: float
    sets: bool = False

    def __post_init__(self) -> None:
        for array in (self.starts, self.ends, self.normals):
            array.flags.writeable = False

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Paint) and self._content() == other._content()

    def __hash__(self) -> int:
        return hash(self._content())

    def _content(self) -> tuple[object, ...]:
        arrays = (self.starts, self.ends, self.normals)
        return (*(a.tobytes() for a in arrays), self.radius, self.factor, self.sets)

    def joined(self, other: Paint) -> Paint:
        """This brush along the lines of another, too."""
        return Paint(
            np.concatenate([self.starts, other.starts]),
            np.concatenate([self.ends, other.ends]),
            np.concatenate([self.normals, other.normals]),
            self.radius,
            self.factor,
            self.sets,
        )

    def find_box(self) -> Points:
        """(2, 3) the lowest and the highest coordinates that it may reach."""
        both = np.concatenate([self.starts, self.ends])
        return np.stack([both.min(axis=0) - self.radius, both.max(axis=0) + self.radius])

    def weigh(self, points: Points, normals: Points) -> NDArray[np.float64]:
        """(n,) its effect at points (n, 3) with normals: 1 on its line, 0 from the radius on."""
        away = np.full(len(points), math.inf)
        # Few points are measured from all of it sooner than sorted out.
        size = PIECE if len(points) * len(self.starts) > FEW else len(self.starts)
        for first in range(0, len(self.starts), size):
            piece = slice(first, first + size)
            # A long stroke passes most points far off.
            both = np.concatenate([self.starts[piece], self.ends[piece]])
            low, high = both.min(axis=0) - self.radius, both.max(axis=0) + self.radius
            near = np.flatnonzero(((points >= low) & (points <= high)).all(axis=1))
            if len(near):
                there = self._measure_from(points[near], normals[near], piece)
                away[near] = np.minimum(away[near], there)
        t = np.minimum(away / self.radius, 1.0)
        return 1.0 - t * t * (3.0 - 2.0 * t)

    def _measure_from(self, points: Points, normals: Points, piece: slice) -> NDArray[np.float64]:
        """(n,) how far points are from some segments; infinitely on the far side of a sheet."""
        starts = self.starts[piece]
        along = self.ends[piece] - starts
        size = np.maximum((along**2).sum(axis=1), np.finfo(np.float64).tiny)
        from_start = points[:, None] - starts
        share = np.clip(np.einsum("nsc,sc->ns", from_start, along) / size, 0.0, 1.0)
        off = from_start - share[..., None] * along
        away = np.sqrt(np.einsum("nsc,nsc->ns", off, off))
        away[normals @ self.normals[piece].T <= 0.0] = math.inf
        return away.min(axis=1)


@dataclass(frozen=True)
class Density:
    """strokes: in the order in which they were painted."""

    strokes: tuple[Paint, ...] = ()

    @cached_property
    def _boxes(self) -> NDArray[np.float64]:
        """(k, 2, 3) of the strokes."""
        return np.array([one.find_box() for one in self.strokes]).reshape(-1, 2, 3)

    def painted(self, stroke: Paint) -> Density:
        """With one more stroke."""
        return Density((*self.strokes, stroke))

    def find_over(self, points: Points) -> list[Paint]:
        """The strokes that may reach points (n, 3)."""
        return [self.strokes[k] for k in self._number_over(points)]

    def _number_over(self, points: Points) -> list[int]:
        low, high = points.min(axis=0), points.max(axis=0)
        over = (self._boxes[:, 0] <= high) & (self._boxes[:, 1] >= low)
        return np.flatnonzero(over.all(axis=1)).tolist()

    def at(self, points: Points, normals: Points) -> NDArray[np.float64]:
        """(n,) the density at points (n, 3) of the surface with normals (n, 3)."""
        found = np.zeros(len(points))
        for k in self._number_over(points) if len(points) else ():
            stroke, (low, high) = self.strokes[k], self._boxes[k]
            near = ((points >= low) & (points <= high)).all(axis=1)
            share = stroke.weigh(points[near], normals[near])
            wanted = math.log(stroke.factor) + (0.0 if stroke.sets else found[near])
            found[near] += share * (wanted - found[near])
            np.clip(found, math.log(LEAST), math.log(MOST), out=found)
        return np.exp(found)

    def measure(self, line: Points, normals: Points) -> tuple[Points, Points]:
        """(k,) arc lengths along a polyline, and (k,) its lengths up to there as edges count: each
        part times the density on it. line: (n, 3), k >= n; normals: (n, 3)."""
        along = arc_length(line)
        over = self.find_over(line)
        if not over:
            return along, along
        step = STEP * min(stroke.radius for stroke in over)
        parts = np.clip(np.ceil(np.diff(along) / step), 1, MOST_STEPS).astype(np.int64)
        first = np.repeat(np.cumsum(parts) - parts, parts)
        place = np.repeat(np.arange(len(parts)), parts)
        place = np.append(place + (np.arange(len(first)) - first) / parts[place], len(line) - 1)
        number = np.arange(len(line))
        points, up = (
            np.stack([np.interp(place, number, values[:, d]) for d in range(3)], axis=1)
            for values in (line, normals)
        )
        lengths = np.interp(place, number, along)
        value = self.at(points, up)
        steps = 0.5 * (value[1:] + value[:-1]) * np.diff(lengths)
        return lengths, np.concatenate([[0.0], np.cumsum(steps)])


#: The density of a network on which nothing is painted.
EVEN = Density()
