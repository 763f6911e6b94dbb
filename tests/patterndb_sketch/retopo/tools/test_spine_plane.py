"""The patch about a stroke and what it snaps to, in the plane."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.tools.planar import (
    NewSide,
    OldSide,
    PlanarBoundary,
    PlanarPatch,
    stretch_points,
)
from patterndb_sketch.retopo.tools.spine import plan_spine
from tests.support.retopo.boundaries import boundary, same_corners

#: Of the cases: length of the stroke, half-width of the brush, snap radius; and how near corners
#: have to be: vertices are so far apart.
LENGTH, HALF, SNAP, NEAR = 4.0, 1.0, 0.25, 0.05 + 1e-9

#: Boundaries are directed with the empty side on their left.
BELOW = "-5,-0.1 5,-0.1"
RIGHT = "0.8,-3 0.8,7"


def made(*drawn: str) -> tuple[PlanarPatch, list[PlanarBoundary]]:
    boundaries = [boundary(text) for text in drawn]
    return plan_spine(boundaries, LENGTH, HALF, SNAP), boundaries


def kinds(patch: PlanarPatch) -> list[str]:
    """For each side, start end left and right of the stroke, o for old and n for new pieces."""
    return ["".join("o" if isinstance(p, OldSide) else "n" for p in side) for side in patch.sides]


@pytest.mark.parametrize(
    ("drawn", "corners", "sides"),
    [
        ([], [(-1, 0), (1, 0), (1, 4), (-1, 4)], ["n", "n", "n", "n"]),
        ([BELOW], [(-1, -0.1), (1, -0.1), (1, 4), (-1, 4)], ["o", "n", "n", "n"]),
        ([RIGHT], [(-1, 0), (0.8, 0), (0.8, 4), (-1, 4)], ["n", "o", "n", "n"]),
        (
            ["-5,-0.1 0.6,-0.1o 5,-0.1"],
            [(-1, -0.1), (0.6, -0.1), (1, 4), (-1, 4)],
            ["o", "n", "n", "n"],
        ),
        (
            ["0.8,-3 0.8,0.2o 0.8,3.9o 0.8,7"],
            [(-1, 0), (0.8, 0.2), (0.8, 3.9), (-1, 4)],
            ["n", "o", "n", "n"],
        ),
        (
            ["0.8,-3 0.8,2 4,5.2"],
            [(-1, 0), (0.8, 0), (1, 4), (-1, 4)],
            ["n", "on", "n", "n"],
        ),
        (["0.5,-3 1.5,7"], [(-1, 0), (0.8, 0), (1, 4), (-1, 4)], ["n", "on", "n", "n"]),
        (
            ["0.8,-3 0.8,1o 3,1", "3,3 0.8,3o 0.8,7"],
            [(-1, 0), (0.8, 0), (0.8, 4), (-1, 4)],
            ["n", "ono", "n", "n"],
        ),
        (
            ["-5,0 5,0", "5,4 -5,4"],
            [(-1, 0), (1, 0), (1, 4), (-1, 4)],
            ["o", "n", "o", "n"],
        ),
    ],
    ids=["a", "b", "c", "d", "e", "f", "g", "resume", "bridge"],
)
def test_every_case_of_the_figure_has_its_patch(
    drawn: list[str], corners: list[tuple[float, float]], sides: list[str]
) -> None:
    patch, _ = made(*drawn)
    assert same_corners(patch.points, corners, NEAR), patch.points
    assert kinds(patch) == sides


def test_where_snapping_stops_and_resumes_the_patch_has_t_junctions() -> None:
    patch, _ = made("0.8,-3 0.8,1o 3,1", "3,3 0.8,3o 0.8,7")
    old, new, _ = patch.sides[1]
    assert isinstance(new, NewSide)
    assert np.allclose(new.points, [(0.8, 1), (0.8, 3)], atol=1e-9)
    assert isinstance(old, OldSide)


def test_a_boundary_that_leaves_the_brush_is_followed_to_its_edge() -> None:
    patch, boundaries = made("0.5,-3 1.5,7")
    old, new = patch.sides[1]
    assert isinstance(old, OldSide) and isinstance(new, NewSide)
    assert np.allclose(boundaries[0].at(old.start), (0.8, 0), atol=1e-9)
    assert np.allclose(boundaries[0].at(old.end), (1, 2), atol=1e-9)
    assert np.allclose(new.points, [(1, 2), (1, 4)], atol=1e-9)


def test_a_boundary_with_its_patch_on_this_side_is_not_snapped_to() -> None:
    patch, _ = made("0.8,12 0.8,9")
    assert kinds(patch) == ["n", "n", "n", "n"]
    with pytest.raises(RefusedError, match="cross"):
        made("5,2 -5,2")


def test_from_a_corner_at_the_end_the_boundary_along_the_stroke_is_the_flank() -> None:
    patch, boundaries = made("-5,0 0.7,0o 0.7,9")
    assert same_corners(patch.points, [(-1, 0), (0.7, 0), (0.7, 4), (-1, 4)], NEAR)
    assert kinds(patch) == ["o", "o", "n", "n"]
    end, side = patch.sides[0][0], patch.sides[1][0]
    assert isinstance(end, OldSide) and isinstance(side, OldSide)
    assert end.end == side.start
    assert np.allclose(boundaries[0].at(end.end), (0.7, 0))


def test_of_two_boundaries_side_by_side_the_nearer_counts() -> None:
    patch, _ = made("0.9,-3 0.9,7", "0.6,-3 0.6,7")
    assert same_corners(patch.points, [(-1, 0), (0.6, 0), (0.6, 4), (-1, 4)], NEAR)
    assert [p.boundary for p in patch.sides[1] if isinstance(p, OldSide)] == [1]


def test_a_loop_is_snapped_to_across_its_first_vertex() -> None:
    # A square hole's border, empty inside: the stroke starts on its lower edge's first vertex.
    hole = boundary("0,0 3,0o 3,4o -3,4o -3,0o", closed=True)
    patch = plan_spine([hole], LENGTH, HALF, SNAP)
    assert kinds(patch) == ["o", "n", "o", "n"]
    assert same_corners(patch.points, [(-1, 0), (1, 0), (1, 4), (-1, 4)], NEAR)
    start = patch.sides[0][0]
    assert isinstance(start, OldSide)
    assert np.allclose(stretch_points(hole, start)[[0, -1]], [(-1, 0), (1, 0)])


slants = st.floats(-0.4, 0.4)


@given(st.floats(0.3, 0.95), slants, st.floats(0.3, 0.95), slants, st.floats(-0.2, 0.2))
def test_mirrored_boundaries_have_the_mirrored_patch(
    right: float, slant: float, left: float, lean: float, below: float
) -> None:
    def drawn(sign: float) -> list[PlanarBoundary]:
        sides = [
            (right - 3 * slant / 4, -3.0, right + 7 * slant / 4, 7.0),
            (-left + 7 * lean / 4, 7.0, -left - 3 * lean / 4, -3.0),
            (-0.2, below, 0.2, below),
        ]
        found = []
        for x0, y0, x1, y1 in sides:
            one = boundary(f"{sign * x0},{y0} {sign * x1},{y1}")
            points = one.points if sign > 0.0 else one.points[::-1]
            found.append(PlanarBoundary(points.copy(), one.corner))
        return found

    def patch(sign: float) -> PlanarPatch | None:
        try:
            return plan_spine(drawn(sign), LENGTH, HALF, SNAP)
        except RefusedError:
            return None

    one, other = patch(1.0), patch(-1.0)
    assert (one is None) == (other is None)
    if one is not None and other is not None:
        mirrored = other.points[[1, 0, 3, 2]] * (-1.0, 1.0)
        assert np.allclose(one.points, mirrored, atol=1e-6)


@given(
    st.lists(
        st.tuples(
            st.lists(
                st.tuples(st.floats(-2, 2), st.floats(-1, 5)), min_size=2, max_size=5, unique=True
            ),
            st.integers(0, 31),
        ),
        max_size=3,
    )
)
def test_whatever_is_there_pieces_join_or_the_tool_refuses(
    drawn: list[tuple[list[tuple[float, float]], int]],
) -> None:
    boundaries = [
        boundary(
            " ".join(f"{x},{y}{'o' if corners >> k & 1 else ''}" for k, (x, y) in enumerate(points))
        )
        for points, corners in drawn
    ]
    try:
        patch = plan_spine(boundaries, LENGTH, HALF, SNAP)
    except RefusedError as error:
        assert "the spine's patch would" in str(error)
        return
    assert len(patch.corners) == 4
    at = patch.corners[0].point
    for part in patch.parts:
        points = (
            part.points
            if isinstance(part, NewSide)
            else stretch_points(boundaries[part.boundary], part)
        )
        assert np.allclose(points[0], at, atol=1e-6)
        at = points[-1]
    assert np.allclose(at, patch.corners[0].point, atol=1e-6)
    border = patch.outline(boundaries)
    after = np.roll(border, -1, axis=0)
    assert (border[:, 0] * after[:, 1] - border[:, 1] * after[:, 0]).sum() > 0.0
