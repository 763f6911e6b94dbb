"""Ask what is hard, and see that all ends when it should: by a limit, by cancel(), by Ctrl-C.

    python benchmarks/adversarial_queries.py --seconds 2
    python benchmarks/adversarial_queries.py --seconds 2 --commands

Forty questions to the starter database that a search could spend minutes or for ever on: many
strokes, boundaries with reflex corners, CP-SAT as the solver, long sides, many sides, families.
Each is asked in a process of its own, three times: with a time limit, with cancel() called by
another thread, and with SIGINT sent to the process. Written down is how many seconds after the
moment the question had ended, with tables loaded before, and how many seconds
of the processor it took for that: a machine that has other work to do ends everything late.

With --commands, the commands of the command line are run instead, whole processes: one after the
other with --time-limit, which counts from the start of the process, and without one and SIGINT sent
in the middle of their work. What counts is the CPU seconds that the process takes after the moment,
exit included; where other work keeps the machine busy, the clock on the wall shows that.
Also shown are the exit code, the most memory, and "loading": the CPU seconds of a command that
needs the same libraries and tables for sides of two edges, after which SIGINT is sent.

Prints a Markdown table and the worst; exits 1 if a question took more than --late seconds.
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
import os
import random
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np

import patterndb
from query import Boundary, Stroke, fills

#: Seconds after the moment, at which a process is killed.
NEVER = 20.0

WAYS = ("limit", "cancel", "key")


@dataclass(frozen=True, slots=True)
class HardQuestion:
    """A question. options: of :func:`query.fills`."""

    name: str
    boundary: Boundary
    strokes: tuple[Stroke, ...] = ()
    options: dict[str, Any] = field(default_factory=dict)


def cross_many(boundary: Boundary, count: int) -> tuple[Stroke, ...]:
    """Strokes from opposite side to opposite side, as even as they can be."""
    n = boundary.n_sides
    found: list[Stroke] = []
    for k in range(count):
        a = k % max(n // 2, 1)
        b = (a + n // 2) % n
        step = boundary.lengths[a] / (count / max(n // 2, 1) + 1)
        at = min(boundary.lengths[a] - 1, int(step * (1 + k // max(n // 2, 1))))
        other = max(0, boundary.lengths[b] - 1 - at)
        found.append(Stroke((a, at), (b, other)))
    return tuple(found)


def scatter(boundary: Boundary, count: int, seed: int) -> tuple[Stroke, ...]:
    """Strokes between random edges of random sides."""
    chance = random.Random(seed)
    found: list[Stroke] = []
    while len(found) < count:
        a, b = chance.sample(range(boundary.n_sides), 2)
        found.append(
            Stroke(
                (a, chance.randrange(boundary.lengths[a])),
                (b, chance.randrange(boundary.lengths[b])),
            )
        )
    return tuple(found)


def fan(boundary: Boundary, count: int) -> tuple[Stroke, ...]:
    """Strokes side by side between two neighbouring sides."""
    last = boundary.lengths[0] - 1
    return tuple(Stroke((0, last - k), (1, k)) for k in range(count))


def crooked(n: int, length: int, every: int, seed: int) -> Boundary:
    """A boundary with reflex corners: every so many-th, and as many convex ones as fit."""
    chance = random.Random(seed)
    corners: list[Any] = ["reflex" if k % every == every - 1 else "convex" for k in range(n)]
    lengths = [chance.randint(1, length) for _ in range(n)]
    lengths[0] += sum(lengths) % 2
    return Boundary(lengths, corners)


def place_round(boundary: Boundary) -> Boundary:
    """The boundary on a circle."""
    angle = np.linspace(0, 2 * math.pi, boundary.perimeter, endpoint=False)
    points = np.column_stack([np.cos(angle), np.sin(angle)])
    return Boundary(boundary.lengths, boundary.corners, points)


def draw(strokes: tuple[Stroke, ...], boundary: Boundary) -> tuple[Stroke, ...]:
    """The strokes as straight lines on a boundary with points."""
    assert boundary.points is not None
    starts = np.concatenate([[0], np.cumsum(boundary.lengths)])
    found: list[Stroke] = []
    for stroke in strokes:
        assert stroke.start is not None
        assert stroke.end is not None
        ends = [
            boundary.points[[starts[s] + e, (starts[s] + e + 1) % boundary.perimeter]].mean(axis=0)
            for s, e in (stroke.start, stroke.end)
        ]
        found.append(Stroke(stroke.start, stroke.end, np.linspace(ends[0], ends[1], 20)))
    return tuple(found)


def list_questions() -> Iterator[HardQuestion]:
    """Forty questions."""
    every: dict[str, Any] = {"limit": None}
    for n, count in ((4, 20), (3, 20), (5, 20), (6, 12), (8, 20), (12, 20)):
        b = Boundary((60,) * n)
        yield HardQuestion(f"{count} even strokes, {n} sides of 60", b, cross_many(b, count))
    for n, count in ((4, 8), (5, 20), (6, 20)):
        b = Boundary((60,) * n)
        yield HardQuestion(f"{count} random strokes, {n} sides of 60", b, scatter(b, count, n))
    for tolerance in (0, 3):
        b = Boundary((60,) * 6)
        yield HardQuestion(
            f"20 strokes round a corner of 6 sides of 60, tolerance {tolerance}",
            b,
            fan(b, 20),
            {"tolerance": tolerance},
        )
    b = Boundary((60,) * 4)
    yield HardQuestion(
        "40 strokes across a square of 60, strict", b, cross_many(b, 40), {"strict": True}
    )
    b = place_round(Boundary((60,) * 5))
    yield HardQuestion("20 drawn strokes, 5 sides of 60", b, draw(cross_many(b, 20), b))
    b = place_round(Boundary((200,) * 6))
    yield HardQuestion("no stroke, by points, 6 sides of 200", b, (), {"pool": 100000, **every})
    b = Boundary.closed(60)
    loops = tuple(Stroke.loop() for _ in range(12))
    yield HardQuestion("12 loops in a closed side of 60", b, loops)
    yield HardQuestion("12 loops in 6 sides of 60", Boundary((60,) * 6), loops)
    across = tuple(Stroke((0, k), (0, 59 - k)) for k in range(12))
    yield HardQuestion("12 strokes across a closed side of 60", b, across)
    for n, length, often in ((127, 9, 3), (127, 28, 2), (126, 1, 3), (60, 40, 3), (30, 100, 2)):
        b = crooked(n, length, often, n)
        yield HardQuestion(f"{n} sides up to {length}, every {often}. corner reflex", b, (), every)
    b = crooked(40, 30, 3, 7)
    yield HardQuestion("40 sides, some reflex, 12 random strokes", b, scatter(b, 12, 3))
    yield HardQuestion("127 convex sides of 15", Boundary((15,) * 126 + (22,)), (), every)
    yield HardQuestion("127 convex sides of 1 and 3", Boundary((1, 3) * 63 + (2,)), (), every)
    for n, length in ((6, 16), (7, 60), (4, 60)):
        b = Boundary((length,) * (n - 1) + (length + length * n % 2,))
        yield HardQuestion(f"CP-SAT, {n} sides of {length}", b, (), {"solver": "cp-sat", **every})
    b = Boundary((60,) * 4)
    yield HardQuestion("CP-SAT, 3 strokes", b, cross_many(b, 3), {"solver": "cp-sat"})
    b = Boundary((30,) * 6)
    yield HardQuestion("CP-SAT, 20 strokes", b, cross_many(b, 20), {"solver": "cp-sat"})
    for n, length in ((8, 250), (6, 332), (3, 666), (2, 1000), (1, 2000)):
        yield HardQuestion(f"{n} sides of {length}", Boundary((length,) * n), (), every)
    yield HardQuestion("a closed side of 2000", Boundary.closed(2000), (), every)
    yield HardQuestion(
        "8 sides of 60, any number irregular on the boundary",
        Boundary((60,) * 8),
        (),
        {"max_boundary_irregular": 500, **every},
    )
    yield HardQuestion("4 sides of 500", Boundary((500,) * 4), (), every)
    yield HardQuestion("1, 1, 1 and 1997", Boundary((1, 1, 1, 1997)), (), every)
    yield HardQuestion(
        "one in a million of 12 sides",
        Boundary((101, 7) * 6),
        (),
        {"max_irregular": 2, "max_boundary_irregular": 1, "has_loop": True},
    )


def ask(database: patterndb.Database, question: HardQuestion, **more: Any) -> Any:
    """The list of a question, not begun yet."""
    return fills(database, question.boundary, strokes=question.strokes, **question.options, **more)


def warm_up(database: patterndb.Database, question: HardQuestion) -> None:
    """Load tables by easy questions of the same kind."""
    n = question.boundary.n_sides
    easy = Boundary.closed(8) if n == 0 else Boundary((4,) * n, question.boundary.corners)
    points = question.boundary.points is not None
    easy = place_round(easy) if points else easy
    ends = ((0, 1), (0, 6)) if n == 0 else ((0, 1), (n - 1, 2))
    strokes = (Stroke(*ends),) if n != 1 else ()
    if points:
        strokes = draw(strokes, easy)
    for some in ((), strokes):
        for option in ({}, {"strict": True}):
            found = fills(database, easy, strokes=some, limit=3, time_limit=1.0, **option)
            list(found)
    if "solver" in question.options:
        next(fills(database, easy, solver=question.options["solver"], limit=1, strict=True), None)


def _work(number: int, way: str, seconds: float, results: Connection) -> None:
    question = list(list_questions())[number]
    # A shell that runs this in the background has it ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    with patterndb.open() as database:
        # What is loaded once is not the question's time.
        warm_up(database, question)
        results.send(time.monotonic())
        more = {"time_limit": seconds} if way == "limit" else {}
        found = ask(database, question, **more)
        began = time.monotonic()
        used: list[float] = []

        def end() -> None:
            used.append(time.process_time())
            if way == "cancel":
                found.cancel()
            elif way == "key":
                os.kill(os.getpid(), signal.SIGINT)

        threading.Timer(seconds, end).start()
        count = 0
        try:
            for _ in found:
                count += 1
        except KeyboardInterrupt:
            pass
        after = time.process_time() - used[0] if used else 0.0
        results.send((count, time.monotonic() - began, after))
        os._exit(0)


def try_question(number: int, way: str, seconds: float) -> tuple[int, float, float] | None:
    """Fills listed, seconds that it took, and those of the processor after the moment; None where
    it had to be killed."""
    context = multiprocessing.get_context("spawn")
    mine, theirs = context.Pipe(duplex=False)
    process = context.Process(target=_work, args=(number, way, seconds, theirs))
    process.start()
    theirs.close()
    try:
        if mine.poll(180):
            mine.recv()
            if mine.poll(seconds + NEVER):
                return mine.recv()
        return None
    except EOFError:
        return None
    finally:
        process.kill()
        process.join()


# Whole commands.

#: Seconds of the processor, beyond those of an easy command, after which SIGINT is sent.
INTO_WORK = 1.0

#: Seconds after which a command is killed that neither its limit nor SIGINT has ended.
HOPELESS = 60.0


def list_commands(folder: Path) -> list[list[str]]:
    """Forty commands that could run for minutes; folder: for what they write."""
    image, sheet = str(folder / "o.png"), str(folder / "o.svg")
    crossed = "0:{0}-2:{1} 1:{0}-3:{1}"
    flows = [flow for k in range(0, 20, 2) for flow in crossed.format(k, 59 - k).split()]
    strokes = [part for flow in flows for part in ("--flow", flow)]
    fan_strokes = [part for k in range(20) for part in ("--flow", f"0:{59 - k}-1:{k}")]
    loops = ["--loop"] * 12
    every = ["--flat", "--limit", "1000000"]
    five, six, eight = ",".join(["60"] * 5), ",".join(["100"] * 6), ",".join(["200"] * 8)
    reflex = ",".join("r" if k % 3 == 2 else "c" for k in range(60))
    boundaries = folder / "boundaries.jsonl"
    boundaries.write_text("".join(f"{line}\n" for line in (six, five, eight) * 20))
    circle = _write_circle(folder / "circle.json", 6, 150)
    mesh = _write_open_grid(folder / "grid.obj", 300)
    several = _write_holed_grid(folder / "holed.obj")
    _write_open_grid(folder / "rim.obj", 60)
    holes_lines = folder / "holes.jsonl"
    holes_lines.write_text('{"mesh": "rim.obj"}\n' * 60)
    return [
        ["query", "--sides", five, *strokes],
        ["query", "--sides", five, *strokes, "--json"],
        ["query", "--sides", five, *strokes, "--tolerance", "3"],
        ["query", "--sides", six.replace("100", "60"), *fan_strokes],
        ["query", "--sides", six.replace("100", "60"), *loops],
        ["query", "--sides", "60,60,60,60", *strokes, "--strict", "--tolerance", "0"],
        ["query", "--sides", "3,5,4,6", "--flow", "0:1-2:1", "--tolerance", "2000", *every],
        ["query", "--sides", six, *every, "--json"],
        ["query", "--sides", six, *every],
        ["query", "--sides", six, "--folded", "--limit", "1000000", "--json"],
        ["query", "--sides", eight, "--limit", "300", "--image", image],
        ["query", "--sides", eight, "--limit", "300", "--image", sheet],
        ["query", "--sides", six, "--limit", "300", "--image", image, "--json"],
        ["query", "--sides", six, "--limit", "300", "--obj", str(folder / "objs")],
        ["query", "--sides", eight, *every, "--order", "regular"],
        ["query", "--sides", "332,332,332,332,332,332", *every, "--order", "small"],
        ["query", "--sides", "2000", "--closed", *every],
        ["query", "--sides", "60", "--closed", *loops, *every],
        ["query", "--sides", "500,500,500,500", *every, "--json"],
        ["query", "--sides", "1,1,1,1997", *every],
        ["query", "--sides", ",".join(["15"] * 60), *every],
        ["query", "--sides", ",".join(["20"] * 60), "--corners", reflex, *every],
        ["query", "--sides", "101,7,101,7,101,7,101,7", "--max-irregular", "2", "--has-loop"],
        ["query", "--sides", eight, "--max-boundary-irregular", "500", *every],
        ["query", "--sides", five, "--solver", "cp-sat", *every],
        ["query", "--sides", five, *strokes[:6], "--solver", "cp-sat"],
        ["query", "--batch", str(boundaries), "--limit", "1000"],
        ["query", "--batch", str(boundaries), "--limit", "300", "--image", image],
        ["fill", circle, "--rank", "100000", "--flat", "-o", str(folder / "fill.obj")],
        ["fill", circle, "--order", "quality", "-o", str(folder / "fill.obj")],
        ["show", "--sides", eight, "--rank", "2000", "--flat", "-o", image],
        ["show", "--sides", eight, "-o", image],
        ["gallery", "--sides", six, "--flat", "--limit", "6000000", "-o", image],
        ["gallery", "--sides", eight, "--limit", "6000", "-o", sheet],
        ["gallery", "--class", "6", "--limit", "100000", "-o", image],
        ["list", "--class", "6", "--limit", "10000000", "--json"],
        ["export", str(folder / "six.jsonl"), "--class", "6"],
        ["holes", mesh, "--limit", "1000", "-o", str(folder / "filled.obj")],
        ["holes", several, "--all", "-o", str(folder / "closed.obj")],
        ["holes", "--batch", str(holes_lines), "--limit", "100"],
    ]


def _write_circle(path: Path, sides: int, length: int) -> str:
    """Write a boundary on a circle for ``fill``."""
    angle = np.linspace(0.0, 2.0 * math.pi, sides * length + 1)
    ring = np.column_stack([np.cos(angle), np.sin(angle), 0.1 * np.sin(3 * angle)])
    ring[-1] = ring[0]
    parts = [ring[k * length : (k + 1) * length + 1].tolist() for k in range(sides)]
    path.write_text(json.dumps({"sides": parts, "vertices": True}))
    return str(path)


def _write_open_grid(path: Path, n: int) -> str:
    """Write a mesh whose one border loop has 4 n edges: the outside of an n by n grid."""
    return _write_grid(path, n, lambda _i, _j: True)


def _write_holed_grid(path: Path) -> str:
    """Write a grid with 36 square holes of 40 edges."""
    return _write_grid(path, 120, lambda i, j: not (5 <= i % 20 < 15 and 5 <= j % 20 < 15))


def _write_grid(path: Path, n: int, is_kept: Callable[[int, int], bool]) -> str:
    lines = [
        f"v {i} {j} {math.sin(i / 9) + math.cos(j / 7)}" for i in range(n + 1) for j in range(n + 1)
    ]
    for i in range(n):
        for j in range(n):
            if is_kept(i, j):
                a = i * (n + 1) + j + 1
                lines.append(f"f {a} {a + n + 1} {a + n + 2} {a + 1}")
    path.write_text("\n".join((*lines, "")))
    return str(path)


@dataclass(frozen=True, slots=True)
class Ended:
    """How a command ended. after: seconds of the processor after the moment; wall: by the clock."""

    code: int
    after: float
    wall: float
    megabytes: float


def read_processor(pid: int) -> float:
    """Seconds of the processor that a process has used."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def run_command(command: list[str], seconds: float, loading: float, *, by_key: bool) -> Ended:
    """Run a command until its limit, or SIGINT, ends it. loading: seconds of the processor that an
    easy command needs."""
    words = [sys.executable, "-m", "patterndb", *command]
    words += [] if by_key else ["--time-limit", str(seconds)]
    began = time.monotonic()
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    used = moment = 0.0
    due = False
    while True:
        pid, status, usage = os.wait4(process.pid, os.WNOHANG)
        now = time.monotonic()
        if pid:
            break
        if not due:
            used, moment = read_processor(process.pid), now
            due = used >= loading + INTO_WORK if by_key else now - began >= seconds
            if due and by_key:
                process.send_signal(signal.SIGINT)
        if now - began > HOPELESS + seconds and now - moment > HOPELESS:
            process.kill()
        time.sleep(0.005)
    process.returncode = os.waitstatus_to_exitcode(status)
    total = usage.ru_utime + usage.ru_stime
    return Ended(
        process.returncode,
        total - used if due else 0.0,
        now - moment if due else 0.0,
        usage.ru_maxrss / 1024.0,
    )


