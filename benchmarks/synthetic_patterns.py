"""Make a large database of patterns that nobody learned: pairs of learned ones, joined at a side.

    python benchmarks/synthetic_patterns.py all.db --patterns 1000000 --db million.db
    python benchmarks/synthetic_patterns.py all.db --patterns 500000 --sides 12 --db twelve.db

Two convex patterns that have sides of one length are glued along these: the four corners there
become flat, so that the whole is convex and has the sides of both less four. What can be reduced
is, and what comes out twice is written once. Codes, columns and checksums are those of real
patterns, so that queries and ``verify`` take them as they take any; frequencies and examples are
made up, and patterns with reflex corners are those of the base alone. Written some at a time, as
meshes of so many patterns; prints, for each, how long a new pattern took.
"""

from __future__ import annotations

import argparse
import hashlib
import shutil
import time
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from patterndb._native.core.halfedge import next_border_edge
from patterndb.core import description as d
from patterndb.core.code import Code, canonical_code
from patterndb.core.halfedge import Int32Array
from patterndb.core.packing import pack, unpack_many
from patterndb.core.quadmesh import QuadMesh
from patterndb.core.reduction import reduce_disk
from patterndb.store import Database, Learned, LearningOptions, Provenance

#: Quads of a pattern that is joined to another, at most.
MOST_QUADS = 16

#: Ways in which two patterns are joined, at most: drawing them costs as much as joining them.
MOST_JOINS = 8

#: Patterns written in one step.
STEP = 100_000

#: Sides of what is made, where no number is given, as often as the base has patterns of as many.
SIDES = range(3, 17)

#: Pairs of patterns that are drawn at a time.
PAIRS = 4096


class Outline(NamedTuple):
    """A pattern to be joined to others.

    twin:  (4q,) int32 its half-edges.
    sides: the border half-edges of each side, from half-edge 0 on, where a code has its first
           corner.
    """

    twin: Int32Array
    sides: list[list[int]]

    @classmethod
    def of_code(cls, code: Code) -> Outline:
        """The pattern of a canonical code."""
        twin = code.astype(np.int32) - 1
        mesh = QuadMesh.from_twin(twin)
        count = mesh.valence()[mesh.vertex]
        sides: list[list[int]] = []
        h = 0
        while True:
            if count[h] != 2:
                sides.append([])
            sides[-1].append(h)
            h = next_border_edge(twin, h)
            if h == 0:
                return cls(twin, sides)


