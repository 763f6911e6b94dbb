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
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from patterndb.core import description as d
from patterndb.core.code import Code, border_count, code_starts, smallest_code
from patterndb.core.halfedge import Int32Array, fans, next_border_edge, next_edge
from patterndb.core.packing import pack, pack_many, unpack_many
from patterndb.core.reduction import NEVER_FULL, dissolve, reduction_work
from patterndb.store import Database, Learned, LearningOptions, Provenance
from patterndb.system.kernels import kernel

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


@kernel
def join_pairs(
    flat: Code,
    ends: NDArray[np.int64],
    pairs: NDArray[np.int64],
    first_side: NDArray[np.int64],
    codes: Code,
    code_ends: NDArray[np.int64],
) -> int:
    """Join pairs (k, 2) of patterns, numbers into the codes ``flat[ends[i]:ends[i + 1]]``, at up to
    MOST_JOINS pairs of sides of one length each; write canonical codes, return how many.

    first_side: (k,) the sides of the first to begin with, any numbers.
    """
    n = 0
    for k in range(len(pairs)):
        one = decode_code(flat[ends[pairs[k, 0]] : ends[pairs[k, 0] + 1]])
        other = decode_code(flat[ends[pairs[k, 1]] : ends[pairs[k, 1] + 1]])
        loop, start = list_sides(one)
        other_loop, other_start = list_sides(other)
        sides = len(start) - 1
        joins = 0
        for turn in range(sides * (len(other_start) - 1)):
            s = (first_side[k] + turn) % sides
            t = turn // sides
            length = start[s + 1] - start[s]
            if joins == MOST_JOINS or other_start[t + 1] - other_start[t] != length:
                continue
            joins += 1
            twin = np.empty(len(one) + len(other), np.int32)
            twin[: len(one)] = one
            for h in range(len(other)):
                twin[len(one) + h] = other[h] + len(one) if other[h] >= 0 else -1
            for j in range(length):
                h = loop[start[s] + j]
                g = len(one) + other_loop[other_start[t + 1] - 1 - j]
                twin[h] = g
                twin[g] = h
            code = find_code(reduce_joined(twin))
            codes[code_ends[n] : code_ends[n] + len(code)] = code
            code_ends[n + 1] = code_ends[n] + len(code)
            n += 1
    return n


@kernel
def decode_code(code: Code) -> Int32Array:
    """The half-edges of a code."""
    twin = np.empty(len(code), np.int32)
    for h in range(len(code)):
        twin[h] = np.int32(code[h]) - 1
    return twin


@kernel
def list_sides(twin: Int32Array) -> tuple[Int32Array, NDArray[np.int64]]:
    """The border from half-edge 0, where a code has its first corner, and where sides begin."""
    loop = np.empty(len(twin), np.int32)
    start = np.empty(len(twin) + 1, np.int64)
    edges = 0
    sides = 0
    h = 0
    while True:
        if border_count(twin, h) != 2:
            start[sides] = edges
            sides += 1
        loop[edges] = h
        edges += 1
        h = next_border_edge(twin, h)
        if h == 0:
            break
    start[sides] = edges
    return loop[:edges], start[: sides + 1]


@kernel
def reduce_joined(twin: Int32Array) -> Int32Array:
    """As :func:`patterndb.core.reduction.reduce_disk`."""
    vertex, n_vertices = fans(twin)
    count = np.zeros(n_vertices, np.int32)
    for h in range(len(twin)):
        count[vertex[h]] += 1
    full = count.copy()
    for h in range(len(twin)):
        if twin[h] < 0:
            full[vertex[h]] = NEVER_FULL
            full[vertex[next_edge(h)]] = NEVER_FULL
    work = reduction_work(n_vertices, len(twin) // 4)
    m, _ = dissolve(len(twin) // 4, twin, vertex, count, full, work)
    return work.reduced[: 4 * m].copy()


@kernel
def find_code(twin: Int32Array) -> Code:
    """As :func:`patterndb.core.code.canonical_code`, the code alone."""
    q = len(twin) // 4
    starts = np.empty(4 * q, np.int32)
    n_starts = code_starts(twin, starts)
    number = np.empty(q, np.int32)
    entry = np.empty(q, np.int32)
    order = np.empty(q, np.int32)
    own = np.zeros(4 * q, np.uint16)
    other = np.zeros(4 * q, np.uint16)
    smallest_code(twin, q, starts, n_starts, False, own, number, entry, order)
    smallest_code(twin, q, starts, n_starts, True, other, number, entry, order)
    for i in range(4 * q):
        if own[i] != other[i]:
            return own if own[i] < other[i] else other
    return own


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
        symbols, self._ends = unpack_many(codes)
        self._flat = symbols.astype(np.uint16)

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
        most = PAIRS * MOST_JOINS
        codes = np.empty(most * 8 * MOST_QUADS, np.uint16)
        ends = np.zeros(most + 1, np.int64)
        first = self._chance.integers(0, 1 << 20, PAIRS)
        n = join_pairs(self._flat, self._ends, pairs, first, codes, ends)
        return pack_many(codes[: ends[n]], ends[: n + 1])


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
