"""A stream of fills: what the lanes find, merged, looked through and made."""

from __future__ import annotations

import heapq
import math
import threading
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from patterndb.core.patternclass import PatternClass
from patterndb.system.compiling import read_work_clock
from query.boundary import Boundary
from query.fill import Fill
from query.identity import hash_fill, is_mesh
from query.listing.construction import list_constructed
from query.listing.filters import Filters, explain_empty
from query.listing.lane import Candidate, Found, More, Search, Step, find_feasible, search_table
from query.listing.orders import FillOrder, Measure
from query.listing.ranking import Listing, Rank, Ranking
from query.listing.table import (
    Frequencies,
    RelaxedTable,
    Table,
    TableEntries,
    get_begun_table,
    get_relaxed_table,
    get_strict_table,
)
from query.solving.batch import pose_question
from query.stroke import Stroke

#: Listings that a table keeps: a query needs two, and boundaries differ in their corners.
LISTINGS_KEPT = 16

#: Origins that are asked for by name.
LEARNED = "learned"
FAMILY = "family"
CONSTRUCTED = "constructed"


@dataclass(frozen=True, slots=True, eq=False)
class Query:
    """The arguments of :func:`query.engine.fills`, checked.

    patterns: the class of the boundary's number of sides. frequencies: gives the patches in
    which patterns of these ids, of any class, were seen; None where only the class is known.
    """

    patterns: PatternClass
    frequencies: Frequencies | None
    boundary: Boundary
    strokes: tuple[Stroke, ...]
    tolerance: int
    limit: int | None
    per_pattern: int | None
    order: FillOrder
    filters: Filters
    strict: bool
    origins: frozenset[str] | None
    use_counts: bool
    time_limit: float | None
    pool: int
    by_cpsat: bool
    threads: int | None

    def wants(self, origin: str) -> bool:
        """May fills have this origin?"""
        return self.origins is None or origin in self.origins


