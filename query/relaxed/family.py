"""Tables of patterns, and complete families: every pattern with few irregular vertices.

The patterns of a family are grown rather than learned. With at most 4 irregular interior vertices
and reflex corners together, of valence 3 to 5, there are 5,887 patterns up to mirror image. They
are made on first use (rust/query/src/relaxed/family.rs) and kept in the user's cache folder.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from patterndb._native.query.relaxed.family import grow_patterns, meshes
from patterndb.core import description as d
from patterndb.core.code import MAX_QUADS, pattern_ids
from patterndb.core.halfedge import Int32Array
from patterndb.core.packing import pack_many, unpack, unpack_many
from patterndb.core.pattern import Pattern
from patterndb.core.patternclass import PatternClass
from patterndb.system.mappedarrays import ArrayCache
from query.cancellation import NEVER, CancelFlag, raise_if_cancelled
from query.errors import InvalidQueryError

#: Raise it whenever a family of the same parameters comes out another way.
VERSION = 2

#: What the patterns of a family are: in no mesh, so their frequency is 0.
ORIGIN = "family"

LEARNED = "learned"

#: Quads. Copies of a self-crossing polychord never collapse, so with few sides (N <= 2, or
#: N = 3 with 5 irregular vertices) there are patterns of any size; the useful ones are small.
MOST_QUADS = 100


@dataclass(frozen=True, slots=True, eq=False)
class PatternTable:
    """p different patterns of any numbers of sides, in order of their ids.

    codes:       p packed canonical codes.
    ids:         (p,) int64.
    frequency:   (p,) int64 distinct patches; 0 for patterns that no mesh has shown.
    learned:     (p,) bool; the others are of a family.
    n_sides, n_irregular, n_reflex: (p,) int32.
    min_valence, max_valence: (p,) int32 over the irregular vertices; 4 where there is none.
    max_count:   (p,) int32 most quads at a boundary vertex.
    n_quads, n_loops: (p,) int32; the latter are loop polychords.
    mesh:        (p,) bool: do no two edges join the same two vertices when every polychord
                 is 1 wide? Then none do however wide they are; see
                 :func:`query.recognition.is_mesh`.
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
    n_quads: Int32Array
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
            origin=LEARNED if self.learned[row] else ORIGIN,
        )

    def take(self, rows: NDArray[np.int64]) -> PatternTable:
        """The table of these rows, which are in order."""
        columns = {name: column[rows] for name, column in self._columns().items()}
        return PatternTable(tuple(self.codes[row] for row in rows.tolist()), **columns)

    def _columns(self) -> dict[str, NDArray[Any]]:
        """All columns but the codes, by name."""
        return {one.name: getattr(self, one.name) for one in fields(self)[1:]}

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """The table as :meth:`from_arrays` takes it."""
        ends = np.cumsum([0, *map(len, self.codes)], dtype=np.int64)
        return {
            "code": np.frombuffer(b"".join(self.codes), np.uint8),
            "code_ends": ends,
            **self._columns(),
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> PatternTable:
        """What :meth:`to_arrays` gave; others may be among the arrays."""
        data = arrays["code"].tobytes()
        codes = tuple(data[a:b] for a, b in pairwise(arrays["code_ends"].tolist()))
        return cls(codes, **{one.name: arrays[one.name] for one in fields(cls)[1:]})

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
        ids = pattern_ids(distinct, counts[:, d.N_CORNERS])
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
            n_quads=counts[:, d.N_QUADS].copy(),
            n_loops=counts[:, d.N_LOOPS].copy(),
            mesh=meshes(symbols.astype(np.uint16), offsets),
        ).take(order)

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


#: Where families, and tables made of them, are kept between runs.
CACHE = ArrayCache("complete families", f"{VERSION}")

#: The families in use, by their bounds.
LOADED: dict[tuple[int, int, int], PatternTable] = {}


def load_family(
    most: int = 4,
    valence: int = 5,
    *,
    max_quads: int = MOST_QUADS,
    cancelled: CancelFlag = NEVER,
) -> PatternTable:
    """Every pattern with at most ``most`` irregular vertices and reflex corners.

    valence: interior vertices have 3 to ``valence`` quads, boundary ones at most
    ``valence - 2``. max_quads: larger patterns are left out, and those that only they lead
    to. The first call takes a moment and keeps the result in the cache folder: most = 4
    0.3 s, most = 5 some 10 s (169,825 patterns up to 120 quads); beyond that there are
    millions. Raises InvalidQueryError for bounds that no pattern meets, QueryCancelledError
    once ``cancelled`` is set.
    """
    if most < 0 or valence < 4 or not 1 <= max_quads <= MAX_QUADS:
        raise InvalidQueryError(
            f"a family needs most >= 0 (got {most}), valence >= 4 (got {valence}) and "
            f"max_quads in 1..{MAX_QUADS} (got {max_quads})"
        )

    def make() -> dict[str, NDArray[Any]]:
        flat, offsets = grow_patterns(most, valence, max_quads, cancelled)
        raise_if_cancelled(cancelled)
        codes = pack_many(flat, offsets)
        n = len(codes)
        grown = PatternTable.from_codes(codes, np.zeros(n, np.int64), np.zeros(n, np.bool_))
        return grown.to_arrays()

    bounds = (most, valence, max_quads)
    if bounds not in LOADED:
        made = CACHE.find_or_make(f"family-{most}-{valence}-{max_quads}", make)
        LOADED[bounds] = PatternTable.from_arrays(made)
    return LOADED[bounds]
