"""Open ends that a curve passes are joined to it: cut where they cross it, or led there."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points, units
from patterndb.geometry.polyline import arc_length
from patterndb_sketch.retopo.network.crossings import crossings
from patterndb_sketch.retopo.network.draft import Draft
from patterndb_sketch.retopo.network.samples import samples_of
from patterndb_sketch.retopo.network.stops import Project, Stop, between
from patterndb_sketch.retopo.network.structure import HalfChain, Node

#: A chain is shortened, or led on, only if it is longer than this many times the radius.
LONG = 2.0


@dataclass(frozen=True, slots=True)
class Passed:
    """An open end on a curve. stem: the half-chain that leaves it. at: arc length on the curve."""

    node: int
    stem: HalfChain
    at: float

    def stop(self) -> Stop:
        return Stop(self.node, self.at, self.at)


def passed_ends(
    draft: Draft,
    line: Points,
    up: Points,
    along: NDArray[np.float64],
    joints: Iterable[int | None],
    reach: float,
    project: Project,
) -> list[Passed]:
    """Lead the open ends within a radius of a curve (n, 3) to it.

    along: (n,) its arc length. joints: nodes that its own ends are joined to; they, and what is
    within the radius of its ends, are left to these. A chain that crosses the curve within the
    radius of its open end is shortened to the crossing; another is led on to the nearest point of
    the curve, if nothing is between. Marked chains stay.
    """
    found: list[Passed] = []
    if reach <= 0.0:
        return found
    low, high = line.min(axis=0) - reach, line.max(axis=0) + reach
    for node in sorted(draft.nodes):
        at = draft.nodes[node]
        if not at.open or node in joints or (at.point < low).any() or (at.point > high).any():
            continue
        stem = at.ends[0]
        chain = draft.chains[stem >> 1]
        if chain.marked or chain.length <= LONG * reach:
            continue
        place = _meeting(draft, line, up, along, at, reach)
        if place is None:
            continue
        s = float(np.interp(place, np.arange(len(along)), along))
        if not reach < s < along[-1] - reach:
            continue
        foot, normal = between(line, up, np.array([place]))
        if _led(draft, at, foot[0], normal[0], project):
            found.append(Passed(node, stem, s))
    return found


def open_places(draft: Draft, line: Points, up: Points, reach: float) -> NDArray[np.float64]:
    """(k,) the samples of a curve (n, 3) that are nearest to open ends within a radius."""
    found: list[float] = []
    for at in draft.nodes.values():
        if at.open:
            away = np.where(up @ at.normal > 0.0, np.linalg.norm(line - at.point, axis=1), np.inf)
            k = int(np.argmin(away))
            if away[k] <= reach:
                found.append(float(k))
    return np.array(found)


def straightened(draft: Draft, passed: Iterable[Passed]) -> None:
    """Make the nodes T-junctions: the curve passes them straight on the side without a stem."""
    for one in passed:
        at = draft.nodes.get(draft.node_now(one.node))
        if at is None or at.valence != 3:
            continue
        far = (at.ends.index(draft.half_now(one.stem)) + 1) % 3
        flags = tuple(k != far for k in range(3))
        draft.set_node(replace(at, flagged=flags, cut=True))


def _meeting(
    draft: Draft, line: Points, up: Points, along: NDArray[np.float64], at: Node, reach: float
) -> float | None:
    """The place on the curve that an open end belongs to: where its chain crosses it first,
    within the radius, else the nearest within it. None if there is none."""
    stem = at.ends[0]
    chain = draft.chains[stem >> 1]
    found = crossings(line, up, False, samples_of({chain.id: chain}))
    if len(found):
        whole = arc_length(chain.points)
        off = np.interp(found.place, np.arange(len(whole)), whole)
        off = whole[-1] - off if stem & 1 else off
        near = np.flatnonzero(off <= reach)
        if len(near):
            # Of several, the one that leaves least of the chain beyond the curve.
            return float(found.along[near[np.argmax(off[near])]])
    steps = np.diff(line, axis=0)
    sizes = np.einsum("nc,nc->n", steps, steps)
    towards = np.einsum("nc,nc->n", at.point - line[:-1], steps)
    share = np.clip(towards / np.maximum(sizes, np.finfo(np.float64).tiny), 0.0, 1.0)
    away = np.linalg.norm(line[:-1] + share[:, None] * steps - at.point, axis=1)
    away[(up[:-1] + up[1:]) @ at.normal <= 0.0] = np.inf
    k = int(np.argmin(away))
    return float(k + share[k]) if away[k] <= reach else None


def _led(draft: Draft, at: Node, foot: Points, normal: Points, project: Project) -> bool:
    """Let the chain of an open end run to a point (3,), if nothing is between; did it?"""
    stem = at.ends[0]
    chain = draft.chains[stem >> 1]
    points, normals = chain.directed(stem)
    # What is beyond the point, seen along the chain, goes.
    keep = int(np.argmin(np.linalg.norm(points - foot, axis=1)))
    while keep < len(points) - 1 and (points[keep + 1] - points[keep]) @ (points[keep] - foot) < 0:
        keep += 1
    points, normals = points[keep:], normals[keep:]
    step = chain.length / chain.segments
    gap = float(np.linalg.norm(points[0] - foot))
    if len(points) < 3:
        return False
    share = np.linspace(0.0, 1.0, max(1, round(gap / step)) + 1)[:-1, None]
    led = (1.0 - share) * foot + share * points[0]
    above = units((1.0 - share) * normal + share * normals[0])
    if len(led) > 1:
        led[1:], above[1:] = project(led[1:], above[1:])
    points, normals = np.concatenate([led, points]), np.concatenate([above, normals])
    others = samples_of({c: other for c, other in draft.chains.items() if c != chain.id})
    new = slice(len(led) + 1)
    if keep == 0 and len(crossings(points[new], normals[new], False, others)):
        return False
    draft.set_node(replace(at, point=foot.copy(), normal=normal.copy()))
    if stem & 1:
        points, normals = points[::-1], normals[::-1]
    draft.reshape_chain(chain.id, points, normals)
    return True
