"""Descriptions, disks and patterns against counting by hand."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from patterndb.core import description as d
from patterndb.core.code import canonical_code, decode
from patterndb.core.disk import Disk
from patterndb.core.packing import pack
from patterndb.core.pattern import Pattern
from patterndb.core.patternclass import PatternClass
from patterndb.core.quadmesh import QuadMesh
from patterndb.errors import InvalidCodeError, InvalidMeshError
from tests.support.meshes import SHAPES, Quads, disks, quad_soups
from tests.support.reference import code as reference_code
from tests.support.reference import label as reference_label
from tests.support.reference.halfedge import as_complex, border_loop, border_vertices, fans, is_disk


def counted(twin: Sequence[int]) -> tuple[list[int], list[int], list[int]]:
    """Quads at the boundary vertices from half-edge 0's tail on, at the corners among them,
    and at the irregular interior vertices."""
    complex_ = as_complex(twin)
    vertex = fans(complex_)
    count = Counter(vertex.values())
    boundary = [count[vertex[h]] for h in border_loop(complex_, 0)]
    inner = set(count) - border_vertices(complex_, vertex)
    return (
        boundary,
        [k for k in boundary if k != 2],
        sorted(count[v] for v in inner if count[v] != 4),
    )


def canonical(twin: Sequence[int]) -> np.ndarray:
    return canonical_code(np.array(twin, np.int32))[0]


@given(st.lists(disks(), max_size=4))
def test_every_column_follows_from_the_half_edges(twins: list[list[int]]) -> None:
    codes = [canonical(twin) for twin in twins]
    rows = d.describe(codes)
    assert rows.counts.shape == (len(codes), d.COLUMNS)
    for i, code in enumerate(codes):
        twin = decode(code).tolist()
        boundary, corners, valences = counted(twin)
        assert rows.numbers(i, d.CORNERS).tolist() == corners
        assert rows.numbers(i, d.VALENCES).tolist() == valences
        _, n_open, n_loops, crosses = reference_label.polychords(twin)
        _, mirrored, rotations, chiral = reference_code.canonical_code(twin)
        assert not mirrored
        assert rows.counts[i, : d.SIG_ROTATION].tolist() == [
            len(corners),
            sum(k > 2 for k in corners),
            len(valences),
            n_open,
            n_loops,
            any(crosses),
            rotations,
            chiral,
            len(boundary),
        ]
        assert rows.counts[i, d.N_QUADS] == len(twin) // 4


@given(st.lists(disks(), max_size=4))
def test_packed_codes_have_the_same_description(twins: list[list[int]]) -> None:
    codes = [canonical(twin) for twin in twins]
    rows, again = d.describe(codes), d.describe([pack(code) for code in codes])
    np.testing.assert_array_equal(again.counts, rows.counts)
    lists = [rows.numbers(i, k).tolist() for i in range(len(codes)) for k in range(d.LISTS)]
    assert [
        again.numbers(i, k).tolist() for i in range(len(codes)) for k in range(d.LISTS)
    ] == lists


@given(st.lists(disks(), max_size=4), st.data())
def test_rows_that_are_taken_have_their_lists(twins: list[list[int]], data: st.DataObject) -> None:
    rows = d.describe([canonical(twin) for twin in twins])
    places = data.draw(st.lists(st.integers(0, len(twins) - 1), max_size=6)) if twins else []
    taken = rows.take(np.array(places, np.int64))
    np.testing.assert_array_equal(taken.counts, rows.counts[places])
    for which in range(d.LISTS):
        numbers, starts = taken.gather(which)
        expected = [rows.numbers(i, which) for i in places]
        assert [numbers[a:b].tolist() for a, b in pairwise(starts)] == [
            one.tolist() for one in expected
        ]
        assert taken.split(which) == [one.tobytes() for one in expected]


@given(st.lists(disks(), min_size=1, max_size=4), st.integers(0))
def test_a_code_that_is_not_canonical_is_refused_with_its_row(
    twins: list[list[int]], where: int
) -> None:
    codes = [canonical(twin) for twin in twins]
    where %= len(codes)
    codes[where] = np.roll(codes[where], 1)
    try:
        d.describe([codes[where]])
    except InvalidCodeError as error:
        assert error.row == 0
        with pytest.raises(InvalidCodeError) as caught:
            d.describe(codes)
        assert caught.value.row == where


@given(disks())
def test_the_euler_sum_is_four(twin: list[int]) -> None:
    _, corners, valences = counted(decode(canonical(twin)).tolist())
    convex = corners.count(1)
    assert convex - sum(k - 2 for k in corners if k > 2) + sum(4 - v for v in valences) == 4


@given(disks())
def test_a_pattern_has_the_columns_of_its_description(twin: list[int]) -> None:
    code = canonical(twin)
    pattern = Pattern.from_code(code, frequency=7, origin="family")
    row = d.describe([code])
    assert (pattern.frequency, pattern.origin) == (7, "family")
    assert [
        pattern.n_sides,
        sum(k > 2 for k in pattern.corners),
        pattern.n_irregular,
        pattern.n_chords,
        pattern.n_loops,
        pattern.self_crossing,
        pattern.rotations,
        pattern.chiral,
    ] == row.counts[0, : d.PERIMETER].tolist()
    assert list(pattern.corners) == row.numbers(0, d.CORNERS).tolist()
    assert list(pattern.valences) == row.numbers(0, d.VALENCES).tolist()
    assert pattern.n_quads == len(code) // 4
    assert pattern.convex == (max(pattern.corners, default=1) == 1)
    assert pattern.name == f"{pattern.id:016x}"


def assert_disk(disk: Disk, twin: Sequence[int], start: int) -> None:
    """The disk's quads, joined by vertex numbers, are the half-edges, from ``start``."""
    complex_ = as_complex(twin)
    vertex = fans(complex_)
    loop = border_loop(complex_, start)
    name = dict(zip(vertex.values(), disk.quads.ravel().tolist(), strict=True))
    assert sorted(name.values()) == list(range(disk.n_vertices)), "one number a vertex"
    assert all(name[v] == n for v, n in zip(vertex.values(), disk.quads.flat, strict=True))
    assert [name[vertex[h]] for h in loop] == list(range(disk.perimeter))
    count = Counter(disk.quads.ravel().tolist())
    assert disk.valence().tolist() == [count[v] for v in range(disk.n_vertices)]
    corners = [v for v in range(disk.perimeter) if count[v] != 2]
    assert disk.corners.tolist() == corners
    assert disk.n_sides == len(corners)
    assert disk.corner_counts().tolist() == [count[v] for v in corners]
    irregular = [v for v in range(disk.perimeter, disk.n_vertices) if count[v] != 4]
    assert disk.irregular().tolist() == irregular
    assert disk.side_lengths().sum() == disk.perimeter
    sides = [s.tolist() for s in disk.sides()]
    assert [len(s) - 1 for s in sides] == disk.side_lengths().tolist()
    assert [s[0] for s in sides] == (corners or [0])
    assert all(b == (a + 1) % disk.perimeter for s in sides for a, b in pairwise(s))
    assert [s[-1] for s in sides] == [s[0] for s in sides[1:] + sides[:1]]


