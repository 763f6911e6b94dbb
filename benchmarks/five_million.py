"""Learn millions of patterns of a folder of meshes, none with too large a share of them.

    python benchmarks/five_million.py ../shared/data/meshes --db deep.db

Every mesh is learned at the default limits at least; some with a larger limit of the side mode,
which teaches most patterns a second and the most that have few sides. A pilot tells which: it
learns the side mode at some small limits, from whose growth follow patterns and patches at larger
ones. A mesh gets the largest limit at which neither are more than its share; then those that teach
most new patterns a second are taken, until there are as many as asked for. Meshes whose small
patterns are mostly those of meshes that were taken (a suit in another cut, a body in another pose)
keep the default limits: so most patterns stand in one mesh or two. When what was taken brings less
than was told, the next ones are. What was learned when time is up stays in the database: the same
command goes on from there. Tells of every mesh as it is done, and at the end Markdown for
RESULTS.md.
"""

from __future__ import annotations

import argparse
import itertools
import os
import resource
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from learn import PAPER
from numpy.typing import NDArray

from ingest import MeshReport, Progress, ingest, read_mesh
from ingest.engines import SHARD_QUADS
from ingest.learning import learn
from patterndb.core.code import pattern_ids
from patterndb.store import Database, LearningOptions

#: Limits of the side mode that the pilot tries, one after the other while they are worth it.
PILOT = (10, 12, 14)

#: The largest limit of the side mode: further than this the growth at small ones says little.
FURTHEST = 23

#: What the factor by which patterns grow is multiplied with at least from one limit to the next,
#: and the power to which that comes each time: growth slows down ever less. Both fit what five
#: meshes had at limits of 16 and 18.
SLOWEST, EASING = 0.9, 0.85

#: A mesh is left at the default limits where the pilot finds fewer patterns, or has to look at more
#: patches for each.
FEWEST, DEAREST = 100, 150

#: A mesh repeats others when fewer of its small patterns are new.
LEAST_NEW = 0.1

#: Patches that one task may have to remember, by the pilot: they take 26 to 51 bytes each.
MOST_PATCHES = 20_000_000

#: CPU seconds to write a pattern of a mesh, beside those to find it.
WRITE_SECONDS = 35e-6

#: How much of what the pilot tells a mesh brings, once what others have and what the growth slows
#: down to is taken off: with more, more meshes are taken at once.
KEPT = 0.8

PLAIN = LearningOptions()


class Log:
    """What was learned so far, told mesh by mesh; ends the run when time is up."""

    def __init__(self, minutes: float) -> None:
        self._begun = time.perf_counter()
        self._ends = self._begun + 60 * minutes

    @property
    def seconds(self) -> float:
        return time.perf_counter() - self._begun

    @property
    def is_over(self) -> bool:
        return time.perf_counter() >= self._ends

    def stop_late(self, _: Progress) -> None:
        """Break off what is in work when time is up, as Ctrl-C does."""
        if self.is_over:
            raise KeyboardInterrupt

    def tell(self, text: str) -> None:
        """Write a line with the time, that of the processor, and the memory."""
        print(
            f"{self.seconds:6.0f} s, CPU {time.process_time():6.0f} s, "
            f"{measure_memory():5.0f} MB: {text}",
            file=sys.stderr,
            flush=True,
        )

    def tell_mesh(self, mesh: MeshReport) -> None:
        """Write a line of a mesh that is done."""
        self.tell(
            f"{mesh.name} {mesh.outcome}, {mesh.quads_used} quads, {mesh.distinct:,} patches, "
            f"{mesh.patterns:,} patterns, {mesh.left_out:,} left out, {mesh.new_patterns:,} new to "
            "what was there"
        )


@dataclass(frozen=True, slots=True)
class Prospect:
    """What a larger limit of the side mode would bring.

    small: (k,) ids of the patterns of the pilot's largest limit, ascending. side: the limit.
    patterns, seconds: that it brings and costs, on one thread.
    """

    path: Path
    small: NDArray[np.int64]
    side: int
    patterns: float
    seconds: float


def measure_memory() -> float:
    """The most memory that this process had so far, in megabytes."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def look_ahead(path: Path, most: int) -> Prospect | None:
    """Learn a mesh at the pilot's limits, and choose a larger one that brings at most so many
    patterns; None where that is not worth while."""
    quads = read_mesh(path).quads()[0]
    counts: list[tuple[int, int]] = []
    ids = np.zeros(0, np.int64)
    seconds, n_quads = 0.0, 0
    for side in PILOT:
        began = time.thread_time()
        learned = learn(quads, LearningOptions(basic=0, side=side, convex=0))
        seconds = time.thread_time() - began
        counts.append((len(learned.codes), learned.distinct))
        n_quads = learned.quads_used
        if counts[-1][0] < FEWEST or counts[-1][1] > DEAREST * counts[-1][0]:
            return None
        ids = np.sort(pattern_ids(learned.codes, learned.sides))
    patterns, patches = (Growth.of(column) for column in zip(*counts, strict=True))
    n_tasks = -(-n_quads // SHARD_QUADS)
    side, cost = PILOT[-1], seconds / patches.count
    while side < FURTHEST:
        more, dearer = patterns.go_on(), patches.go_on()
        if more.count > most or dearer.count > MOST_PATCHES * n_tasks:
            break
        side, patterns, patches = side + 1, more, dearer
    return Prospect(path, ids, side, patterns.count, cost * patches.count)


@dataclass(frozen=True, slots=True)
class Growth:
    """A count, by what factor it last grew with a limit larger by one, and by what that factor
    becomes smaller each time."""

    count: float
    factor: float
    slower: float

    @classmethod
    def of(cls, counts: Sequence[int]) -> Growth:
        """Of the counts at the pilot's limits, which are two apart."""
        first, last = ((b / a) ** 0.5 for a, b in itertools.pairwise(counts[-3:]))
        slower = min(1.0, max(SLOWEST, (last / first) ** 0.5))
        # The last factor lies between the last two limits, half a step before the last.
        return cls(counts[-1], last * slower**0.5, slower)

    def go_on(self) -> Growth:
        """At the next limit."""
        factor = self.factor * self.slower
        return Growth(self.count * factor, factor, self.slower**EASING)


