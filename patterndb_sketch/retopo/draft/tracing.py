"""Trace separatrices of a cross field over a mesh, each until it meets another: a motorcycle graph.

After Eppstein, Goodrich, Kim and Tamstorf 2008, "Motorcycle Graphs": all traces set out at once and
run equally fast; one that comes to where another has been stops there, in a T-junction
(:func:`trace_lines`). Before, where a separatrix nearly meets another's beginning, the two become
one curve between singularities, an arc (:func:`find_arcs`): else two traces would run next to each
other, a sliver apart, and every sliver costs a row of quads.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb._native.retopo.draft.tracing import trace_all
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats, Points, units
from patterndb_sketch.retopo.draft.crossfield import QUARTER, CrossField
from patterndb_sketch.retopo.draft.frames import TangentFrames
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.tracing import trace_geodesic

#: How a trace ended: at another line (its number is told), at a border, or where it was cut off.
AT_LINE, AT_BORDER, CUT_OFF = 0, 1, 2

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
class Starts:
    """Where traces begin: (n,) vertices, (n,) triangles, (n,) corners of these that the vertices
    are, (n, 2) places in their frames, (n,) angles there, and (n,) directions of the cross, 0 to 3
    and beyond, that are nearest to them.
    """

    vertex: Int32Array
    triangle: Int32Array
    corner: Int32Array
    place: Floats
    angle: Floats
    direction: Int32Array

    def __len__(self) -> int:
        return len(self.vertex)

    def __getitem__(self, which: NDArray[np.intp]) -> Starts:
        return Starts(
            self.vertex[which],
            self.triangle[which],
            self.corner[which],
            self.place[which],
            self.angle[which],
            self.direction[which],
        )


def list_separatrices(field: CrossField, vertex: int) -> list[tuple[int, int, float]]:
    """The directions of the field that leave a vertex, counter-clockwise: triangle, corner, angle.

    An inner vertex has exactly 4 - index of them, a border's vertex 1 - index within. Around the
    vertex the field's turning is spread evenly over triangles, as the matchings say; where it
    turns back, the first of equals counts.
    """
    mesh = field.mesh
    ring = mesh.list_ring(vertex)
    # How far the direction of a side is from the field's, unrolled.
    first = mesh.side_angle.ravel()[ring[0]] - field.angle[ring[0] // 3]
    level = [float(first)]
    end = float(first)
    for k, side in enumerate(ring):
        f, e = divmod(side, 3)
        end += float(mesh.corner_angle[f, e])
        before = 3 * f + (e + 2) % 3
        g = int(mesh.across[before])
        gap = 0.0
        if g >= 0:
            gap = float(
                field.angle[g // 3]
                - field.angle[f]
                - mesh.turn[before]
                - QUARTER * field.quarters[before]
            )
        if k == len(ring) - 1:
            if g >= 0:
                # All the way round: the first value again, shifted as the last one is.
                level[0] += 0.5 * gap
            level.append(end - 0.5 * gap)
        else:
            level.append(end - 0.5 * gap)
            end -= gap
    levels = np.maximum.accumulate(np.array(level))
    if mesh.on_border[vertex]:
        # The border's own directions are the field's.
        low = int(np.rint(level[0] / QUARTER)) + 1
        high = int(np.rint(level[-1] / QUARTER)) - 1
    else:
        count = 4 - int(field.index[vertex])
        low = int(np.ceil(levels[0] / QUARTER - 1e-9))
        high = low + count - 1
    found: list[tuple[int, int, float]] = []
    for step in range(low, high + 1):
        wanted = step * QUARTER
        j = int(np.searchsorted(levels, wanted, side="left")) - 1
        j = min(max(j, 0), len(ring) - 1)
        room = levels[j + 1] - levels[j]
        share = (wanted - levels[j]) / room if room > 0.0 else 0.5
        f, e = divmod(ring[j], 3)
        turned = min(max(share, 0.02), 0.98) * mesh.corner_angle[f, e]
        found.append((f, e, float(mesh.side_angle[f, e] + turned)))
    return found


def start_at_vertices(field: CrossField, vertices: list[int]) -> Starts:
    """Starts of all separatrices of some vertices."""
    rows = [(v, f, e, angle) for v in vertices for f, e, angle in list_separatrices(field, v)]
    vertex = np.array([row[0] for row in rows], np.int32)
    triangle = np.array([row[1] for row in rows], np.int32)
    corner = np.array([row[2] for row in rows], np.int32)
    angle = np.array([row[3] for row in rows], np.float64)
    return Starts(
        vertex,
        triangle,
        corner,
        field.mesh.flat[triangle, corner].reshape(-1, 2),
        angle,
        np.rint((angle - field.angle[triangle]) / QUARTER).astype(np.int32),
    )


@dataclass(frozen=True, slots=True, eq=False)
class LineSegments:
    """Pieces of lines within triangles, in the order in which they were laid.

    line: (s,) whose. triangle: (s,). begin, end: (s, 2) in the triangle's frame. along: (s,) how
    far along its line it begins, and reach: (s,) how long it is in the same measure.
    """

    line: Int32Array
    triangle: Int32Array
    begin: Floats
    end: Floats
    along: Floats
    reach: Floats

    @classmethod
    def none(cls) -> LineSegments:
        """No segments."""
        empty, flat = np.empty(0, np.int32), np.empty((0, 2))
        return cls(empty, empty.copy(), flat, flat.copy(), np.empty(0), np.empty(0))

    @classmethod
    def joined(cls, parts: list[LineSegments]) -> LineSegments:
        """Several as one."""
        return cls(
            np.concatenate([one.line for one in parts]).astype(np.int32),
            np.concatenate([one.triangle for one in parts]).astype(np.int32),
            np.concatenate([one.begin for one in parts]),
            np.concatenate([one.end for one in parts]),
            np.concatenate([one.along for one in parts]),
            np.concatenate([one.reach for one in parts]),
        )

    def lift(self, mesh: TangentFrames, places: Floats) -> Points:
        """(s, 3) places in the segments' triangles, in space."""
        f = self.triangle
        base = mesh.vertices[mesh.triangles[f, 0]]
        return base + places[:, :1] * mesh.x[f] + places[:, 1:] * mesh.y[f]


