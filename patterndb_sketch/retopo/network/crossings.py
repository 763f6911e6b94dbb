"""Find where a curve crosses the chains of a network, or itself, and in which order.

Two segments cross if each has its ends on both sides of the other, seen along the other's normal,
and their gap is small. To see every crossing once, even where points lie on segments or on each
other, the new curve is looked at as if it lay a little aside: by the same tiny step all along.

Where chains lie on each other, or cross next to a place, rounding says which a curve meets first.
The faces of the network say it for certain (:func:`order_crossings`): crossing a chain leads from
the face on its one side to that on its other, and the next chain that is crossed, of the same part
of the network, has that face on its near side.

After curves were pulled, or drawn along each other, chains may lie over each other without a node,
and a curve may come, without crossing any, from a face to another. The chains between the two faces
tell what it must have crossed (:func:`find_hidden_crossings`): of all ways from face to face it is
that along which they are nearest to the curve.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Floats, Points
from patterndb.system.kernels import kernel
from patterndb_sketch.retopo.network.attaching import ASIDE, TOWARDS
from patterndb_sketch.retopo.network.faces import find_joined_chains, list_face
from patterndb_sketch.retopo.network.samples import Samples
from patterndb_sketch.retopo.network.structure import Chain, HalfChain, Node

#: Segments whose places nearest to each other, seen along the normals, are further apart than this
#: part of their lengths do not cross: on a curved surface, where the two normals differ, nearly
#: parallel ones may seem to.
BESIDE = 0.25


@dataclass(frozen=True, slots=True, eq=False)
class Crossings:
    """Of k crossings, in order along the curve.

    along:     (k,) float64 places on the curve, in its samples.
    chain:     (k,) int32 ids of the chains; of the curve with itself, -1.
    place:     (k,) float64 places on these, in samples.
    rightward: (k,) bool: does the curve cross from the left to the right of the chain?
    """

    along: Floats
    chain: Int32Array
    place: Floats
    rightward: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.along)

    def select(self, order: Sequence[int]) -> Crossings:
        """Those with these numbers, in this order."""
        k = np.array(order, np.int64)
        return Crossings(self.along[k], self.chain[k], self.place[k], self.rightward[k])


def find_crossings(points: Points, normals: Points, closed: bool, of: Samples) -> Crossings:
    """Where a curve (n, 3) with its normals (n, 3) crosses chains.

    closed: does it run back to its first point, which is not repeated? Segments whose gap is
    larger than their lengths together do not cross, nor do those on different sides of a sheet:
    their normals disagree.
    """
    line, up = _close_line(points, closed), _close_line(normals, closed)
    aside = line + ASIDE * _mean_step(line) * TOWARDS
    found = _cross_chains(aside, up, of.points, of.normals, of.starts, of.loose)
    order = np.argsort(found[:, 0], kind="stable")
    found = found[order]
    return Crossings(
        found[:, 0],
        of.ids[found[:, 1].astype(np.int64)] if len(found) else np.empty(0, np.int32),
        found[:, 2],
        found[:, 3] > 0.0,
    )


def find_self_crossings(points: Points, normals: Points, closed: bool) -> Crossings:
    """Where a curve crosses itself, each crossing once: ``place`` is the earlier of the two."""
    line, up = _close_line(points, closed), _close_line(normals, closed)
    aside = line + ASIDE * _mean_step(line) * TOWARDS
    found = _cross_itself(line, aside, up, closed)
    found = found[np.argsort(found[:, 0], kind="stable")]
    none = np.full(len(found), -1, np.int32)
    return Crossings(found[:, 0], none, found[:, 2], found[:, 3] > 0.0)


def _close_line(values: Points, closed: bool) -> Points:
    return np.ascontiguousarray(np.concatenate([values, values[:1]]) if closed else values)


def _mean_step(line: Points) -> float:
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).mean()) if len(line) > 1 else 0.0


@kernel
def _side(
    points: Points,
    i: Index,
    j: Index,
    x: float,
    y: float,
    z: float,
    others: Points,
    k: Index,
) -> float:
    """How far a point of the others is left of the segment from i to j, seen against (x, y, z);
    scaled."""
    ux, uy, uz = (
        points[j, 0] - points[i, 0],
        points[j, 1] - points[i, 1],
        points[j, 2] - points[i, 2],
    )
    vx, vy, vz = (
        others[k, 0] - points[i, 0],
        others[k, 1] - points[i, 1],
        others[k, 2] - points[i, 2],
    )
    return x * (uy * vz - uz * vy) + y * (uz * vx - ux * vz) + z * (ux * vy - uy * vx)


@kernel
def _step(points: Points, f: Index, g: Index) -> float:
    size = 0.0
    for c in range(3):
        size += (points[g, c] - points[f, c]) ** 2
    return math.sqrt(size)


@kernel
def _cross_segments(
    line: Points,
    up: Points,
    e: Index,
    points: Points,
    normals: Points,
    f: Index,
    g: Index,
) -> tuple[bool, float, float, bool]:
    """Does segment e of the line cross that from point f to point g? The part of each up to the
    crossing, and is it from left to right?"""
    mx, my, mz = up[e, 0] + up[e + 1, 0], up[e, 1] + up[e + 1, 1], up[e, 2] + up[e + 1, 2]
    nx = normals[f, 0] + normals[g, 0]
    ny = normals[f, 1] + normals[g, 1]
    nz = normals[f, 2] + normals[g, 2]
    if mx * nx + my * ny + mz * nz <= 0.0:
        return False, 0.0, 0.0, False
    a = _side(points, f, g, nx, ny, nz, line, e)
    b = _side(points, f, g, nx, ny, nz, line, e + 1)
    if (a >= 0.0) == (b >= 0.0):
        return False, 0.0, 0.0, False
    c = _side(line, e, e + 1, mx, my, mz, points, f)
    d = _side(line, e, e + 1, mx, my, mz, points, g)
    if (c >= 0.0) == (d >= 0.0):
        return False, 0.0, 0.0, False
    s, u = a / (a - b), c / (c - d)
    far = _step(line, e, e + 1) + _step(points, f, g)
    gx = line[e, 0] + s * (line[e + 1, 0] - line[e, 0])
    gy = line[e, 1] + s * (line[e + 1, 1] - line[e, 1])
    gz = line[e, 2] + s * (line[e + 1, 2] - line[e, 2])
    gx -= points[f, 0] + u * (points[g, 0] - points[f, 0])
    gy -= points[f, 1] + u * (points[g, 1] - points[f, 1])
    gz -= points[f, 2] + u * (points[g, 2] - points[f, 2])
    gap = gx * gx + gy * gy + gz * gz
    x, y, z = mx + nx, my + ny, mz + nz
    across = (gx * x + gy * y + gz * z) ** 2 / (x * x + y * y + z * z)
    beside = math.sqrt(max(gap - across, 0.0))
    return math.sqrt(gap) <= far and beside <= BESIDE * far, s, u, a >= 0.0


@kernel
def _double_room(found: Floats) -> Floats:
    return np.concatenate((found, np.empty_like(found)))


@kernel
def _box(points: Points, first: Index, last: Index) -> Floats:
    """(2, 3) lowest and highest coordinates of the points from first to last."""
    box = np.empty((2, 3))
    box[0] = points[first]
    box[1] = points[first]
    for k in range(first + 1, last + 1):
        for c in range(3):
            box[0, c] = min(box[0, c], points[k, c])
            box[1, c] = max(box[1, c], points[k, c])
    return box


@kernel
def _is_apart(box: Floats, points: Points, f: Index, g: Index, reach: float) -> bool:
    """Is the segment from f to g further than a distance from a box, along one of the axes?"""
    for c in range(3):
        low, high = points[f, c], points[g, c]
        if low > high:
            low, high = high, low
        if low > box[1, c] + reach or high < box[0, c] - reach:
            return True
    return False


@kernel
def _cross_chains(
    line: Points,
    up: Points,
    points: Points,
    normals: Points,
    starts: Int32Array,
    loose: NDArray[np.bool_],
) -> Floats:
    """(k, 4): place on the line, number and place of the chain, 1 if from left to right."""
    found = np.empty((16, 4))
    n = 0
    whole = _box(line, 0, len(line) - 1)
    longest = 0.0
    for e in range(len(line) - 1):
        longest = max(longest, _step(line, e, e + 1))
    near = np.empty(len(line), np.int32)
    for c in range(len(starts) - 1):
        first, last = starts[c], starts[c + 1] - 1
        box = _box(points, first, last)
        reach = longest
        for k in range(first, last):
            reach = max(reach, _step(points, k, k + 1))
        reach += longest
        if loose[c]:
            reach = max(reach, longest + _step(points, last, first))
        gone = False
        for d in range(3):
            gone |= box[0, d] > whole[1, d] + reach or box[1, d] < whole[0, d] - reach
        if gone:
            continue
        m = 0
        for e in range(len(line) - 1):
            if not _is_apart(box, line, e, e + 1, reach):
                near[m] = e
                m += 1
        for k in range(first, last + 1):
            j = k + 1
            if k == last:
                if not loose[c]:
                    break
                j = first
            if m == 0:
                break
            far = longest + _step(points, k, j)
            if _is_apart(whole, points, k, j, far):
                continue
            for i in range(m):
                e = near[i]
                apart = False
                for d in range(3):
                    a, b = line[e, d], line[e + 1, d]
                    p, q = points[k, d], points[j, d]
                    apart |= max(a, b) + far < min(p, q) or min(a, b) - far > max(p, q)
                if apart:
                    continue
                crosses, s, u, rightward = _cross_segments(line, up, e, points, normals, k, j)
                if crosses:
                    if n == len(found):
                        found = _double_room(found)
                    found[n, 0] = e + s
                    found[n, 1] = c
                    found[n, 2] = k - first + u
                    found[n, 3] = 1.0 if rightward else 0.0
                    n += 1
    return found[:n]


@kernel
def _cross_itself(line: Points, aside: Points, up: Points, closed: bool) -> Floats:
    """(k, 4): later place, 0, earlier place, 1 if the later part goes to the earlier's right."""
    found = np.empty((16, 4))
    n = 0
    m = len(line) - 1
    for f in range(m):
        for e in range(f + 2, m):
            if closed and f == 0 and e == m - 1:
                continue
            apart = False
            far = _step(line, f, f + 1) + _step(line, e, e + 1)
            for d in range(3):
                a, b = line[e, d], line[e + 1, d]
                p, q = line[f, d], line[f + 1, d]
                apart |= max(a, b) + far < min(p, q) or min(a, b) - far > max(p, q)
            if apart:
                continue
            crosses, s, u, rightward = _cross_segments(aside, up, e, line, up, f, f + 1)
            if crosses:
                if n == len(found):
                    found = _double_room(found)
                found[n, 0] = e + s
                found[n, 1] = 0.0
                found[n, 2] = f + u
                found[n, 3] = 1.0 if rightward else 0.0
                n += 1
    return found[:n]


