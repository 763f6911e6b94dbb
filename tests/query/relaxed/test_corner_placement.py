"""Tables of marked patterns: every row expands to what it says, none twice, in order, and kept."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from patterndb._native.core.code import rooted_code
from patterndb.core.quadmesh import QuadMesh
from query import Boundary
from query.errors import InvalidQueryError, QueryCancelledError
from query.expand import expand_marked
from query.listing.table import get_relaxed_table
from query.orientation import Orientation
from query.relaxed.corner_placement import (
    CornerSites,
    MarkedClass,
    load_marked_family,
    mark_patterns,
)
from query.relaxed.family import load_family
from tests.support.query.cases import small_class
from tests.support.query.relaxed import forget_families, irregular, own_cache


@pytest.fixture(autouse=True, scope="module")
def cache_folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """One cache folder for the module, so that nothing is left in the user's."""
    with own_cache(tmp_path_factory.mktemp("cache")) as folder:
        yield folder


def foretold(marked: MarkedClass, row: int, boundary: Boundary, o: Orientation) -> tuple[int, int]:
    """What the columns of a row say of a boundary: irregular vertices in all, and on it."""
    n = marked.n_sides
    counts = marked.counts[row].tolist()
    asked = boundary.corner_counts or (2,)
    off = 0
    for i in range(n):
        # Mirrored, boundary side i is walked from the end of the pattern's side.
        mark = (o.rotation - i + 1) % n if o.mirrored else (o.rotation + i) % n
        off += counts[mark] != asked[i]
    return int(marked.cost[row]) + off, int(marked.n_unmarked[row]) + off


@pytest.mark.parametrize(("n_sides", "free"), [(1, True), (1, False), (2, False), (3, False)])
def test_every_row_expands_to_what_its_columns_say(n_sides: int, free: bool) -> None:
    chance = random.Random(5)
    marked = load_marked_family(n_sides, free=free)
    rows = list(range(len(marked)))
    for row in rows if len(rows) < 150 else chance.sample(rows, 150):
        widths = [chance.randint(1, 3) for _ in marked.chords(row)]
        o = Orientation(chance.random() < 0.5, chance.randrange(n_sides))
        fill = expand_marked(marked, row, widths, o)
        boundary = Boundary.closed(*fill.lengths) if free else Boundary(fill.lengths)
        inside, on_boundary = irregular(boundary, fill.quads, fill.n_vertices)
        assert (inside + on_boundary, on_boundary) == foretold(marked, row, boundary, o)
        assert inside + on_boundary <= marked.most
        strands = [sum(widths[s] for s in side) for side in marked.sides(row)]
        assert sorted(strands) == sorted(fill.lengths)
        for chord in range(fill.pattern.n_chords):
            mine = [w for w, c in zip(widths, marked.chords(row), strict=True) if c == chord]
            assert fill.widths[chord] == sum(mine) >= 1


@pytest.mark.parametrize("n_sides", [2, 4, 7])
def test_systems_are_those_of_the_labels(n_sides: int) -> None:
    marked = load_marked_family(n_sides)
    assert len({j.tobytes() for j in marked.joins}) == len(marked.joins)
    for row in random.Random(6).sample(range(len(marked)), 200):
        sides = marked.sides(row)
        where: dict[int, list[int]] = {}
        for s, strands in enumerate(sides):
            for strand in strands:
                where.setdefault(strand, []).append(s)
        assert list(where) == list(range(len(marked.chords(row))))
        joins = np.zeros((n_sides, n_sides), np.int64)
        for i, j in where.values():
            joins[i, j] += 1
            joins[j, i] += i != j
        turn, reflected = int(marked.rotation[row]), bool(marked.reflected[row])
        to = [(turn - i if reflected else turn + i) % n_sides for i in range(n_sides)]
        seen = joins[np.ix_(to, to)]
        s = marked.signature[row]
        assert (seen == marked.joins[s]).all()
        assert [len(sides[i]) for i in to] == marked.lengths[s].tolist()
        # It is the smallest of all its images.
        upper = np.triu_indices(n_sides)
        for turn in range(n_sides):
            for sign in (1, -1):
                to = [(turn + sign * i) % n_sides for i in range(n_sides)]
                assert tuple(joins[np.ix_(to, to)][upper]) >= tuple(seen[upper])


@pytest.mark.parametrize("n_sides", [1, 3, 4, 6])
def test_in_order(n_sides: int) -> None:
    marked = load_marked_family(n_sides)
    keys = [
        (
            int(marked.cost[row]),
            not marked.strict[row],
            len(marked.chords(row)),
            int(marked.patterns.ids[marked.pattern[row]]),
            marked.label[marked.label_start[row] : marked.label_start[row + 1]].tolist(),
        )
        for row in range(len(marked))
    ]
    assert keys == sorted(keys)


