"""The linear systems that widths solve: of one pattern, and of all signatures of a class.

For every side s the widths of the polychords that end on it add up to the edges asked
for; a polychord with both ends on s counts twice (Marcias et al. 2015, section 4). The
polychords of one pattern that join the same two sides form a *class*: only the sum of
their widths matters to the sides. With slack = edges asked for - base length, the sums
solve an uncapacitated b-matching on the sides (rust/query/src/solving/matching.rs).

:class:`Chords` is the system of one pattern. :class:`Systems` has those of a class of patterns
ready for testing: every signature stands for one system, a graph whose nodes are the sides and
whose edges are the classes of polychords that join them.
"""

from __future__ import annotations

import weakref
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb._native.query.solving.jointclaims import list_joint_claims
from patterndb._native.query.solving.systems import fill, number_claims
from patterndb.core.halfedge import Int32Array
from patterndb.core.patternclass import PatternClass

Int16Array = NDArray[np.int16]

#: Sides of the largest graphs with joint claims, as in rust/query/src/solving/jointclaims.rs.
MOST_SIDES = 15


@dataclass(frozen=True, slots=True)
class Chords:
    """Open polychords in label order, and their classes in order of (i, j).

    n_sides: number of sides, at least 1 (one closed side is a side like any other).
    edges:   (2 n,) int32, the polychord that crosses each edge when all widths are 1, side by
             side.
    side_start: (n_sides + 1,) int32, where each side begins in ``edges``.
    sides:   (n, 2) int32, the two sides i <= j that each polychord joins.
    class_i, class_j: (m,) int32, the sides that each class joins.
    class_n: (m,) int32 >= 1, how many polychords the class has.
    class_of: (n,) int32, the class of each polychord.
    """

    n_sides: int
    edges: Int32Array
    side_start: Int32Array
    sides: Int32Array
    class_i: Int32Array
    class_j: Int32Array
    class_n: Int32Array
    class_of: Int32Array

    @classmethod
    def from_label(cls, label: Sequence[Sequence[int]]) -> Chords:
        """From a boundary label: per side, the polychord that crosses each edge."""
        edges = np.array([chord for side in label for chord in side], np.int32)
        start = np.cumsum([0, *map(len, label)]).astype(np.int32)
        side_of = np.repeat(np.arange(len(label), dtype=np.int32), np.diff(start))
        # The two edges of each polychord stand together once sorted by polychord.
        pairs = side_of[np.argsort(edges, kind="stable")].reshape(-1, 2)
        n_sides = len(label)
        key, class_of, count = np.unique(
            pairs[:, 0] * n_sides + pairs[:, 1], return_inverse=True, return_counts=True
        )
        return cls(
            n_sides,
            edges,
            start,
            pairs,
            (key // n_sides).astype(np.int32),
            (key % n_sides).astype(np.int32),
            count.astype(np.int32),
            class_of.ravel().astype(np.int32),
        )

    @classmethod
    def from_sides(cls, n_sides: int, sides: ArrayLike) -> Chords:
        """From the two sides, in either order, of every polychord; (n, 2).

        Along every side they come in the order given: right where only sums matter.
        """
        label: list[list[int]] = [[] for _ in range(n_sides)]
        for chord, pair in enumerate(np.asarray(sides, np.int32).reshape(-1, 2).tolist()):
            for side in pair:
                label[side].append(chord)
        return cls.from_label(label)

    @property
    def n(self) -> int:
        """How many open polychords there are."""
        return len(self.sides)

    def base_lengths(self) -> Int32Array:
        """(n_sides,) int32 edges of every side when all widths are 1."""
        return np.bincount(self.sides.ravel(), minlength=self.n_sides).astype(np.int32)

    def side_lengths(self, widths: ArrayLike) -> NDArray[np.int64]:
        """(n_sides,) int64 edges of every side with the given widths (n,)."""
        ends = np.repeat(np.asarray(widths, np.int64), 2)
        lengths = np.zeros(self.n_sides, np.int64)
        np.add.at(lengths, self.sides.ravel(), ends)
        return lengths


#: The most that is told of a side's neighbours: what the sieve of :mod:`query.solving.feasibility`
#: has room for. A greater surplus is a weaker sieve, no other answer.
MOST_SURPLUS = 127

#: The longest base length that the sieve tells from longer ones, so that two are one byte. Those of
#: half a million patterns of 12 sides are 14 at most.
LONGEST_BASE = 15


class Graphs(NamedTuple):
    """The graphs of s systems of w sides and of c classes in all.

    A named tuple, which the compiled core takes whole.

    first:      (s + 1,) int32 graph r has the classes first[r]..first[r + 1] - 1.
    class_i, class_j: (c,) int16 the sides that a class joins, in the order in which
                the flow fills them.
    claim:      (s, w) int32 what a side asks of its neighbours: a *claim* is a side and the sides
                that it is joined to. There are far fewer of them than sides of all graphs.
    near_first: (k + 1,) int32 the sides of claim q are near[near_first[q] : near_first[q + 1]].
    near:       (d,) int16; a side joined to itself is listed once.
    """

    first: Int32Array
    class_i: Int16Array
    class_j: Int16Array
    claim: Int32Array
    near_first: Int32Array
    near: Int16Array


class Systems(NamedTuple):
    """All that a query needs of s signatures.

    graphs:     the sides that their polychords join.
    base:       (s, w) int16 base length of every side.
    pairs:      (s, ceil(w / 2)) uint8 of each two sides (LONGEST_BASE + 1) * a + b, where a and b
                are their base lengths, at most LONGEST_BASE; b is 0 where there is one side more.
    perimeter:  (s,) int32 sum of the base lengths.
    surplus:    (s, w) uint8 one more than what the base lengths of a side's neighbours have beyond
                its own, at most MOST_SURPLUS; 0 where it is joined to itself: it asks no other.
    claimant:   (k,) int16 the side that makes a claim.
    component, colour: (s, w) int16 of :func:`query.solving.systems.two_colour`.
    parity:     (s,) bool can parity refuse an even perimeter? Not in a graph that is in one
                piece and has an odd cycle.
    graph, joint_first, joint: of :func:`list_joint_claims`; or one graph for all, without claims.
    """

    graphs: Graphs
    base: Int16Array
    pairs: NDArray[np.uint8]
    perimeter: Int32Array
    surplus: NDArray[np.uint8]
    claimant: Int16Array
    component: Int16Array
    colour: Int16Array
    parity: NDArray[np.bool_]
    graph: Int32Array
    joint_first: Int32Array
    joint: Int32Array


#: The systems of the classes in use, by the identity of their joins, and what keeps them
#: apart from a later array at the same address.
_known: dict[int, tuple[weakref.ref[NDArray[np.integer]], Systems]] = {}

#: The name of systems among what is kept of a class; changed whenever what they hold is.
SHELVED_SYSTEMS = "systems-3"


class SignedRows(Protocol):
    """Rows with signatures: patterns of a class, or marked patterns of as many sides.

    The fields are those of :class:`patterndb.core.patternclass.PatternClass`.
    """

    @property
    def signature(self) -> Int32Array: ...
    @property
    def rotation(self) -> Int32Array: ...
    @property
    def reflected(self) -> NDArray[np.bool_]: ...
    @property
    def lengths(self) -> NDArray[np.integer]: ...
    @property
    def joins(self) -> NDArray[np.integer]: ...


def systems_of(patterns: SignedRows) -> Systems:
    """The systems of the rows; made at the first call, and kept as long as the rows are."""
    key = id(patterns.joins)
    known = _known.get(key)
    if known is not None and known[0]() is patterns.joins:
        return known[1]
    cache = patterns.cache if isinstance(patterns, PatternClass) else None
    if cache is None:
        made = make_systems(patterns.lengths, patterns.joins)
    else:
        made = _from_arrays(
            cache.find_or_make(
                f"{patterns.lengths.shape[1]}-{SHELVED_SYSTEMS}",
                lambda: _to_arrays(make_systems(patterns.lengths, patterns.joins, jointly=True)),
            )
        )

    def forget(gone: weakref.ref[NDArray[np.integer]]) -> None:
        if _known.get(key, (None,))[0] is gone:
            del _known[key]

    _known[key] = weakref.ref(patterns.joins, forget), made
    return made


def _to_arrays(systems: Systems) -> dict[str, NDArray[Any]]:
    """The arrays of systems by name, those of the graphs among them."""
    return systems.graphs._asdict() | {
        name: array for name, array in systems._asdict().items() if name != "graphs"
    }


def _from_arrays(arrays: Mapping[str, NDArray[Any]]) -> Systems:
    """What :func:`_to_arrays` gave."""
    graphs = Graphs(*(arrays[name] for name in Graphs._fields))
    return Systems(graphs, *(arrays[name] for name in Systems._fields[1:]))


def make_systems(
    lengths: NDArray[np.integer], joins: NDArray[np.integer], *, jointly: bool = False
) -> Systems:
    """The systems of (s, w) base lengths and (s, w, w) joins; see :class:`SignedRows`.

    jointly: with joint claims, which take longer to list than all else and pay where it is kept.
    """
    s, w = lengths.shape
    joined = joins > 0
    n_loops = int(np.diagonal(joined, axis1=1, axis2=2).sum())
    n_classes = (int(joined.sum()) + n_loops) // 2
    # Longer than any boundary is long enough.
    base = np.minimum(lengths.astype(np.int32), np.iinfo(np.int16).max).astype(np.int16)
    claim, claimant, near_first, near = number_claims(joined)
    graphs = Graphs(
        first=np.zeros(s + 1, np.int32),
        class_i=np.empty(n_classes, np.int16),
        class_j=np.empty(n_classes, np.int16),
        claim=claim,
        near_first=near_first,
        near=near,
    )
    graph, joint_first, joint = np.zeros(s, np.int32), np.zeros(2, np.int32), np.zeros(0, np.int32)
    if jointly and w <= MOST_SIDES:
        graph, joint_first, joint = list_joint_claims(claim, near_first, near)
    made = Systems(
        graphs,
        base=base,
        pairs=_pair_sides(base),
        perimeter=lengths.sum(axis=1, dtype=np.int32),
        surplus=np.empty((s, w), np.uint8),
        claimant=claimant,
        component=np.empty((s, w), np.int16),
        colour=np.empty((s, w), np.int16),
        parity=np.empty(s, np.bool_),
        graph=graph,
        joint_first=joint_first,
        joint=joint,
    )
    fill(made, joined)
    return made


def _pair_sides(base: Int16Array) -> NDArray[np.uint8]:
    """The base lengths (s, w) of each two sides as one number: see :class:`Systems`."""
    even = np.pad(np.minimum(base, LONGEST_BASE), ((0, 0), (0, base.shape[1] % 2)))
    return ((LONGEST_BASE + 1) * even[:, ::2] + even[:, 1::2]).astype(np.uint8)