class Fills(Iterator[Fill]):
    """An iterator over the fills of a boundary, best first; see :func:`query.engine.fills`.

    boundary:  the boundary they fill.
    truncated: are there more fills than were listed, by whichever limit? Known once the
               iterator has ended.
    seconds:   spent in finding what was listed so far.
    stopped:   "cancelled" or "time limit" where one of these ended the list, else None.

    Another thread may call :meth:`cancel` at any time.
    """

    def __init__(self, query: Query) -> None:
        self.boundary = query.boundary
        self.truncated = False
        self.seconds = 0.0
        self.stopped: str | None = None
        self._query = query
        self._cancelled = np.zeros(1, np.uint8)
        self._listed = 0
        self._found = False
        self._late = False
        self._deadline = math.inf
        self._source = self._ordered()

    def __iter__(self) -> Fills:
        return self

    def __next__(self) -> Fill:
        begin = read_work_clock()
        try:
            fill = next(self._source)
        finally:
            self.seconds += read_work_clock() - begin
        self._listed += 1
        return fill

    def cancel(self) -> None:
        """End the list as soon as may be, from whichever thread."""
        self.stopped = "cancelled"
        self._cancelled[0] = 1

    @property
    def feasible_patterns(self) -> int:
        """How many patterns of the database pass the filters and fit the boundary strictly."""
        table = get_strict_table(self._query.patterns)
        entries = self._entries(table)
        # Whatever ended the list, the count is of all.
        search = replace(self._search(1, False), cancelled=np.zeros(1, np.uint8))
        return int(find_feasible(table, entries, search, once=True).any(axis=1).sum())

    @property
    def reason(self) -> str | None:
        """Why nothing was listed, in a sentence; None where something was."""
        if self._listed:
            return None
        if self.stopped is not None:
            return f"the query was ended before the first fill was found ({self.stopped})"
        q = self._query
        candidates = len(self._entries(get_strict_table(q.patterns)))
        return explain_empty(
            q.patterns,
            q.boundary,
            q.filters,
            candidates,
            strict=q.filters.max_boundary_irregular == 0,
            strokes=bool(q.strokes),
        )

    # How the list comes about.

    def _ordered(self) -> Iterator[Fill]:
        q = self._query
        timer = None
        if q.time_limit is not None:
            self._deadline = read_work_clock() + q.time_limit
            # Another thread tells the kernels, which look at nothing but their flag.
            timer = threading.Timer(q.time_limit, self._time_out)
            timer.daemon = True
            timer.start()
        try:
            measure = q.order.measure
            source = self._ranked(q.limit) if measure is None else self._measured(measure)
            for count, fill in enumerate(source):
                if count == q.limit:
                    self.truncated = True
                    return
                yield fill
            self.truncated = self.truncated or self.stopped is not None
        finally:
            if timer is not None:
                timer.cancel()

    def _time_out(self) -> None:
        self.stopped = self.stopped or "time limit"
        self._cancelled[0] = 1

    def _measured(self, measure: Measure) -> Iterator[Fill]:
        """The fills of the pool, by what is measured on them."""
        q = self._query
        pool: list[tuple[float, int, Fill]] = []
        for place, fill in enumerate(self._ranked(q.pool)):
            if place == q.pool:
                self.truncated = True
                break
            value, fill = measure(fill, q.boundary, q.strokes, q.tolerance)
            pool.append((value, place, fill))
        for _, _, fill in sorted(pool, key=lambda entry: entry[:2]):
            yield fill

    def _ranked(self, wanted: int | None) -> Iterator[Fill]:
        """The fills in an order that needs no geometry; about ``wanted`` will be taken."""
        q = self._query
        regular = q.order.name == "regular"
        if regular or q.strokes:
            yield from self._merged(self._search(wanted, not regular))
            return
        # The most regular fill is always worth a look; after it come those that artists made.
        first = next(self._merged(self._search(1, False, True)), None)
        if first is None:
            return
        yield first
        yield from self._merged(self._search(wanted, True), first)

    def _merged(self, search: Search, first: Fill | None = None) -> Iterator[Fill]:
        """The fills of all lanes, by rank, but for one that is listed already."""
        lanes = [step for step in map(_Ahead, self._lanes(search)) if step.bound is not None]
        waiting: list[tuple[Rank, int, Candidate | More]] = []
        number = 0
        sieve = _Sieve(self._query, first)
        while True:
            lanes = [ahead for ahead in lanes if ahead.bound is not None]
            if read_work_clock() >= self._deadline and not self._late:
                self._time_out()
            nearest = min(lanes, key=lambda ahead: ahead.bound or (), default=None)
            while waiting and (nearest is None or waiting[0][0] <= (nearest.bound or ())):
                if self._cancelled[0]:
                    break
                candidate = heapq.heappop(waiting)[2]
                if isinstance(candidate, More):
                    for rank, found in candidate.find():
                        heapq.heappush(waiting, (rank, number, found))
                        number += 1
                    continue
                fill = sieve.make_fill(candidate)
                self.truncated = self.truncated or sieve.cut
                if fill is not None:
                    self._found = True
                    yield fill
            if self._cancelled[0]:
                if self.stopped == "time limit" and not self._found:
                    yield from self._in_a_hurry(search, sieve)
                    if not self._found:
                        # Time is up and nothing is found: search on for one fill.
                        self._cancelled[0] = 0
                        self._late = True
                        yield from islice(self._merged(search), 1)
                        self._cancelled[0] = 1
                return
            if nearest is None:
                return
            for rank, candidate in nearest.advance():
                heapq.heappush(waiting, (rank, number, candidate))
                number += 1

    def _in_a_hurry(self, search: Search, sieve: _Sieve) -> Iterator[Fill]:
        """One fill that needs no search, where time is up before there was any."""
        q = self._query
        if not q.wants(CONSTRUCTED):
            return
        for step in list_constructed(search, q.filters, q.strict, q.strokes, 0):
            for _, candidate in step.found:
                if (
                    not isinstance(candidate, More)
                    and (fill := sieve.make_fill(candidate)) is not None
                ):
                    self._found = True
                    yield fill
                    return

    def _lanes(self, search: Search) -> Iterator[Iterator[Step]]:
        q = self._query
        table: Table = get_strict_table(q.patterns)
        if q.boundary.n_sides == 0 and search.strokes:
            table = get_begun_table(q.patterns)
        yield search_table(table, self._listing(table, search.ranking), search, 0)
        least = None
        if "full" in q.boundary.corners:
            return  # neither the family nor what is constructed has such corners
        if q.wants(FAMILY) or q.wants(LEARNED):
            table = get_relaxed_table(q.patterns, q.frequencies)
            least = table.least(q.boundary, q.filters.max_boundary_irregular)
            if least is not None:
                yield search_table(table, self._listing(table, search.ranking), search, least)
        if q.wants(CONSTRUCTED):
            yield list_constructed(search, q.filters, q.strict, q.strokes, least or 0)

    def _entries(self, table: Table) -> TableEntries:
        """The rows of a table that pass the filters."""
        return self._listing(table, Ranking(False, False)).entries

    def _listing(self, table: Table, ranking: Ranking) -> Listing:
        """The rows of a table that pass the filters, in order.

        Kept with the table: whoever asks often asks much the same way.
        """
        q = self._query
        loops = any(stroke.is_loop for stroke in q.strokes)
        asked_before = (q.boundary.corners, q.filters, loops, q.wants(FAMILY), ranking)
        if q.filters.ids is None and asked_before in table.listings:
            return table.listings[asked_before]
        passing = q.filters.admitted(table, table.n_corners)
        if isinstance(table, RelaxedTable) and not q.wants(FAMILY):
            passing &= table.frequency > 0
        if loops:
            passing &= table.n_loops > 0
        entries = table.entries(q.boundary, passing)
        kept = np.ones(len(entries), np.bool_)
        if q.filters.max_irregular is not None:
            kept &= entries.irregular <= q.filters.max_irregular
        if q.filters.max_boundary_irregular is not None:
            kept &= entries.boundary <= q.filters.max_boundary_irregular
        listing = ranking.list_entries(table, entries if kept.all() else entries.take(kept))
        if q.filters.ids is None:
            while len(table.listings) >= LISTINGS_KEPT:
                table.listings.pop(next(iter(table.listings)))
            table.listings[asked_before] = listing
        return listing

    def _search(self, wanted: int | None, artist: bool, worth: bool = False) -> Search:
        q = self._query
        most = min((n for n in (wanted, q.per_pattern) if n is not None), default=None)
        return Search(
            boundary=q.boundary,
            question=pose_question(q.boundary, q.strokes, q.tolerance),
            ranking=Ranking(artist, q.use_counts, worth),
            # One more than is asked for tells whether there are more.
            keep=None if most is None else most + 1,
            n_loops=sum(s.is_loop for s in q.strokes),
            cancelled=self._cancelled,
            by_cpsat=q.by_cpsat,
            threads=q.threads,
        )


