"""Patterns of holes: what artists' fills of holes reduce to, and where each may lie in a loop.

The database knows patches of a mesh, small ones and convex ones. A hole is grown from a face or a
vertex, has reflex corners, and its pattern is one of a few thousand that come back from mesh to
mesh. scripts/train_holes.py cuts holes, reduces them, and counts in how many kinds of meshes each
pattern was met. Here every pattern is tried in every way that it may lie in a loop: all
widths of its polychords, all turns, both hands; by how likely its corners are there, and by how
often artists make it.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from patterndb.core import description as d
from patterndb.core.code import pattern_id
from patterndb.core.halfedge import Int32Array
from patterndb.core.label import split_word
from patterndb.core.packing import unpack
from patterndb.core.pattern import Pattern
from patterndb.geometry.points import Floats
from patterndb.system.kernels import kernel

#: Ways to lie that are kept of all that were tried.
KEPT = 250

#: Steps after which no more is looked for of one pattern. A pattern of few corners lies in a long
#: loop in thousands of ways, all about as likely; the database solves for those.
MOST_LOOKED = 20_000

#: Ways that are less likely than the best by a factor of exp(this) are not looked at to the end.
REACH = 10.0

#: How much it counts that a pattern is frequent, beside how likely its corners are.
SHARE = 0.5

#: Longer loops are left to the database: holes that patterns were gathered from have fewer edges.
MOST_EDGES = 64

#: Patterns with more open polychords are not kept.
MOST_CHORDS = 40


@dataclass(frozen=True, slots=True)
class Lie:
    """One way that a pattern lies in a loop.

    pattern: its row. widths: of its open polychords. turn: the loop's vertex at which the pattern's
    corner 0 lies. mirrored: does the pattern run backwards along the loop?
    """

    pattern: int
    widths: tuple[int, ...]
    turn: int
    mirrored: bool


@dataclass(frozen=True, eq=False)
class HolePatterns:
    """Patterns of holes, and how often they were met.

    codes: their codes, packed, one after another; code i is codes[ends[i]:ends[i + 1]].
    meshes: (p,) kinds of meshes in which each was met; those that share topology are one kind.
    share: (p,) the part of all holes that it is, each kind of mesh counting alike.
    """

    codes: NDArray[np.uint8]
    ends: Int32Array
    meshes: NDArray[np.int32]
    share: NDArray[np.float64]

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> HolePatterns:
        """The patterns of arrays by name."""
        return cls(
            arrays["pattern_codes"],
            arrays["pattern_ends"],
            arrays["pattern_meshes"],
            arrays["pattern_share"].astype(np.float64),
        )

    def __len__(self) -> int:
        return len(self.meshes)

    @cached_property
    def _blobs(self) -> list[bytes]:
        data = self.codes.tobytes()
        return [data[a:b] for a, b in itertools.pairwise(self.ends.tolist())]

    @cached_property
    def _tables(self) -> _Tables:
        return _Tables.of(d.describe(self._blobs))

    @cached_property
    def _rows(self) -> dict[int, int]:
        sides = self._tables.n_sides.tolist()
        return {
            pattern_id(unpack(blob).astype(np.uint16), n): row
            for row, (blob, n) in enumerate(zip(self._blobs, sides, strict=True))
        }

    @cached_property
    def _made(self) -> dict[int, Pattern]:
        return {}

    def row_of(self, number: int) -> int:
        """The row of a pattern by its id; -1 where it is none of these."""
        return self._rows.get(number, -1)

    def pattern(self, row: int) -> Pattern:
        """The pattern in a row, as one that was learned."""
        if row not in self._made:
            code = unpack(self._blobs[row]).astype(np.uint16)
            self._made[row] = Pattern.from_trusted_code(code)
        return self._made[row]

    def find_lies(self, logs: Floats, most: int = KEPT) -> tuple[list[Lie], Int32Array]:
        """Find the likeliest ways in which patterns lie in a loop.

        logs: (L, 4) log probabilities of 1 to 4 quads at each vertex. Returns the ways, likeliest
        first, and the quads (c, L) that each has at the loop's vertices.
        """
        n = len(logs)
        if n % 2 or n > MOST_EDGES or not len(self):
            return [], np.zeros((0, n), np.int32)
        t = self._tables
        loss = np.zeros((2, 2 * n, 5))
        loss[0, :n, 1:] = logs.max(axis=1, keepdims=True) - logs
        loss[1, :n] = loss[0, (-np.arange(n)) % n]
        loss[:, n:] = loss[:, :n]
        found = _find_lies(
            loss,
            n,
            t.first_side,
            t.corner,
            t.first_edge,
            t.chord,
            t.n_chords,
            t.chiral,
            SHARE * np.log(self.share),
            most,
        )
        scores, row, turn, mirrored, widths = found
        order = np.argsort(-scores, kind="stable")
        lies: list[Lie] = []
        quads = np.full((len(order), n), 2, np.int32)
        for at, i in enumerate(order.tolist()):
            p = int(row[i])
            chords = int(t.n_chords[p])
            lie = Lie(p, tuple(widths[i, :chords].tolist()), int(turn[i]), bool(mirrored[i]))
            lies.append(lie)
            places, corners = self._places(lie)
            quads[at, (lie.turn + (-places if lie.mirrored else places)) % n] = corners
        return lies, quads

    def first_vertex(self, lie: Lie) -> int:
        """The loop's vertex that is vertex 0 of the pattern's expansion, turned by 0."""
        if not lie.mirrored:
            return lie.turn
        t = self._tables
        if t.n_sides[lie.pattern] <= 1:
            return lie.turn - (t.n_sides[lie.pattern] == 0)
        a = t.first_side[lie.pattern]
        edges = t.chord[t.first_edge[a] : t.first_edge[a + 1]]
        return lie.turn - int(np.array(lie.widths)[edges].sum())

    def _places(self, lie: Lie) -> tuple[NDArray[np.int64], Int32Array]:
        """Where the pattern's corners lie along its boundary, and the quads at each."""
        t = self._tables
        a, b = int(t.first_side[lie.pattern]), int(t.first_side[lie.pattern + 1])
        if t.n_sides[lie.pattern] == 0:
            return np.zeros(0, np.int64), np.zeros(0, np.int32)
        first = int(t.first_edge[a])
        edges = t.chord[first : int(t.first_edge[b])]
        along = np.zeros(len(edges) + 1, np.int64)
        along[1:] = np.cumsum(np.array(lie.widths)[edges])
        return along[t.first_edge[a:b] - first], t.corner[a:b]


