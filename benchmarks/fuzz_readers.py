"""Feed damaged files to the readers of text and binary formats, and count what comes out.

    python benchmarks/fuzz_readers.py --files 1000000 --seed 1 --jobs 2

The formats are those of the registry that are read from bytes; a new one is damaged as its own
writer spells it. Each file is a small valid one with a few random damages, and is read from
memory. It must be accepted as a sound mesh or refused with a MeshFileError, within a second.
Anything else is a failure: another exception, an unsound mesh, a slow or hanging read, a dead
worker process.
``--only N`` reads file N of a seed alone, in this process, and prints it.

Prints one JSON document; exits 1 if there were failures.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import random
import struct
import sys
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from multiprocessing.sharedctypes import RawArray
from typing import Any

import numpy as np

from ingest.formats import FORMATS, ReadLimits, parse
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import InvalidMeshError

SLOW_SECONDS = 1.0
# A worker that has been at one file for so long is taken to hang, and is ended.
HANG_SECONDS = 20.0
# Mostly one: a file with many is nearly always refused at the first.
DAMAGES_PER_FILE = (1, 1, 1, 2, 3)
MAX_FAILURES_SHOWN = 20

LIMITS = ReadLimits()


# Valid files


def _obj_seeds() -> list[bytes]:
    grid = b"".join(b"v %d %.2f -0.5\n" % (i % 4, i / 4) for i in range(12))
    quads = [(i, i + 1, i + 5, i + 4) for i in (1, 2, 3, 5, 6, 7)]
    plain = b"".join(b"f %d %d %d %d\n" % quad for quad in quads)
    seams = b"".join(b"f " + b" ".join(b"%d/%d/1" % (i, i) for i in quad) + b"\n" for quad in quads)
    return [
        grid + plain,
        b"# a comment\nmtllib a.mtl\no grid\n" + grid + b"vn 0 0 1\nvt 0 1\ns off\n" + seams,
        b"v 0 0 0\nv 1 0 0 1\nv 1 1 0 .1 .2 .3\nv 0 1 0 1 .1 .2 .3\n"
        b"f -4 -3 -2 -1\nf 1//1 2//1 3//1\n",
        (grid + plain).replace(b"\n", b"\r\n") + b"f 1 \\\r\n 2 \\\r\n 6\r\n",
        b"\xef\xbb\xbfg a b\n" + grid + b"usemtl \xff\xfe\nf 1 2 6 5 9 # tail\nl 1 2\np 3\n",
    ]


def _ply_header(order: str, n_vertices: int, n_faces: int, *, rich: bool) -> bytes:
    lines = ["ply", f"format {order} 1.0", "comment made by hand", f"element vertex {n_vertices}"]
    lines += [f"property {'double' if rich else 'float'} {axis}" for axis in "xyz"]
    lines += ["property uchar red"] if rich else []
    lines += [f"element face {n_faces}"]
    lines += ["property uchar flags"] if rich else []
    lines += [f"property list uchar {'uint' if rich else 'int'} vertex_indices"]
    lines += ["property list int16 float32 texcoord"] if rich else []
    lines += ["element edge 1", "property list uint uint8 tags"] if rich else []
    return ("\n".join([*lines, "end_header"]) + "\n").encode()


def _ply_seeds() -> list[bytes]:
    points = [(i % 4, i // 4, 0.5) for i in range(12)]
    faces = [[i, i + 1, i + 5, i + 4] for i in (0, 1, 2, 4, 5)]
    mixed = [*faces, [6, 7, 11], [6, 11, 10]]
    seeds: list[bytes] = []
    for own in (faces, mixed):
        rows = ["{:g} {:g} {:g}".format(*point) for point in points]
        rows += [" ".join(map(str, [len(face), *face])) for face in own]
        body = ("\n".join(rows) + "\n").encode()
        seeds.append(_ply_header("ascii", len(points), len(own), rich=False) + body)
        rows = ["{:g} {:g} {:g} 7".format(*point) for point in points]
        rows += [" ".join(map(str, [0, len(face), *face, 2, 0.5, 1])) for face in own]
        body = ("\n".join([*rows, "3 1 2 3"]) + "\n").encode()
        seeds.append(_ply_header("ascii", len(points), len(own), rich=True) + body)
        for order, name in (("<", "binary_little_endian"), (">", "binary_big_endian")):
            body = b"".join(struct.pack(order + "3f", *point) for point in points)
            body += b"".join(struct.pack(f"{order}B{len(f)}i", len(f), *f) for f in own)
            seeds.append(_ply_header(name, len(points), len(own), rich=False) + body)
            body = b"".join(struct.pack(order + "3dB", *point, 7) for point in points)
            body += b"".join(
                struct.pack(f"{order}BB{len(f)}Ih2f", 0, len(f), *f, 2, 0.5, 1) for f in own
            )
            body += struct.pack(order + "I3B", 3, 1, 2, 3)
            seeds.append(_ply_header(name, len(points), len(own), rich=True) + body)
    return seeds


def _off_seeds() -> list[bytes]:
    points = b"".join(b"%d %d .5\n" % (i % 4, i // 4) for i in range(12))
    quads = b"".join(b"4 %d %d %d %d\n" % (i, i + 1, i + 5, i + 4) for i in (0, 1, 2, 4, 5))
    coloured = points.replace(b" .5\n", b" .5 255 0 0 128\n")
    return [
        b"OFF\n# by hand\n12 5 0\n\n" + points + quads,
        b"COFF 12 6 0\n" + coloured + quads + b"5 6 7 11 10 9 0.5 .5 1 # a colour\n",
        (b"\xef\xbb\xbfNOFF\n12 5 0\n" + points.replace(b".5\n", b".5 0 0 1\n") + quads).replace(
            b"\n", b"\r\n"
        ),
    ]


def _written_seeds() -> list[tuple[str, bytes]]:
    """One file of each format that is written, so that the next one is damaged too."""
    points = [(i % 4, i // 4, i / 7) for i in range(12)]
    mesh = PolygonMesh.from_faces(
        points, [[0, 1, 5, 4], [1, 2, 6, 5], [6, 7, 11], [4, 5, 6, 10, 9]]
    )
    return [
        (f"seed{entry.suffixes[0]}", entry.spell(mesh))
        for entry in FORMATS
        if entry.from_bytes and entry.spell is not None
    ]


SEEDS: list[tuple[str, bytes]] = [
    *(("seed.obj", data) for data in _obj_seeds()),
    *(("seed.ply", data) for data in _ply_seeds()),
    *(("seed.off", data) for data in _off_seeds()),
    *_written_seeds(),
]


# Damages

_NUMBERS = (
    b"0 -1 1 2 3 4 64 65 127 128 255 256 32768 65535 2147483647 2147483648 4294967295 "
    b"-2147483649 9223372036854775808 99999999999999999999 1e308 1e309 -1e999 nan inf -inf NaN "
    b"1_000 0x10 1e 1.5 .5 5. . + - +1 1,5 1/ 1// /1 1/1/1/1 1#2 \xd9\xa1 \\ 007 1e-400"
).split()
_TOKENS = (
    b"OFF COFF NOFF STOFF 4OFF nOFF BINARY "
    b"v f vt vn l p g o s usemtl fo call # \\ ply format ascii binary_little_endian 1.0 "
    b"binary_big_endian element property list vertex face edge x y z vertex_indices uchar char "
    b"short int uint float double int8 uint16 float64 end_header comment"
).split()


def _spot(rng: random.Random, data: bytes) -> int:
    """A place in the file, the end included."""
    return rng.randrange(len(data) + 1)


def _flip(rng: random.Random, data: bytes) -> bytes:
    at = min(_spot(rng, data), max(0, len(data) - 1))
    return (
        data[:at] + bytes([data[at] ^ (1 << rng.randrange(8))]) + data[at + 1 :] if data else data
    )


def _overwrite(rng: random.Random, data: bytes) -> bytes:
    at = _spot(rng, data)
    junk = rng.choice((b"\0", b"\n", b"\r", b"\xff", b" ", b"\x80\x80\x80\x80", rng.randbytes(4)))
    return data[:at] + junk + data[at + len(junk) :]


def _insert(rng: random.Random, data: bytes) -> bytes:
    at = _spot(rng, data)
    junk = rng.choice((b"\0", b"\n", b"\r\n", b"\\\n", b" ", b"\t", b"#", rng.randbytes(3)))
    return data[:at] + junk * rng.choice((1, 1, 1, 2, 70)) + data[at:]


def _delete(rng: random.Random, data: bytes) -> bytes:
    at = _spot(rng, data)
    return data[:at] + data[at + rng.choice((1, 1, 2, 4, 13, 60)) :]


def _truncate(rng: random.Random, data: bytes) -> bytes:
    return data[: rng.randrange(len(data) + 1)]


def _splice(rng: random.Random, data: bytes) -> bytes:
    other = rng.choice(SEEDS)[1]
    begin = _spot(rng, other)
    at = _spot(rng, data)
    return data[:at] + other[begin : begin + rng.choice((4, 40, 400))] + data[_spot(rng, data) :]


def _edit_token(rng: random.Random, data: bytes) -> bytes:
    """Another number or word in place of a blank-separated token."""
    at = _spot(rng, data)
    begin = max(data.rfind(b" ", 0, at), data.rfind(b"\n", 0, at)) + 1
    ends = [end for end in (data.find(b" ", begin), data.find(b"\n", begin)) if end >= 0]
    end = min(ends, default=len(data))
    token = rng.choice(_NUMBERS if rng.random() < 0.7 else _TOKENS)
    return data[:begin] + token + data[end:]


def _digits(rng: random.Random, data: bytes) -> bytes:
    """More digits in the middle of a number."""
    at = _spot(rng, data)
    return data[:at] + b"9" * rng.choice((1, 2, 9, 18, 19, 400, 5000)) + data[at:]


def _lines(rng: random.Random, data: bytes) -> bytes:
    """Two lines swapped, one repeated, or one left out."""
    lines = data.split(b"\n")
    a, b = rng.randrange(len(lines)), rng.randrange(len(lines))
    match rng.randrange(3):
        case 0:
            lines[a], lines[b] = lines[b], lines[a]
        case 1:
            lines[a:a] = [lines[b]] * rng.choice((1, 2, 30))
        case _:
            del lines[a]
    return b"\n".join(lines)


def _swap_tokens(rng: random.Random, data: bytes) -> bytes:
    tokens = data.split(b" ")
    a, b = rng.randrange(len(tokens)), rng.randrange(len(tokens))
    tokens[a], tokens[b] = tokens[b], tokens[a]
    return b" ".join(tokens)


_DAMAGES: tuple[Callable[[random.Random, bytes], bytes], ...] = (
    _flip,
    _overwrite,
    _insert,
    _delete,
    _truncate,
    _splice,
    _edit_token,
    _edit_token,
    _edit_token,
    _digits,
    _lines,
    _swap_tokens,
)


def damaged(seed: int, number: int) -> tuple[str, bytes]:
    """Name and bytes of the damaged file of this number; the same for the same two numbers."""
    rng = random.Random((seed << 40) + number)
    name, data = rng.choice(SEEDS)
    for _ in range(rng.choice(DAMAGES_PER_FILE)):
        data = rng.choice(_DAMAGES)(rng, data)
    return name, data


# What must hold of every file


def verdict(name: str, data: bytes) -> tuple[bool, str | None]:
    """Whether the file was accepted, and what is wrong with the way it was treated."""
    try:
        mesh = parse(data, name, LIMITS)
    except InvalidMeshError as error:
        return False, None if str(error).startswith(name) else f"the message names no file: {error}"
    except Exception as error:
        return False, f"{type(error).__name__}: {error}"
    return True, unsound(mesh)


def unsound(mesh: PolygonMesh) -> str | None:
    """What is wrong with a mesh that was accepted."""
    arities = mesh.arities()
    if not len(arities) or arities.min() < 3 or arities.max() > LIMITS.max_arity:
        return f"arities {arities.tolist()}"
    if mesh.corners.min() < 0 or mesh.corners.max() >= len(mesh.points):
        return "a corner out of range"
    if not np.isfinite(mesh.points).all():
        return "a point that is not finite"
    types = (mesh.points.dtype, mesh.corners.dtype, mesh.offsets.dtype)
    if types != (np.float64, np.int32, np.int64):
        return f"types {types}"
    return None


# Workers: each takes every jobs-th file and keeps its tally in memory it shares, so that
# the tally, and the file it died on, outlive it.

_NEXT, _ACCEPTED, _REFUSED, _SLOWEST_US, _SLOWEST, _SINCE_MS, _FIELDS = range(7)


@dataclass(frozen=True, slots=True)
class Task:
    seed: int
    files: int
    jobs: int


def work(task: Task, tally: Any, failures: Connection) -> None:
    """Read the files from ``tally[_NEXT]`` on, in steps of the number of jobs."""
    warnings.simplefilter("error")  # numpy warns of a value that it could not convert
    for number in range(tally[_NEXT], task.files, task.jobs):
        name, data = damaged(task.seed, number)
        tally[_NEXT] = number
        tally[_SINCE_MS] = int(time.monotonic() * 1000)
        start = time.perf_counter()
        accepted, wrong = verdict(name, data)
        seconds = time.perf_counter() - start
        if seconds > SLOW_SECONDS:
            wrong = f"{seconds:.1f} s to read"
        if wrong is not None:
            failures.send((number, wrong))
        tally[_ACCEPTED if accepted else _REFUSED] += 1
        if seconds * 1e6 > tally[_SLOWEST_US]:
            tally[_SLOWEST_US], tally[_SLOWEST] = int(seconds * 1e6), number
    tally[_NEXT] = task.files


@dataclass(slots=True)
class Worker:
    """One process at a time, started anew behind a file that ended it."""

    task: Task
    tally: Any
    failures: list[tuple[int, str]]
    process: multiprocessing.Process | None = None
    receiver: Connection | None = None

    def start(self) -> None:
        self.receiver, sender = multiprocessing.Pipe(duplex=False)
        self.tally[_SINCE_MS] = int(time.monotonic() * 1000)
        process = multiprocessing.Process(target=work, args=(self.task, self.tally, sender))
        process.start()
        self.process = process
        sender.close()

    def watch(self) -> bool:
        """Take in what the process reports; False once all its files are read."""
        assert self.process is not None and self.receiver is not None
        alive = self.process.is_alive()  # before the pipe is emptied, so that nothing is missed
        try:
            while self.receiver.poll():
                self.failures.append(self.receiver.recv())
        except EOFError:
            pass
        if alive:
            if time.monotonic() * 1000 - self.tally[_SINCE_MS] < HANG_SECONDS * 1000:
                return True
            self.process.kill()
            self.process.join()
            ending = f"no end after {HANG_SECONDS:.0f} s"
        elif self.tally[_NEXT] >= self.task.files:
            self.process.join()
            return False
        else:
            ending = f"the process died with exit code {self.process.exitcode}"
        self.failures.append((self.tally[_NEXT], ending))
        self.tally[_NEXT] += self.task.jobs
        self.start()
        return True


def fuzz(task: Task) -> dict[str, object]:
    """Read all files of a task; the summary that is printed."""
    begin = time.monotonic()
    failures: list[tuple[int, str]] = []
    workers: list[Worker] = []
    for job in range(task.jobs):
        tally = RawArray("q", _FIELDS)
        tally[_NEXT] = job
        workers.append(Worker(task, tally, failures))
        workers[-1].start()
    running = workers
    while running:
        time.sleep(0.05)
        running = [worker for worker in running if worker.watch()]
    slowest = max(workers, key=lambda worker: worker.tally[_SLOWEST_US])
    accepted = sum(worker.tally[_ACCEPTED] for worker in workers)
    refused = sum(worker.tally[_REFUSED] for worker in workers)
    return {
        "files": accepted + refused,
        "seed": task.seed,
        "accepted": accepted,
        "refused": refused,
        "slowest_ms": slowest.tally[_SLOWEST_US] / 1000,
        "slowest_file": slowest.tally[_SLOWEST],
        "seconds": round(time.monotonic() - begin, 1),
        "n_failures": len(failures),
        "failures": [
            {"file": number, "wrong": wrong}
            for number, wrong in sorted(failures)[:MAX_FAILURES_SHOWN]
        ],
    }


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--files", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", type=int, metavar="N", help="read file N alone, and print it")
    options = parser.parse_args()
    if options.only is not None:
        name, data = damaged(options.seed, options.only)
        print(name, data, sep="\n")
        print(parse(data, name, LIMITS))
        return 0
    summary = fuzz(Task(options.seed, options.files, options.jobs))
    print(json.dumps(summary, indent=2))
    return 1 if summary["n_failures"] else 0


if __name__ == "__main__":
    sys.exit(main())
