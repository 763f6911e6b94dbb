"""Prove that what a user sees has not changed: record what the verbs make, compare two records.

    python benchmarks/unchanged.py record BEFORE.json --shared ../shared
    python benchmarks/unchanged.py compare BEFORE.json AFTER.json

Run "record" in a checkout of the state before and in one of the state after a change, then
"compare" the two files. Only the command line is driven, so that the code below it may be moved
and renamed. The checkout is the one that this file lies in, or the one that PYTHONPATH names.

| part | items |
|---|---|
| queries | lists of fills of random boundaries, with strokes, loops, reflex corners; all orders |
| retopo | the scripts of examples/retopo |
| features | the curves of examples/features on the models of real vehicles |
| surfaces | the curve networks of the shared folder and of examples/networks |
| fills | fills placed on regions that are cut at random out of meshes |
| database | all meshes of the shared folder, learned into one database |

An item has fields: digests (SHA-256) of its input, of every file that was written, byte for
byte, of the JSON document on stdout, of stdout as text; and the exit code and the talk on stderr.
Of texts, times in seconds are left out and folders are replaced by names. The document's digest
does not depend on the order of its keys, the text's does. No time limit is given to any verb, and
libraries of linear algebra get one thread each, so that neither clock nor load decides a result.

A record of some parts (--part) goes into an existing file beside the parts that it has. With
--work DIR, databases and caches are kept in DIR under the digest of the code that made them, and
are used again by the same code.
"""

from __future__ import annotations

import argparse
import hashlib
import heapq
import json
import os
import platform
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import dist
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]

#: What is known of an item: digests, exit codes, texts.
Fields = dict[str, Any]

#: A point in space.
Point = tuple[float, float, float]

#: Entries of JSON documents that hold a time.
SECONDS_ENTRY = re.compile(r'("\w*seconds\w*"): ?[-+.0-9eE]+')

#: Times in texts: "in 0.12 s", "3.1 ms".
SECONDS_SAID = re.compile(r"\b[0-9][0-9.,]* ?(?:ms|s)\b")

#: Variables that set the threads of libraries of linear algebra.
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")

#: Differing items that "compare" lists of each part, and characters of a text that it shows.
LISTED = 10
SHOWN = 160

#: Random questions: of each batch file how many there are, their most sides, and the options.
BATCHES: dict[str, tuple[int, int, tuple[str, ...]]] = {
    "artist": (230, 10, ()),
    "strict": (50, 10, ("--strict",)),
    "regular": (50, 10, ("--order", "regular")),
    "small": (30, 10, ("--order", "small", "--tolerance", "0")),
    "symmetric": (30, 10, ("--order", "symmetric", "--max-boundary-irregular", "1")),
    "learned": (40, 10, ("--learned-only", "--per-pattern", "1", "--limit", "50")),
    "filtered": (40, 10, ("--max-irregular", "4", "--valence", "3..5", "--no-loop")),
    # This solver looks at patterns one by one, and of all patterns it would take minutes.
    "solver": (20, 6, ("--solver", "cp-sat", "--strict", "--max-irregular", "3", "--limit", "5")),
}

#: Questions that are asked one by one, with a table and an OBJ file for every fill.
SINGLE = 10

#: Networks that are surfaced by other methods and options too, below data/curves.
HANDFUL = (
    "cassie/graph/01-2-2.json",
    "cassie/graph/11-2-2.json",
    "cassie/graph/08-2-2.json",
    "salvi/cagd86.lop",
    "salvi/pocket6sided.lop",
    "salvi/trebol_network.json",
)

#: Options for the handful.
OTHER_WAYS: dict[str, tuple[str, ...]] = {
    "area": ("--method", "area"),
    "quads": ("--method", "quads"),
    "any chord": ("--any-chord",),
    "cycles": ("--find-cycles", "--cycles-only"),
}

#: Drawn strokes that meet only within a tolerance, and the tolerance, in the networks' unit.
LOOSE = (
    "cassie/strokes/guitar.curves",
    "cassie/strokes/hat.curves",
    "cassie/strokes/shield.curves",
    "cassie/strokes/teapot.curves",
)
LOOSE_TOLERANCE = "0.01"

