"""Learning from one mesh: tasks that may run in parallel, and putting their results together.

A task counts the patterns of one range of smallest quads (basic mode) or of one shard's
roots (side and convex mode). Patches that reach into several shards are found from each of
them, so tasks report them one by one and they are counted when all is in. What is learned does
not depend on how the mesh is cut, nor on which task ends first.
"""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ingest.census import Census, UInt64Array, new_census, reset_counts
from ingest.prepare import prepare
from ingest.shards import cut_into_shards
from patterndb._native.ingest.basic import count_basic
from patterndb._native.ingest.census import kernel_mesh, new_bench
from patterndb._native.ingest.growth import grow
from patterndb._native.ingest.hashing import random_pairs
from patterndb._native.ingest.learning import hash_rows, pack_faces
from patterndb.core.code import pattern_ids
from patterndb.core.halfedge import Int32Array
from patterndb.core.packing import PackedRows, take_stretches
from patterndb.core.quadmesh import QuadMesh
from patterndb.store.records import Learned, LearningOptions, take_patterns

#: Quads of one task of the basic mode.
BASIC_RANGE = 2048

#: Bytes of the largest census that a thread keeps for its next task: one of some 400,000 patterns,
#: more than the default limits have found in 82 meshes.
LARGEST_CENSUS = 256 << 20


@dataclass(frozen=True, slots=True)
class Tally:
    """The result of one task.

    totals: patches by mode that were counted here. codes, sides, patches, example_size,
    example_hash: the patterns met, as in :class:`ingest.census.Census`. example: the quads of
    their examples, one after the other.
    far_*: patches that reach into other shards: mode, hash, row of this tally and
    handedness, row -1 where the basic mode counts them.
    """

    totals: tuple[int, int, int]
    codes: PackedRows
    sides: Int32Array
    patches: NDArray[np.int64]
    example_size: Int32Array
    example_hash: UInt64Array
    example: Int32Array
    far_mode: NDArray[np.int8]
    far_hash: UInt64Array
    far_row: Int32Array
    far_mirrored: NDArray[np.int8]


Task = Callable[[], Tally]


