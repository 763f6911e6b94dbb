"""Expansion: every invariant of a fill, for patterns with random widths in every orientation."""

from __future__ import annotations

import random
from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb.core.pattern import Pattern
from patterndb.core.quadmesh import QuadMesh
from patterndb.core.reduction import reduce_disk
from query import Fill
from query.errors import InvalidQueryError
from query.expand import expand_pattern
from query.orientation import list_distinct_orientations
from query.recognition import is_mesh
from tests.support.query.cases import (
    all_orientations,
    class_of,
    grid_widths,
    laid_corners,
    laid_lengths,
    small_patterns,
)
from tests.support.reference import reduction
from tests.support.reference.code import isomorphic, mirrored, rooted_code
from tests.support.reference.halfedge import as_complex, border_loop, is_disk, twins

PATTERNS = st.sampled_from(range(len(small_patterns())))


def has_wide_crossing(pattern: Pattern, widths: tuple[int, ...]) -> bool:
    crosses = pattern.polychords().crosses_itself
    return any(w > 1 and c for w, c in zip(widths, crosses, strict=True))


def boundary_twin(fill: Fill) -> tuple[list[int], int]:
    """Half-edges by plain Python, and the one that leaves vertex 0 along the boundary."""
    quads = fill.quads.tolist()
    twin = twins(quads)
    (start,) = (h for h, t in enumerate(twin) if t < 0 and quads[h // 4][h % 4] == 0)
    return twin, start


def assert_fill(fill: Fill, pattern: Pattern, rotation: int, mirror: bool) -> None:
    quads = fill.quads.tolist()
    assert fill.quads.dtype == np.int32
    assert all(len(set(q)) == 4 for q in quads)
    assert is_mesh(fill.quads)
    twin, start = boundary_twin(fill)
    assert is_disk(as_complex(twin))
    assert {v for q in quads for v in q} == set(range(fill.n_vertices))

    # The boundary's vertices in order, counter-clockwise as the quads are.
    loop = border_loop(as_complex(twin), start)
    assert [quads[h // 4][h % 4] for h in loop] == list(range(fill.perimeter))
    count = Counter(v for q in quads for v in q)
    sides = fill.sides()
    joined = [v for side in sides for v in side[:-1].tolist()]
    assert joined == list(range(fill.perimeter))
    if pattern.n_sides:
        assert list(fill.lengths) == laid_lengths(pattern, fill.widths, rotation, mirror)
        corners = [int(side[0]) for side in sides]
        assert [count[v] for v in corners] == laid_corners(pattern, rotation, mirror)
    else:
        corners = []
    assert fill.disk().corners.tolist() == corners
    assert all(count[v] == 2 for v in range(fill.perimeter) if v not in corners)
    inner = sorted(count[v] for v in range(fill.perimeter, fill.n_vertices) if count[v] != 4)
    assert inner == list(pattern.valences)
    assert fill.n_irregular == len(inner) == len(fill.disk().irregular())


@settings(max_examples=150, derandomize=True)
@given(PATTERNS, st.integers(0, 2**32))
def test_a_fill_is_what_was_asked_for(at: int, seed: int) -> None:
    pattern = small_patterns()[at]
    chance = random.Random(seed)
    widths = grid_widths(chance, pattern, 4).tolist()
    rotation, mirror = chance.choice(all_orientations(pattern.n_sides))
    fill = expand_pattern(pattern, widths, rotation=rotation, mirrored=mirror)
    assert fill.widths == tuple(widths)
    assert (fill.rotation, fill.mirrored) == (rotation, mirror)
    assert_fill(fill, pattern, rotation, mirror)


@settings(max_examples=150, derandomize=True)
@given(PATTERNS, st.integers(0, 2**32))
def test_reducing_a_fill_gives_its_pattern_back(at: int, seed: int) -> None:
    pattern = small_patterns()[at]
    widths = grid_widths(random.Random(seed), pattern, 3).tolist()
    fill = expand_pattern(pattern, widths, mirrored=seed % 2 == 1)
    if has_wide_crossing(pattern, fill.widths):
        return
    twin = QuadMesh.from_quads(fill.quads).twin
    assert Pattern.from_disk(reduce_disk(twin)).id == pattern.id


@settings(max_examples=25, derandomize=True)
@given(PATTERNS, st.integers(0, 2**32))
def test_so_does_collapsing_by_plain_python(at: int, seed: int) -> None:
    pattern = small_patterns()[at]
    widths = grid_widths(random.Random(seed), pattern, 2).tolist()
    fill = expand_pattern(pattern, widths)
    if has_wide_crossing(pattern, fill.widths):
        return
    reduced = reduction.reduce_disk(boundary_twin(fill)[0], random.Random(seed), False)
    assert isomorphic(reduced, pattern.twin().tolist())


@settings(max_examples=80, derandomize=True)
@given(PATTERNS)
def test_widths_of_one_give_the_pattern_itself(at: int) -> None:
    pattern = small_patterns()[at]
    ones = [1] * (pattern.n_chords + pattern.n_loops)
    twin, start = boundary_twin(expand_pattern(pattern, ones))
    assert rooted_code(twin, start) == tuple(pattern.code.tolist())


@settings(max_examples=80, derandomize=True)
@given(PATTERNS, st.integers(0, 2**32))
def test_a_mirrored_fill_is_the_mirror_image(at: int, seed: int) -> None:
    """Seen in a mirror, side 0 of the one is side 0 of the other, read backwards."""
    pattern = small_patterns()[at]
    widths = grid_widths(random.Random(seed), pattern, 3).tolist()
    twin, start = boundary_twin(expand_pattern(pattern, widths))
    fill = expand_pattern(pattern, widths, mirrored=True)
    other, first = boundary_twin(fill)
    # The mirror image of the edges that begin at vertex 0 end there: one on, at the far end
    # of side 0, the mirror image of the plain fill begins with its side 0.
    loop = border_loop(as_complex(twin), start)
    end = loop[fill.lengths[0] - 1 if pattern.n_sides else 0]
    image = mirrored(twin)
    flipped = 4 * (end // 4) + 3 - end % 4
    assert rooted_code(image, flipped) == rooted_code(other, first)


@settings(max_examples=80, derandomize=True)
@given(PATTERNS)
def test_orientations_are_told_apart_exactly_up_to_symmetry(at: int) -> None:
    pattern = small_patterns()[at]
    if pattern.n_sides == 0:
        return
    widths = [1] * (pattern.n_chords + pattern.n_loops)

    def code(rotation: int, mirror: bool) -> tuple[int, ...]:
        fill = expand_pattern(pattern, widths, rotation=rotation, mirrored=mirror)
        return rooted_code(*boundary_twin(fill))

    distinct = [code(o.rotation, o.mirrored) for o in list_distinct_orientations(pattern)]
    assert len(set(distinct)) == len(distinct)
    assert set(distinct) == {code(*o) for o in all_orientations(pattern.n_sides)}


@pytest.mark.parametrize("mirror", [False, True])
def test_a_closed_side_turns_edge_by_edge(mirror: bool) -> None:
    (pattern,) = [p for p in small_patterns() if p.n_sides == 0]
    widths = grid_widths(random.Random(1), pattern, 3).tolist()
    plain, start = boundary_twin(expand_pattern(pattern, widths))
    loop = border_loop(as_complex(plain), start)
    perimeter = len(loop)
    for rotation in range(perimeter + 2):
        fill = expand_pattern(pattern, widths, rotation=rotation, mirrored=mirror)
        assert fill.rotation == rotation % perimeter
        assert_fill(fill, pattern, rotation, mirror)
        edge = loop[rotation % perimeter]
        if mirror:
            image, edge = mirrored(plain), 4 * (edge // 4) + 3 - edge % 4
        else:
            image = plain
        assert rooted_code(image, edge) == rooted_code(*boundary_twin(fill))


def test_loops_may_be_left_out_and_are_one_wide_then() -> None:
    (pattern,) = [p for p in small_patterns() if p.n_sides == 0]
    assert pattern.n_loops
    fill = expand_pattern(pattern, [2] * pattern.n_chords)
    assert fill.widths == (2,) * pattern.n_chords + (1,) * pattern.n_loops
    wide = expand_pattern(pattern, [2] * pattern.n_chords + [3] * pattern.n_loops)
    assert wide.lengths == fill.lengths
    assert wide.n_quads > fill.n_quads
    assert_fill(wide, pattern, 0, False)


def test_a_quad_on_one_polychord_becomes_a_square() -> None:
    pattern = next(p for p in small_patterns() if p.self_crossing)
    polychords = pattern.polychords()
    widths = np.arange(2, 2 + polychords.n)
    fill = expand_pattern(pattern, widths.tolist())
    assert fill.n_quads == (widths[polychords.of_strand].prod(axis=1)).sum()
    assert_fill(fill, pattern, 0, False)


@pytest.mark.parametrize("widths", [[], [1], [1, 1, 1], [0, 1], [2, -1]])
def test_wrong_widths_are_refused(widths: list[int]) -> None:
    square = class_of(4, [p for p in small_patterns() if p.n_quads == 1]).pattern(0)
    with pytest.raises(InvalidQueryError, match=r"give one for each|the least is 1"):
        expand_pattern(square, widths)
