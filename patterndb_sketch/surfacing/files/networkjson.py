"""Networks as plain JSON.

    {"curves": [{"id": "rim", "points": [[0, 0, 0], [1, 0, 0.2], [2, 0, 0]],
                 "normals": [[0, 0, 1], [0, 0.1, 1], [0, 0, 1]]},
                {"id": 4, "points": [[2, 0, 0], [1, 2, 0]], "stroke": 2}, ...],
     "tolerance": 0.001,
     "cycles": [["rim", 4, 7], [{"curve": 7, "reversed": true}, 5, 6], ...],
     "stages": [["rim"], [4, 7], ...]}

curves: the curves as drawn, each once; id is its place in the list and stroke its id where they
are left out; normals, where a program knows them, are those of the surface at the points. Curves
meet where :func:`patterndb_sketch.curvenetwork.joining.join_polylines` finds it, within the
tolerance, or if there is none within one that follows from the drawing.
cycles: the patches, each the ids of its curves in the order of a closed walk;
"reversed" may say the sense, "part" which of the parts that nodes split the curve into, counted
from 0; else :func:`patterndb_sketch.curvenetwork.naming.named_cycle` finds both. stages: the ids
of the curves drawn in every stage.

With "nodes", a list of points, the file says itself where curves meet: every curve then has
"nodes": [first, second], its ends are moved there, and there is no tolerance. Parts of one
curve share its id. :func:`network_document` writes this form. "source", where the file comes
from, and "bezier", what a curve's points were taken from, may be there and are not needed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

import numpy as np
from msgspec import UNSET, Meta, UnsetType, field

from patterndb.geometry.points import Points
from patterndb.system.documents import (
    JsonModel,
    JsonValue,
    Name,
    Number,
    Point,
    Polyline,
    complete_points,
)
from patterndb_sketch.curvenetwork.drawing import Drawing
from patterndb_sketch.curvenetwork.joining import JoinedCurves, join_polylines
from patterndb_sketch.curvenetwork.naming import (
    NamedCurve,
    Walks,
    list_parts,
    named_cycle,
    parts_of,
    walks_of,
)
from patterndb_sketch.curvenetwork.network import (
    Curve,
    CurveId,
    CurveNetwork,
    Cycle,
    InvalidNetworkError,
    Step,
)
from patterndb_sketch.curvenetwork.normals import as_normals, carry_normals
from patterndb_sketch.curvenetwork.polylines import as_curve, as_places, measure_diagonal, move_ends

#: Where the file says at which node a curve ends, it may be this far away, as a share of the
#: network's diagonal: beyond it the number of the node is surely wrong.
NEAR_NODE = 1e-3


Nodes = Annotated[
    tuple[int, int], Meta(extra={"length": "a list is not a pair of nodes [first, second]"})
]
CurveName = Annotated[int | str, Meta(description="the id of a curve")]


class CurveEntries(JsonModel):
    points: Annotated[Polyline, Meta(extra={"missing": "the curve as drawn"})]
    id: Name | UnsetType = UNSET
    stroke: Name | UnsetType = UNSET
    nodes: Nodes | UnsetType = UNSET
    normals: list[Point] | UnsetType = UNSET
    bezier: Any = None


class StepEntries(JsonModel):
    curve: Annotated[CurveName, Meta(extra={"missing": "the id of the curve"})]
    reversed: bool | UnsetType = UNSET
    part: Annotated[int, Meta(description="the number of a part")] | UnsetType = UNSET


class CurveNetworkEntries(JsonModel):
    curves: Annotated[
        list[CurveEntries], Meta(extra={"missing": "a list with the points of every curve"})
    ]
    cycles: list[list[CurveName | StepEntries]] = field(default_factory=list)
    stages: list[list[CurveName]] = field(default_factory=list)
    tolerance: Number | UnsetType = UNSET
    nodes: list[Point] | UnsetType = UNSET
    source: str = ""


def drawing_of(document: JsonValue, tolerance: float | None = None) -> Drawing:
    """Return the drawing in a plain JSON document.

    tolerance: how far apart curves may pass and still meet, instead of the document's.
    Raises InvalidNetworkError that names the place in the document.
    """
    entries = document.read(CurveNetworkEntries, 'an object such as {"curves": [...]}')
    drawn = entries.curves
    ids = [i if one.id is UNSET else one.id for i, one in enumerate(drawn)]
    strokes = [
        name if one.stroke is UNSET else one.stroke for name, one in zip(ids, drawn, strict=True)
    ]
    polylines: list[Points] = []
    known: list[tuple[Points, Points | None]] = []
    for i, (one, name) in enumerate(zip(drawn, ids, strict=True)):
        with document.at("curves", i).named():
            points = complete_points(one.points)
            polylines.append(as_curve(points, f"curve {name!r}"))
            if one.normals is UNSET:
                known.append((polylines[-1], None))
            else:
                normals = as_normals(complete_points(one.normals), points, f"curve {name!r}")
                known.append((np.array(points, np.float64), normals))
    if entries.nodes is not UNSET:
        if entries.tolerance is not UNSET or tolerance is not None:
            raise InvalidNetworkError(
                'a tolerance has nothing to do where the file has "nodes" and says where curves '
                'meet; leave it out, or "nodes"'
            )
        network = _at_given_nodes(document, entries.nodes, drawn, polylines, ids, strokes)
        network = carry_normals(network, known, [[(i, False)] for i in range(len(known))])
        walks: Walks = walks_of(network)
        found = JoinedCurves(network, ())
    else:
        for i, one in enumerate(drawn):
            if one.nodes is not UNSET:
                document.at("curves", i, "nodes").fail(
                    'there are no "nodes" in the file; add them, or leave this out'
                )
        if tolerance is None and entries.tolerance is not UNSET:
            tolerance = entries.tolerance
        found = join_polylines(polylines, ids=ids, strokes=strokes, tolerance=tolerance)
        network = carry_normals(found.network, known, found.walks)
        walks = {name: [walk] if walk else [] for name, walk in zip(ids, found.walks, strict=True)}
    cycles: list[Cycle] = []
    for i, cycle in enumerate(entries.cycles):
        with document.at("cycles", i).named():
            cycles.append(named_cycle(network, [_named(step) for step in cycle], walks))
    parts = list_parts(network, ids)
    stages = [
        _stage(document.at("stages", i), stage, parts) for i, stage in enumerate(entries.stages)
    ]
    whole = CurveNetwork(network.curves, network.nodes, tuple(cycles))
    return Drawing(whole, tuple(stages), found.notes, found.joins, found.loose)


def network_document(
    network: CurveNetwork, stages: Sequence[Sequence[int]] = ()
) -> dict[str, object]:
    """The network, its cycles and maybe stages (numbers of curves) as plain JSON has them.

    :func:`drawing_of` gives the same back, bit for bit. Raises InvalidNetworkError for stages
    that part what one id names.
    """
    parts = parts_of(network)
    document: dict[str, object] = {
        "nodes": network.nodes.tolist(),
        "curves": [
            {
                "id": curve.id,
                "stroke": curve.stroke,
                "nodes": list(curve.nodes),
                "points": curve.points.tolist(),
                **({} if curve.normals is None else {"normals": curve.normals.tolist()}),
            }
            for curve in network.curves
        ],
    }
    if network.cycles:
        document["cycles"] = [
            [_step_document(network, step, parts) for step in cycle.steps]
            for cycle in network.cycles
        ]
    if stages:
        document["stages"] = [_stage_document(network, stage) for stage in stages]
    return document


def _at_given_nodes(
    document: JsonValue,
    nodes: list[list[float]],
    drawn: Sequence[CurveEntries],
    polylines: list[Points],
    ids: Sequence[CurveId],
    strokes: Sequence[CurveId],
) -> CurveNetwork:
    places = np.array(complete_points(nodes), np.float64).reshape(-1, 3)
    places = as_places(places, "the list of nodes")
    reach = NEAR_NODE * measure_diagonal(polylines)
    curves: list[Curve] = []
    for i, (one, points, name, stroke) in enumerate(
        zip(drawn, polylines, ids, strokes, strict=True)
    ):
        place = document.at("curves", i)
        if one.nodes is UNSET:
            place.fail('"nodes" is missing: the numbers of the nodes where the curve ends')
        for k, (node, point) in enumerate(zip(one.nodes, points[[0, -1]], strict=True)):
            end = place.at("nodes", k)
            if not 0 <= node < len(places):
                end.fail(f"there is no node {node}; the file has {len(places)}, counted from 0")
            gap = float(np.linalg.norm(places[node] - point))
            if gap > reach:
                end.fail(
                    f"the curve ends {gap:.3g} away from node {node}; name the node where it ends"
                )
        first, last = one.nodes
        points = move_ends(points, places[first], places[last])
        if len(points) < 2:
            place.fail("nothing is left of the curve between its nodes; leave it out")
        curves.append(Curve(points, (first, last), name, stroke))
    return CurveNetwork(tuple(curves), places)


def _named(step: CurveId | StepEntries) -> NamedCurve:
    if not isinstance(step, StepEntries):
        return NamedCurve(step)
    backward = None if step.reversed is UNSET else step.reversed
    return NamedCurve(step.curve, backward, None if step.part is UNSET else step.part)


def _stage(
    place: JsonValue, names: list[CurveId], parts: dict[CurveId, list[int]]
) -> tuple[int, ...]:
    drawn: list[int] = []
    for i, name in enumerate(names):
        if name not in parts:
            place.at(i).fail(f"there is no curve {name!r}; name curves by their ids")
        drawn += parts[name]
    return tuple(dict.fromkeys(drawn))


def _step_document(network: CurveNetwork, step: Step, parts: list[int | None]) -> dict[str, object]:
    curve, backward = step
    document: dict[str, object] = {"curve": network.curves[curve].id, "reversed": backward}
    if parts[curve] is not None:
        document["part"] = parts[curve]
    return document


def _stage_document(network: CurveNetwork, stage: Sequence[int]) -> list[CurveId]:
    names = list(dict.fromkeys(network.curves[curve].id for curve in stage))
    whole = {i for i, curve in enumerate(network.curves) if curve.id in names}
    if whole != set(stage):
        raise InvalidNetworkError(
            "a stage has some parts of a curve and not the others; a file names whole curves"
        )
    return names