def test_strict_rows_are_the_patterns_themselves() -> None:
    patterns = load_family()
    for n_sides in (1, 2, 5, 8):
        marked = load_marked_family(n_sides)
        rows = np.flatnonzero(marked.strict)
        ids = marked.patterns.ids[marked.pattern[rows]]
        assert sorted(ids.tolist()) == sorted(patterns.ids[patterns.n_sides == n_sides].tolist())
        for row in rows[:: len(rows) // 20 + 1].tolist():
            pattern = marked.patterns.pattern(int(marked.pattern[row]))
            assert tuple(map(tuple, marked.sides(row))) == pattern.label
            assert tuple(marked.counts[row].tolist()) == pattern.corners
            assert (marked.start_edge[row], marked.start_strand[row]) == (0, 0)


@pytest.mark.parametrize(("n_sides", "free"), [(2, False), (3, False), (4, False), (1, True)])
def test_no_row_is_the_image_of_another(n_sides: int, free: bool) -> None:
    marked = load_marked_family(n_sides, most=4 if free or n_sides == 2 else 3, free=free)
    seen: set[tuple[tuple[int, ...], tuple[int, ...]]] = set()
    for row in range(len(marked)):
        if marked.patterns.pattern(int(marked.pattern[row])).self_crossing:
            continue
        fill = expand_marked(marked, row, [2] * len(marked.chords(row)), Orientation(False, 0))
        at = np.cumsum((0, *fill.lengths[:-1])).tolist()
        p = sum(fill.lengths)
        images: list[tuple[tuple[int, ...], tuple[int, ...]]] = []
        for mirrored in (False, True):
            quads = fill.quads[:, ::-1] if mirrored else fill.quads
            twin = QuadMesh.from_quads(quads).twin
            q = len(quads)
            border = np.flatnonzero(twin < 0)
            start_of = dict(zip(quads.ravel()[border].tolist(), border.tolist(), strict=True))
            for v in at:
                code = np.zeros(4 * q, np.uint16)
                number, entry, order = (np.empty(q, np.int32) for _ in range(3))
                rooted_code(twin, q, start_of[v], False, code, number, entry, order, False)
                sign = -1 if mirrored else 1
                marks = tuple(sorted(sign * (u - v) % p for u in at))
                images.append((tuple(code.tolist()), marks))
        assert min(images) not in seen
        seen.add(min(images))
    assert len(seen) > 20


def count_sites(marks: int) -> int:
    """How many sequences of slots have so many marks: one mark, at either end, or two."""
    if marks < 2:
        return marks + 1
    return 2 * count_sites(marks - 1) + count_sites(marks - 2)


def test_corner_sites() -> None:
    found = CornerSites.up_to(6)
    assert Counter(found.marks.tolist()) == {m: count_sites(m) for m in range(7)}
    rows = set(zip(found.slots.tolist(), found.near.tolist(), found.far.tolist(), strict=True))
    assert len(rows) == len(found.marks)
    for m, slots, near, far in zip(
        found.marks.tolist(),
        found.slots.tolist(),
        found.near.tolist(),
        found.far.tolist(),
        strict=True,
    ):
        assert near | far == (1 << slots) - 1
        assert near.bit_count() + far.bit_count() == m


@pytest.mark.parametrize(("n_sides", "most", "free"), [(0, 4, False), (2, 4, True), (3, 99, False)])
def test_tables_that_mean_nothing(n_sides: int, most: int, free: bool) -> None:
    with pytest.raises(InvalidQueryError, match="marked patterns need"):
        load_marked_family(n_sides, most=most, free=free)


def test_kept_between_runs(cache_folder: Path) -> None:
    first = load_marked_family(5)
    kept = list(cache_folder.rglob("*-marked-*-5.arrays"))
    assert len(kept) == 1
    before = kept[0].read_bytes()
    kept[0].write_bytes(before[:-1])
    forget_families()
    again = load_marked_family(5)
    assert kept[0].read_bytes() == before
    forget_families()
    for other in (again, load_marked_family(5), mark_patterns(load_family(), 5)):
        assert other.patterns.codes == first.patterns.codes
        for column in ("pattern", "cost", "counts", "label", "strand_chord", "signature", "joins"):
            assert np.array_equal(getattr(other, column), getattr(first, column))


def test_loading_ends_when_it_is_cancelled(cache_folder: Path) -> None:
    forget_families()
    with pytest.raises(QueryCancelledError):
        load_marked_family(6, most=3, cancelled=np.ones(1, np.uint8))
    assert not list(cache_folder.rglob("*-marked-*-3-5-*-6.arrays"))
    assert len(load_marked_family(6, most=3))


def test_relaxed_tables_know_how_many_quads_a_pattern_has() -> None:
    """A code of more than 31 quads has numbers that take two bytes."""
    table = get_relaxed_table(small_class(4))
    large = np.flatnonzero(table.n_quads > 31)
    assert len(large)
    for row in [0, *large[:: len(large) // 20 + 1].tolist()]:
        assert table.n_quads[row] == table.pattern(row).n_quads
