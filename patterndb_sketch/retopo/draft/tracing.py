"""Trace separatrices of a cross field over a mesh, each until it meets another: a motorcycle graph.

After Eppstein, Goodrich, Kim and Tamstorf 2008, "Motorcycle Graphs": all traces set out at once and
run equally fast; one that comes to where another has been stops there, in a T-junction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats, Points
from patterndb.system.kernels import kernel
from patterndb_sketch.retopo.draft.crossfield import QUARTER, CrossField
from patterndb_sketch.retopo.draft.fieldmesh import FieldMesh
from patterndb_sketch.retopo.ground.heap import grown, pop, push

#: How a trace ended: at another line (its number is told), at a border, or where it was cut off.
AT_LINE, AT_BORDER, CUT_OFF = 0, 1, 2

#: Traces keep this part of a side's length from its ends, and go into a triangle at this angle at
#: least, so that none runs into a vertex or along a side.
OFF_ENDS, LEAST_ANGLE = 1e-3, 0.03

#: A trace has so many steps at most: one that needs more turns round in a spike.
MOST_STEPS = 6000


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

    def lift(self, mesh: FieldMesh, places: Floats) -> Points:
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
    out = _trace_all(
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


@kernel
def _trace_all(
    flat: Floats,
    side_angle: Floats,
    across: Int32Array,
    angle: Floats,
    quarters: Int32Array,
    start_triangle: Int32Array,
    start_corner: Int32Array,
    start_place: Floats,
    start_angle: Floats,
    start_direction: Int32Array,
    wall_line: Int32Array,
    wall_triangle: Int32Array,
    wall_begin: Floats,
    wall_end: Floats,
    wall_along: Floats,
    wall_reach: Floats,
    first: int,
    longest: float,
    stopping: bool,
) -> tuple[
    Int32Array,
    Int32Array,
    Floats,
    Floats,
    Floats,
    Floats,
    Int32Array,
    Floats,
    Int32Array,
    Floats,
    NDArray[np.bool_],
]:
    """:func:`trace_lines` on flat arrays."""
    n = len(start_triangle)
    room = len(wall_line) + 64 * n + 1024
    line = np.empty(room, np.int32)
    triangle = np.empty(room, np.int32)
    begin = np.empty((room, 2))
    end = np.empty((room, 2))
    along = np.empty(room)
    reach = np.empty(room)
    following = np.empty(room, np.int32)
    head = np.full(len(angle), -1, np.int32)
    count = 0
    for w in range(len(wall_line)):
        line[count], triangle[count] = wall_line[w], wall_triangle[w]
        begin[count], end[count] = wall_begin[w], wall_end[w]
        along[count], reach[count] = wall_along[w], wall_reach[w]
        following[count] = head[wall_triangle[w]]
        head[wall_triangle[w]] = count
        count += 1
    ended = np.full(n, CUT_OFF, np.int32)
    length = np.zeros(n)
    other = np.full(n, -1, np.int32)
    there = np.zeros(n)
    left = np.zeros(n, np.bool_)
    at_triangle = start_triangle.copy()
    at_place = start_place.copy()
    at_angle = start_angle.copy()
    at_direction = start_direction.copy()
    entry = np.full(n, -1, np.int32)
    steps = np.zeros(n, np.int32)
    keys = np.empty(n + 16)
    items = np.empty(n + 16, np.int32)
    held = 0
    for i in range(n):
        held = push(keys, items, held, 0.0, i)
    while held:
        i = items[0]
        held = pop(keys, items, held)
        f = at_triangle[i]
        px, py = at_place[i, 0], at_place[i, 1]
        dx, dy = np.cos(at_angle[i]), np.sin(at_angle[i])
        # The side by which the trace leaves.
        far, share, out = np.inf, 0.0, -1
        for e in range(3):
            if e == entry[i]:
                continue
            if steps[i] == 0 and e != (start_corner[i] + 1) % 3:
                continue
            ax, ay = flat[f, e, 0], flat[f, e, 1]
            wx, wy = flat[f, (e + 1) % 3, 0] - ax, flat[f, (e + 1) % 3, 1] - ay
            size = dx * wy - dy * wx
            if size == 0.0:
                continue
            t = ((ax - px) * wy - (ay - py) * wx) / size
            s = ((ax - px) * dy - (ay - py) * dx) / size
            if t > 0.0 and -1e-6 <= s <= 1.0 + 1e-6 and t < far:
                far, share, out = t, s, e
        if out < 0 or steps[i] >= MOST_STEPS:
            continue
        share = min(max(share, OFF_ENDS), 1.0 - OFF_ENDS)
        ax, ay = flat[f, out, 0], flat[f, out, 1]
        bx, by = flat[f, (out + 1) % 3, 0], flat[f, (out + 1) % 3, 1]
        qx, qy = ax + share * (bx - ax), ay + share * (by - ay)
        ux, uy = qx - px, qy - py
        step = np.sqrt(ux * ux + uy * uy)
        if step == 0.0:
            continue
        cut, found = np.inf, -1
        if stopping:
            k = head[f]
            while k >= 0:
                mine = line[k] == first + i
                # What a trace has just left behind itself is not met.
                skip = mine and length[i] - along[k] < 8.0 * step
                if not skip:
                    vx, vy = end[k, 0] - begin[k, 0], end[k, 1] - begin[k, 1]
                    size = ux * vy - uy * vx
                    if size != 0.0:
                        ox, oy = begin[k, 0] - px, begin[k, 1] - py
                        t = (ox * vy - oy * vx) / size
                        s = (ox * uy - oy * ux) / size
                        # Beginnings at one vertex touch there, and do not meet.
                        least = 1e-6 if steps[i] == 0 else -1e-9
                        if least <= t <= 1.0 + 1e-9 and -1e-6 <= s <= 1.0 + 1e-6 and t < cut:
                            cut, found = t, k
                            there[i] = along[k] + min(max(s, 0.0), 1.0) * reach[k]
                            left[i] = size > 0.0
                k = following[k]
        if found >= 0:
            cut = max(cut, 0.0)
            qx, qy = px + cut * ux, py + cut * uy
            step *= cut
        if count == room:
            room *= 2
            line, triangle, following = _more(line), _more(triangle), _more(following)
            begin, end = _more_rows(begin), _more_rows(end)
            along, reach = _more_floats(along), _more_floats(reach)
        line[count], triangle[count] = first + i, f
        begin[count, 0], begin[count, 1] = px, py
        end[count, 0], end[count, 1] = qx, qy
        along[count], reach[count] = length[i], step
        following[count] = head[f]
        head[f] = count
        count += 1
        length[i] += step
        steps[i] += 1
        if found >= 0:
            ended[i] = AT_LINE
            other[i] = line[found]
            continue
        h = 3 * f + out
        if across[h] < 0:
            ended[i] = AT_BORDER
            other[i] = h
            there[i] = share
            continue
        if length[i] > longest:
            continue
        g, into = across[h] // 3, across[h] % 3
        at_direction[i] -= quarters[h]
        turned = angle[g] + at_direction[i] * (np.pi / 2.0)
        over = (turned - side_angle[g, into]) % (2.0 * np.pi)
        if not LEAST_ANGLE < over < np.pi - LEAST_ANGLE:
            flat_on = over < np.pi / 2.0 or over > 1.5 * np.pi
            turned = side_angle[g, into] + (LEAST_ANGLE if flat_on else np.pi - LEAST_ANGLE)
        at_triangle[i] = g
        at_angle[i] = turned
        entry[i] = into
        ax, ay = flat[g, into, 0], flat[g, into, 1]
        bx, by = flat[g, (into + 1) % 3, 0], flat[g, (into + 1) % 3, 1]
        at_place[i, 0], at_place[i, 1] = bx + share * (ax - bx), by + share * (ay - by)
        if held == len(keys):
            keys, items = grown(keys, items)
        held = push(keys, items, held, length[i], i)
    return (
        line[:count],
        triangle[:count],
        begin[:count],
        end[:count],
        along[:count],
        reach[:count],
        ended,
        length,
        other,
        there,
        left,
    )


@kernel
def _more(values: Int32Array) -> Int32Array:
    found = np.empty(2 * len(values), np.int32)
    found[: len(values)] = values
    return found


@kernel
def _more_floats(values: Floats) -> Floats:
    found = np.empty(2 * len(values))
    found[: len(values)] = values
    return found


@kernel
def _more_rows(values: Floats) -> Floats:
    found = np.empty((2 * len(values), 2))
    found[: len(values)] = values
    return found
