"""What a query asks of a pattern beside its lengths, and why nothing was found.

:class:`Filters` is what may be asked. Where a list stays empty, :func:`explain_empty` says what no
database could fill, and what this one does not hold.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.core.patternclass import PatternClass
from query.boundary import Boundary
from query.errors import InvalidQueryError, refuse_large

Range = tuple[int, int]

#: Interior vertices of two quads make poor meshes: refused unless asked for.
NO_DOUBLETS: Range = (3, 10_000)


class FilterColumns(Protocol):
    """What filters look at: (r,) arrays over patterns."""

    @property
    def ids(self) -> NDArray[np.int64]: ...
    @property
    def frequency(self) -> NDArray[np.int64]: ...
    @property
    def n_quads(self) -> Int32Array: ...
    @property
    def n_loops(self) -> Int32Array: ...
    @property
    def min_valence(self) -> Int32Array: ...
    @property
    def max_valence(self) -> Int32Array: ...


@dataclass(frozen=True, slots=True)
class Filters:
    """What may be asked for; None asks for nothing.

    max_irregular: the most irregular vertices, interior and boundary.
    valence:  (least, greatest) valence of every irregular interior vertex. A pattern without
              any passes.
    max_quads: the most quads of a fill.
    corners:  (least, greatest) number of corners of the pattern.
    has_loop: has the pattern a loop polychord?
    min_frequency: the fewest patches in which the pattern was seen.
    max_boundary_irregular: the most irregular vertices on the boundary.
    ids:      (k,) int64, ascending: patterns that may be taken, see
              :meth:`patterndb.store.Database.pattern_ids`.
    only:     the patterns that may be taken, by their ids, also of constructed fills.

    Raises InvalidQueryError for a negative bound, an empty range, and for numbers above MOST_COUNT.
    """

    max_irregular: int | None = None
    valence: Range | None = None
    max_quads: int | None = None
    corners: Range | None = None
    has_loop: bool | None = None
    min_frequency: int | None = None
    max_boundary_irregular: int | None = None
    ids: NDArray[np.int64] | None = field(default=None, compare=False)
    only: frozenset[int] | None = None

    def __post_init__(self) -> None:
        if self.max_irregular is not None and self.max_irregular < 0:
            raise InvalidQueryError(
                f"max_irregular is {self.max_irregular}; 0 asks for regular fills only"
            )
        if self.max_boundary_irregular is not None and self.max_boundary_irregular < 0:
            raise InvalidQueryError(
                f"max_boundary_irregular is {self.max_boundary_irregular}; 0 asks for strict "
                "fills only"
            )
        if self.valence is not None and not 1 <= self.valence[0] <= self.valence[1]:
            raise InvalidQueryError(
                f"valence is {self.valence}; write (least, greatest), such as (3, 5)"
            )
        if self.corners is not None and not 0 <= self.corners[0] <= self.corners[1]:
            raise InvalidQueryError(
                f"corners is {self.corners}; write (least, greatest), such as (4, 6)"
            )
        for name, value in (
            ("max_irregular", self.max_irregular),
            ("max_boundary_irregular", self.max_boundary_irregular),
            ("max_quads", self.max_quads),
            ("min_frequency", self.min_frequency),
            ("valence", None if self.valence is None else self.valence[1]),
            ("corners", None if self.corners is None else self.corners[1]),
        ):
            if value is not None:
                refuse_large(name, value)
        for name, value in (("max_quads", self.max_quads), ("min_frequency", self.min_frequency)):
            if value is not None and value < 1:
                raise InvalidQueryError(f"{name} is {value}; the least is 1, None leaves it open")

    @property
    def of_few(self) -> bool:
        """Are they for some patterns by name, so that nobody else will ask the same?"""
        return self.ids is not None or self.only is not None

    def rows(self, patterns: PatternClass, boundary: Boundary) -> NDArray[np.int64]:
        """(r,) int64 rows, ascending, that pass and have the boundary's corner kinds in number."""
        same_kinds = patterns.n_reflex == boundary.n_reflex
        return np.flatnonzero(same_kinds & self.passing(patterns))

    def passing(self, patterns: PatternClass) -> NDArray[np.bool_]:
        """(p,) bool: which patterns of the class pass, as strict fills."""
        passes = self.admitted(patterns, np.full(len(patterns), patterns.n_sides, np.int32))
        if self.max_irregular is not None:
            passes &= patterns.n_irregular <= self.max_irregular
        return passes

    def admitted(self, patterns: FilterColumns, n_corners: Int32Array) -> NDArray[np.bool_]:
        """(r,) bool: which patterns pass, whatever their fills' irregular vertices.

        n_corners: (r,) their corners.
        """
        passes = np.ones(len(patterns.ids), np.bool_)
        if self.valence is not None:
            # Without irregular vertices both bounds are 4.
            least, greatest = self.valence
            within = (patterns.min_valence >= least) & (patterns.max_valence <= greatest)
            passes &= within | ((patterns.min_valence == 4) & (patterns.max_valence == 4))
        if self.max_quads is not None:
            passes &= patterns.n_quads <= self.max_quads
        if self.corners is not None:
            passes &= (n_corners >= self.corners[0]) & (n_corners <= self.corners[1])
        if self.has_loop is not None:
            passes &= (patterns.n_loops > 0) == self.has_loop
        if self.min_frequency is not None:
            passes &= patterns.frequency >= self.min_frequency
        if self.ids is not None:
            passes &= np.isin(patterns.ids, self.ids)
        if self.only is not None:
            passes &= np.isin(patterns.ids, list(self.only))
        return passes


