"""How many quads each vertex of a loop will get: models of what artists do, and likely assignments.

The corner model judges every vertex by itself. What an artist does at one depends on the others:
loops turn by four corners more often than not, irregular vertices come in pairs of three and five
quads, opposite sides are equally long. So the assignments that are likely vertex by vertex are
listed first, and then put in order by the whole.

The models are fitted by scripts/train_holes.py to holes cut from artists' meshes and shipped as
arrays (patterndb/data/holes.npz).
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from itertools import islice
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from patterndb._native.query.holes.corners import measure, score_trees
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats
from query.holes.symmetry import ASYMMETRIC, follow_mirrors

#: No number of quads is less likely than this, in natural logarithms.
LEAST_LOG = -12.0

#: Quads that a loop vertex may get: 1 (a convex corner) to 4.
MOST_QUADS = 4

#: Assignments that are listed vertex by vertex and put in order by the whole.
LISTED = 300

#: What is looked at, in order; see :func:`measure_assignments`.
TRAITS = (
    "log_corners",
    "turns_by_four",
    "turns_off",
    "turns_off_squared",
    "turns_more",
    "turns_even",
    "irregular",
    "valence_2",
    "valence_3",
    "valence_5",
    "valence_6",
    "all_regular",
    "convex",
    "reflex",
    "full",
    "irregular_pairs",
    "dipoles",
    "corner_pairs",
    "convex_pairs",
    "rectangle",
    "four_sides",
    "closed_side",
)


@dataclass(frozen=True, slots=True, eq=False)
class TreeModel:
    """Trees whose leaves add up to one score or more.

    start:     (t + 1,) int32 where each tree's nodes begin; tree t adds to score t % k.
    feature:   (n,) int16 the number that a node looks at, -1 at a leaf.
    threshold: (n,) float32: not above it the left child is taken, above it the right.
    child:     (n,) int16 left child, counted from the tree's first node; the right is the next.
    value:     (n,) float32 what a leaf adds.
    base:      (k,) float64 the scores without any tree.
    """

    start: Int32Array
    feature: NDArray[np.int16]
    threshold: NDArray[np.float32]
    child: NDArray[np.int16]
    value: NDArray[np.float32]
    base: Floats

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]], prefix: str = "") -> Self:
        """The model whose arrays go by the names of its fields, after the prefix."""
        return cls(**{one.name: arrays[prefix + one.name] for one in fields(cls)})

    def to_arrays(self, prefix: str = "") -> dict[str, NDArray[Any]]:
        """The arrays that :meth:`from_arrays` reads."""
        return {prefix + one.name: getattr(self, one.name) for one in fields(self)}

    def score(self, features: Floats) -> Floats:
        """(n, k) float64 the scores of rows (n, f)."""
        return score_trees(
            np.ascontiguousarray(features, np.float64),
            self.start,
            self.feature,
            self.threshold,
            self.child,
            self.value,
            self.base,
        )


class CornerModel(TreeModel):
    """Trees of which each kind scores a number of quads at a vertex, 1 to 4."""

    def log_probabilities(self, features: Floats) -> Floats:
        """(L, 4) float64: log of the probability of 1 to 4 quads at every vertex (L, f)."""
        scores = self.score(features)
        top = scores.max(axis=1, keepdims=True)
        log_sum = top + np.log(np.exp(scores - top).sum(axis=1, keepdims=True))
        return np.maximum(scores - log_sum, LEAST_LOG)


@dataclass(frozen=True, slots=True, eq=False)
class AssignmentModel:
    """A linear score of assignments, fitted by scripts/train_holes.py: a conditional logit.

    mean, spread: (TRAITS,) by which traits are standardised. weights: (TRAITS,).
    """

    mean: Floats
    spread: Floats
    weights: Floats

    def score_traits(self, traits: Floats) -> Floats:
        """(c,) scores of assignments whose traits (c, TRAITS) are measured."""
        return ((traits - self.mean) / self.spread) @ self.weights

    def score(self, logs: Floats, regular_valence: Int32Array, assignments: Int32Array) -> Floats:
        """(c,) scores of assignments (c, L): the greater, the likelier."""
        return self.score_traits(measure_assignments(logs, regular_valence, assignments))

    def rank(
        self, logs: Floats, regular_valence: Int32Array, mirrors: Int32Array
    ) -> tuple[Int32Array, Floats]:
        """List (c, L) int32 assignments by their scores (c,), greatest first."""
        listed = rank_listed(logs, mirrors)
        scores = self.score(logs, regular_valence, listed) - ASYMMETRIC * ~follow_mirrors(
            listed, mirrors
        )
        order = np.argsort(-scores, kind="stable")
        return listed[order], scores[order]


def rank_listed(logs: Floats, mirrors: Int32Array) -> Int32Array:
    """(c, L) int32 the LISTED assignments most probable vertex by vertex, in that order.

    mirrors: of the loop, see :func:`find_mirrors`. Assignments that follow the first are listed
    before these, as many, pairs of vertices taken as one.
    """
    listed = [quads for _, quads in islice(list_assignments(logs), LISTED)]
    if len(mirrors):
        n = len(logs)
        partner = (mirrors[0] - np.arange(n)) % n
        one = np.minimum(np.arange(n), partner)
        folded, at = np.unique(one, return_inverse=True)
        both = logs[folded] + np.where(
            (partner == np.arange(n))[folded, None], 0, logs[partner[folded]]
        )
        alike = [quads[at] for _, quads in islice(list_assignments(both), LISTED)]
        listed = list({quads.tobytes(): quads for quads in (*alike, *listed)}.values())
    return np.array(listed, np.int32)


def list_assignments(logs: Floats) -> Iterator[tuple[float, Int32Array]]:
    """Yield (L,) quads for every loop vertex, most probable first, with the log probability.

    logs: (L, 4), vertices independent of each other. Each assignment comes once; all of them would
    be 4 ** L. Lazy: the next one is a single change from some that came before (Lawler's partition
    of the rest).
    """
    n = len(logs)
    order = np.argsort(-logs, axis=1, kind="stable")
    ordered = np.take_along_axis(logs, order, axis=1)
    losses = ordered[:, :1] - ordered  # (L, 4), 0 first, ascending
    # Places by the loss of their first change, so that a step is to the next place or rank.
    by_loss = np.argsort(losses[:, 1], kind="stable")
    cost = losses[by_loss].tolist()
    best = float(ordered[:, 0].sum())
    first = (order[:, 0] + 1).astype(np.int32)
    yield best, first
    if not n:
        return
    # A state is the changed places, as (place in by_loss, rank), the last of which may move on.
    heap: list[tuple[float, int, tuple[tuple[int, int], ...]]] = [(cost[0][1], 0, ((0, 1),))]
    serial = 1
    while heap:
        loss, _, changed = heapq.heappop(heap)
        chosen = first.copy()
        for place, rank in changed:
            at = by_loss[place]
            chosen[at] = order[at, rank] + 1
        yield best - loss, chosen
        place, rank = changed[-1]
        rest = changed[:-1]
        following: list[tuple[float, tuple[tuple[int, int], ...]]] = []
        if rank + 1 < MOST_QUADS:
            more = loss - cost[place][rank] + cost[place][rank + 1]
            following.append((more, (*rest, (place, rank + 1))))
        if place + 1 < n:
            following.append((loss + cost[place + 1][1], (*changed, (place + 1, 1))))
            if rank == 1:
                more = loss - cost[place][1] + cost[place + 1][1]
                following.append((more, (*rest, (place + 1, 1))))
        for more, state in following:
            heapq.heappush(heap, (more, serial, state))
            serial += 1


def measure_assignments(
    logs: Floats, regular_valence: Int32Array, assignments: Int32Array
) -> Floats:
    """Measure the traits (c, TRAITS) of assignments (c, L).

    logs: (L, 4) log probabilities of 1 to 4 quads at each vertex. regular_valence: (L,) quads
    that would make each vertex regular.
    """
    return measure(
        np.ascontiguousarray(logs),
        np.ascontiguousarray(regular_valence, np.int32),
        np.ascontiguousarray(assignments, np.int32),
    )
