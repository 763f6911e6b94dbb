"""The census: which pattern a patch reduces to, and how often each pattern was met.

A patch is reduced, read as a code from one of its corners, and looked up; only a reading
never met before is turned into the canonical code. So the common case costs one
reduction, one breadth-first reading and one look-up.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ingest.hashing import LOAD, UInt64Array, double_map, empty_keys, find, hash_symbols
from patterndb.core.buffers import copy_items, copy_rows
from patterndb.core.code import Code, clockwise_start, rooted_code, smallest_code
from patterndb.core.halfedge import Index, Int32Array, border_vertices
from patterndb.core.reduction import (
    NEVER_FULL,
    ReductionWork,
    cut_blocks,
    mark_chains,
    read_pattern,
    reduction_work,
)
from patterndb.system.kernels import kernel

#: Slots of a map that only saves work: 84 MB with their values. What is forgotten at deep limits is
#: worked out again when it is met.
MOST_SLOTS = 1 << 22

#: Most bytes that one of the 16 bits' symbols takes when it is packed.
SYMBOL_BYTES = 3


class KernelMesh(NamedTuple):
    """What the kernels read of a quad mesh.

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


@kernel
def new_bench(n_quads: int, n_vertices: int, limit: int) -> Bench:
    """Scratch for patches of at most ``limit`` quads."""
    return Bench(
        np.full(n_quads, -1, np.int32),
        np.zeros(n_vertices, np.int32),
        np.zeros(limit, np.int32),
        np.zeros(4 * limit, np.int32),
        np.zeros(4 * limit, np.int32),
        np.zeros(1, np.int64),
        np.zeros(4 * limit, np.uint16),
        np.zeros(limit, np.int32),
        np.zeros(limit, np.int32),
        np.zeros(limit, np.int32),
        reduction_work(n_vertices, limit),
    )


@kernel
def kernel_mesh(
    twin: Int32Array, vertex: Int32Array, n_vertices: int, zobrist: UInt64Array
) -> KernelMesh:
    """The kernels' view of a mesh."""
    valence = np.zeros(n_vertices, np.int32)
    for h in range(len(vertex)):
        valence[vertex[h]] += 1
    border = border_vertices(twin, vertex, n_vertices)
    full = valence.copy()
    star_start = np.zeros(n_vertices + 1, np.int32)
    for v in range(n_vertices):
        if border[v]:
            full[v] = NEVER_FULL
        star_start[v + 1] = star_start[v] + valence[v]
    at = star_start[:-1].copy()
    star = np.empty(len(vertex), np.int32)
    for h in range(len(vertex)):
        star[at[vertex[h]]] = h >> 2
        at[vertex[h]] += 1
    return KernelMesh(twin, vertex, valence, full, star_start, star, zobrist)


@kernel(borrowing=True)
def recognise(n: Index, n_border: Index, mesh: KernelMesh, bench: Bench, census: Census) -> Index:
    """2 * row + handedness of the pattern of the patch ``bench.quads[:n]``, which must be a disk;
    -1 if its reading is not known: then :func:`add_reading` has to follow.

    ``bench.reduction.border[:n_border]`` are the half-edges of its border.
    """
    m = _read(n, n_border, mesh, bench)
    a, b = hash_symbols(bench.code, 4 * m)
    slot = find(census.reading_keys, a, b)
    return census.reading_rows[slot] if slot >= 0 else -1


@kernel(borrowing=True)
def _read(n: Index, n_border: Index, mesh: KernelMesh, bench: Bench) -> Index:
    """Read the patch's pattern from one of its corners into ``bench.code``; how many quads."""
    twin, vertex, held, work = bench.twin, bench.vertex, bench.held, bench.reduction
    mark_chains(n, twin, vertex, held, mesh.full, work, n_border, bench.curvature[0])
    # From a corner; without one, from whatever is left of the border.
    start = -1
    for i in range(n_border):
        h = work.border[i]
        v = vertex[h]
        if held[v] != 2:
            start = h
            break
        if start < 0 and work.gone[v] != work.stamp[0]:
            start = h
    return read_pattern(start, twin, vertex, bench.code, work)


