"""Pieces of drawn curves between nodes: which are copies, which close, and their numbers."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import sampled
from patterndb_sketch.surfacing.joining.cutting import Node
from patterndb_sketch.surfacing.joining.nearest import farthest
from patterndb_sketch.surfacing.naming import Step
from patterndb_sketch.surfacing.network import Curve, CurveId, Network


@dataclass(slots=True)
class Piece:
    """A piece of a curve between two nodes, in the sense in which the curve is worked on.

    copy_of: the piece that stays of the two that are alike, and whether it runs the other way.
    """

    points: Points
    nodes: tuple[int, int]
    length: float
    copy_of: tuple[int, bool] | None = None


def copied(
    piece: Piece, same: list[int], pieces: list[Piece], reach: float
) -> tuple[int, bool] | None:
    """Which of some pieces between the same nodes this one copies, and whether it is turned."""
    for number in same:
        other = pieces[number].points
        if farthest(piece.points, other) <= reach and farthest(other, piece.points) <= reach:
            first, last = piece.nodes
            if first != last:
                return number, pieces[number].nodes != piece.nodes
            quarters = [sampled(points, 4)[[1, 3]] for points in (piece.points, other)]
            straight = np.linalg.norm(quarters[0] - quarters[1])
            return number, bool(np.linalg.norm(quarters[0] - quarters[1][::-1]) < straight)
    return None


def close(runs: list[list[int]], pieces: list[Piece]) -> None:
    """Make one piece of the last and first of a closed curve that no other ends meet between."""
    copied = {piece.copy_of[0] for piece in pieces if piece.copy_of is not None}
    ends = Counter(node for piece in pieces if piece.copy_of is None for node in piece.nodes)
    for run in runs:
        if len(run) < 2:
            continue
        first, last = pieces[run[0]], pieces[run[-1]]
        seam = first.nodes[0]
        ours = first.copy_of is None and last.copy_of is None and not copied & {run[0], run[-1]}
        if not ours or last.nodes[1] != seam or ends[seam] != 2:
            continue
        last.points = np.concatenate([last.points, first.points[1:]])
        last.nodes = (last.nodes[0], first.nodes[1])
        last.length += first.length
        del run[0]


def numbered(
    pieces: list[Piece],
    runs: list[list[int]],
    nodes: dict[int, Node],
    order: list[int],
    turned: list[bool],
    names: list[CurveId],
    strokes: list[CurveId],
    exponent: int,
) -> tuple[Network, tuple[tuple[Step, ...], ...], dict[int, int]]:
    """The network with curves and nodes in the order in which the curves were given.

    Returns it, the walks of the curves, and the new numbers of the nodes that remain.
    """
    walks: list[list[Step]] = [[] for _ in names]
    for run, number, backward in zip(runs, order, turned, strict=True):
        steps = [pieces[piece].copy_of or (piece, False) for piece in run]
        owned = [(piece, way != backward) for piece, way in steps]
        walks[number] = owned[::-1] if backward else owned
    owner = {piece: number for run, number in zip(runs, order, strict=True) for piece in run}
    #: The new number of every piece that stays, and whether it was turned round.
    placed: dict[int, Step] = {}
    numbers: dict[int, int] = {}
    curves: list[Curve] = []
    for number, walk in enumerate(walks):
        for piece, backward in walk:
            if owner[piece] != number or piece in placed:
                continue
            points = np.ldexp(pieces[piece].points, exponent)
            ends = pieces[piece].nodes
            if backward:
                points, ends = np.ascontiguousarray(points[::-1]), ends[::-1]
            first, last = (numbers.setdefault(node, len(numbers)) for node in ends)
            placed[piece] = len(curves), backward
            curves.append(Curve(points, (first, last), names[number], strokes[number]))
    at = np.array([np.ldexp(nodes[node].place, exponent) for node in numbers]).reshape(-1, 3)
    named = tuple(
        tuple((placed[piece][0], way != placed[piece][1]) for piece, way in walk) for walk in walks
    )
    return Network(tuple(curves), at), named, numbers
