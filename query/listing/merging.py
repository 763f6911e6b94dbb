"""Merging: the fills of one boundary out of all streams of matches, by rank.

Each stream, of a table's matches or of constructed fills, reports the best rank that may still come
from it. A fill is listed once no stream can do better.
"""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from itertools import islice

import numpy as np

from patterndb.errors import TimeLimitError
from query.cancellation import CancelFlag, RunLimits
from query.errors import QueryCancelledError
from query.fill import Fill
from query.listing.construction import list_constructed
from query.listing.matches import (
    FAMILY,
    FIRST_KEPT,
    Batch,
    Candidate,
    Continuation,
    Found,
    MatchSearch,
    PreparedQuery,
    Rank,
    Ranking,
    list_matches,
    list_rows,
)
from query.listing.table import (
    Table,
    find_least_irregular,
    get_begun_table,
    get_relaxed_table,
    get_strict_table,
)
from query.recognition import hash_fill, is_mesh, reread_fill
from query.request import admits
from query.solving.problem import WidthProblem, build_width_problem
from query.solving.widths import WidthSolver

#: The least valence of vertices that a pole may stand for.
FIVE = 5

#: Seconds after a time limit in which a list that is still empty may find its one fill.
HURRY_SECONDS = 0.1

#: Origins that are asked for by name.
LEARNED = "learned"
CONSTRUCTED = "constructed"


