"""Matches: the rows of one table that fit a boundary, with their widths, found bit by bit in order.

A stream of matches takes the table's rows in the order in which their fills may come, a share at a
time: small shares first, so that the first fill does not wait for the last pattern.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations_with_replacement, pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from query.boundary import Boundary
from query.cancellation import CancelFlag
from query.fill import Fill
from query.listing.ranking import Listing, Rank, Ranking
from query.listing.table import Table
from query.solving.problem import OFF
from query.solving.widths import WidthSolver


def list_loop_widths(n_loops: int, n_strokes: int) -> list[tuple[int, ...]]:
    """Widths (n_loops,) of the loop polychords, for every way to give each loop stroke a strand.

    A loop is as wide as it carries strokes, and at least 1; one strand carries one stroke.
    Narrowest first; none where there is a stroke and no loop.

    >>> list_loop_widths(2, 2)
    [(1, 1), (1, 2), (2, 1)]
    """
    found: set[tuple[int, ...]] = set()
    for carriers in combinations_with_replacement(range(n_loops), n_strokes):
        found.add(tuple(max(1, carriers.count(loop)) for loop in range(n_loops)))
    return sorted(found, key=lambda widths: (sum(widths), widths))


#: Rows of the first share; each share is GROWTH times the one before, up to MOST_ROWS.
FIRST_ROWS = 24
GROWTH = 4
MOST_ROWS = 8192

#: So many fits of a row are looked for first, unless fewer are asked for, and GROWTH times as
#: many whenever these run out.
FIRST_KEPT = 4

#: Of the rows that fit, so many are solved first, then twice as many each time.
FIRST_SOLVED = 4
MOST_SOLVED = 64


class Candidate(Protocol):
    """A fill that is yet to be made."""

    def fill(self) -> Fill: ...

    @property
    def may_repeat(self) -> bool:
        """May it equal another, or be no mesh?"""
        ...

    @property
    def pattern_id(self) -> int:
        """What ``per_pattern`` counts by."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Continuation:
    """Matches of a pattern that are yet to be found; they rank where this stands, or after it."""

    find: Callable[[], list[Found]]
    pattern_id: int


Found = tuple[Rank, "Candidate | Continuation"]


@dataclass(frozen=True, slots=True)
class Batch:
    """Matches of a stream, and the bound on those that may still come.

    found: candidates with their ranks, in any order.
    bound: nothing that comes later ranks before it; None where nothing comes any more.
    """

    found: list[Found]
    bound: Rank | None


@dataclass(frozen=True, slots=True)
class Match:
    """A row of a table with the widths that make it meet a boundary.

    table, row:  what is to be expanded.
    orientation: number of the orientation in :func:`query.orientation.list_orientations`.
    widths:      of the strands.
    loops:       of the loop polychords.
    n_boundary:  irregular vertices on the boundary.
    off:         edges by which strands miss strokes, or None where there are none.
    """

    table: Table
    row: int
    orientation: int
    widths: tuple[int, ...]
    loops: tuple[int, ...]
    n_boundary: int
    off: int | None

    def fill(self) -> Fill:
        """Expand it."""
        fill = self.table.fill(self.row, self.orientation, self.widths, self.loops)
        return replace(
            fill,
            n_irregular=fill.pattern.n_irregular + self.n_boundary,
            n_irregular_boundary=self.n_boundary,
            flow_distance=None if self.off is None else float(self.off),
        )

    @property
    def may_repeat(self) -> bool:
        return self.table.may_repeat(self.row)

    @property
    def pattern_id(self) -> int:
        return int(self.table.ids[self.row])


