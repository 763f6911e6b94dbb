"""The fills of a boundary while they stream in: paging through them, and placing one.

Fills come from :func:`query.fills`, their vertices from :func:`query.placing.place`. A query and
the placing of a fill each run in a thread; whoever shows them asks :meth:`FillFinder.poll` now and
then whether there is something new.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

from patterndb.core.patternclass import PatternClass
from patterndb.errors import NotFoundError
from patterndb.system.numbers import TOLERANCE
from query import Boundary, Fill, Fills, Stroke, fills
from query.engine import PatternSource
from query.listing.orders import ORDERS, default_order
from query.placing import Placement, Region, Surface, enclose_region, place
from query.request import NO_DOUBLETS


class OneAtATime:
    """A source of patterns that several threads may ask: a database serves one at a time."""

    def __init__(self, source: PatternSource) -> None:
        self._source = source
        self._lock = threading.Lock()

    def pattern_class(self, n_sides: int) -> PatternClass:
        """As the source's."""
        with self._lock:
            return self._source.pattern_class(n_sides)


class FillSearch:
    """A query that runs in a thread of its own.

    ask: makes the query; it is called in the thread, too, as patterns may have to be read.
    fills: those found so far, best first; it only grows. done: has it ended? failure: what it
    was ended by, if it failed. reason: why there is no fill, once it has ended without one.
    asked: the query itself, once it has begun.
    """

    def __init__(self, ask: Callable[[], Fills]) -> None:
        self.fills: list[Fill] = []
        self.done = False
        self.failure: Exception | None = None
        self.reason: str | None = None
        self.truncated = False
        self.cut_short = False
        self._ask = ask
        self.asked: Fills | None = None
        self._cancelled = False
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._run, name="fills", daemon=True)
        self._thread.start()

    def cancel(self) -> None:
        """End it soon; does not wait."""
        with self._changed:
            self._cancelled = True
            if self.asked is not None:
                self.asked.cancel()

    def wait(self, count: int | None = None, timeout: float | None = None) -> bool:
        """Until there are so many fills, or it has ended; False if time ran out before."""

        def reached() -> bool:
            return self.done or (count is not None and len(self.fills) >= count)

        with self._changed:
            return self._changed.wait_for(reached, timeout)

    def join(self) -> None:
        """Until the thread has ended: then nothing of the database is in use any more."""
        self._thread.join()

    def _run(self) -> None:
        try:
            self._stream()
        except Exception as error:
            # Raised here it would be lost; whoever waits for fills raises it.
            self.failure = error
        finally:
            with self._changed:
                self.done = True
                self._changed.notify_all()

    def _stream(self) -> None:
        if self._cancelled:
            return
        asked = self._ask()
        with self._changed:
            self.asked = asked
            if self._cancelled:
                return
        for fill in asked:
            with self._changed:
                self.fills.append(fill)
                self._changed.notify_all()
        self.truncated = asked.truncated
        self.cut_short = asked.cut_short
        if not self._cancelled:
            self.reason = asked.reason


#: Placed fills are kept, the last ones, while they have at most so many quads in all: stepping back
#: and forth shows them at once. A quad takes some 3 kB where it is cut fine to be drawn.
KEPT_QUADS = 16_000

#: Makes what is drawn of a placed fill: (fill, placement, region, boundary, strokes, tolerance).
Prepare = Callable[[Fill, Placement, Region | None, Boundary, Sequence[Stroke], int], Any]


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """A fill where it lies. net: what :data:`Prepare` made of it, None without."""

    fill: Fill
    placement: Placement
    net: Any = None


