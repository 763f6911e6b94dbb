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

from patterndb._native.core.code import code_starts, smallest_code
from patterndb.core.halfedge import Int32Array
from patterndb.core.packing import pack
from patterndb.errors import InvalidCodeError

Code = NDArray[np.uint16]

#: Quads that a 16-bit symbol can name: 1 + 4 * j + 3 <= 65535.
MAX_QUADS = 16383

#: Largest number of sides that an id tells; patterns with more share this class of ids.
MAX_CLASS = 127


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
