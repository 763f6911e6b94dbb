"""Sessions of surfacing: the drawing with its new curves, cycles on and off, methods, strokes.

The content of the file is :class:`SavedSurfacing`; :mod:`patterndb_sketch.sessions` reads and
writes it. A cycle is its steps, [curve, 1 if it is walked backward].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Points
from patterndb.system.documents import JsonModel, JsonValue, Name, Pair
from patterndb_sketch.curvenetwork.drawing import Drawing
from patterndb_sketch.curvenetwork.network import Curve, CurveNetwork, Cycle, InvalidNetworkError
from patterndb_sketch.sessions import SessionFormat
from patterndb_sketch.surfacing.edits import SurfacingEdits
from patterndb_sketch.surfacing.inking import InkedStroke

Steps = list[Pair]


class SavedNetworkCurve(JsonModel):
    """A curve of the drawing; points and normals (n, 3)."""

    points: Points
    nodes: Pair
    id: Name
    stroke: Name
    normals: Points | None


class SavedMethod(JsonModel):
    """The method of one cycle."""

    cycle: Steps
    method: str


class SavedInk(JsonModel):
    """A stroke on the surface; fields as of :class:`InkedStroke`."""

    parts: list[Points]
    owners: list[Int64Array]
    missed: int
    rays: int


class SavedSurfacing(JsonModel):
    """What a session has; fields as of :class:`SurfacingEdits` and :class:`SurfacingWork`."""

    curves: list[SavedNetworkCurve]
    nodes: Points
    cycles: list[Steps]
    stages: list[list[int]]
    notes: list[str]
    stage: int
    given: list[Steps] | None
    added: list[Steps]
    banned: list[Steps]
    method: str
    methods: list[SavedMethod]
    strokes: list[SavedInk]
    alpha: float
    fair: bool


@dataclass(frozen=True, slots=True, eq=False)
class SurfacingWork:
    """What is edited. alpha, fair: of the surface.

    Strokes that were read have no surface yet: it has to be made first.
    """

    edits: SurfacingEdits
    alpha: float
    fair: bool

    def is_like(self, other: SurfacingWork) -> bool:
        """Is nothing different?"""
        mine, yours = (self.alpha, self.fair), (other.alpha, other.fair)
        return self.edits is other.edits and mine == yours


def _save(work: SurfacingWork) -> SavedSurfacing:
    edits = work.edits
    network = edits.drawing.network
    return SavedSurfacing(
        curves=[
            SavedNetworkCurve(one.points, list(one.nodes), one.id, one.stroke, one.normals)
            for one in network.curves
        ],
        nodes=network.nodes,
        cycles=_steps(network.cycles),
        stages=[list(stage) for stage in edits.drawing.stages],
        notes=list(edits.drawing.notes),
        stage=edits.stage,
        given=None if edits.given is None else _steps(edits.given),
        added=_steps(edits.added),
        banned=_steps(edits.banned),
        method=edits.method,
        methods=[
            SavedMethod([[curve, int(back)] for curve, back in key], method)
            for key, method in edits.methods.items()
        ],
        strokes=[
            SavedInk(list(ink.parts), list(ink.owners), ink.missed, ink.rays) for ink in edits.inks
        ],
        alpha=work.alpha,
        fair=work.fair,
    )


def _open(saved: SavedSurfacing, place: JsonValue) -> SurfacingWork:
    """Return the work that a file has; raises InvalidNetworkError with the place in it."""
    curves = tuple(
        Curve(one.points, (one.nodes[0], one.nodes[1]), one.id, one.stroke, one.normals)
        for one in saved.curves
    )
    network = CurveNetwork(curves, saved.nodes, _cycles(saved.cycles))
    for steps in (*saved.added, *saved.banned, *(saved.given or ())):
        network.walk(_cycle(steps))
    if not 0 <= saved.stage <= len(saved.stages):
        place.at("stage").fail(f"the drawing has {len(saved.stages)} stages")
    for i, ink in enumerate(saved.strokes):
        if [(len(owner), 3) for owner in ink.owners] != [part.shape for part in ink.parts]:
            place.at("strokes", i).fail("each point [x, y, z] of a part needs the patch it is on")
    edits = SurfacingEdits(
        Drawing(network, tuple(map(tuple, saved.stages)), tuple(saved.notes)),
        saved.stage,
        None if saved.given is None else _cycles(saved.given),
        _cycles(saved.added),
        _cycles(saved.banned),
        saved.method,
        {_cycle(one.cycle).key: one.method for one in saved.methods},
        tuple(
            InkedStroke(None, tuple(ink.parts), tuple(ink.owners), ink.missed, ink.rays)
            for ink in saved.strokes
        ),
    )
    return SurfacingWork(edits, saved.alpha, saved.fair)


SURFACING_SESSION: SessionFormat[SurfacingWork, SavedSurfacing] = SessionFormat(
    "surface", InvalidNetworkError, SavedSurfacing, _save, _open
)


def _steps(cycles: Sequence[Cycle]) -> list[Steps]:
    return [[[curve, int(back)] for curve, back in cycle.steps] for cycle in cycles]


def _cycle(steps: Steps) -> Cycle:
    return Cycle(tuple((curve, bool(back)) for curve, back in steps))


def _cycles(cycles: Sequence[Steps]) -> tuple[Cycle, ...]:
    return tuple(map(_cycle, cycles))
