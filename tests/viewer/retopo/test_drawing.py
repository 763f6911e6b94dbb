"""Curves drawn in the window of retopology, and what is shown before they are made."""

from __future__ import annotations

import numpy as np
import pytest

from patterndb_sketch.retopo.network import check_network
from query.engine import PatternSource
from tests.support.viewer.sheets import (
    ROOM,
    SQUARE,
    at,
    click,
    curves,
    drag,
    hover,
    keys,
    opened,
    press,
    quads_of,
    square,
    texts,
    tube,
)
from viewer.retopo import RetopoState
from viewer.retopo.marks import INK
from viewer.retopo.picture import RetopoPainter
from viewer.stage import Curves


def test_what_is_drawn_becomes_curves_and_a_loop_of_them_quads(state: RetopoState) -> None:
    keys(state, "d")
    drag(state, SQUARE[0], SQUARE[1])
    (chain,) = curves(state)
    line = state.network.chains[chain].points
    assert np.abs(line[[0, -1], :2] - np.array(SQUARE[:2])).max() < 0.02
    assert np.abs(line[:, 1] + 1.5).max() < 0.02 and np.abs(line[:, 2]).max() < 1e-12
    for k in (2, 3, 4):
        drag(state, SQUARE[k - 1], SQUARE[k % 4])
    (patch,) = state.network.patches.values()
    assert len(patch.corners) == 4 and len(curves(state)) == 4
    counts = [state.network.chains[c].count for c in curves(state)]
    assert quads_of(state) == counts[0] * counts[1] > 0
    assert state.shown.fresh and not state.editing.waiting and not state.message
    assert state.shown.undoable == 4


def test_a_stroke_that_closes_and_a_quick_one_stay_on_the_surface(state: RetopoState) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 9)
    drag(state, *np.stack([np.cos(angle), np.sin(angle)], axis=1).tolist())
    (chain,) = curves(state)
    assert state.network.chains[chain].is_closed_loop
    # Two events only: the way between them is on the surface, too.
    places = [at(state, (-3.0, 3.0)), at(state, (3.0, 3.0))]
    state.move(*places[0])
    state.press(*places[0])
    state.release(*places[1])
    state.settle()
    assert len(curves(state)) == 2
    assert state.network.chains[curves(state)[1]].length == pytest.approx(6.0, abs=0.05)


def test_beside_the_surface_and_by_the_right_button_the_view_turns(state: RetopoState) -> None:
    for turn, place in ((False, (-6.0, 0.0)), (True, (0.0, 0.0))):
        axes = state.camera.view.axes
        x, y = at(state, place)
        state.press(x, y, turn=turn)
        state.move(x + 30.0, y + 10.0)
        state.release(x + 30.0, y + 10.0)
        assert not np.allclose(state.camera.view.axes, axes)
        keys(state, "3")
    assert not curves(state) and state.editing.calls == ()


def test_a_spine_shows_its_patch_before_it_is_made(state: RetopoState) -> None:
    keys(state, "i")
    press(state, (-1.5, 0.0), (1.5, 0.0))
    state.settle()
    preview = state.tool.preview
    assert preview is not None and not preview.refused and len(preview.curves) == 4
    state.release(*at(state, (1.5, 0.0)))
    state.settle()
    (patch,) = state.network.patches.values()
    assert len(patch.corners) == 4
    made = np.concatenate([state.network.chains[c].points for c in curves(state)])
    shown = np.concatenate(preview.curves)
    away = np.linalg.norm(shown[:, None] - made[None], axis=2).min(axis=1)
    assert away.max() < 0.05
    width = np.ptp(made[:, 1])
    assert width == pytest.approx(2.0 * state.tool.brush, rel=0.02)
    assert state.tool.preview is None
    keys(state, "]")
    assert state.tool.brush > 0.5 * width and state.shown.undoable == 1, "a brush is no step"


def test_nearer_by_the_spine_is_narrower(state: RetopoState) -> None:
    keys(state, "i")
    hover(state, (0.0, 0.0))
    before = state.tool.brush
    for _ in range(5):
        state.wheel(1.0)
    assert state.tool.brush == pytest.approx(before / 1.15**5)
    keys(state, "v")
    for _ in range(5):
        state.wheel(-1.0)
    assert state.tool.brush == before


def test_completions_are_shown_stepped_through_and_taken_as_shown(state: RetopoState) -> None:
    keys(state, "i")
    drag(state, (-1.5, 0.0), (1.5, 0.0))
    keys(state, "a")
    hover(state, (0.0, 0.9))
    first = state.tool.preview
    assert first is not None and first.count > 1 and first.number == 0
    keys(state, "-")
    second = state.tool.preview
    assert second is not None and second.number == 1
    assert second.corners is not None and first.corners is not None
    assert not np.array_equal(first.corners, second.corners)
    assert f"2 of {second.count}   - +" in texts(state)
    keys(state, "+ -")
    click(state, (0.0, 0.9))
    assert len(state.network.patches) == 2
    nodes = np.array([node.point for node in state.network.nodes.values()])
    away = np.linalg.norm(second.corners[:, None] - nodes[None], axis=2).min(axis=1)
    # Corners on old curves are at their samples, those shown on the map between them.
    assert away.max() < 2e-3
    hover(state, (3.0, 3.0))
    assert state.tool.preview is not None and state.tool.preview.count == 0
    click(state, (3.0, -3.0))
    assert "nothing can be completed here" in state.message
    assert len(state.network.patches) == 2