#: Options for the strokes of one vehicle, beside those of the file alone.
FEATURE_WAYS: dict[str, tuple[str, ...]] = {
    "angle": ("--alpha", "0.3", "--beta", "60"),
    "stiff": ("--stiffness", "4", "--degree", "4"),
    "strict": ("--strict", "--rounds", "1", "--reach", "0.03"),
}
FEATURE_MODEL = "q_car_normalcar1"

#: Meshes that fills are placed on: files of examples/, then of data/surfaces; faces of a region.
GROUNDS: tuple[tuple[str, int, int], ...] = (
    ("head.obj", 8, 60),
    ("hand.obj", 8, 40),
    ("jug.obj", 8, 40),
    ("dog.obj", 8, 40),
    ("spot.obj", 100, 900),
    ("koala_low.obj", 60, 400),
)

#: How many fills, and the options that they take in turn.
FILLS = 36
FILL_WAYS: tuple[tuple[str, ...], ...] = (
    (),
    ("--rank", "2"),
    ("--order", "quality"),
    ("--order", "regular", "--rank", "3"),
    ("--strict",),
    ("--order", "small"),
)


# ------------------------------------------------------------------------------ running verbs


@dataclass(frozen=True, slots=True)
class Bench:
    """Where things are. work: a folder to write into. digest: of the code that is run."""

    shared: Path
    work: Path
    seed: int
    digest: str
    environment: dict[str, str]

    @property
    def data(self) -> Path:
        return self.shared / "data"

    def make_chance(self, *names: object) -> random.Random:
        """Make a source of random numbers that depends on the seed and the names alone."""
        return random.Random(" ".join(map(str, (self.seed, *names))))

    def start_verb(self, arguments: Sequence[str], talk: Any) -> subprocess.Popen[bytes]:
        """Start a verb in the folder work; stdout is a pipe, stderr goes to the file talk."""
        command = [sys.executable, "-m", "patterndb", *arguments]
        return subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=talk, stdin=subprocess.DEVNULL,
            cwd=self.work, env=self.environment,
        )  # fmt: skip

    def clean_text(self, text: str, out: Path | None = None) -> str:
        """Replace what differs from machine to machine and from run to run."""
        folders = [(out, "{out}"), (self.work, "{work}"), (self.shared, "{shared}")]
        for folder, name in [*folders, (ROOT, "{root}")]:
            if folder is not None:
                text = text.replace(str(folder), name)
        text = SECONDS_ENTRY.sub(r"\1:0", text.replace(self.digest[:16], "{code}"))
        return SECONDS_SAID.sub("0 s", text)


@dataclass(frozen=True, slots=True)
class Case:
    """A call of a verb. In arguments, {out} is a fresh folder for what it writes.

    Arguments that are full paths of files are its input, but for databases.
    """

    name: str
    arguments: tuple[str, ...]


@dataclass(slots=True)
class Progress:
    """Tell on stderr how far a part is."""

    part: str
    total: int
    done: int = 0
    started: float = field(default_factory=time.perf_counter)

    def advance(self, name: str) -> None:
        self.done += 1
        seconds = time.perf_counter() - self.started
        line = f"{self.part}: {self.done} of {self.total}, {seconds:.0f} s: {name}"
        if sys.stderr.isatty():
            end = "\n" if self.done == self.total else ""
            print(f"\r{line[:99]:99}", end=end, file=sys.stderr, flush=True)
        else:
            print(line, file=sys.stderr, flush=True)