class RankedSearch:
    """The search for the fills of one query, in the orders "artist" and "regular".

    found:    has it found a fill?
    left_out: were fills left out for there being enough of their pattern?
    """

    def __init__(self, query: PreparedQuery, limits: RunLimits) -> None:
        self.found = False
        self.left_out = False
        self._query = query
        self._limits = limits
        self._problems: dict[int, WidthProblem] = {}

    def count_feasible(self) -> int:
        """Count the patterns of the database that pass the filters and fit strictly."""
        q = self._query
        table = get_strict_table(q.patterns)
        entries = list_rows(q, table, Ranking(False, False)).entries
        solver = self._solver(q.request.tolerance)
        return int(solver.is_feasible(table, entries.row, entries.packed).sum())

    def list_fills(self, wanted: int | None) -> Iterator[Fill]:
        """The fills in an order that needs no geometry; about ``wanted`` will be taken."""
        limits = self._limits
        try:
            yield from self._passes(wanted)
        except TimeLimitError:
            # A statement of the database ran out of time.
            limits.time_out()
        if limits.stopped != "time limit" or self.found:
            return
        # Time is up and nothing is found: a grid takes no search, and for a moment something else
        # that comes easily is looked for.
        flag, limits.flag = limits.flag, np.zeros(1, np.uint8)
        end = limits.set_alarm(limits.deadline + HURRY_SECONDS)
        try:
            with suppress(TimeLimitError):
                yield from islice(self._passes(1), 1)
            if not self.found:
                limits.flag = np.zeros(1, np.uint8)
                yield from self._in_a_hurry()
        finally:
            end.call_off()
            limits.flag = flag

    def _passes(self, wanted: int | None) -> Iterator[Fill]:
        """The fills of one search after another, none twice."""
        q = self._query
        artist = q.order.name != "regular"
        listed = _FillDeduplicator(q)
        if q.known is not None:
            listed.list_first(q.known)
        if any(not stroke.is_loop for stroke in q.request.strokes) and q.request.tolerance:
            # What was drawn is nearly always meant exactly: what misses it comes last. A search
            # for exact strands has few rows to look through, and ends before it is searched on.
            yield from self._merged(self._search(wanted, artist, tolerance=0), listed)
            yield from self._merged(self._search(wanted, artist, least_off=1), listed)
            return
        if artist and not q.request.strokes and q.known is None:
            first = self._find_first()
            if first is not None:
                listed.list_first(first)
                listed.count_first()
                yield first
        yield from self._merged(self._search(wanted, artist), listed)

    def _find_first(self) -> Fill | None:
        """Find what stands before what artists did most: the most regular fill is always worth a
        look. None where there is none, or artists make fives of the one pole that it has.

        One vertex does the work of two of valence 5, or of more: few irregular vertices, but on
        patches of meshes that a database had not learned the artist's fill was that with the fives
        wherever its pattern was worth more, and that with the pole else (benchmarks/recovery.py).
        """
        q = self._query
        first = next(self._merged(self._search(1, False, worth=True), _FillDeduplicator(q)), None)
        if (
            first is None
            or first.n_irregular != 1
            or max(first.pattern.valences, default=0) <= FIVE
        ):
            return first
        made = next(self._merged(self._search(1, True), _FillDeduplicator(q)), None)
        if made is not None and made.strict and set(made.pattern.valences) == {FIVE}:
            return None
        return first

    def _merged(self, search: MatchSearch, listed: _FillDeduplicator) -> Iterator[Fill]:
        """The fills of all streams that are new and asked for, by rank."""
        with suppress(QueryCancelledError):
            yield from self._merge_streams(search, listed)

    def _merge_streams(self, search: MatchSearch, listed: _FillDeduplicator) -> Iterator[Fill]:
        streams = list(map(_Peekable, self._list_streams(search)))
        waiting: list[tuple[Rank, int, Candidate | Continuation]] = []
        number = 0
        while True:
            streams = [one for one in streams if one.bound is not None]
            self._limits.look_at_clock()
            nearest = min(streams, key=lambda one: one.bound or (), default=None)
            while waiting and (nearest is None or waiting[0][0] <= (nearest.bound or ())):
                if self._limits.flag[0]:
                    break
                candidate = heapq.heappop(waiting)[2]
                if isinstance(candidate, Continuation):
                    if listed.is_done_with(candidate.pattern_id):
                        continue
                    for rank, found in candidate.find():
                        heapq.heappush(waiting, (rank, number, found))
                        number += 1
                    continue
                fill = listed.make_fill(candidate, self._limits.flag)
                self.left_out = self.left_out or listed.cut
                if fill is not None:
                    self.found = True
                    yield fill
            if self._limits.flag[0] or nearest is None:
                return
            for rank, candidate in nearest.advance():
                heapq.heappush(waiting, (rank, number, candidate))
                number += 1

    def _in_a_hurry(self) -> Iterator[Fill]:
        """A grid, which needs no search, where time is up before there was any fill."""
        q = self._query
        if not q.request.wants(CONSTRUCTED):
            return
        listed = _FillDeduplicator(q)
        search = self._search(1, q.order.name != "regular")
        for batch in list_constructed(search, q, 0, grid_only=True):
            for _, candidate in batch.found:
                if (
                    not isinstance(candidate, Continuation)
                    and (fill := listed.make_fill(candidate, self._limits.flag)) is not None
                ):
                    self.found = True
                    yield fill
                    return

    def _list_streams(self, search: MatchSearch) -> Iterator[Iterator[Batch]]:
        """The streams of matches: of tables, and of constructions."""
        q = self._query
        table: Table = get_strict_table(q.patterns)
        if q.boundary.n_sides == 0 and search.strokes:
            table = get_begun_table(q.patterns)
        yield list_matches(table, list_rows(q, table, search.ranking), search, 0)
        least = None
        if "full" in q.boundary.corners:
            return  # neither the family nor what is constructed has such corners
        if q.request.wants(FAMILY) or q.request.wants(LEARNED):
            # Making the table takes a third of a second where the database was just opened.
            if self._limits.flag[0]:
                return
            table = get_relaxed_table(q.patterns, q.frequencies, self._limits.flag)
            most = q.request.max_boundary_irregular
            least = find_least_irregular(q.boundary, most, self._limits.flag)
            if least is not None:
                yield list_matches(table, list_rows(q, table, search.ranking), search, least)
        if q.request.wants(CONSTRUCTED):
            yield list_constructed(search, q, least or 0)

    def _solver(self, tolerance: int) -> WidthSolver:
        """The solver of the widths; tolerance: edges that a strand's end may be off."""
        q, asked = self._query, self._query.request
        if tolerance not in self._problems:
            problem = build_width_problem(q.boundary, asked.strokes, tolerance)
            self._problems[tolerance] = problem
        return WidthSolver(
            self._problems[tolerance],
            cancelled=self._limits.flag,
            threads=asked.threads,
            by_cpsat=asked.solver == "cp-sat",
        )

    def _search(
        self,
        wanted: int | None,
        artist: bool,
        *,
        worth: bool = False,
        tolerance: int | None = None,
        least_off: int = 0,
    ) -> MatchSearch:
        """worth: see :class:`Ranking`. tolerance: None for the query's."""
        q = self._query
        most = min((n for n in (wanted, q.most_looked_at) if n is not None), default=None)
        return MatchSearch(
            solver=self._solver(q.request.tolerance if tolerance is None else tolerance),
            ranking=Ranking(artist, q.request.use_counts, worth),
            # One more than is asked for tells whether there are more.
            keep=FIRST_KEPT if most is None else min(most + 1, FIRST_KEPT),
            n_loops=sum(s.is_loop for s in q.request.strokes),
            least_off=least_off,
        )


