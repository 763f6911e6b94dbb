"""Curve networks: curves that meet at nodes, and the closed walks along them that bound patches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from patterndb.errors import PatternDBError
from patterndb.geometry.points import Points, as_points
from patterndb.geometry.polyline import arc_length
from patterndb.verbs import NetworkVerbs

#: A curve's name in the file it came from.
CurveId = int | str


#: A step along a curve of the network: its number, and whether from its second node to its first.
Step = tuple[int, bool]


class InvalidNetworkError(PatternDBError, ValueError):
    """A curve network, or a cycle of one, is not what it must be."""


@dataclass(frozen=True, slots=True)
class Curve:
    """One curve of a network, from node to node.

    points: (k, 3) float64, k >= 2, from the first node to the second, no two in a row alike.
    nodes:  the nodes where it begins and ends; the same one twice for a closed curve.
    id:     its name. Curves that a longer one was split into at nodes share the name.
    stroke: the name of the drawn stroke that it is a part of, by default its own.
    normals: (k, 3) unit normals of the surface at its points, of either sense; None if they are
            not known.
    """

    points: Points = field(repr=False)
    nodes: tuple[int, int]
    id: CurveId
    stroke: CurveId
    normals: Points | None = field(default=None, repr=False)

    @property
    def length(self) -> float:
        """Arc length, in the units of the points."""
        return float(arc_length(self.points)[-1])

    @property
    def closed(self) -> bool:
        """Does it end where it begins?"""
        return self.nodes[0] == self.nodes[1]


@dataclass(frozen=True, slots=True)
class Cycle:
    """A closed walk along curves of a network.

    steps: (curve, backward) for every curve in the order of the walk: the curve's number in
    the network, and whether it is walked from its second node to its first.
    """

    steps: tuple[Step, ...]

    @property
    def curves(self) -> tuple[int, ...]:
        """The numbers of its curves, in order."""
        return tuple(curve for curve, _ in self.steps)

    @property
    def turned(self) -> Cycle:
        """The same cycle, walked the other way round."""
        return Cycle(turn_walk(self.steps))

    @property
    def key(self) -> tuple[tuple[int, bool], ...]:
        """What two cycles have in common that differ in start and sense only."""
        walks = (self.steps, self.turned.steps)
        return min(walk[i:] + walk[:i] for walk in walks for i in range(len(walk)))

    def renumber(self, number: Mapping[int, int]) -> Cycle | None:
        """Return the cycle with other numbers of curves; None if one of them has no other."""
        if not all(curve in number for curve in self.curves):
            return None
        return Cycle(tuple((number[curve], backward) for curve, backward in self.steps))


def turn_walk(steps: Sequence[Step]) -> tuple[Step, ...]:
    """Return the steps of a walk the other way round."""
    return tuple((curve, not backward) for curve, backward in reversed(steps))


@dataclass(frozen=True, slots=True)
class CurveNetwork(NetworkVerbs):
    """Curves that meet at nodes.

    curves: the curves; a cycle names them by their place in this tuple.
    nodes:  (n, 3) float64, where curves begin and end.
    cycles: the cycles that came with the network, each a patch; empty if none did.

    Raises InvalidNetworkError for curves whose ends are not at their nodes, without length,
    with points that are not finite, and for cycles that :meth:`walk` refuses.
    """

    curves: tuple[Curve, ...]
    nodes: Points = field(repr=False)
    cycles: tuple[Cycle, ...] = ()

    def __post_init__(self) -> None:
        for number, curve in enumerate(self.curves):
            self._check_curve(number, curve)
        for cycle in self.cycles:
            self.walk(cycle)

    @classmethod
    def from_edges(cls, points: ArrayLike, edges: ArrayLike) -> CurveNetwork:
        """The network whose curves are straight edges between points, such as a mesh's edges.

        points: (n, 3). edges: (m, 2) integers below n; curve i is edge i. Points without an
        edge remain as nodes. Raises InvalidNetworkError for edges of no length.
        """
        nodes = as_points(points, "points", InvalidNetworkError)
        pairs = np.asarray(edges, np.int64).reshape(-1, 2)
        curves = tuple(
            Curve(nodes[[a, b]], (int(a), int(b)), number, number)
            for number, (a, b) in enumerate(pairs)
        )
        return cls(curves, nodes)

    @property
    def diagonal(self) -> float:
        """The diagonal of the box around all curves, 0 without any."""
        if not self.curves:
            return 0.0
        points = np.concatenate([curve.points for curve in self.curves])
        return float(np.linalg.norm(np.ptp(points, axis=0)))

    def ends(self, step: Step) -> tuple[int, int]:
        """The nodes where a step of a walk begins and ends."""
        curve, backward = step
        first, last = self.curves[curve].nodes
        return (last, first) if backward else (first, last)

    def walk(self, cycle: Cycle) -> tuple[int, ...]:
        """The nodes that the cycle passes: node i is where step i begins.

        Raises InvalidNetworkError if the cycle is empty, names a curve that is not there, does
        not close, or passes a curve or a node twice: then it bounds no disk, and is two
        cycles at least.
        """
        if not cycle.steps:
            raise InvalidNetworkError("a cycle needs at least one curve")
        for curve, _ in cycle.steps:
            if not 0 <= curve < len(self.curves):
                raise InvalidNetworkError(
                    f"a cycle names curve {curve}; the network has curves 0 to "
                    f"{len(self.curves) - 1}"
                )
        ends = [self.ends(step) for step in cycle.steps]
        for i, (_, last) in enumerate(ends):
            following = (i + 1) % len(ends)
            if last != ends[following][0]:
                raise InvalidNetworkError(
                    f"the cycle {self.names(cycle)} breaks: curve {self._name(cycle, i)} ends at "
                    f"{self._place(last)}, but curve {self._name(cycle, following)} begins at "
                    f"{self._place(ends[following][0])}; name curves in the order of a closed walk"
                )
        nodes = tuple(first for first, _ in ends)
        for i, node in enumerate(nodes):
            if node in nodes[:i]:
                raise InvalidNetworkError(
                    f"the cycle {self.names(cycle)} passes {self._place(node)} twice; give the "
                    "parts before and after as cycles of their own"
                )
        return nodes

    def names(self, cycle: Cycle) -> list[CurveId]:
        """The names of the cycle's curves in order; parts of one split curve in a row once."""
        names = [self.curves[curve].id for curve, _ in cycle.steps]
        kept = [name for i, name in enumerate(names) if i == 0 or name != names[i - 1]]
        return kept[:-1] if len(kept) > 1 and kept[0] == kept[-1] else kept

    def polyline(self, cycle: Cycle) -> Points:
        """(k, 3) points of the curves around the cycle as they were drawn, the first not again."""
        return np.concatenate([self.along(step)[:-1] for step in cycle.steps])

    def along(self, step: Step) -> Points:
        """(k, 3) points of a step's curve, in the sense of the walk."""
        curve, backward = step
        points = self.curves[curve].points
        return points[::-1] if backward else points

    def _check_curve(self, number: int, curve: Curve) -> None:
        points = curve.points
        if points.ndim != 2 or points.shape[1:] != (3,) or len(points) < 2:
            raise InvalidNetworkError(f"curve {curve.id!r} needs two points [x, y, z] or more")
        if not np.isfinite(points).all():
            raise InvalidNetworkError(f"curve {curve.id!r} has a point that is not finite")
        if (points[1:] == points[:-1]).all(axis=1).any():
            raise InvalidNetworkError(
                f"curve {curve.id!r} has two points in a row at one place; leave one out"
            )
        if curve.normals is not None and curve.normals.shape != points.shape:
            raise InvalidNetworkError(
                f"curve {curve.id!r} has {len(points)} points and {len(curve.normals)} normals; "
                "give one normal for each point"
            )
        for node, end in zip(curve.nodes, (points[0], points[-1]), strict=True):
            if not 0 <= node < len(self.nodes) or not np.array_equal(self.nodes[node], end):
                raise InvalidNetworkError(
                    f"curve {curve.id!r} (number {number}) has an end that is not at its "
                    f"node {node}; end it there"
                )

    def _name(self, cycle: Cycle, step: int) -> str:
        return repr(self.curves[cycle.steps[step][0]].id)

    def _place(self, node: int) -> str:
        x, y, z = self.nodes[node]
        return f"node {node} ({x:.4g}, {y:.4g}, {z:.4g})"


def list_steps_at_nodes(network: CurveNetwork) -> list[list[tuple[int, bool]]]:
    """For every node the steps that leave it: (curve, backward), a closed curve both ways."""
    leaving: list[list[tuple[int, bool]]] = [[] for _ in range(len(network.nodes))]
    for number, curve in enumerate(network.curves):
        leaving[curve.nodes[0]].append((number, False))
        leaving[curve.nodes[1]].append((number, True))
    return leaving


def total_length(network: CurveNetwork, curves: Sequence[int]) -> float:
    """The summed arc length of some curves of the network."""
    return float(sum(network.curves[curve].length for curve in curves))
