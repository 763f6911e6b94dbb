"""Arcs between singularities: where a separatrix nearly meets another's beginning, one curve.

Without them two traces would run beside each other, a sliver apart, and every sliver costs a row
of quads.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats, Points, units
from patterndb_sketch.retopo.draft.crossfield import CrossField
from patterndb_sketch.retopo.draft.tracing import (
    LineSegments,
    Starts,
    trace_lines,
)
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.tracing import trace_geodesic

#: Separatrices are followed so far, in diagonals.
LONGEST = 0.35

#: One that passes a singularity within this part of its length is led there; and no further off
#: than an edge.
ASIDE = 0.25

#: What is led there heads against one of its directions: the cosine of 41 degrees; and the arc
#: leaves along both, within the cosine of 45 degrees.
HEADING, LEAVING = 0.75, 0.7

#: An arc is at most so many times as long as the trace was.
LONGER = 1.15


@dataclass(frozen=True, slots=True, eq=False)
class Arc:
    """From start ``begin`` to start ``end``, numbers of :class:`Starts`: (n, 3) points, and
    (n - 1,) the triangles between."""

    begin: int
    end: int
    points: Points
    triangles: Int32Array


def find_arcs(field: CrossField, starts: Starts, edge: float) -> list[Arc]:
    """Arcs between starts, the shortest first; they do not cross each other."""
    if not len(starts):
        return []
    mesh = field.mesh
    longest = LONGEST * mesh.surface.diagonal
    traced = trace_lines(field, starts, LineSegments.none(), 0, longest, stopping=False)
    directions = np.array(
        [mesh.lift(int(f), float(a)) for f, a in zip(starts.triangle, starts.angle, strict=True)]
    )
    vertices = np.unique(starts.vertex[starts.vertex >= 0])
    by_vertex = {int(v): np.flatnonzero(starts.vertex == v) for v in vertices}
    wanted = _find_meetings(field, starts, traced.segments, edge, vertices, by_vertex, directions)
    taken: set[int] = set()
    laid = [LineSegments.none()]
    found: list[Arc] = []
    for length, one, two in wanted:
        if one in taken or two in taken:
            continue
        arc = _lay_arc(field, starts, one, two, length, directions)
        if arc is None:
            continue
        pieces = cut_segments(field, arc.points, arc.triangles, len(found))
        if _cross_any(LineSegments.joined(laid), pieces):
            continue
        laid.append(pieces)
        found.append(arc)
        taken |= {one, two}
    return found


def _find_meetings(
    field: CrossField,
    starts: Starts,
    segments: LineSegments,
    edge: float,
    vertices: Int32Array,
    by_vertex: dict[int, np.ndarray],
    directions: Points,
) -> list[tuple[float, int, int]]:
    """Pairs of starts that lead to each other, with the length of the way, shortest first."""
    mesh = field.mesh
    places, up = mesh.vertices[vertices], mesh.surface.normals[vertices]
    begins, ends = segments.lift(mesh, segments.begin), segments.lift(mesh, segments.end)
    normal = mesh.normal[segments.triangle]
    found: dict[tuple[int, int], float] = {}
    for i in range(len(starts)):
        mine = np.flatnonzero(segments.line == i)
        if not len(mine):
            continue
        away = np.linalg.norm(ends[mine][:, None] - places[None], axis=2)
        away[normal[mine] @ up.T < 0.3] = np.inf
        nearest = away.argmin(axis=0)
        for w in range(len(vertices)):
            if vertices[w] == starts.vertex[i]:
                continue
            k = int(nearest[w])
            off = float(away[k, w])
            length = float(segments.along[mine[k]] + segments.reach[mine[k]])
            if off > min(edge, ASIDE * length):
                continue
            heading = units((ends[mine[k]] - begins[mine[k]])[None])[0]
            mates = by_vertex[int(vertices[w])]
            against = -(directions[mates] @ heading)
            best = int(against.argmax())
            if against[best] > HEADING:
                pair = (min(i, int(mates[best])), max(i, int(mates[best])))
                way = length + 2.0 * off
                found[pair] = min(way, found.get(pair, np.inf))
    return sorted((way, one, two) for (one, two), way in found.items())


def _lay_arc(
    field: CrossField, starts: Starts, one: int, two: int, way: float, directions: Points
) -> Arc | None:
    surface = field.mesh.surface
    feet = []
    for k in (one, two):
        weights = np.zeros((1, 3))
        weights[0, starts.corner[k]] = 1.0
        feet.append(surface.at(starts.triangle[k : k + 1], weights))
    try:
        path = trace_geodesic(surface, feet[0], feet[1])
    except RefusedError:
        return None
    if path.length > LONGER * way:
        return None
    points = path.points
    if _touches(field, points, path.triangles):
        return None
    leave = units(np.stack([points[min(2, len(points) - 1)] - points[0]]))[0]
    arrive = units(np.stack([points[-min(3, len(points))] - points[-1]]))[0]
    if leave @ directions[one] < LEAVING or arrive @ directions[two] < LEAVING:
        return None
    return Arc(one, two, points, path.triangles)


def _touches(field: CrossField, points: Points, triangles: Int32Array) -> bool:
    """Does a path pass a singularity on its way, or run along a border?"""
    mesh = field.mesh
    barred = mesh.on_border | (field.index != 0)
    corner = mesh.triangles[triangles]
    for k, row in enumerate(corner):
        for v in row[barred[row]].tolist():
            off = np.linalg.norm(points[k : k + 2] - mesh.vertices[v], axis=1)
            at = off < 1e-6 * mesh.surface.diagonal
            if (at[0] and k > 0) or (at[1] and k + 1 < len(triangles)):
                return True
    return len(triangles) == 1 and bool(mesh.on_border[corner[0]].sum() > 1)


def cut_segments(
    field: CrossField, points: Points, triangles: Int32Array, line: int
) -> LineSegments:
    """A polyline (n, 3) whose pieces lie in triangles (n - 1,), as segments of a line."""
    mesh = field.mesh
    base = mesh.vertices[mesh.triangles[triangles, 0]]

    def flatten(at: Points) -> Floats:
        off = at - base
        return np.stack(
            [
                np.einsum("nc,nc->n", off, mesh.x[triangles]),
                np.einsum("nc,nc->n", off, mesh.y[triangles]),
            ],
            axis=1,
        )

    reach = np.linalg.norm(np.diff(points, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(reach)[:-1]])
    return LineSegments(
        np.full(len(triangles), line, np.int32),
        triangles,
        flatten(points[:-1]),
        flatten(points[1:]),
        along,
        reach,
    )


def _cross_any(laid: LineSegments, pieces: LineSegments) -> bool:
    """Does a new line cross one that is laid, other than where both begin or end?"""
    last = len(pieces.line) - 1
    for k, f in enumerate(pieces.triangle.tolist()):
        near = np.flatnonzero(laid.triangle == f)
        if not len(near):
            continue
        u = pieces.end[k] - pieces.begin[k]
        v = laid.end[near] - laid.begin[near]
        off = laid.begin[near] - pieces.begin[k]
        size = u[0] * v[:, 1] - u[1] * v[:, 0]
        safe = np.where(size == 0.0, 1.0, size)
        t = (off[:, 0] * v[:, 1] - off[:, 1] * v[:, 0]) / safe
        s = (off[:, 0] * u[1] - off[:, 1] * u[0]) / safe
        low = 1e-6 if k == 0 else -1e-9
        high = 1.0 - 1e-6 if k == last else 1.0 + 1e-9
        if ((size != 0.0) & (t > low) & (t < high) & (s > -1e-9) & (s < 1.0 + 1e-9)).any():
            return True
    return False
