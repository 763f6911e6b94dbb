"""Canonical codes: one list of symbols per pattern, the same from wherever one looks.

Quads are numbered breadth-first from a starting corner; the code lists each quad's
neighbours counter-clockwise from the edge by which the quad was reached. Symbol 0 is
a border edge; symbol ``1 + 4 * j + e`` is quad j, entered by its edge e, counted from
the edge by which j itself was reached (two quads may share two edges, so the quad
alone would not tell). Among all starting corners (all border vertices where there is no
corner) the lexicographically smallest code wins; a mirror image is coded clockwise.

Source: Marcias et al. 2015, section 3.3. Differs from the paper: the paper visits
vertices and names only the neighbouring face, which two faces sharing two edges make
ambiguous; here the visit is over quads and the symbol names the edge too.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array, fans, next_border_edge, prev_edge
from patterndb.core.packing import pack
from patterndb.errors import InvalidCodeError
from patterndb.system.kernels import kernel

Code = NDArray[np.uint16]

#: Quads that a 16-bit symbol can name: 1 + 4 * j + 3 <= 65535.
MAX_QUADS = 16383

#: Largest number of sides that an id tells; patterns with more share this class of ids.
MAX_CLASS = 127


@kernel(borrowing=True)
def rooted_code(
    twin: Int32Array,
    n_quads: int,
    start: int,
    clockwise: bool,
    code: NDArray[np.uint16],
    number: Int32Array,
    entry: Int32Array,
    order: Int32Array,
    best: bool,
) -> int:
    """Write the code read from half-edge ``start`` into ``code``.

    code: (>= 4 * n_quads,) uint16; number, entry, order: (>= n_quads,) int32 scratch.
    With ``best``, ``code`` already holds one and is only overwritten by a smaller one.
    Returns -1 if written, 0 if equal to what was there, 1 if larger (nothing written).
    """
    for q in range(n_quads):
        number[q] = -1
    step = 3 if clockwise else 1
    root = start >> 2
    number[root] = 0
    entry[0] = start & 3
    order[0] = root
    count = 1
    state = 0 if best else -1
    at = 0
    for i in range(n_quads):
        base = order[i] * 4
        e = entry[i]
        for r in range(4):
            t = twin[base + ((e + r * step) & 3)]
            if t < 0:
                symbol = 0
            else:
                q = t >> 2
                j = number[q]
                if j < 0:
                    j = count
                    number[q] = j
                    order[j] = q
                    entry[j] = t & 3
                    count += 1
                symbol = 1 + 4 * j + ((((t & 3) - entry[j]) * step) & 3)
            if state == 0:
                if symbol < code[at]:
                    state = -1
                elif symbol > code[at]:
                    return 1
            if state < 0:
                code[at] = symbol
            at += 1
    return state


@kernel(borrowing=True)
def clockwise_start(twin: Int32Array, h: int) -> int:
    """The border half-edge that ends at the tail of border half-edge h.

    Seen in a mirror, it is the one that starts there.
    """
    while True:
        h = prev_edge(h)
        if twin[h] < 0:
            return h
        h = twin[h]


@kernel(borrowing=True)
def smallest_code(
    twin: Int32Array,
    n_quads: int,
    starts: Int32Array,
    n_starts: int,
    clockwise: bool,
    code: NDArray[np.uint16],
    number: Int32Array,
    entry: Int32Array,
    order: Int32Array,
) -> tuple[int, int]:
    """Write the smallest code over all starts; return (its first start, how many reach it).

    starts: (>= n_starts,) int32 border half-edges. The count is the number of rotations
    that map the pattern onto itself.
    """
    winner = -1
    ties = 0
    for s in range(n_starts):
        h = starts[s]
        if clockwise:
            h = clockwise_start(twin, h)
        state = rooted_code(twin, n_quads, h, clockwise, code, number, entry, order, s > 0)
        if state < 0:
            winner = s
            ties = 1
        elif state == 0:
            ties += 1
    return winner, ties


@kernel
def code_starts(twin: Int32Array, starts: Int32Array) -> int:
    """Write the half-edges a code may start from, in border order; return their number.

    They leave the corners (border vertices whose number of quads is not 2), or every
    border vertex where there is no corner. starts: (>= 4q,) int32.
    """
    first = -1
    for h in range(len(twin)):
        if twin[h] < 0:
            first = h
            break
    if first < 0:
        return 0
    count = 0
    for every in (False, True):
        h = first
        while True:
            if every or border_count(twin, h) != 2:
                starts[count] = h
                count += 1
            h = next_border_edge(twin, h)
            if h == first:
                break
        if count:
            break
    return count


@kernel
def border_count(twin: Int32Array, h: int) -> int:
    """Number of quads at the tail of border half-edge h."""
    count = 1
    h = prev_edge(h)
    while twin[h] >= 0:
        count += 1
        h = prev_edge(twin[h])
    return count


@kernel
def is_disk_code(twin: Int32Array) -> bool:
    """Are these the half-edges that a code of a disk describes?

    twin: (n,) int32 symbols less one, from any source: nothing is taken for granted. They
    must pair up, number their quads breadth-first from half-edge 0, which is on the
    border, and form a disk with one simple border.
    """
    n = len(twin)
    if n == 0 or n % 4 or twin[0] != -1:
        return False
    reached = 1
    n_border = 0
    for h in range(n):
        if h == 4 * reached:
            return False
        t = twin[h]
        if t < -1 or t >= n or t == h:
            return False
        if t == -1:
            n_border += 1
        elif twin[t] != h:
            return False
        elif t >= 4 * reached:
            if t != 4 * reached:
                return False
            reached += 1
    vertex, n_vertices = fans(twin)
    if n_vertices - (n + n_border) // 2 + n // 4 != 1:
        return False
    # A border of several loops, or one that meets itself, has fewer steps from edge 0.
    seen = np.zeros(n_vertices, np.bool_)
    h = 0
    steps = 0
    while True:
        if seen[vertex[h]]:
            return False
        seen[vertex[h]] = True
        steps += 1
        h = next_border_edge(twin, h)
        if h == 0:
            return steps == n_border


def canonical_code(twin: Int32Array) -> tuple[Code, bool, int, bool]:
    """Canonical code of a disk, the smaller of its own and its mirror image's.

    twin: (4q,) int32 half-edges of a disk. Returns (code (4q,) uint16, mirrored,
    rotations, chiral): whether the code was read in the mirror, how many rotations map
    the disk onto itself (>= 1), and whether its mirror image is another pattern.
    Raises InvalidCodeError for more than MAX_QUADS quads or a closed surface.
    """
    q = len(twin) // 4
    if q > MAX_QUADS:
        raise InvalidCodeError(f"{q} quads are more than a code can name ({MAX_QUADS})")
    starts = np.empty(4 * q, np.int32)
    n_starts = code_starts(twin, starts)
    if n_starts == 0:
        raise InvalidCodeError("a closed surface has no border to start a code from")
    scratch = [np.empty(q, np.int32) for _ in range(3)]
    own = np.zeros(4 * q, np.uint16)
    other = np.zeros(4 * q, np.uint16)
    _, rotations = smallest_code(twin, q, starts, n_starts, False, own, *scratch)
    smallest_code(twin, q, starts, n_starts, True, other, *scratch)
    differ = np.flatnonzero(own != other)
    if len(differ) == 0:
        return own, False, rotations, False
    mirrored = bool(other[differ[0]] < own[differ[0]])
    return (other if mirrored else own), mirrored, rotations, True


def decode(code: Code) -> Int32Array:
    """The half-edges (4q,) int32 that a code describes; its first edge is half-edge 0.

    Raises InvalidCodeError if the list is not the code of edge-connected quads numbered
    breadth-first.
    """
    symbols = np.asarray(code, dtype=np.int64)
    if symbols.ndim != 1 or len(symbols) == 0 or len(symbols) % 4:
        raise InvalidCodeError(f"a code has four symbols a quad, got {symbols.shape}")
    n = len(symbols)
    twin = np.full(n, -1, np.int32)
    inner = np.flatnonzero(symbols)
    targets = symbols[inner] - 1
    if len(targets) and targets.min() < 0:
        raise InvalidCodeError(f"symbol {inner[targets.argmin()]} is negative")
    if len(targets) and targets.max() >= n:
        at = inner[targets.argmax()]
        raise InvalidCodeError(
            f"symbol {at} names quad {(symbols[at] - 1) // 4}, but the code has {n // 4} quads"
        )
    twin[inner] = targets
    if not (twin[twin[inner]] == inner).all():
        at = inner[np.flatnonzero(twin[twin[inner]] != inner)[0]]
        raise InvalidCodeError(f"symbol {at} names an edge that does not name it back")
    if (twin == np.arange(n)).any():
        raise InvalidCodeError(f"symbol {np.flatnonzero(twin == np.arange(n))[0]} names itself")
    seen = 1
    for at in range(n):
        if at == 4 * seen:
            raise InvalidCodeError(f"quad {seen} is not reached from the quads before it")
        t = int(twin[at])
        if t >= 4 * seen:
            if t != 4 * seen:
                raise InvalidCodeError(f"symbol {at} should be the first to reach quad {seen}")
            seen += 1
    return twin


def format_id(number: int) -> str:
    """A pattern's id as people write it: 16 hexadecimal digits."""
    return f"{number:016x}"


def pattern_id(code: Code | bytes, n_sides: int) -> int:
    """The pattern's id, the same in every database, of its code or its packed code.

    The number of sides (127 standing for more) in the top byte, then 56 bits of the code's
    BLAKE2b hash. So the patterns of one class lie together in a table ordered by id.
    """
    data = code if isinstance(code, bytes) else pack(code)
    digest = hashlib.blake2b(data, digest_size=7).digest()
    return min(n_sides, MAX_CLASS) << 56 | int.from_bytes(digest, "big")


def pattern_ids(codes: Iterable[bytes], n_sides: NDArray[np.integer]) -> NDArray[np.int64]:
    """(n,) int64 ids of patterns of these packed codes and numbers of sides (n,)."""
    pairs = zip(codes, n_sides.tolist(), strict=True)
    return np.fromiter((pattern_id(c, n) for c, n in pairs), np.int64, len(n_sides))
