"""Where among the ends of a node a new one goes: by what it crosses, or by where it points."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from patterndb_sketch.retopo.network.order import wedge_for
from patterndb_sketch.retopo.network.structure import Chain, HalfChain, Node


@dataclass(frozen=True, slots=True)
class Gap:
    """Where around a node a new curve goes, if that is known without looking at angles.

    half: an end of the node; left: the new curve is next to it on its left, else on its right.
    off:  how far along ``half`` the curve crosses it, if it was taken to the node from there:
          of several curves in one gap, those that cross further off are nearer to ``half``.
    """

    half: HalfChain
    left: bool
    off: float = 0.0


def beside(
    at: Node,
    gap: Gap,
    given: Mapping[HalfChain, Gap],
    now: Callable[[HalfChain], HalfChain],
) -> int:
    """The wedge that a gap is: beyond the ends that are in it and nearer to its half-chain.

    given: the gaps of ends that were put there by one. now: the half-chain that one of before
    a cut is.
    """
    n = at.valence
    half = now(gap.half)
    step = 1 if gap.left else -1
    j = at.ends.index(half)
    for _ in range(n):
        other = given.get(at.ends[(j + step) % n])
        if other is None or other.left != gap.left or other.off <= gap.off:
            break
        if now(other.half) != half:
            break
        j = (j + step) % n
    return j if gap.left else (j - 1) % n


def pointed_into(
    at: Node,
    half: HalfChain,
    reach: float,
    chains: Mapping[int, Chain],
    given: Mapping[HalfChain, Gap],
    now: Callable[[HalfChain], HalfChain],
) -> int:
    """The wedge that a half-chain points into, over an arc length ``reach``.

    Ends whose gaps were given say nothing by their directions: they were led to the node from
    a little off it, and lie beside the half-chains that they cross.
    """
    old = [h for h in at.ends if h not in given]
    # The left of an end: never beyond the border of the surface.
    free = [j for j, h in enumerate(old) if not chains[h >> 1].marks[h & 1]]
    ends = [(chains[end >> 1].points, bool(end & 1)) for end in old]
    new = (chains[half >> 1].points, bool(half & 1))
    j = wedge_for(at.normal, ends, new, reach, free or range(len(old)))
    return beside(at, Gap(old[j], True, -1.0), given, now)