class _Peekable:
    """A stream of matches and the bound on what may still come; None at its end."""

    def __init__(self, batches: Iterator[Batch]) -> None:
        self._batches = batches
        self.bound: Rank | None = None
        first = next(batches, None)
        if first is not None:
            assert not first.found, "a stream begins with a bound"
            self.bound = first.bound

    def advance(self) -> list[Found]:
        """What the stream finds next."""
        batch = next(self._batches, Batch([], None))
        self.bound = batch.bound
        return batch.found


class _FillDeduplicator:
    """Makes fills of matches, and keeps those that are new and asked for."""

    def __init__(self, query: PreparedQuery) -> None:
        self._query = query
        self._filters = query.request.filters
        self._closed = query.boundary.n_sides == 0
        self._of_pattern: Counter[int] = Counter()
        # Candidates, which are small: their fills are made again where they are compared.
        self._kept: list[Candidate] = []
        self._first: Fill | None = None
        self._first_key = b""
        self._keys: set[bytes] = set()
        self.cut = False

    def list_first(self, fill: Fill) -> None:
        """Remember a fill that is listed already, for the search will come by it."""
        self._first = fill
        self._first_key = b""

    def _hash_first(self) -> bytes:
        """The hash of that fill, made when it is first compared: often only one is taken."""
        assert self._first is not None
        self._first_key = self._first_key or hash_fill(self._first, self._closed)
        return self._first_key

    def count_first(self) -> None:
        """Count that fill as one of its pattern's."""
        assert self._first is not None
        self._of_pattern[self._first.pattern.id] += 1

    def is_done_with(self, pattern_id: int) -> bool:
        """Is no fill of this pattern wanted any more, not even to report that there are more?"""
        return self.cut and self._is_full(pattern_id)

    def make_fill(self, candidate: Candidate, cancelled: CancelFlag) -> Fill | None:
        """Make the fill; None where it is not to be listed, or the search is cancelled."""
        q = self._query
        if self.is_done_with(candidate.pattern_id):
            return None
        fill = candidate.fill()
        # With half a million quads each of what follows takes a tenth of a second.
        if cancelled[0]:
            return None
        first = self._first
        maybe_first = candidate.may_repeat or (
            first is not None and candidate.pattern_id == first.pattern.id
        )
        if (
            first is not None
            and maybe_first
            and hash_fill(fill, self._closed) == self._hash_first()
        ):
            return None
        if not admits(self._filters, fill):
            return None
        if candidate.may_repeat and not is_mesh(fill.quads):
            return None
        if cancelled[0] or (candidate.may_repeat and self._is_known(fill, cancelled)):
            return None
        if self._is_full(candidate.pattern_id):
            self.cut = True
            return None
        self._of_pattern[candidate.pattern_id] += 1
        self._kept.append(candidate)
        pattern = fill.pattern
        plain = pattern.chiral and pattern.rotations == 1 and not pattern.self_crossing
        # Constructed fills are read from their quads already.
        if candidate.may_repeat and fill.origin != CONSTRUCTED and (fill.strict or not plain):
            return reread_fill(fill, q.boundary)
        return fill

    def _is_full(self, pattern_id: int) -> bool:
        most = self._query.most_looked_at
        return most is not None and self._of_pattern[pattern_id] >= most

    def _is_known(self, fill: Fill, cancelled: CancelFlag) -> bool:
        """Was the fill listed before? Also True where the search is cancelled meanwhile."""
        while self._kept:
            if cancelled[0]:
                return True
            self._keys.add(hash_fill(self._kept.pop().fill(), self._closed))
        return bool(self._keys) and hash_fill(fill, self._closed) in self._keys
