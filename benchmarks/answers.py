"""Every boundary is answered: random boundaries of 0 to 34 sides, and what they get.

    python benchmarks/answers.py --db all.db --boundaries 100000

Lengths are 1 to 20, corners convex, perimeters even and at least 4; as many boundaries of each
number of sides. The first fill of the default order is checked by code that shares nothing with
the library: quads, vertex numbers, a disk, sides with the lengths asked for, irregular vertices
counted anew. Prints a Markdown table; ends with code 1 if a boundary has no fill or a fill is
wrong. With --jobs the boundaries are shared out to processes.
"""

from __future__ import annotations

import argparse
import random
import sys
import time
from collections import Counter, defaultdict
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

import patterndb
from query import Boundary, Fill, best

MOST_SIDES = 34
LONGEST = 20


def boundary(chance: random.Random, n: int) -> Boundary:
    """A random boundary of n sides."""
    while True:
        lengths = [chance.randint(1, LONGEST) for _ in range(max(n, 1))]
        if sum(lengths) >= 4 and sum(lengths) % 2 == 0:
            return Boundary(lengths, () if n == 0 else None)


def fault(asked: Boundary, fill: Fill) -> str | None:
    """What is wrong with a fill, or None."""
    quads = np.asarray(fill.quads)
    perimeter = sum(asked.lengths)
    if quads.ndim != 2 or quads.shape[1] != 4 or (np.diff(np.sort(quads), axis=1) == 0).any():
        return "not all quads"
    used = np.unique(quads)
    if len(used) != fill.n_vertices or used[-1] != fill.n_vertices - 1:
        return "vertex numbers have gaps"
    tails, heads = quads.ravel(), np.roll(quads, -1, axis=1).ravel()
    way = tails.astype(np.int64) * fill.n_vertices + heads
    back = heads.astype(np.int64) * fill.n_vertices + tails
    if len(np.unique(way)) != len(way):
        return "an edge is used twice in one direction"
    border = ~np.isin(way, back)
    order = np.argsort(tails[border])
    ring = np.arange(perimeter)
    if not (
        np.array_equal(tails[border][order], ring)
        and np.array_equal(heads[border][order], (ring + 1) % perimeter)
    ):
        return "the border is not the boundary"
    edges = (len(way) + perimeter) // 2
    if fill.n_vertices - edges + len(quads) != 1:
        return "no disk by Euler's sum"
    # One piece: quads reached over shared edges from the first.
    place = {int(edge): h for h, edge in enumerate(way)}
    reached, ahead = {0}, [0]
    while ahead:
        q = ahead.pop()
        for h in range(4 * q, 4 * q + 4):
            other = place.get(int(back[h]))
            if other is not None and other // 4 not in reached:
                reached.add(other // 4)
                ahead.append(other // 4)
    if len(reached) != len(quads):
        return "more than one piece"
    counts = np.bincount(quads.ravel())
    wanted = np.full(fill.n_vertices, 4)
    wanted[:perimeter] = 2
    if asked.corners:
        starts = np.r_[0, np.cumsum(asked.lengths)[:-1]]
        wanted[starts] = [1 if kind == "convex" else 3 for kind in asked.corners]
    wrong = counts != wanted
    if (int(wrong.sum()), int(wrong[:perimeter].sum())) != (
        fill.n_irregular,
        fill.n_irregular_boundary,
    ):
        return "irregular vertices are not as many as it says"
    if (
        fill.quads.shape[0] != fill.n_quads
        or tuple(len(s) - 1 for s in fill.sides()) != asked.lengths
    ):
        return "sides of other lengths"
    return None


Row = tuple[int, str, int, str | None, float]


def answer(db: Path | None, seed: int, n: int, count: int) -> list[Row]:
    """(sides, kind of fill, irregular vertices, fault, seconds) of each of ``count`` boundaries."""
    chance = random.Random(f"{seed} {n}")
    rows: list[Row] = []
    with patterndb.open(db) as database:
        for _ in range(count):
            asked = boundary(chance, n)
            begin = time.perf_counter()
            fill = best(database, asked)
            seconds = time.perf_counter() - begin
            if fill is None:
                rows.append((n, "none", 0, f"no fill for {asked.lengths}", seconds))
                continue
            if fill.origin == "constructed":
                kind = "constructed"
            else:
                kind = "strict" if fill.strict else "relaxed"
            wrong = fault(asked, fill)
            note = None if wrong is None else f"{asked.lengths}: {wrong}"
            rows.append((n, kind, fill.n_irregular, note, seconds))
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--db", type=Path, help="default: the starter database")
    parser.add_argument("--boundaries", type=int, default=3_500, help="1000000 takes hours")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1)
    given = parser.parse_args()
    each = -(-given.boundaries // (MOST_SIDES + 1))
    sides = range(MOST_SIDES + 1)
    with ProcessPoolExecutor(given.jobs) as pool:
        asked = [pool.submit(answer, given.db, given.seed, n, each) for n in sides]
        rows = [row for future in asked for row in future.result()]
    kinds = ("strict", "relaxed", "constructed", "none")
    print(
        "| N | boundaries | strict | relaxed | constructed | none | irregular: mean - (N - 4) |"
        " fewest | most | ms: median | p99 |"
    )
    print("| ---: " * 11 + "|")
    by_sides: dict[int, list[Row]] = defaultdict(list)
    for row in rows:
        by_sides[row[0]].append(row)
    for n, of in by_sides.items():
        count = Counter(row[1] for row in of)
        irregular = np.array([row[2] for row in of if row[1] != "none"])
        ms = 1e3 * np.array([row[4] for row in of])
        print(
            f"| {n} | {len(of):,} | "
            + " | ".join(f"{count[kind]:,}" for kind in kinds)
            + f" | {irregular.mean() - (n - 4):.2f} | {irregular.min()} | {irregular.max()}"
            f" | {np.median(ms):.1f} | {np.quantile(ms, 0.99):.0f} |"
        )
    total = Counter(row[1] for row in rows)
    print(f"\nof {len(rows):,}: " + ", ".join(f"{kind} {total[kind]:,}" for kind in kinds))
    many = np.array([row[2] - row[0] for row in rows if row[0] >= 9])
    print(f"9 to {MOST_SIDES} sides: mean number of irregular vertices N {many.mean():+.2f}")
    wrong = [row[3] for row in rows if row[3] is not None]
    print(f"unanswered or wrong: {len(wrong)}")
    for note in wrong[:10]:
        print(f"  {note}")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
