"""Where drawn curves are cut, and the nodes that they are cut at."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from patterndb.geometry.points import Floats, Points
from patterndb.geometry.polyline import arc_length
from patterndb_sketch.surfacing.joining.meetings import find_joins
from patterndb_sketch.surfacing.network import without_repeats


def in_order(drawn: list[Points]) -> tuple[list[Points], list[int], list[bool]]:
    """The curves in an order and senses that depend on their geometry alone, longest first.

    Returns the curves, which each of them is, and whether it is turned round.
    """
    keyed: list[tuple[float, bytes, int, bool, Points]] = []
    for number, points in enumerate(drawn):
        # Adding 0 makes the negative zero positive: the bytes shall be alike.
        senses = [np.ascontiguousarray(sense + 0.0) for sense in (points, points[::-1])]
        turned = senses[1].tobytes() < senses[0].tobytes()
        line = senses[turned]
        keyed.append((-arc_length(line)[-1], line.tobytes(), number, turned, line))
    keyed.sort(key=lambda one: one[:3])
    return [k[4] for k in keyed], [k[2] for k in keyed], [k[3] for k in keyed]


@dataclass(frozen=True, slots=True)
class Cut:
    """A place where a curve is cut: its arc length, the node, and whether a curve ends there."""

    length: float
    node: int
    ending: bool


def find_cuts(lines: list[Points], alongs: list[Floats], tolerance: float) -> list[list[Cut]]:
    """Where every curve is cut, ends included, in order; one alone if the curve vanishes."""
    starts = np.cumsum([0, *map(len, lines)])
    joins = find_joins(np.concatenate(lines), starts, np.concatenate(alongs), tolerance)
    n_curves, n_joins = len(lines), len(joins.curves)
    lasts = np.array([along[-1] for along in alongs])
    curve = np.r_[joins.curves.T.reshape(-1), np.arange(n_curves), np.arange(n_curves)]
    length = np.r_[joins.lengths.T.reshape(-1), np.zeros(n_curves), lasts]
    met = np.arange(len(curve)) < 2 * n_joins
    order = np.lexsort((length, curve))
    curve, length, met = curve[order], length[order], met[order]
    place = np.empty(len(order), np.int64)
    place[order] = np.arange(len(order))
    apart = (np.diff(curve) > 0) | (np.diff(length) > tolerance)
    group = np.r_[0, np.cumsum(apart)]
    ends = group[place[: 2 * n_joins]].reshape(2, -1)
    links = coo_array((np.ones(n_joins, bool), ends), shape=(group[-1] + 1, group[-1] + 1))
    nodes = connected_components(links, directed=False)[1]
    cuts: list[list[Cut]] = [[] for _ in lines]
    for begin, end in pairwise([0, *(1 + np.flatnonzero(apart)).tolist(), len(curve)]):
        of_curve = int(curve[begin])
        within, real = length[begin:end], met[begin:end]
        at_ends = [e for e in (0.0, lasts[of_curve]) if e in (within[0], within[-1])]
        # A curve is cut at its end if others meet it there, else where they do meet it: what
        # goes on beyond is an overshoot.
        exact = [e for e in at_ends if (within[real] == e).any()]
        mean = _mean(within[real]) if real.any() else None
        at = float((exact or at_ends)[0] if exact or mean is None else mean)
        cuts[of_curve].append(Cut(at, int(nodes[group[begin]]), bool(at_ends)))
    return cuts


@dataclass(frozen=True, slots=True)
class Node:
    """Where curves meet.

    place:  (3,) the mean of the curves that pass it, or if there is none of those that end there.
    count:  how many cuts of curves are gathered in it.
    spread: how far the furthest of them was away.
    """

    place: Floats = field(repr=False)
    count: int
    spread: float


def find_nodes(lines: list[Points], alongs: list[Floats], cuts: list[list[Cut]]) -> dict[int, Node]:
    """The nodes that the cuts name."""
    passing: dict[int, list[Points]] = {}
    ending: dict[int, list[Points]] = {}
    for points, along, of_curve in zip(lines, alongs, cuts, strict=True):
        at = _at(points, along, [cut.length for cut in of_curve])
        for cut, place in zip(of_curve, at, strict=True):
            (ending if cut.ending else passing).setdefault(cut.node, []).append(place)
    nodes: dict[int, Node] = {}
    for number in ending | passing:
        gathered = np.array(passing.get(number, []) + ending.get(number, []))
        place = _mean(gathered[: len(passing.get(number, gathered))])
        spread = np.linalg.norm(gathered - place, axis=1).max()
        nodes[number] = Node(place, len(gathered), float(spread))
    return nodes


def _mean(values: Floats) -> Floats:
    """The mean over the first axis; exact if all are the same."""
    return values[0] + (values - values[0]).mean(axis=0)


def _at(points: Points, along: Floats, lengths: list[float]) -> Points:
    return np.stack([np.interp(lengths, along, points[:, d]) for d in range(3)], axis=1)


def part_of(points: Points, along: Floats, begin: float, end: float) -> Points:
    """The polyline between two arc lengths."""
    inner = points[(along > begin) & (along < end)]
    first, last = _at(points, along, [begin, end])
    return without_repeats(np.concatenate([first[None], inner, last[None]]))
