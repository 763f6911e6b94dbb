"""Which side lengths have a cheap regular fill, and what counts cost in all.

A fill is cheap here where as few irregular vertices as its number of sides asks for will do, in
a patch of 3, 4 or 5 sides: a grid, or one inner vertex of valence 3 or 5.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from patterndb.halfedge import Int32Array
from query.boundary import Boundary
from query.listing.familylookup import MOST_SIDES, FamilyLookup
from sketch.retopo.counts.problem import CountsProblem

#: Twice the edges of the narrowest strip of quads about the inner vertex of a triangle or
#: pentagon: every strip is one edge wide at least.
LEAST_TWICE = 2


def irregular_patches(problem: CountsProblem, counts: Int32Array) -> NDArray[np.bool_]:
    """(p,) bool: the patches without a cheap regular fill."""
    lengths = problem.side_lengths(counts)
    if problem.cheap is None:
        return _irregular(problem.first_side, lengths)
    first = problem.first_side
    return np.array(
        [
            not problem.cheap(tuple(lengths[first[f] : first[f + 1]].tolist()))
            for f in range(problem.n_patches)
        ],
        np.bool_,
    )


def total(problem: CountsProblem, counts: Int32Array) -> float:
    """Errors of all chains, and the cost of all patches without a cheap regular fill."""
    n_irregular = int(irregular_patches(problem, counts).sum())
    return float(problem.errors(counts).sum()) + problem.regularity * n_irregular


def has_cheap_fill(lengths: tuple[int, ...]) -> bool:
    """Has a patch of these side lengths a grid, or a fill with one inner vertex, irregular?

    N = 4: opposite sides are equal. N = 3 and 5: with an even perimeter, every strip between
    the inner vertex and the boundary is one edge wide or more: l_i + l_j - l_k >= 2, and
    l_i-1 + l_i + l_i+1 - l_i+2 - l_i-2 >= 2, for all i. Other patches have none.
    """
    return bool(is_cheap(np.array(lengths, np.int32), 0, len(lengths)))


def family_rule(lengths: tuple[int, ...]) -> bool:
    """The same by the complete family, for 2 to 8 sides: has it a fill with |N - 4| irregular ones?

    Vertices of the boundary count with the inner ones. It is asked by
    :class:`query.listing.familylookup.FamilyLookup`, which takes 2 to 130 microseconds and grows
    the family on first use.
    """
    n = len(lengths)
    if not 2 <= n <= MOST_SIDES or sum(lengths) % 2:
        return False
    count = FamilyLookup.shared().count(Boundary(lengths))
    return count is not None and count <= abs(n - 4)


@njit(cache=True, nogil=True)
def _irregular(first_side: Int32Array, lengths: Int32Array) -> NDArray[np.bool_]:
    found = np.empty(len(first_side) - 1, np.bool_)
    for f in range(len(found)):
        found[f] = not is_cheap(lengths, first_side[f], first_side[f + 1])
    return found


@njit(cache=True, nogil=True)
def is_cheap(lengths: Int32Array, low: int, high: int) -> bool:
    """:func:`has_cheap_fill` of lengths[low:high]."""
    n = high - low
    if n == 4:
        return lengths[low] == lengths[low + 2] and lengths[low + 1] == lengths[low + 3]
    if n != 3 and n != 5:
        return False
    perimeter = 0
    for i in range(n):
        perimeter += lengths[low + i]
    if perimeter % 2:
        return False
    for i in range(n):
        less = lengths[low + i]
        if n == 5:
            less += lengths[low + (i + 1) % n]
        if perimeter - 2 * less < LEAST_TWICE:
            return False
    return True