#: Steps after which the search for an order is given up; among a few crossings at one place it
#: takes tens.
MOST_STEPS = 1000


def order_crossings(
    nodes: Mapping[int, Node],
    chains: Mapping[int, Chain],
    along: NDArray[np.float64],
    crossed: Sequence[HalfChain],
    near: float,
) -> list[int]:
    """The order of k crossings, as their numbers.

    along:   (k,) where they are on the curve, ascending. crossed: for each the half-chain that
             the curve crosses from left to right. near: crossings no further apart along the curve
             may be in another order than measured.

    Of the orders in which the faces follow each other it is the first, as measured; if there is
    none, as measured.
    """
    if len(crossed) < 2:
        return list(range(len(crossed)))
    face: dict[HalfChain, int] = {}
    part: dict[int, int] = {}
    for half in crossed:
        for side in (half, half ^ 1):
            if side not in face:
                face.update(dict.fromkeys(list_face(nodes, chains, side), side))
        if half >> 1 not in part:
            part.update(dict.fromkeys(find_joined_chains(nodes, chains, half >> 1), half >> 1))
    steps = [FaceStep(part[half >> 1], face[half], face[half ^ 1]) for half in crossed]
    return find_first_order(steps, along, near)


@dataclass(frozen=True, slots=True)
class FaceStep:
    """Of a crossing: the part of the network, and the faces that it leads from and to."""

    part: int
    before: int
    after: int


