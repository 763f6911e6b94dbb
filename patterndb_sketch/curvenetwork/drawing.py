"""Drawings: a network as it was drawn, with its stages, and with how well its curves meet."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import KDTree

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length
from patterndb_sketch.curvenetwork.network import CurveId, CurveNetwork, InvalidNetworkError

#: An end is reported if it misses another curve by no more than this share of its own curve's
#: length: strokes drawn by hand miss by a few hundredths, what stands farther off may be meant to.
NEAR = 0.1

#: A curve's own end, or another part of it, counts as another curve from this share of it on.
OWN = 0.5


@dataclass(frozen=True, slots=True)
class CurveJoin:
    """Two curves, or one with itself, that were joined ``gap`` apart at ``place`` (3,), halfway."""

    curves: tuple[CurveId, CurveId]
    place: Points = field(repr=False)
    gap: float


@dataclass(frozen=True, slots=True)
class LooseEnd:
    """An end of ``curve`` at ``place`` (3,) where nothing goes on, ``gap`` from ``other``."""

    curve: CurveId
    place: Points = field(repr=False)
    other: CurveId
    gap: float


@dataclass(frozen=True, slots=True)
class Drawing:
    """A network as a file has it.

    network: all of it.
    stages:  the numbers of the curves that were drawn in every stage, in the order of drawing;
             empty if the file does not say. A curve that a later one splits is in its parts
             from the start.
    notes:   what was left out or changed on the way, a sentence each.
    joins:   joins of curves that do not meet exactly, the farthest apart first.
    loose:   ends where nothing goes on that are near another curve, the farthest off first.
    """

    network: CurveNetwork
    stages: tuple[tuple[int, ...], ...] = ()
    notes: tuple[str, ...] = ()
    joins: tuple[CurveJoin, ...] = ()
    loose: tuple[LooseEnd, ...] = ()

    def after(self, n_stages: int) -> CurveNetwork:
        """The network as it was after some stages, 0 to all: their curves, in their order.

        The nodes are those of the whole network, with the same numbers. A cycle that the file
        gives is there as soon as all its curves are. Raises InvalidNetworkError for a number
        of stages that the drawing does not have.
        """
        if not 0 <= n_stages <= len(self.stages):
            raise InvalidNetworkError(
                f"after {n_stages} stages: the drawing has {len(self.stages)}; give 0 to "
                f"{len(self.stages)}"
            )
        drawn = sorted({curve for stage in self.stages[:n_stages] for curve in stage})
        number = {curve: i for i, curve in enumerate(drawn)}
        cycles = filter(None, (cycle.renumber(number) for cycle in self.network.cycles))
        curves = tuple(self.network.curves[curve] for curve in drawn)
        return CurveNetwork(curves, self.network.nodes, tuple(cycles))


def find_loose_ends(network: CurveNetwork) -> tuple[LooseEnd, ...]:
    """Find the ends where nothing goes on that are near another curve, the farthest off first."""
    degree = np.bincount([node for c in network.curves for node in c.nodes])
    ends = [
        (number, -1 if last else 0)
        for number, curve in enumerate(network.curves)
        for last in (False, True)
        if degree[curve.nodes[last]] == 1
    ]
    if not ends:
        return ()
    starts = np.concatenate([curve.points[:-1] for curve in network.curves])
    steps = np.concatenate([np.diff(curve.points, axis=0) for curve in network.curves])
    owner = np.repeat(np.arange(len(network.curves)), [len(c.points) - 1 for c in network.curves])
    along = np.concatenate([arc_length(curve.points)[:-1] for curve in network.curves])
    size = np.linalg.norm(steps, axis=1)
    places = np.array([network.curves[number].points[end] for number, end in ends])
    reaches = NEAR * np.array([network.curves[number].length for number, _ in ends])
    tree = KDTree(starts + steps / 2)
    nearby = tree.query_ball_point(places, reaches + size.max() / 2, return_sorted=True)
    found: list[LooseEnd] = []
    for (number, end), place, reach, edges in zip(ends, places, reaches, nearby, strict=True):
        some = np.array(edges, np.int64)
        offset = place - starts[some]
        # Of steps so short that their squares are 0, the first point is as near as any.
        square = np.maximum(size[some] ** 2, np.finfo(np.float64).tiny)
        share = np.clip((offset * steps[some]).sum(axis=1) / square, 0.0, 1.0)
        gaps = np.linalg.norm(offset - share[:, None] * steps[some], axis=1)
        length = network.curves[number].length
        at = along[some] + share * size[some]
        away = at if end == 0 else length - at
        gaps[(owner[some] == number) & (away < OWN * length)] = math.inf
        best = int(np.argmin(gaps)) if len(gaps) else -1
        # An end that lies on a curve, as where a curve goes out and back, is not short of it.
        if best >= 0 and np.finfo(np.float64).tiny < gaps[best] <= reach:
            ids = network.curves[number].id, network.curves[int(owner[some[best]])].id
            found.append(LooseEnd(ids[0], place, ids[1], float(gaps[best])))
    return tuple(sorted(found, key=lambda one: (-one.gap, one.place.tolist())))


def describe_loose_ends(ends: Sequence[LooseEnd]) -> str:
    """Describe how far ends are off, where the farthest is, and which tolerance joins them all."""
    worst = ends[0]
    x, y, z = worst.place
    many = f"{len(ends):,} ends of curves stop" if len(ends) > 1 else "an end of a curve stops"
    up_to = "up to " if len(ends) > 1 else ""
    whose = "itself" if worst.other == worst.curve else f"curve {worst.other!r}"
    return (
        f"{many} short of another curve, by {up_to}{worst.gap:.3g} (curve {worst.curve!r} at "
        f"{x:.4g}, {y:.4g}, {z:.4g} of {whose}); a tolerance of {round_up(worst.gap)} "
        f"joins {'them' if len(ends) > 1 else 'it'}"
    )


def round_up(length: float) -> str:
    """A length of two digits that is no less, and at most a tenth more."""
    exponent = math.floor(math.log10(length)) - 1
    digits = math.ceil(length / 10.0**exponent * (1 + 1e-9))
    return f"{digits * 10.0**exponent:.2g}"


def describe_joins(joins: Sequence[CurveJoin]) -> str:
    """Describe how many joins bridge gaps, and where the widest gap is."""
    widest = joins[0]
    x, y, z = widest.place
    one, other = widest.curves
    one_join = "a join of curves bridges a gap of "
    many = f"{len(joins):,} joins of curves bridge gaps of up to " if len(joins) > 1 else one_join
    return f"{many}{widest.gap:.3g} (curves {one!r} and {other!r} at {x:.4g}, {y:.4g}, {z:.4g})"
