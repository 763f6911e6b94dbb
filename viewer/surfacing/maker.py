"""Finds cycles and makes surfaces in a thread, so that whoever looks at them need not wait."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from concurrent.futures import wait as wait_for
from dataclasses import dataclass, field, replace
from time import perf_counter

from patterndb.store import Database
from patterndb_sketch.curvenetwork.drawing import Drawing
from patterndb_sketch.curvenetwork.network import CurveNetwork, Cycle
from patterndb_sketch.surfacing.edits import Key, renumber_cycle
from patterndb_sketch.surfacing.methods import SurfaceOptions
from patterndb_sketch.surfacing.openings import Openings, find_openings
from patterndb_sketch.surfacing.patch import Surfacing
from patterndb_sketch.surfacing.surfaces import LoopMemory, surface
from viewer.surfacing.body import SurfaceBody

# How cycles are found where a network brings none.

#: Finds the cycles of a network: (network, added, banned) -> cycles, and notes on them.
Find = Callable[
    [CurveNetwork, Sequence[Cycle], Sequence[Cycle]], tuple[Sequence[Cycle], Sequence[str]]
]


def find_network_cycles(
    network: CurveNetwork, added: Sequence[Cycle], banned: Sequence[Cycle]
) -> tuple[Sequence[Cycle], Sequence[str]]:
    """Find cycles as :func:`patterndb_sketch.surfacing.cycles.find_cycles` does."""
    # Its solver takes a second to import, which networks with cycles need not wait for.
    from patterndb_sketch.surfacing.cycles import find_cycles

    result = find_cycles(network, added=added, banned=banned)
    return result.cycles, result.notes


@dataclass(frozen=True, slots=True, eq=False)
class Wish:
    """What is to be made.

    drawing: the whole one. network: its curves so far. numbers: for each of them the number that
             it has in the drawing, which all cycles here go by.
    given:   the cycles to surface; None to find them.
    added, banned: cycles that shall, or shall not, be patches. methods: for some cycles
    another method than the settings', by key. settings, spacing: as for
    :func:`patterndb_sketch.surfacing.surfaces.surface`.
    """

    drawing: Drawing
    network: CurveNetwork
    numbers: tuple[int, ...]
    given: tuple[Cycle, ...] | None
    added: tuple[Cycle, ...]
    banned: tuple[Cycle, ...]
    methods: Mapping[Key, str]
    settings: SurfaceOptions
    spacing: float

    def here(self, cycles: Sequence[Cycle]) -> list[Cycle]:
        """Those cycles of the whole drawing that the network has, by its own numbers."""
        number = {name: i for i, name in enumerate(self.numbers)}
        found = [renumber_cycle(cycle, number) for cycle in cycles]
        return [cycle for cycle in found if cycle is not None]

    def whole(self, cycle: Cycle) -> Cycle:
        """A cycle of the network by the numbers of the whole drawing."""
        steps = tuple((self.numbers[curve], backward) for curve, backward in cycle.steps)
        return Cycle(steps)


@dataclass(frozen=True, slots=True, eq=False)
class Made:
    """What was made of a wish.

    surfacing, body:  the patches; None where there is no cycle.
    off, off_body:    likewise those that are switched off, to be seen as outlines.
    openings: curves of the wish's network that bound no patch which is on, and open rims.
    notes:   what finding the cycles and surfacing had to tell.
    finding: seconds of finding cycles, 0 if they were known. seconds: of surfacing.
    """

    wish: Wish
    surfacing: Surfacing | None
    body: SurfaceBody | None
    off: Surfacing | None
    off_body: SurfaceBody | None
    openings: Openings
    notes: tuple[str, ...]
    finding: float
    seconds: float


@dataclass(slots=True)
class _Known:
    """What need not be done again if only the method or alpha changes."""

    network: CurveNetwork | None = None
    asked: tuple[list[Key], list[Key]] = field(default_factory=lambda: ([], []))
    cycles: tuple[Cycle, ...] = ()
    notes: tuple[str, ...] = ()
    tints: dict[Key, tuple[int, ...]] = field(default_factory=dict)


class SurfaceMaker:
    """Makes one surface after another; what was not begun when another is wanted is dropped.

    find: how cycles are found. db: where quads come from.
    """

    def __init__(self, find: Find, db: Database | None) -> None:
        self._find = find
        self._db = db
        self._memory = LoopMemory()
        self._known = _Known()
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="surfacing")
        self._asked: list[Future[Made]] = []

    def want(self, wish: Wish) -> None:
        """Ask for a surface instead of what was asked for before."""
        for future in self._asked:
            future.cancel()
        self._asked = [f for f in self._asked if not f.cancelled() and not f.done()]
        self._asked.append(self._worker.submit(self._make, wish))

    @property
    def busy(self) -> bool:
        """Is the last wish still to be fulfilled?"""
        return bool(self._asked) and not self._asked[-1].done()

    def wait(self, seconds: float | None = None) -> bool:
        """Until the last wish is fulfilled; False if time ran out before."""
        return not wait_for(self._asked[-1:], seconds).not_done

    @property
    def last(self) -> Future[Made] | None:
        """What was made last, of the wishes that are fulfilled."""
        return next((f for f in reversed(self._asked) if f.done() and not f.cancelled()), None)

    def close(self) -> None:
        """Wait for what was begun."""
        self._worker.shutdown(wait=True, cancel_futures=True)

    def _make(self, wish: Wish) -> Made:
        # This is the one thread that makes: nobody else writes to what is known.
        started = perf_counter()
        cycles, notes = self._cycles(wish)
        finding = perf_counter() - started
        banned = {cycle.key for cycle in wish.banned}
        on = [c for c in cycles if wish.whole(c).key not in banned]
        started = perf_counter()
        surfacing, body = self._surfaced(wish, on, wish.settings, wish.methods)
        seconds = perf_counter() - started
        # Quads would change the edges of curves; an outline needs none.
        plain = replace(wish.settings, method="chords", fair=False)
        off, off_body = self._surfaced(wish, wish.here(wish.banned), plain, {})
        self._memory.end_stage()
        told = () if surfacing is None else surfacing.notes
        there = () if surfacing is None else surfacing.list_surfaced_cycles()
        openings = find_openings(wish.network, there)
        return Made(
            wish, surfacing, body, off, off_body, openings, (*notes, *told), finding, seconds
        )

    def _cycles(self, wish: Wish) -> tuple[tuple[Cycle, ...], tuple[str, ...]]:
        added = wish.here(wish.added)
        if wish.given is not None:
            cycles = {wish.whole(c).key: c for c in (*wish.here(wish.given), *added)}
            return tuple(cycles.values()), ()
        if not wish.network.curves:
            return (), ()
        banned = wish.here(wish.banned)
        asked = (sorted(c.key for c in added), sorted(c.key for c in banned))
        known = self._known
        if known.network is not wish.network or asked != known.asked:
            find_network_cycles, notes = self._find(wish.network, added, banned)
            known.network, known.asked = wish.network, asked
            known.cycles, known.notes = tuple(find_network_cycles), tuple(notes)
        return known.cycles, known.notes

    def _surfaced(
        self,
        wish: Wish,
        cycles: Sequence[Cycle],
        settings: SurfaceOptions,
        methods: Mapping[Key, str],
    ) -> tuple[Surfacing | None, SurfaceBody | None]:
        if not cycles:
            return None, None
        keys = [wish.whole(cycle).key for cycle in cycles]
        others: dict[Cycle, str] = {
            cycle: methods[key] for cycle, key in zip(cycles, keys, strict=True) if key in methods
        }
        made = surface(
            wish.network,
            cycles,
            options=replace(settings, spacing=wish.spacing),
            methods=others,
            db=self._db,
            memory=self._memory,
        )
        # Tints go by the numbers of the whole drawing: they stay from stage to stage.
        tints = self._known.tints
        body = SurfaceBody.of(made, {i: tints[key] for i, key in enumerate(keys) if key in tints})
        tints.update(zip(keys, body.tint_of, strict=True))
        return made, body