def _run_easy(command: list[str]) -> float:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-m", "patterndb", *command], check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def _make_easy(command: list[str], folder: Path) -> list[str]:
    """Make a command that loads what another one does, and has next to nothing to do."""
    verb = command[0]
    if verb == "fill":
        return ["fill", _write_circle(folder / "easy.json", 6, 2), "-o", str(folder / "easy.obj")]
    if "--sides" not in command:
        return ["query", "--sides", "1,1,1,1", "--limit", "1"]
    n_sides = command[command.index("--sides") + 1].count(",") + 1
    closed = ["--closed"] if "--closed" in command else []
    easy = [verb, "--sides", "4" if closed else ",".join(["2"] * min(n_sides, 12)), *closed]
    easy += ["--limit", "1"] if verb != "show" else []
    for option in ("--image", "-o"):
        if option in command:
            written = Path(command[command.index(option) + 1])
            easy += [option, str(written.with_stem("easy"))]
    return [*easy, "--overwrite"] if verb != "query" or "--image" in command else easy


def run_commands(seconds: float, late: float, only: list[int] | None) -> int:
    """Run the commands, and print the table."""
    # A shell that runs this in the background has SIGINT ignored, and children inherit that.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    worst = 0.0
    with tempfile.TemporaryDirectory() as folder:
        commands = list_commands(Path(folder))
        known: dict[tuple[str, ...], float] = {}
        print(
            "| | command | loading | limit: code, s of processor after, s | SIGINT: the same | MB |"
        )
        print("|--:|---|--:|---|---|--:|")
        for number, command in enumerate(commands):
            if only and number not in only:
                continue
            easy = _make_easy(command, Path(folder))
            loading = known.setdefault(tuple(easy), 0.0) or _run_easy(easy)
            known[tuple(easy)] = loading
            ended = [
                run_command(command, seconds, loading, by_key=by_key) for by_key in (False, True)
            ]
            worst = max(worst, *(one.after for one in ended))
            cells = " | ".join(f"{one.code}, {one.after:.2f}, {one.wall:.2f}" for one in ended)
            megabytes = max(one.megabytes for one in ended)
            words = " ".join(command).replace(folder, "")
            shown = words if len(words) <= 80 else words[:79] + "…"
            print(f"| {number} | {shown} | {loading:.2f} | {cells} | {megabytes:.0f} |", flush=True)
    print(f"\nworst: {worst:.2f} s of the processor after the moment")
    return int(worst > late)


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--seconds", type=float, default=2.0, help="when it should end")
    parser.add_argument("--late", type=float, default=0.25, help="seconds after that are too many")
    parser.add_argument("--way", choices=WAYS, action="append", help="all if not given")
    parser.add_argument("--only", type=int, action="append", help="numbers of questions")
    parser.add_argument("--commands", action="store_true", help="run whole commands instead")
    given = parser.parse_args()
    if given.commands:
        return run_commands(given.seconds, given.late, given.only)
    ways = given.way or list(WAYS)
    print(f"| | question | {' | '.join(f'{w}: fills, s after, of processor' for w in ways)} |")
    print(f"|--:|---|{'---|' * len(ways)}")
    worst = 0.0
    for number, question in enumerate(list_questions()):
        if given.only and number not in given.only:
            continue
        cells: list[str] = []
        for way in ways:
            got = try_question(number, way, given.seconds)
            after = math.inf if got is None else max(0.0, got[1] - given.seconds)
            worst = max(worst, after)
            cells.append("never" if got is None else f"{got[0]:,}, {after:.2f}, {got[2]:.2f}")
        print(f"| {number} | {question.name} | {' | '.join(cells)} |", flush=True)
    print(f"\nworst: {worst:.2f} s after the moment")
    return int(worst > given.late)


if __name__ == "__main__":
    sys.exit(main())