@given(disks())
def test_a_disk_is_numbered_along_its_boundary(twin: list[int]) -> None:
    disk = Disk.from_twin(np.array(twin, np.int32))
    first = reference_code.code_starts(twin)
    start = next(h for h in border_loop(as_complex(twin), twin.index(-1)) if h in first)
    assert_disk(disk, twin, start)
    if first != [h for h, t in enumerate(twin) if t < 0]:
        assert disk.corners[0] == 0


@given(disks(), st.data())
def test_a_disk_may_be_numbered_from_any_border_edge(twin: list[int], data: st.DataObject) -> None:
    start = data.draw(st.sampled_from([h for h, t in enumerate(twin) if t < 0]))
    assert_disk(Disk.from_twin(np.array(twin, np.int32), start), twin, start)


@given(disks())
def test_side_0_of_a_pattern_begins_at_vertex_0(twin: list[int]) -> None:
    pattern = Pattern.from_disk(np.array(twin, np.int32))
    disk = pattern.disk()
    assert_disk(disk, pattern.twin().tolist(), 0)
    assert tuple(disk.corner_counts().tolist()) == pattern.corners
    assert disk.side_lengths().tolist() == [len(side) for side in pattern.label]


@given(quad_soups(most=12))
def test_what_is_no_disk_is_refused(quads: Quads) -> None:
    twin = QuadMesh.from_quads(quads).twin
    if is_disk(as_complex(twin.tolist())):
        assert Disk.from_twin(twin).n_quads == len(quads)
    else:
        with pytest.raises(InvalidMeshError):
            Disk.from_twin(twin)


@pytest.mark.parametrize("name", ["bow", "book", "cube", "tube", "torus", "ring", "windowed"])
def test_shapes_that_are_no_disks_are_refused(name: str) -> None:
    with pytest.raises(InvalidMeshError):
        Disk.from_twin(QuadMesh.from_quads(SHAPES[name]).twin)


@given(st.lists(disks(most=8), min_size=1, max_size=8))
def test_a_class_holds_its_patterns_in_default_order(twins: list[list[int]]) -> None:
    patterns = {
        p.id: p
        for i, twin in enumerate(twins)
        for p in [Pattern.from_code(canonical(twin), frequency=1 + i % 3)]
    }
    n_sides = next(iter(patterns.values())).n_sides
    patterns = [p for p in patterns.values() if p.n_sides == n_sides]
    found = PatternClass.from_patterns(n_sides, patterns)
    patterns.sort(key=lambda p: (p.n_irregular, -p.frequency, p.id))
    assert found.ids.tolist() == [p.id for p in patterns]
    for row, p in enumerate(patterns):
        assert found.pattern(row).id == found.ids[row]
        assert found.pattern(row).frequency == p.frequency
        assert found.code(row).tolist() == p.code.tolist()
        assert found.frequency[row] == p.frequency
        assert found.corners[row].tolist() == list(p.corners)
        assert found.min_valence[row] == min(p.valences, default=4)
        assert found.max_valence[row] == max(p.valences, default=4)
        assert found.n_reflex[row] == sum(k > 2 for k in p.corners)
        # The signature's lengths, read back to the pattern's own sides.
        lengths = found.lengths[found.signature[row]].tolist()
        rotation, n = int(found.rotation[row]), max(n_sides, 1)
        if n_sides:
            sign = -1 if found.reflected[row] else 1
            lengths = [lengths[sign * (i - rotation) % n] for i in range(n)]
        assert lengths == [len(side) for side in p.label]
        joins = found.joins[found.signature[row]]
        assert (joins == joins.T).all()
        assert (joins.sum(axis=1) + np.diag(joins)).tolist() == (
            found.lengths[found.signature[row]].tolist()
        )


def test_a_class_takes_no_pattern_of_another() -> None:
    one = Pattern.from_code(np.zeros(4, np.uint16))
    with pytest.raises(ValueError, match="3 sides"):
        PatternClass.from_patterns(3, [one])
    assert len(PatternClass.from_patterns(3, [])) == 0
