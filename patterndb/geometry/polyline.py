"""Polylines: arc length, equal sampling, and how the sides of a boundary join."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.errors import InvalidBoundaryError
from patterndb.geometry.points import Points, as_points
from patterndb.system.numbers import MOST_EDGES

#: Ends of neighbouring polylines this close, as a share of the boundary's diagonal, are one
#: corner: files keep some six digits.
JOIN_TOLERANCE = 1e-5

#: The fewest edges around any quad mesh: one quad.
MIN_EDGES = 4

#: The most edges around a boundary. A fill of a perimeter P has up to about P**2 / 16 quads
#: times the crossings of the polychords: beyond this a list of fills no longer fits in memory,
#: and is surely a slip.
MAX_EDGES = MOST_EDGES


def arc_length(points: Points) -> NDArray[np.float64]:
    """(k,) length of the polyline (k, 3) up to every point; the first is 0."""
    along = np.zeros(len(points))
    np.cumsum(np.linalg.norm(points[1:] - points[:-1], axis=1), out=along[1:])
    return along


def at_lengths(points: Points, lengths: ArrayLike) -> Points:
    """(m, 3) points of the polyline (k, 3) at these arc lengths (m,), the ends beyond them."""
    return interpolate(points, arc_length(points), np.asarray(lengths, np.float64))


def interpolate(values: Points, along: NDArray[np.float64], wanted: NDArray[np.float64]) -> Points:
    """(m, 3) values (k, 3), known at places (k,) in ascending order, at wanted places (m,)."""
    return np.stack([np.interp(wanted, along, values[:, d]) for d in range(3)], axis=1)


def find_nearest_on(line: Points, point: ArrayLike) -> tuple[float, int, float]:
    """Find the place of a polyline (k, d) that is nearest to a point (d,).

    Returns how far it is, the number of the piece that it is on, and how far along that, 0 to 1.
    A line of one point has one piece, without a length.
    """
    ends = line if len(line) > 1 else line[[0, 0]]
    start, step = ends[:-1], np.diff(ends, axis=0)
    size = np.maximum((step**2).sum(axis=1), np.finfo(np.float64).tiny)
    share = np.clip(((np.asarray(point, np.float64) - start) * step).sum(axis=1) / size, 0.0, 1.0)
    away = np.linalg.norm(start + share[:, None] * step - point, axis=1)
    k = int(away.argmin())
    return float(away[k]), k, float(share[k])


def sample_polyline(points: Points, edges: int) -> Points:
    """(edges + 1, 3) points at equal arc length along the polyline (k, 3), ends exact."""
    result = at_lengths(points, np.linspace(0, float(arc_length(points)[-1]), edges + 1))
    result[0], result[-1] = points[0], points[-1]
    return result


def join_sides(sides: Sequence[ArrayLike], closed: bool) -> list[Points]:
    """The polylines with their ends made equal where they meet.

    closed: there is one polyline, which ends where it begins (the end may be left out).
    Raises InvalidBoundaryError, naming the side, for one that does not join the next.
    """
    chains = [as_points(side, f"side {i}") for i, side in enumerate(sides)]
    if not chains:
        raise InvalidBoundaryError("a boundary needs at least one side")
    everything = np.concatenate(chains)
    reach = JOIN_TOLERANCE * float(np.linalg.norm(np.ptp(everything, axis=0)))
    if closed and np.linalg.norm(chains[0][0] - chains[0][-1]) > reach:
        chains[0] = np.concatenate([chains[0], chains[0][:1]])
    for i, chain in enumerate(chains):
        if len(chain) < 2 or arc_length(chain)[-1] <= reach:
            raise InvalidBoundaryError(f"side {i} has no length; give it two points or more")
        follower = chains[(i + 1) % len(chains)]
        gap = float(np.linalg.norm(chain[-1] - follower[0]))
        if gap > reach:
            raise InvalidBoundaryError(
                f"side {i} ends {gap:.3g} away from where side {(i + 1) % len(chains)} begins; "
                "sides run counter-clockwise, each from the end of the one before"
            )
        chain[-1] = follower[0]
    return chains


def edge_counts(chains: Sequence[Points], edge_length: float) -> list[int]:
    """Edges per polyline, each about ``edge_length`` long, with an even sum of at least 4.

    Where rounding gives an odd sum, the polyline whose edges change least in proportion has
    one more or one fewer.
    """
    if not (np.isfinite(edge_length) and edge_length > 0):
        raise InvalidBoundaryError(f"edge_length is {edge_length}; give a length above 0")
    wanted = [float(arc_length(chain)[-1]) / edge_length for chain in chains]
    if sum(wanted) > MAX_EDGES:
        raise InvalidBoundaryError(
            f"edge_length {edge_length:g} would make {sum(wanted):.3g} edges around the "
            f"boundary; the limit is {MAX_EDGES}, so make it longer"
        )
    counts = [max(1, round(w)) for w in wanted]
    while sum(counts) < MIN_EDGES or sum(counts) % 2:
        steps = (1,) if sum(counts) < MIN_EDGES else (-1, 1)
        _, side, step = min(
            (abs(math.log((counts[i] + step) / wanted[i])), i, step)
            for i in range(len(counts))
            for step in steps
            if counts[i] + step >= 1
        )
        counts[side] += step
    return counts
