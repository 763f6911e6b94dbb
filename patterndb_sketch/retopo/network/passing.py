"""In which order a curve crosses chains: that in which faces follow each other.

Where chains lie on each other, or cross next to a place, rounding says which a curve meets first.
The faces of the network say it for certain: crossing a chain leads from the face on its one side
to that on its other, and the next chain that is crossed, of the same part of the network, has
that face on its near side.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb_sketch.retopo.network.structure import Chain, HalfChain, Node
from patterndb_sketch.retopo.network.walks import joined_chains, walked

#: Steps after which the search for an order is given up; among a few crossings at one place it
#: takes tens.
MOST_STEPS = 1000


def in_order(
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
                face.update(dict.fromkeys(walked(nodes, chains, side), side))
        if half >> 1 not in part:
            part.update(dict.fromkeys(joined_chains(nodes, chains, half >> 1), half >> 1))
    steps = [Step(part[half >> 1], face[half], face[half ^ 1]) for half in crossed]
    return first_order(steps, along, near)


@dataclass(frozen=True, slots=True)
class Step:
    """Of a crossing: the part of the network, and the faces that it leads from and to."""

    part: int
    before: int
    after: int


def first_order(steps: Sequence[Step], along: NDArray[np.float64], near: float) -> list[int]:
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