#: Quads around an interior vertex are at least two: with one, it would meet itself.
LEAST_VALENCE = 2


def explain_empty(
    patterns: PatternClass,
    boundary: Boundary,
    filters: Filters,
    n_candidates: int,
    *,
    strict: bool,
    strokes: int,
    together: Sequence[tuple[int, ...]] | None = (),
    relaxed: Sequence[str] = (),
) -> str:
    """Return one sentence. n_candidates: patterns of the class that pass the filters. strokes: how
    many were asked for. together: those, by their numbers from 0, that some fill has together; None
    where time was up before that was known. relaxed: the fills that exist without one of the
    filters, a part of a sentence each."""
    impossible = explain_impossible(boundary, filters) if strict else None
    if impossible:
        return impossible
    sides = _sides(boundary)
    if strokes:
        return (
            f"no fill has strands on all the strokes{_list_groups(together, strokes)}; allow a "
            "greater tolerance, leave a stroke out, or split the boundary along one"
        )
    if not strict:
        return f"no fill passes the filters; {' and '.join(relaxed) or 'relax them'}"
    if len(patterns) == 0:
        return (
            f"the database has no pattern with {sides}; learn from more meshes, or let corners "
            "fall elsewhere (relaxed matching)"
        )
    if n_candidates == 0:
        mend = " and ".join(relaxed) or "relax the filters or learn from more meshes"
        return (
            f"none of the {len(patterns)} patterns with {sides} has these corners and passes the "
            f"filters; {mend}"
        )
    lengths = ", ".join(map(str, boundary.lengths))
    return (
        f"none of the {n_candidates} patterns with {sides} that pass fits the lengths {lengths}; "
        + (" and ".join(relaxed) or "change the lengths, or learn from more meshes")
    )


def _list_groups(together: Sequence[tuple[int, ...]] | None, strokes: int) -> str:
    """What of the strokes goes together, as the part of a sentence."""
    if together is None:
        return " (time was up before it was known which of them go together)"
    if not together:
        return ", nor on any one of them" if strokes > 1 else ""
    groups = ", and with ".join(
        " and ".join(str(number + 1) for number in group) for group in together
    )
    alone = " alone" if len(together[0]) == 1 else ""
    return f", but there are fills with {groups}{alone}, counted as they were given"


def explain_impossible(boundary: Boundary, filters: Filters) -> str | None:
    """Why no strict fill exists at all, or None where nothing forbids one.

    Only what can be proved of every quad mesh is said. None is no promise of a fill.
    """
    return _short_side(boundary) or _too_few_irregular(boundary, filters)


def _short_side(boundary: Boundary) -> str | None:
    # At both ends of such a side lies the same quad. Peeled off, it leaves a side of
    # length 1 between neighbours one shorter, until one of them is used up: the quad at its
    # corner then has only boundary edges, so that all was a 1 by n rectangle.
    if not boundary.convex or boundary.n_sides in (0, 4) or 1 not in boundary.lengths:
        return None
    side = boundary.lengths.index(1)
    return (
        f"side {side} has length 1: between convex corners that has a strict fill only where "
        f"there are 4 sides, not {boundary.n_sides}; give it length 2"
    )


def _too_few_irregular(boundary: Boundary, filters: Filters) -> str | None:
    """Gauss-Bonnet: convex corners - reflex corners + sum over interior (4 - valence) = 4."""
    missing = 4 - sum(2 - count for count in boundary.corner_counts)
    if missing == 0:
        return None
    least, greatest = filters.valence or (LEAST_VALENCE, boundary.perimeter)
    each = 4 - max(least, LEAST_VALENCE) if missing > 0 else greatest - 4
    kind = "below" if missing > 0 else "above"
    turn = (
        f"{_sides(boundary)} ask for irregular vertices whose valences are {abs(missing)} "
        f"{kind} 4 in sum"
    )
    if each <= 0:
        return f"{turn}, and the valences allowed are {least} to {greatest}; widen the range"
    needed = -(-abs(missing) // each)
    if filters.valence is None and missing < 0:
        # Nothing bounds one valence from above: one vertex may do it all.
        needed = 1
    if filters.max_irregular is not None and needed > filters.max_irregular:
        return f"{turn}: at least {needed}, but max_irregular is {filters.max_irregular}"
    return None


def _sides(boundary: Boundary) -> str:
    if boundary.n_sides == 0:
        return "one closed side"
    reflex = boundary.n_reflex
    sides = "1 side" if boundary.n_sides == 1 else f"{boundary.n_sides} sides"
    return f"{sides}, {reflex} of their corners reflex," if reflex else sides
