"""Networks as plain JSON.

    {"curves": [{"id": "rim", "points": [[0, 0, 0], [1, 0, 0.2], [2, 0, 0]]},
                {"id": 4, "points": [[2, 0, 0], [1, 2, 0]], "stroke": 2}, ...],
     "tolerance": 0.001,
     "cycles": [["rim", 4, 7], [{"curve": 7, "reversed": true}, 5, 6], ...],
     "stages": [["rim"], [4, 7], ...]}

curves: the curves as drawn, each once; id is its place in the list and stroke its id where they
are left out. They meet where
:func:`patterndb_sketch.surfacing.joining.junctions.join_polylines` finds it, within the
tolerance. cycles: the patches, each the ids of its curves in the order of a closed walk;
"reversed" may say the sense, "part" which of the parts that nodes split the curve into, counted
from 0; else :func:`patterndb_sketch.surfacing.naming.named_cycle` finds both. stages: the ids
of the curves drawn in every stage.

With "nodes", a list of points, the file says itself where curves meet: every curve then has
"nodes": [first, second], its ends are moved there, and there is no tolerance. Parts of one
curve share its id. :func:`network_document` writes this form. "source", where the file comes
from, and "bezier", what a curve's points were taken from, may be there and are not needed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from patterndb.geometry.points import Points
from patterndb.system.documents import JsonValue
from patterndb_sketch.surfacing.joining.junctions import join_polylines
from patterndb_sketch.surfacing.joining.polylines import (
    as_curve,
    as_places,
    measure_diagonal,
    move_ends,
)
from patterndb_sketch.surfacing.naming import (
    NamedCurve,
    Step,
    Walks,
    named_cycle,
    parts_of,
    walks_of,
)
from patterndb_sketch.surfacing.network import (
    Curve,
    CurveId,
    CurveNetwork,
    Cycle,
    Drawing,
    InvalidNetworkError,
)

KEYS = ("curves", "cycles", "stages", "tolerance", "nodes", "source")
CURVE_KEYS = ("id", "points", "stroke", "nodes", "bezier")
STEP_KEYS = ("curve", "reversed", "part")

#: Where the file says at which node a curve ends, it may be this far away, as a share of the
#: network's diagonal: beyond it the number of the node is surely wrong.
NEAR_NODE = 1e-3


def drawing_of(document: JsonValue, tolerance: float | None = None) -> Drawing:
    """The drawing in a plain JSON document.

    tolerance: how far apart curves may pass and still meet, instead of the document's.
    Raises InvalidNetworkError that names the place in the document.
    """
    entries = document.entries(KEYS, 'an object such as {"curves": [...]}')
    if "curves" not in entries:
        document.fail('"curves" is missing: a list with the points of every curve')
    if "source" in entries:
        entries["source"].text()
    drawn = entries["curves"].items()
    known = [curve.entries(CURVE_KEYS) for curve in drawn]
    ids = [one["id"].name() if "id" in one else i for i, one in enumerate(known)]
    strokes = [
        one["stroke"].name() if "stroke" in one else name
        for name, one in zip(ids, known, strict=True)
    ]
    polylines = [_points(*one) for one in zip(drawn, known, ids, strict=True)]
    if "nodes" in entries:
        if "tolerance" in entries or tolerance is not None:
            raise InvalidNetworkError(
                'a tolerance has nothing to do where the file has "nodes" and says where curves '
                'meet; leave it out, or "nodes"'
            )
        network = _at_given_nodes(entries["nodes"], drawn, known, polylines, ids, strokes)
        walks: Walks = walks_of(network)
        notes: tuple[str, ...] = ()
    else:
        for one in known:
            if "nodes" in one:
                one["nodes"].fail('there are no "nodes" in the file; add them, or leave this out')
        if tolerance is None and "tolerance" in entries:
            tolerance = entries["tolerance"].number()
        found = join_polylines(polylines, ids=ids, strokes=strokes, tolerance=tolerance)
        network = found.network
        walks = {name: [walk] if walk else [] for name, walk in zip(ids, found.walks, strict=True)}
        notes = found.notes
    cycles = [_cycle(network, cycle, walks) for cycle in _items(entries, "cycles")]
    stages = [_stage(stage, walks) for stage in _items(entries, "stages")]
    return Drawing(CurveNetwork(network.curves, network.nodes, tuple(cycles)), tuple(stages), notes)


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


def _points(curve: JsonValue, entries: dict[str, JsonValue], name: CurveId) -> Points:
    if "points" not in entries:
        curve.fail('"points" is missing: the curve as drawn')
    points = entries["points"].polyline()
    try:
        return as_curve(points, f"curve {name!r}")
    except InvalidNetworkError as error:
        raise InvalidNetworkError(f"{curve.where}: {error}") from None


def _at_given_nodes(
    nodes: JsonValue,
    drawn: Sequence[JsonValue],
    known: Sequence[dict[str, JsonValue]],
    polylines: list[Points],
    ids: Sequence[CurveId],
    strokes: Sequence[CurveId],
) -> CurveNetwork:
    places = as_places(np.array(nodes.points(), np.float64).reshape(-1, 3), "the list of nodes")
    reach = NEAR_NODE * measure_diagonal(polylines)
    curves: list[Curve] = []
    for curve, entries, points, name, stroke in zip(
        drawn, known, polylines, ids, strokes, strict=True
    ):
        if "nodes" not in entries:
            curve.fail('"nodes" is missing: the numbers of the nodes where the curve ends')
        ends = entries["nodes"].items()
        if len(ends) != 2:
            entries["nodes"].refuse("a pair of nodes [first, second]")
        first, last = (_node(end, len(places)) for end in ends)
        for end, node, point in ((ends[0], first, points[0]), (ends[1], last, points[-1])):
            gap = float(np.linalg.norm(places[node] - point))
            if gap > reach:
                end.fail(
                    f"the curve ends {gap:.3g} away from node {node}; name the node where it ends"
                )
        points = move_ends(points, places[first], places[last])
        if len(points) < 2:
            curve.fail("nothing is left of the curve between its nodes; leave it out")
        curves.append(Curve(points, (first, last), name, stroke))
    return CurveNetwork(tuple(curves), places)


def _node(value: JsonValue, n_nodes: int) -> int:
    node = value.whole("the number of a node")
    if not 0 <= node < n_nodes:
        value.fail(f"there is no node {node}; the file has {n_nodes}, counted from 0")
    return node


def _cycle(network: CurveNetwork, cycle: JsonValue, walks: Walks) -> Cycle:
    names = [_named(step) for step in cycle.items("a list of curve ids")]
    try:
        return named_cycle(network, names, walks)
    except InvalidNetworkError as error:
        raise InvalidNetworkError(f"{cycle.where}: {error}") from None


def _named(step: JsonValue) -> NamedCurve:
    if not step.is_object:
        return NamedCurve(step.name("the id of a curve"))
    entries = step.entries(STEP_KEYS)
    if "curve" not in entries:
        step.fail('"curve" is missing: the id of the curve')
    return NamedCurve(
        entries["curve"].name("the id of a curve"),
        entries["reversed"].truth() if "reversed" in entries else None,
        entries["part"].whole("the number of a part") if "part" in entries else None,
    )


def _stage(stage: JsonValue, walks: Walks) -> tuple[int, ...]:
    drawn: list[int] = []
    for name in stage.items("a list of curve ids"):
        of_id = name.name("the id of a curve")
        if of_id not in walks:
            name.fail(f"there is no curve {of_id!r}; name curves by their ids")
        drawn += [curve for walk in walks[of_id] for curve, _ in walk]
    return tuple(dict.fromkeys(drawn))


def _items(entries: dict[str, JsonValue], key: str) -> list[JsonValue]:
    return entries[key].items() if key in entries else []


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
