"""The patterns of several classes of one number of sides as one class, their frequencies added.

What follows from a pattern's code is the same in every class that holds it, and is taken from the
first; what was counted is added. Patterns are met by id, which is a hash of the code, in one sort
over all of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from patterndb.core.code import format_id
from patterndb.core.packing import PackedRows, take_stretches
from patterndb.core.patternclass import PatternClass, shrink
from patterndb.errors import InvalidCodeError

ScalarT = TypeVar("ScalarT", bound=np.generic)

#: The largest frequency: sums of weighted ones stay within int64.
MOST_FREQUENT = 1 << 62


@dataclass(frozen=True, slots=True, eq=False)
class ClassShare:
    """A class that is to be united with others.

    weight:  what its frequencies count, above 0.
    patches: (p,) int64 patches that count: its frequencies, less what another share counts.
    n_meshes: (p,) int32 meshes that count.
    """

    patterns: PatternClass
    weight: float
    patches: NDArray[np.int64]
    n_meshes: NDArray[np.int32]


def weigh_patches(
    patches: Sequence[NDArray[np.int64]], weights: Sequence[float]
) -> NDArray[np.int64]:
    """Add frequencies (k,) of the same k patterns, each times its weight.

    Returns (k,) int64, rounded; what was met at all is met at least once. Weights of 1 add
    exactly up to 2**53 patches.
    """
    total = np.zeros(len(patches[0]), np.float64)
    met = np.zeros(len(patches[0]), np.bool_)
    for one, weight in zip(patches, weights, strict=True):
        total += one * weight
        met |= one > 0
    rounded = np.rint(np.minimum(total, MOST_FREQUENT)).astype(np.int64)
    return np.where(met, np.maximum(rounded, 1), 0)


def unite_classes(n_sides: int, shares: Sequence[ClassShare]) -> PatternClass:
    """Make the class of all patterns that some share counts, or that were used, in default order.

    Raises InvalidCodeError where two patterns have one id: their hashes collide.
    """
    parts = [share.patterns for share in shares]
    sizes = [len(part) for part in parts]
    start = np.cumsum([0, *sizes])
    ids, first, place = np.unique(
        np.concatenate([np.zeros(0, np.int64), *(part.ids for part in parts)]),
        return_index=True,
        return_inverse=True,
    )
    codes = PackedRows.join([PackedRows.of(part.codes) for part in parts])
    _refuse_collisions(ids, codes, first, place)
    n_meshes = np.zeros(len(ids), np.int64)
    uses = np.zeros(len(ids), np.int64)
    # Learned comes before imported in ORIGINS; one that nobody met is what it was first used as.
    origin = np.concatenate([np.zeros(0, np.int8), *(part.origin for part in parts)])[first]
    origin_met = np.full(len(ids), np.iinfo(np.int8).max, np.int8)
    patches: list[NDArray[np.int64]] = []
    for at, share in enumerate(shares):
        rows = place[start[at] : start[at + 1]]
        own = np.zeros(len(ids), np.int64)
        own[rows] = share.patches
        patches.append(own)
        n_meshes[rows] += share.n_meshes
        uses[rows] += share.patterns.uses
        met = share.patches > 0
        origin_met[rows[met]] = np.minimum(origin_met[rows[met]], share.patterns.origin[met])
    frequency = weigh_patches(
        patches or [np.zeros(0, np.int64)], [share.weight for share in shares] or [1.0]
    )
    origin = np.where(frequency > 0, origin_met, origin)
    n_irregular = _take(parts, "n_irregular", first, np.int32)
    kept = np.flatnonzero((frequency > 0) | (uses > 0))
    kept = kept[np.lexsort((ids[kept], -frequency[kept], n_irregular[kept]))]
    rows = first[kept]
    words, word_start = _take_words(parts, rows)
    signature, lengths, joins = _unite_signatures(parts, start, rows)
    return PatternClass(
        n_sides=n_sides,
        ids=ids[kept],
        frequency=frequency[kept],
        n_meshes=n_meshes[kept].astype(np.int32),
        uses=uses[kept],
        origin=origin[kept],
        n_irregular=n_irregular[kept],
        n_quads=_take(parts, "n_quads", rows, np.int32),
        min_valence=_take(parts, "min_valence", rows, np.int32),
        max_valence=_take(parts, "max_valence", rows, np.int32),
        n_reflex=_take(parts, "n_reflex", rows, np.int32),
        corners=np.concatenate(
            [np.zeros((0, n_sides), np.uint8), *(part.corners for part in parts)]
        )[rows],
        n_loops=_take(parts, "n_loops", rows, np.int32),
        chiral=_take(parts, "chiral", rows, np.bool_),
        rotations=_take(parts, "rotations", rows, np.int32),
        self_crossing=_take(parts, "self_crossing", rows, np.bool_),
        words=words,
        word_start=word_start,
        signature=signature,
        rotation=_take(parts, "rotation", rows, np.int32),
        reflected=_take(parts, "reflected", rows, np.bool_),
        codes=codes.take(rows),
        lengths=lengths,
        joins=joins,
    )


def _take(
    parts: Sequence[PatternClass], name: str, rows: NDArray[np.int64], dtype: type[ScalarT]
) -> NDArray[ScalarT]:
    """A column's values in these rows of all parts, one after the other."""
    return np.concatenate([np.zeros(0, dtype), *(getattr(part, name) for part in parts)])[rows]