@kernel(borrowing=True)
def add_reading(n: Index, n_border: Index, mesh: KernelMesh, bench: Bench, census: Census) -> Index:
    """Note the reading that :func:`recognise` did not know, and its pattern if that is new; return
    2 * row + handedness. The census must have room for it (:func:`with_room`)."""
    m = _read(n, n_border, mesh, bench)
    a, b = hash_symbols(bench.code, 4 * m)
    held, work = bench.held, bench.reduction
    code, number, entry, order = bench.code, bench.number, bench.entry, bench.order
    _, n_starts = cut_blocks(n, bench.twin, bench.vertex, held, work)
    smallest_code(work.reduced, m, work.starts, n_starts, False, code, number, entry, order)
    handedness = 0
    for s in range(n_starts):
        h = clockwise_start(work.reduced, work.starts[s])
        if rooted_code(work.reduced, m, h, True, code, number, entry, order, True) < 0:
            handedness = 1
    first = bench.vertex[work.head[work.starts[0]]]
    sides = n_starts if held[first] != 2 else 0
    value = 2 * _row_of(code, 4 * m, sides, census) + handedness
    slot = -1 - find(census.reading_keys, a, b)
    census.reading_keys[slot, 0] = a
    census.reading_keys[slot, 1] = b
    census.reading_rows[slot] = value
    census.used[2] += 1
    return value


@kernel(borrowing=True)
def _row_of(code: Code, n: int, sides: int, census: Census) -> Index:
    """The row of the canonical code ``code[:n]``, a new one if there is none."""
    a, b = hash_symbols(code, n)
    slot = find(census.code_keys, a, b)
    if slot >= 0:
        return census.code_rows[slot]
    slot = -1 - slot
    row = census.used[0]
    at = census.ends[row]
    for i in range(n):
        symbol = code[i]
        while symbol > 127:
            census.codes[at] = symbol & 127 | 128
            symbol >>= 7
            at += 1
        census.codes[at] = symbol
        at += 1
    census.ends[row + 1] = at
    census.sides[row] = sides
    census.code_keys[slot, 0] = a
    census.code_keys[slot, 1] = b
    census.code_rows[slot] = row
    census.used[0] = row + 1
    census.used[1] = at
    return row


@kernel(borrowing=True)
def has_room(census: Census, n: int) -> bool:
    """Is there room for one more reading, one more row of n symbols and its example of as many
    quads as these have?"""
    used = census.used
    return (
        used[2] + 1 <= LOAD * census.reading_keys.shape[0]
        and used[0] + 1 <= LOAD * census.code_keys.shape[0]
        and used[1] + SYMBOL_BYTES * n <= len(census.codes)
        and used[0] < census.patches.shape[0]
        and used[3] + n // 4 <= len(census.example)
    )


