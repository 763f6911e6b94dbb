"""The artist's own choice: at which rank comes the fill that an artist made?

    python benchmarks/recovery.py --db all.db --shared ../shared

all.db has learned the meshes of ../shared/data/meshes. Ten of them at a time are taken out of a
copy, convex patches with irregular vertices are cut from those ten by ../shared/oracle/recovery.py,
and their boundaries are asked for: without strokes, and with one and two strands of the artist's
as strokes. There are three splits of ten meshes, disjoint and drawn with one seed; the default
order was chosen by what it does on the other meshes. hit@K is the share of boundaries among whose
first K fills is the artist's, quad for quad.

Where it is not, either the database without the ten meshes does not hold its pattern ("unknown";
the complete families or a construction may still make it), or the order has put it further down
("ranked lower"). Prints Markdown for RESULTS.md.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib.util
import io
import json
import random
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

import patterndb
from patterndb.core.pattern import Pattern
from patterndb.core.quadmesh import QuadMesh
from patterndb.core.reduction import reduce_disk
from query import Boundary, Fill, Stroke, fills

#: Seed, number and size of the splits.
SEED = "report"
SPLITS = 3
HELD_OUT = 10

ORDERS = ("artist", "regular")
STROKES = ("none", "one", "two")
SHOWN = (1, 5, 20)

#: Misses are told apart at this rank.
PAGE = 5

#: Fills that are looked through for the artist's.
LIMIT = 100

#: The code of a fill from the first edge of its first side, given quads and sides as lists.
Rooted = Callable[[list[list[int]], list[list[int]]], object]


@dataclass(frozen=True, slots=True)
class Case:
    """A boundary cut from a mesh that the database has not learned.

    wanted: code of the artist's fill; known: does the database hold its pattern?
    """

    boundary: Boundary
    strokes: tuple[Stroke, ...]
    n_quads: int
    wanted: object
    known: bool


@dataclass(slots=True)
class Score:
    """What became of cases.

    ranks: from 0, of the artists' fills; None where they are not listed. known: see Case.
    seconds: spent on the queries.
    """

    ranks: list[int | None] = field(default_factory=list)
    known: list[bool] = field(default_factory=list)
    seconds: float = 0.0

    def __add__(self, other: Score) -> Score:
        return Score(
            self.ranks + other.ranks, self.known + other.known, self.seconds + other.seconds
        )

    def hit(self, k: int) -> float:
        """The share of cases whose fill is among the first k."""
        return sum(rank is not None and rank < k for rank in self.ranks) / len(self.ranks)

    def missed(self, k: int, known: bool) -> float:
        """The share of cases whose fill is not, of those with or without a known pattern."""
        pairs = zip(self.ranks, self.known, strict=True)
        return sum(held == known and (r is None or r >= k) for r, held in pairs) / len(self.ranks)

    def row(self, *heads: object) -> str:
        """A line of the table."""
        shares = [*map(self.hit, SHOWN), self.missed(PAGE, False), self.missed(PAGE, True)]
        cells = [*map(str, heads), str(len(self.ranks)), *(f"{share:.3f}" for share in shares)]
        return f"| {' | '.join(cells)} |"


def shared_program(folder: Path) -> ModuleType:
    """oracle/recovery.py of the shared folder."""
    sys.path.insert(0, str(folder / "oracle"))
    spec = importlib.util.spec_from_file_location("cases", folder / "oracle" / "recovery.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def splits(meshes: Iterable[Path]) -> list[list[Path]]:
    """Disjoint sets of meshes to be held out."""
    drawn = sorted(meshes, key=lambda mesh: mesh.name)
    random.Random(SEED).shuffle(drawn)
    return [sorted(drawn[i * HELD_OUT : (i + 1) * HELD_OUT]) for i in range(SPLITS)]


def cut(program: ModuleType, meshes: Sequence[Path]) -> list[dict[str, Any]]:
    """The patches that the shared program cuts from meshes."""
    lines = io.StringIO()
    with contextlib.redirect_stdout(lines):
        program.make([str(mesh) for mesh in meshes])
    return [json.loads(line) for line in lines.getvalue().splitlines()]


def case_of(patch: dict[str, Any], rooted: Rooted, database: patterndb.Database) -> Case:
    pattern = Pattern.from_disk(reduce_disk(QuadMesh.from_quads(patch["quads"]).twin))
    return Case(
        boundary=Boundary(patch["sides"]),
        strokes=tuple(Stroke(tuple(start), tuple(end)) for start, end in patch["strokes"]),
        n_quads=len(patch["quads"]),
        wanted=rooted(patch["quads"], patch["side_vertices"]),
        known=bool((database.pattern_class(pattern.n_sides).ids == pattern.id).any()),
    )


def rank(case: Case, found: Iterable[Fill], rooted: Rooted) -> int | None:
    """The place of the artist's fill in a list."""
    for place, fill in enumerate(found):
        if fill.n_quads == case.n_quads:
            sides = [side.tolist() for side in fill.sides()]
            if rooted(fill.quads.tolist(), sides) == case.wanted:
                return place
    return None


def scored(
    database: patterndb.Database,
    cases: Sequence[Case],
    order: str,
    n_strokes: int,
    code: Rooted,
    limit: int = LIMIT,
) -> Score:
    """Ask for all cases, with so many of their strokes, and look through so many fills."""
    score = Score()
    for case in cases:
        begun = time.perf_counter()
        strokes = case.strokes[:n_strokes]
        found = list(fills(database, case.boundary, strokes=strokes, order=order, limit=limit))
        score.seconds += time.perf_counter() - begun
        score.ranks.append(rank(case, found, code))
        score.known.append(case.known)
    return score


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--db", type=Path, required=True, help="has learned all meshes")
    parser.add_argument("--shared", type=Path, required=True, help="the folder of test data")
    arguments = parser.parse_args()
    program = shared_program(arguments.shared)
    heads = [f"hit@{k}" for k in SHOWN] + [f"unknown, not @{PAGE}", f"ranked lower, not @{PAGE}"]
    print(f"| held out | order | strokes | cases | {' | '.join(heads)} |")
    print("| --- | --- | --- | ---: |" + " ---: |" * len(heads), flush=True)
    asked: list[tuple[str, int]] = [(order, n) for order in ORDERS for n in range(len(STROKES))]
    pooled = dict.fromkeys(asked, Score())
    for number, held in enumerate(splits((arguments.shared / "data" / "meshes").glob("*.obj")), 1):
        patches = cut(program, held)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(shutil.copyfile(arguments.db, Path(folder) / "without.db"))
            with patterndb.open(path, "write") as database:
                database.remove([mesh.name for mesh in held])
                cases = [case_of(patch, program.rooted, database) for patch in patches]
                for order, n in asked:
                    score = scored(database, cases, order, n, program.rooted)
                    print(score.row(f"split {number}", order, STROKES[n]), flush=True)
                    pooled[order, n] += score
    for (order, n), score in pooled.items():
        print(score.row("all", order, STROKES[n]))
    count = sum(len(score.ranks) for score in pooled.values())
    seconds = sum(score.seconds for score in pooled.values())
    print(f"\n{count:,} queries of up to {LIMIT} fills, {seconds / count * 1e3:.0f} ms each.")


if __name__ == "__main__":
    main()
