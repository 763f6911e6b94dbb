"""Stroke graphs of CASSIE, sketches drawn in virtual reality (Yu et al. 2021).

    {"strokes": [{"id": 2, "segments": [0, 1]}, ...],
     "segments": [{"id": 0, "stroke_id": 2, "ctrl_pts": [[[x, y, z], ...], ...],
                   "nodes": [0, 1]}, ...],
     "nodes": [{"id": 0, "position": [x, y, z], "neighbor_edges": [0, 4]}, ...],
     "patches_created": [{"id": 0, "by_algorithm": true, "manually_deleted": false,
                          "strokes": [2, 3, 5]}, ...]}

A segment is what lies of a stroke between two nodes: cubic Beziers in a row, or a straight line
with two points. It becomes a curve, the stroke its stroke. Where curves meet is found as in any
other drawing: the nodes of the file leave out many places where strokes meet. Strokes were drawn in
the order of their numbers: each is a stage.
"""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from patterndb.geometry.points import Points
from patterndb.system.documents import JsonValue
from patterndb_sketch.curvenetwork.drawing import Drawing
from patterndb_sketch.curvenetwork.joining import join_polylines
from patterndb_sketch.curvenetwork.network import InvalidNetworkError
from patterndb_sketch.curvenetwork.polylines import SAME_PLACE, as_places, measure_diagonal
from patterndb_sketch.surfacing.files.splines import polylines_of

KEYS = ("strokes", "segments", "nodes", "patches_created")
STROKE_KEYS = ("id", "segments")
SEGMENT_KEYS = ("id", "stroke_id", "ctrl_pts", "nodes")
NODE_KEYS = ("id", "position", "neighbor_edges")
PATCH_KEYS = ("id", "by_algorithm", "manually_deleted", "strokes")

#: Segments end this close to their nodes, as a share of the sketch's diagonal: the data set has
#: up to 0.0017. Beyond it the node is surely another one.
NEAR_NODE = 1e-2


@dataclass(frozen=True, slots=True)
class RecordedPatch:
    """A patch that was made while the sketch was drawn.

    number:           its number in the session.
    strokes:          the strokes around it, in order; some may not be in the final sketch.
    by_algorithm:     found by the program, not by the user.
    manually_deleted: deleted by the user later. What the program deleted is not recorded.
    """

    number: int
    strokes: tuple[int, ...]
    by_algorithm: bool
    manually_deleted: bool


def is_stroke_graph(document: JsonValue) -> bool:
    """Is it a stroke graph, right or wrong, rather than another document?"""
    return document.is_object and "segments" in document.entries()


@dataclass(frozen=True, slots=True)
class _Segment:
    entry: JsonValue
    name: int
    stroke: int
    nodes: tuple[int, int]
    points: Points


def stroke_graph_drawing(document: JsonValue, tolerance: float | None = None) -> Drawing:
    """Return the drawing in a stroke graph; curves are named by their segments' ids.

    tolerance: how far apart curves may pass and still meet; by default it follows from the drawing.
    A segment without length is left out. Raises InvalidNetworkError that names the place in the
    document.
    """
    entries = document.entries(KEYS)
    numbers: dict[int, int] = {}
    places: list[list[float]] = []
    for node in _listed(document, entries, "nodes"):
        values = _all(node, NODE_KEYS, optional=("neighbor_edges",))
        numbers[_new(values["id"], numbers)] = len(places)
        places.append(values["position"].point())
    nodes = as_places(np.array(places, np.float64).reshape(-1, 3), "the list of nodes")
    strokes: dict[int, list[int]] = {}
    for stroke in _listed(document, entries, "strokes"):
        strokes[_new(_all(stroke, STROKE_KEYS, optional=("segments",))["id"], strokes)] = []
    segments = _segments(_listed(document, entries, "segments"), numbers, strokes)
    diagonal = measure_diagonal([segment.points for segment in segments])
    for segment in segments:
        _check_ends(segment, nodes, NEAR_NODE * diagonal)
    kept = [segment for segment in segments if _extent(segment) > SAME_PLACE * diagonal]
    found = join_polylines(
        [segment.points for segment in kept],
        [segment.name for segment in kept],
        [segment.stroke for segment in kept],
        tolerance,
    )
    for number, curve in enumerate(found.network.curves):
        assert isinstance(curve.stroke, int)
        strokes[curve.stroke].append(number)
    notes = tuple(
        f"segment {segment.name} has no length and was left out"
        for segment in segments
        if _extent(segment) <= SAME_PLACE * diagonal
    )
    stages = tuple(tuple(strokes[stroke]) for stroke in sorted(strokes))
    return Drawing(found.network, stages, (*notes, *found.notes), found.joins, found.loose)


