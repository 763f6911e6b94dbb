"""Learn millions of patterns of a folder of meshes, none with too large a share of them.

    python benchmarks/five_million.py ../shared/data/meshes --db deep.db

Every mesh is learned at the default limits first. Then, again and again, the mesh that last brought
most new patterns a second is learned with a larger limit of the side mode, until there are as many
patterns as asked for or time is up. No mesh is learned deeper from which more than its share of the
patterns asked for must be expected. What was learned stays in the database: the same command goes
on from there. Prints Markdown for RESULTS.md.
"""

from __future__ import annotations

import argparse
import os
import resource
import time
from dataclasses import dataclass
from pathlib import Path

from learn import PAPER

from ingest import ingest
from patterndb.store import Database, LearningOptions, Mesh

#: Limits of the side mode, one after the other; the first are the default limits.
SIDES = (12, 14, 16, 18, 20, 22, 24, 26, 28, 30)

#: By how much the patterns of a mesh grow from one limit to the next, where it is not known yet.
GROWTH = 2.5


@dataclass(slots=True)
class Climb:
    """How deep a mesh was learned, and what that brought.

    level: place in SIDES. patterns: of the mesh. growth: by the last step. rate: patterns new to
    the database, a second of the last step.
    """

    path: Path
    level: int
    patterns: int
    growth: float
    rate: float


def learn(database: Database, climb: Climb, level: int, jobs: int) -> int:
    """Learn a mesh at a level; return how many patterns the database has now.

    What it had learned of the mesh is taken out first, so what the report calls new is not all new.
    """
    before = count(database)
    (report,) = ingest(database, [climb.path], LearningOptions(side=SIDES[level]), jobs=jobs).meshes
    if climb.patterns:
        climb.growth = max(report.patterns / climb.patterns, 1.0)
    climb.level, climb.patterns = level, report.patterns
    total = count(database)
    climb.rate = (total - before) / max(report.seconds, 1e-3)
    return total


def count(database: Database) -> int:
    """Count the patterns of a database."""
    return sum(database.sides_histogram().values())


def start(database: Database, paths: list[Path], jobs: int) -> list[Climb]:
    """Every mesh as the database holds it, or learned at the first level."""
    held: dict[str, Mesh] = {mesh.name: mesh for mesh in database.meshes()}
    climbs: list[Climb] = []
    for path in paths:
        climb = Climb(path, 0, 0, GROWTH, 0.0)
        if path.name in held:
            climb.level = SIDES.index(held[path.name].options.side)
            climb.patterns = held[path.name].patterns
            climb.rate = climb.patterns / max(held[path.name].distinct, 1)
        else:
            learn(database, climb, 0, jobs)
        climbs.append(climb)
    return climbs


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--db", type=Path, required=True, help="the database, made or gone on with")
    parser.add_argument("--patterns", type=int, default=5_000_000)
    parser.add_argument("--share", type=float, default=0.15, help="of one mesh, at most")
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    given = parser.parse_args()
    begun = time.perf_counter()
    paths = sorted(given.folder.glob("*.obj"), key=lambda path: path.stat().st_size)
    with Database(given.db, "create") as database:
        before = count(database)
        climbs = start(database, paths, given.jobs)
        total = count(database)
        most = given.share * given.patterns
        print(f"{total:,} patterns at the first limits, {time.perf_counter() - begun:.0f} s\n")
        print("| s | mesh | side | patterns of it | patterns of all | new a second |")
        print("| ---: | --- | ---: | ---: | ---: | ---: |")
        while total < given.patterns and time.perf_counter() - begun < 60 * given.minutes:
            able = [
                climb
                for climb in climbs
                if climb.level + 1 < len(SIDES) and climb.patterns * climb.growth <= most
            ]
            if not able:
                break
            climb = max(able, key=lambda one: one.rate)
            total = learn(database, climb, climb.level + 1, given.jobs)
            print(
                f"| {time.perf_counter() - begun:.0f} | {climb.path.name} | {SIDES[climb.level]} | "
                f"{climb.patterns:,} | {total:,} | {climb.rate:,.0f} |",
                flush=True,
            )
        seconds = time.perf_counter() - begun
        by_sides = database.sides_histogram()
        total = sum(by_sides.values())
        largest = max(climbs, key=lambda climb: climb.patterns)
    megabytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    size = given.db.stat().st_size
    print(
        f"\n{total:,} patterns of {len(climbs)} meshes, {total - before:,} of them in this run of "
        f"{seconds / 60:.1f} minutes, {given.jobs} threads; peak memory {megabytes:,.0f} MB; "
        f"{size / 1e6:,.0f} MB on disk, {size / total:.0f} bytes a pattern; most of one mesh: "
        f"{largest.patterns:,} ({largest.path.name}, {largest.patterns / total:.1%})\n"
    )
    print("| corners | patterns | paper |\n| ---: | ---: | ---: |")
    for n in range(max(len(PAPER), 1 + max(by_sides))):
        paper = f"{PAPER[n]:,}" if n < len(PAPER) else ""
        print(f"| {n} | {by_sides.get(n, 0):,} | {paper} |")
    print(f"| all | {total:,} | {sum(PAPER):,} |")


if __name__ == "__main__":
    main()