def find_first_order(
    steps: Sequence[FaceStep], along: NDArray[np.float64], near: float
) -> list[int]:
    """By a search in depth, in which what was measured first is tried first."""
    left = [True] * len(steps)
    at: dict[int, int] = {}  # the face that the curve is in, in each part of the network
    order: list[int] = []
    behind: list[int | None] = []  # the face that each crossing left, to go back

    def next_ones() -> Iterator[int]:
        first = left.index(True) if True in left else len(steps)
        for i in range(first, len(steps)):
            if along[i] > along[first] + near:
                break
            if left[i] and at.get(steps[i].part, steps[i].before) == steps[i].before:
                yield i

    choices = [next_ones()]
    for _ in range(MOST_STEPS):
        if len(order) == len(steps):
            return order
        i = next(choices[-1], None)
        if i is not None:
            order.append(i)
            left[i] = False
            behind.append(at.get(steps[i].part))
            at[steps[i].part] = steps[i].after
            choices.append(next_ones())
            continue
        choices.pop()
        if not choices:
            break
        last, face = order.pop(), behind.pop()
        left[last] = True
        if face is None:
            del at[steps[last].part]
        else:
            at[steps[last].part] = face
    return list(range(len(steps)))


#: What each chain that is crossed costs beside its distance, as a part of the curve's length: of
#: two ways it is that across fewer.
CROSSED = 1e-3


