"""Relaxed fills: exactly those that all small disks make of a boundary, and never none."""

from __future__ import annotations

import os
import random
from collections.abc import Iterator
from functools import cache

import numpy as np
import pytest

import query
from patterndb.core.pattern import Pattern
from patterndb.core.patternclass import PatternClass
from patterndb.core.reduction import reduce_disk
from query import Boundary, Fill
from tests.support.query.cases import Source, code_of, read_reference_fills, small_disks
from tests.support.reference.code import Code, mirrored, rooted_code
from tests.support.reference.halfedge import as_complex, border_loop, fans

#: What relaxed matching lists: at most so many irregular vertices, and of them on the boundary.
MOST, MOST_ON_BOUNDARY = 4, 3


@cache
def laid_disks() -> dict[int, list[tuple[Code, tuple[int, ...], int, bool]]]:
    """By perimeter: every small disk begun at each boundary vertex, either way round.

    Its code from there, the quads at its boundary vertices from there on, its irregular interior
    vertices, and whether reducing it leaves a polychord that crosses itself.
    """
    found: dict[int, list[tuple[Code, tuple[int, ...], int, bool]]] = {}
    for disk in small_disks():
        pattern = Pattern.from_disk(reduce_disk(np.array(disk, np.int32)))
        for twin in (disk, mirrored(disk)):
            complex_ = as_complex(twin)
            vertex = fans(complex_)
            loop = border_loop(complex_, twin.index(-1))
            count = np.bincount([vertex[h] for h in complex_])
            rim = [int(count[vertex[h]]) for h in loop]
            on_rim = {vertex[h] for h in loop}
            irregular = sum(k != 4 for v, k in enumerate(count.tolist()) if v not in on_rim)
            for at, h in enumerate(loop):
                begun = tuple(rim[at:] + rim[:at])
                code = rooted_code(twin, h)
                found.setdefault(len(loop), []).append(
                    (code, begun, irregular, pattern.self_crossing)
                )
    return found


def expected(boundary: Boundary) -> tuple[set[Code], set[Code]]:
    """(codes that must be listed, codes that may be): fills of few irregular vertices."""
    targets = [2] * boundary.perimeter
    for start, count in zip(boundary.side_starts, boundary.corner_counts, strict=False):
        targets[start] = count
    must: set[Code] = set()
    may: set[Code] = set()
    for code, rim, irregular, crossing in laid_disks()[boundary.perimeter]:
        wrong = sum(k != target for k, target in zip(rim, targets, strict=True))
        if wrong <= MOST_ON_BOUNDARY and irregular + wrong <= MOST:
            (may if crossing else must).add(code)
    return must, may


def is_small(fill: Fill) -> bool:
    """Could it be one of the small disks?"""
    valence = fill.disk().valence()
    inner = valence[fill.perimeter :]
    return (
        len(inner) <= 4
        and all(3 <= v <= 5 for v in inner)
        and int(valence[: fill.perimeter].max()) <= 3
    )


def some_boundaries() -> Iterator[Boundary]:
    chance = random.Random(5)
    for n in (2, 3, 4, 5, 6):
        for _ in range(4):
            perimeter = chance.choice([8, 10] if n < 6 else [10])
            cuts = sorted(chance.sample(range(1, perimeter), n - 1))
            yield Boundary(np.diff([0, *cuts, perimeter]).tolist())


@pytest.mark.parametrize("boundary", list(some_boundaries()), ids=str)
def test_every_small_disk_with_few_irregular_vertices_is_listed(boundary: Boundary) -> None:
    nothing = PatternClass.from_patterns(boundary.n_sides, [])
    found = list(query.fills(nothing, boundary, limit=None, origins=("family",)))
    codes = [code_of(fill) for fill in found]
    assert len(set(codes)) == len(codes)
    must, may = expected(boundary)
    small = {code for code, fill in zip(codes, found, strict=True) if is_small(fill)}
    assert small >= must
    assert small <= must | may
    assert must


def test_the_complete_family_is_never_worse_than_fifteen_patterns() -> None:
    """The best fills of random boundaries beside those of the filler of Takayama et al. 2014."""
    fewer = rows = 0
    for boundary, reference in read_reference_fills():
        fill = query.best(PatternClass.from_patterns(boundary.n_sides, []), boundary)
        assert fill is not None
        assert fill.n_irregular <= reference
        fewer += fill.n_irregular < reference
        rows += 1
    assert rows == 249
    assert fewer >= 50


