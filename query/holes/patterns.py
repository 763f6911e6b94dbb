"""Patterns of holes: what artists' fills of holes reduce to, and their embeddings in a loop.

The database knows patches of a mesh, small ones and convex ones. A hole is grown from a face or a
vertex, has reflex corners, and its pattern is one of a few thousand that come back from mesh to
mesh. scripts/train_holes.py cuts holes, reduces them, and counts in how many kinds of meshes each
pattern was met. Here every embedding of every pattern in a loop is tried: all
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

from patterndb._native.query.holes.patterns import enumerate_embeddings
from patterndb.core import description as d
from patterndb.core.code import pattern_id
from patterndb.core.halfedge import Int32Array
from patterndb.core.label import split_word
from patterndb.core.packing import unpack
from patterndb.core.pattern import Pattern
from patterndb.geometry.points import Floats
from query.cancellation import flag_deadline

#: Embeddings that are kept of all that were tried.
KEPT = 250


#: Ways that are less likely than the best by a factor of exp(this) are not looked at to the end.
REACH = 10.0

#: How much it counts that a pattern is frequent, beside how likely its corners are.
SHARE = 0.5

#: Longer loops are left to the database: holes that patterns were gathered from have fewer edges.
MOST_EDGES = 64


@dataclass(frozen=True, slots=True)
class PatternEmbedding:
    """An embedding of a pattern in a loop.

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
    def _tables(self) -> PatternTables:
        return PatternTables.of(d.describe(self._blobs))

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

    def enumerate_embeddings(
        self, logs: Floats, most: int = KEPT
    ) -> tuple[list[PatternEmbedding], Int32Array]:
        """Enumerate the likeliest embeddings of patterns in a loop.

        logs: (L, 4) log probabilities of 1 to 4 quads at each vertex. Returns the ways, likeliest
        first, and the quads (c, L) that each has at the loop's vertices. Once this thread's
        deadline is past, those found until then.
        """
        n = len(logs)
        if n % 2 or n > MOST_EDGES or not len(self):
            return [], np.zeros((0, n), np.int32)
        t = self._tables
        loss = np.zeros((2, 2 * n, 5))
        loss[0, :n, 1:] = logs.max(axis=1, keepdims=True) - logs
        loss[1, :n] = loss[0, (-np.arange(n)) % n]
        loss[:, n:] = loss[:, :n]
        prior = SHARE * np.log(self.share)
        with flag_deadline() as late:
            found = enumerate_embeddings(loss, n, t, prior, most, late)
        scores, row, turn, mirrored, widths = found
        order = np.argsort(-scores, kind="stable")
        embeddings: list[PatternEmbedding] = []
        quads = np.full((len(order), n), 2, np.int32)
        for at, i in enumerate(order.tolist()):
            p = int(row[i])
            chords = int(t.n_chords[p])
            embedding = PatternEmbedding(
                p, tuple(widths[i, :chords].tolist()), int(turn[i]), bool(mirrored[i])
            )
            embeddings.append(embedding)
            places, corners = self._places(embedding)
            quads[at, (embedding.turn + (-places if embedding.mirrored else places)) % n] = corners
        return embeddings, quads

    def first_vertex(self, embedding: PatternEmbedding) -> int:
        """The loop's vertex that is vertex 0 of the pattern's expansion, turned by 0."""
        if not embedding.mirrored:
            return embedding.turn
        t = self._tables
        if t.n_sides[embedding.pattern] <= 1:
            return embedding.turn - (t.n_sides[embedding.pattern] == 0)
        a = t.first_side[embedding.pattern]
        edges = t.chord[t.first_edge[a] : t.first_edge[a + 1]]
        return embedding.turn - int(np.array(embedding.widths)[edges].sum())

    def _places(self, embedding: PatternEmbedding) -> tuple[NDArray[np.int64], Int32Array]:
        """Where the pattern's corners lie along its boundary, and the quads at each."""
        t = self._tables
        a, b = int(t.first_side[embedding.pattern]), int(t.first_side[embedding.pattern + 1])
        if t.n_sides[embedding.pattern] == 0:
            return np.zeros(0, np.int64), np.zeros(0, np.int32)
        first = int(t.first_edge[a])
        edges = t.chord[first : int(t.first_edge[b])]
        along = np.zeros(len(edges) + 1, np.int64)
        along[1:] = np.cumsum(np.array(embedding.widths)[edges])
        return along[t.first_edge[a:b] - first], t.corner[a:b]


@dataclass(frozen=True, slots=True, eq=False)
class PatternTables:
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
    def of(cls, rows: d.Descriptions) -> PatternTables:
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
