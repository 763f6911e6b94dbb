"""Everything about a pattern that follows from its code, for many patterns at once.

The compiled core runs without the interpreter lock, so descriptions of a mesh's new patterns
are made beside the learning of the next mesh.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

from patterndb._native.core.description import describe as _describe
from patterndb.core.code import Code
from patterndb.core.packing import take_stretches, unpack_many
from patterndb.errors import InvalidCodeError

# Columns of the table of counts.
N_CORNERS = 0
N_REFLEX = 1
N_IRREGULAR = 2
N_CHORDS = 3
N_LOOPS = 4
SELF_CROSSING = 5
ROTATIONS = 6
CHIRAL = 7
PERIMETER = 8
SIG_ROTATION = 9
SIG_REFLECTED = 10
SIG_SYMMETRIES = 11
N_QUADS = 12
COLUMNS = 13


# Lists of numbers that it fills for every pattern.
CORNERS = 0  # quads at each corner
VALENCES = 1  # of the irregular vertices, ascending
LABEL = 2  # word of patterndb.core.label
SIGNATURE = 3  # word of patterndb.core.label
LENGTHS = 4  # of the signature's sides
JOINS = 5  # for every polychord of the signature the two sides it joins
LISTS = 6


@dataclass(frozen=True, slots=True, eq=False)
class Descriptions:
    """One row a pattern, in the order of the codes given.

    counts: (n, COLUMNS) int32, see the column names of this module.
    flat, ends: the lists, see their names: list k of row i is
        ``flat[ends[LISTS * i + k]:ends[LISTS * i + k + 1]]``.
    """

    counts: NDArray[np.int32]
    flat: NDArray[np.uint16]
    ends: NDArray[np.int64]

    def numbers(self, row: int, which: int) -> NDArray[np.uint16]:
        """One list of one row."""
        at = LISTS * row + which
        return self.flat[self.ends[at] : self.ends[at + 1]]

    def take(self, rows: NDArray[np.integer]) -> SomeDescriptions:
        """The rows of these places, in this order."""
        return SomeDescriptions(self, rows, self.counts[rows])

    def split(self, which: int) -> list[bytes]:
        """One list of every row as bytes, which are equal where the lists are."""
        return self.take(np.arange(len(self.counts))).split(which)


@dataclass(frozen=True, slots=True, eq=False)
class SomeDescriptions:
    """Rows of descriptions. counts: theirs."""

    whole: Descriptions
    rows: NDArray[np.integer]
    counts: NDArray[np.int32]

    def take(self, rows: NDArray[np.integer]) -> SomeDescriptions:
        """The rows of these places among them, in this order."""
        return self.whole.take(self.rows[rows])

    def gather(self, which: int) -> tuple[NDArray[np.uint16], NDArray[np.int64]]:
        """One list of every row, one after the other, and the (n + 1,) places that part them."""
        at = LISTS * self.rows + which
        begin = self.whole.ends[at]
        sizes = self.whole.ends[at + 1] - begin
        starts = np.zeros(len(sizes) + 1, np.int64)
        np.cumsum(sizes, out=starts[1:])
        return take_stretches(self.whole.flat, begin, sizes), starts

    def split(self, which: int) -> list[bytes]:
        """One list of every row as bytes, which are equal where the lists are."""
        numbers, starts = self.gather(which)
        data = numbers.tobytes()
        return [data[a:b] for a, b in itertools.pairwise((starts * numbers.itemsize).tolist())]


def describe(codes: Sequence[Code] | Sequence[bytes]) -> Descriptions:
    """Describe canonical codes of disks, as numbers or packed.

    Raises InvalidCodeError, with its row, if one is no code, not a disk's, or not canonical.
    """
    if codes and isinstance(codes[0], bytes):
        symbols, offsets = unpack_many(cast("Sequence[bytes]", codes))
        flat = symbols.astype(np.uint16)
    else:
        arrays = cast("Sequence[Code]", codes)
        offsets = np.r_[0, np.cumsum([len(c) for c in arrays])].astype(np.int64)
        flat = np.concatenate(arrays) if arrays else np.zeros(0, np.uint16)
    return describe_symbols(flat, offsets)


def describe_symbols(flat: Code, offsets: NDArray[np.int64]) -> Descriptions:
    """As :func:`describe`, of codes in one array of symbols, parted by (n + 1,) offsets."""
    counts, lists, ends, bad = _describe(flat, offsets)
    if bad >= 0:
        raise InvalidCodeError(
            f"code {bad} of {len(offsets) - 1} is not the canonical code of a disk", bad
        )
    return Descriptions(counts, lists, ends)
