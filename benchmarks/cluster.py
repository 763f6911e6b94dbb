"""Learning on a cluster beside learning on threads: the same hash, time, bytes, and workers killed.

    python benchmarks/cluster.py ../shared/data/meshes --kills 20
    python benchmarks/cluster.py ../shared/data/meshes --every 8 --limits 5,8,16 --kills 20

Starts a scheduler and worker processes on this machine, as docs/cluster.md does on three, and
learns the meshes of the folder: on threads, on clusters of so many workers, and with workers killed
(SIGKILL) at random moments, up to three in a run. Every database must have the content hash of the
threads'. Bytes are those of quads that leave this process and of columns that come back, without
what Dask adds. Prints Markdown; ends with code 1 if a hash differs.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from ingest import cluster, ingest
from patterndb.store import Database, LearningOptions

engines: list[cluster.ClusterEngine] = []


class CountedEngine(cluster.ClusterEngine):
    """An engine whose counts of bytes can be asked afterwards."""

    def __init__(self, scheduler: str) -> None:
        super().__init__(scheduler)
        engines.append(self)


def start(stack: ExitStack, *arguments: str) -> subprocess.Popen[bytes]:
    """Start a part of Dask, which ends with the stack."""
    process = subprocess.Popen(
        [sys.executable, "-m", "dask", *arguments],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    stack.callback(process.wait)
    stack.callback(process.terminate)
    return process


def start_cluster(stack: ExitStack, workers: int, folder: Path) -> str:
    """Start a scheduler and workers of one thread each; return its address."""
    where = folder / f"scheduler-{workers}.json"
    told = ("--scheduler-file", str(where))
    start(stack, "scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", *told)
    while not (where.exists() and where.stat().st_size):
        time.sleep(0.05)
    start(stack, "worker", "--nworkers", str(workers), "--nthreads", "1", "--no-dashboard", *told)
    address: str = json.loads(where.read_text())["address"]
    from distributed import Client

    with Client(address, set_as_default=False) as client:
        client.wait_for_workers(workers)
    return address


def learn_best(
    files: list[Path], options: LearningOptions, folder: Path, **how: Any
) -> tuple[str, float]:
    """Learn the meshes twice, the first time of which loads modules; return the
    hash, and the seconds of the faster run."""
    runs = [learn(files, options, folder, **how) for _ in range(2)]
    assert runs[0][0] == runs[1][0], "the same meshes gave two hashes"
    return min(runs, key=lambda run: run[1])


def learn(
    files: list[Path], options: LearningOptions, folder: Path, **how: Any
) -> tuple[str, float]:
    """Learn the meshes into a new database; return its hash, and the seconds."""
    path = folder / "learned.db"
    path.unlink(missing_ok=True)
    began = time.perf_counter()
    with Database(path, "create") as database:
        ingest(database, files, options, **how)
        seconds = time.perf_counter() - began
        return database.content_hash(), seconds


#: Workers killed in one run: Dask gives a task up when the fourth dies of it.
MOST_KILLED = 3


class WorkerKiller:
    """Kills a worker of the cluster every few seconds, which its nanny starts again."""

    def __init__(self, address: str, every: float, chance: random.Random) -> None:
        self.address = address
        self.every = every
        self.chance = chance
        self.killed = 0
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._work, daemon=True)

    def __enter__(self) -> WorkerKiller:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()

    def _work(self) -> None:
        from distributed import Client

        with Client(self.address, set_as_default=False) as client:
            while self.killed < MOST_KILLED:
                if self._over.wait(self.chance.uniform(0.5, 1.5) * self.every):
                    return
                pids: Any = client.run(os.getpid, on_error="return")
                alive = [pid for pid in pids.values() if isinstance(pid, int)]
                if alive:
                    os.kill(self.chance.choice(alive), signal.SIGKILL)
                    self.killed += 1


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("meshes", type=Path, help="a folder of OBJ files")
    parser.add_argument("--every", type=int, default=1, help="take every so many-th mesh")
    parser.add_argument("--limits", default="7,12,40", help="basic,side,convex")
    parser.add_argument("--workers", default="1,2,8", help="clusters of so many workers")
    parser.add_argument("--kills", type=int, default=0, help="runs with workers killed")
    parser.add_argument("--between", type=float, default=3.0, help="seconds between kills")
    parser.add_argument("--seed", type=int, default=7)
    given = parser.parse_args()
    cluster.ClusterEngine = CountedEngine  # type: ignore[misc]
    files = sorted(given.meshes.glob("*.obj"))[:: given.every]
    options = LearningOptions(*map(int, given.limits.split(",")))
    chance = random.Random(given.seed)
    bad = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        expected, by_threads = learn_best(files, options, folder, jobs=2)
        print(f"{len(files)} meshes of {sum(f.stat().st_size for f in files) / 1e6:.1f} MB")
        print("| | seconds | of threads | MB sent | MB back | hash |")
        print("| --- | ---: | ---: | ---: | ---: | --- |")
        print(f"| 2 threads | {by_threads:.1f} | 1.00 | | | {expected[:8]} |", flush=True)
        for workers in map(int, given.workers.split(",")):
            with ExitStack() as stack:
                address = start_cluster(stack, workers, folder)
                found, seconds = learn_best(files, options, folder, scheduler=address)
                bad += found != expected
                sent, back = engines[-1].bytes_sent / 1e6, engines[-1].bytes_received / 1e6
                print(
                    f"| {workers} workers | {seconds:.1f} | {seconds / by_threads:.2f} | "
                    f"{sent:.1f} | {back:.1f} | {found[:8]} |",
                    flush=True,
                )
        killed = differ = runs = 0
        for _ in range(given.kills):
            with ExitStack() as stack:
                address = start_cluster(stack, 2, folder)
                with WorkerKiller(address, given.between, chance) as killer:
                    found, _ = learn(files, options, folder, scheduler=address)
            runs += 1
            killed += killer.killed
            differ += found != expected
        if runs:
            print(f"\n{runs} runs on 2 workers, {killed} killed: {differ} hashes differ")
        bad += differ
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