@kernel
def with_room(census: Census, n: int) -> Census:
    """The census with the room that :func:`has_room` asks for."""
    reading_keys, reading_rows = census.reading_keys, census.reading_rows
    if census.used[2] + 1 > LOAD * reading_keys.shape[0]:
        if reading_keys.shape[0] < census.most[0]:
            reading_keys, reading_rows = double_map(reading_keys, reading_rows)
        else:
            # Rows keep their codes, so that a reading that is forgotten finds its row again.
            empty_keys(reading_keys)
            census.used[2] = 0
    code_keys, code_rows = census.code_keys, census.code_rows
    if census.used[0] + 1 > LOAD * code_keys.shape[0]:
        code_keys, code_rows = double_map(code_keys, code_rows)
    codes = census.codes
    if census.used[1] + SYMBOL_BYTES * n > len(codes):
        codes = np.zeros(2 * len(codes) + SYMBOL_BYTES * n, np.uint8)
        copy_items(census.codes, census.used[1], codes, 0)
    ends, sides, patches = census.ends, census.sides, census.patches
    example_size, example_hash = census.example_size, census.example_hash
    example_at, example = census.example_at, census.example
    if census.used[3] + n // 4 > len(example):
        example = np.zeros(2 * len(example) + n // 4, np.int32)
        copy_items(census.example, census.used[3], example, 0)
    rows = census.patches.shape[0]
    if census.used[0] == rows:
        ends = np.zeros(2 * rows + 1, np.int64)
        copy_items(census.ends, rows + 1, ends, 0)
        sides = np.zeros(2 * rows, np.int32)
        copy_items(census.sides, rows, sides, 0)
        patches = np.zeros((2 * rows, 2), np.int64)
        copy_rows(census.patches, rows, patches)
        example_size = np.zeros(2 * rows, np.int32)
        copy_items(census.example_size, rows, example_size, 0)
        example_hash = np.zeros((2 * rows, 2), np.uint64)
        copy_rows(census.example_hash, rows, example_hash)
        example_at = np.zeros(2 * rows, np.int64)
        copy_items(census.example_at, rows, example_at, 0)
    return Census(
        census.used,
        census.most,
        reading_keys,
        reading_rows,
        code_keys,
        code_rows,
        codes,
        ends,
        sides,
        patches,
        example_size,
        example_hash,
        example_at,
        example,
    )


@kernel(borrowing=True)
def count_patch(value: Index, census: Census) -> None:
    """Count a patch of the pattern and handedness that :func:`recognise` told."""
    census.patches[value >> 1, value & 1] += 1


@kernel(borrowing=True)
def propose_example(
    row: Index, n: Index, a: np.uint64, b: np.uint64, quads: Int32Array, census: Census
) -> None:
    """Let the patch ``quads[:n]`` with hash (a, b) be the row's example if it is the first
    of its size or smaller than the one there."""
    size = census.example_size[row]
    if size != 0 and size < n:
        return
    if size == n:
        x, y = census.example_hash[row, 0], census.example_hash[row, 1]
        if x < a or (x == a and y <= b):
            return
    if size == 0:
        census.example_at[row] = census.used[3]
        census.used[3] += n
    # A better one has no more quads than the first, and takes its place.
    at = census.example_at[row]
    census.example_size[row] = n
    census.example_hash[row, 0] = a
    census.example_hash[row, 1] = b
    for i in range(n):
        census.example[at + i] = quads[i]


@kernel(borrowing=True)
def add_quad(q: Index, place: Index, mesh: KernelMesh, bench: Bench) -> int:
    """Put quad q into the patch at hand at ``place``; return the change of V - E + F.

    A non-empty patch that stays edge-connected is a disk exactly if its V - E + F is 1:
    a vertex that its boundary visits twice, a hole or a handle would make it smaller, and
    only a closed surface has more.
    """
    change = -3
    for e in range(4):
        v = mesh.vertex[4 * q + e]
        held = bench.held[v] + 1
        bench.held[v] = held
        if held == 1:
            change += 1
        if held < 4 and held == mesh.full[v]:
            bench.curvature[0] += 4 - held
        bench.vertex[4 * place + e] = v
        t = mesh.twin[4 * q + e]
        there = -1
        if t >= 0:
            j = bench.member[t >> 2]
            if j >= 0:
                change += 1
                there = 4 * j + (t & 3)
                bench.twin[there] = 4 * place + e
        bench.twin[4 * place + e] = there
    bench.member[q] = place
    bench.quads[place] = q
    return change


@kernel(borrowing=True)
def remove_quad(q: Index, mesh: KernelMesh, bench: Bench) -> None:
    """Take quad q, the last one added, out of the patch at hand."""
    place = bench.member[q]
    bench.member[q] = -1
    for e in range(4):
        v = bench.vertex[4 * place + e]
        held = bench.held[v]
        bench.held[v] = held - 1
        if held < 4 and held == mesh.full[v]:
            bench.curvature[0] -= 4 - held
        t = bench.twin[4 * place + e]
        if t >= 0:
            bench.twin[t] = -1


def reset_counts(census: Census) -> None:
    """Forget the counts and examples of the task at hand, and keep the codes."""
    used = int(census.used[0])
    census.patches[:used] = 0
    census.example_size[:used] = 0
    census.used[3] = 0
