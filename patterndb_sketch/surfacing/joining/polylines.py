"""Polylines as they come from files and hands: checked, moved onto nodes, ends brought together."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from patterndb.geometry.points import Points, as_points
from patterndb.geometry.polyline import arc_length
from patterndb_sketch.surfacing.network import InvalidNetworkError, drop_repeats

#: Coordinates beyond this are refused: the squares of their distances must remain numbers.
MAX_COORDINATE = 1e100

#: Places this close are one, as a share of the network's diagonal: programs and files keep some
#: six digits or more.
SAME_PLACE = 1e-6


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