def find_hidden_crossings(
    nodes: Mapping[int, Node],
    chains: Mapping[int, Chain],
    line: Points,
    ends: tuple[int, int],
    reach: float,
) -> list[tuple[HalfChain, float, float]]:
    """The half-chains that a curve (n, 3) from a node to another crosses from left to right, in
    order, with the place on each chain, and the place on the curve, both in samples.

    reach: how far from the curve that is at most. Chains with a marked side are never crossed.
    Empty if there is no way.
    """
    tree = KDTree(line)
    length = float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())
    costs: dict[int, tuple[float, float, float]] = {}

    def cost(chain: int) -> tuple[float, float, float]:
        if chain not in costs:
            away, k = map(np.asarray, tree.query(chains[chain].points))
            best = int(away.argmin())
            costs[chain] = float(away[best]) + CROSSED * length, float(best), float(k[best])
        return costs[chain]

    face: dict[HalfChain, HalfChain] = {}
    loops: dict[HalfChain, list[HalfChain]] = {}

    def face_of(half: HalfChain) -> HalfChain:
        if half not in face:
            loops[half] = list_face(nodes, chains, half)
            face.update(dict.fromkeys(loops[half], half))
        return face[half]

    # The face on the left of each; there is no way beyond a marked side.
    begun, goals = (
        {face_of(half) for half in nodes[node].ends if not chains[half >> 1].marks[half & 1]}
        for node in ends
    )
    reached: dict[HalfChain, float] = dict.fromkeys(sorted(begun), 0.0)
    came: dict[HalfChain, HalfChain] = {}
    queue = [(0.0, at) for at in reached]
    heapq.heapify(queue)
    while queue:
        so_far, at = heapq.heappop(queue)
        if so_far > reached[at]:
            continue
        if at in goals:
            way: list[HalfChain] = []
            while at in came:
                way.append(came[at])
                at = face_of(came[at])
            return [(half, *cost(half >> 1)[1:]) for half in way[::-1]]
        for half in loops[at]:
            away = cost(half >> 1)[0]
            if chains[half >> 1].marked or away > reach + CROSSED * length:
                continue
            beyond = face_of(half ^ 1)
            new = so_far + away
            if new < reached.get(beyond, float("inf")):
                reached[beyond] = new
                came[beyond] = half
                heapq.heappush(queue, (new, beyond))
    return []