def join_pair(one: Outline, other: Outline, first_side: int) -> list[bytes]:
    """Packed codes of two patterns joined at up to MOST_JOINS pairs of sides of one length each.

    first_side: the side of the first to begin with, any number.
    """
    codes: list[bytes] = []
    n, shift = len(one.sides), len(one.twin)
    both = np.concatenate([one.twin, np.where(other.twin < 0, -1, other.twin + shift)])
    for turn in range(n * len(other.sides)):
        own, others = one.sides[(first_side + turn) % n], other.sides[turn // n]
        if len(own) != len(others) or len(codes) == MOST_JOINS:
            continue
        twin = both.astype(np.int32)
        across = shift + np.array(others[::-1])
        twin[own] = across
        twin[across] = own
        codes.append(pack(canonical_code(reduce_disk(twin))[0]))
    return codes


class Parts:
    """Convex patterns of a database, by their numbers of sides, to be joined."""

    def __init__(self, database: Database, chance: np.random.Generator) -> None:
        self._chance = chance
        self._classes: dict[int, NDArray[np.int64]] = {}
        codes: list[bytes] = []
        for n in (n for n in database.sides_histogram() if 3 <= n <= max(SIDES)):
            patterns = database.pattern_class(n)
            fit = (patterns.n_reflex == 0) & (patterns.n_quads <= MOST_QUADS)
            rows = np.flatnonzero(fit)
            if len(rows):
                self._classes[n] = np.arange(len(codes), len(codes) + len(rows))
                codes += [patterns.codes[row] for row in rows.tolist()]
        symbols, ends = unpack_many(codes)
        flat = symbols.astype(np.uint16)
        self._outlines = [Outline.of_code(flat[a:b]) for a, b in pairwise(ends.tolist())]

    def join(self, n_sides: int) -> list[bytes]:
        """Packed codes of PAIRS pairs of patterns of ``n_sides`` sides together, less four."""
        # One of few sides and one of many join as well as two of some.
        able = [n for n in self._classes if n_sides + 4 - n in self._classes]
        of_first = self._chance.choice(able, PAIRS)
        pairs = np.empty((PAIRS, 2), np.int64)
        for n in able:
            drawn = np.flatnonzero(of_first == n)
            pairs[drawn, 0] = self._chance.choice(self._classes[n], len(drawn))
            pairs[drawn, 1] = self._chance.choice(self._classes[n_sides + 4 - n], len(drawn))
        first = self._chance.integers(0, 1 << 20, PAIRS)
        outlines = self._outlines
        return [
            code
            for (one, other), side in zip(pairs.tolist(), first.tolist(), strict=True)
            for code in join_pair(outlines[one], outlines[other], side)
        ]


def make_patterns(
    parts: Parts, weights: dict[int, int], chance: np.random.Generator, n: int
) -> dict[bytes, int]:
    """About ``n`` packed codes, each with its number of sides."""
    sides = list(weights)
    often = np.array(list(weights.values())) / sum(weights.values())
    found: set[bytes] = set()
    # Each draw gives many of one number of sides; of all there shall be as many as asked for.
    wanted = dict(zip(sides, np.ceil(n * often).astype(int).tolist(), strict=True))
    for n_sides, count in wanted.items():
        own: set[bytes] = set()
        while len(own) < count:
            own.update(parts.join(n_sides))
        ordered = sorted(own)
        found.update(ordered[i] for i in chance.permutation(len(ordered))[:count].tolist())
    codes = sorted(found)
    # Reduction may take a side of quads away, and corners with it.
    corners = d.describe(codes).counts[:, d.N_CORNERS].tolist()
    return {code: k for code, k in zip(codes, corners, strict=True) if k in weights}


def write(database: Database, name: str, found: dict[bytes, int]) -> int:
    """Write patterns as those of one mesh; return how many are new."""
    codes = list(found)
    # A packed code has a byte and more a symbol, so these are as many quads as it has, or more.
    quads = [len(code) // 4 for code in codes]
    longest = pack([0] + [1] * max(quads))
    learned = Learned(
        quads_read=0,
        quads_used=0,
        basic=len(codes),
        side=0,
        convex=0,
        distinct=len(codes),
        codes=codes,
        sides=np.array(list(found.values()), np.int32),
        patches=np.tile(np.array([1, 0], np.int64), (len(codes), 1)),
        examples=[longest[:q] for q in quads],
    )
    sha256 = hashlib.sha256(name.encode()).hexdigest()
    return database.add_mesh(name, sha256, Provenance(), LearningOptions(), learned)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("base", type=Path, help="a database of learned patterns; it is copied")
    parser.add_argument("--patterns", type=int, required=True, help="of all, or of --sides alone")
    parser.add_argument("--sides", type=int, help="make patterns of so many sides alone")
    parser.add_argument("--db", type=Path, required=True, help="the database to make")
    parser.add_argument("--seed", type=int, default=7)
    given = parser.parse_args()
    if given.db.exists():
        parser.error(f"{given.db} is there already")
    shutil.copy(given.base, given.db)
    with Database(given.db, "write") as database:
        histogram = database.sides_histogram()
        weights = {n: histogram.get(n, 0) for n in SIDES}
        if given.sides is not None:
            weights = {given.sides: 1}
        held = sum(count for n, count in histogram.items() if given.sides in (None, n))
        # What is made of a base that is made so itself is not made of the same draws.
        chance = np.random.default_rng([given.seed, held])
        parts = Parts(database, chance)
        while held < given.patterns:
            begun = time.perf_counter()
            found = make_patterns(parts, weights, chance, min(STEP, given.patterns - held))
            made = time.perf_counter()
            new = write(database, f"synthetic from {held}", found)
            done = time.perf_counter()
            held += new
            print(
                f"{held:,} patterns; {new:,} new ones made in {made - begun:.0f} s, written in "
                f"{done - made:.1f} s, {1e6 * (done - made) / max(new, 1):.0f} us each",
                flush=True,
            )
    size = given.db.stat().st_size
    print(f"{size / 1e6:,.0f} MB")


if __name__ == "__main__":
    main()