@dataclass(frozen=True, slots=True, eq=False)
class _Tables:
    """What the search needs of all patterns, in flat arrays.

    n_sides, n_chords, chiral: (p,). first_side: (p + 1,) where each pattern's sides begin; one side
    where it has no corner. corner: (s,) quads at the corner where a side begins, 0 where there is
    none. first_edge: (s + 1,) where its edges begin. chord: (e,) the polychord across each.
    """

    n_sides: Int32Array
    n_chords: Int32Array
    chiral: NDArray[np.bool_]
    first_side: Int32Array
    corner: Int32Array
    first_edge: Int32Array
    chord: Int32Array

    @classmethod
    def of(cls, rows: d.Descriptions) -> _Tables:
        """The tables of descriptions."""
        counts = rows.counts
        first_side, corner, first_edge, chord = [0], [], [0], []
        for row in range(len(counts)):
            n = int(counts[row, d.N_CORNERS])
            corners = rows.numbers(row, d.CORNERS).tolist() if n else [0]
            label = split_word(rows.numbers(row, d.LABEL), n)
            for quads, side in zip(corners, label, strict=True):
                corner.append(quads)
                chord += list(side)
                first_edge.append(len(chord))
            first_side.append(len(corner))
        return cls(
            counts[:, d.N_CORNERS].copy(),
            counts[:, d.N_CHORDS].copy(),
            counts[:, d.CHIRAL] != 0,
            *(np.array(one, np.int32) for one in (first_side, corner, first_edge, chord)),
        )