class Placer:
    """Places the fills of one boundary after another, in a thread.

    surface: what they lie on, or None. prepare: called in the thread with each that is placed.
    """

    def __init__(self, surface: Surface | None, prepare: Prepare | None = None) -> None:
        self._surface, self._prepare = surface, prepare
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="placing")
        self._placed: dict[tuple[tuple[int, int], bool], Future[Placed]] = {}
        self._region: tuple[Boundary, Region] | None = None

    def forget(self) -> None:
        """What was asked for is of no use any more."""
        for future in self._placed.values():
            future.cancel()
        self._placed = {}

    def placed(
        self,
        rank: tuple[int, int],
        fill: Fill,
        boundary: Boundary,
        strokes: Sequence[Stroke],
        tolerance: int,
        following: bool,
    ) -> Future[Placed]:
        """The fill of a rank where it lies, now or later; one that was not begun is dropped.

        rank: its place in the list, and among the variants there. following: pull strands onto
        the strokes.
        """
        key = (rank, following)
        if key not in self._placed:
            for future in self._placed.values():
                future.cancel()
            self._drop_oldest(fill.n_quads)
            self._placed[key] = self._worker.submit(
                self._place, fill, boundary, tuple(strokes), tolerance, following
            )
        return self._placed[key]

    def close(self) -> None:
        """Wait for what was begun."""
        self._worker.shutdown(wait=True, cancel_futures=True)

    def _drop_oldest(self, coming: int) -> None:
        """Keep only the last fills that have few enough quads, with those that are coming."""
        kept: list[tuple[tuple[tuple[int, int], bool], Future[Placed]]] = []
        for key, future in reversed(self._placed.items()):
            if future.cancelled():
                continue
            if future.done() and future.exception() is None:
                coming += future.result().fill.n_quads
            if coming > KEPT_QUADS:
                break
            kept.append((key, future))
        self._placed = dict(reversed(kept))

    def _place(
        self,
        fill: Fill,
        boundary: Boundary,
        strokes: tuple[Stroke, ...],
        tolerance: int,
        following: bool,
    ) -> Placed:
        assert boundary.points is not None
        region = None
        if self._surface is not None:
            # This is the one thread that places: nobody else writes this.
            if self._region is None or self._region[0] is not boundary:
                self._region = boundary, enclose_region(self._surface, boundary.points)
            region = self._region[1]
        pulling = strokes if following else ()
        placement = place(fill, boundary.points, region, pulling, tolerance=tolerance)
        if self._prepare is None:
            return Placed(fill, placement)
        net = self._prepare(fill, placement, region, boundary, strokes, tolerance)
        return Placed(fill, placement, net)


#: Fills asked for at first; the key m asks for twice as many each time.
LIMIT = 100

#: Variants of one fill that are listed at most.
VARIANTS = 100

#: Most edges that a strand's ends may be off, by the key.
MAX_TOLERANCE = 3


#: What is said where there is nothing to open.
UNFOLDED = "all fills are listed; a lists one of each pattern"