def hash_bytes(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def hash_json(document: object) -> str:
    """Hash a document whatever the order of its keys, times left out."""
    return hash_bytes(json.dumps(drop_seconds(document), sort_keys=True).encode())


def drop_seconds(value: Any) -> Any:
    """Copy a document without the entries that hold times."""
    if isinstance(value, dict):
        return {key: drop_seconds(one) for key, one in value.items() if "seconds" not in key}
    if isinstance(value, list):
        return [drop_seconds(one) for one in value]
    return value


def run_case(bench: Bench, case: Case) -> Fields:
    """Run a call of a verb and return what it made."""
    out = Path(tempfile.mkdtemp(dir=bench.work, prefix="out-"))
    try:
        arguments = [argument.replace("{out}", str(out)) for argument in case.arguments]
        named = [Path(argument) for argument in arguments if Path(argument).is_absolute()]
        # Rows of a database may lie in any order: its bytes tell nothing.
        inputs = [path for path in named if path.is_file() and path.suffix != ".db"]
        said = bench.work / "talk.txt"
        with said.open("wb") as talk, bench.start_verb(arguments, talk) as verb:
            stdout = verb.communicate()[0].decode()
        fields: Fields = {
            "call": bench.clean_text(" ".join(arguments), out),
            "exit": verb.returncode,
            "input": hash_bytes(b"".join(path.read_bytes() for path in inputs)),
            "talk": bench.clean_text(said.read_text(encoding="utf-8"), out).splitlines(),
        }
        text = bench.clean_text(stdout, out)
        if text:
            fields["stdout"] = hash_bytes(text.encode())
        if text.startswith("{"):
            fields["document"] = hash_json(json.loads(text))
        for path in sorted(out.rglob("*")):
            if path.is_file():
                fields[f"file {path.relative_to(out).as_posix()}"] = hash_bytes(path.read_bytes())
        return fields
    finally:
        shutil.rmtree(out)


def run_cases(bench: Bench, part: str, cases: Sequence[Case]) -> dict[str, Fields]:
    """Run calls one after another and return what they made, by their names."""
    progress = Progress(part, len(cases))
    items: dict[str, Fields] = {}
    for case in cases:
        items[case.name] = run_case(bench, case)
        progress.advance(f"{case.name}: exit code {items[case.name]['exit']}")
    return items


def run_for_text(bench: Bench, arguments: Sequence[str]) -> str:
    """Run a verb that must succeed and return its stdout; RuntimeError where it fails."""
    said = bench.work / "talk.txt"
    with said.open("wb") as talk, bench.start_verb(arguments, talk) as verb:
        stdout = verb.communicate()[0].decode()
    if verb.returncode:
        call = " ".join(arguments)
        talked = said.read_text(encoding="utf-8").strip()
        raise RuntimeError(f"patterndb {call} ended with {verb.returncode}: {talked}")
    return stdout


# ------------------------------------------------------------------------------------ queries


def draw_question(chance: random.Random, most_sides: int = 10) -> dict[str, Any]:
    """Draw a boundary, half of them with strokes, as a line of a batch file has it."""
    if chance.random() < 0.05:
        return {"sides": [2 * chance.randint(2, 12)], "corners": []}
    while True:
        sides = [chance.randint(1, 8) for _ in range(chance.randint(3, most_sides))]
        if sum(sides) % 2 == 0:
            break
    question: dict[str, Any] = {"sides": sides}
    if len(sides) > 4 and chance.random() < 0.2:
        reflex = set(chance.sample(range(len(sides)), chance.randint(1, len(sides) - 4)))
        question["corners"] = ["r" if k in reflex else "c" for k in range(len(sides))]
    if chance.random() < 0.5:
        question["strokes"] = [draw_stroke(chance, sides) for _ in range(chance.choice((1, 1, 2)))]
    if chance.random() < 0.06:
        question["loops"] = 1
    return question


def draw_stroke(chance: random.Random, sides: Sequence[int]) -> list[list[int]]:
    """Draw a stroke between edges of two sides of a boundary."""
    return [[k, chance.randrange(sides[k])] for k in chance.sample(range(len(sides)), 2)]


def record_queries(bench: Bench) -> dict[str, Fields]:
    """Ask for the fills of random boundaries: a batch of each kind, then some one by one."""
    progress = Progress("queries", sum(n + 1 for n, _, _ in BATCHES.values()) + SINGLE)
    items: dict[str, Fields] = {}
    for kind, (count, most_sides, options) in BATCHES.items():
        chance = bench.make_chance("queries", kind)
        questions = [draw_question(chance, most_sides) for _ in range(count)]
        for name, fields in ask_batch(bench, kind, questions, options):
            items[name] = fields
            progress.advance(f"{name}: {fields.get('fills', 0)} fills")
    for case in list_single_questions(bench):
        items[case.name] = run_case(bench, case)
        progress.advance(case.name)
    return items


def ask_batch(
    bench: Bench, kind: str, questions: Sequence[dict[str, Any]], options: Sequence[str]
) -> Iterator[tuple[str, Fields]]:
    """Ask the questions of a batch file in one process; yields names and answers in order."""
    batch = bench.work / f"{kind}.jsonl"
    lines = [json.dumps(question) for question in questions]
    batch.write_text("\n".join(lines) + "\n", encoding="utf-8")
    said = bench.work / "talk.txt"
    arguments = ["query", "--batch", str(batch), *options]
    answered = 0
    with said.open("wb") as talk, bench.start_verb(arguments, talk) as verb:
        assert verb.stdout is not None
        for line, question in zip(verb.stdout, lines, strict=False):
            text = bench.clean_text(line.decode())
            answer = json.loads(text)
            fields: Fields = {"question": question, "document": hash_json(answer)}
            if "fills" in answer:
                fields["fills"] = len(answer["fills"])
                fields["reason"] = answer["reason"]
            else:
                fields["error"] = answer["error"]
            answered += 1
            yield f"{kind} {answered:03}", fields | {"stdout": hash_bytes(text.encode())}
    told = bench.clean_text(said.read_text(encoding="utf-8")).splitlines()
    yield f"{kind} at the end", {"exit": verb.returncode, "talk": told, "answers": answered}


def list_single_questions(bench: Bench) -> list[Case]:
    """Questions by options, not by file: fills as a table and as OBJ files."""
    chance = bench.make_chance("queries", "single")
    cases: list[Case] = []
    while len(cases) < SINGLE:
        question = draw_question(chance)
        arguments = ["query", "--sides", ",".join(map(str, question["sides"])), "--limit", "8"]
        corners = question.get("corners")
        if corners is not None:
            arguments += ["--corners", ",".join(corners)] if corners else ["--closed"]
        for (a, i), (b, j) in question.get("strokes", ()):
            arguments += ["--flow", f"{a}:{i}-{b}:{j}"]
        arguments += ["--loop"] * question.get("loops", 0)
        ways = ("--obj", "{out}") if len(cases) % 2 else ("--json", "--flat")
        cases.append(Case(f"single {len(cases) + 1:03}", (*arguments, *ways)))
    return cases


# ------------------------------------------------------- retopology, features, curve networks


def list_retopo(bench: Bench) -> list[Case]:
    """The scripts of examples/retopo, each on the surface that it names."""
    cases: list[Case] = []
    for script in sorted((ROOT / "examples" / "retopo").glob("*.jsonl")):
        with script.open(encoding="utf-8") as lines:
            named = json.loads(next(line for line in lines if line.startswith("{")))
        surface = bench.data / "surfaces" / Path(named["surface"]).name
        written = ("-o", "{out}/mesh.obj", "--session", "{out}/session.retopo", "--json")
        cases.append(Case(script.name, ("retopo", str(surface), "--script", str(script), *written)))
    return cases


def list_features(bench: Bench) -> list[Case]:
    """The strokes of examples/features, each on its model; one model with other options too."""
    cases: list[Case] = []
    for strokes in sorted((ROOT / "examples" / "features").glob("*.strokes.json")):
        name = strokes.name.removesuffix(".strokes.json")
        folders = (bench.data / "cad", bench.data / "meshes")
        model = next(path for folder in folders if (path := folder / f"{name}.obj").is_file())
        ways = {"": (), **(FEATURE_WAYS if name == FEATURE_MODEL else {})}
        for way, options in ways.items():
            call = ("features", str(model), "--strokes", str(strokes), *options)
            full = f"{name}, {way}" if way else name
            cases.append(Case(full, (*call, "-o", "{out}/curves.json", "--json")))
    return cases


def list_surfaces(bench: Bench) -> list[Case]:
    """The curve networks of the shared folder and of examples/networks; some in other ways."""
    curves = bench.data / "curves"
    suffixes = (".json", ".curves", ".lop", ".sdm")
    networks = {
        path.relative_to(curves).as_posix(): path
        for path in curves.rglob("*")
        if path.suffix in suffixes
    }
    examples = {
        f"examples/{path.name}": path for path in (ROOT / "examples/networks").glob("*.json")
    }
    networks |= examples
    written = ("-o", "{out}/surface.obj", "--json")
    cases = [
        Case(name, ("surface", str(path), *written)) for name, path in sorted(networks.items())
    ]
    for name in sorted((*HANDFUL, *examples)):
        for way, options in OTHER_WAYS.items():
            ends = ("--json",) if "--cycles-only" in options else written
            call = ("surface", str(networks[name]), *options, *ends)
            cases.append(Case(f"{name}, {way}", call))
    for name in LOOSE:
        call = ("surface", str(networks[name]), "--tolerance", LOOSE_TOLERANCE, *written)
        cases.append(Case(f"{name}, tolerance", call))
    return cases


# -------------------------------------------------------------------------------------- fills


@dataclass(frozen=True, slots=True)
class Mesh:
    """points, and faces as lists of vertices. beside: the face on the left of a half-edge."""

    points: list[Point]
    faces: list[list[int]]
    beside: dict[tuple[int, int], int]


def read_obj(path: Path) -> Mesh:
    """Read the vertices and faces of an OBJ file."""
    points: list[Point] = []
    faces: list[list[int]] = []
    with path.open(encoding="utf-8") as lines:
        for line in lines:
            words = line.split()
            if words and words[0] == "v":
                points.append((float(words[1]), float(words[2]), float(words[3])))
            elif words and words[0] == "f":
                faces.append([int(word.split("/")[0]) - 1 for word in words[1:]])
    beside = {edge: k for k, face in enumerate(faces) for edge in walk_around(face)}
    return Mesh(points, faces, beside)


def walk_around(loop: Sequence[int]) -> Iterator[tuple[int, int]]:
    """Yield the half-edges of a closed loop of vertices."""
    return pairwise((*loop, loop[0]))


def grow_region(mesh: Mesh, chance: random.Random, size: int) -> set[int]:
    """Grow a region of faces about a face drawn at random, the nearest faces first."""
    start = chance.randrange(len(mesh.faces))
    middle = find_middle(mesh, start)
    queue, seen, region = [(0.0, start)], {start}, set[int]()
    while queue and len(region) < size:
        _, face = heapq.heappop(queue)
        region.add(face)
        for a, b in walk_around(mesh.faces[face]):
            other = mesh.beside.get((b, a))
            if other is not None and other not in seen:
                seen.add(other)
                heapq.heappush(queue, (dist(middle, find_middle(mesh, other)), other))
    return region


def find_middle(mesh: Mesh, face: int) -> Point:
    """Find the mean of a face's corners."""
    corners = [mesh.points[k] for k in mesh.faces[face]]
    x, y, z = (sum(values) / len(corners) for values in zip(*corners, strict=True))
    return x, y, z


def trace_border(mesh: Mesh, region: set[int]) -> list[int] | None:
    """Trace the border of a region, the region on the left; None unless it is a disk."""
    edges = [edge for face in region for edge in walk_around(mesh.faces[face])]
    there = set(edges)
    border = {a: b for a, b in edges if (b, a) not in there}
    n_border = sum((b, a) not in there for a, b in edges)
    n_edges = (len(edges) + n_border) // 2
    n_vertices = len({k for face in region for k in mesh.faces[face]})
    if n_vertices - n_edges + len(region) != 1 or len(border) != n_border:
        return None
    start = min(border)
    loop = [start]
    while border[loop[-1]] != start:
        loop.append(border[loop[-1]])
    return loop if len(loop) == n_border else None


def draw_boundary(mesh: Mesh, chance: random.Random, least: int, most: int) -> dict[str, Any]:
    """Draw a region of least to most faces and return its boundary as a file of "fill" has it."""
    while True:
        region = grow_region(mesh, chance, chance.randint(least, most))
        loop = trace_border(mesh, region)
        n_sides = chance.randint(3, 6)
        if loop is None or len(loop) < 2 * n_sides:
            continue
        turn = chance.randrange(len(loop))
        loop = loop[turn:] + loop[:turn]
        cuts = [k * len(loop) // n_sides for k in range(n_sides + 1)]
        ring = [*loop, loop[0]]
        sides = [ring[a : b + 1] for a, b in pairwise(cuts)]
        lines = [[mesh.points[k] for k in side] for side in sides]
        spans = [sum(dist(a, b) for a, b in pairwise(line)) for line in lines]
        edge = sum(spans) / chance.randint(10, 30)
        lengths = [max(1, round(span / edge)) for span in spans]
        lengths[0] += sum(lengths) % 2
        drawn: dict[str, Any] = {"sides": lines, "lengths": lengths}
        if chance.random() < 0.4:
            a, b = chance.sample(sides, 2)
            path = find_path(mesh, region, a[len(a) // 2], b[len(b) // 2])
            if len(path) > 1:
                drawn["strokes"] = [[mesh.points[k] for k in path]]
        elif chance.random() < 0.2:
            drawn["strokes"] = [{"points": shrink_loop(mesh, loop), "loop": True}]
        if n_sides > 4 and chance.random() < 0.3:
            reflex = chance.randrange(n_sides)
            drawn["corners"] = ["reflex" if k == reflex else "convex" for k in range(n_sides)]
        return drawn


def shrink_loop(mesh: Mesh, loop: Sequence[int]) -> list[Point]:
    """Return a loop of vertices drawn half-way to its middle."""
    points = [mesh.points[k] for k in loop]
    x, y, z = (sum(values) / len(points) for values in zip(*points, strict=True))
    return [((x + a) / 2, (y + b) / 2, (z + c) / 2) for a, b, c in points]


def find_path(mesh: Mesh, region: set[int], start: int, end: int) -> list[int]:
    """Find a path of the fewest edges between two vertices of a region."""
    beside: dict[int, set[int]] = {}
    for face in region:
        for a, b in walk_around(mesh.faces[face]):
            beside.setdefault(a, set()).add(b)
            beside.setdefault(b, set()).add(a)
    before = {end: end}
    queue = deque([end])
    while queue and start not in before:
        vertex = queue.popleft()
        for other in sorted(beside[vertex]):
            if other not in before:
                before[other] = vertex
                queue.append(other)
    path = [start]
    while path[-1] != end:
        path.append(before[path[-1]])
    return path


def list_fills(bench: Bench) -> list[Case]:
    """Boundaries of random regions; every fourth is filled in space, without its surface."""
    folder = bench.work / "boundaries"
    folder.mkdir(exist_ok=True)
    meshes: dict[str, tuple[Path, Mesh]] = {}
    for name, _, _ in GROUNDS:
        folders = (ROOT / "examples", bench.data / "surfaces")
        path = next(path for one in folders if (path := one / name).is_file())
        meshes[name] = path, read_obj(path)
    cases: list[Case] = []
    for k in range(FILLS):
        name, least, most = GROUNDS[k % len(GROUNDS)]
        ground, mesh = meshes[name]
        chance = bench.make_chance("fills", k)
        boundary = folder / f"{k + 1:03}.json"
        boundary.write_text(json.dumps(draw_boundary(mesh, chance, least, most)), encoding="utf-8")
        way = FILL_WAYS[(k // len(GROUNDS) + k) % len(FILL_WAYS)]
        surface = () if k % 4 == 3 else ("--surface", str(ground))
        call = ("fill", str(boundary), *surface, *way, "-o", "{out}/fill.obj", "--json")
        cases.append(Case(f"{k + 1:03} {name}", call))
    return cases


# ----------------------------------------------------------------------------------- database


def record_database(bench: Bench) -> dict[str, Fields]:
    """Learn all meshes of the shared folder with default options into one database.

    Meshes are given one by one, so that a run that was interrupted goes on where it stopped.
    """
    database = str(bench.work / f"learned-{bench.digest[:16]}.db")
    meshes = sorted((bench.data / "meshes").glob("*.obj"))
    progress = Progress("database", len(meshes))
    for mesh in meshes:
        run_for_text(bench, ["ingest", str(mesh), "--db", database, "--json"])
        progress.advance(mesh.name)
    items: dict[str, Fields] = {}
    held = json.loads(run_for_text(bench, ["meshes", "--db", database, "--json"]))["meshes"]
    for mesh in held:
        kept = {key: value for key, value in mesh.items() if key != "id" and "second" not in key}
        items[mesh["name"]] = {"document": hash_json(kept), "patterns": mesh["patterns"]}
    counts = json.loads(run_for_text(bench, ["stats", "--db", database, "--json"]))
    items["stats"] = counts
    for verb in ("meshes", "stats", "verify"):
        items[verb if verb != "stats" else "stats as text"] = run_case(
            bench, Case(verb, (verb, "--db", database))
        )
    return items


# --------------------------------------------------------------------------- recording, files


def make_part(part: str, list_cases: Callable[[Bench], list[Case]]) -> Callable[[Bench], Any]:
    """Make a part of a list of calls."""
    return lambda bench: run_cases(bench, part, list_cases(bench))


PARTS: dict[str, Callable[[Bench], dict[str, Fields]]] = {
    "queries": record_queries,
    "retopo": make_part("retopo", list_retopo),
    "features": make_part("features", list_features),
    "surfaces": make_part("surfaces", list_surfaces),
    "fills": make_part("fills", list_fills),
    "database": record_database,
}


def prepare_bench(shared: Path, work: Path, seed: int) -> Bench:
    """Find the code that will run, and a cache folder of its own."""
    environment = dict(os.environ)
    paths = [*filter(None, [environment.get("PYTHONPATH")]), str(ROOT)]
    environment |= {"PYTHONPATH": os.pathsep.join(paths), "PYTHONIOENCODING": "utf-8"}
    environment |= {"COLUMNS": "100", "NO_COLOR": "1", **dict.fromkeys(THREADS, "1")}
    asked = "import patterndb; print(patterndb.__file__)"
    found = subprocess.run(
        [sys.executable, "-c", asked], env=environment, cwd=work, capture_output=True, text=True,
        check=True,
    )  # fmt: skip
    code = Path(found.stdout.strip()).resolve().parents[1]
    digest = hash_code(code)
    print(f"code: {code}, digest {digest[:16]}", file=sys.stderr)
    environment.setdefault("PATTERNDB_CACHE", str(work / f"cache-{digest[:16]}"))
    bench = Bench(shared, work, seed, digest, environment)
    # The starter database and the complete family are made once, before anything is recorded.
    run_for_text(bench, ["query", "--sides", "3,5,4,6", "--limit", "1"])
    return bench


def hash_code(root: Path) -> str:
    """Hash the sources of all packages in a folder, and the database's schema."""
    packages = [path.parent for path in root.glob("*/__init__.py")]
    sources = [path for package in packages for path in package.rglob("*.py")]
    sources += root.glob("patterndb/_native*.so")
    total = hashlib.sha256()
    for path in sorted([*sources, *root.glob("schema.sql")]):
        total.update(f"{path.relative_to(root).as_posix()}\n".encode())
        total.update(path.read_bytes())
    return total.hexdigest()


def record_parts(out: Path, names: Iterable[str], bench: Bench) -> None:
    """Record parts into a file, beside those that it has."""
    document: dict[str, Any] = {}
    if out.exists():
        document = json.loads(out.read_text(encoding="utf-8"))
    for name in names:
        started = time.perf_counter()
        items = PARTS[name](bench)
        seconds = time.perf_counter() - started
        document[name] = {"about": describe_run(bench, seconds), "items": items}
        out.write_text(json.dumps(document, indent=1, sort_keys=True) + "\n", encoding="utf-8")
        print(f"{name}: {len(items)} items in {seconds:.0f} s", file=sys.stderr)


def describe_run(bench: Bench, seconds: float) -> Fields:
    """Describe what a part was recorded with."""
    return {
        "seed": bench.seed,
        "code": bench.digest,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "machine": f"{platform.machine()}, {os.cpu_count()} cores",
        "seconds": round(seconds, 1),
    }


# ---------------------------------------------------------------------------------- comparing


def compare_records(before: Path, after: Path, parts: Sequence[str]) -> int:
    """Print a line for each part and the items that differ; return how many parts do.

    parts: those to compare; all that either record has, and all that there are, if empty.
    """
    records = [json.loads(path.read_text(encoding="utf-8")) for path in (before, after)]
    unequal = 0
    for part in parts or PARTS:
        missing = [
            str(path) for path, one in zip((before, after), records, strict=True) if part not in one
        ]
        if missing:
            print(f"{part}: not recorded in {' and '.join(missing)}")
            unequal += 1
            continue
        first, second = (one[part] for one in records)
        for key in ("seed", "python", "numpy", "machine"):
            if first["about"][key] != second["about"][key]:
                print(f"{part}: recorded with another {key}", file=sys.stderr)
        names = sorted({*first["items"], *second["items"]})
        told = [
            line
            for name in names
            if (line := tell_difference(first["items"].get(name), second["items"].get(name), name))
        ]
        if told:
            unequal += 1
            print(f"{part}: {len(told)} of {len(names)} differ")
            for line in told[:LISTED]:
                print(f"    {line}")
            if len(told) > LISTED:
                print(f"    and {len(told) - LISTED} more")
        else:
            print(f"{part}: equal ({len(names)})")
    return unequal


def tell_difference(before: Fields | None, after: Fields | None, name: str) -> str:
    """Tell what differs between two states of an item; empty where nothing does."""
    if before is None or after is None:
        return f"{name}: only {'after' if before is None else 'before'}"
    told: list[str] = []
    for key in sorted({*before, *after}):
        old, new = before.get(key), after.get(key)
        if old == new:
            continue
        texts = [" / ".join(one) if isinstance(one, list) else str(one) for one in (old, new)]
        if any(re.fullmatch("[0-9a-f]{64}", text) for text in texts):
            told.append(key)
        else:
            told.append(f"{key} ({texts[0][:SHOWN]!r} -> {texts[1][:SHOWN]!r})")
    return f"{name}: {', '.join(told)}" if told else ""


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    verbs = parser.add_subparsers(dest="verb", required=True)
    recording = verbs.add_parser("record", help="record what the verbs make")
    recording.add_argument("out", type=Path, metavar="OUT.json")
    recording.add_argument("--shared", type=Path, default=ROOT.parent / "shared")
    recording.add_argument("--work", type=Path, help="keep databases and caches in this folder")
    recording.add_argument("--seed", type=int, default=1)
    comparing = verbs.add_parser("compare", help="compare two records")
    comparing.add_argument("before", type=Path, metavar="BEFORE.json")
    comparing.add_argument("after", type=Path, metavar="AFTER.json")
    for one in (recording, comparing):
        one.add_argument("--part", action="append", default=[], choices=PARTS, metavar="NAME")
    options = parser.parse_args()
    if options.verb == "compare":
        return min(compare_records(options.before, options.after, options.part), 1)
    shared: Path = options.shared.resolve()
    if not (shared / "data").is_dir():
        parser.error(f"there is no {shared / 'data'}; give --shared, a folder with data/meshes")
    with tempfile.TemporaryDirectory(prefix="unchanged-") as folder:
        work: Path = options.work or Path(folder)
        work.mkdir(parents=True, exist_ok=True)
        bench = prepare_bench(shared, work.resolve(), options.seed)
        record_parts(options.out, options.part or list(PARTS), bench)
    return 0


if __name__ == "__main__":
    sys.exit(main())
