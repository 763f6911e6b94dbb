"""All patterns of one number of sides, as the arrays that a query runs over."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from patterndb.core import description as d
from patterndb.core.code import Code, format_id
from patterndb.core.label import join_matrices
from patterndb.core.packing import PackedRows, pack, take_stretches, unpack
from patterndb.core.pattern import Pattern
from patterndb.errors import InvalidCodeError
from patterndb.system.memory import return_freed_memory

if TYPE_CHECKING:
    # Imported for its name alone: a class without a cache need not wait for it.
    from patterndb.system.mappedarrays import ArrayCache

#: Where patterns come from, as ``PatternClass.origin`` numbers it: found in learned meshes,
#: found in imported tables alone, made by a query as one of a family or by construction.
ORIGINS = ("learned", "imported", "family", "constructed")


def shrink(counts: NDArray[np.integer]) -> NDArray[np.unsignedinteger]:
    """Counts, none negative, as the smallest unsigned integers that hold them."""
    return counts.astype(np.min_scalar_type(int(counts.max(initial=0))), copy=False)


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
    words, word_start: int16 and (p + 1,) int64: the boundary label of row i, as a word of
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
    cache:       where arrays that take a while to make of the class are kept; None: nowhere.
    tables:      what queries make of the class and keep with it, by what it is.
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
    words: NDArray[np.int16]
    word_start: NDArray[np.int64]
    signature: NDArray[np.int32]
    rotation: NDArray[np.int32]
    reflected: NDArray[np.bool_]
    codes: Sequence[bytes]
    lengths: NDArray[np.unsignedinteger]
    joins: NDArray[np.unsignedinteger]
    cache: ArrayCache | None = None
    tables: dict[str, Any] = field(default_factory=dict[str, Any], repr=False)

    def __len__(self) -> int:
        return len(self.ids)

    @property
    def n_corners(self) -> NDArray[np.int32]:
        """(p,) int32 corners of every pattern: N."""
        return np.full(len(self), self.n_sides, np.int32)

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
        if any(p.n_sides != n_sides for p in patterns):
            raise ValueError(f"every pattern of the class must have {n_sides} sides")
        uses = uses or {}
        ids = [p.id for p in patterns]
        part = ClassPart(
            PackedRows.of([pack(p.code) for p in patterns]),
            d.describe([p.code for p in patterns]),
            ids=np.array(ids, np.int64),
            frequency=np.array([p.frequency for p in patterns], np.int64),
            n_meshes=np.array([p.frequency > 0 for p in patterns], np.int32),
            uses=np.array([uses.get(number, 0) for number in ids], np.int64),
            origin=np.array([ORIGINS.index(p.origin) for p in patterns], np.int8),
        )
        return cls.from_parts(n_sides, [part])

    @classmethod
    def from_parts(cls, n_sides: int, parts: Iterable[ClassPart]) -> PatternClass:
        """The class of the patterns of all parts, all of ``n_sides`` sides.

        Of each part the columns are kept, and no more: parts may come one by one.
        """
        width = max(n_sides, 1)
        held: dict[str, list[NDArray[Any]]] = {}
        for part in parts:
            for name, column in _make_columns(n_sides, part).items():
                held.setdefault(name, []).append(column)
        if not held:
            held = {name: [column] for name, column in _make_columns(n_sides, EMPTY_PART).items()}

        def join(name: str) -> NDArray[Any]:
            whole = np.concatenate(held.pop(name))
            if whole.nbytes >= LARGE:
                return_freed_memory()
            return whole

        ids, frequency, n_irregular = map(join, ("ids", "frequency", "n_irregular"))
        order = np.lexsort((ids, -frequency, n_irregular))
        place = np.empty(len(order), np.int64)
        place[order] = np.arange(len(order))
        rows: dict[str, Any] = {
            "ids": ids[order],
            "frequency": frequency[order],
            "n_irregular": n_irregular[order],
        }
        for name in ("words", "codes"):
            sizes = join(f"{name}_size")
            rows[name] = take_stretches(join(name), (np.cumsum(sizes) - sizes)[order], sizes[order])
            rows[f"{name}_start"] = np.cumsum(np.r_[0, sizes[order]])
        # Patterns that share a signature share one row of lengths and joins.
        digest = _put_rows(held.pop("signature"), place).view(np.uint64).reshape(-1, 2)
        signature, first = number_rows(digest)
        shown = np.full(len(order), -1, np.int64)
        shown[order[first]] = np.arange(len(first))
        lengths = _put_rows(held.pop("lengths"), shown)
        joins = _put_rows(held.pop("joins"), shown)
        rows |= {name: _put_rows(held.pop(name), place) for name in list(held)}
        codes = PackedRows(rows.pop("codes"), rows.pop("codes_start"))
        return cls(
            n_sides=n_sides,
            word_start=rows.pop("words_start"),
            signature=signature,
            codes=codes,
            lengths=shrink(lengths.reshape(-1, width)),
            joins=shrink(joins.reshape(-1, width, width)),
            **rows,
        )


def _put_rows(parts: list[NDArray[Any]], place: NDArray[np.int64]) -> NDArray[Any]:
    """Put each row of all parts (n, ...) where it is to be, or nowhere where that is -1.

    The parts go as they are read: a large class has some hundred megabytes of columns.
    """
    shape = (int(place.max(initial=-1)) + 1, *parts[0].shape[1:])
    whole = np.empty(shape, np.result_type(*parts))
    at = 0
    parts.reverse()
    while parts:
        part = parts.pop()
        where = place[at : at + len(part)]
        at += len(part)
        whole[where[where >= 0]] = part[where >= 0]
    if whole.nbytes >= LARGE:
        return_freed_memory()
    return whole


@dataclass(frozen=True, slots=True, eq=False)
class ClassPart:
    """Some patterns of a class, in any order: packed codes, what they describe, and what a database
    knows of them; see :class:`PatternClass`."""

    codes: PackedRows
    described: d.Descriptions
    ids: NDArray[np.int64]
    frequency: NDArray[np.int64]
    n_meshes: NDArray[np.int32]
    uses: NDArray[np.int64]
    origin: NDArray[np.int8]


#: A part without patterns.
EMPTY_PART = ClassPart(
    PackedRows.of([]),
    d.Descriptions(
        np.zeros((0, d.COLUMNS), np.int32), np.zeros(0, np.uint16), np.zeros(1, np.int64)
    ),
    ids=np.zeros(0, np.int64),
    frequency=np.zeros(0, np.int64),
    n_meshes=np.zeros(0, np.int32),
    uses=np.zeros(0, np.int64),
    origin=np.zeros(0, np.int8),
)

#: Bytes of a column after which what its parts took is given back to the system.
LARGE = 8 << 20

#: Bytes of the hash that stands for a signature while a class is put together: no two are equal.
DIGEST = 16


def number_rows(rows: NDArray[Any]) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Number equal rows (n, k) alike, as they first appear; the numbers, and the first of each."""
    by_value = np.lexsort(rows.T)
    ordered = rows[by_value]
    begins = np.ones(len(rows), np.bool_)
    begins[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    # Sorting is stable, so that the first of equal rows comes first.
    first = by_value[begins]
    by_place = np.argsort(first)
    rank = np.empty(len(first), np.int32)
    rank[by_place] = np.arange(len(first))
    number = np.empty(len(rows), np.int32)
    number[by_value] = rank[np.cumsum(begins) - 1]
    return number, first[by_place]


def _make_columns(n_sides: int, part: ClassPart) -> dict[str, NDArray[Any]]:
    """The columns of a part, by the names of :class:`PatternClass`: of words and codes with the
    sizes, of signatures (n, DIGEST) hashes, and lengths and joins for every pattern."""
    counts = part.described.counts
    told = part.described.take(np.arange(len(counts)))
    corners, _ = told.gather(d.CORNERS)
    words, word_start = told.gather(d.LABEL)
    digests = b"".join(
        hashlib.blake2b(word, digest_size=DIGEST).digest() for word in told.split(d.SIGNATURE)
    )
    lengths, _ = told.gather(d.LENGTHS)
    joins, join_start = told.gather(d.JOINS)
    owner = np.repeat(np.arange(len(counts)), np.diff(join_start) // 2)
    valences, valence_start = told.gather(d.VALENCES)
    irregular = counts[:, d.N_IRREGULAR] > 0
    smallest, largest = (np.full(len(counts), 4, np.int32) for _ in range(2))
    # Valences ascend.
    smallest[irregular] = valences[valence_start[:-1][irregular]]
    largest[irregular] = valences[valence_start[1:][irregular] - 1]
    return {
        "ids": part.ids,
        "frequency": part.frequency,
        "n_meshes": part.n_meshes,
        "uses": part.uses,
        "origin": part.origin,
        "n_irregular": counts[:, d.N_IRREGULAR].copy(),
        "n_quads": counts[:, d.N_QUADS].copy(),
        "min_valence": smallest,
        "max_valence": largest,
        "n_reflex": counts[:, d.N_REFLEX].copy(),
        "corners": corners.astype(np.uint8).reshape(len(counts), n_sides),
        "n_loops": counts[:, d.N_LOOPS].copy(),
        "chiral": counts[:, d.CHIRAL].astype(np.bool_),
        "rotations": counts[:, d.ROTATIONS].copy(),
        "self_crossing": counts[:, d.SELF_CROSSING].astype(np.bool_),
        "words": words.astype(np.int16),
        "words_size": np.diff(word_start),
        "signature": np.frombuffer(digests, np.uint8).reshape(-1, DIGEST),
        "rotation": counts[:, d.SIG_ROTATION].copy(),
        "reflected": counts[:, d.SIG_REFLECTED].astype(np.bool_),
        "codes": part.codes.raw,
        "codes_size": np.diff(part.codes.ends),
        "lengths": shrink(lengths.astype(np.int32)).reshape(-1, max(n_sides, 1)),
        "joins": shrink(join_matrices(n_sides, joins.reshape(-1, 2), owner, len(counts))),
    }
