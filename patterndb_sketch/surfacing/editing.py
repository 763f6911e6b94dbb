"""The editing of a surface of curves: edits, steps back and forward, and the surface made of them.

Cycles come from :func:`patterndb_sketch.surfacing.cycles.find_cycles`, patches from
:func:`patterndb_sketch.surfacing.surfaces.surface`. Both run in a thread; whoever shows them
asks :meth:`SurfacingEditing.poll` now and then whether there is something new.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from time import perf_counter

import numpy as np

from patterndb.errors import PatternDBError
from patterndb.geometry.points import Points
from patterndb_sketch.background import Latest
from patterndb_sketch.curvenetwork.drawing import Drawing
from patterndb_sketch.curvenetwork.network import CurveNetwork, Cycle
from patterndb_sketch.history import History
from patterndb_sketch.surfacing.edits import (
    Key,
    SurfacingEdits,
    choose_next_method,
)
from patterndb_sketch.surfacing.inking import InkedStroke
from patterndb_sketch.surfacing.methods import DEFAULT_METHOD, METHODS, SurfaceRequest
from patterndb_sketch.surfacing.openings import Openings, find_openings
from patterndb_sketch.surfacing.patch import SurfacePatch, Surfacing
from patterndb_sketch.surfacing.patchsurface import PatchSurface
from patterndb_sketch.surfacing.sampling import (
    EDGES_OF_MEDIAN_CURVE,
    EDGES_OF_MEDIAN_QUADS,
    default_spacing,
)
from patterndb_sketch.surfacing.session import SurfacingWork
from patterndb_sketch.surfacing.surfaces import LoopMemory, surface
from query.engine import PatternSource

#: Seconds that a change waits for what it asks for: what is made at once is shown at once.
AT_ONCE = 0.05

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
class SurfaceTask:
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
    settings: SurfaceRequest
    spacing: float

    def here(self, cycles: Sequence[Cycle]) -> list[Cycle]:
        """Those cycles of the whole drawing that the network has, by its own numbers."""
        number = {name: i for i, name in enumerate(self.numbers)}
        found = [cycle.renumber(number) for cycle in cycles]
        return [cycle for cycle in found if cycle is not None]

    def whole(self, cycle: Cycle) -> Cycle:
        """A cycle of the network by the numbers of the whole drawing."""
        steps = tuple((self.numbers[curve], backward) for curve, backward in cycle.steps)
        return Cycle(steps)


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceResult:
    """What was made of a task.

    surfacing, body:  the patches; None where there is no cycle.
    off, off_body:    likewise those that are switched off, to be seen as outlines.
    openings: curves of the task's network that bound no patch which is on, and open rims.
    notes:   what finding the cycles and surfacing had to tell.
    finding: seconds of finding cycles, 0 if they were known. seconds: of surfacing.
    """

    task: SurfaceTask
    surfacing: Surfacing | None
    body: PatchSurface | None
    off: Surfacing | None
    off_body: PatchSurface | None
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


class SurfacingEditing:
    """The edits of a drawing, and the surface that was made of them last, in a thread.

    steps: of edits, the drawing and what the user made of it. message: what went wrong last.
    settings: of which the method is the edits'. spacing: about how far vertices are apart; by
    default that of :func:`patterndb_sketch.surfacing.surfaces.surface` for the whole drawing, in
    every stage. db: where quads come from; without it there are none. find: how cycles are found.
    made: the surface that was made last.
    """

    def __init__(
        self,
        edits: SurfacingEdits,
        settings: SurfaceRequest,
        spacing: float | None,
        db: PatternSource | None,
        find: Find = find_network_cycles,
    ) -> None:
        self.steps = History(edits)
        self.settings = settings
        self.message = ""
        self.has_database = db is not None
        self.made: SurfaceResult | None = None
        self._spacing = spacing
        self._failure: BaseException | None = None
        self._seen: tuple[object, ...] = ()
        self._stages: tuple[Drawing, dict[int, tuple[CurveNetwork, tuple[int, ...]]]]
        self._stages = edits.drawing, {}
        points = [curve.points for curve in edits.drawing.network.curves]
        self.all_points = np.concatenate(points) if points else np.zeros((0, 3))
        self._find, self._db = find, db
        self._saved = edits
        self._memory = LoopMemory()
        self._known = _Known()
        self._latest: Latest[SurfaceResult] = Latest("surfacing")
        self.ask()

    def close(self) -> None:
        """Wait until nothing is being made any more."""
        self._latest.close()

    @property
    def edits(self) -> SurfacingEdits:
        """What is asked for now."""
        return self.steps.now

    @property
    def network(self) -> CurveNetwork:
        """The curves of this stage."""
        return self._at_stage()[0]

    @property
    def network_made(self) -> CurveNetwork:
        """The curves that the surface shown is of."""
        return self.network if self.made is None else self.made.task.network

    @property
    def n_stages(self) -> int:
        """How many stages the drawing has, 0 if it does not say."""
        return len(self.edits.drawing.stages)

    @property
    def making(self) -> bool:
        """Is the surface still that of an earlier state?"""
        return self._latest.busy

    @property
    def patches(self) -> tuple[SurfacePatch, ...]:
        """The patches that are there."""
        made = self.made
        return () if made is None or made.surfacing is None else made.surfacing.patches

    @property
    def off(self) -> tuple[SurfacePatch, ...]:
        """Those that are switched off."""
        made = self.made
        return () if made is None or made.off is None else made.off.patches

    @property
    def body(self) -> PatchSurface | None:
        """The patches as they are drawn, None if there are none."""
        return None if self.made is None else self.made.body

    @property
    def off_body(self) -> PatchSurface | None:
        """Likewise those that are switched off."""
        return None if self.made is None else self.made.off_body

    @property
    def openings(self) -> Openings | None:
        """What is open in the network shown; None while its surface is not there."""
        made = self.made
        return None if made is None or made.task.network is not self.network else made.openings

    @property
    def trouble(self) -> str:
        """Why the surface is not what was asked for, "" if it is."""
        return "" if self._failure is None else str(self._failure)

    @property
    def extent(self) -> float:
        """The diagonal of the box around the whole drawing."""
        return (
            float(np.linalg.norm(np.ptp(self.all_points, axis=0))) if len(self.all_points) else 1.0
        )

    @property
    def centre(self) -> Points:
        """(3,) a point within that box."""
        return self.all_points.mean(axis=0) if len(self.all_points) else np.zeros(3)

    def cycle_of(self, on: bool, number: int) -> Cycle:
        """The cycle of a patch that is on or off, by the curves of the whole drawing."""
        assert self.made is not None
        return self.made.task.whole((self.patches if on else self.off)[number].cycle)

    def rings(self) -> list[Points]:
        """For every patch that is off a point (3,) near its middle."""
        body = self.off_body
        if body is None:
            return []
        middles = [body.middle(number) for number in range(len(self.off))]
        polylines = [self.off_polyline(number) for number in range(len(self.off))]
        return [
            line.mean(axis=0) if at is None else at
            for at, line in zip(middles, polylines, strict=True)
        ]

    def poll(self) -> bool:
        """Is there something new since the last time that this was asked?"""
        self._take()
        laid = self._lay_loose()
        now = (self.made, self._failure, self.making)
        changed = now != self._seen
        self._seen = now
        return changed or laid

    def settle(self) -> None:
        """Wait for the surface that was asked for; raises what making it raised."""
        self._latest.wait()
        self._take()
        if self._failure is not None:
            raise self._failure

    def off_polyline(self, number: int) -> Points:
        """(k, 3) the curves around a patch that is switched off, the first point not again."""
        made = self.made
        assert made is not None
        return made.task.network.polyline(self.off[number].cycle)

    def ask(self) -> None:
        """Have the surface of what is asked for now made."""
        network, numbers = self._at_stage()
        edits = self.edits
        self.settings = self.settings.having(method=edits.method)
        asked = (edits.method, *edits.methods.values())
        quads = any(METHODS[name].makes_quads for name in asked)
        spacing = self._spacing
        if spacing is None:
            whole = edits.drawing.network
            edges = EDGES_OF_MEDIAN_QUADS if quads else EDGES_OF_MEDIAN_CURVE
            spacing = default_spacing(whole, edges) if whole.curves else 1.0
        task = SurfaceTask(
            edits.drawing,
            network,
            numbers,
            edits.given,
            edits.added,
            edits.banned,
            edits.methods,
            self.settings,
            spacing,
        )
        self._latest.want(partial(self._make, task))
        self._latest.wait(AT_ONCE)
        self._take()

    # Edits

    def edit(self, after: SurfacingEdits) -> None:
        """Take another step, which can be taken back, and ask for its surface."""
        self.steps.step(after)
        self.ask()

    def toggle_patch(self, on: bool, number: int) -> None:
        """Switch a patch that is on off, or one that is off on again."""
        cycle = self.cycle_of(on, number)
        self.edit(self.edits.switched_off(cycle) if on else self.edits.switched_on(cycle))

    def choose_next_method_of(self, number: int) -> None:
        """Make a patch by the next method."""
        cycle = self.cycle_of(True, number)
        method = self.edits.methods.get(cycle.key, self.edits.method)
        after = choose_next_method(method, database=self.has_database)
        self.edit(self.edits.with_method_of(cycle, after))

    def add_ink(self, ink: InkedStroke) -> None:
        """Keep a stroke that was drawn on the surface."""
        if ink.missed:
            self.message = (
                f"the stroke left the surface: {ink.missed} of {ink.rays} places are off it, "
                f"it is in {len(ink.parts)} part{'' if len(ink.parts) == 1 else 's'}"
            )
        self.steps.step(replace(self.edits, inks=(*self.edits.inks, ink)))

    def add_curves(self, reach: float) -> bool:
        """Make the last stroke curves of the network; cycles are found anew, or cut.

        reach: how far its ends may be from the curves that they are moved to. False if that cannot
        be.
        """
        made = self.made
        if not self.edits.inks or made is None or made.surfacing is None:
            self.message = "draw a stroke from curve to curve first"
            return False
        ink = self.edits.inks[-1]
        if made.surfacing is not ink.surfacing:
            self.message = "the surface has changed since the stroke was drawn; draw it again"
            return False
        try:
            after = self.edits.with_stroke(ink, reach)
        except PatternDBError as error:
            self.message = str(error)
            return False
        self.edit(after)
        return True

    def take_work(self, work: SurfacingWork) -> None:
        """Take work that was kept, as one step."""
        self.settings = self.settings.having(alpha=work.alpha, fair=work.fair)
        self.edit(work.edits)

    def change_alpha(self, alpha: float) -> None:
        """Another price of chords, 0 to 1; where no patch is cut so, all are from now."""
        alpha = round(min(max(alpha, 0.0), 1.0), 3)
        if alpha == self.settings.alpha:
            return
        self.settings = self.settings.having(alpha=alpha)
        edits = self.edits
        if "chords" in (edits.method, *edits.methods.values()):
            self.ask()
        else:
            self.choose_method("chords")
            self.message = "alpha is the price of chords: loops are cut along chords now"

    def toggle_fair(self) -> None:
        """Fair smooth patches across curves, or leave each by itself."""
        settings = self.settings
        self.settings = settings.having(fair=not settings.fair)
        edits = self.edits
        if settings.fair or DEFAULT_METHOD in (edits.method, *edits.methods.values()):
            self.ask()
        else:
            self.choose_method(DEFAULT_METHOD)
            self.message = "fairing moves smooth patches: loops are filled by smooth grids now"

    def next_method(self) -> None:
        """The next method for all patches."""
        method = choose_next_method(self.edits.method, database=self.has_database)
        self.choose_method(method)

    def list_methods(self) -> list[str]:
        """List the methods that can be had here."""
        there = self.has_database
        return [one.name for one in METHODS.values() if there or not one.needs_database]

    def choose_method(self, method: str) -> None:
        """A method, by its name, for all patches."""
        if method == self.edits.method and not self.edits.methods:
            return
        self.edit(self.edits.with_method(method))

    def go_to_stage(self, stage: int) -> None:
        """Show the drawing as it was after so many stages, from the end if below 0.

        Strokes that were drawn are forgotten.
        """
        n = self.n_stages
        if not n:
            self.message = "the drawing has no stages"
            return
        stage = min(max(stage if stage >= 0 else n + 1 + stage, 0), n)
        if stage != self.edits.stage:
            self.steps.settle(replace(self.edits, stage=stage, inks=()))
            self.ask()

    def step(self, by: int) -> None:
        """Stages forward or back, stopping at the ends."""
        self.go_to_stage(max(self.edits.stage + by, 0))

    def all_on(self) -> None:
        """Switch on whatever was switched off."""
        if self.edits.banned:
            self.edit(replace(self.edits, banned=()))

    @property
    def unsaved(self) -> bool:
        """Was anything edited since the surface was saved?"""
        return self.edits is not self._saved

    def mark_saved(self) -> None:
        """The surface was saved as it is."""
        self._saved = self.edits

    def undo(self) -> None:
        """Take back the last stroke, curve, click on a patch or change of method."""
        self._turn(self.steps.undo, "there is nothing to take back")

    def redo(self) -> None:
        """Do again what was taken back last."""
        self._turn(self.steps.redo, "there is nothing to do again")

    def _turn(self, turn: Callable[[], bool], otherwise: str) -> None:
        before = self.edits
        if not turn():
            self.message = otherwise
        elif not self.edits.asks_like(before):
            self.ask()

    def _lay_loose(self) -> bool:
        """Lay the strokes that were kept on their surface, once that is made; was it done?"""
        made = self.made
        if self.making or made is None or made.surfacing is None:
            return False
        inks = self.edits.inks
        if all(ink.surfacing is not None for ink in inks):
            return False
        laid = [
            ink
            for one in inks
            if (ink := one.lay_on(made.surfacing) if one.surfacing is None else one) is not None
        ]
        self.steps.settle(replace(self.edits, inks=tuple(laid)))
        return True

    def _take(self) -> None:
        """Show what was made last."""
        last = self._latest.last
        if last is None:
            return
        self._failure = last.exception()
        if self._failure is None:
            self.made = last.result()

    def _at_stage(self) -> tuple[CurveNetwork, tuple[int, ...]]:
        """The network of this stage, and the numbers of its curves in the whole drawing."""
        drawing, stage = self.edits.drawing, self.edits.stage
        if self._stages[0] is not drawing:
            self._stages = drawing, {}
        known = self._stages[1]
        if stage not in known:
            numbers = tuple(range(len(drawing.network.curves)))
            network = drawing.network
            if stage < len(drawing.stages):
                network = drawing.after(stage)
                numbers = tuple(sorted({c for one in drawing.stages[:stage] for c in one}))
            known[stage] = network, numbers
        return known[stage]

    def _make(self, task: SurfaceTask) -> SurfaceResult:
        # This is the one thread that makes: nobody else writes to what is known.
        started = perf_counter()
        cycles, notes = self._cycles(task)
        finding = perf_counter() - started
        banned = {cycle.key for cycle in task.banned}
        on = [c for c in cycles if task.whole(c).key not in banned]
        started = perf_counter()
        surfacing, body = self._surfaced(task, on, task.settings, task.methods)
        seconds = perf_counter() - started
        # Quads would change the edges of curves; an outline needs none.
        plain = task.settings.having(method="chords", fair=False)
        off, off_body = self._surfaced(task, task.here(task.banned), plain, {})
        self._memory.end_stage()
        told = () if surfacing is None else surfacing.notes
        there = () if surfacing is None else surfacing.list_surfaced_cycles()
        openings = find_openings(task.network, there)
        return SurfaceResult(
            task, surfacing, body, off, off_body, openings, (*notes, *told), finding, seconds
        )

    def _cycles(self, task: SurfaceTask) -> tuple[tuple[Cycle, ...], tuple[str, ...]]:
        added = task.here(task.added)
        if task.given is not None:
            cycles = {task.whole(c).key: c for c in (*task.here(task.given), *added)}
            return tuple(cycles.values()), ()
        if not task.network.curves:
            return (), ()
        banned = task.here(task.banned)
        asked = (sorted(c.key for c in added), sorted(c.key for c in banned))
        known = self._known
        if known.network is not task.network or asked != known.asked:
            found, notes = self._find(task.network, added, banned)
            known.network, known.asked = task.network, asked
            known.cycles, known.notes = tuple(found), tuple(notes)
        return known.cycles, known.notes

    def _surfaced(
        self,
        task: SurfaceTask,
        cycles: Sequence[Cycle],
        settings: SurfaceRequest,
        methods: Mapping[Key, str],
    ) -> tuple[Surfacing | None, PatchSurface | None]:
        if not cycles:
            return None, None
        keys = [task.whole(cycle).key for cycle in cycles]
        others: dict[Cycle, str] = {
            cycle: methods[key] for cycle, key in zip(cycles, keys, strict=True) if key in methods
        }
        made = surface(
            task.network,
            cycles,
            settings.having(spacing=task.spacing),
            methods=others,
            db=self._db,
            memory=self._memory,
        )
        # Tints go by the numbers of the whole drawing: they stay from stage to stage.
        tints = self._known.tints
        body = PatchSurface.of(made, {i: tints[key] for i, key in enumerate(keys) if key in tints})
        tints.update(zip(keys, body.tint_of, strict=True))
        return made, body
