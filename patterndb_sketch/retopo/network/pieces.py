"""The parts of a curve between its stops become chains."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.network.attaching import Gaps, SeparatedError
from patterndb_sketch.retopo.network.contracting import drawn_together
from patterndb_sketch.retopo.network.cutting import AT_SAMPLE
from patterndb_sketch.retopo.network.detour import between_faces
from patterndb_sketch.retopo.network.draft import Draft
from patterndb_sketch.retopo.network.ends import AtNode, End, Free
from patterndb_sketch.retopo.network.gaps import Gap
from patterndb_sketch.retopo.network.stops import Nearness, Stop, between


def pairs(
    stops: list[Stop], free: tuple[bool, bool], whole: float, shortest: float
) -> list[tuple[Stop | float, Stop | float]]:
    """The parts of an open curve: from stop to stop, or from or to a loose end (arc length)."""
    if not stops:
        return [(0.0, whole)]
    pairs: list[tuple[Stop | float, Stop | float]] = []
    if free[0] and stops[0].begins > shortest:
        pairs.append((0.0, stops[0]))
    pairs += pairwise(stops)
    if free[1] and whole - stops[-1].ends > shortest:
        pairs.append((stops[-1], whole))
    return pairs


def piece(
    draft: Draft,
    line: Points,
    up: Points,
    along: NDArray[np.float64],
    a: Stop | float,
    b: Stop | float,
    near: Nearness,
) -> list[int]:
    """Add the part of the curve between two stops; nothing beyond a marked side.

    Nodes of two stops that are no further apart than ``near.node`` become one, if they can. Raises
    SeparatedError if what is between is further off than ``near.open``.
    """
    if (isinstance(a, Stop) and a.outside[1]) or (isinstance(b, Stop) and b.outside[0]):
        return []
    begin = a.ends if isinstance(a, Stop) else a
    finish = b.begins if isinstance(b, Stop) else b
    gaps = (
        a.after if isinstance(a, Stop) else None,
        b.before if isinstance(b, Stop) else None,
    )
    if isinstance(a, Stop) and isinstance(b, Stop) and finish - begin <= near.node:
        one, two = draft.node_now(a.node), draft.node_now(b.node)
        if one == two or drawn_together(draft, one, two, gaps, near.node):
            return []
    step = float(along[-1]) / (len(along) - 1)
    inner = np.flatnonzero((along > begin) & (along < finish))
    edge = np.interp([begin, finish], along, np.arange(len(along)))
    points, normals = between(line, up, edge)
    ends: list[End] = [Free(), Free()]
    for k, stop in enumerate((a, b)):
        off = 0.0
        if isinstance(stop, Stop):
            node = draft.nodes[draft.node_now(stop.node)]
            off = float(np.linalg.norm(points[k] - node.point))
            points[k], normals[k] = node.point, node.normal
            ends[k] = AtNode(node.id)
        # Samples that the node has come past.
        close = np.linalg.norm(line[inner] - points[k], axis=1) < max(AT_SAMPLE * step, off)
        run = close if k == 0 else close[::-1]
        drop = len(run) if run.all() else int(np.argmin(run))
        inner = inner[drop:] if k == 0 else inner[: len(inner) - drop]
    line = np.concatenate([points[:1], line[inner], points[1:]])
    up = np.concatenate([normals[:1], up[inner], normals[1:]])
    if (line[0] == line[-1]).all() and len(inner) < 2:
        return []
    try:
        return [draft.add_chain(line, up, ends[0], ends[1], gaps=gaps)]
    except SeparatedError:
        one, two = ends
        if not (isinstance(one, AtNode) and isinstance(two, AtNode)):
            raise
        made = _through(draft, line, up, one.node, two.node, gaps, near)
        if not made:
            raise
        return made


def _through(
    draft: Draft, line: Points, up: Points, first: int, last: int, gaps: Gaps, near: Nearness
) -> list[int]:
    """Add a part (n, 3) from a node to another across what is between; see :mod:`.detour`."""
    made: list[int] = []
    at, after = first, gaps[0]
    begin = 0
    for half, place, k in between_faces(draft.nodes, draft.chains, line, (first, last), near.open):
        chain, place = draft.located(half >> 1, place)
        line_of = draft.chains[chain]
        node = draft.cut_chain(chain, place)
        # At an end of the chain, the half-chain that leaves it there.
        leaving = draft.nodes[node].ends[0]
        if chain in draft.chains:
            leaving = 2 * chain + int(2.0 * place > line_of.segments)
        left = (leaving ^ half) & 1 == 0
        finish = max(begin, int(k))
        around = after, Gap(leaving, left)
        made += _step(draft, line, up, (begin, finish), (at, node), around, near.node)
        at, after, begin = node, Gap(leaving, not left), finish
    if after is gaps[0]:
        return []
    return made + _step(
        draft, line, up, (begin, len(line)), (at, last), (after, gaps[1]), near.node
    )


def _step(
    draft: Draft,
    line: Points,
    up: Points,
    part: tuple[int, int],
    nodes: tuple[int, int],
    gaps: Gaps,
    near: float,
) -> list[int]:
    """Add the samples of a part that are strictly between two, from a node to another."""
    one, two = (draft.nodes[draft.node_now(node)] for node in nodes)
    if one.id == two.id or drawn_together(draft, one.id, two.id, gaps, near):
        return []
    inner = slice(part[0] + 1, max(part[0] + 1, min(part[1], len(line) - 1)))
    points = np.concatenate([one.point[None], line[inner], two.point[None]])
    normals = np.concatenate([one.normal[None], up[inner], two.normal[None]])
    if not (points[1:] != points[:-1]).any():
        return []
    return [draft.add_chain(points, normals, AtNode(one.id), AtNode(two.id), gaps=gaps)]