def recorded_patches(document: JsonValue) -> tuple[RecordedPatch, ...]:
    """The patches in a stroke graph's record, in the order they were made.

    Raises InvalidNetworkError that names the place in the document.
    """
    patches: list[RecordedPatch] = []
    for patch in _listed(document, document.entries(KEYS), "patches_created"):
        values = _all(patch, PATCH_KEYS)
        patches.append(
            RecordedPatch(
                values["id"].whole(),
                tuple(stroke.whole() for stroke in values["strokes"].items()),
                values["by_algorithm"].truth(),
                values["manually_deleted"].truth(),
            )
        )
    return tuple(patches)


def _segments(
    listed: Sequence[JsonValue], nodes: Mapping[int, int], strokes: Container[int]
) -> list[_Segment]:
    names: set[int] = set()
    found: list[tuple[JsonValue, int, int, tuple[int, int]]] = []
    beziers: list[Points] = []
    for entry in listed:
        values = _all(entry, SEGMENT_KEYS)
        name = _new(values["id"], names)
        names.add(name)
        stroke = values["stroke_id"].whole("the id of a stroke")
        if stroke not in strokes:
            values["stroke_id"].fail(f"there is no stroke {stroke}")
        found.append((entry, name, stroke, _ends(values["nodes"], nodes)))
        beziers.append(_beziers(values["ctrl_pts"]))
    if not found:
        return []
    # All at once: that takes a hundredth of the time.
    chain = np.repeat(np.arange(len(beziers)), list(map(len, beziers)))
    lines = polylines_of(np.concatenate(beziers), chain)
    return [_Segment(*one, points) for one, points in zip(found, lines, strict=True)]


def _beziers(control: JsonValue) -> Points:
    """(m, 4, 3) control points of cubic Beziers; a line is one of them."""
    pieces = [piece.points() for piece in control.items()]
    if len(pieces) == 1 and len(pieces[0]) == 2:
        first, last = np.array(pieces[0])
        pieces = [[first, first + (last - first) / 3, last + (first - last) / 3, last]]
    elif not pieces or any(len(piece) != 4 for piece in pieces):
        control.fail("give one line of 2 points, or cubic Beziers of 4 control points each")
    beziers = np.array(pieces, np.float64)
    try:
        as_places(beziers.reshape(-1, 3), "the segment")
    except InvalidNetworkError as error:
        raise InvalidNetworkError(f"{control.where}: {error}") from None
    return beziers


def _ends(pair: JsonValue, nodes: Mapping[int, int]) -> tuple[int, int]:
    names = pair.items()
    if len(names) != 2:
        pair.refuse("a pair of nodes [first, second]")
    for name in names:
        if name.whole("the id of a node") not in nodes:
            name.fail(f"there is no node {name.value}; name a node by its id")
    return nodes[names[0].whole()], nodes[names[1].whole()]


def _check_ends(segment: _Segment, nodes: Points, reach: float) -> None:
    for node, point in zip(segment.nodes, segment.points[[0, -1]], strict=True):
        gap = float(np.linalg.norm(nodes[node] - point))
        if gap > reach:
            segment.entry.fail(
                f"the segment ends {gap:.3g} away from its node at "
                f"{', '.join(f'{x:.4g}' for x in nodes[node])}; name the node where it ends"
            )


def _extent(segment: _Segment) -> float:
    return float(np.linalg.norm(np.ptp(segment.points, axis=0)))


def _listed(document: JsonValue, entries: dict[str, JsonValue], key: str) -> list[JsonValue]:
    if key not in entries:
        document.fail(f'"{key}" is missing: a stroke graph has a list of them')
    return entries[key].items()


def _all(
    value: JsonValue, keys: tuple[str, ...], optional: tuple[str, ...] = ()
) -> dict[str, JsonValue]:
    entries = value.entries(keys)
    for key in keys:
        if key not in entries and key not in optional:
            value.fail(f'"{key}" is missing; entries are {", ".join(keys)}')
    return entries


def _new(name: JsonValue, known: Container[int]) -> int:
    number = name.whole("a whole number")
    if number in known:
        name.fail(f"the id {number} is there twice; give each its own")
    return number