def test_a_plane_cuts_loops_and_a_stroke_joins_them_to_a_cylinder(source: PatternSource) -> None:
    state = opened(source, tube())
    try:
        # Across the tube, from beside it to beside it.
        state.camera.look_along((1.0, 0.0, 0.0))
        keys(state, "l")
        for z in (-1.0, 1.0):
            press(state, (0.0, -1.4, z), (0.0, 1.4, z))
            state.settle()
            preview = state.tool.preview
            assert preview is not None and len(preview.curves) == 1
            assert np.abs(preview.curves[0][:, 2] - z).max() < 0.01
            line = state.tool.plane_line
            assert line is not None and line[0] != line[1]
            state.release(*at(state, (0.0, 1.4, z)))
            state.settle()
        loops = [state.network.chains[c] for c in curves(state)]
        assert len(loops) == 2 and all(chain.is_closed_loop for chain in loops)
        keys(state, "c + . .")
        assert state.tool.option(state.tool.mode, state.tool.mode.options[0]) == 5
        drag(state, (1.0, 0.0, -1.0), (1.0, 0.0, 1.0))
        assert [len(patch.corners) for patch in state.network.patches.values()] == [4] * 5
        assert (
            state.editing.calls is not None and state.editing.calls[-1].arguments["division"] == 5
        )
        keys(state, "l")
        drag(state, (0.0, 2.0, -1.0), (0.0, 2.5, -1.0))
        assert state.message == "drag a line across a part of the surface"
        check_network(state.network)
    finally:
        state.close()


def test_what_is_drawn_on_one_half_is_on_both(source: PatternSource) -> None:
    state = opened(source, tube())
    try:
        keys(state, "M")
        plane = state.shown.state.plane
        assert plane is not None and "symmetry is on" in state.message
        normal = np.array(plane.normal)
        # A square on the half that is worked on, seen from there; the tube has many planes.
        lengthwise = abs(normal[2]) < 0.5
        state.camera.look_along(normal if lengthwise else (1.0, 0.0, 0.0))
        right, up = state.camera.view.axes[:2]
        middle = np.array(plane.point) + (
            normal if lengthwise else np.r_[1.0, 0.0, 1.5 * normal[2]]
        )
        square(state, [middle + 0.4 * (x * right + y * up) for x, y in SQUARE])
        (patch,) = state.network.patches.values()
        mesh = state.shown.body.mesh
        assert len(mesh.quads) == 2 * len(state.shown.filled.placed[patch.id].quads) > 0
        heights = plane.heights(mesh.vertices)
        assert (heights > 0.1).sum() == (heights < -0.1).sum() == len(mesh.vertices) / 2
        keys(state, "M")
        assert state.shown.state.plane is None and len(state.network.patches) == 2
        assert len(state.shown.body.mesh.quads) == len(mesh.quads)
        keys(state, "u")
        assert state.shown.state.plane == plane and len(state.network.patches) == 1
    finally:
        state.close()


def count_ribbons(state: RetopoState) -> int:
    """Count the curves in the colour of what is being drawn."""
    layers = RetopoPainter().compose(state, *ROOM).layers
    return sum(isinstance(one, Curves) and one.look.colour == INK for one in layers)


def test_what_is_being_drawn_is_seen_on_the_other_half_too(source: PatternSource) -> None:
    """More of the picture is painted with the image of the line than without it."""
    state = opened(source, tube())
    try:
        keys(state, "M d")
        plane = state.shown.state.plane
        assert plane is not None
        normal = np.array(plane.normal)
        lengthwise = abs(normal[2]) < 0.5
        state.camera.look_along(normal if lengthwise else (1.0, 0.0, 0.0))
        right, up = state.camera.view.axes[:2]
        middle = np.array(plane.point) + (
            normal if lengthwise else np.r_[1.0, 0.0, 1.5 * normal[2]]
        )
        press(state, middle.tolist(), (middle + 0.3 * right + 0.2 * up).tolist())
        assert state.tool.holding and len(state.tool.line) > 2
        line = np.stack(state.tool.line)
        image = state.tool.mirror(line)
        assert image is not None
        assert np.allclose(plane.heights(image), -plane.heights(line))
        assert np.allclose(plane.flatten(image), plane.flatten(line))
        assert count_ribbons(state) == 2 * 1
        state.leave()
        keys(state, "M d")
        assert state.tool.mirror(line) is None
        press(state, middle.tolist(), (middle + 0.3 * right + 0.2 * up).tolist())
        assert count_ribbons(state) == 1
    finally:
        state.close()


def test_what_ends_would_snap_to_is_shown(state: RetopoState) -> None:
    drag(state, (-2.0, 0.0), (2.0, 0.0))
    hover(state, (2.1, 0.1))
    (end,) = state.tool.snaps()
    assert end[:2] == pytest.approx([2.0, 0.0], abs=0.03)
    hover(state, (0.0, 0.1))
    (side,) = state.tool.snaps()
    assert side == pytest.approx([0.0, 0.0, 0.0], abs=0.03)
    press(state, (2.1, 0.1), (2.0, 2.0), (-2.0, 0.15))
    assert len(state.tool.snaps()) == 2
    state.release(*at(state, (-2.0, 0.15)))
    state.settle()
    assert len(state.network.nodes) == 2, "both ends are joined"
    hover(state, (0.0, -3.0))
    assert state.tool.snaps() == []
    before = state.sizes.snap
    keys(state, "]")
    assert state.sizes.snap == pytest.approx(1.15 * before) and state.editing.calls is not None
    assert state.editing.calls[-1].tool == "sizes"
