"""What more meshes bring: how much of meshes that were not learned is known, and is proposed first.

    python benchmarks/learning_curve.py --db all.db --shared ../shared -o curve.svg
    python benchmarks/learning_curve.py --db all.db --deep deep.db --shared ../shared --hits 1

all.db has learned the meshes of ../shared/data/meshes at the default limits. The three splits of
benchmarks/recovery.py hold ten meshes out; of the other 72, in an order drawn, the first 10, 20, 40
and all are taken as if no others had been learned. Known is a held-out pattern that occurs in them:
as a share of the held-out patches, and of the held-out patterns, each of which counts once. Nothing
is learned anew for that: which meshes a pattern occurs in is in the database. deep.db: the same
meshes, or some of them, at deeper limits; held-out patches stay those of all.db.

--hits N: cut patches from the held-out meshes of N splits as recovery.py does, and ask databases of
these meshes for their boundaries, without strokes; hit@K is the share where the artist's own fill
is among the first K. Prints Markdown for RESULTS.md.
"""

from __future__ import annotations

import argparse
import contextlib
import itertools
import random
import shutil
import sqlite3
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from recovery import SEED, SHOWN, case_of, cut, scored, shared_program, splits

import patterndb
from viewer.paper import Page

#: Meshes that are taken as learned; the last of the 82 that are not held out.
SIZES = (10, 20, 40, 72)

#: Rows of the tables: numbers of sides and of irregular vertices, the last for all from it on.
SIDES = (3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13)
IRREGULAR = (0, 1, 2, 3, 4, 5, 6, 7)


@dataclass(frozen=True, slots=True)
class Occurrences:
    """What a database has of meshes.

    names: of meshes, by id. pattern, mesh, patches: (k,) int64 columns of the table occurrence.
    n_sides, n_irregular: (k,) int64 of these patterns.
    """

    names: dict[int, str]
    pattern: NDArray[np.int64]
    mesh: NDArray[np.int64]
    patches: NDArray[np.int64]
    n_sides: NDArray[np.int64]
    n_irregular: NDArray[np.int64]

    @classmethod
    def read(cls, path: Path) -> Occurrences:
        """Read them all."""
        with contextlib.closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as held:
            names = dict(held.execute("SELECT id, name FROM mesh").fetchall())
            rows = held.execute(
                "SELECT pattern_id, mesh_id, patches, n_sides, n_irregular "
                "FROM occurrence JOIN pattern ON pattern.id = pattern_id"
            )
            # By column as they come: a list of millions of rows would take gigabytes.
            flat = np.fromiter((n for row in rows for n in row), np.int64)
        columns = flat.reshape(-1, 5).T
        return cls(names, *(np.ascontiguousarray(column) for column in columns))

    def is_of(self, meshes: set[str]) -> NDArray[np.bool_]:
        """(k,) which rows are of meshes of these names."""
        ids = [number for number, name in self.names.items() if name in meshes]
        return np.isin(self.mesh, ids)


@dataclass(frozen=True, slots=True)
class Known:
    """Held-out patterns: how many patches they have, and whether they are known.

    patches: (p,) int64. n_sides, n_irregular: (p,) int64. known: (p,) bool.
    """

    patches: NDArray[np.int64]
    n_sides: NDArray[np.int64]
    n_irregular: NDArray[np.int64]
    known: NDArray[np.bool_]

    def share(self, chosen: NDArray[np.bool_], *, once: bool) -> float:
        """The known share of the chosen patterns' patches, or of the patterns."""
        weight = np.ones(len(self.known)) if once else self.patches
        return float((weight * self.known)[chosen].sum() / max(weight[chosen].sum(), 1))


def draw_meshes(folder: Path) -> tuple[list[list[Path]], list[list[str]]]:
    """The held-out meshes of each split, and the names of the others in the order drawn."""
    meshes = list(folder.glob("*.obj"))
    held = splits(meshes)
    drawn = sorted(mesh.name for mesh in meshes)
    random.Random(SEED).shuffle(drawn)
    return held, [[n for n in drawn if n not in {mesh.name for mesh in some}] for some in held]


def compare(asked: Occurrences, held: set[str], taught: Occurrences, learned: set[str]) -> Known:
    """What of the held-out meshes is known from the learned ones."""
    rows = asked.is_of(held)
    ids, first, place = np.unique(asked.pattern[rows], return_index=True, return_inverse=True)
    patches = np.zeros(len(ids), np.int64)
    np.add.at(patches, place, asked.patches[rows])
    return Known(
        patches,
        asked.n_sides[rows][first],
        asked.n_irregular[rows][first],
        np.isin(ids, taught.pattern[taught.is_of(learned)]),
    )


def pool(parts: Sequence[Known]) -> Known:
    """Put several splits together."""
    return Known(
        *(
            np.concatenate([getattr(part, name) for part in parts])
            for name in ("patches", "n_sides", "n_irregular", "known")
        )
    )


def write_rows(results: dict[str, Known], column: str, rows: Sequence[int]) -> None:
    """Print a table: a row a number of sides or of irregular vertices, a pair a database."""
    heads = "".join(f" {name}: patches | patterns |" for name in results)
    print(
        f"\n| {column} | held-out patterns |{heads}\n| ---: | ---: |" + " ---: |" * 2 * len(results)
    )
    for at, row in enumerate((*rows, None)):
        cells: list[str] = []
        for found in results.values():
            number: NDArray[np.int64] = getattr(found, column)
            is_last = at == len(rows) - 1
            chosen = number >= (0 if row is None else row)
            chosen &= (number == row) | (row is None or is_last)
            if not cells:
                cells.append(f"{chosen.sum():,}")
            cells += [f"{found.share(chosen, once=once):.1%}" for once in (False, True)]
        name = "all" if row is None else f"{row} and more" if at == len(rows) - 1 else row
        print(f"| {name} | {' | '.join(cells)} |")


