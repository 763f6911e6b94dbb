"""The census: which pattern a patch reduces to, and how often each pattern was met.

A patch is reduced, read as a code from one of its corners, and looked up; only a reading
never met before is turned into the canonical code. So the common case costs one
reduction, one breadth-first reading and one look-up.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from patterndb.core.code import Code
from patterndb.core.halfedge import Int32Array
from patterndb.core.reduction import ReductionWork

#: Slots of a map that only saves work: 84 MB with their values. What is forgotten at deep limits is
#: worked out again when it is met.
MOST_SLOTS = 1 << 22


UInt64Array = NDArray[np.uint64]


class KernelMesh(NamedTuple):
    """What the search reads of a quad mesh.

    twin, vertex: (4q,) int32. valence: (v,) int32. full: (v,) int32 number of quads that
    makes the vertex interior, NEVER_FULL on the border. star_start, star: the quads at
    each vertex, star[star_start[v]:star_start[v + 1]]. zobrist: (q, 2) uint64.
    """

    twin: Int32Array
    vertex: Int32Array
    valence: Int32Array
    full: Int32Array
    star_start: Int32Array
    star: Int32Array
    zobrist: UInt64Array


class Census(NamedTuple):
    """Patterns met so far, as growing arrays; row r is one pattern.

    used:     (4,) int64: rows, bytes in ``codes``, keys in ``reading_keys``, quads in ``example``.
    most:     (1,) int64: slots that a map gets at most which only saves work (readings here, ways
              to build a patch in the basic mode): when it is full it begins anew.
    reading_keys, reading_rows: map from the hash of a reading to 2 * row + handedness;
              handedness 1 means that the patch is the mirror image of the stored code.
    code_keys, code_rows: map from the hash of a canonical code to its row.
    codes, ends: the canonical codes, packed (:mod:`patterndb.core.packing`), row r in
              codes[ends[r]:ends[r + 1]].
    sides:    (rows,) int32 number of sides.
    patches:  (rows, 2) int64 patches of the task at hand, by handedness.
    example_size, example_hash, example_at, example: the task's example of each row: the patch with
              the fewest quads, then the smallest hash, so that it does not depend on the order
              in which patches come. Its quads stand in ``example`` from place example_at[r] on.
    """

    used: NDArray[np.int64]
    most: NDArray[np.int64]
    reading_keys: UInt64Array
    reading_rows: Int32Array
    code_keys: UInt64Array
    code_rows: Int32Array
    codes: NDArray[np.uint8]
    ends: NDArray[np.int64]
    sides: Int32Array
    patches: NDArray[np.int64]
    example_size: Int32Array
    example_hash: UInt64Array
    example_at: NDArray[np.int64]
    example: Int32Array


class Bench(NamedTuple):
    """Scratch for recognising one patch at a time, for one mesh.

    member: (q,) int32, place of each quad in the patch at hand, -1 outside.
    held: (v,) int32, the patch's quads at each vertex. quads: (limit,) int32, the patch.
    twin, vertex: (4 * limit,) int32, the patch on its own. curvature: (1,) int64, the sum of 4 -
    valence over its interior vertices of valence 1 to 3. All of these :func:`add_quad` and
    :func:`remove_quad` keep up to date. code: (4 * limit,) uint16.
    """

    member: Int32Array
    held: Int32Array
    quads: Int32Array
    twin: Int32Array
    vertex: Int32Array
    curvature: NDArray[np.int64]
    code: Code
    number: Int32Array
    entry: Int32Array
    order: Int32Array
    reduction: ReductionWork


def new_census(rows: int = 1024, most: int = MOST_SLOTS) -> Census:
    """An empty census with room for some rows at first.

    most: the most slots of a map that only saves work, a power of two of at least 2.
    """
    return Census(
        np.zeros(4, np.int64),
        np.array([most], np.int64),
        np.zeros((min(8 * rows, most), 2), np.uint64),
        np.zeros(min(8 * rows, most), np.int32),
        np.zeros((4 * rows, 2), np.uint64),
        np.zeros(4 * rows, np.int32),
        np.empty(64 * rows, np.uint8),
        np.zeros(rows + 1, np.int64),
        np.zeros(rows, np.int32),
        np.zeros((rows, 2), np.int64),
        np.zeros(rows, np.int32),
        np.zeros((rows, 2), np.uint64),
        np.zeros(rows, np.int64),
        np.empty(16 * rows, np.int32),
    )


def reset_counts(census: Census) -> None:
    """Forget the counts and examples of the task at hand, and keep the codes."""
    used = int(census.used[0])
    census.patches[:used] = 0
    census.example_size[:used] = 0
    census.used[3] = 0