class Choice:
    """Takes the prospect that brings most new patterns a second, one after the other."""

    def __init__(self, prospects: list[Prospect]) -> None:
        self._left = prospects
        self._known = np.zeros(0, np.int64)

    def take(self) -> Prospect | None:
        """The next one, and from then on its small patterns are known; None when no other is
        worth while."""
        self._left = [one for one in self._left if self._part_new(one) >= LEAST_NEW]
        if not self._left:
            return None
        best = max(self._left, key=self._rate)
        self._left.remove(best)
        self._known = np.union1d(self._known, best.small)
        return best

    def _part_new(self, one: Prospect) -> float:
        return 1 - np.isin(one.small, self._known, assume_unique=True).mean()

    def _rate(self, one: Prospect) -> float:
        seconds = one.seconds + WRITE_SECONDS * one.patterns
        return self._part_new(one) * one.patterns / seconds


def count_patterns(database: Database) -> int:
    """Count the patterns of a database."""
    return sum(database.sides_histogram().values())


def learn_meshes(
    database: Database,
    paths: list[Path],
    options: Callable[[Path], LearningOptions],
    jobs: int,
    log: Log,
) -> None:
    """Learn some meshes, each with its own limits, and tell of each."""
    ingest(database, paths, options, jobs=jobs, progress=log.stop_late, report=log.tell_mesh)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--db", type=Path, required=True, help="the database, made or gone on with")
    parser.add_argument("--patterns", type=int, default=5_000_000)
    parser.add_argument("--share", type=float, default=0.15, help="of one mesh, at most")
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    given = parser.parse_args()
    most = int(given.share * given.patterns)
    log = Log(given.minutes)
    paths = sorted(given.folder.glob("*.obj"))
    with ThreadPoolExecutor(given.jobs) as pool:
        found = list(pool.map(lambda path: look_ahead(path, most), paths))
    choice = Choice([one for one in found if one is not None])
    log.tell(f"pilot done, {sum(one is not None for one in found)} of {len(paths)} worth more")
    side: dict[Path, int] = {}

    def choose(path: Path) -> LearningOptions:
        return LearningOptions(side=side.get(path, PLAIN.side), most_patterns=most)

    with Database(given.db, "create") as database:
        before = total = count_patterns(database)
        held = {mesh.name: mesh.options.side for mesh in database.meshes()}
        # Those of an earlier run come first, for it chose as this one does.
        while total < given.patterns and not log.is_over:
            taken: list[Path] = []
            expected = float(total)
            while expected < given.patterns and (one := choice.take()):
                side[one.path] = one.side
                taken.append(one.path)
                log.tell(f"{one.path.name} with a side of {one.side}: {one.patterns:,.0f} expected")
                if held.get(one.path.name) != one.side:
                    expected += KEPT * one.patterns
            if not taken:
                break
            learn_meshes(database, taken, choose, given.jobs, log)
            total = count_patterns(database)
        if not log.is_over:
            learn_meshes(database, paths, choose, given.jobs, log)
        by_sides = database.sides_histogram()
        meshes = database.meshes()
    size = given.db.stat().st_size
    total = sum(by_sides.values())
    occurrences = sum(mesh.patterns for mesh in meshes)
    largest = max(meshes, key=lambda mesh: mesh.patterns)
    print(
        f"{total:,} patterns of {len(meshes)} meshes, {len(side)} of them with a larger limit of "
        f"the side mode; {total - before:,} patterns in this run of {log.seconds / 60:.1f} minutes "
        f"({time.process_time() / 60:.1f} of processor), {given.jobs} threads; peak memory "
        f"{measure_memory():,.0f} MB; {size / 1e6:,.0f} MB on disk, {size / max(total, 1):.0f} "
        f"bytes a pattern, each in {occurrences / max(total, 1):.2f} meshes; most of one mesh: "
        f"{largest.patterns:,} ({largest.name}, {largest.patterns / max(total, 1):.1%}), "
        f"{sum(bool(m.left_out) for m in meshes)} cut\n"
    )
    print("| corners | patterns | paper |\n| ---: | ---: | ---: |")
    for n in range(max(len(PAPER), 1 + max(by_sides, default=0))):
        paper = f"{PAPER[n]:,}" if n < len(PAPER) else ""
        print(f"| {n} | {by_sides.get(n, 0):,} | {paper} |")
    print(f"| all | {total:,} | {sum(PAPER):,} |")


if __name__ == "__main__":
    main()
