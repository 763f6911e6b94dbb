"""Which patch each configuration of boundaries suggests, in the plane."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from patterndb_sketch.retopo.tools.planar import (
    NewSide,
    PlanarBoundary,
    PlanarPatch,
    _find_crossings,
    find_fault,
)
from patterndb_sketch.retopo.tools.suggestions import SIZES, suggest_patch, suggest_patches
from tests.support.retopo.boundaries import boundary, same_corners
from tests.support.retopo.completion import CASES, LINE, NEAR, RADIUS, SNAP, C, asked, framed


@pytest.mark.parametrize(
    ("drawn", "cursor", "triangle", "case", "corners", "curves"),
    [case[1:] for case in CASES],
    ids=[case[0] for case in CASES],
)
def test_every_case_of_the_figure_has_its_patch(
    drawn: list[str],
    cursor: tuple[float, float],
    triangle: bool,
    case: str,
    corners: list[tuple[float, float]],
    curves: int,
) -> None:
    found, at = asked(drawn, cursor, triangle=triangle)
    assert found is not None
    assert at is not None
    assert found.case == case
    assert same_corners(at, corners, NEAR), at
    assert len(found.patch.curves) == curves


def test_all_sizes_have_a_patch_on_a_straight_boundary() -> None:
    for k in range(1, SIZES + 1):
        found, at = asked([LINE], size=k / SIZES)
        assert found is not None and at is not None
        assert found.case == "a"
        assert same_corners(
            at, [(-k / 10, 0), (k / 10, 0), (k / 10, k / 5), (-k / 10, k / 5)], NEAR
        )


@pytest.mark.parametrize(
    ("drawn", "cursor", "cases"),
    [
        (["0,3 0,0o 3,0"], (0.5, 0), "aaaa" + 6 * "B"),
        (["-3,1 0,0o 3,0"], (0.5, 0), "aaaa" + 6 * "A"),
        (["2,3 0,0o 3,0"], (0.5, 0), "aaii" + 6 * "T"),
        ([LINE, "3,1.5 -3,1.5"], (0, 0), "aaaaaaaiii"),
        ([C, "0.6,3 0.6,1.5o -0.6,1.5o -0.6,3"], (0, 0), "aaaaccckkk"),
        ([LINE, "3,1.2 0.3,1.2o 0.3,3", "-0.3,3 -0.3,1.2o -3,1.2"], (0, 0), "aaaaa-----"),
        ([LINE], (0, 0.3), 10 * "-"),
    ],
)
def test_smaller_windows_see_less(
    drawn: list[str], cursor: tuple[float, float], cases: str
) -> None:
    """Cases from the smallest window to the largest; B is b1, A is a0, T is b2, - is none."""
    letters = {"b1": "B", "a0": "A", "b2": "T"}
    seen = ""
    for k in range(1, SIZES + 1):
        found, _ = asked(drawn, cursor, size=k / SIZES)
        seen += "-" if found is None else letters.get(found.case, found.case)
    assert seen == cases


def test_beside_a_corner_that_is_not_sharp_the_longer_stretch_gets_a_patch() -> None:
    found, at = asked(["-3,1 0,0o 3,0"], (0.5, 0))
    assert found is not None and at is not None
    assert found.case == "a0"
    assert same_corners(at, [(0, 0), (1.5, 0), (1.5, 1.5), (0, 1.5)], NEAR)


def test_no_triangle_at_a_corner_that_is_not_sharp() -> None:
    found, _ = asked(["-3,0 0.3,0o 3,0"], triangle=True)
    assert found is None


def test_the_largest_quad_comes_first_and_triangles_last() -> None:
    boundaries = framed([boundary("0,3 0,0o 3,0")], (0.5, 0))
    found = suggest_patches(boundaries, RADIUS, SNAP)
    corners = [len(s.patch.corners) for s in found]
    assert corners == sorted(corners, reverse=True)
    assert {3, 4} == set(corners)
    for kind in (3, 4):
        sizes = [s.size for s in found if len(s.patch.corners) == kind]
        assert sizes == sorted(sizes, reverse=True)
    assert found[0].case == "b1"
    assert found[0].size == RADIUS


def test_suggestions_with_nearly_the_same_corners_are_one() -> None:
    # Every window from 0.5 on sees the same two corners.
    found = suggest_patches(framed([boundary(C)], (0, 0)), RADIUS, SNAP)
    assert [s.case for s in found].count("c") == 1


def test_a_closed_boundary_in_sight_is_a_patch_itself() -> None:
    square = boundary("-0.5,0o 0.5,0o 0.5,1o -0.5,1o", closed=True)
    found = suggest_patch(framed([square], (0, 0)), 1.0)
    assert found is not None
    assert found.case == "loop"
    assert len(found.patch.corners) == 4
    assert not found.patch.curves


def test_a_patch_off_the_parameterised_part_is_not_shown() -> None:
    boundaries = framed([boundary(LINE)], (0, 0))
    sizes = [s.size for s in suggest_patches(boundaries, RADIUS, 0.01)]
    low = suggest_patches(
        boundaries, RADIUS, 0.01, covered=lambda line: bool((line[:, 1] <= 1.0).all())
    )
    assert [s.size for s in low] == [size for size in sizes if size <= 0.5]


def test_curves_that_would_cross_a_boundary_are_not_shown() -> None:
    # A spur from the side reaches into the patch of case a, its end outside of the window.
    boundaries = framed([boundary(LINE), boundary("3,1 1.02,1")], (0, 0))
    alone = suggest_patch(boundaries[:1], 1.0)
    assert alone is not None
    wall = PlanarBoundary(np.array([[0.0, 1.5], [3.0, 1.5]]), np.zeros(2, bool))
    assert find_fault(alone.patch, boundaries[:1]) is None
    assert find_fault(alone.patch, [boundaries[0], wall]) == "cross a curve that is there"


def test_a_patch_inside_out_is_not_shown() -> None:
    found = suggest_patch(framed([boundary(LINE)], (0, 0)), 1.0)
    assert found is not None
    corners = found.patch.corners[::-1]
    sides = [
        (NewSide(np.array([a.point, b.point])),)
        for a, b in zip(corners, (*corners[1:], corners[0]), strict=True)
    ]
    assert "inside out" in str(find_fault(PlanarPatch(corners, tuple(sides)), []))


def test_crossing_segments_are_those_that_pass_through_each_other() -> None:
    a = np.array([[0.0, 0.0]])
    b = np.array([[1.0, 1.0]])
    c = np.array([[0.0, 1.0], [0.0, 0.0], [2.0, 0.0], [0.5, 0.5], [0.5, 0.5]])
    d = np.array([[1.0, 0.0], [1.0, 0.0], [3.0, 1.0], [0.0, 2.0], [1.0, 0.0]])
    # The last two go on into each other across a b: one of them counts.
    assert _find_crossings(a, b, c, d).tolist() == [[True, False, False, False, True]]


coordinates = st.tuples(
    st.floats(-2, 2).map(lambda x: round(x, 2)), st.floats(-2, 2).map(lambda x: round(x, 2))
)


@given(
    st.lists(
        st.tuples(st.lists(coordinates, min_size=2, max_size=6, unique=True), st.integers(0, 63)),
        min_size=1,
        max_size=3,
    ),
    st.floats(0, 6.28),
)
def test_whatever_is_drawn_suggestions_are_sound_and_turn_with_it(
    drawn: list[tuple[list[tuple[float, float]], int]], angle: float
) -> None:
    boundaries = []
    for points, corners in drawn:
        marked = [f"{x},{y}{'o' if corners >> k & 1 else ''}" for k, (x, y) in enumerate(points)]
        boundaries.append(boundary(" ".join(marked)))
    shown = framed(boundaries, (0.0, 0.0))
    found = suggest_patches(shown, RADIUS, SNAP)
    for one in found:
        assert len(one.patch.corners) >= 2
        assert len(one.patch.sides) == len(one.patch.corners)
        border = one.patch.outline(shown)
        after = np.roll(border, -1, axis=0)
        assert (border[:, 0] * after[:, 1] - border[:, 1] * after[:, 0]).sum() > 0.0
        for corner in one.patch.corners:
            if corner.boundary is not None:
                assert np.allclose(shown[corner.boundary].at(corner.place), corner.point, atol=1e-9)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    turned = [PlanarBoundary(b.points @ turn.T, b.corner) for b in boundaries]
    again = suggest_patches(framed(turned, (0.0, 0.0)), RADIUS, SNAP)
    # Rounding may decide ties otherwise, but what is found is mostly the same.
    for one, other in zip(found, again, strict=False):
        if one.case == other.case and one.size == other.size:
            assert np.allclose(one.patch.points, other.patch.points, atol=1e-6)
