"""What was made of a drawing, as JSON has it: the drawing with its new curves, cycles switched on
and off, methods, and strokes on the surface.

    {"curves": [{"points": [[x, y, z], ...], "nodes": [0, 1], "id": "a", "stroke": "a"}, ...],
     "nodes": [[x, y, z], ...], "cycles": [[[0, 0], [4, 1]], ...], "stages": [[0, 1], ...],
     "notes": [], "stage": 2, "given": null, "added": [], "banned": [[[0, 0], ...]],
     "method": "smooth", "methods": [{"cycle": [[0, 0], ...], "method": "chords"}],
     "strokes": [{"parts": [[[x, y, z], ...]], "owners": [[0, ...]], "missed": 0, "rays": 12}]}

A cycle is its steps, [curve, 1 if it is walked backward].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from msgspec import UNSET, UnsetType

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Points
from patterndb.system.documents import JsonModel, JsonValue, Name, Pair, Point, complete_points
from patterndb_sketch.curvenetwork.drawing import Drawing
from patterndb_sketch.curvenetwork.network import Curve, CurveNetwork, Cycle
from patterndb_sketch.surfacing.edits import SurfacingEdits
from patterndb_sketch.surfacing.inking import InkedStroke
from patterndb_sketch.surfacing.patch import Surfacing

Steps = list[Pair]


class EditedCurveEntries(JsonModel):
    """A curve of the drawing."""

    points: list[Point]
    nodes: Pair
    id: Name
    stroke: Name
    normals: list[Point] | UnsetType = UNSET


class MethodEntries(JsonModel):
    """The method of one cycle."""

    cycle: Steps
    method: str


class InkEntries(JsonModel):
    """A stroke on the surface."""

    parts: list[list[Point]]
    owners: list[list[int]]
    missed: int
    rays: int


class EditsEntries(JsonModel):
    """All of it."""

    curves: list[EditedCurveEntries]
    nodes: list[Point]
    cycles: list[Steps]
    stages: list[list[int]]
    notes: list[str]
    stage: int
    given: list[Steps] | None
    added: list[Steps]
    banned: list[Steps]
    method: str
    methods: list[MethodEntries]
    strokes: list[InkEntries]


@dataclass(frozen=True, slots=True, eq=False)
class LooseStroke:
    """A stroke that was on a surface; fields as of
    :class:`patterndb_sketch.surfacing.inking.InkedStroke`, without the surface."""

    parts: tuple[Points, ...]
    owners: tuple[Int64Array, ...]
    missed: int
    rays: int

    def lay_on(self, surfacing: Surfacing) -> InkedStroke | None:
        """Lay it on the surface made anew; None if that has not the patches it was on."""
        if any(owner.max(initial=-1) >= len(surfacing.patches) for owner in self.owners):
            return None
        return InkedStroke(surfacing, self.parts, self.owners, self.missed, self.rays)


def edits_document(edits: SurfacingEdits) -> dict[str, object]:
    """Make the document of what was made of a drawing."""
    drawing = edits.drawing
    network = drawing.network
    return {
        "curves": [
            {
                "points": curve.points.tolist(),
                "nodes": list(curve.nodes),
                "id": curve.id,
                "stroke": curve.stroke,
                **({} if curve.normals is None else {"normals": curve.normals.tolist()}),
            }
            for curve in network.curves
        ],
        "nodes": network.nodes.tolist(),
        "cycles": _steps(network.cycles),
        "stages": [list(stage) for stage in drawing.stages],
        "notes": list(drawing.notes),
        "stage": edits.stage,
        "given": None if edits.given is None else _steps(edits.given),
        "added": _steps(edits.added),
        "banned": _steps(edits.banned),
        "method": edits.method,
        "methods": [
            {"cycle": [[curve, int(back)] for curve, back in key], "method": method}
            for key, method in edits.methods.items()
        ],
        "strokes": [
            {
                "parts": [part.tolist() for part in ink.parts],
                "owners": [owner.tolist() for owner in ink.owners],
                "missed": ink.missed,
                "rays": ink.rays,
            }
            for ink in edits.inks
        ],
    }


def edits_of(document: JsonValue) -> tuple[SurfacingEdits, tuple[LooseStroke, ...]]:
    """Read what was made of a drawing, and the strokes on its surface, which has to be made first.

    Raises the document's error, and InvalidNetworkError for what is no network.
    """
    found = document.read(EditsEntries)
    curves = tuple(
        Curve(
            _points(one.points),
            (one.nodes[0], one.nodes[1]),
            one.id,
            one.stroke,
            None if one.normals is UNSET else _points(one.normals),
        )
        for one in found.curves
    )
    network = CurveNetwork(curves, _points(found.nodes), _cycles(found.cycles))
    for steps in (*found.added, *found.banned, *(found.given or ())):
        network.walk(_cycle(steps))
    stages = tuple(map(tuple, found.stages))
    if not 0 <= found.stage <= len(stages):
        document.fail(f"stage {found.stage}: the drawing has {len(stages)}")
    edits = SurfacingEdits(
        Drawing(network, stages, tuple(found.notes)),
        found.stage,
        None if found.given is None else _cycles(found.given),
        _cycles(found.added),
        _cycles(found.banned),
        found.method,
        {_cycle(one.cycle).key: one.method for one in found.methods},
    )
    strokes = tuple(
        LooseStroke(
            tuple(map(_points, one.parts)),
            tuple(np.array(owner, np.int64) for owner in one.owners),
            one.missed,
            one.rays,
        )
        for one in found.strokes
    )
    return edits, strokes


@dataclass(frozen=True, slots=True, eq=False)
class SurfacingWork:
    """What is kept in case of a crash. strokes: that are not among the edits yet."""

    edits: SurfacingEdits
    alpha: float
    fair: bool
    strokes: tuple[LooseStroke, ...] = ()

    def is_like(self, other: SurfacingWork) -> bool:
        """Is nothing different?"""
        mine, yours = (self.alpha, self.fair), (other.alpha, other.fair)
        return self.edits is other.edits and mine == yours

    def document(self) -> dict[str, object]:
        """What :meth:`of_document` reads, for JSON."""
        return {"edits": edits_document(self.edits), "alpha": self.alpha, "fair": self.fair}

    @classmethod
    def of_document(cls, document: JsonValue) -> SurfacingWork:
        """From JSON; raises InvalidWorkError, and InvalidNetworkError for what is no network."""
        entries = document.entries(("edits", "alpha", "fair"))
        edits, strokes = edits_of(entries["edits"])
        return cls(edits, entries["alpha"].number(), entries["fair"].truth(), strokes)


def _steps(cycles: Sequence[Cycle]) -> list[Steps]:
    return [[[curve, int(back)] for curve, back in cycle.steps] for cycle in cycles]


def _cycle(steps: Steps) -> Cycle:
    return Cycle(tuple((curve, bool(back)) for curve, back in steps))


def _cycles(cycles: Sequence[Steps]) -> tuple[Cycle, ...]:
    return tuple(map(_cycle, cycles))


def _points(points: list[list[float]]) -> Points:
    return np.array(complete_points(points), np.float64).reshape(-1, 3)
