"""Places fills in a thread, so that whoever looks at them need not wait."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass

from query import Boundary, Fill, Stroke
from query.placing import Placement, Region, Surface, enclose_region, place
from viewer.net import Net

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
        self._placed: dict[tuple[int, bool], Future[Placed]] = {}
        self._region: tuple[Boundary, Region] | None = None

    def forget(self) -> None:
        """What was asked for is of no use any more."""
        for future in self._placed.values():
            future.cancel()
        self._placed = {}

    def placed(
        self,
        rank: int,
        fill: Fill,
        boundary: Boundary,
        strokes: Sequence[Stroke],
        tolerance: int,
        following: bool,
    ) -> Future[Placed]:
        """The fill of a rank where it lies, now or later; one that was not begun is dropped.

        following: pull strands onto the strokes.
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
