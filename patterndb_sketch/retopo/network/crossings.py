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
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from patterndb._native.retopo.network.crossings import cross_chains, cross_itself
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats, Points
from patterndb_sketch.retopo.network.attaching import ASIDE, TOWARDS
from patterndb_sketch.retopo.network.faces import find_joined_chains, list_face
from patterndb_sketch.retopo.network.samples import Samples
from patterndb_sketch.retopo.network.structure import Chain, HalfChain, Node


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
    found = cross_chains(aside, up, of.points, of.normals, of.starts, of.is_closed_loop)
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
    found = cross_itself(line, aside, up, closed)
    found = found[np.argsort(found[:, 0], kind="stable")]
    none = np.full(len(found), -1, np.int32)
    return Crossings(found[:, 0], none, found[:, 2], found[:, 3] > 0.0)


def _close_line(values: Points, closed: bool) -> Points:
    return np.ascontiguousarray(np.concatenate([values, values[:1]]) if closed else values)


def _mean_step(line: Points) -> float:
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).mean()) if len(line) > 1 else 0.0


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
