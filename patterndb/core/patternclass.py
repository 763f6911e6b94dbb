"""All patterns of one number of sides, as the arrays that a query runs over."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from patterndb.core import description as d
from patterndb.core.code import Code, format_id
from patterndb.core.label import join_matrices
from patterndb.core.packing import pack, unpack
from patterndb.core.pattern import Pattern
from patterndb.errors import InvalidCodeError

#: Where patterns come from, as ``PatternClass.origin`` numbers it: found in learned meshes,
#: found in imported tables alone, made by a query as one of a family or by construction.
ORIGINS = ("learned", "imported", "family", "constructed")


class Shelf(Protocol):
    """Where arrays that take a while to make of a class are kept between processes."""

    def find_or_make(
        self, what: str, make: Callable[[], Mapping[str, NDArray[Any]]]
    ) -> Mapping[str, NDArray[Any]]:
        """The arrays kept under a name; where there are none they are made, and kept."""
        ...


def shrink(counts: NDArray[np.integer]) -> NDArray[np.unsignedinteger]:
    """Counts, none negative, as the smallest unsigned integers that hold them."""
    return counts.astype(np.min_scalar_type(int(counts.max(initial=0))))


@dataclass(frozen=True, slots=True, eq=False, weakref_slot=True)
class PatternClass:
    """One class, in default order: fewest irregular vertices, most frequent, smallest id.

    n_sides:     N >= 0. Where N = 0 the arrays below have one column: the closed side.
    ids:         (p,) int64.
    frequency:   (p,) int64 distinct patches; 0 where a pattern is there for its uses alone.
    n_meshes:    (p,) int32 meshes in which it occurs.
    uses:        (p,) int64 accepted fills that were recorded.
    origin:      (p,) int8 place in ORIGINS.
    n_irregular, n_quads: (p,) int32.
    min_valence, max_valence: (p,) int32 over the irregular vertices; 4 where there is none.
    n_reflex:    (p,) int32 number of reflex corners.
    corners:     (p, N) uint8 number of quads at each corner.
    n_loops:     (p,) int32 loop polychords.
    chiral:      (p,) bool.
    rotations:   (p,) int32, how many rotations map the pattern onto itself.
    self_crossing: (p,) bool, does a polychord cross itself?
    words, word_start: int32 and (p + 1,) int64: the boundary label of row i, as a word of
                 :mod:`patterndb.core.label`, is ``words[word_start[i]:word_start[i + 1]]``.
    signature:   (p,) int32 row of ``lengths`` and ``joins``.
    rotation, reflected: (p,) int32 and bool; side i of the signature is the pattern's side
                 rotation + i, or rotation - i read backwards where reflected. Where N = 0
                 rotation counts boundary edges.
    codes:       p packed codes.
    lengths:     (s, max(N, 1)) base length of every side of a signature. Unsigned integers, the
                 smallest that hold them.
    joins:       (s, max(N, 1), max(N, 1)) n_ij of a signature, symmetric; a polychord with both
                 ends on side i counts once in n_ii. Unsigned integers, the smallest that hold them.
    shelf:       where arrays that take a while to make of the class are kept; None: nowhere.
    """

    n_sides: int
    ids: NDArray[np.int64]
    frequency: NDArray[np.int64]
    n_meshes: NDArray[np.int32]
    uses: NDArray[np.int64]
    origin: NDArray[np.int8]
    n_irregular: NDArray[np.int32]
    n_quads: NDArray[np.int32]
    min_valence: NDArray[np.int32]
    max_valence: NDArray[np.int32]
    n_reflex: NDArray[np.int32]
    corners: NDArray[np.uint8]
    n_loops: NDArray[np.int32]
    chiral: NDArray[np.bool_]
    rotations: NDArray[np.int32]
    self_crossing: NDArray[np.bool_]
    words: NDArray[np.int32]
    word_start: NDArray[np.int64]
    signature: NDArray[np.int32]
    rotation: NDArray[np.int32]
    reflected: NDArray[np.bool_]
    codes: Sequence[bytes]
    lengths: NDArray[np.unsignedinteger]
    joins: NDArray[np.unsignedinteger]
    shelf: Shelf | None = None

    def __len__(self) -> int:
        return len(self.ids)

    def code(self, row: int) -> Code:
        """(4q,) uint16 code of the pattern in this row."""
        return unpack(self.codes[row]).astype(np.uint16)

    def pattern(self, row: int) -> Pattern:
        """The pattern in this row. Raises InvalidCodeError, with its name, where its code is not
        the canonical code of a disk."""
        try:
            return Pattern.from_trusted_code(
                self.code(row),
                frequency=int(self.frequency[row]),
                origin=ORIGINS[int(self.origin[row])],
            )
        except InvalidCodeError as error:
            raise InvalidCodeError(
                f"pattern {format_id(int(self.ids[row]))} is damaged ({error}); "
                "'patterndb verify' tells what is wrong with the whole file"
            ) from error

    @classmethod
    def from_patterns(
        cls, n_sides: int, patterns: Sequence[Pattern], uses: Mapping[int, int] | None = None
    ) -> PatternClass:
        """The class of these patterns, all of ``n_sides`` sides, without a database.

        uses: how often patterns were used, by their ids; those not named never. Raises
        ValueError for a pattern of another class, or of an origin that is none of ORIGINS.
        """
        patterns = sorted(patterns, key=lambda p: (p.n_irregular, -p.frequency, p.id))
        if any(p.n_sides != n_sides for p in patterns):
            raise ValueError(f"every pattern of the class must have {n_sides} sides")
        uses = uses or {}
        rows = d.describe([p.code for p in patterns])
        labels = [rows.numbers(i, d.LABEL) for i in range(len(patterns))]
        words: dict[bytes, int] = {}
        number = [
            words.setdefault(rows.numbers(i, d.SIGNATURE).tobytes(), len(words))
            for i in range(len(patterns))
        ]
        _, first = np.unique(np.array(number, np.int64), return_index=True)
        lengths = [rows.numbers(i, d.LENGTHS).tolist() for i in first.tolist()]
        joins = [rows.numbers(i, d.JOINS) for i in first.tolist()]
        pairs = np.concatenate([np.zeros(0, np.int64), *joins]).reshape(-1, 2)
        owner = np.repeat(np.arange(len(joins)), [len(j) // 2 for j in joins])
        corners = np.array([p.corners for p in patterns], np.uint8)
        return cls(
            n_sides=n_sides,
            ids=np.array([p.id for p in patterns], np.int64),
            frequency=np.array([p.frequency for p in patterns], np.int64),
            n_meshes=np.array([p.frequency > 0 for p in patterns], np.int32),
            uses=np.array([uses.get(p.id, 0) for p in patterns], np.int64),
            origin=np.array([ORIGINS.index(p.origin) for p in patterns], np.int8),
            n_irregular=np.array([p.n_irregular for p in patterns], np.int32),
            n_quads=np.array([p.n_quads for p in patterns], np.int32),
            min_valence=np.array([min(p.valences, default=4) for p in patterns], np.int32),
            max_valence=np.array([max(p.valences, default=4) for p in patterns], np.int32),
            n_reflex=np.array([sum(k > 2 for k in p.corners) for p in patterns], np.int32),
            corners=corners.reshape(len(patterns), n_sides),
            n_loops=np.array([p.n_loops for p in patterns], np.int32),
            chiral=np.array([p.chiral for p in patterns], np.bool_),
            rotations=np.array([p.rotations for p in patterns], np.int32),
            self_crossing=np.array([p.self_crossing for p in patterns], np.bool_),
            words=np.concatenate([np.zeros(0, np.uint16), *labels]).astype(np.int32),
            word_start=np.cumsum([0, *map(len, labels)], dtype=np.int64),
            signature=np.array(number, np.int32),
            rotation=rows.counts[:, d.SIG_ROTATION].copy(),
            reflected=rows.counts[:, d.SIG_REFLECTED].astype(np.bool_),
            codes=[pack(p.code) for p in patterns],
            lengths=shrink(np.array(lengths, np.int32).reshape(-1, max(n_sides, 1))),
            joins=shrink(join_matrices(n_sides, pairs, owner, len(joins))),
        )
