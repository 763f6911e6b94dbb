"""Check the rows of a class against their codes, and find what their polychords join.

Kernels index by what stands in a class, so one from elsewhere is checked as it is loaded: its
columns must follow from its codes. Lengths and joins, by which most is indexed, are made here
of labels that have been checked, and are not read at all.

Describing the codes anew (:mod:`patterndb.core.description`) would double the cost of loading. Left
out is what needs every interior vertex or every possible start: that a code is a disk's and the
smallest, which is checked when a pattern is made of it; the symmetries and the turn to the
signature, which need only lie in their ranges.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb.core.code import MAX_QUADS, border_count
from patterndb.core.halfedge import Int32Array, next_border_edge
from patterndb.core.label import label_word
from patterndb.core.polychord import trace
from patterndb.system.kernels import kernel

#: What may be wrong with a row, as the columns of schema.sql are called.
CHECKED = (
    "code",
    "corners",
    "label",
    "signature",
    "n_reflex",
    "n_quads",
    "n_loops",
    "self_crossing",
    "rotations",
    "chiral",
    "sig_rotation",
    "sig_reflected",
)
CODE, CORNERS, LABEL, SIGNATURE = range(4)
N_REFLEX, N_QUADS, N_LOOPS, SELF_CROSSING = range(4, 8)
ROTATIONS, CHIRAL, SIG_ROTATION, SIG_REFLECTED = range(8, 12)

#: Those of them that are numbers.
NUMBERS = CHECKED[N_REFLEX:]


@dataclass(frozen=True, slots=True, eq=False)
class CheckedRows:
    """What came of checking p rows with s signatures.

    wrong: the first row that is wrong and the name of its column; None where all are right.
    lengths, joins: (s, w) and (s, w, w) int32, as in
        :class:`patterndb.core.patternclass.PatternClass`; of use only if no row is wrong.
    """

    wrong: tuple[int, str] | None
    lengths: NDArray[np.int32]
    joins: NDArray[np.int32]


def check_rows(
    codes: Sequence[bytes],
    corners: NDArray[np.int32],
    words: Int32Array,
    word_start: NDArray[np.int64],
    signature: NDArray[np.int32],
    numbers: NDArray[np.int64],
) -> CheckedRows:
    """Check p rows of a class of N sides.

    codes: packed. corners: (p, N) quads at each corner. words, word_start: (n,) and (p + 1,), the
    labels. signature: (p,) numbers of the signatures, 0, 1, 2, ... as they first appear.
    numbers: (8, p) the columns NUMBERS.
    """
    width = max(corners.shape[1], 1)
    n = int(signature.max(initial=-1)) + 1
    lengths = np.zeros((n, width), np.int32)
    joins = np.zeros((n, width, width), np.int32)
    ends = np.zeros(len(codes) + 1, np.int64)
    np.cumsum([len(code) for code in codes], out=ends[1:])
    row, column = _check_rows(
        np.frombuffer(b"".join(codes), np.uint8),
        ends,
        corners,
        words,
        word_start,
        signature,
        np.ascontiguousarray(numbers.T),
        lengths,
        joins,
    )
    return CheckedRows(None if row < 0 else (row, CHECKED[column]), lengths, joins)


@kernel
def _check_rows(
    raw: NDArray[np.uint8],
    ends: NDArray[np.int64],
    corners: NDArray[np.int32],
    words: Int32Array,
    word_start: NDArray[np.int64],
    signature: NDArray[np.int32],
    numbers: NDArray[np.int64],
    lengths: NDArray[np.int32],
    joins: NDArray[np.int32],
) -> tuple[int, int]:
    """Kernel of :func:`check_rows`: (row, place in CHECKED) of what is wrong first, or (-1, -1)."""
    most = 0
    for i in range(len(ends) - 1):
        most = max(most, ends[i + 1] - ends[i])
    twin = np.empty(most, np.int32)
    scratch = np.empty((4, 2 * most), np.int32)
    own_lengths = np.empty(lengths.shape[1], np.int32)
    own_joins = np.empty(joins.shape[1:], np.int32)
    known = 0
    for i in range(len(ends) - 1):
        size = _read_twins(raw, ends[i], ends[i + 1], twin)
        if size == 0:
            return i, CODE
        label = words[word_start[i] : word_start[i + 1]]
        s = signature[i]
        # The first row of a signature says what it is, and the others must say the same.
        first = s == known
        known += first
        l = lengths[s] if first else own_lengths  # noqa: E741
        j = joins[s] if first else own_joins
        wrong = _check_row(twin[:size], corners[i], label, numbers[i], l, j, scratch)
        if wrong >= 0:
            return i, wrong
        if not first:
            for a in range(len(l)):
                if l[a] != lengths[s, a]:
                    return i, SIGNATURE
                for b in range(len(l)):
                    if j[a, b] != joins[s, a, b]:
                        return i, SIGNATURE
    return -1, -1


@kernel
def _read_twins(raw: NDArray[np.uint8], begin: int, end: int, twin: Int32Array) -> int:
    """Write the half-edges of a packed code; return how many, 0 where it cannot be one."""
    size = 0
    at = begin
    while at < end:
        symbol = np.int32(raw[at] & 127)
        shift = 7
        while raw[at] > 127:
            at += 1
            if at == end or shift > 14:
                return 0
            symbol |= np.int32(raw[at] & 127) << shift
            shift += 7
        twin[size] = symbol - 1
        size += 1
        at += 1
    if size == 0 or size % 4 or size > 4 * MAX_QUADS or twin[0] != -1:
        return 0
    # Where edges name each other, walks along borders and polychords end.
    for h in range(size):
        t = twin[h]
        if t >= size or t == h or (t >= 0 and twin[t] != h):
            return 0
    return size


@kernel
def _check_row(
    twin: Int32Array,
    corners: NDArray[np.int32],
    label: Int32Array,
    numbers: NDArray[np.int64],
    lengths: NDArray[np.int32],
    joins: NDArray[np.int32],
    scratch: Int32Array,
) -> int:
    """The place in CHECKED of the first column that is wrong, -1 for none; writes the lengths and
    joins of its signature. scratch: (4, >= 2 * len(twin)) int32."""
    chord, side_start, names, word = scratch[0], scratch[1], scratch[2], scratch[3]
    of_edge, n_open, n_total = trace(twin)
    # The border from half-edge 0, where a code begins.
    perimeter = 0
    n_corners = 0
    n_reflex = 0
    h = 0
    while True:
        quads = border_count(twin, h)
        if quads != 2:
            if n_corners == len(corners):
                return CODE
            if corners[n_corners] != quads:
                return CORNERS
            side_start[n_corners] = perimeter
            n_corners += 1
            n_reflex += quads > 2
        chord[perimeter] = of_edge[h]
        perimeter += 1
        h = next_border_edge(twin, h)
        if h == 0:
            break
    # Another border would have ends of polychords too.
    if n_corners != len(corners) or perimeter != 2 * n_open or (n_corners and side_start[0]):
        return CODE
    turns = n_corners
    if n_corners == 0:
        turns = perimeter
        side_start[0] = 0
    width = len(lengths)

    length = width + perimeter
    if len(label) != length:
        return LABEL
    label_word(chord, side_start, width, perimeter, 0, False, word, names[:n_total])
    for j in range(length):
        if label[j] != word[j]:
            return LABEL

    if numbers[0] != n_reflex:
        return N_REFLEX
    if numbers[N_QUADS - N_REFLEX] != len(twin) // 4:
        return N_QUADS
    if numbers[N_LOOPS - N_REFLEX] != n_total - n_open:
        return N_LOOPS
    crossing = 0
    for f in range(len(twin) // 4):
        if of_edge[4 * f] == of_edge[4 * f + 1]:
            crossing = 1
    if numbers[SELF_CROSSING - N_REFLEX] != crossing:
        return SELF_CROSSING
    # Rotations are a group: their number divides that of all.
    rotations = numbers[ROTATIONS - N_REFLEX]
    if rotations < 1 or turns % rotations:
        return ROTATIONS
    if not 0 <= numbers[CHIRAL - N_REFLEX] <= 1:
        return CHIRAL
    turn = numbers[SIG_ROTATION - N_REFLEX]
    if not 0 <= turn < turns:
        return SIG_ROTATION
    if not 0 <= numbers[SIG_REFLECTED - N_REFLEX] <= 1:
        return SIG_REFLECTED

    # Side k of the label is this side of the signature; the ends of a polychord have one name.
    first_side = names
    for c in range(n_open):
        first_side[c] = -1
    joins[:] = 0
    at = 0
    for k in range(width):
        side = (turn - k if numbers[SIG_REFLECTED - N_REFLEX] else k - turn) % width
        lengths[side] = word[at]
        for j in range(at + 1, at + 1 + word[at]):
            c = word[j]
            if first_side[c] < 0:
                first_side[c] = side
            else:
                joins[first_side[c], side] += 1
                if first_side[c] != side:
                    joins[side, first_side[c]] += 1
        at += 1 + word[at]
    return -1
