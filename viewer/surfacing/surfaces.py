"""Edits and the surface that is made of them: the half of the viewer that asks.

It computes nothing itself: cycles come from
:func:`patterndb_sketch.surfacing.cycles.find_cycles`, patches from
:func:`patterndb_sketch.surfacing.surfaces.surface`. Both run in a thread; whoever shows them
asks :meth:`Surfaces.poll` now and then whether there is something new.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from patterndb.geometry.points import Points
from patterndb.store import Database
from patterndb_sketch.curvenetwork.drawing import Drawing
from patterndb_sketch.curvenetwork.network import CurveNetwork, Cycle
from patterndb_sketch.history import History
from patterndb_sketch.surfacing.edits import SurfacingEdits
from patterndb_sketch.surfacing.methods import METHODS, SurfaceOptions
from patterndb_sketch.surfacing.openings import Openings
from patterndb_sketch.surfacing.patch import SurfacePatch
from patterndb_sketch.surfacing.sampling import (
    EDGES_OF_MEDIAN_CURVE,
    EDGES_OF_MEDIAN_QUADS,
    default_spacing,
)
from viewer.surfacing.body import SurfaceBody
from viewer.surfacing.maker import Find, Made, SurfaceMaker, Wish

#: Seconds that a change waits for what it asks for: what is made at once is shown at once.
AT_ONCE = 0.05


class Surfaces:
    """What is asked for, and what was made of it last.

    steps: of edits, the drawing and what the user made of it. message: what went wrong last.
    settings: of which the method is the edits'. spacing, db, find: as for
    :class:`viewer.surfacing.state.SurfacingState`.
    """

    def __init__(
        self,
        edits: SurfacingEdits,
        settings: SurfaceOptions,
        spacing: float | None,
        db: Database | None,
        find: Find,
    ) -> None:
        self.steps = History(edits)
        self.settings = settings
        self.message = ""
        self.has_database = db is not None
        self.made: Made | None = None
        self._spacing = spacing
        self._failure: BaseException | None = None
        self._seen: tuple[object, ...] = ()
        self._stages: tuple[Drawing, dict[int, tuple[CurveNetwork, tuple[int, ...]]]]
        self._stages = edits.drawing, {}
        points = [curve.points for curve in edits.drawing.network.curves]
        self.all_points = np.concatenate(points) if points else np.zeros((0, 3))
        self._maker = SurfaceMaker(find, db)
        self.ask()

    def close(self) -> None:
        """Wait until nothing is being made any more."""
        self._maker.close()

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
        return self.network if self.made is None else self.made.wish.network

    @property
    def n_stages(self) -> int:
        """How many stages the drawing has, 0 if it does not say."""
        return len(self.edits.drawing.stages)

    @property
    def making(self) -> bool:
        """Is the surface still that of an earlier state?"""
        return self._maker.busy

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
    def body(self) -> SurfaceBody | None:
        """The patches as they are drawn, None if there are none."""
        return None if self.made is None else self.made.body

    @property
    def off_body(self) -> SurfaceBody | None:
        """Likewise those that are switched off."""
        return None if self.made is None else self.made.off_body

    @property
    def openings(self) -> Openings | None:
        """What is open in the network shown; None while its surface is not there."""
        made = self.made
        return None if made is None or made.wish.network is not self.network else made.openings

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
        return self.made.wish.whole((self.patches if on else self.off)[number].cycle)

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
        now = (self.made, self._failure, self.making)
        changed = now != self._seen
        self._seen = now
        return changed

    def settle(self) -> None:
        """Wait for the surface that was asked for; raises what making it raised."""
        self._maker.wait()
        self._take()
        if self._failure is not None:
            raise self._failure

    def off_polyline(self, number: int) -> Points:
        """(k, 3) the curves around a patch that is switched off, the first point not again."""
        made = self.made
        assert made is not None
        return made.wish.network.polyline(self.off[number].cycle)

    def ask(self) -> None:
        """Have the surface of what is asked for now made."""
        network, numbers = self._at_stage()
        edits = self.edits
        self.settings = replace(self.settings, method=edits.method)
        asked = (edits.method, *edits.methods.values())
        quads = any(METHODS[name].makes_quads for name in asked)
        spacing = self._spacing
        if spacing is None:
            whole = edits.drawing.network
            edges = EDGES_OF_MEDIAN_QUADS if quads else EDGES_OF_MEDIAN_CURVE
            spacing = default_spacing(whole, edges) if whole.curves else 1.0
        self._maker.want(
            Wish(
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
        )
        self._maker.wait(AT_ONCE)
        self._take()

    def _take(self) -> None:
        """Show what was made last."""
        last = self._maker.last
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
