"""Polychords, labels and signatures."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from patterndb._native.core.halfedge import next_border_edge
from patterndb.core import description as d
from patterndb.core.code import canonical_code, decode
from patterndb.core.label import join_matrices, split_word
from patterndb.core.pattern import Pattern
from patterndb.core.polychord import polychords
from patterndb.core.quadmesh import QuadMesh
from tests.support.meshes import CUP, SHAPES, Quads, disks, quad_soups, star
from tests.support.reference import code as reference_code
from tests.support.reference import label as reference


def described(twin: list[int]) -> tuple[list[int], d.Descriptions]:
    """The half-edges that the canonical code of a disk decodes to, and its description."""
    code = canonical_code(np.array(twin, np.int32))[0]
    return decode(code).tolist(), d.describe([code])


def assert_polychords(twin: list[int]) -> None:
    traced = polychords(np.array(twin, np.int32))
    of_edge, n_open, n_loops, crosses = reference.polychords(twin)
    assert traced.of_edge.tolist() == of_edge
    assert (traced.n_open, traced.n_loops, traced.n) == (n_open, n_loops, n_open + n_loops)
    assert traced.crosses_itself.tolist() == crosses
    strands = [[of_edge[h], of_edge[h + 1]] for h in range(0, len(twin), 4)]
    assert traced.of_strand.tolist() == strands


@given(quad_soups())
def test_polychords_of_a_mesh(quads: Quads) -> None:
    assert_polychords(QuadMesh.from_quads(quads).twin.tolist())


@given(disks())
def test_polychords_of_a_disk(twin: list[int]) -> None:
    assert_polychords(twin)
    # Each open one ends on two border edges.
    border = [polychords(np.array(twin, np.int32)).of_edge[h] for h, t in enumerate(twin) if t < 0]
    assert all(border.count(c) == 2 for c in border)


def test_no_quads_have_no_polychords() -> None:
    assert polychords(np.zeros(0, np.int32)).n == 0


@given(disks())
def test_the_label_is_the_reference_s(twin: list[int]) -> None:
    twin, rows = described(twin)
    sides = reference.label(twin, 0)
    assert rows.numbers(0, d.LABEL).tolist() == reference.word(sides)
    n_sides = int(rows.counts[0, d.N_CORNERS])
    assert split_word(rows.numbers(0, d.LABEL), n_sides) == sides
    pattern = Pattern.from_code(canonical_code(np.array(twin, np.int32))[0])
    assert [list(s) for s in pattern.label] == sides


@given(disks())
def test_the_signature_is_the_smallest_word(twin: list[int]) -> None:
    twin, rows = described(twin)
    sides = reference.label(twin, 0)
    closed = rows.counts[0, d.N_CORNERS] == 0
    word, symmetries = reference.canonical_word(sides, closed)
    assert rows.numbers(0, d.SIGNATURE).tolist() == word
    assert rows.counts[0, d.SIG_SYMMETRIES] == symmetries


@given(disks())
def test_from_the_stored_rotation_the_label_reads_as_the_signature(twin: list[int]) -> None:
    twin, rows = described(twin)
    sides = reference.label(twin, 0)
    rotation, reflected = rows.counts[0, [d.SIG_ROTATION, d.SIG_REFLECTED]].tolist()
    closed = rows.counts[0, d.N_CORNERS] == 0
    assert 0 <= rotation < (len(sides[0]) if closed else len(sides))
    seen = reference.seen_from(sides, rotation, bool(reflected), closed)
    assert reference.word(seen) == rows.numbers(0, d.SIGNATURE).tolist()


@given(disks(), st.data())
def test_rotation_and_mirror_image_do_not_change_the_signature(
    twin: list[int], data: st.DataObject
) -> None:
    """Labels read from any corner of either image have the one signature."""
    rows = described(twin)[1]
    image = data.draw(st.sampled_from([twin, reference_code.mirrored(twin)]))
    start = data.draw(st.sampled_from(reference_code.code_starts(image)))
    closed = rows.counts[0, d.N_CORNERS] == 0
    sides = reference.label(image, start)
    assert reference.canonical_word(sides, closed)[0] == rows.numbers(0, d.SIGNATURE).tolist()


@given(disks())
def test_polychords_of_a_pattern_are_numbered_as_its_label(twin: list[int]) -> None:
    pattern = Pattern.from_disk(np.array(twin, np.int32))
    chords = pattern.polychords()
    h, along = 0, []
    for _ in range(sum(map(len, pattern.label))):
        along.append(int(chords.of_edge[h]))
        h = int(next_border_edge(pattern.twin(), h))
    assert h == 0
    assert along == [c for side in pattern.label for c in side]
    traced = polychords(pattern.twin())
    assert (chords.n_open, chords.n_loops) == (traced.n_open, traced.n_loops)
    # The same classes under other names, with the same crossings.
    pairs = set(zip(chords.of_edge.tolist(), traced.of_edge.tolist(), strict=True))
    assert len(pairs) == chords.n
    assert all(chords.crosses_itself[a] == traced.crosses_itself[b] for a, b in pairs)


@given(disks())
def test_joins_are_the_two_sides_that_each_chord_ends_on(twin: list[int]) -> None:
    _, rows = described(twin)
    n_sides = int(rows.counts[0, d.N_CORNERS])
    sides = split_word(rows.numbers(0, d.SIGNATURE), n_sides)
    assert rows.numbers(0, d.LENGTHS).tolist() == [len(side) for side in sides]
    ends = [
        [s for s, side in enumerate(sides) for c in side if c == chord]
        for chord in range(rows.counts[0, d.N_CHORDS])
    ]
    pairs = rows.numbers(0, d.JOINS).reshape(-1, 2)
    assert pairs.tolist() == ends

    n = max(n_sides, 1)
    matrix = join_matrices(n_sides, pairs, np.zeros(len(pairs), np.int64), 1)[0]
    expected = [[ends.count(sorted((i, j))) for j in range(n)] for i in range(n)]
    assert matrix.tolist() == expected
    assert (matrix.sum(axis=1) + np.diag(matrix)).tolist() == [len(side) for side in sides]


@pytest.mark.parametrize(
    ("quads", "label", "loops"),
    [
        (SHAPES["one"], [[0], [1], [0], [1]], 0),
        (star(3), [[0, 1], [2, 0], [1, 2]], 0),
        (star(5), [[0, 1], [2, 3], [1, 4], [3, 0], [4, 2]], 0),
        # The four walls of a cup are a loop; its rim is one closed side.
        (CUP, [[0, 1, 0, 1]], 1),
    ],
)
def test_labels_of_known_patterns(quads: Quads, label: list[list[int]], loops: int) -> None:
    pattern = Pattern.from_disk(QuadMesh.from_quads(quads).twin)
    assert [list(s) for s in pattern.label] == label
    assert pattern.n_loops == loops
