"""Recognising quads: expanding what was recognised gives the quads back."""

from __future__ import annotations

import random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb._native.query.expand import expand_quads
from patterndb.core.disk import Disk
from patterndb.core.pattern import Pattern
from patterndb.errors import InvalidMeshError
from query import Boundary, Fill, fills
from query.boundary import CornerKind
from query.expand import expand_pattern
from query.orientation import list_distinct_orientations
from query.recognition import read_fill
from query.relaxed.family import load_family
from tests.support.query.cases import (
    KIND,
    Source,
    all_orientations,
    code_of,
    grid_widths,
    small_disks,
    small_patterns,
)
from tests.support.reference import reduction
from tests.support.reference.code import isomorphic, rooted_code
from tests.support.reference.halfedge import twins

PATTERNS = st.sampled_from(range(len(small_patterns())))


def boundary_of(fill: Fill) -> Boundary:
    """The boundary that the fill fills strictly, reflex corners of 4 and more quads included."""
    if not fill.pattern.n_sides:
        return Boundary.closed(fill.perimeter)
    disk = fill.disk()
    count = disk.valence()[disk.corners].tolist()
    return Boundary(fill.lengths, [KIND.get(k, "reflex") for k in count])


def expanded_again(fill: Fill) -> np.ndarray:
    """The quads that a fill's pattern, widths and orientation stand for, by its docstring."""
    pattern, widths = fill.pattern, np.array(fill.widths, np.int32)
    sides = [int(widths[list(side)].sum()) for side in pattern.label]
    if fill.strict and pattern.n_sides:
        corner = (fill.rotation + fill.mirrored) % pattern.n_sides
        first = sum(sides[:corner])
    else:
        first = fill.rotation + fill.mirrored
    across = widths[pattern.polychords().of_edge]
    return expand_quads(pattern.twin(), across, sum(sides), first, fill.mirrored)[0]