class MeshLearning:
    """Everything to be done for one mesh: ``tasks``, then ``finish(their results)``."""

    def __init__(
        self,
        quads: Int32Array,
        faces: NDArray[np.int64],
        options: LearningOptions,
        *,
        shard_quads: int,
        pulse: NDArray[np.int64],
    ) -> None:
        """quads: (q, 4) vertex indices; faces: (q,) their places in the file.

        shard_quads: the most quads of a growth task. pulse: (2,) int64 shared with the
        kernels: a number other than 0 in place 0 stops them, place 1 counts patches met.
        """
        mesh = QuadMesh.from_quads(quads)
        self.quads_read = mesh.n_quads
        self.options = options
        self._pulse = pulse
        self._mesh = prepare(mesh) if options.prepare else mesh
        self._faces = faces
        self._widest = max(options.basic, options.side, options.convex)
        m = self._mesh
        self._kernel = kernel_mesh(m.twin, m.vertex, m.n_vertices, random_pairs(m.n_quads))
        self._shard = cut_into_shards(m.twin, m.components(), shard_quads)
        self.tasks: list[Task] = []
        if m.n_quads and options.basic:
            for first in range(0, m.n_quads, BASIC_RANGE):
                self.tasks.append(self._basic_task(first, min(first + BASIC_RANGE, m.n_quads)))
        if m.n_quads and (options.side or options.convex):
            order = np.argsort(self._shard, kind="stable").astype(np.int32)
            ends = np.cumsum(np.bincount(self._shard))
            for roots in np.split(order, ends[:-1]):
                self.tasks.append(self._growth_task(roots))

    @property
    def n_quads(self) -> int:
        return self._mesh.n_quads

    def _basic_task(self, first: int, last: int) -> Task:
        def task() -> Tally:
            census = _census()
            bench = new_bench(self._mesh.n_quads, self._mesh.n_vertices, self._widest)
            total, census = count_basic(
                first, last, self.options.basic, self._kernel, bench, census, self._pulse
            )
            return self._tally((total, 0, 0), census, [])

        return task

    def _growth_task(self, roots: Int32Array) -> Task:
        def task() -> Tally:
            census = _census()
            bench = new_bench(self._mesh.n_quads, self._mesh.n_vertices, self._widest)
            totals = [0, 0, 0]
            far: list[tuple[int, UInt64Array, Int32Array]] = []
            others = np.zeros((4, 2), np.uint64)
            for mode, limit, convex in (
                (1, self.options.side, False),
                (2, self.options.convex, True),
            ):
                if not limit:
                    continue
                totals[mode], others, hashes, values, census = grow(
                    roots,
                    limit,
                    convex,
                    self.options.basic,
                    others,
                    self._shard,
                    self._kernel,
                    bench,
                    census,
                    self._pulse,
                )
                far.append((mode, hashes, values))
            return self._tally((totals[0], totals[1], totals[2]), census, far)

        return task

    def _tally(
        self,
        totals: tuple[int, int, int],
        census: Census,
        far: list[tuple[int, UInt64Array, Int32Array]],
    ) -> Tally:
        """Copy the task's rows out of the thread's census, and clear them there."""
        used = int(census.used[0])
        rows = np.flatnonzero(census.example_size[:used])
        place = np.full(used + 1, -1, np.int32)
        place[rows] = np.arange(len(rows), dtype=np.int32)
        values = np.concatenate([v for _, _, v in far]) if far else np.zeros(0, np.int32)
        result = Tally(
            totals=totals,
            codes=PackedRows(census.codes, census.ends[: used + 1]).take(rows),
            sides=census.sides[rows],
            patches=census.patches[rows],
            example_size=census.example_size[rows],
            example_hash=census.example_hash[rows],
            example=take_stretches(
                census.example, census.example_at[rows], census.example_size[rows]
            ),
            far_mode=np.repeat(
                np.array([m for m, _, _ in far], np.int8), [len(v) for _, _, v in far]
            ),
            far_hash=(
                np.concatenate([h for _, h, _ in far]) if far else np.zeros((0, 2), np.uint64)
            ),
            far_row=np.where(values >= 0, place[values >> 1], -1).astype(np.int32),
            far_mirrored=(values & 1).astype(np.int8),
        )
        reset_counts(census)
        _keep_census(census)
        return result

    def finish(self, tallies: Sequence[Tally]) -> Learned:
        """Put the tasks' results together."""
        all_of_it = merge_tallies(tallies)
        patches = all_of_it.patches.copy()
        side, convex = _count_far(all_of_it, patches)
        assert patches.sum(axis=1).all(), "a pattern was met but in no patch that counts"
        faces = self._faces[self._mesh.source_quad]
        examples = PackedRows(*pack_faces(all_of_it.example, all_of_it.example_size, faces))
        basic, near_side, near_convex = all_of_it.totals
        everything = Learned(
            quads_read=self.quads_read,
            quads_used=self._mesh.n_quads,
            basic=basic,
            side=near_side + side,
            convex=near_convex + convex,
            distinct=int(patches.sum()),
            codes=all_of_it.codes,
            sides=all_of_it.sides,
            patches=patches,
            examples=examples,
        )
        return keep_commonest(everything, self.options.most_patterns)


def keep_commonest(learned: Learned, most: int) -> Learned:
    """Keep of what a mesh teaches the ``most`` patterns that most of its patches have; 0: all.

    Of patterns with as many patches those of smaller ids stay, which are hashes: so it is the same
    however the mesh was cut, and no number of sides is preferred.
    """
    n = len(learned.codes)
    if not most or n <= most:
        return learned
    ids = pattern_ids(learned.codes, learned.sides)
    # The top byte of an id is the number of sides.
    hashed = ids & ((1 << 56) - 1)
    kept = np.sort(np.lexsort((hashed, -learned.patches.sum(axis=1)))[:most])
    return replace(take_patterns(learned, kept), left_out=n - most)