class _Ahead:
    """A lane and the bound on what it has not told yet; None at its end."""

    def __init__(self, steps: Iterator[Step]) -> None:
        self._steps = steps
        self.bound: Rank | None = None
        first = next(steps, None)
        if first is not None:
            assert not first.found, "a lane begins with a bound"
            self.bound = first.bound

    def advance(self) -> list[Found]:
        """What the lane finds next."""
        step = next(self._steps, Step([], None))
        self.bound = step.bound
        return step.found


class _Sieve:
    """Makes candidates fills, and lets pass what is new and was asked for."""

    def __init__(self, query: Query, first: Fill | None) -> None:
        self._query = query
        self._closed = query.boundary.n_sides == 0
        self._of_pattern: Counter[int] = Counter()
        self._passed: list[Fill] = []
        self._first = first
        self._first_key = b""
        if first is not None:
            self._of_pattern[first.pattern.id] += 1
            self._passed.append(first)
            self._first_key = hash_fill(first, self._closed)
        self._keys: set[bytes] = set()
        self.cut = False

    def make_fill(self, candidate: Candidate) -> Fill | None:
        """Make the fill; None where it is not to be listed."""
        q = self._query
        full = q.per_pattern is not None and self._of_pattern[candidate.pattern_id] >= q.per_pattern
        first = self._first
        maybe_first = first is not None and candidate.pattern_id == first.pattern.id
        if full and not maybe_first:
            self.cut = True
            return None
        fill = candidate.fill()
        if maybe_first and hash_fill(fill, self._closed) == self._first_key:
            return None
        if full:
            self.cut = True
            return None
        if not q.wants(fill.origin):
            return None
        if q.filters.max_quads is not None and fill.n_quads > q.filters.max_quads:
            return None
        if candidate.may_repeat and (not is_mesh(fill.quads) or self._is_known(fill)):
            return None
        self._of_pattern[candidate.pattern_id] += 1
        self._passed.append(fill)
        return fill

    def _is_known(self, fill: Fill) -> bool:
        for other in self._passed:
            self._keys.add(hash_fill(other, self._closed))
        self._passed.clear()
        return hash_fill(fill, self._closed) in self._keys
