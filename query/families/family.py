"""Complete families: every pattern with few irregular vertices, grown rather than learned.

With at most 4 irregular interior vertices and reflex corners together, of valence 3 to 5,
there are 5,887 patterns up to mirror image. They are made on first use, see
rust/query/src/families/growing.rs, and kept in the user's cache folder.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from patterndb._native.query.families.growing import grow_patterns
from patterndb.core import description as d
from patterndb.core.code import MAX_QUADS, pattern_id
from patterndb.core.halfedge import Int32Array
from patterndb.core.packing import pack_many, unpack
from patterndb.core.pattern import Pattern
from query.errors import InvalidQueryError
from query.families.arraycache import Array, load_or_make

#: Raise it whenever a family of the same parameters comes out another way.
VERSION = 1

#: What the patterns of a family are: in no mesh, so their frequency is 0.
ORIGIN = "family"

#: Quads. Copies of a self-crossing polychord never collapse, so with few sides (N <= 2, or
#: N = 3 with 5 irregular vertices) there are patterns of any size; the useful ones are small.
MOST_QUADS = 100


@dataclass(frozen=True, slots=True, eq=False)
class Family:
    """All patterns within bounds, by cost, then number of sides, then id.

    most:        the greatest cost: irregular interior vertices and reflex corners.
    valence:     the greatest of an interior vertex; a reflex corner has two less at most.
    max_quads:   no pattern is larger.
    codes:       p packed canonical codes.
    ids:         (p,) int64.
    n_sides:     (p,) int32, N.
    n_irregular: (p,) int32 interior vertices whose valence is not 4.
    n_reflex:    (p,) int32 reflex corners.
    n_quads:     (p,) int32.
    self_crossing: (p,) bool: does a polychord cross itself?
    """

    most: int
    valence: int
    max_quads: int
    codes: tuple[bytes, ...]
    ids: NDArray[np.int64]
    n_sides: Int32Array
    n_irregular: Int32Array
    n_reflex: Int32Array
    n_quads: Int32Array
    self_crossing: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.codes)

    @property
    def cost(self) -> Int32Array:
        """(p,) int32 irregular interior vertices and reflex corners."""
        return self.n_irregular + self.n_reflex

    def rows(self, n_sides: int) -> NDArray[np.int64]:
        """The rows of the patterns of ``n_sides`` sides, in order."""
        return np.flatnonzero(self.n_sides == n_sides)

    def pattern(self, row: int) -> Pattern:
        """The pattern in this row."""
        code = unpack(self.codes[row]).astype(np.uint16)
        return Pattern.from_trusted_code(code, origin=ORIGIN)

    def patterns(self, n_sides: int) -> Iterator[Pattern]:
        """The patterns of ``n_sides`` sides, in order."""
        return (self.pattern(row) for row in self.rows(n_sides).tolist())


@lru_cache(maxsize=4)
def load_family(most: int = 4, valence: int = 5, *, max_quads: int = MOST_QUADS) -> Family:
    """Every pattern with at most ``most`` irregular vertices and reflex corners.

    valence: interior vertices have 3 to ``valence`` quads, boundary ones at most
    ``valence - 2``. max_quads: larger patterns are left out, and those that only they lead
    to. The first call takes a moment and keeps the result in the cache folder: most = 4
    0.3 s, most = 5 some 10 s (169,825 patterns up to 120 quads); beyond that there are
    millions. Raises InvalidQueryError for bounds that no pattern meets.
    """
    if most < 0 or valence < 4 or not 1 <= max_quads <= MAX_QUADS:
        raise InvalidQueryError(
            f"a family needs most >= 0 (got {most}), valence >= 4 (got {valence}) and "
            f"max_quads in 1..{MAX_QUADS} (got {max_quads})"
        )
    name = f"family-{VERSION}-{most}-{valence}-{max_quads}.bin"
    symbols, offsets, ids, counts, crossing = load_or_make(
        name, lambda: _make(most, valence, max_quads)
    )
    return Family(
        most=most,
        valence=valence,
        max_quads=max_quads,
        codes=tuple(pack_many(symbols, offsets)),
        ids=ids,
        n_sides=counts[0],
        n_irregular=counts[1],
        n_reflex=counts[2],
        n_quads=counts[3],
        self_crossing=crossing,
    )


def _make(most: int, valence: int, max_quads: int) -> list[Array]:
    flat, offsets = grow_patterns(most, valence, max_quads)
    codes = pack_many(flat, offsets)
    counts = d.describe(codes).counts
    n_sides = counts[:, d.N_CORNERS]
    ids = np.array(
        [pattern_id(c, n) for c, n in zip(codes, n_sides.tolist(), strict=True)], np.int64
    )
    order = np.lexsort((ids, n_sides, counts[:, d.N_IRREGULAR] + counts[:, d.N_REFLEX]))
    symbols = [flat[a:b] for a, b in zip(offsets[order], offsets[order + 1], strict=True)]
    columns = counts[order][:, [d.N_CORNERS, d.N_IRREGULAR, d.N_REFLEX, d.N_QUADS]]
    return [
        np.concatenate(symbols),
        np.r_[0, np.cumsum([len(s) for s in symbols])].astype(np.int64),
        ids[order],
        np.ascontiguousarray(columns.T),
        counts[order, d.SELF_CROSSING].astype(np.bool_),
    ]
