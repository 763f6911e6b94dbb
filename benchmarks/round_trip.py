"""Are the quads of a fill read as the pattern, widths and orientation that made them?

    python benchmarks/round_trip.py --count 20000 --seed 1

Fills of the starter database, or of --db, for boundaries with 0 to 12 sides, as many of each. Half
are listed by random boundaries, reflex corners among them; half are random patterns, expanded by
random widths. The inner vertices are numbered another way and the quads stand in another order
before they are recognised. A line for each number of sides, and one for all: fills, those with a
polychord that crosses itself and is wider than 1, those with irregular vertices on the boundary,
and differences.
"""

from __future__ import annotations

import argparse
import random
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import patterndb
from patterndb.core.pattern import Pattern
from patterndb.core.patternclass import PatternClass
from query import Boundary, Fill, fills
from query.boundary import CornerKind
from query.expand import expand_pattern
from query.orientation import list_distinct_orientations
from query.recognition import is_mesh, read_fill

MOST_SIDES = 12

#: Fills that are taken of one boundary, out of that many times as many.
TAKEN, LISTED = 12, 4

#: Edges of a side, quads of a fill, and the greatest width of a polychord.
LONGEST, MOST_QUADS, WIDEST = 9, 2000, 4

KINDS: dict[int, CornerKind] = {1: "convex", 3: "reflex"}


def draw_boundary(chance: random.Random, n_sides: int) -> Boundary:
    """Draw a boundary that quads can fill."""
    if n_sides == 0:
        return Boundary.closed(2 * chance.randint(2, LONGEST))
    lengths = [chance.randint(1, LONGEST) for _ in range(n_sides)]
    lengths[0] += sum(lengths) % 2 + 2 * (sum(lengths) < 4)
    kinds: list[CornerKind] = ["convex"] * n_sides
    if chance.random() < 0.25:
        kinds[chance.randrange(n_sides)] = "reflex"
    return Boundary(lengths, kinds)


def list_some(
    db: patterndb.Database, chance: random.Random, n_sides: int
) -> Iterator[tuple[Fill, Boundary]]:
    """List fills of random boundaries, without end."""
    while True:
        boundary = draw_boundary(chance, n_sides)
        found = list(fills(db, boundary, limit=LISTED * TAKEN))
        for fill in chance.sample(found, min(TAKEN, len(found))):
            yield fill, boundary


def narrow(pattern: Pattern) -> Pattern | None:
    """The pattern of which another is a widened copy, or the pattern itself; None where it is no
    boundary's."""
    if any(corner not in KINDS for corner in pattern.corners):
        return None
    if not pattern.self_crossing:
        return pattern
    wide = expand_pattern(pattern, [2] * pattern.n_chords)
    return read_fill(wide.quads, bound(wide), "").pattern if is_mesh(wide.quads) else None


def bound(fill: Fill) -> Boundary:
    """The boundary that an expanded pattern fills strictly."""
    if fill.pattern.n_sides == 0:
        return Boundary.closed(fill.perimeter)
    disk = fill.disk()
    return Boundary(fill.lengths, [KINDS[k] for k in disk.valence()[disk.corners].tolist()])


def expand_some(patterns: PatternClass, chance: random.Random) -> Iterator[tuple[Fill, Boundary]]:
    """Expand random patterns of a class by random widths, without end; those that cross themselves
    are as many as the others, where there are any."""
    crossing = np.flatnonzero(patterns.self_crossing).tolist()
    while True:
        row = chance.randrange(len(patterns))
        if crossing and chance.random() < 0.5:
            row = chance.choice(crossing)
        pattern = narrow(patterns.pattern(row))
        if pattern is None:
            continue
        widths = [chance.randint(1, WIDEST) for _ in range(pattern.n_chords + pattern.n_loops)]
        turn = chance.choice(list_distinct_orientations(pattern))
        made = expand_pattern(pattern, widths, rotation=turn.rotation, mirrored=turn.mirrored)
        if made.n_quads <= MOST_QUADS and is_mesh(made.quads):
            yield made, bound(made)


def shuffle_quads(fill: Fill, chance: random.Random) -> np.ndarray:
    """The quads in another order, with other numbers of the inner vertices."""
    name = np.arange(fill.n_vertices)
    inner = name[fill.perimeter :].tolist()
    chance.shuffle(inner)
    name[fill.perimeter :] = inner
    order = list(range(fill.n_quads))
    chance.shuffle(order)
    return name[fill.quads][order]


def differs(fill: Fill, boundary: Boundary, chance: random.Random) -> bool:
    """Are the quads read as anything else than what made them?"""
    found = read_fill(shuffle_quads(fill, chance), boundary, fill.origin)
    return (found.pattern, found.widths, found.rotation, found.mirrored, found.n_irregular) != (
        fill.pattern, fill.widths, fill.rotation, fill.mirrored, fill.n_irregular
    )  # fmt: skip


def main() -> None:
    """Make the fills, and count differences."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--count", type=int, default=20_000, help="fills in all")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--db", type=Path, help="another database than the starter")
    given = parser.parse_args()
    chance = random.Random(given.seed)
    total = np.zeros(4, np.int64)
    print("| sides | fills | crossing, wide | off the corners | differences |")
    print("| ---: | ---: | ---: | ---: | ---: |")
    with patterndb.open(given.db) if given.db else patterndb.open() as db:
        for n_sides in range(MOST_SIDES + 1):
            share = len(range(n_sides, given.count, MOST_SIDES + 1))
            ways = [list_some(db, chance, n_sides), expand_some(db.pattern_class(n_sides), chance)]
            row = np.zeros(4, np.int64)
            for number in range(share):
                fill, boundary = next(ways[number % 2])
                crosses = fill.pattern.polychords().crosses_itself
                row += (
                    1,
                    any(w > 1 and c for w, c in zip(fill.widths, crosses, strict=True)),
                    not fill.strict,
                    wrong := differs(fill, boundary, chance),
                )
                if wrong:
                    print(f"differs: {fill.pattern.name} {fill.widths} of {boundary}")
            total += row
            print(f"| {n_sides} | " + " | ".join(f"{k:,}" for k in row.tolist()) + " |", flush=True)
    print("| all | " + " | ".join(f"{k:,}" for k in total.tolist()) + " |")
    print(f"{total[0]:,} fills, differences {total[3]:,}")


if __name__ == "__main__":
    main()