def _refuse_collisions(
    ids: NDArray[np.int64],
    codes: PackedRows,
    first: NDArray[np.int64],
    place: NDArray[np.int64],
) -> None:
    """Raise InvalidCodeError where a row's code is not that of the first row of its id.

    ids: (k,); first: (k,) their first rows; place: (r,) which of them each row has.
    """
    again = np.flatnonzero(first[place] != np.arange(len(place)))
    known = first[place[again]]
    sizes = np.diff(codes.ends)
    wrong = sizes[again] != sizes[known]
    alike = np.flatnonzero(~wrong)
    width = sizes[again[alike]]
    mine = take_stretches(codes.raw, codes.ends[again[alike]], width)
    theirs = take_stretches(codes.raw, codes.ends[known[alike]], width)
    differ = np.repeat(alike, width)[mine != theirs]
    wrong[differ] = True
    if wrong.any():
        number = int(ids[place[again[wrong.argmax()]]])
        raise InvalidCodeError(
            f"two patterns have the id {format_id(number)}: their hashes collide"
        )


def _take_words(
    parts: Sequence[PatternClass], rows: NDArray[np.int64]
) -> tuple[NDArray[np.int16], NDArray[np.int64]]:
    """The boundary labels of these rows, as a class has them."""
    words = np.concatenate([np.zeros(0, np.int16), *(part.words for part in parts)])
    sizes = np.concatenate([np.zeros(0, np.int64), *(np.diff(p.word_start) for p in parts)])
    starts = np.cumsum(sizes) - sizes
    taken = take_stretches(words, starts[rows], sizes[rows])
    return taken, np.cumsum(np.r_[0, sizes[rows]], dtype=np.int64)


def _unite_signatures(
    parts: Sequence[PatternClass], start: NDArray[np.int64], rows: NDArray[np.int64]
) -> tuple[NDArray[np.int32], NDArray[np.unsignedinteger], NDArray[np.unsignedinteger]]:
    """Signatures of these rows, lengths and joins, where equal ones of several parts are one:
    what is solved for a signature is solved once."""
    width = max((part.lengths.shape[1] for part in parts), default=1)
    lengths = np.concatenate([np.zeros((0, width), np.uint8), *(p.lengths for p in parts)])
    joins = np.concatenate([np.zeros((0, width, width), np.uint8), *(p.joins for p in parts)])
    before = np.cumsum([0, *(len(part.lengths) for part in parts)])
    number = np.concatenate(
        [np.zeros(0, np.int64), *(p.signature + b for p, b in zip(parts, before, strict=False))]
    )[rows]
    used, number = np.unique(number, return_inverse=True)
    table = np.ascontiguousarray(
        np.hstack([lengths[used], joins[used].reshape(len(used), width * width)])
    )
    # One value a row, so that the sort compares bytes.
    keys = table.view(np.dtype((np.void, table.itemsize * table.shape[1]))).ravel()
    _, kept, same = np.unique(keys, return_index=True, return_inverse=True)
    chosen = used[kept]
    return same[number].astype(np.int32), shrink(lengths[chosen]), shrink(joins[chosen])
