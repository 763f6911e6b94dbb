"""Everything about a pattern that follows from its code, for many patterns at once.

The kernel runs without the interpreter lock, so descriptions of a mesh's new patterns
are made beside the learning of the next mesh.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

from patterndb.core.buffers import copy_items, sort_few
from patterndb.core.code import Code, border_count, clockwise_start, is_disk_code, rooted_code
from patterndb.core.halfedge import fans, next_border_edge
from patterndb.core.label import canonical_word, label_word
from patterndb.core.packing import take_stretches, unpack_many
from patterndb.core.polychord import trace
from patterndb.errors import InvalidCodeError
from patterndb.system.kernels import kernel

# Columns of the table of counts that the kernel fills.
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


@kernel
def _describe(
    flat: Code, offsets: NDArray[np.int64]
) -> tuple[NDArray[np.int32], NDArray[np.uint16], NDArray[np.int64], int]:
    n = len(offsets) - 1
    counts = np.zeros((n, COLUMNS), np.int32)
    ends = np.zeros(LISTS * n + 1, np.int64)
    # A pattern of q quads has at most 2q + 2 vertices, and as many boundary edges and
    # sides; the lists hold vertices, twice sides and edges, sides, and the chords' ends.
    lists = np.zeros(7 * (2 * (len(flat) // 4) + 3 * n), np.uint16)
    at = 0
    for i in range(n):
        size = offsets[i + 1] - offsets[i]
        q = size // 4
        counts[i, N_QUADS] = q
        twin = np.empty(size, np.int32)
        for h in range(size):
            twin[h] = np.int32(flat[offsets[i] + h]) - 1
        if not is_disk_code(twin):
            return counts, lists, ends, i
        vertex, n_vertices = fans(twin)
        valence = np.zeros(n_vertices, np.int32)
        inner = np.ones(n_vertices, np.bool_)
        for h in range(size):
            valence[vertex[h]] += 1
            if twin[h] < 0:
                inner[vertex[h]] = False

        # Boundary from half-edge 0, where the code begins.
        perimeter = 0
        h = 0
        loop = np.empty(size, np.int32)
        while True:
            loop[perimeter] = h
            perimeter += 1
            h = next_border_edge(twin, h)
            if h == 0:
                break
        starts = np.empty(perimeter, np.int32)
        side_start = np.empty(perimeter, np.int32)
        n_corners = 0
        for j in range(perimeter):
            k = border_count(twin, loop[j])
            if k != 2:
                starts[n_corners] = loop[j]
                side_start[n_corners] = j
                n_corners += 1
                counts[i, N_REFLEX] += k > 2
                lists[at] = k
                at += 1
        counts[i, N_CORNERS] = n_corners
        counts[i, PERIMETER] = perimeter
        ends[LISTS * i + 1] = at

        first_valence = at
        for v in range(n_vertices):
            if inner[v] and valence[v] != 4:
                lists[at] = valence[v]
                at += 1
        sort_few(lists, first_valence, at)
        counts[i, N_IRREGULAR] = at - first_valence
        ends[LISTS * i + 2] = at

        # Symmetry: rotations that give the same code, and whether the mirror image does.
        n_starts = n_corners
        if n_corners == 0:
            n_starts = perimeter
            copy_items(loop, perimeter, starts, 0)
        number = np.empty(q, np.int32)
        entry = np.empty(q, np.int32)
        order = np.empty(q, np.int32)
        # Written only where a smaller one is found, and then it is not looked at again.
        code = flat[offsets[i] : offsets[i + 1]].copy()
        counts[i, CHIRAL] = 1
        for s in range(n_starts):
            own = rooted_code(twin, q, starts[s], False, code, number, entry, order, True)
            counts[i, ROTATIONS] += own == 0
            if own < 0:
                return counts, lists, ends, i
            h = clockwise_start(twin, starts[s])
            other = rooted_code(twin, q, h, True, code, number, entry, order, True)
            if other == 0:
                counts[i, CHIRAL] = 0
            if other < 0:
                return counts, lists, ends, i

        of_edge, n_open, n_total = trace(twin)
        counts[i, N_CHORDS] = n_open
        counts[i, N_LOOPS] = n_total - n_open
        for f in range(q):
            if of_edge[4 * f] == of_edge[4 * f + 1]:
                counts[i, SELF_CROSSING] = 1

        chord = np.empty(perimeter, np.int32)
        for j in range(perimeter):
            chord[j] = of_edge[loop[j]]
        n_sides = n_corners
        if n_corners == 0:
            n_sides = 1
            side_start[0] = 0
        word = np.empty(n_sides + perimeter, np.int32)
        best = np.empty(n_sides + perimeter, np.int32)
        names = np.empty(n_total, np.int32)
        length = label_word(chord, side_start, n_sides, perimeter, 0, False, word, names)
        for j in range(length):
            lists[at] = word[j]
            at += 1
        ends[LISTS * i + 3] = at
        length, rotation, reflected, symmetries = canonical_word(
            chord, side_start, n_sides, n_corners, perimeter, best, word, names
        )
        for j in range(length):
            lists[at] = best[j]
            at += 1
        ends[LISTS * i + 4] = at
        first_end = np.full(n_open, -1, np.int32)
        last_end = np.empty(n_open, np.int32)
        j = 0
        for side in range(n_sides):
            lists[at] = best[j]
            at += 1
            for k in range(j + 1, j + 1 + best[j]):
                c = best[k]
                if first_end[c] < 0:
                    first_end[c] = side
                else:
                    last_end[c] = side
            j += 1 + best[j]
        ends[LISTS * i + 5] = at
        for c in range(n_open):
            lists[at] = first_end[c]
            lists[at + 1] = last_end[c]
            at += 2
        ends[LISTS * i + 6] = at
        counts[i, SIG_ROTATION] = rotation
        counts[i, SIG_REFLECTED] = reflected
        counts[i, SIG_SYMMETRIES] = symmetries
    return counts, lists[:at].copy(), ends, -1