@dataclass(frozen=True, slots=True, eq=False)
class MatchSearch:
    """What all streams of matches of a query need.

    solver:    of the width problem of the boundary and strokes.
    keep:      fits of one row that are looked for at first.
    n_loops:   loop strokes.
    least_off: fits whose strands miss the strokes by fewer edges are left out.
    """

    boundary: Boundary
    solver: WidthSolver
    ranking: Ranking
    keep: int
    n_loops: int
    least_off: int = 0

    @property
    def strokes(self) -> bool:
        """Are there strokes that end on the boundary?"""
        return self.solver.problem.has_strokes

    @property
    def cancelled(self) -> CancelFlag:
        """The flag that another thread sets once nobody waits for the answer any more."""
        return self.solver.cancelled


def list_matches(
    table: Table, listing: Listing, search: MatchSearch, least: int
) -> Iterator[Batch]:
    """The matches of the entries listed; the first batch has only a bound.

    least: no fit has fewer irregular vertices.
    """
    possible = listing.entries.n_irregular >= least
    if not possible.all():
        listing = listing.take(possible)
    if not len(listing):
        return
    at, size, solve = 0, FIRST_ROWS, FIRST_SOLVED
    yield Batch([], listing.rank(0, 0, -1))
    while at < len(listing):
        last = min(at + size, len(listing))
        after = listing.rank(last, 0, -1) if last < len(listing) else None
        places = np.arange(at, last)
        entries = listing.entries.take(slice(at, last))
        allowed = search.solver.find_feasible(table, entries.row, entries.packed)
        at, size = last, min(size * GROWTH, MOST_ROWS)
        some = allowed.any(axis=1)
        hits, allowed = places[some], allowed[some]
        if not len(hits) and not search.cancelled[0]:
            yield Batch([], after)
        end = 0
        while end < len(hits):
            if search.cancelled[0]:
                return
            begin, end = end, end + solve
            solve = min(2 * solve, MOST_SOLVED)
            bound = listing.rank(int(hits[end]), 0, -1) if end < len(hits) else after
            near = hits[begin:end], allowed[begin:end]
            found = _find_matches(table, listing, *near, search, search.keep, 0)
            yield Batch(found, bound)


def _find_matches(
    table: Table,
    listing: Listing,
    hits: NDArray[np.int64],
    allowed: NDArray[np.bool_],
    search: MatchSearch,
    keep: int,
    known: int,
) -> list[Found]:
    """The first ``keep`` fits of the entries at these places, but for the first ``known`` of each.

    Where an entry may have more fits, the last found says how to get them. A search that was
    cancelled gets those found until then.
    """
    rows = listing.entries.row[hits]
    solve_most = keep * table.copies(rows)
    solved = search.solver.find_best(table.labels, rows, allowed, solve_most)
    found: list[Found] = []
    ends = np.searchsorted(solved.row, np.arange(len(hits) + 1)).tolist()
    widths = solved.widths.tolist()
    offs = (solved.key // OFF).tolist()
    turned = solved.orientation.tolist()
    for hit, (first, last) in enumerate(pairwise(ends)):
        at = int(hits[hit])
        row = int(rows[hit])
        single = table.one_of_each(row, solved.widths[first:last]).tolist()
        loops = list_loop_widths(int(table.n_loops[row]), search.n_loops)
        place = 0
        for f in range(first, last):
            if search.cancelled[0]:
                return found
            if not single[f - first]:
                continue
            for wide in loops:
                if place >= known and offs[f] >= search.least_off:
                    off = offs[f] if search.strokes or search.n_loops else None
                    on_boundary = int(listing.entries.n_irregular_boundary[at])
                    fit = Match(table, row, turned[f], tuple(widths[f]), wide, on_boundary, off)
                    found.append((listing.rank(at, offs[f], place), fit))
                place += 1
        if last - first >= solve_most and not search.cancelled[0]:
            later = partial(
                _find_matches,
                table,
                listing,
                hits[hit : hit + 1],
                allowed[hit : hit + 1],
                search,
                keep * GROWTH,
                place,
            )
            more = Continuation(later, int(table.ids[row]))
            found.append((listing.rank(at, offs[last - 1], place), more))
    return found
