"""A stream of fills: what the lanes find, merged, looked through and made."""

from __future__ import annotations

import heapq
import math
import threading
import weakref
from collections import Counter
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations, islice
from time import perf_counter

import numpy as np

from patterndb.errors import TimeLimitError
from patterndb.system.deadline import Alarm, begin_task, end_by, get_deadline
from patterndb.system.requests import list_options
from query.cancellation import CancelFlag, raise_if_cancelled, wait_unless_cancelled
from query.errors import QueryCancelledError
from query.fill import Fill
from query.identity import hash_fill, is_mesh
from query.listing.construction import list_constructed
from query.listing.filters import explain_empty
from query.listing.lane import (
    FIRST_KEPT,
    Candidate,
    Found,
    More,
    Search,
    Step,
    search_table,
)
from query.listing.orders import ORDERS, Measure
from query.listing.prepared import PreparedQuery
from query.listing.ranking import Listing, Rank, Ranking
from query.listing.table import (
    RelaxedTable,
    Table,
    TableEntries,
    get_begun_table,
    get_relaxed_table,
    get_strict_table,
)
from query.recognise import reread_fill
from query.request import FillRequest, admits
from query.solving.problem import WidthProblem, build_width_problem
from query.solving.widths import WidthSolver

#: Variants of a fill that are counted unless told otherwise.
MOST_COUNTED = 25

#: The least valence of vertices that a pole may stand for.
FIVE = 5

#: Seconds after a time limit in which a list that is still empty may find its one fill.
HURRY_SECONDS = 0.1

#: Quads from which on measuring a fill may take tenths of a second.
LARGE_QUADS = 5_000

#: Groups of as many strokes that are tried where no fill has all.
MOST_GROUPS = 10

#: Listings that a table keeps: a query needs two, and boundaries differ in their corners.
LISTINGS_KEPT = 16

#: Tables are shared by threads that ask at the same time.
_KEEPING = threading.Lock()

#: Origins that are asked for by name.
LEARNED = "learned"
FAMILY = "family"
CONSTRUCTED = "constructed"


