"""State a counts problem: chains with targets, patches whose sides are made of them; and its cost.

The same network as anywhere in retopology, but as flat arrays of what the choice of counts needs:
nothing here knows where a chain lies.

A patch of N sides has |N - 4| irregular vertices at least, or some of higher valence. Side lengths
that can do with so many have a *regular fill*. The complete family of the database knows which do;
its answer follows from a few inequalities (:func:`has_regular_fill`), which take nanoseconds. By
Gauss and Bonnet no strip of quads leads from a side back to itself, nor to a neighbour of it, if no
vertex has fewer than four quads: what lies across must be long enough, for each side and for each
two neighbours. For 2 to 6 sides this is the family's answer exactly; for more it is sufficient.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from patterndb._native.retopo.counts.rules import find_irregular, is_cheap
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Bools, Floats
from patterndb_sketch.retopo.errors import InvalidRetopoError

#: The fewest edges around a patch.
MIN_PERIMETER = 4

#: Target counts and pinned ones above this are refused: a chain of so many edges is a mistake.
MOST_COUNT = 1_000_000

#: An error of a chain weighs WEIGHT / its target, so that it counts relatively; below SHORT all
#: weigh alike, for a chain of half an edge is not wrong by 100 % with one.
WEIGHT = 3.0
SHORT = 1.5

#: What a patch without a regular fill costs, for new networks: regularity is what one sees.
REGULARITY = 3.0

#: What it costs where curves were laid or drawn along the flow of the surface, so that a patch
#: without a regular fill has two irregular vertices that were not meant. Measured on drafts of
#: penguin, human and goathead: with half of it 0 to 3 more patches are such; with twice, up to 4
#: fewer, of edges that are less even.
FLOW_REGULARITY = 20.0


@dataclass(frozen=True, slots=True, eq=False)
class CountsProblem:
    """What to choose counts for; see :meth:`of` to make one.

    targets:     (c,) float64 > 0, the length of every chain in target edges.
    pinned:      (c,) int32, the count that the user chose, 0 elsewhere.
    first_side:  (p + 1,) int32: the sides of patch f are first_side[f] to first_side[f + 1].
    first_chain: (s + 1,) int32: the chains of side k are chains[first_chain[k]:first_chain[k + 1]].
    chains:      (k,) int32. A chain occurs twice at most, once a side of it; perhaps twice in
                 one patch.
    regularity:  what a patch without a regular fill costs beside errors of counts.
    least:       (c,) int32, the fewest edges a chain may get: 1, or 2 where it alone is a side of
                 a patch with other than 4 sides (there a side of one edge has no strict fill), or
                 4 where it is all of a patch's boundary, or what the caller asks for. Pinned chains
                 keep what the user chose.
    weights:     (c,) float64, the cost of an edge too many or too few.
    ends:        (c, 2) int32, the patches on the two sides of a chain, p for none.
    """

    targets: Floats
    pinned: Int32Array
    first_side: Int32Array
    first_chain: Int32Array
    chains: Int32Array
    regularity: float
    least: Int32Array
    weights: Floats
    ends: Int32Array

    @classmethod
    def of(
        cls,
        targets: ArrayLike,
        patches: Iterable[Sequence[Sequence[int]]],
        pinned: ArrayLike | None = None,
        *,
        regularity: float = REGULARITY,
        least: ArrayLike | None = None,
        urgency: ArrayLike | None = None,
    ) -> CountsProblem:
        """A problem from lists: of every patch its sides, of every side its chains.

        least: the fewest edges of every chain, where it needs more than patches ask for.
        urgency: so many times as much an edge too many or too few of every chain costs, > 0.
        A patch without corners has one side. Where a chain must have as many edges as several
        others together (a seam between two networks), name those instead of it. Raises
        InvalidRetopoError for targets that are not above 0, pinned or least counts below 0,
        chains that do not exist or occur more than twice, sides without chains, and patches
        without sides.
        """
        lists = [[list(side) for side in patch] for patch in patches]
        wanted = np.array(targets, np.float64)
        if wanted.ndim != 1 or not np.all((wanted > 0) & (wanted <= MOST_COUNT)):
            raise InvalidRetopoError(
                f"targets must be one number a chain, above 0 and at most {MOST_COUNT}; "
                "check the lengths of the chains and the target edge"
            )
        if not (np.isfinite(regularity) and 0 <= regularity <= MOST_COUNT):
            raise InvalidRetopoError(
                f"regularity is {regularity}; give a cost of 0 to {MOST_COUNT}, "
                f"such as {REGULARITY}"
            )
        pins = _read_pinned(np.zeros(len(wanted)) if pinned is None else pinned, len(wanted))
        first_side, first_chain, chains = _flatten_patches(lists, len(wanted))
        bounds, ends = _find_bounds(first_side, first_chain, chains, len(wanted))
        if least is not None:
            bounds = np.maximum(bounds, _read_least(least, len(wanted)))
        weights = WEIGHT / np.maximum(wanted, SHORT)
        if urgency is not None:
            weights = weights * np.asarray(urgency, np.float64)
        return cls(
            wanted,
            pins,
            first_side,
            first_chain,
            chains,
            float(regularity),
            bounds,
            weights,
            ends,
        )

    @property
    def n_chains(self) -> int:
        return len(self.targets)

    @property
    def n_patches(self) -> int:
        return len(self.first_side) - 1

    def with_pinned(self, chain: int, count: int) -> CountsProblem:
        """The same with one more chain pinned, or freed with a count of 0.

        Raises InvalidRetopoError for a chain that does not exist and a count below 0.
        """
        if not 0 <= chain < self.n_chains:
            raise InvalidRetopoError(f"there is no chain {chain}; there are {self.n_chains}")
        pinned = self.pinned.copy()
        pinned[chain] = min(count, MOST_COUNT + 1)
        return replace(self, pinned=_read_pinned(pinned, self.n_chains))

    def with_regularity(self, regularity: float) -> CountsProblem:
        """The same with another cost of patches without a regular fill."""
        return replace(self, regularity=float(regularity))

    def side_lengths(self, counts: Int32Array) -> Int32Array:
        """(s,) int32: the edges of every side."""
        if not len(self.chains):
            return np.zeros(0, np.int32)
        return np.add.reduceat(counts[self.chains], self.first_chain[:-1]).astype(np.int32)

    def perimeters(self, counts: Int32Array) -> Int32Array:
        """(p,) int32: the edges around every patch."""
        if not self.n_patches:
            return np.zeros(0, np.int32)
        lengths = self.side_lengths(counts)
        return np.add.reduceat(lengths, self.first_side[:-1]).astype(np.int32)

    def errors(self, counts: Int32Array) -> Floats:
        """(c,) float64: what the counts of chains cost."""
        return self.weights * np.abs(counts - self.targets)

    def find_irregular_patches(self, counts: Int32Array) -> Bools:
        """Find the patches without a regular fill: (p,) bool."""
        return find_irregular(self.first_side, self.side_lengths(counts))

    def sum_costs(self, counts: Int32Array) -> float:
        """Sum the errors of all chains and the costs of all patches without a regular fill."""
        n_irregular = int(self.find_irregular_patches(counts).sum())
        return float(self.errors(counts).sum()) + self.regularity * n_irregular

    def patch_chains(self, patch: int) -> Int32Array:
        """The chains around a patch, one that occurs twice named twice."""
        low, high = self.first_chain[self.first_side[patch : patch + 2]]
        return self.chains[low:high]


def _read_pinned(pinned: ArrayLike, n_chains: int) -> Int32Array:
    given = np.array(pinned)
    if given.shape != (n_chains,) or not np.all((given >= 0) & (given <= MOST_COUNT)):
        raise InvalidRetopoError(
            f"pinned counts must be one whole number a chain, 1 to {MOST_COUNT}, or 0 where the "
            "user has chosen none"
        )
    if not np.all(given == np.floor(given)):
        raise InvalidRetopoError("a pinned count is not a whole number; pin whole edges")
    return given.astype(np.int32)


def _read_least(least: ArrayLike, n_chains: int) -> Int32Array:
    given = np.array(least)
    whole = given.shape == (n_chains,) and bool(np.all(given == np.floor(given)))
    if not whole or not np.all((given >= 0) & (given <= MOST_COUNT)):
        raise InvalidRetopoError(
            f"least counts must be one whole number a chain, 0 to {MOST_COUNT}"
        )
    return given.astype(np.int32)


def _flatten_patches(
    patches: list[list[list[int]]], n_chains: int
) -> tuple[Int32Array, Int32Array, Int32Array]:
    for number, patch in enumerate(patches):
        if not patch:
            raise InvalidRetopoError(f"patch {number} has no side; a loop without corners has one")
        for at, side in enumerate(patch):
            if not side:
                raise InvalidRetopoError(f"side {at} of patch {number} has no chain; name its own")
            for chain in side:
                if not 0 <= chain < n_chains:
                    raise InvalidRetopoError(
                        f"side {at} of patch {number} names chain {chain}, but there are only "
                        f"{n_chains}, from 0 on"
                    )
    sides = [side for patch in patches for side in patch]
    first_side = np.cumsum([0] + [len(patch) for patch in patches]).astype(np.int32)
    first_chain = np.cumsum([0] + [len(side) for side in sides]).astype(np.int32)
    chains = np.array([chain for side in sides for chain in side], np.int32)
    return first_side, first_chain, chains


def _find_bounds(
    first_side: Int32Array, first_chain: Int32Array, chains: Int32Array, n_chains: int
) -> tuple[Int32Array, Int32Array]:
    """Find the fewest edges of chains, and the patches beside them."""
    n_patches = len(first_side) - 1
    least = np.ones(n_chains, np.int32)
    ends = np.full((n_chains, 2), n_patches, np.int32)
    used = np.zeros(n_chains, np.int32)
    for patch in range(n_patches):
        low, high = int(first_side[patch]), int(first_side[patch + 1])
        for side in range(low, high):
            of_side = chains[first_chain[side] : first_chain[side + 1]]
            for chain in of_side:
                if used[chain] == 2:
                    raise InvalidRetopoError(
                        f"chain {chain} occurs a third time, in patch {patch}; a chain has two "
                        "sides, and a patch on each at most"
                    )
                ends[chain, used[chain]] = patch
                used[chain] += 1
            if len(of_side) == 1 and high - low != 4:
                alone = MIN_PERIMETER if high - low == 1 else 2
                least[of_side[0]] = max(least[of_side[0]], alone)
    return least, ends


def has_regular_fill(lengths: tuple[int, ...]) -> bool:
    """Has a patch of these side lengths, each 1 or more, a fill of |N - 4| irregular vertices?

    Those on the boundary count with those inside. All need an even perimeter. N = 4: opposite
    sides are equal. N = 3: no side is longer than the others together. N >= 5: no side is longer
    than those that do not touch it, and no two neighbours are longer than all others. N < 3: all.

    Where it is False for 7 sides or more, a fill of so many may exist all the same, with a vertex
    of valence 3 between corners of three quads.
    """
    return bool(is_cheap(np.array(lengths, np.int32), 0, len(lengths)))
