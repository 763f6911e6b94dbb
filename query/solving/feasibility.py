"""Which patterns of a class fit a boundary by its lengths alone, and in which orientations.

Whether lengths can be met depends on a pattern's signature and on the orientation alone. Each is
one system. A sieve rejects most of them, all orientations of a signature together; parity and Hall
conditions may reject others; a flow decides the rest, and the cut that one orientation fails by,
others of the same system often fail by as well (rust/query/src/solving/feasibility.rs). Marcias et
al. 2015, section 4, solve one integer program a pattern.

The sieve has two conditions. A side of a pattern can be no shorter than its base length, and its
neighbours together must be longer than theirs by as much as it is, since a polychord takes as much
from one end as from the other:

    lengths_i >= base_i
    sum of lengths_j - lengths_i >= sum of base_j - base_i, over the sides j that i is joined to

The right-hand sides are the pattern's, the left-hand ones the boundary's: the first depends on the
side alone, the second on the side and its neighbours, a *claim*
(:class:`query.solving.systems.Systems`). A class of 20,000 patterns of 12 sides has some 3,000 of
these, so that a query works all left-hand sides out once, a byte for each *lane*, which is a way in
which a pattern can see the boundary, and compares eight lanes at a time
(rust/query/src/solving/sieve.rs).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb._native.query.solving.feasibility import mark, pack_lengths, state_claims
from patterndb.core.halfedge import Int32Array, Int64Array
from query.cancellation import CancelFlag, share_out
from query.solving.systems import SignatureRows, Systems, systems_of

#: Patterns that a thread takes at a time: a millisecond of work or less, so that all
#: threads end together, and so much that handing it over costs nothing.
ROWS_PER_THREAD = 2048

#: The most times that patterns are handed over: of many a thread takes more.
MOST_SHARES = 64

#: Claims likewise.
CLAIMS_PER_THREAD = 4096

#: Lanes in a word.
LANES = 8


@dataclass(frozen=True, slots=True, eq=False)
class Lanes:
    """The different ways in which a signature can see a boundary, for the compiled core.

    lengths:  (n, w) int32, of every lane.
    lane_of:  (o,) int32 the lane of each orientation.
    marks:    (g,) int64 words with the highest bit of every lane.
    compared: int64 words, the lengths compared with all base lengths.
    """

    lengths: Int32Array
    lane_of: Int32Array
    marks: Int64Array
    compared: Int64Array

    @classmethod
    def of_lengths(cls, lengths: Int32Array) -> Lanes:
        """Of the lengths (o, w) in every orientation."""
        number: dict[bytes, int] = {}
        which = np.array(
            [number.setdefault(row.tobytes(), len(number)) for row in lengths], np.int32
        )
        different = lengths[np.unique(which, return_index=True)[1]]
        return cls(different, which, *pack_lengths(different))


@dataclass(frozen=True, slots=True, eq=False)
class PatternRows:
    """Some rows of a class, for the compiled core.

    rows: (r,) int64. signature, rotation, reflected: of all rows, see
    :class:`query.solving.systems.SignatureRows`. allowed: (r, ceil(o / 8)) uint8 packed.
    """

    rows: NDArray[np.int64]
    signature: Int32Array
    rotation: Int32Array
    reflected: NDArray[np.bool_]
    allowed: NDArray[np.uint8]


class LengthTest:
    """Finds the patterns that can meet the lengths of one boundary.

    lengths: (o, w) int32 in every orientation. Once ``cancelled`` is set, a call ends within a
    fraction of a millisecond, and rows not looked at count as unfit.
    """

    def __init__(self, lengths: Int32Array, cancelled: CancelFlag, threads: int | None) -> None:
        self._lanes = Lanes.of_lengths(lengths)
        self._seen = np.ascontiguousarray(self._lanes.lengths.T)
        self._cancelled = cancelled
        self._threads = threads
        # The claims stated for the systems that were last asked about.
        self._stated: tuple[Systems, NDArray[np.uint8]] | None = None

    def find(
        self,
        patterns: SignatureRows,
        rows: NDArray[np.int64],
        allowed: NDArray[np.uint8],
        *,
        once: bool = False,
    ) -> NDArray[np.bool_]:
        """(r, o) bool: the allowed orientations in which lengths can be met.

        With ``once`` (r, 1) bool: can they in any?

        allowed: (r, ceil(o / 8)) uint8, orientations as np.packbits packs them.
        """
        fits = np.zeros((len(rows), 1 if once else len(self._lanes.lane_of)), np.bool_)
        systems = systems_of(patterns)
        stated = self._state_claims(systems, patterns.signature, rows)
        share = max(ROWS_PER_THREAD, len(rows) // MOST_SHARES)

        def run(first: int) -> None:
            some = slice(first, first + share)
            mark(
                systems,
                self._lanes,
                stated,
                PatternRows(
                    rows[some],
                    patterns.signature,
                    patterns.rotation,
                    patterns.reflected,
                    allowed[some],
                ),
                self._cancelled,
                fits[some],
            )

        share_out(run, range(0, len(rows), share), self._threads)
        return fits

    def _state_claims(
        self, systems: Systems, signature: Int32Array, rows: NDArray[np.int64]
    ) -> Int64Array:
        """(k, g) words, what the boundary has for every claim of the rows."""
        if self._stated is None or self._stated[0] is not systems:
            size = (len(systems.claimant), len(self._lanes.marks) * LANES)
            self._stated = systems, np.zeros(size, np.uint8)
        stated = self._stated[1]
        # Few rows make few of the claims.
        if len(rows) * systems.claim.shape[1] < len(stated):
            claims = systems.claim[signature[rows]].ravel()
            state_claims(systems, self._seen, claims, 0, stated)
        else:
            every = np.arange(len(stated), dtype=np.int32)

            def state(first: int) -> None:
                some = slice(first, first + CLAIMS_PER_THREAD)
                state_claims(systems, self._seen, every[some], first, stated[some])

            share_out(state, range(0, len(every), CLAIMS_PER_THREAD), self._threads)
        return stated.view("<i8")
