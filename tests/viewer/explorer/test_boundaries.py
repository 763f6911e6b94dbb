"""Boundaries in the fill explorer: drawn, and changed."""

from __future__ import annotations

import numpy as np
import pytest

from patterndb.errors import NotFoundError
from query import Boundary
from query.contour import Contour, make_flat_boundary
from tests.support.viewer.domed import DOME, click, keys
from viewer.explorer_state import ExplorerState
from viewer.pointerstroke import PointerMode


@pytest.mark.parametrize(
    ("lengths", "corners"),
    [((4, 3, 4, 3), None), ((5, 5), None), ((8,), ("convex",)), ((12,), ()), ((3, 4, 5), None)],
)
def test_flat_boundaries(lengths: tuple[int, ...], corners: tuple[str, ...] | None) -> None:
    boundary = make_flat_boundary(lengths, corners)  # type: ignore[arg-type]
    assert boundary == Boundary(lengths, corners)  # type: ignore[arg-type]
    assert boundary.points is not None
    after = np.roll(boundary.points, -1, axis=0)
    assert np.cross(boundary.points, after)[:, 2].sum() > 0.0
    contour = Contour.of(boundary)
    again = contour.boundary()
    assert again == boundary and again.points is not None
    assert (again.points == boundary.points).all()
    back = contour.reversed().reversed()
    assert back.lengths == contour.lengths and back.corners == contour.corners
    for one, other in zip(back.sides, contour.sides, strict=True):
        assert (one == other).all()


def test_reflex_corners_are_drawn_in() -> None:
    boundary = make_flat_boundary((2, 2, 2, 2, 2, 2), ("convex", "reflex") * 3)
    contour = Contour.of(boundary)
    normals = np.tile([0.0, 0.0, 1.0], (6, 1))
    assert Contour.drawn(contour.sides, normals).corners == boundary.corners
    assert contour.toggled(1).corners.count("reflex") == 2
    assert set(contour.reversed().corners[::2]) == {"reflex"}


@pytest.mark.parametrize("clockwise", [False, True])
def test_a_boundary_is_drawn_by_clicks(empty: ExplorerState, clockwise: bool) -> None:
    corners = [(-120.0, -90.0), (110.0, -100.0), (120.0, 90.0), (-100.0, 100.0)]
    keys(empty, "b")
    assert empty.mode is PointerMode.CORNERS
    click(empty, *(corners[::-1] if clockwise else corners), (0.0, 0.0))
    keys(empty, "BackSpace")
    assert len(empty.pen.clicked) == 4 and len(empty.pen.paths) == 3
    last = corners[0] if clockwise else corners[-1]
    click(empty, last)
    assert empty.mode is PointerMode.LOOK and empty.finder.boundary is not None
    boundary = empty.finder.boundary
    assert boundary.n_sides == 4 and boundary.convex and boundary.points is not None
    found = empty.camera.view.seen(boundary.points[list(boundary.side_starts[:-1])])[:, :2]
    wanted = {(round(x, 6), round(y, 6)) for x, y in corners}
    assert {(round(x, 6), round(y, 6)) for x, y in found.tolist()} == wanted
    after = np.roll(boundary.points, -1, axis=0)
    assert np.cross(boundary.points, after)[:, 2].sum() > 0.0
    assert np.abs(DOME.nearest(boundary.points).points - boundary.points).max() < 0.01
    empty.settle()
    placed = empty.finder.placed
    assert placed is not None and len(placed.placement.flipped) == 0
    assert placed.placement.off_surface < 1e-9
    inside = placed.placement.region_share
    assert inside is not None and inside < 0.5


def test_a_boundary_needs_three_corners_on_the_surface(empty: ExplorerState) -> None:
    keys(empty, "s")
    assert empty.mode is PointerMode.LOOK and "no boundary" in empty.message
    keys(empty, "b Enter")
    assert "three corners" in empty.message
    click(empty, (900.0, 0.0))
    assert "on the surface" in empty.message and empty.pen.clicked == []
    click(empty, (0.0, 0.0), (50.0, 0.0), (50.0, 0.0))
    assert "three corners" in empty.message and len(empty.pen.clicked) == 2
    keys(empty, "Escape")
    assert empty.mode is PointerMode.LOOK and empty.pen.clicked == [] and empty.contour is None
    with pytest.raises(NotFoundError, match="no boundary"):
        empty.settle(0)


def test_edges_and_corners_under_the_pointer(state: ExplorerState) -> None:
    keys(state, "+")
    assert "pointer" in state.message
    assert state.contour is not None
    for side in range(4):
        start, end = state.camera.view.seen(state.contour.sides[side][[0, -1]])[:, :2]
        state.move(*((start + end) / 2.0))
        assert state.side_under() == side
    before = state.contour.lengths
    keys(state, "+")
    assert sum(state.contour.lengths) == sum(before) + 1 and state.contour.lengths[3] == 4
    assert state.finder.boundary is None and "odd" in state.message and state.finder.fills == []
    keys(state, "+")
    assert state.finder.boundary is not None and state.finder.boundary.lengths == (4, 3, 4, 5)
    state.settle()
    assert state.finder.fills and all(fill.lengths == (4, 3, 4, 5) for fill in state.finder.fills)
    corner = state.camera.view.seen(state.contour.sides[2][0])[:2]
    state.move(*corner)
    assert state.corner_under() == 2
    keys(state, "c")
    assert state.finder.boundary.corners == ("convex", "convex", "reflex", "convex")
    keys(state, "c k")
    assert state.finder.boundary.lengths == (5, 4, 3, 4)
    assert state.finder.boundary.corners == ("reflex",) * 4
    keys(state, "k ] [")
    assert state.finder.boundary.perimeter == 16
