"""Tell which side lengths have a regular fill, and what counts cost in all.

A patch of N sides has |N - 4| irregular vertices at least, or some of higher valence. Which side
lengths can do with so many, the complete family of the database knows
(:func:`is_cheap_by_family`). Its answer follows from a few inequalities, which take nanoseconds. By
Gauss and Bonnet no strip of quads leads from a side back to itself, nor to a neighbour of it, if no
vertex has fewer than four quads: what lies across must be long enough, for each side and for each
two neighbours. For 2 to 6 sides this is the family's answer exactly; for more it is sufficient.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb._native.retopo.counts.rules import find_irregular, is_cheap
from patterndb.core.halfedge import Int32Array
from patterndb_sketch.retopo.counts.problem import CountsProblem
from query.boundary import MAX_PERIMETER, Boundary
from query.listing.construction import MOST_SIDES, FamilyLookup

#: Up to so many sides the inequalities are the family's own answer.
SURE_SIDES = 6


def find_irregular_patches(problem: CountsProblem, counts: Int32Array) -> NDArray[np.bool_]:
    """Find the patches without a regular fill: (p,) bool."""
    lengths = problem.side_lengths(counts)
    if problem.cheap is None:
        return find_irregular(problem.first_side, lengths)
    first = problem.first_side
    return np.array(
        [
            not problem.cheap(tuple(lengths[first[f] : first[f + 1]].tolist()))
            for f in range(problem.n_patches)
        ],
        np.bool_,
    )


def sum_costs(problem: CountsProblem, counts: Int32Array) -> float:
    """Sum the errors of all chains and the costs of all patches without a regular fill."""
    n_irregular = int(find_irregular_patches(problem, counts).sum())
    return float(problem.errors(counts).sum()) + problem.regularity * n_irregular


def has_cheap_fill(lengths: tuple[int, ...]) -> bool:
    """Has a patch of these side lengths, each 1 or more, a fill of |N - 4| irregular vertices?

    Those on the boundary count with those inside. All need an even perimeter. N = 4: opposite
    sides are equal. N = 3: no side is longer than the others together. N >= 5: no side is longer
    than those that do not touch it, and no two neighbours are longer than all others. N < 3: all.

    Where it is False for 7 sides or more, a fill of so many may exist all the same, with a vertex
    of valence 3 between corners of three quads: see :func:`is_cheap_by_family`.
    """
    return bool(is_cheap(np.array(lengths, np.int32), 0, len(lengths)))


def is_cheap_by_family(lengths: tuple[int, ...]) -> bool:
    """Has it by the complete family itself? For 2 to 8 sides.

    It is asked by :class:`query.listing.construction.FamilyLookup`, which takes 2 to 130
    microseconds and grows the family on first use: too much for a search that asks a million
    times, so that :func:`has_cheap_fill` answers there.
    """
    n = len(lengths)
    if not 2 <= n <= MOST_SIDES or sum(lengths) % 2:
        return False
    count = FamilyLookup().count(Boundary(lengths))
    return count is not None and count <= abs(n - 4)


def find_misjudged_patches(problem: CountsProblem, counts: Int32Array) -> tuple[int, ...]:
    """Find patches of 7 or 8 sides that only the inequalities, not the family, call irregular."""
    if problem.cheap is not None:
        return ()
    sides = np.diff(problem.first_side)
    asked = find_irregular_patches(problem, counts) & (sides > SURE_SIDES) & (sides <= MOST_SIDES)
    asked &= problem.perimeters(counts) % 2 == 0
    asked &= problem.perimeters(counts) <= MAX_PERIMETER
    lengths, first = problem.side_lengths(counts), problem.first_side
    return tuple(
        f
        for f in np.flatnonzero(asked).tolist()
        if is_cheap_by_family(tuple(lengths[first[f] : first[f + 1]].tolist()))
    )