@dataclass(frozen=True, slots=True, eq=False)
class TracedLines:
    """What tracing came to; all arrays are by trace.

    segments: of all traces, each trace's in order; their line is ``first`` + the trace's number.
    ended:    (n,) how; see AT_LINE. length: (n,) of each.
    other:    (n,) the line that it met, or the border's side. there: (n,) how far along that.
    left:     (n,) bool, did it come from the left of what it met?
    """

    segments: LineSegments
    ended: Int32Array
    length: Floats
    other: Int32Array
    there: Floats
    left: NDArray[np.bool_]


def trace_lines(
    field: CrossField,
    starts: Starts,
    walls: LineSegments,
    first: int,
    longest: float,
    stopping: bool = True,
) -> TracedLines:
    """Trace from all starts at once; the shortest trace makes the next step.

    walls:    lines that are there already, at which traces stop. first: the number of the first
              trace as a line; walls have lower ones.
    longest:  where a trace is cut off. stopping: do traces stop at lines? Else only at borders.
    """
    mesh = field.mesh
    out = trace_all(
        mesh.flat,
        mesh.side_angle,
        mesh.across,
        field.angle,
        field.quarters,
        starts.triangle,
        starts.corner,
        starts.place,
        starts.angle,
        starts.direction,
        walls.line,
        walls.triangle,
        walls.begin,
        walls.end,
        walls.along,
        walls.reach,
        first,
        longest,
        stopping,
    )
    line, triangle, begin, end, along, reach, ended, length, other, there, left = out
    new = slice(len(walls.line), None)
    order = np.lexsort((along[new], line[new]))
    segments = LineSegments(
        line[new][order],
        triangle[new][order],
        begin[new][order],
        end[new][order],
        along[new][order],
        reach[new][order],
    )
    return TracedLines(segments, ended, length, other, there, left)


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