@kernel
def _find_lies(
    loss: Floats,
    n: int,
    first_side: Int32Array,
    corner: Int32Array,
    first_edge: Int32Array,
    chord: Int32Array,
    n_chords: Int32Array,
    chiral: NDArray[np.bool_],
    prior: Floats,
    most: int,
) -> tuple[Floats, Int32Array, Int32Array, NDArray[np.bool_], Int32Array]:
    """The likeliest lies: (c,) scores, patterns, turns, mirrored, and (c, MOST_CHORDS) widths.

    loss: (2, 2 n, 5) how much less likely 1 to 4 quads at a loop vertex are than the likeliest
    number, twice around; and the same backwards. A pattern is laid along its boundary edge by edge:
    a polychord that is met first may have any width, and is as wide where it comes out. What is
    lost never shrinks, so that a way is left where it has lost too much.
    """
    score = np.empty(most)
    row = np.empty(most, np.int32)
    turn = np.empty(most, np.int32)
    mirrored = np.empty(most, np.bool_)
    widths = np.zeros((most, MOST_CHORDS), np.int32)
    count = 0
    worst = 0
    floor = -np.inf
    # passed[h, i]: lost by vertices before i that get two quads.
    passed = np.zeros((2, 2 * n + 1))
    for hand in range(2):
        for i in range(2 * n):
            passed[hand, i + 1] = passed[hand, i] + loss[hand, i, 2]
    bound = _bound_patterns(loss[0], n, first_side, corner, prior)
    order = np.argsort(-bound)
    rest = _bound_stretches(loss, n)
    ahead = np.empty((2 * MOST_CHORDS + 1, 5), np.int32)
    width = np.zeros(MOST_CHORDS, np.int32)
    first_met = np.empty(2 * MOST_CHORDS, np.bool_)
    kind = np.empty(2 * MOST_CHORDS + 1, np.int32)
    at = np.empty(2 * MOST_CHORDS + 1, np.int32)
    spare = np.empty(2 * MOST_CHORDS + 1, np.int32)
    lost = np.empty(2 * MOST_CHORDS + 1)
    for p in order:
        if bound[p] <= floor:
            break
        c = n_chords[p]
        if c > MOST_CHORDS or c < 1 or n // 2 < c:
            continue
        begin = first_edge[first_side[p]]
        edges = 2 * c
        for e in range(edges + 1):
            kind[e] = 2
        for s in range(first_side[p], first_side[p + 1]):
            if corner[s] > 0:
                kind[first_edge[s] - begin] = corner[s]
        for k in range(5):
            ahead[edges, k] = 0
        for e in range(edges - 1, -1, -1):
            for k in range(5):
                ahead[e, k] = ahead[e + 1, k]
            if e + 1 < edges and 0 < kind[e + 1] < 5:
                ahead[e, kind[e + 1]] += 1
        for e in range(edges):
            first_met[e] = True
            for f in range(e):
                if chord[begin + f] == chord[begin + e]:
                    first_met[e] = False
        looked = 0
        last_met = 0
        for e in range(edges):
            if first_met[e]:
                last_met = e
        for hand in range(2 if chiral[p] else 1):
            for r in range(n):
                if kind[0] > 4 or looked >= MOST_LOOKED:
                    continue
                e = 0
                at[0] = r
                spare[0] = n // 2 - c
                lost[0] = loss[hand, r, kind[0]]
                if prior[p] - lost[0] <= floor:
                    continue
                width[chord[begin]] = 0
                while e >= 0:
                    looked += 1
                    if looked >= MOST_LOOKED:
                        break
                    # Widen the polychord at edge e by one, or step back.
                    x = chord[begin + e]
                    if first_met[e]:
                        if e == last_met:
                            # The last polychord to be met takes all that is spare.
                            width[x] = spare[e] + 1 if width[x] == 0 else spare[e] + 2
                        else:
                            width[x] += 1
                        if width[x] - 1 > spare[e]:
                            e -= 1
                            continue
                    elif width[x] < 0:
                        width[x] = -width[x]
                        e -= 1
                        continue
                    w = width[x]
                    there = at[e] + w
                    left = spare[e] - (w - 1 if first_met[e] else 0)
                    off = lost[e] + passed[hand, there] - passed[hand, at[e] + 1]
                    if e + 1 < edges:
                        k = kind[e + 1]
                        off += loss[hand, there, k]
                        span = r + n - 1 - there
                        off_least = off
                        for m in (1, 3, 4):
                            off_least += rest[hand, (there + 1) % n, span, m, ahead[e + 1, m]]
                        off_least += passed[hand, r + n] - passed[hand, there + 1]
                    else:
                        off_least = off
                    if prior[p] - off_least <= floor:
                        # Wider still loses more only where what is passed does.
                        if first_met[e]:
                            gone = passed[hand, there] - passed[hand, at[e] + 1]
                            if prior[p] - lost[e] - gone <= floor:
                                e -= 1
                        else:
                            e -= 1
                        continue
                    if not first_met[e]:
                        width[x] = -w  # been here
                    if e + 1 < edges:
                        e += 1
                        at[e] = there
                        spare[e] = left
                        lost[e] = off
                        if first_met[e]:
                            width[chord[begin + e]] = 0
                        continue
                    if left > 0:
                        continue
                    place = count
                    if count < most:
                        count += 1
                    else:
                        place = worst
                    score[place] = prior[p] - off
                    row[place] = p
                    turn[place] = (n - r) % n if hand else r
                    mirrored[place] = hand == 1
                    for i in range(c):
                        widths[place, i] = abs(width[i])
                    widths[place, c:] = 0
                    if count == most:
                        worst = 0
                        for i in range(1, most):
                            if score[i] < score[worst]:
                                worst = i
                        floor = max(floor, score[worst])
                    floor = max(floor, score[place] - REACH)
    return score[:count], row[:count], turn[:count], mirrored[:count], widths[:count]


