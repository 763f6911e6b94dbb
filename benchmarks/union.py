"""A union lists what a merged database lists: random questions put to both.

    python benchmarks/union.py first.db second.db --questions 1000

The first is merged into a copy of the second, in a folder that is removed at the end, and both are
asked: random boundaries of 3 to 10 sides with reflex corners, strokes and loops, as
benchmarks/unchanged.py draws them, every third in the order "regular". A list is equal where its
first 50 fills are, in order, with patterns, frequencies, widths and quads. Tells what the first
question of each number of sides took, which loads and unites classes, and what the others took.
Ends with code 1 if a list differs.
"""

from __future__ import annotations

import argparse
import json
import random
import shutil
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from unchanged import draw_question

import patterndb
from patterndb.store import Database, DatabaseUnion
from query import fills
from query.batchline import parse_line

PAGE = 50


def ask(source: Database | DatabaseUnion, question: str, order: str) -> tuple[list[object], float]:
    """The fills of a question as JSON, and the seconds that they took."""
    boundary, strokes = parse_line(question)
    began = time.perf_counter()
    found = list(fills(source, boundary, strokes=strokes, limit=PAGE, order=order))
    seconds = time.perf_counter() - began
    return [fill.to_json() for fill in found], seconds


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("first", type=Path)
    parser.add_argument("second", type=Path)
    parser.add_argument("--questions", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=7)
    given = parser.parse_args()
    chance = random.Random(given.seed)
    work = Path(tempfile.mkdtemp())
    try:
        whole = Path(shutil.copy(given.second, work / "merged.db"))
        with Database(whole, "write") as database, Database(given.first) as first:
            added, replaced, _ = database.merge(first)
        print(f"merged: {added} meshes added, {replaced} replaced")
        taken: dict[tuple[str, bool], list[float]] = {}
        seen: set[int] = set()
        differ = listed = empty = 0
        with patterndb.open([given.first, given.second]) as union, Database(whole) as merged:
            for number in range(given.questions):
                drawn = draw_question(chance)
                question = json.dumps(drawn)
                order = "regular" if number % 3 == 2 else "artist"
                fresh = len(drawn["sides"]) not in seen
                seen.add(len(drawn["sides"]))
                mine, seconds = ask(union, question, order)
                taken.setdefault(("union", fresh), []).append(seconds)
                theirs, seconds = ask(merged, question, order)
                taken.setdefault(("merged", fresh), []).append(seconds)
                listed += len(theirs)
                empty += not theirs
                if mine != theirs:
                    differ += 1
                    print(f"differs: {question} {order}")
            patterns = sum(len(union.pattern_class(n)) for n in seen)
        print(
            f"{given.questions} questions, {listed:,} fills, {empty} lists without any, "
            f"{patterns:,} patterns asked: {differ} lists differ"
        )
        print("| ms, median and p95 | first of its number of sides | later |")
        print("| --- | ---: | ---: |")
        for name in ("union", "merged"):
            cells = [
                f"{1e3 * np.median(t):.1f}, {1e3 * np.quantile(t, 0.95):.1f}"
                for t in (taken[name, True], taken[name, False])
            ]
            print(f"| {name} | {' | '.join(cells)} |")
    finally:
        shutil.rmtree(work)
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
