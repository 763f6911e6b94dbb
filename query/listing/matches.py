"""Matches: the rows of one table that fit a boundary, found bit by bit in the order of their fills.

A stream of matches takes the table's rows in the order in which their fills may come, a share at a
time: small shares first, so that the first fill does not wait for the last pattern. Matches are
ranked before they are expanded, in one of two orders; all others sort what these find by a measure
(:mod:`query.listing.orders`).

"regular": fewest irregular vertices, then fewest of them on the boundary, then the pattern seen
most often (Marcias et al. 2015, section 4, their order).

"artist": by what artists did, as far as a database tells. A pattern's patches are shared by the
ways in which it can lie in a boundary, of which its symmetries leave the fewer the more it has,
so that a fill is worth

    frequency * meshes * symmetries / (k * 20 ** d)

where the number of meshes makes up for meshes that repeat one pattern; k counts the fills of one
pattern from 1, most even widths first, so that fills of many patterns stand side by side, not
all of the first pattern before any of the second; and d is the number of edges by which strands
miss the strokes: nearly always the exact fill is meant, but whoever draws may be off by one.
Differs from the paper: fewest irregular vertices first hides what artists do with one or two
more; benchmarks/RESULTS.md has how often either order lists an artist's own fill.

Where strokes have ends, fits that miss none of them come first in both, and those that do after
them, by a search of their own (:mod:`query.listing.merging`).
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations_with_replacement, pairwise
from typing import Any, Protocol

import msgspec
import numpy as np
from numpy.typing import NDArray

from patterndb.core.patternclass import PatternClass
from query.boundary import Boundary
from query.cancellation import CancelFlag
from query.fill import Fill
from query.listing.orders import FillOrder
from query.listing.table import Frequencies, RelaxedTable, Table, TableEntries
from query.request import FillRequest
from query.solving.problem import OFF
from query.solving.widths import WidthSolver

#: Where at most so many fills of a pattern are listed, orders that measure fills look at so many
#: patterns at least, as far as there are.
PATTERNS_IN_POOL = 20


@dataclass(frozen=True, slots=True, eq=False)
class PreparedQuery:
    """A request for one boundary, with what a database answers it from.

    request:  its order is that of ``order``; max_boundary_irregular is 0 where it is strict.
    patterns: the class of the boundary's number of sides.
    frequencies: gives the patches in which patterns of these ids, of any class, were seen; None
              where only the class is known.
    ids:      (k,) int64, ascending: learned patterns that may be taken, by their meshes and
              licences; None for all.
    only:     the patterns that may be taken, also of constructed fills; None for all.
    known:    a fill that is not to be listed again.
    """

    request: FillRequest
    boundary: Boundary
    order: FillOrder
    patterns: PatternClass
    frequencies: Frequencies | None = None
    ids: NDArray[np.int64] | None = None
    only: frozenset[int] | None = None
    known: Fill | None = None

    def change(self, **options: Any) -> PreparedQuery:
        """Return the query with other options of its request."""
        return replace(self, request=msgspec.structs.replace(self.request, **options))

    @property
    def of_few(self) -> bool:
        """Is it for some patterns by name, so that nobody else will ask the same?"""
        return self.ids is not None or self.only is not None

    @property
    def most_looked_at(self) -> int | None:
        """The most fills of one pattern that are made: more than are listed, where an order has to
        measure them to tell which of them come first."""
        most = self.request.per_pattern
        if most is None or self.order.measure is None:
            return most
        return max(most, self.request.pool // PATTERNS_IN_POOL)

    def admit_rows(self, table: Table) -> NDArray[np.bool_]:
        """(r,) bool: which patterns of a table may be taken."""
        passes = self.request.admit_patterns(table)
        if self.ids is not None:
            passes &= np.isin(table.ids, self.ids)
        if self.only is not None:
            passes &= np.isin(table.ids, list(self.only))
        return passes


#: Listings that a table keeps: a query needs two, and boundaries differ in their corners.
LISTINGS_KEPT = 16

#: Tables are shared by threads that ask at the same time.
_KEEPING = threading.Lock()

#: The origin of patterns that no mesh has shown.
FAMILY = "family"

#: A place in an order: smaller comes first. Ties end at the pattern's id and the fit's place
#: among its row's, so that the same query gives the same list on any number of threads.
Rank = tuple[float, ...]

#: By how much an edge off a stroke's end makes a fill less likely.
OFF_BY_ONE = 20.0


@dataclass(frozen=True, slots=True)
class Ranking:
    """How fits are ranked before they are expanded.

    artist: does what artists did most come first? Else what is most regular does.
    worth:  where equally many vertices are irregular, does what a fill is worth decide, as in the
            order "artist", instead of how often its pattern was seen?
    used:   do recorded uses of a pattern count as much as patches of meshes?
    """

    artist: bool
    used: bool
    worth: bool = False

    def list_entries(self, table: Table, entries: TableEntries) -> Listing:
        """The entries in the order in which their fits may come."""
        seen = table.frequency[entries.row]
        meshes = table.n_meshes[entries.row].astype(np.float64)
        if self.used:
            uses = table.uses[entries.row]
            seen = seen + uses
            # What was only ever used counts as seen in one mesh.
            meshes = np.maximum(meshes, uses > 0)
        worth = meshes * seen.astype(np.float64) * table.n_symmetries[entries.row]
        worth[entries.n_irregular_boundary > 0] = 0.0
        ids = table.ids[entries.row]
        # Entries of one pattern stand in the order of their rows.
        common = worth if self.worth else seen
        keys = (entries.row, ids, -common, entries.n_irregular_boundary, entries.n_irregular)
        order = np.lexsort((*keys, -worth) if self.artist else keys)
        return Listing(self, entries.take(order), worth[order], seen[order], table.ids)

    def rank_constructed(self, irregular: int, boundary: int, off: int, place: int) -> Rank:
        """The rank of a fill that no table holds."""
        regular = (irregular, boundary, 0, 0, 0, off, place)
        return (0.0, *regular) if self.artist else regular


@dataclass(frozen=True, slots=True, eq=False)
class Listing:
    """Entries in order, with what ranks their fits.

    worth: (e,) float64 frequency times meshes times symmetries, 0 where corners are not where
           they should be, or a pattern was never seen. seen: (e,) int64.
    ids:   (r,) int64 of the table's rows.
    """

    ranking: Ranking
    entries: TableEntries
    worth: NDArray[np.float64]
    seen: NDArray[np.int64]
    ids: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.entries)

    def take(self, chosen: NDArray[np.bool_]) -> Listing:
        """Those chosen, in the same order."""
        return Listing(
            self.ranking,
            self.entries.take(chosen),
            self.worth[chosen],
            self.seen[chosen],
            self.ids,
        )

    def rank(self, at: int, off: int, place: int) -> Rank:
        """The rank of an entry's fit: ``off`` edges off the strokes, number ``place`` of its
        row's, from 0; with place -1 a rank before all of them."""
        entries = self.entries
        regular = (
            int(entries.n_irregular[at]),
            int(entries.n_irregular_boundary[at]),
            -float(self.worth[at] if self.ranking.worth else self.seen[at]),
            int(self.ids[entries.row[at]]),
            int(entries.row[at]),
            off,
            place,
        )
        if not self.ranking.artist:
            return regular
        worth = float(self.worth[at])
        return (-worth / ((max(place, 0) + 1) * OFF_BY_ONE**off), *regular)


def list_rows(query: PreparedQuery, table: Table, ranking: Ranking) -> Listing:
    """The rows of a table that may be taken, in the order in which their fits may come.

    Kept with the table: queries often ask much the same way.
    """
    q = query
    loops = any(stroke.is_loop for stroke in q.request.strokes)
    rules = tuple(
        (name, value)
        for name, rule, value in q.request.filters
        if rule.pattern is not None or rule.fit is not None
    )
    asked_before = (q.boundary.corners, rules, loops, q.request.wants(FAMILY), ranking)
    known = None if q.of_few else table.listings.get(asked_before)
    if known is not None:
        return known
    passing = q.admit_rows(table)
    if isinstance(table, RelaxedTable) and not q.request.wants(FAMILY):
        passing &= table.frequency > 0
    if loops:
        passing &= table.n_loops > 0
    entries = table.entries(q.boundary, passing)
    kept = q.request.admit_fits(entries)
    listing = ranking.list_entries(table, entries if kept.all() else entries.take(kept))
    if not q.of_few:
        with _KEEPING:
            while len(table.listings) >= LISTINGS_KEPT:
                table.listings.pop(next(iter(table.listings)))
            table.listings[asked_before] = listing
    return listing


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