@kernel
def _bound_patterns(
    loss: Floats, n: int, first_side: Int32Array, corner: Int32Array, prior: Floats
) -> Floats:
    """(p,) what the score of each pattern cannot exceed, however it lies.

    Where it has m corners of k quads, all but m of the loop's vertices get another number.
    """
    saved = np.zeros((5, n + 1))
    least = 0.0
    for i in range(n):
        least += loss[i, 2]
    for k in range(5):
        if k == 0 or k == 2:
            continue
        gain = np.sort(loss[:n, k] - loss[:n, 2])
        for i in range(n):
            saved[k, i + 1] = saved[k, i] + gain[i]
    bound = np.empty(len(prior))
    numbers = np.empty(5, np.int64)
    for p in range(len(prior)):
        numbers[:] = 0
        far = False
        for s in range(first_side[p], first_side[p + 1]):
            if corner[s] > 4:
                far = True
            elif corner[s] > 0:
                numbers[corner[s]] += 1
        total = least
        for k in range(1, 5):
            if numbers[k] > n:
                far = True
            elif k != 2:
                total += saved[k, numbers[k]]
        bound[p] = -np.inf if far else prior[p] - max(total, 0.0)
    return bound


@kernel
def _bound_stretches(loss: Floats, n: int) -> Floats:
    """(2, n, n, 5, n + 1) what m corners of k quads among ``span`` vertices from i on lose at
    least, beyond what all of them lose with two quads: [hand, i, span, k, m]."""
    rest = np.zeros((2, n, n, 5, n + 1))
    ordered = np.empty(n)
    for hand in range(2):
        for i in range(n):
            for k in range(1, 5):
                if k == 2:
                    continue
                for span in range(n):
                    if span > 0:
                        v = i + span - 1
                        gain = loss[hand, v, k] - loss[hand, v, 2]
                        j = span - 1
                        while j > 0 and ordered[j - 1] > gain:
                            ordered[j] = ordered[j - 1]
                            j -= 1
                        ordered[j] = gain
                    for m in range(1, n + 1):
                        if m <= span:
                            rest[hand, i, span, k, m] = (
                                rest[hand, i, span, k, m - 1] + ordered[m - 1]
                            )
                        else:
                            rest[hand, i, span, k, m] = np.inf
    return rest