def code_at_vertex_0(quads: np.ndarray) -> tuple[int, ...]:
    rows = quads.tolist()
    twin = twins(rows)
    (start,) = (h for h, t in enumerate(twin) if t < 0 and rows[h // 4][h % 4] == 0)
    return rooted_code(twin, start)


@settings(max_examples=150, derandomize=True)
@given(PATTERNS, st.integers(0, 2**32))
def test_an_expanded_pattern_is_recognised(at: int, seed: int) -> None:
    pattern = small_patterns()[at]
    chance = random.Random(seed)
    widths = grid_widths(chance, pattern, 3).tolist()
    rotation, mirror = chance.choice(all_orientations(pattern.n_sides))
    known = expand_pattern(pattern, widths, rotation=rotation, mirrored=mirror)
    if max(pattern.corners, default=1) > 3:
        return
    # The order of the quads and the numbers of the inner vertices shall not matter.
    name = np.arange(known.n_vertices)
    inner = name[known.perimeter :].tolist()
    chance.shuffle(inner)
    name[known.perimeter :] = inner
    order = list(range(known.n_quads))
    chance.shuffle(order)
    fill = read_fill(name[known.quads][order], boundary_of(known), "drawn")
    assert (fill.origin, fill.pattern.origin) == ("drawn", "drawn")
    assert fill.lengths == known.lengths
    assert (fill.n_irregular, fill.n_irregular_boundary) == (pattern.n_irregular, 0)
    assert code_of(fill) == code_of(known)
    assert code_at_vertex_0(expanded_again(fill)) == code_at_vertex_0(fill.quads)
    if not pattern.self_crossing:
        assert fill.pattern == pattern
        assert sorted(fill.widths) == sorted(known.widths)


def widened(pattern: Pattern, width: int) -> Fill:
    """The pattern with all open polychords that wide."""
    return expand_pattern(pattern, [width] * pattern.n_chords)


@pytest.mark.parametrize("n_sides", range(4))
def test_a_widened_polychord_that_crosses_itself_is_one(n_sides: int) -> None:
    """Copies of it cross themselves and each other, and are one polychord all the same."""
    family = load_family(4)
    patterns = map(family.pattern, np.flatnonzero(family.n_sides == n_sides).tolist())
    crossing = [pattern for pattern in patterns if pattern.self_crossing]
    crossing.sort(key=lambda pattern: pattern.n_irregular + sum(k > 2 for k in pattern.corners))
    for pattern in crossing[:12]:
        if max(pattern.corners, default=1) > 3:
            continue
        narrow = read_fill(widened(pattern, 2).quads, boundary_of(widened(pattern, 2)), "").pattern
        assert narrow.n_quads <= pattern.n_quads
        for width in (2, 3):
            for turn in list_distinct_orientations(narrow):
                known = expand_pattern(
                    narrow,
                    [width] * narrow.n_chords,
                    rotation=turn.rotation,
                    mirrored=turn.mirrored,
                )
                fill = read_fill(known.quads, boundary_of(known), "drawn")
                assert (fill.pattern, fill.widths) == (narrow, known.widths)
                assert (fill.rotation, fill.mirrored) == (known.rotation, known.mirrored)
    assert crossing


@pytest.mark.parametrize(
    "boundary",
    [
        Boundary((8,)),
        Boundary((10,)),
        Boundary.closed(8),
        Boundary((3, 5)),
        Boundary((4, 4), ("convex", "reflex")),
        Boundary((3, 4, 5)),
        Boundary((2, 4, 2, 4)),
    ],
    ids=str,
)
def test_a_fill_that_is_listed_is_recognised(boundary: Boundary) -> None:
    """Pattern, widths and orientation: a client that gets quads alone finds what was listed."""
    listed = list(fills(Source(), boundary, limit=100))
    assert listed
    for known in listed:
        fill = read_fill(known.quads, boundary, known.origin)
        assert (fill.pattern, fill.widths) == (known.pattern, known.widths)
        assert (fill.rotation, fill.mirrored) == (known.rotation, known.mirrored)
        assert code_at_vertex_0(expanded_again(known)) == code_at_vertex_0(known.quads)


@settings(max_examples=100, derandomize=True)
@given(st.sampled_from(range(len(small_disks()))), st.integers(0, 2**32))
def test_a_disk_within_any_boundary_is_recognised(at: int, seed: int) -> None:
    """Corners anywhere: rotations count edges, and places that are not met are counted."""
    chance = random.Random(seed)
    disk = Disk.from_twin(np.array(small_disks()[at], np.int32))
    cuts = sorted(chance.sample(range(disk.perimeter), chance.randint(1, disk.perimeter)))
    lengths = np.diff([*cuts, cuts[0] + disk.perimeter]).tolist()
    kinds: list[CornerKind] = [KIND[chance.choice((1, 3))] for _ in cuts]
    quads = disk.quads.copy()
    on = quads < disk.perimeter
    quads[on] = (quads[on] - cuts[0]) % disk.perimeter
    boundary = Boundary(lengths, kinds)
    fill = read_fill(quads, boundary, "drawn")
    assert code_at_vertex_0(expanded_again(fill)) == code_at_vertex_0(fill.quads)
    reduced = reduction.reduce_disk(twins(quads.tolist()), chance, False)
    own = Pattern.from_disk(np.array(reduced, np.int32))
    if not own.self_crossing:
        assert isomorphic(reduced, fill.pattern.twin().tolist())
    count = np.bincount(quads.ravel(), minlength=disk.n_vertices).tolist()
    asked = {c - cuts[0]: {"convex": 1, "reflex": 3}[k] for c, k in zip(cuts, kinds, strict=True)}
    wrong = sum(count[v] != asked.get(v, 2) for v in range(disk.perimeter))
    inner = sum(count[v] != 4 for v in range(disk.perimeter, disk.n_vertices))
    assert (fill.n_irregular, fill.n_irregular_boundary) == (wrong + inner, wrong)


def test_a_closed_side_is_recognised() -> None:
    (pattern,) = [p for p in small_patterns() if p.n_sides == 0]
    for rotation in range(3):
        for mirror in (False, True):
            known = expand_pattern(
                pattern, [2] * pattern.n_chords, rotation=rotation, mirrored=mirror
            )
            fill = read_fill(known.quads, Boundary.closed(known.perimeter), "drawn")
            assert fill.pattern == pattern
            assert fill.strict
            assert code_at_vertex_0(expanded_again(fill)) == code_at_vertex_0(fill.quads)


@pytest.mark.parametrize(
    ("quads", "lengths", "fault"),
    [
        ([[0, 1, 2, 2]], (1, 1, 1, 1), "repeats a vertex"),
        ([[0, 1, 2, 3], [0, 1, 2, 3]], (1, 1, 1, 1), "join the same two vertices"),
        ([[0, 3, 2, 1]], (1, 1, 1, 1), "counter-clockwise"),
        ([[0, 1, 2, 3]], (2, 1, 2, 1), "border"),
        ([[0, 1, 2, 4]], (1, 1, 1, 1), "number them again"),
        ([[0, 1, 2, 3], [4, 5, 6, 7]], (1, 1, 1, 1), "border"),
        ([], (1, 1, 1, 1), r"\(q, 4\)"),
        ([[0, 1, 2]], (1, 1, 1, 1), r"\(q, 4\)"),
    ],
)
def test_what_fills_no_boundary_is_refused(
    quads: list[list[int]], lengths: tuple[int, ...], fault: str
) -> None:
    with pytest.raises(InvalidMeshError, match=fault):
        read_fill(quads, Boundary(lengths), "drawn")


def test_a_closed_surface_beside_the_disk_is_refused() -> None:
    cube = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    beside = [[v + 4 for v in quad] for quad in cube]
    with pytest.raises(InvalidMeshError, match="not a disk"):
        read_fill([[0, 1, 2, 3], *beside], Boundary((1, 1, 1, 1)), "drawn")


def test_the_pattern_of_a_fill_is_a_pattern() -> None:
    fill = read_fill([[0, 1, 2, 3]], Boundary((2, 1, 1)), "drawn")
    assert fill.pattern == Pattern.from_code(np.zeros(4, np.uint16))
    assert (fill.n_irregular, fill.n_irregular_boundary, fill.strict) == (1, 1, False)
