"""The service under load: requests a second, waiting, refusals, memory; and hostile cases.

    python benchmarks/service_load.py load [--clients 1,10,50,200] [--seconds 10] [--workers 1]
    python benchmarks/service_load.py closes [--streams 10000] [--rounds 1]
    python benchmarks/service_load.py cases [--cases 10000]

Each starts ``patterndb serve`` on the starter database, on a free port of this machine, and asks
it from one process. load: clients that each ask one question after another, fills of a random
boundary, streamed; a 429 is counted, and its client waits a moment. closes: streams of long lists
that are closed at random moments; then nothing may be at work, and no memory be grown. cases: what
schemathesis makes of the interface's description, right and wrong, every answer held to it.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import json
import random
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]

#: Fills that a question asks for.
LIMIT = 20

#: A list that is long enough to be closed in its midst.
LONG = {"sides": [20, 20, 20, 20, 20, 20], "limit": 1000}

#: Streams that are open at the same time while they are closed at random.
TOGETHER = 8

#: Seconds that a client waits after a 429, of the one second that it is told: so that there is
#: always one more.
WAIT_SECONDS = 0.2


class Served:
    """A service in a process of its own."""

    def __init__(self, workers: int) -> None:
        words = [sys.executable, "-m", "patterndb", "serve", "--port", "0"]
        self.process = subprocess.Popen(
            [*words, "--workers", str(workers)], stderr=subprocess.PIPE, text=True, cwd=ROOT
        )
        assert self.process.stderr is not None
        self.port = int(self.process.stderr.readline().split(":")[2].split("/")[0])
        # The log goes on, and nobody shall wait for who reads it.
        drain = [sys.executable, "-c", "import sys\nfor line in sys.stdin: pass"]
        self._drain = subprocess.Popen(drain, stdin=self.process.stderr)
        while self._is_cold():
            time.sleep(0.2)

    def _is_cold(self) -> bool:
        try:
            return self.ask("/v1/health")["status"] != "ok"
        except OSError:
            return True

    def is_busy(self) -> bool:
        """Is anything at work? More connections than may be open are, too."""
        try:
            return bool(self.ask("/v1/health")["at_work"])
        except urllib.error.HTTPError as error:
            if error.code != 503:
                raise
            return True

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    def ask(self, path: str) -> dict[str, object]:
        with urllib.request.urlopen(self.url + path, timeout=30) as answer:
            return json.load(answer)

    def read_memory(self) -> float:
        """MB of the process and those that it started."""
        total = 0
        for folder in Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError, ValueError, IndexError):
                stat = (folder / "stat").read_text().rpartition(")")[2].split()
                if int(folder.name) == self.process.pid or int(stat[1]) == self.process.pid:
                    total += int((folder / "statm").read_text().split()[1]) * 4096
        return total / 1e6

    def stop(self) -> None:
        self.process.terminate()
        self.process.wait(30)
        self._drain.wait(30)


@contextlib.contextmanager
def served(workers: int = 1) -> Iterator[Served]:
    running = Served(workers)
    try:
        yield running
    finally:
        running.stop()


def make_boundary(rng: random.Random) -> dict[str, object]:
    """A boundary as people draw them: four to six sides of two to eight edges, an even sum."""
    sides = [rng.randint(2, 8) for _ in range(rng.choice((4, 4, 4, 5, 5, 6)))]
    sides[0] += sum(sides) % 2
    return {"sides": sides, "limit": LIMIT}


def format_request(body: dict[str, object]) -> bytes:
    data = json.dumps(body).encode()
    return (
        b"POST /v1/fills HTTP/1.1\r\nHost: localhost\r\nAccept: application/x-ndjson\r\n"
        b"Content-Type: application/json\r\nContent-Length: %d\r\n\r\n%b" % (len(data), data)
    )


async def ask(
    reader: asyncio.StreamReader, writer: asyncio.StreamWriter, body: dict[str, object]
) -> tuple[int, float, float, bool]:
    """Ask over a connection that is kept: status, seconds to the first line and to the last, and
    whether all came."""
    began = time.perf_counter()
    writer.write(format_request(body))
    head = await reader.readuntil(b"\r\n\r\n")
    status = int(head.split(b" ", 2)[1])
    if b"transfer-encoding: chunked" not in head.lower():
        length = int(head.lower().partition(b"content-length: ")[2].split(b"\r\n")[0])
        await reader.readexactly(length)
        took = time.perf_counter() - began
        return status, took, took, True
    first, last = 0.0, b""
    while True:
        size = int(await reader.readline(), 16)
        chunk = await reader.readexactly(size + 2)
        first = first or time.perf_counter() - began
        if not size:
            break
        last = (last + chunk[:-2])[-400:]
    whole = json.loads(last.strip().rpartition(b"\n")[2]).get("done", False)
    return status, first, time.perf_counter() - began, whole


async def run_clients(port: int, clients: int, seconds: float, seed: int) -> None:
    """Have clients ask one question after another, and print what came of it."""
    firsts: list[float] = []
    totals: list[float] = []
    statuses: Counter[int] = Counter()
    lost = 0
    until = time.perf_counter() + seconds

    async def client(number: int) -> None:
        nonlocal lost
        rng = random.Random(seed * 1000 + number)
        reader, writer = await asyncio.open_connection("127.0.0.1", port, limit=2**24)
        while time.perf_counter() < until:
            try:
                status, first, total, whole = await ask(reader, writer, make_boundary(rng))
            except (OSError, ValueError, asyncio.IncompleteReadError):
                lost += 1
                reader, writer = await asyncio.open_connection("127.0.0.1", port, limit=2**24)
                continue
            statuses[status] += 1
            lost += not whole
            if status == 200:
                firsts.append(first)
                totals.append(total)
            else:
                await asyncio.sleep(WAIT_SECONDS)
        writer.close()

    began = time.perf_counter()
    await asyncio.gather(*(client(number) for number in range(clients)))
    took = time.perf_counter() - began
    cuts = [np.percentile(values, (50, 95, 99)) * 1000 for values in (firsts, totals)]
    told = " | ".join(f"{value:.0f}" for cut in cuts for value in cut)
    print(
        f"| {clients} | {len(totals) / took:.0f} | {told} | {statuses[200]} | {statuses[429]} | "
        f"{sum(statuses.values()) - statuses[200] - statuses[429]} | {lost} |",
        flush=True,
    )


def measure_load(clients: list[int], seconds: float, workers: int, seed: int) -> None:
    with served(workers) as running:
        before = running.read_memory()
        asyncio.run(run_clients(running.port, 2, 3.0, seed))  # what was never asked is loaded
        print("(that was to warm it)")
        print(
            "| clients | requests/s | first line p50 ms | p95 | p99 | whole p50 ms | p95 | p99 | "
            "200 | 429 | others | lost |"
        )
        for count in clients:
            asyncio.run(run_clients(running.port, count, seconds, seed + count))
        print(f"memory: {before:.0f} MB at the start, {running.read_memory():.0f} MB at the end")


async def close_streams(port: int, streams: int, seed: int) -> None:
    """Open streams of long lists, and close each at a random moment."""
    rng = random.Random(seed)
    left = iter(range(streams))

    async def client() -> None:
        for _ in left:
            reader, writer = await asyncio.open_connection("127.0.0.1", port, limit=2**24)
            writer.write(format_request(LONG))
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(rng.choice((0.0, 0.005, 0.02, 0.1)) * rng.random()):
                    while await reader.read(65536):
                        pass
            writer.close()

    await asyncio.gather(*(client() for _ in range(TOGETHER)))


def measure_closes(streams: int, rounds: int, seed: int) -> None:
    with served() as running:
        asyncio.run(close_streams(running.port, 200, seed))
        wait_idle(running)
        before = running.read_memory()
        began = time.perf_counter()
        asyncio.run(close_streams(running.port, streams, seed + 1))
        ended = time.perf_counter()
        idle = wait_idle(running)
        print(
            f"{streams:,} streams closed at random in {ended - began:.1f} s; {idle * 1000:.0f} ms "
            f"after the last nothing was at work; memory {before:.0f} MB before, "
            f"{running.read_memory():.0f} MB after"
        )
        for number in range(1, rounds):
            asyncio.run(close_streams(running.port, streams, seed + 1 + number))
            wait_idle(running)
            print(f"  after as many again: {running.read_memory():.0f} MB", flush=True)
        print("how long a search goes on after its client has gone, one stream at a time:")
        waits: list[float] = []
        for number in range(50):
            asyncio.run(close_one(running.port, seed + number))
            waits.append(wait_idle(running) * 1000)
        print(f"  median {np.median(waits):.0f} ms, longest {max(waits):.0f} ms, 50 streams")


async def close_one(port: int, seed: int) -> None:
    reader, writer = await asyncio.open_connection("127.0.0.1", port, limit=2**24)
    writer.write(format_request(LONG))
    await reader.readuntil(b"\r\n\r\n")
    await asyncio.sleep(random.Random(seed).random() * 0.2)
    writer.close()


def wait_idle(running: Served) -> float:
    """Wait until nothing is at work; return the seconds."""
    began = time.perf_counter()
    while running.is_busy():
        if time.perf_counter() - began > 60:
            raise RuntimeError("a search is still running a minute after its client has gone")
    return time.perf_counter() - began


def measure_cases(cases: int, seed: int) -> None:
    sys.path.insert(0, str(ROOT))
    from tests.support.service.hostilecases import ask_cases

    with served() as running:
        described = running.ask("/openapi.json")
        operations = sum(len(methods) for methods in described["paths"].values())  # type: ignore
        before = running.read_memory()
        asked, failures = ask_cases(described, running.url, cases // operations, seed)
        print(
            f"{asked:,} cases of {operations} operations, seed {seed}: {len(failures)} answers "
            f"not as described; memory {before:.0f} MB before, {running.read_memory():.0f} MB after"
        )
        for failure in failures[:10]:
            print(failure)
        if failures:
            sys.exit(1)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("what", choices=("load", "closes", "cases"))
    parser.add_argument("--clients", default="1,10,50,200")
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--streams", type=int, default=10_000)
    parser.add_argument("--rounds", type=int, default=1, help="of closes, to see memory level off")
    parser.add_argument("--cases", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    if given.what == "load":
        counts = [int(count) for count in given.clients.split(",")]
        measure_load(counts, given.seconds, given.workers, given.seed)
    elif given.what == "closes":
        measure_closes(given.streams, given.rounds, given.seed)
    else:
        measure_cases(given.cases, given.seed)


if __name__ == "__main__":
    main()
