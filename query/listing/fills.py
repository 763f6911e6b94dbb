"""The list of fills that a caller holds: an iterator with limits, cancellation and reasons."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from time import perf_counter

from patterndb.errors import TimeLimitError
from patterndb.system.deadline import begin_task, end_by
from query.cancellation import CancelFlag, RunLimits, wait_unless_cancelled
from query.errors import QueryCancelledError
from query.fill import Fill
from query.listing.explanation import explain_empty
from query.listing.matches import PreparedQuery
from query.listing.merging import HURRY_SECONDS, RankedSearch
from query.listing.orders import ORDERS, Measure

#: Variants of a fill that are counted unless told otherwise.
MOST_COUNTED = 25

#: Quads from which on measuring a fill may take tenths of a second.
LARGE_QUADS = 5_000


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

    def __init__(self, query: PreparedQuery, cancelled: CancelFlag | None = None) -> None:
        """cancelled: the flag of another list that cancels this one, too."""
        self.boundary = query.boundary
        self.cut_short = False
        self.seconds = 0.0
        self._query = query
        self._limits = RunLimits(query.request.time_limit, cancelled)
        self._search = RankedSearch(query, self._limits)
        self._listed = 0
        self._left_out = False
        self._source = self._ordered()

    def __iter__(self) -> Fills:
        return self

    def __next__(self) -> Fill:
        begin = perf_counter()
        self._limits.begin()
        try:
            # Statements of the database end a little later: the last, hurried fill may ask it.
            with end_by(self._limits.deadline + HURRY_SECONDS):
                fill = next(self._source)
        except TimeLimitError:
            self._limits.time_out()
            self.cut_short = True
            raise StopIteration from None
        finally:
            self.seconds += perf_counter() - begin
        self._listed += 1
        return fill

    @property
    def truncated(self) -> bool:
        return self.cut_short or self._left_out or self._search.left_out

    @property
    def stopped(self) -> str | None:
        return self._limits.stopped

    @property
    def complete(self) -> bool:
        return self.stopped is None

    def cancel(self, why: str = "cancelled") -> None:
        """End the list as soon as possible, from any thread; why: what ``stopped`` will be."""
        self._limits.cancel(why)

    @property
    def feasible_patterns(self) -> int | None:
        """How many patterns of the database pass the filters and fit the boundary strictly; None
        where the time limit or :meth:`cancel` ended the list or the count."""
        limits = self._limits
        with limits.hold():
            if limits.flag[0]:
                return None
            try:
                count = self._search.count_feasible()
            except (QueryCancelledError, TimeLimitError):
                return None
            return None if limits.flag[0] else count

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
        with self._limits.hold():
            return explain_empty(self._query, self._find_other)

    def _find_other(self, query: PreparedQuery) -> tuple[Fill | None, bool]:
        """Find the most regular fill of another query, in what is left of the time.

        Returns the fill, and whether it is known that there is none. The flag is that of this list,
        so that the limit and :meth:`cancel` end it as well.
        """
        flag = self._limits.flag
        if flag[0]:
            return None, False
        changed = query.change(limit=1, time_limit=None)
        some = Fills(replace(changed, order=ORDERS["regular"]), flag)
        found = next(some, None)
        return found, found is None and not flag[0] and some.complete

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
        flag = self._limits.flag
        counted = Fills(replace(changed, only=only, order=ORDERS["regular"]), flag)
        with self._limits.hold():
            of_pattern = Counter(fill.pattern.id for fill in counted)
        counts = [max(of_pattern[fill.pattern.id] - 1, 0) for fill in fills]
        if counted.complete and not flag[0]:
            return list(counts)
        return [count if count == most else None for count in counts]

    def _ordered(self) -> Iterator[Fill]:
        q = self._query
        try:
            measure, limit, search = q.order.measure, q.request.limit, self._search
            source = search.list_fills(limit) if measure is None else self._measured(measure)
            for count, fill in enumerate(source):
                if count == limit:
                    self.cut_short = True
                    return
                yield fill
            self.cut_short = self.cut_short or self.stopped is not None
        finally:
            self._limits.end()

    def _measured(self, measure: Measure) -> Iterator[Fill]:
        """The fills of the pool, by what is measured on them; of every pattern the best."""
        q = self._query
        pool: list[_Measured] = []
        for place, fill in enumerate(self._search.list_fills(q.request.pool)):
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
        return task.result() if wait_unless_cancelled(task, self._limits.flag) else None


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