#: Random boundaries of each number of sides; benchmarks/RESULTS.md has 1,000.
OPTIMA_TRIED = int(os.environ.get("QUERY_OPTIMA", "150"))

#: Shares of boundaries of N sides, lengths 1 to 20, by the fewest irregular vertices that
#: valences 3 to 5 allow.
OPTIMA = {
    2: {2: 1.0},
    3: {1: 0.58, 3: 0.42},
    4: {0: 0.006, 2: 0.90, 3: 0.10},
    5: {1: 0.29, 2: 0.61, 3: 0.09, 4: 0.02},
    6: {1: 0.006, 2: 0.68, 3: 0.31, 4: 0.003},
    7: {2: 0.61, 3: 0.39, 4: 0.005},
    8: {2: 0.01, 3: 0.96, 4: 0.03},
}


@pytest.mark.parametrize("n", sorted(OPTIMA))
def test_optima_are_spread_as_they_are_known_to_be(n: int) -> None:
    chance = random.Random(n)
    nothing = PatternClass.from_patterns(n, [])
    tries = OPTIMA_TRIED
    counts: dict[int, int] = {}
    asked = 0
    while asked < tries:
        lengths = [chance.randint(1, 20) for _ in range(n)]
        if sum(lengths) % 2 or sum(lengths) < 4:
            continue
        asked += 1
        fill = query.best(nothing, lengths, valence=(3, 5), order="regular")
        assert fill is not None
        counts[fill.n_irregular] = counts.get(fill.n_irregular, 0) + 1
    shares = ", ".join(f"{t}: {100 * k / tries:.1f}" for t, k in sorted(counts.items()))
    print(f"| {n} | {shares} |")
    for irregular in {*counts, *OPTIMA[n]}:
        share = OPTIMA[n].get(irregular, 0.0)
        # Four standard errors of the sample, and of the 1,000 that the shares come from.
        spread = 4 * ((share * (1 - share) + 0.004) * (1 / tries + 1 / 1000)) ** 0.5
        assert abs(counts.get(irregular, 0) / tries - share) <= spread


def test_strict_fills_come_first_among_equals() -> None:
    found = list(query.fills(Source(), (3, 4, 4, 3, 4), limit=200, order="regular"))
    ranks = [(fill.n_irregular, fill.origin == "constructed", not fill.strict) for fill in found]
    assert ranks == sorted(ranks)
    assert any(fill.strict for fill in found)
    assert not all(fill.strict for fill in found)


@pytest.mark.parametrize("lengths", [(2, 1, 1), (2, 1, 1, 1, 1)], ids=str)
def test_a_side_of_one_edge_has_no_strict_fill_but_a_relaxed_one(lengths: tuple[int, ...]) -> None:
    boundary = Boundary(lengths)
    assert not list(query.fills(Source(), boundary, strict=True))
    fill = query.best(Source(), boundary)
    assert fill is not None
    assert (fill.n_irregular, fill.n_irregular_boundary) == (1, 1)
    assert fill.n_quads == len(lengths) // 2
    for cap in (0, 1):
        tables = query.fills(
            Source(), boundary, max_boundary_irregular=cap, origins=("learned", "family")
        )
        assert bool(list(tables)) == (cap == 1)


def test_reflex_corners_are_met() -> None:
    """A boundary like an L: three unit squares, the corner between them reflex."""
    boundary = Boundary((2, 1, 1, 1, 1, 2), ("convex",) * 3 + ("reflex",) + ("convex",) * 2)
    fill = query.best(Source(), boundary)
    assert fill is not None
    assert (fill.n_quads, fill.n_irregular, fill.strict) == (3, 0, True)


@pytest.mark.parametrize("perimeter", [4, 6, 8])
def test_no_boundary_goes_without(perimeter: int) -> None:
    for n in range(1, perimeter + 1):
        lengths = [1] * (n - 1) + [perimeter - n + 1]
        for kinds in (None, ["reflex"] * n, ["convex", "reflex"] * (n // 2) + ["convex"] * (n % 2)):
            fill = query.best(PatternClass.from_patterns(n, []), Boundary(lengths, kinds))
            assert fill is not None
    closed = Boundary.closed(perimeter)
    assert query.best(PatternClass.from_patterns(0, []), closed) is not None
