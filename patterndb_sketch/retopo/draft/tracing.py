"""Trace separatrices of a cross field over a mesh, each until it meets another: a motorcycle graph.

After Eppstein, Goodrich, Kim and Tamstorf 2008, "Motorcycle Graphs": all traces set out at once and
run equally fast; one that comes to where another has been stops there, in a T-junction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb._native.retopo.draft.tracing import trace_all
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats, Points
from patterndb_sketch.retopo.draft.crossfield import QUARTER, CrossField
from patterndb_sketch.retopo.draft.frames import TangentFrames

#: How a trace ended: at another line (its number is told), at a border, or where it was cut off.
AT_LINE, AT_BORDER, CUT_OFF = 0, 1, 2


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
