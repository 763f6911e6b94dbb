"""Polylines as they come from files and hands: checked, moved onto nodes, ends brought together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats, Points, as_points
from patterndb.geometry.polyline import arc_length, find_nearest_on
from patterndb_sketch.curvenetwork.network import InvalidNetworkError

#: Coordinates beyond this are refused: the squares of their distances must remain numbers.
MAX_COORDINATE = 1e100

#: Places this close are one, as a share of the network's diagonal: programs and files keep some
#: six digits or more.
SAME_PLACE = 1e-6


#: A polyline that turns by more than this at a point has a corner there, in radians
#: (Abbasinejad et al. 2013, section 3.1: 20 degrees).
CORNER_ANGLE = math.radians(20)


def as_places(points: ArrayLike, name: str) -> Points:
    """A (k, 3) float64 copy of (k, 3) or (k, 2) points.

    name: what messages call them. Raises InvalidNetworkError for what is no list of finite
    points with coordinates up to MAX_COORDINATE.
    """
    array = as_points(points, name, InvalidNetworkError)
    if len(array) and np.abs(array).max() > MAX_COORDINATE:
        raise InvalidNetworkError(
            f"{name} has a coordinate beyond {MAX_COORDINATE:g}; give it in a larger unit"
        )
    return array


def as_curve(points: ArrayLike, name: str) -> Points:
    """A (k, 3) float64 copy of (k, 3) or (k, 2) points, k >= 2, no two in a row alike.

    Raises InvalidNetworkError as :func:`as_places` does, and for a polyline without length.
    """
    array = as_places(points, name)
    if len(array):
        array = drop_repeats(array)
    if len(array) < 2 or arc_length(array)[-1] == 0:
        raise InvalidNetworkError(f"{name} has no length; give it two places, or leave it out")
    return array


def measure_diagonal(polylines: list[Points]) -> float:
    """Measure the diagonal of the box around some polylines, 0 without any."""
    if not polylines:
        return 0.0
    low = np.min([points.min(axis=0) for points in polylines], axis=0)
    high = np.max([points.max(axis=0) for points in polylines], axis=0)
    return float(np.linalg.norm(high - low))


def move_ends(points: Points, first: ArrayLike, last: ArrayLike) -> Points:
    """Move the ends of a polyline (k, 3) to ``first`` and ``last``, exactly.

    What the ends move by is spread along the curve in proportion to arc length, so that no
    kink arises; a straight line stays straight. Points that fall on the one before are left
    out; fewer than two remain if nothing is left of the curve.
    """
    along = arc_length(points)
    share = (along / along[-1])[:, None]
    moved = points + ((1 - share) * (first - points[0]) + share * (last - points[-1]))
    moved[0], moved[-1] = first, last
    return drop_repeats(moved)


def drop_repeats(points: Points) -> Points:
    """The points of a polyline (k, 3) without those that repeat the one before."""
    differs = (points[1:] != points[:-1]).any(axis=1)
    if differs.all():
        return np.ascontiguousarray(points)
    return np.concatenate([points[:1], points[1:][differs]])


def measure_turning(points: Points) -> NDArray[np.float64]:
    """(k - 2,) turning angle in radians at every inner point of a polyline (k, 3)."""
    steps = np.diff(points, axis=0)
    return measure_angles(steps[:-1], steps[1:])


def measure_angles(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """(m,) angle in radians between the rows of two (m, 3) arrays of vectors, 0 to pi."""
    # By powers of two, which change no digit: products of large or small ones stay numbers.
    a, b = (np.ldexp(v, -np.frexp(np.abs(v).max(axis=-1, keepdims=True))[1]) for v in (a, b))
    # The arc tangent keeps its precision where the arc cosine loses it: near 0 and pi.
    return np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), (a * b).sum(axis=-1))


def gather_places(points: Points, tolerance: float) -> tuple[Points, NDArray[np.int64]]:
    """Gather points (n, 3) into places: those within the tolerance of each other are one.

    Returns the places (m, 3), each the mean of its points, in the order of their first points,
    and for every point its place (n,). The places do not depend on the order of the points.
    """
    exact, which = np.unique(points, axis=0, return_inverse=True)
    which = which.reshape(-1)
    pairs = KDTree(exact).query_pairs(tolerance, output_type="ndarray")
    links = coo_array((np.ones(len(pairs), bool), pairs.T), shape=(len(exact), len(exact)))
    n_places, labels = connected_components(links, directed=False)
    places = np.zeros((n_places, 3))
    np.add.at(places, labels, exact)
    places /= np.bincount(labels, minlength=n_places)[:, None]
    # In the order in which the points first come to them.
    _, first = np.unique(labels[which], return_index=True)
    order = np.argsort(first)
    number = np.empty(n_places, np.int64)
    number[order] = np.arange(n_places)
    return places[order], number[labels[which]]


class Groups:
    """Things 0 to n - 1, each at first a group of its own (union-find)."""

    def __init__(self, n: int) -> None:
        self._parent = list(range(n))

    def find(self, thing: int) -> int:
        """Return the group of a thing: the least thing in it."""
        parent = self._parent
        while parent[thing] != thing:
            parent[thing] = parent[parent[thing]]
            thing = parent[thing]
        return thing

    def unite(self, one: int, other: int) -> int:
        """Make one group of the groups of two things, and return it."""
        first, second = sorted((self.find(one), self.find(other)))
        self._parent[second] = first
        return first


@dataclass(frozen=True, slots=True)
class PackedCurves:
    """Polylines in one array.

    points: (n, 3). starts: (c + 1,) where each of them begins there. along: (n,) arc length from
    the beginning of its curve. lasts: (c,) how long they are. closed: (c,) which end where they
    begin. curve_of: (n,) the curve of every point.
    """

    points: Points = field(repr=False)
    starts: Int64Array = field(repr=False)
    along: Floats = field(repr=False)
    lasts: Floats = field(repr=False)
    closed: NDArray[np.bool_] = field(repr=False)
    curve_of: Int64Array = field(repr=False)

    def __len__(self) -> int:
        return len(self.lasts)

    def split(self) -> list[Points]:
        """Return the polylines one by one."""
        return np.split(self.points, self.starts[1:-1])

    def find_edges(self, curves: Int64Array, lengths: Floats) -> Int64Array:
        """(m,) the edge, by the number of its first point, at arc lengths (m,) of curves (m,)."""
        # All curves in a row: each goes from twice its number to one more.
        long = np.where(self.lasts > 0.0, self.lasts, 1.0)
        row = 2.0 * self.curve_of + self.along / long[self.curve_of]
        wanted = 2.0 * curves + lengths / long[curves]
        edges = np.searchsorted(row, wanted, side="right") - 1
        return np.clip(edges, self.starts[curves], self.starts[curves + 1] - 2)

    def find_vertices(self, curves: Int64Array, lengths: Floats) -> Int64Array:
        """(m,) the vertex that is nearest, along the curve, to arc lengths (m,) of curves (m,)."""
        edges = self.find_edges(curves, lengths)
        return edges + (lengths - self.along[edges] > self.along[edges + 1] - lengths)

    def locate(self, curves: Int64Array, lengths: Floats) -> Points:
        """(m, 3) the places at arc lengths (m,) of curves (m,)."""
        edges = self.find_edges(curves, lengths)
        size = self.along[edges + 1] - self.along[edges]
        share = (lengths - self.along[edges]) / np.where(size > 0.0, size, 1.0)
        share = np.clip(share, 0.0, 1.0)[:, None]
        return (1.0 - share) * self.points[edges] + share * self.points[edges + 1]

    def select_between_points(
        self, curves: Int64Array, lengths: Floats, within: float
    ) -> tuple[Int64Array, Floats]:
        """Select arc lengths (m,) of curves (m,) that have no point ``within`` along the curve.

        Returns them by curve and length; of several within ``within`` of each other the first.
        """
        between = np.flatnonzero(
            np.abs(self.along[self.find_vertices(curves, lengths)] - lengths) > within
        )
        between = between[np.lexsort((lengths[between], curves[between]))]
        curves, lengths = curves[between], lengths[between]
        apart = (np.diff(curves) > 0) | (np.diff(lengths) > within)
        first = np.r_[True, apart][: len(between)]
        return curves[first], lengths[first]

    def is_open_end(self, curves: Int64Array, lengths: Floats) -> NDArray[np.bool_]:
        """Which places at arc lengths of curves are an end of a curve that is not closed."""
        return ((lengths == 0.0) | (lengths == self.lasts[curves])) & ~self.closed[curves]

    def is_seam(self, curves: Int64Array, lengths: Floats) -> NDArray[np.bool_]:
        """Which pairs of places (m, 2) are both ends of one curve: where it is closed."""
        at_ends = (lengths.min(axis=1) == 0.0) & (lengths.max(axis=1) == self.lasts[curves[:, 0]])
        return at_ends & (curves[:, 0] == curves[:, 1])

    def find_nearest(
        self, curve: int, place: Points, within: tuple[float, float]
    ) -> tuple[float, float]:
        """Find the arc length, within two of a curve, nearest to a place (3,), and the distance."""
        along = self.along[self.starts[curve] : self.starts[curve + 1]]
        line = self.points[self.starts[curve] : self.starts[curve + 1]]
        begin = int(np.searchsorted(along, within[0], side="right")) - 1
        begin = min(max(begin, 0), len(line) - 2)
        end = max(min(int(np.searchsorted(along, within[1])) + 1, len(line)), begin + 2)
        away, edge, share = find_nearest_on(line[begin:end], place)
        first, last = along[begin + edge], along[begin + edge + 1]
        length = last if share == 1.0 else first + share * (last - first)
        return float(np.clip(length, *within)), away


def pack_curves(lines: Sequence[Points]) -> PackedCurves:
    """Put polylines (k, 3), one or more, in one array."""
    points = np.concatenate(lines)
    starts = np.cumsum([0, *map(len, lines)])
    first, last = starts[:-1], starts[1:] - 1
    along = np.zeros(len(points))
    steps = np.linalg.norm(points[1:] - points[:-1], axis=1)
    for begin, end in pairwise(starts.tolist()):
        np.cumsum(steps[begin : end - 1], out=along[begin + 1 : end])
    closed = (points[first] == points[last]).all(axis=1)
    curve_of = np.repeat(np.arange(len(lines)), np.diff(starts))
    return PackedCurves(points, starts, along, along[last], closed, curve_of)


def is_closed(line: Points) -> bool:
    """Does a polyline end where it begins?"""
    return bool((line[0] == line[-1]).all())