def merge_tallies(tallies: Sequence[Tally]) -> Tally:
    """Make one tally of several tasks of a mesh: patterns that several met come once.

    Of their examples the one with the fewest quads stays, then that with the smallest hash.
    """
    if len(tallies) == 1:
        return tallies[0]
    codes = PackedRows.join([t.codes for t in tallies])
    row, n_rows = _number_rows(codes)
    cuts = np.cumsum([0, *(len(t.codes) for t in tallies)])
    where = [row[a:b] for a, b in itertools.pairwise(cuts.tolist())]
    sizes = np.concatenate([np.zeros(0, np.int32), *(t.example_size for t in tallies)])
    hashes = np.concatenate([np.zeros((0, 2), np.uint64), *(t.example_hash for t in tallies)])
    sides = np.concatenate([np.zeros(0, np.int32), *(t.sides for t in tallies)])
    patches = np.zeros((n_rows, 2), np.int64)
    np.add.at(patches, row, np.concatenate([patches[:0], *(t.patches for t in tallies)]))
    # The first of each row is its best.
    order = np.lexsort((hashes[:, 1], hashes[:, 0], sizes, row))
    best = order[np.searchsorted(row[order], np.arange(n_rows))]
    quads = np.concatenate([np.zeros(0, np.int32), *(t.example for t in tallies)])
    ends = np.cumsum(sizes, dtype=np.int64)
    totals = np.sum([(0, 0, 0), *(t.totals for t in tallies)], axis=0).tolist()
    return Tally(
        totals=(totals[0], totals[1], totals[2]),
        codes=codes.take(best),
        sides=sides[best],
        patches=patches,
        example_size=sizes[best],
        example_hash=hashes[best],
        example=take_stretches(quads, ends[best] - sizes[best], sizes[best]),
        far_mode=np.concatenate([np.zeros(0, np.int8), *(t.far_mode for t in tallies)]),
        far_hash=np.concatenate([np.zeros((0, 2), np.uint64), *(t.far_hash for t in tallies)]),
        far_row=np.concatenate(
            [
                np.zeros(0, np.int32),
                *(
                    # A place more, for patches that no row counts.
                    np.append(w, -1)[t.far_row].astype(np.int32)
                    for t, w in zip(tallies, where, strict=True)
                ),
            ]
        ),
        far_mirrored=np.concatenate([np.zeros(0, np.int8), *(t.far_mirrored for t in tallies)]),
    )


def _number_rows(rows: PackedRows) -> tuple[NDArray[np.int64], int]:
    """Number rows from 0 on as they first come, equal ones alike; and how many differ.

    Rows are equal where their hashes are, as in the census.
    """
    n = len(rows)
    hashes = hash_rows(rows.raw, rows.ends)
    order = np.lexsort((hashes[:, 1], hashes[:, 0]))
    new = np.ones(n, np.bool_)
    new[1:] = (hashes[order[1:]] != hashes[order[:-1]]).any(axis=1)
    group = np.empty(n, np.int64)
    group[order] = np.cumsum(new) - 1
    # The sort is stable: the first of a group came first of all.
    first = order[new]
    number = np.empty(len(first), np.int64)
    number[np.argsort(first)] = np.arange(len(first))
    return number[group], len(first)


def _count_far(tally: Tally, patches: NDArray[np.int64]) -> tuple[int, int]:
    """Count the patches that reach into several shards, each once; return the totals of
    the side and of the convex mode."""
    # By hash, and patches that the census knows before those that it does not count.
    order = np.lexsort((-tally.far_row, tally.far_hash[:, 1], tally.far_hash[:, 0]))
    if not len(order):
        return 0, 0
    hashes, mode = tally.far_hash[order], tally.far_mode[order]
    row, mirrored = tally.far_row[order], tally.far_mirrored[order]
    new = np.r_[True, (hashes[1:] != hashes[:-1]).any(axis=1)]
    group = np.cumsum(new) - 1
    counted = new & (row >= 0)
    np.add.at(patches, (row[counted], mirrored[counted].astype(np.int64)), 1)
    side, convex = (len(np.unique(group[mode == m])) for m in (1, 2))
    return side, convex


_local = threading.local()


def _census() -> Census:
    """This thread's census: codes once read need not be worked out again for the next mesh.

    It is handed out, and put back by _keep_census: a task that is broken off takes it along.
    """
    held: Census | None = getattr(_local, "census", None)
    _local.census = None
    return new_census() if held is None else held


def _keep_census(census: Census) -> None:
    # One that has grown large is given up: what it remembers is worked out again, and millions
    # of patterns in one database do not mean millions in the memory of every thread.
    if sum(array.nbytes for array in census) <= LARGEST_CENSUS:
        _local.census = census


def learn(
    quads: Int32Array,
    options: LearningOptions | None = None,
    *,
    faces: NDArray[np.int64] | None = None,
    shard_quads: int = 1 << 30,
) -> Learned:
    """What one mesh, given by its (q, 4) quads, teaches; on one core."""
    learning = MeshLearning(
        quads,
        np.arange(len(quads)) if faces is None else faces,
        options or LearningOptions(),
        shard_quads=shard_quads,
        pulse=np.zeros(2, np.int64),
    )
    return learning.finish([task() for task in learning.tasks])