class Fills(Iterator[Fill]):
    """An iterator over the fills of a boundary, best first; see :func:`query.engine.fills`.

    boundary:  the boundary they fill.
    truncated: are there more fills than were listed, by whichever limit? Known once the
               iterator has ended.
    cut_short: the same, but for fills that per_pattern alone left out: are there more patterns?
    seconds:   spent in finding what was listed so far.
    stopped:   "cancelled" or "time limit" where one of these ended the list, else None.
    complete:  was everything searched that was asked for? If not, that nothing was found does not
               mean that there is nothing.

    The time limit holds for all that is asked of the list, and so does the earlier deadline of the
    thread that begins it (:mod:`patterndb.system.deadline`). Another thread may call :meth:`cancel`
    at any time.
    """

    def __init__(self, query: PreparedQuery) -> None:
        self.boundary = query.boundary
        self.cut_short = False
        self.seconds = 0.0
        self.stopped: str | None = None
        self._query = query
        self._cancelled = np.zeros(1, np.uint8)
        self._listed = 0
        self._found = False
        self._left_out = False
        self._deadline = math.inf
        self._alarm: Alarm | None = None
        self._begun = False
        self._problems: dict[int, WidthProblem] = {}
        self._source = self._ordered()

    def __iter__(self) -> Fills:
        return self

    def __next__(self) -> Fill:
        begin = perf_counter()
        self._begin_clock()
        try:
            # Statements of the database end a little later: the last, hurried fill may ask it.
            with end_by(self._deadline + HURRY_SECONDS):
                fill = next(self._source)
        except TimeLimitError:
            self._time_out(self._cancelled)
            self.cut_short = True
            raise StopIteration from None
        finally:
            self.seconds += perf_counter() - begin
        self._listed += 1
        return fill

    @property
    def truncated(self) -> bool:
        return self.cut_short or self._left_out

    @property
    def complete(self) -> bool:
        return self.stopped is None

    def cancel(self, why: str = "cancelled") -> None:
        """End the list as soon as may be, from whichever thread; why: what ``stopped`` will be."""
        self.stopped = why
        self._cancelled[0] = 1
        if self._alarm is not None:
            self._alarm.call_off()

    @property
    def feasible_patterns(self) -> int | None:
        """How many patterns of the database pass the filters and fit the boundary strictly; None
        where the time limit or :meth:`cancel` ended the list or the count."""
        with self._timed():
            if self._cancelled[0]:
                return None
            try:
                count = self._count_feasible()
            except (QueryCancelledError, TimeLimitError):
                return None
            return None if self._cancelled[0] else count

    def _count_feasible(self) -> int:
        q = self._query
        table = get_strict_table(q.patterns)
        entries = self._entries(table)
        solver = self._solver(q.request.tolerance)
        return int(solver.is_feasible(table, entries.row, entries.packed).sum())

    def _solver(self, tolerance: int) -> WidthSolver:
        """The solver of the widths; tolerance: edges that a strand's end may be off."""
        q, asked = self._query, self._query.request
        if tolerance not in self._problems:
            problem = build_width_problem(q.boundary, asked.strokes, tolerance)
            self._problems[tolerance] = problem
        return WidthSolver(
            self._problems[tolerance],
            cancelled=self._cancelled,
            threads=asked.threads,
            by_cpsat=asked.solver == "cp-sat",
        )

    @property
    def reason(self) -> str | None:
        """Why nothing was listed, in a sentence; None where something was.

        Where there are several strokes, it searches for fills of some of them.
        """
        if self._listed:
            return None
        if self.stopped is not None:
            return (
                f"the query was ended before the first fill was found ({self.stopped}), so that "
                "there may be one"
            )
        q = self._query
        with self._timed():
            candidates = len(self._entries(get_strict_table(q.patterns)))
            return explain_empty(
                q.patterns,
                q.boundary,
                q.request,
                candidates,
                strict=q.request.strict or q.request.max_boundary_irregular == 0,
                strokes=len(q.request.strokes),
                together=self._find_compatible_strokes() if len(q.request.strokes) > 1 else [],
                relaxed=[] if q.request.strokes else self._list_relaxed(),
            )

    def _find_compatible_strokes(self) -> list[tuple[int, ...]] | None:
        """Find large groups of strokes, by their numbers from 0, that a fill has; all as large.

        Empty where no stroke alone has a fill; None where that is not known when time is up.
        """
        n = len(self._query.request.strokes)
        alone = [self._has_fill_with((number,)) for number in range(n)]
        usable = [number for number, has in enumerate(alone) if has]
        # A fill of several strokes is one of each of them.
        for size in range(min(len(usable), n - 1), 1, -1):
            groups = islice(combinations(usable, size), MOST_GROUPS)
            found = [group for group in groups if self._has_fill_with(group)]
            if found:
                return found
            if self._cancelled[0]:
                break
        if not usable and None in alone:
            return None
        return [(number,) for number in usable]

    def _list_relaxed(self) -> list[str]:
        """List what can be had without one of the filters, for each that alone leaves it out."""
        q = self._query
        found: list[str] = []
        for name, rule, value in q.request.filters:
            free = list_options(FillRequest)[name].default
            if not rule.without or value == free:
                continue
            first = self._find_without(q.change(**{name: free}))
            if first is not None:
                found.append(rule.without.format(fill=first, value=value))
        if q.ids is not None and self._find_without(replace(q, ids=None)) is not None:
            found.append("there are fills without the choice of meshes and licences")
        return found

    def _find_without(self, query: PreparedQuery) -> Fill | None:
        """Find the most regular fill of a less strict query, in what is left of the time.

        Its flag is that of this list, so that the limit and :meth:`cancel` end it as well.
        """
        if self._cancelled[0]:
            return None
        changed = query.change(limit=1, time_limit=None)
        some = Fills(replace(changed, order=ORDERS["regular"]))
        some._cancelled = self._cancelled
        return next(some, None)

    def _has_fill_with(self, group: tuple[int, ...]) -> bool | None:
        """Is a fill found that has these of the strokes? None where time is up before that.

        Its flag is that of this list, so that the limit and :meth:`cancel` end it as well.
        """
        if self._cancelled[0]:
            return None
        q = self._query
        strokes = tuple(q.request.strokes[i] for i in group)
        changed = q.change(strokes=strokes, limit=1, time_limit=None)
        some = Fills(replace(changed, order=ORDERS["regular"]))
        some._cancelled = self._cancelled
        if next(some, None) is not None:
            return True
        return None if self._cancelled[0] or not some.complete else False

    def _begin_clock(self) -> None:
        """Set the deadline and its alarm, at the first that is asked of this list."""
        if self._begun:
            return
        self._begun = True
        limit = self._query.request.time_limit
        mine = math.inf if limit is None else perf_counter() + limit
        self._deadline = min(mine, get_deadline())
        if self._deadline < math.inf:
            # Another thread sets the flag, the only thing that the compiled core looks at.
            self._alarm = self._set_alarm(self._deadline)

    @contextmanager
    def _timed(self) -> Generator[None]:
        """Have what follows the list end when the list would have."""
        self._begin_clock()
        flag = self._cancelled

        def ring() -> None:
            flag[0] = 1

        alarm = Alarm(self._deadline, ring) if self._deadline < math.inf else None
        try:
            if perf_counter() >= self._deadline:
                ring()
            with end_by(self._deadline):
                yield
        finally:
            if alarm is not None:
                alarm.call_off()

    def variants(self, fill: Fill, limit: int | None = None) -> Fills:
        """Find the other fills of a fill's pattern, in the order of this list.

        fill: one of this list. They are what a list with per_pattern=1 leaves out: they pass all
        that was asked for here but per_pattern, and ``limit`` takes the place of this list's.
        """
        changed = self._query.change(limit=limit, per_pattern=None)
        return Fills(replace(changed, only=frozenset((fill.pattern.id,)), known=fill))

    def count_variants(self, fills: Sequence[Fill], most: int = MOST_COUNTED) -> list[int | None]:
        """Count the other fills of each fill's pattern, up to ``most``: families of long sides
        run into millions. None where time was up before a pattern's fills were counted.

        fills: some of this list, of different patterns.
        """
        only = frozenset(fill.pattern.id for fill in fills)
        changed = self._query.change(time_limit=None, limit=None, per_pattern=most + 1)
        # No order needs to measure what is only counted.
        counted = Fills(replace(changed, only=only, order=ORDERS["regular"]))
        counted._cancelled = self._cancelled
        with self._timed():
            of_pattern = Counter(fill.pattern.id for fill in counted)
        counts = [max(of_pattern[fill.pattern.id] - 1, 0) for fill in fills]
        if counted.complete and not self._cancelled[0]:
            return list(counts)
        return [count if count == most else None for count in counts]

    # How the list comes about.

    def _ordered(self) -> Iterator[Fill]:
        q = self._query
        try:
            measure = q.order.measure
            source = self._ranked(q.request.limit) if measure is None else self._measured(measure)
            for count, fill in enumerate(source):
                if count == q.request.limit:
                    self.cut_short = True
                    return
                yield fill
            self.cut_short = self.cut_short or self.stopped is not None
        finally:
            if self._alarm is not None:
                self._alarm.call_off()

    def _set_alarm(self, moment: float) -> Alarm:
        """Have the search that runs with the present flag ended at a moment."""
        # A list that nobody holds any more is not kept until its time is up.
        held, flag = weakref.ref(self), self._cancelled

        def ring() -> None:
            fills = held()
            if fills is not None:
                fills._time_out(flag)

        return Alarm(moment, ring)

    def _time_out(self, flag: CancelFlag) -> None:
        self.stopped = self.stopped or "time limit"
        flag[0] = 1

    def _measured(self, measure: Measure) -> Iterator[Fill]:
        """The fills of the pool, by what is measured on them; of every pattern the best."""
        q = self._query
        pool: list[_Measured] = []
        for place, fill in enumerate(self._ranked(q.request.pool)):
            if place == q.request.pool:
                self.cut_short = True
                break
            off = fill.flow_distance or 0.0
            # What comes, or is measured, after the limit is first by any measure if it is alone.
            measured = None if self.stopped == "time limit" else self._measure(measure, fill)
            if measured is None:
                if not pool and self.stopped == "time limit":
                    pool.append(_Measured(False, 0.0, place, fill))
                break
            value, fill = measured
            # What goes by the strokes' distances needs no count of edges beside them.
            pool.append(_Measured(not q.order.needs_strokes and off > 0, value, place, fill))
        pool.sort(key=lambda one: (one.near, one.value, one.place))
        if q.order.alike is not None:
            pool = _sort_alike(pool, q.order.alike(q.boundary, q.request.strokes))
        of_pattern: Counter[int] = Counter()
        most = q.request.per_pattern
        for one in pool:
            of_pattern[one.fill.pattern.id] += 1
            if most is not None and of_pattern[one.fill.pattern.id] > most:
                self._left_out = True
                continue
            yield one.fill

    def _measure(self, measure: Measure, fill: Fill) -> tuple[float, Fill] | None:
        """Measure a fill; None where the list is ended before that is done."""
        q, asked = self._query, self._query.request
        if fill.n_quads < LARGE_QUADS:
            return measure(fill, q.boundary, asked.strokes, asked.tolerance)
        # One that is placed takes a second, in which nothing looks at the flag.
        task = begin_task(partial(measure, fill, q.boundary, asked.strokes, asked.tolerance))
        return task.result() if wait_unless_cancelled(task, self._cancelled) else None

    def _ranked(self, wanted: int | None) -> Iterator[Fill]:
        """The fills in an order that needs no geometry; about ``wanted`` will be taken."""
        try:
            yield from self._passes(wanted)
        except TimeLimitError:
            # A statement of the database was ended.
            self._time_out(self._cancelled)
        if self.stopped != "time limit" or self._found:
            return
        # Time is up and nothing is found: a grid takes no search, and for a moment something else
        # that comes easily is looked for.
        flag, self._cancelled = self._cancelled, np.zeros(1, np.uint8)
        end = self._set_alarm(self._deadline + HURRY_SECONDS)
        try:
            with suppress(TimeLimitError):
                yield from islice(self._passes(1), 1)
            if not self._found:
                self._cancelled = np.zeros(1, np.uint8)
                yield from self._in_a_hurry()
        finally:
            end.call_off()
            self._cancelled = flag

    def _passes(self, wanted: int | None) -> Iterator[Fill]:
        """The fills of one search after another, none twice."""
        q = self._query
        artist = q.order.name != "regular"
        sieve = _Sieve(q)
        if q.known is not None:
            sieve.list_first(q.known)
        if any(not stroke.is_loop for stroke in q.request.strokes) and q.request.tolerance:
            # What was drawn is nearly always meant exactly: what misses it comes last. A search
            # for exact strands has few rows to look through, and ends before it is searched on.
            yield from self._merged(self._search(wanted, artist, tolerance=0), sieve)
            yield from self._merged(self._search(wanted, artist, least_off=1), sieve)
            return
        if artist and not q.request.strokes and q.known is None:
            first = self._find_first()
            if first is not None:
                sieve.list_first(first)
                sieve.count_first()
                yield first
        yield from self._merged(self._search(wanted, artist), sieve)

    def _find_first(self) -> Fill | None:
        """Find what stands before what artists did most: the most regular fill is always worth a
        look. None where there is none, or artists make fives of the one pole that it has.

        One vertex does the work of two of valence 5, or of more: few irregular vertices, but on
        patches of meshes that a database had not learned the artist's fill was that with the fives
        wherever its pattern was worth more, and that with the pole else (benchmarks/recovery.py).
        """
        q = self._query
        first = next(self._merged(self._search(1, False, worth=True), _Sieve(q)), None)
        if (
            first is None
            or first.n_irregular != 1
            or max(first.pattern.valences, default=0) <= FIVE
        ):
            return first
        made = next(self._merged(self._search(1, True), _Sieve(q)), None)
        if made is not None and made.strict and set(made.pattern.valences) == {FIVE}:
            return None
        return first

    def _merged(self, search: Search, sieve: _Sieve) -> Iterator[Fill]:
        """The fills of all lanes that the sieve lets pass, by rank."""
        with suppress(QueryCancelledError):
            yield from self._merge_lanes(search, sieve)

    def _merge_lanes(self, search: Search, sieve: _Sieve) -> Iterator[Fill]:
        raise_if_cancelled(self._cancelled)
        lanes = [step for step in map(_Ahead, self._lanes(search)) if step.bound is not None]
        waiting: list[tuple[Rank, int, Candidate | More]] = []
        number = 0
        while True:
            lanes = [ahead for ahead in lanes if ahead.bound is not None]
            if self.stopped is None and perf_counter() >= self._deadline:
                self._time_out(self._cancelled)
            nearest = min(lanes, key=lambda ahead: ahead.bound or (), default=None)
            while waiting and (nearest is None or waiting[0][0] <= (nearest.bound or ())):
                if self._cancelled[0]:
                    break
                candidate = heapq.heappop(waiting)[2]
                if isinstance(candidate, More):
                    if sieve.is_done_with(candidate.pattern_id):
                        continue
                    for rank, found in candidate.find():
                        heapq.heappush(waiting, (rank, number, found))
                        number += 1
                    continue
                fill = sieve.make_fill(candidate, self._cancelled)
                self._left_out = self._left_out or sieve.cut
                if fill is not None:
                    self._found = True
                    yield fill
            if self._cancelled[0] or nearest is None:
                return
            for rank, candidate in nearest.advance():
                heapq.heappush(waiting, (rank, number, candidate))
                number += 1

    def _in_a_hurry(self) -> Iterator[Fill]:
        """A grid, which needs no search, where time is up before there was any fill."""
        q = self._query
        if not q.request.wants(CONSTRUCTED):
            return
        sieve = _Sieve(q)
        search = self._search(1, q.order.name != "regular")
        for step in list_constructed(search, q, 0, grid_only=True):
            for _, candidate in step.found:
                if (
                    not isinstance(candidate, More)
                    and (fill := sieve.make_fill(candidate, self._cancelled)) is not None
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
        if q.request.wants(FAMILY) or q.request.wants(LEARNED):
            # Making the table takes a third of a second where the database was just opened.
            raise_if_cancelled(self._cancelled)
            table = get_relaxed_table(q.patterns, q.frequencies)
            least = table.least(q.boundary, q.request.max_boundary_irregular)
            if least is not None:
                yield search_table(table, self._listing(table, search.ranking), search, least)
        if q.request.wants(CONSTRUCTED):
            yield list_constructed(search, q, least or 0)

    def _entries(self, table: Table) -> TableEntries:
        """The rows of a table that pass the filters."""
        return self._listing(table, Ranking(False, False)).entries

    def _listing(self, table: Table, ranking: Ranking) -> Listing:
        """The rows of a table that pass the filters, in order.

        Kept with the table: whoever asks often asks much the same way.
        """
        q = self._query
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

    def _search(
        self,
        wanted: int | None,
        artist: bool,
        *,
        worth: bool = False,
        tolerance: int | None = None,
        least_off: int = 0,
    ) -> Search:
        """worth: see :class:`Ranking`. tolerance: None for the query's."""
        q = self._query
        most = min((n for n in (wanted, q.most_looked_at) if n is not None), default=None)
        return Search(
            boundary=q.boundary,
            solver=self._solver(q.request.tolerance if tolerance is None else tolerance),
            ranking=Ranking(artist, q.request.use_counts, worth),
            # One more than is asked for tells whether there are more.
            keep=FIRST_KEPT if most is None else min(most + 1, FIRST_KEPT),
            n_loops=sum(s.is_loop for s in q.request.strokes),
            least_off=least_off,
        )


@dataclass(frozen=True, slots=True, eq=False)
class _Measured:
    """A fill of the pool.

    near: does a strand miss a stroke by an edge? value: what was measured, the smaller the
    better. place: in the order "artist", from 0.
    """

    near: bool
    value: float
    place: int
    fill: Fill


def _sort_alike(pool: Sequence[_Measured], alike: float) -> list[_Measured]:
    """Of fills that measure about the same, bring the more regular forward.

    pool: by what was measured. Those that measure at most ``alike`` more than the first change
    places among each other; then the same with what follows them.
    """
    result: list[_Measured] = []
    at = 0
    while at < len(pool):
        end = at
        while end < len(pool) and pool[end].value <= pool[at].value + alike:
            end += 1
        result += sorted(
            pool[at:end],
            key=lambda one: (one.fill.n_irregular, one.fill.n_irregular_boundary),
        )
        at = end
    return result


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

    def __init__(self, query: PreparedQuery) -> None:
        self._query = query
        self._filters = query.request.filters
        self._closed = query.boundary.n_sides == 0
        self._of_pattern: Counter[int] = Counter()
        # Candidates, which are small: their fills are made again where they are compared.
        self._passed: list[Candidate] = []
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
        """Is no fill of this pattern wanted any more, not even to tell that there are more?"""
        return self.cut and self._is_full(pattern_id)

    def make_fill(self, candidate: Candidate, ended: CancelFlag) -> Fill | None:
        """Make the fill; None where it is not to be listed, or the search is ended meanwhile."""
        q = self._query
        if self.is_done_with(candidate.pattern_id):
            return None
        fill = candidate.fill()
        # With half a million quads each of what follows takes a tenth of a second.
        if ended[0]:
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
        if ended[0] or (candidate.may_repeat and self._is_known(fill, ended)):
            return None
        if self._is_full(candidate.pattern_id):
            self.cut = True
            return None
        self._of_pattern[candidate.pattern_id] += 1
        self._passed.append(candidate)
        pattern = fill.pattern
        plain = pattern.chiral and pattern.rotations == 1 and not pattern.self_crossing
        # Constructed fills are read from their quads already.
        if candidate.may_repeat and fill.origin != CONSTRUCTED and (fill.strict or not plain):
            return reread_fill(fill, q.boundary)
        return fill

    def _is_full(self, pattern_id: int) -> bool:
        most = self._query.most_looked_at
        return most is not None and self._of_pattern[pattern_id] >= most

    def _is_known(self, fill: Fill, ended: CancelFlag) -> bool:
        """Was the fill listed before? Also True where the search is ended meanwhile."""
        while self._passed:
            if ended[0]:
                return True
            self._keys.add(hash_fill(self._passed.pop().fill(), self._closed))
        return bool(self._keys) and hash_fill(fill, self._closed) in self._keys
