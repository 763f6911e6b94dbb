"""Patterns of any number of sides in one table: what marked patterns are made of."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from patterndb._native.query.marks.patterntable import meshes
from patterndb.core import description as d
from patterndb.core.code import pattern_id
from patterndb.core.halfedge import Int32Array
from patterndb.core.packing import unpack, unpack_many
from patterndb.core.pattern import Pattern
from patterndb.core.patternclass import PatternClass
from query.families import family as f
from query.families.arraycache import Array

LEARNED = "learned"


@dataclass(frozen=True, slots=True, eq=False)
class PatternTable:
    """p different patterns, in order of their ids.

    codes:       p packed canonical codes.
    ids:         (p,) int64.
    frequency:   (p,) int64 distinct patches; 0 for patterns that no mesh has shown.
    learned:     (p,) bool; the others are of a family.
    n_sides, n_irregular, n_reflex: (p,) int32.
    min_valence, max_valence: (p,) int32 over the irregular vertices; 4 where there is none.
    max_count:   (p,) int32 most quads at a boundary vertex.
    n_loops:     (p,) int32 loop polychords.
    mesh:        (p,) bool: do no two edges join the same two vertices when every polychord
                 is 1 wide? Then none do however wide they are; see
                 :func:`query.identity.is_mesh`.
    """

    codes: tuple[bytes, ...]
    ids: NDArray[np.int64]
    frequency: NDArray[np.int64]
    learned: NDArray[np.bool_]
    n_sides: Int32Array
    n_irregular: Int32Array
    n_reflex: Int32Array
    min_valence: Int32Array
    max_valence: Int32Array
    max_count: Int32Array
    n_loops: Int32Array
    mesh: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.codes)

    @property
    def cost(self) -> Int32Array:
        """(p,) int32 irregular interior vertices and reflex corners."""
        return self.n_irregular + self.n_reflex

    def pattern(self, row: int) -> Pattern:
        """The pattern in this row."""
        return Pattern.from_trusted_code(
            unpack(self.codes[row]).astype(np.uint16),
            frequency=int(self.frequency[row]),
            origin=LEARNED if self.learned[row] else f.ORIGIN,
        )

    def take(self, rows: NDArray[np.int64]) -> PatternTable:
        """The table of these rows, which are in order."""
        return PatternTable(
            tuple(self.codes[row] for row in rows.tolist()),
            self.ids[rows],
            self.frequency[rows],
            self.learned[rows],
            self.n_sides[rows],
            self.n_irregular[rows],
            self.n_reflex[rows],
            self.min_valence[rows],
            self.max_valence[rows],
            self.max_count[rows],
            self.n_loops[rows],
            self.mesh[rows],
        )

    def to_arrays(self) -> list[Array]:
        """The table as :meth:`from_arrays` takes it."""
        counts = [self.n_sides, self.n_irregular, self.n_reflex]
        counts += [self.min_valence, self.max_valence, self.max_count, self.n_loops]
        return [
            np.frombuffer(b"".join(self.codes), np.uint8),
            np.r_[0, np.cumsum([len(code) for code in self.codes])].astype(np.int64),
            self.ids,
            self.frequency,
            np.stack([self.learned, self.mesh]),
            np.stack(counts),
        ]

    @classmethod
    def from_arrays(cls, arrays: Sequence[Array]) -> PatternTable:
        """What :meth:`to_arrays` gave."""
        raw, start, ids, frequency, flags, counts = arrays
        data = raw.tobytes()
        codes = tuple(data[a:b] for a, b in pairwise(start.tolist()))
        return cls(codes, ids, frequency, flags[0], *counts, mesh=flags[1])

    @classmethod
    def from_codes(
        cls,
        codes: Sequence[bytes],
        frequency: NDArray[np.int64],
        learned: NDArray[np.bool_],
    ) -> PatternTable:
        """Of packed canonical codes; frequency, learned: (n,). A code given twice is one row:
        learned if either is, with the frequencies added.

        Raises InvalidCodeError for what is no canonical code of a disk.
        """
        number: dict[bytes, int] = {}
        owner = np.array([number.setdefault(c, len(number)) for c in codes], np.int64)
        distinct = list(number)
        rows = d.describe(distinct)
        counts = rows.counts
        ids = np.array(
            [
                pattern_id(code, n)
                for code, n in zip(distinct, counts[:, d.N_CORNERS].tolist(), strict=True)
            ],
            np.int64,
        )
        sums = np.zeros(len(distinct), np.int64)
        np.add.at(sums, owner, frequency)
        either = np.zeros(len(distinct), np.bool_)
        either[owner[learned]] = True
        valences = [rows.numbers(i, d.VALENCES).tolist() for i in range(len(distinct))]
        corners = [rows.numbers(i, d.CORNERS).tolist() for i in range(len(distinct))]
        symbols, offsets = unpack_many(distinct)
        order = np.argsort(ids)
        return cls(
            codes=tuple(distinct),
            ids=ids,
            frequency=sums,
            learned=either,
            n_sides=counts[:, d.N_CORNERS].copy(),
            n_irregular=counts[:, d.N_IRREGULAR].copy(),
            n_reflex=counts[:, d.N_REFLEX].copy(),
            min_valence=np.array([min(v, default=4) for v in valences], np.int32),
            max_valence=np.array([max(v, default=4) for v in valences], np.int32),
            max_count=np.array([max([2, *k]) for k in corners], np.int32),
            n_loops=counts[:, d.N_LOOPS].copy(),
            mesh=meshes(symbols.astype(np.uint16), offsets),
        ).take(order)

    @classmethod
    def from_family(cls, family: f.Family) -> PatternTable:
        """The patterns of a family."""
        n = len(family)
        return cls.from_codes(family.codes, np.zeros(n, np.int64), np.zeros(n, np.bool_))

    @classmethod
    def from_class(cls, patterns: PatternClass, most: int) -> PatternTable:
        """The patterns of a class with at most ``most`` irregular and reflex vertices."""
        rows = np.flatnonzero(patterns.n_irregular + patterns.n_reflex <= most)
        codes = [patterns.codes[row] for row in rows.tolist()]
        return cls.from_codes(codes, patterns.frequency[rows], np.ones(len(rows), np.bool_))

    @classmethod
    def joined(cls, tables: Iterable[PatternTable]) -> PatternTable:
        """All patterns of the tables, each once, as in :meth:`from_codes`."""
        parts = list(tables)
        return cls.from_codes(
            [code for part in parts for code in part.codes],
            np.concatenate([np.zeros(0, np.int64), *(part.frequency for part in parts)]),
            np.concatenate([np.zeros(0, np.bool_), *(part.learned for part in parts)]),
        )