class FillFinder:
    """What is asked, and what was found of it so far.

    Nothing is asked for until there is a boundary. tolerance, order, strict, limit: as for
    :func:`query.fills`. following: are strands pulled onto their strokes? folded: is every fill
    listed of another pattern, with its variants under it? Else all fills are. max_irregular,
    max_valence: of vertices within a fill, None for any. rank: of the fill
    that is looked at, from 0. variant: 0 for the fill listed, k for the k-th variant under it.
    prepare: see :class:`Placer`.
    """

    def __init__(
        self,
        source: PatternSource,
        surface: Surface | None,
        strokes: Sequence[Stroke],
        tolerance: int = TOLERANCE,
        limit: int = LIMIT,
        folded: bool = True,
        prepare: Prepare | None = None,
    ) -> None:
        self._source = OneAtATime(source)
        self.boundary: Boundary | None = None
        self.strokes: list[Stroke] = list(strokes)
        self.tolerance = tolerance
        self.order: str | None = None
        self.strict = False
        self.limit = limit
        self.following = True
        self.folded = folded
        self.max_irregular: int | None = None
        self.max_valence: int | None = None
        self.message = ""
        self.rank = 0
        self.variant = 0
        self._under: tuple[int, FillSearch] | None = None
        self._search: FillSearch | None = None
        self._ended: list[FillSearch] = []
        self._seen: tuple[object, ...] = ()
        self._placer = Placer(surface, prepare)

    @property
    def fills(self) -> list[Fill]:
        """The fills found so far, best first."""
        return [] if self._search is None else self._search.fills

    @property
    def searching(self) -> bool:
        """May there be more fills to come?"""
        return self._search is not None and not self._search.done

    @property
    def truncated(self) -> bool:
        """Has the list been cut off, so that the key m finds more?"""
        return self._search is not None and self._search.cut_short

    @property
    def default_order(self) -> str:
        """The order of the fills where none is chosen; see :func:`query.fills`."""
        return default_order(points=True, drawn=self._has_drawn_stroke)

    @property
    def _has_drawn_stroke(self) -> bool:
        return any(s.points is not None for s in self.strokes)

    def _is_usable(self, order: str) -> bool:
        """Can the fills come in this order? Boundaries always have points here."""
        return ORDERS[order].is_usable(points=True, strokes=self._has_drawn_stroke)

    @property
    def fill(self) -> Fill | None:
        """The fill that is looked at; None while there is none."""
        found = self.fills
        if self.rank >= len(found):
            return None
        return found[self.rank] if self.variant == 0 else self.variants[self.variant - 1]

    @property
    def variants(self) -> list[Fill]:
        """The fills under the one listed that were found so far; they are looked for as soon as
        this is asked."""
        search = self._search_variants()
        return [] if search is None else search.fills

    @property
    def counting(self) -> bool:
        """May there be more variants than were found so far?"""
        search = self._search_variants()
        return search is not None and (not search.done or search.truncated)

    @property
    def placed(self) -> Placed | None:
        """The fill that is looked at, where it lies; None while that is not known yet."""
        future = self._placing()
        if future is None or not future.done():
            return None
        if future.exception() is not None:
            return None
        return future.result()

    @property
    def trouble(self) -> str | None:
        """Why nothing is shown, if something is wrong."""
        search = self._search
        if search is None:
            return None
        if search.failure is not None:
            return f"the query failed: {search.failure}"
        if search.done and not search.fills:
            return search.reason
        future = self._placing()
        error = future.exception() if future is not None and future.done() else None
        return None if error is None else f"this fill cannot be placed: {error}"

    def poll(self) -> bool:
        """Is there something new since the last time that this was asked?"""
        under = (len(self.variants), self.counting)
        now = (len(self.fills), self.searching, self.placed, self.trouble, under)
        changed = now != self._seen
        self._seen = now
        return changed

    def settle(self, rank: int | None = None) -> None:
        """Wait for the fill of a rank (from 0; None: for all), look at it, wait for its place.

        Raises NotFoundError if there is no such fill, and what the query or the placing raised.
        """
        if self._search is None:
            raise NotFoundError("there is no boundary that can be filled; draw or change one")
        wanted = None if rank is None else rank + 1
        self._search.wait(wanted)
        if self._search.failure is not None:
            raise self._search.failure
        if rank is not None:
            if rank >= len(self.fills):
                raise NotFoundError(
                    f"no fill: {self.trouble}"
                    if not self.fills
                    else f"there is no fill {rank + 1}, only {len(self.fills)}"
                )
            self.rank, self.variant = rank, 0
        under = self._search_variants()
        if under is not None:
            under.wait()
        future = self._placing()
        if future is not None:
            error = future.exception()
            if error is not None:
                raise error

    def close(self) -> None:
        """End what is going on, and wait until the source is not in use any more."""
        if self._search is not None:
            self._search.cancel()
            self._ended.append(self._search)
        self._forget_variants()
        for search in self._ended:
            search.join()
        self._placer.close()

    # What keys do

    def step(self, by: int) -> None:
        """Another fill, stopping at the ends of what has been found."""
        self.look_at(max(0, self.rank + by))

    def look_at(self, rank: int) -> None:
        """The fill of a rank from 0; from the end, if below 0."""
        self.rank = max(0, min(rank if rank >= 0 else len(self.fills) + rank, len(self.fills) - 1))
        self.variant = 0

    def step_variant(self, by: int) -> None:
        """Another variant under the fill listed, or that fill again, stopping at either end."""
        if not self.variants and not self.counting:
            self.message = "this pattern has no other fill here" if self.folded else UNFOLDED
            return
        self.variant = max(0, min(self.variant + by, len(self.variants)))

    def toggle_folded(self) -> None:
        """One fill of each pattern, or every fill in its place."""
        self.folded = not self.folded
        self.restart()

    def stop(self) -> None:
        """End the query that runs; the fills found so far stay."""
        if self._search is not None and not self._search.done:
            self._search.cancel()
            self.message = "stopped looking: these are the fills found so far"

    def change_tolerance(self, by: int) -> None:
        """How far strands may miss the strokes' ends, in edges."""
        self.choose_tolerance(self.tolerance + by)

    def choose_tolerance(self, edges: int) -> None:
        """The same, in edges."""
        self.tolerance = max(0, min(edges, MAX_TOLERANCE))
        self.restart()

    def limit_irregular(self, most: int | None) -> None:
        """Fills with at most so many irregular vertices, None for any number."""
        if most != self.max_irregular:
            self.max_irregular = most
            self.restart()

    def limit_valence(self, most: int | None) -> None:
        """Fills whose vertices have at most so many quads, None for any number."""
        if most != self.max_valence:
            self.max_valence = most
            self.restart()

    def choose_order(self, order: str | None) -> None:
        """An order by its name, None for the one by default."""
        if order != self.order:
            self.order = order
            self.restart()

    def list_orders(self) -> list[str]:
        """List the orders that make sense here."""
        return [name for name in ORDERS if self._is_usable(name)]

    def change_order(self) -> None:
        """The next order that makes sense here, after the last the default."""
        choices: list[str | None] = [None, *filter(self._is_usable, ORDERS)]
        at = choices.index(self.order) if self.order in choices else 0
        self.order = choices[(at + 1) % len(choices)]
        self.restart()

    def toggle_strict(self) -> None:
        """Fills with the boundary's own corners only, or others too."""
        self.strict = not self.strict
        self.restart()

    def toggle_following(self) -> None:
        """Pull strands onto their strokes, or not."""
        self.following = not self.following

    def more(self) -> None:
        """Ask for twice as many fills."""
        if not self.truncated:
            self.message = "these are all the fills there are" if self.fills else ""
            return
        self.limit *= 2
        self.restart(keep_rank=True)

    def drop_stroke(self) -> None:
        """Forget the last stroke."""
        if self.strokes:
            self.strokes.pop()
            self.restart()

    def restart(self, *, keep_rank: bool = False) -> None:
        """End the query that runs, and ask anew."""
        if self._search is not None:
            self._search.cancel()
            self._ended = [s for s in self._ended if not s.done] + [self._search]
        self._placer.forget()
        self._forget_variants()
        self.variant = 0
        if not keep_rank:
            self.rank = 0
        self._search = None if self.boundary is None else FillSearch(self._question(self.boundary))

    # How it is done

    def _question(self, boundary: Boundary) -> Callable[[], Fills]:
        strokes, tolerance, limit = tuple(self.strokes), self.tolerance, self.limit
        order, strict, source = self.order, self.strict, self._source
        irregular = self.max_irregular
        highest = NO_DOUBLETS if self.max_valence is None else (NO_DOUBLETS[0], self.max_valence)
        per_pattern = 1 if self.folded else None
        if order is not None and not self._is_usable(order):
            order = None

        def ask() -> Fills:
            return fills(
                source,
                boundary,
                strokes=strokes,
                tolerance=tolerance,
                limit=limit,
                per_pattern=per_pattern,
                order=order,
                strict=strict,
                max_irregular=irregular,
                valence=highest,
            )

        return ask

    def _search_variants(self) -> FillSearch | None:
        """The search for what is under the fill listed; begun if it was not, once the list is
        complete: both at once would only wait for each other."""
        search = self._search
        if not self.folded or search is None or not search.done or search.asked is None:
            return None
        if self.rank >= len(search.fills):
            return None
        if self._under is None or self._under[0] != self.rank:
            self._forget_variants()
            asked, listed = search.asked, search.fills[self.rank]
            self._under = self.rank, FillSearch(lambda: asked.variants(listed, limit=VARIANTS))
        return self._under[1]

    def _forget_variants(self) -> None:
        """End the search for what is under a fill."""
        if self._under is not None:
            self._under[1].cancel()
            self._ended = [s for s in self._ended if not s.done] + [self._under[1]]
            self._under = None

    def _placing(self) -> Future[Placed] | None:
        """The work of placing the fill that is looked at; begun if it was not."""
        fill, boundary = self.fill, self.boundary
        if fill is None or boundary is None:
            return None
        return self._placer.placed(
            (self.rank, self.variant), fill, boundary, self.strokes, self.tolerance, self.following
        )
