"""Learn millions of patterns of a folder of meshes, none with too large a share of them.

    python benchmarks/five_million.py ../shared/data/meshes --db deep.db

From the smallest on, meshes are learned with a larger limit of the basic mode, until there are as
many patterns as asked for; then the others at the default limits. The basic mode takes no memory
for the patches that it met, and in a mesh of few quads each is near an irregular vertex: such
meshes teach most patterns a second. One whose small patches have the patterns of another's repeats
it (a suit in another cut, a body in another pose): it gets the default limits. No mesh keeps
more patterns than its share of those asked for. What was learned when time is up stays in the
database: the same command goes on from there. Tells of every mesh as it is done, and at the end
Markdown for RESULTS.md.
"""

from __future__ import annotations

import argparse
import os
import resource
import sys
import time
from pathlib import Path

from learn import PAPER

from ingest import MeshReport, Progress, ingest, read_mesh
from ingest.learning import learn
from ingest.prepare import prepare
from patterndb.core.quadmesh import QuadMesh
from patterndb.store import Database, LearningOptions

#: Meshes that are learned together: enough that no thread waits for long at the end.
TOGETHER = 8

#: Quads of the patches by which a mesh is known to repeat another, and the part of the patterns of
#: both that must be of both.
SMALL, SAME = 8, 0.9


class Log:
    """What was learned so far, told mesh by mesh; ends the run when time is up."""

    def __init__(self, held: int, wanted: int, minutes: float) -> None:
        self.total = held
        self.wanted = wanted
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

    def tell(self, mesh: MeshReport) -> None:
        """Write a line of a mesh that is done."""
        self.total += mesh.new_patterns
        print(
            f"{self.seconds:6.0f} s, CPU {time.process_time():6.0f} s, "
            f"{measure_memory():5.0f} MB: {mesh.name} {mesh.outcome}, {mesh.quads_used} quads, "
            f"{mesh.distinct:,} patches, {mesh.patterns:,} patterns, {mesh.left_out:,} left out, "
            f"{mesh.new_patterns:,} new to what was there; {self.total:,} or fewer in all",
            file=sys.stderr,
            flush=True,
        )


def measure_memory() -> float:
    """The most memory that this process had so far, in megabytes."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def count_quads(path: Path) -> int:
    """The quads of a mesh once it is prepared."""
    return prepare(QuadMesh.from_quads(read_mesh(path).quads()[0])).n_quads


def find_small_patterns(path: Path) -> set[bytes]:
    """The patterns of a mesh's smallest patches."""
    small = LearningOptions(basic=SMALL, side=0, convex=0)
    return set(learn(read_mesh(path).quads()[0], small).codes)


class Repetition:
    """Which meshes repeat another: their smallest patches have the same patterns."""

    def __init__(self, learned: list[Path]) -> None:
        self._known = [find_small_patterns(path) for path in learned]

    def take_new(self, path: Path) -> bool:
        """Is a mesh unlike all so far? It is among those from then on."""
        small = find_small_patterns(path)
        alike = any(len(small & one) >= SAME * len(small | one) for one in self._known)
        self._known.append(small)
        return not alike


def count_patterns(database: Database) -> int:
    """Count the patterns of a database."""
    return sum(database.sides_histogram().values())


def learn_together(
    database: Database, paths: list[Path], options: LearningOptions, jobs: int, log: Log
) -> None:
    """Learn some meshes, and tell of each."""
    ingest(database, paths, options, jobs=jobs, progress=log.stop_late, report=log.tell)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--db", type=Path, required=True, help="the database, made or gone on with")
    parser.add_argument("--patterns", type=int, default=5_000_000)
    parser.add_argument("--share", type=float, default=0.15, help="of one mesh, at most")
    parser.add_argument("--basic", type=int, default=12, help="the larger limit of the basic mode")
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    given = parser.parse_args()
    most = int(given.share * given.patterns)
    plain = LearningOptions(most_patterns=most)
    deep = LearningOptions(basic=given.basic, most_patterns=most)
    with Database(given.db, "create") as database:
        before = count_patterns(database)
        log = Log(before, given.patterns, given.minutes)
        paths = sorted(given.folder.glob("*.obj"), key=count_quads)
        held = {mesh.name for mesh in database.meshes() if mesh.options == deep}
        fresh = [path for path in paths if path.name not in held]
        repetition = Repetition([path for path in paths if path.name in held])
        while fresh and not log.is_over and log.total < log.wanted:
            taken: list[Path] = []
            while fresh and len(taken) < TOGETHER:
                path = fresh.pop(0)
                if repetition.take_new(path):
                    taken.append(path)
                else:
                    print(f"{log.seconds:6.0f} s: {path.name} repeats another", file=sys.stderr)
            learn_together(database, taken, deep, given.jobs, log)
            # What was replaced took patterns with it.
            log.total = count_patterns(database)
        learned = {mesh.name for mesh in database.meshes()}
        rest = [path for path in paths if path.name not in learned]
        if rest and not log.is_over:
            learn_together(database, rest, plain, given.jobs, log)
        by_sides = database.sides_histogram()
        meshes = database.meshes()
    size = given.db.stat().st_size
    total = sum(by_sides.values())
    largest = max(meshes, key=lambda mesh: mesh.patterns)
    n_deep = sum(mesh.options.basic == given.basic for mesh in meshes)
    print(
        f"{total:,} patterns of {len(meshes)} meshes, {n_deep} of them at {given.basic} quads of "
        f"the basic mode, {total - before:,} patterns in this run of {log.seconds / 60:.1f} "
        f"minutes ({time.process_time() / 60:.1f} of processor), {given.jobs} threads; peak memory "
        f"{measure_memory():,.0f} MB; {size / 1e6:,.0f} MB on disk, {size / max(total, 1):.0f} "
        f"bytes a pattern; most of one mesh: {largest.patterns:,} ({largest.name}, "
        f"{largest.patterns / max(total, 1):.1%}), {sum(bool(m.left_out) for m in meshes)} cut\n"
    )
    print("| corners | patterns | paper |\n| ---: | ---: | ---: |")
    for n in range(max(len(PAPER), 1 + max(by_sides, default=0))):
        paper = f"{PAPER[n]:,}" if n < len(PAPER) else ""
        print(f"| {n} | {by_sides.get(n, 0):,} | {paper} |")
    print(f"| all | {total:,} | {sum(PAPER):,} |")


if __name__ == "__main__":
    main()
