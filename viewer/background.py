"""Fills that arrive while something else goes on."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass

from patterndb.core.patternclass import PatternClass
from query import Boundary, Fill, Fills, Stroke
from query.engine import PatternSource
from query.placing import Placement, Region, Surface, enclose_region, place
from viewer.net import Net


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


# Places fills in a thread, so that whoever looks at them need not wait.

#: Placed fills that are kept, the last ones: stepping back and forth shows them at once.
KEPT = 64


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """A fill where it lies."""

    fill: Fill
    placement: Placement
    net: Net


class Placer:
    """Places the fills of one boundary after another; surface: what they lie on, or None."""

    def __init__(self, surface: Surface | None) -> None:
        self._surface = surface
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
            done = [(k, f) for k, f in self._placed.items() if not f.cancelled()]
            self._placed = dict(done[-KEPT:])
            self._placed[key] = self._worker.submit(
                self._place, fill, boundary, tuple(strokes), tolerance, following
            )
        return self._placed[key]

    def close(self) -> None:
        """Wait for what was begun."""
        self._worker.shutdown(wait=True, cancel_futures=True)

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
        net = Net.of(fill, placement, region, boundary.corner_counts, strokes, tolerance)
        return Placed(fill, placement, net)