def measure_hits(
    db: Path, shared: Path, held: Sequence[list[Path]], others: Sequence[list[str]]
) -> None:
    """Print hit@K by number of meshes learned."""
    program = shared_program(shared)
    print("\n| meshes | cases | " + " | ".join(f"hit@{k}" for k in SHOWN) + " | unknown |")
    print("| ---: | ---: |" + " ---: |" * (len(SHOWN) + 1), flush=True)
    patches = [cut(program, some) for some in held]
    for size in SIZES:
        total = None
        for some, names in zip(patches, others, strict=True):
            with tempfile.TemporaryDirectory() as folder:
                path = Path(shutil.copyfile(db, Path(folder) / "part.db"))
                with patterndb.open(path, "write") as database:
                    learned = set(names[:size])
                    database.remove([m.name for m in database.meshes() if m.name not in learned])
                    cases = [case_of(patch, program.rooted, database) for patch in some]
                    score = scored(database, cases, "artist", 0, program.rooted, max(SHOWN))
            total = score if total is None else total + score
        assert total is not None
        unknown = sum(not known for known in total.known) / len(total.known)
        cells = [f"{total.hit(k):.3f}" for k in SHOWN]
        print(f"| {size} | {len(total.ranks)} | {' | '.join(cells)} | {unknown:.3f} |", flush=True)


#: Of the picture, in points: its size, and where the axes lie.
WIDTH, HEIGHT = 460.0, 300.0
LEFT, RIGHT, BOTTOM, TOP = 52.0, 130.0, 40.0, 30.0

#: Classes with a line of their own in the picture, and its colours from light to dark.
DRAWN = (4, 6, 8, 10, 12)


def draw_curve(results: dict[int, Known], path: Path) -> None:
    """Draw the known share of held-out patterns by meshes learned, a line a number of sides."""
    page = Page(WIDTH, HEIGHT)
    sizes = list(results)
    across = np.log2(np.array(sizes) / sizes[0]) / np.log2(sizes[-1] / sizes[0])
    x = LEFT + across * (WIDTH - LEFT - RIGHT)

    def y_of(share: float) -> float:
        return BOTTOM + share * (HEIGHT - BOTTOM - TOP)

    def paint_line(points: list[tuple[float, float]], colour: str, width: float) -> None:
        pairs = np.array([[a, b, a] for a, b in itertools.pairwise(points)])
        page.polygons(pairs, line=colour, width=width)

    for tenth in range(0, 11, 2):
        y = y_of(tenth / 10)
        paint_line([(LEFT, y), (WIDTH - RIGHT, y)], "#dddddd", 0.5)
        page.text(LEFT - 6, y - 3, f"{tenth * 10} %", size=8, align="right")
    for size, at in zip(sizes, x.tolist(), strict=True):
        page.text(at, BOTTOM - 14, str(size), size=8, align="center")
    page.text((LEFT + WIDTH - RIGHT) / 2, BOTTOM - 28, "meshes learned", size=8, align="center")
    page.text(LEFT, HEIGHT - 18, "held-out patterns that are known, by sides", size=9, align="left")
    lowest = -np.inf
    for number, n_sides in reversed(list(enumerate(DRAWN))):
        shares = [r.share(r.n_sides == n_sides, once=True) for r in results.values()]
        shade = int(40 + 130 * number / (len(DRAWN) - 1))
        colour = f"#{shade:02x}{60 + shade // 3:02x}{210 - shade:02x}"
        points = [(a, y_of(share)) for a, share in zip(x.tolist(), shares, strict=True)]
        paint_line(points, colour, 1.6)
        label = f"{n_sides} sides, {100 * shares[-1]:.0f} %"
        # The more sides the less is known: from below, no label on the one before.
        lowest = max(points[-1][1] - 3, lowest + 10)
        page.text(points[-1][0] + 6, lowest, label, size=8, align="left")
    page.save(path)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--db", type=Path, required=True, help="has learned all meshes")
    parser.add_argument("--deep", type=Path, help="has learned them, or some, at deeper limits")
    parser.add_argument("--shared", type=Path, required=True, help="the folder of test data")
    parser.add_argument("--hits", type=int, default=0, help="splits of which patches are asked for")
    parser.add_argument("-o", "--output", type=Path, help="a picture of the curve, SVG or PNG")
    given = parser.parse_args()
    held, others = draw_meshes(given.shared / "data" / "meshes")
    names = [{mesh.name for mesh in some} for some in held]
    asked = Occurrences.read(given.db)
    pairs = list(zip(names, others, strict=True))
    curve = {
        size: pool([compare(asked, out, asked, set(rest[:size])) for out, rest in pairs])
        for size in SIZES
    }
    results = {str(size): found for size, found in curve.items()}
    if given.deep:
        deep = Occurrences.read(given.deep)
        known = set(deep.names.values())
        print(f"{len(known)} meshes at deeper limits.")
        results["deeper"] = pool([compare(asked, out, deep, set(rest)) for out, rest in pairs])
    write_rows(results, "n_sides", SIDES)
    write_rows(results, "n_irregular", IRREGULAR)
    if given.output:
        draw_curve(curve, given.output)
    if given.hits:
        measure_hits(given.db, given.shared, held[: given.hits], others[: given.hits])


if __name__ == "__main__":
    main()
