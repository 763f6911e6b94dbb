"""What thousands of meshes would cost, from a database of some dozens: slopes, and where they lead.

    patterndb ingest ../shared/data/meshes --db all.db
    python benchmarks/scaling.py all.db --cpu-seconds 292

Measures, with the meshes of the database in random order: how many patterns are known after so
many meshes, and the exponent of that growth; how fast one writer takes what meshes teach, in the
first and the last third, and how the file grows; how many bytes of quads travel to workers and of
columns come back. --cpu-seconds is what learning them took, in seconds of one core
(benchmarks/learn.py has wall seconds and threads). Then prints what more meshes would cost: that
they are like these is an assumption, and the exponent one that is less sure the further it leads.
"""

from __future__ import annotations

import argparse
import random
import sqlite3
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ingest.clustertasks import to_columns
from patterndb.store import Database, Learned, LearningOptions, Mesh, Provenance

#: Bytes of a quad on its way to a worker: four numbers of 32 bits.
QUAD_BYTES = 16
HOUR = 3600.0


@dataclass(frozen=True, slots=True)
class Taught:
    """What a mesh taught, and the ids of its patterns."""

    mesh: Mesh
    learned: Learned
    ids: list[int]


def read_taught(path: Path) -> list[Taught]:
    """What every mesh of a database taught."""
    with Database(path) as database:
        meshes = {mesh.sha256: mesh for mesh in database.meshes()}
    connection = sqlite3.connect(f"file:{path}?mode=ro", uri=True)
    found: list[Taught] = []
    numbers = connection.execute("SELECT id, lower(hex(sha256)) FROM mesh").fetchall()
    for number, sha256 in numbers:
        rows = connection.execute(
            "SELECT pattern_id, code, n_sides, patches - mirrored_patches, mirrored_patches, "
            "example FROM occurrence JOIN pattern ON pattern.id = pattern_id WHERE mesh_id = ?",
            (number,),
        ).fetchall()
        mesh = meshes[sha256]
        learned = Learned(
            quads_read=mesh.quads_read,
            quads_used=mesh.quads_used,
            basic=mesh.basic,
            side=mesh.side,
            convex=mesh.convex,
            distinct=mesh.distinct,
            codes=[row[1] for row in rows],
            sides=np.array([row[2] for row in rows], np.int32),
            patches=np.array([row[3:5] for row in rows], np.int64).reshape(-1, 2),
            examples=[row[5] for row in rows],
        )
        found.append(Taught(mesh, learned, [row[0] for row in rows]))
    connection.close()
    return found


def measure_growth(taught: list[Taught], orders: int, seed: int) -> tuple[dict[int, float], float]:
    """Patterns known after so many meshes, mean over random orders, and the exponent of the growth
    from half of the meshes to all of them."""
    steps = sorted({max(1, len(taught) * part // 8) for part in (1, 2, 4, 8)})
    known: dict[int, list[int]] = {step: [] for step in steps}
    chance = random.Random(seed)
    for _ in range(orders):
        seen: set[int] = set()
        for count, one in enumerate(chance.sample(taught, len(taught)), 1):
            seen.update(one.ids)
            if count in known:
                known[count].append(len(seen))
    mean = {step: float(np.mean(counts)) for step, counts in known.items()}
    half, whole = steps[-2], steps[-1]
    return mean, float(np.log(mean[whole] / mean[half]) / np.log(whole / half))


def measure_writer(taught: list[Taught], seed: int) -> list[tuple[int, int, float, int]]:
    """(new patterns, occurrences, seconds, bytes by which the file grew) of every mesh written."""
    taken: list[tuple[int, int, float, int]] = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "written.db"
        with Database(path, "create") as database:
            for one in random.Random(seed).sample(taught, len(taught)):
                before = path.stat().st_size
                began = time.perf_counter()
                new = database.add_mesh(
                    one.mesh.name, one.mesh.sha256, Provenance(), LearningOptions(), one.learned
                )
                seconds = time.perf_counter() - began
                taken.append((new, len(one.ids), seconds, path.stat().st_size - before))
    return taken


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("database", type=Path)
    parser.add_argument("--cpu-seconds", type=float, required=True, help="of learning all of it")
    parser.add_argument("--orders", type=int, default=10)
    parser.add_argument("--seed", type=int, default=7)
    given = parser.parse_args()
    taught = read_taught(given.database)
    n = len(taught)
    mean, exponent = measure_growth(taught, given.orders, given.seed)
    taken = measure_writer(taught, given.seed)
    new, rows, seconds, grown = (
        np.array(column, np.float64) for column in zip(*taken, strict=True)
    )
    patterns, occurrences = float(new.sum()), float(rows.sum())
    sent = QUAD_BYTES * sum(one.mesh.quads_read for one in taught)
    back = sum(
        sum(v.nbytes for v in to_columns(one.learned).values() if isinstance(v, np.ndarray))
        for one in taught
    )
    print(f"{n} meshes, {patterns:,.0f} patterns, {occurrences:,.0f} occurrences")
    print("known after " + ", ".join(f"{k} meshes: {v:,.0f}" for k, v in mean.items()))
    print(f"exponent {exponent:.2f}")
    third = n // 3
    for name, part in (("first third", slice(0, third)), ("last third", slice(n - third, n))):
        print(
            f"writer, {name}: {rows[part].sum() / seconds[part].sum():,.0f} occurrences a second, "
            f"{new[part].sum() / seconds[part].sum():,.0f} of them with a new pattern"
        )
    print(f"bytes: {sent / n:,.0f} a mesh to workers, {back / n:,.0f} back")
    # A new pattern costs more than another occurrence of a known one: both by least squares.
    counts = np.column_stack([new, rows])
    time_new, time_row = np.maximum(np.linalg.lstsq(counts, seconds, rcond=None)[0], 0.0)
    disk_new, disk_row = np.maximum(np.linalg.lstsq(counts, grown, rcond=None)[0], 0.0)
    print(
        f"by least squares: a new pattern {1e6 * time_new:.1f} us and {disk_new:.0f} bytes, "
        f"an occurrence {1e6 * time_row:.1f} us and {disk_row:.0f} bytes"
    )
    heads = ("meshes", "patterns", "CPU hours", "GB to workers", "GB back", "writer hours", "GB")
    print(f"\n| {' | '.join(heads)} on disk |")
    print("| ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
    for count in (1_000, 10_000, 100_000):
        much = count / n
        known = patterns * much**exponent
        met = occurrences * much
        writing = time_new * known + time_row * met
        disk = disk_new * known + disk_row * met
        print(
            f"| {count:,} | {known:,.0f} | {given.cpu_seconds * much / HOUR:,.0f} | "
            f"{sent * much / 1e9:,.1f} | {back * much / 1e9:,.1f} | {writing / HOUR:,.1f} | "
            f"{disk / 1e9:,.1f} |"
        )


if __name__ == "__main__":
    main()
