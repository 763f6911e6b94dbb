"""The window of retopology without a window: tools by the mouse, previews, and waiting."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from sheets import SQUARE, at, click, drag, hover, keys, opened, press, sheet, square, texts, tube

import patterndb
from query.engine import PatternSource
from sketch.retopo.editor import TOOLS, Call, Editor
from sketch.retopo.editor.arguments import Argument, Flag, Number, Vector, Word
from sketch.retopo.editor.tool import Result, Tool
from sketch.retopo.filling import welded
from sketch.retopo.filling.choosing import filling_of
from sketch.retopo.network import check
from viewer.retopo import RetopoState
from viewer.retopo.keys import ACTIONS, KEY_HELP, KEYS, MODE_KEYS
from viewer.retopo.layout import mode_box, option_under, options_top
from viewer.retopo.modes import NO_MODES, mode_of, modes
from viewer.retopo.pointing import foot_at, visible


@pytest.fixture(scope="module")
def source() -> Iterator[PatternSource]:
    with patterndb.open() as opened:
        yield opened


@pytest.fixture
def state(source: PatternSource) -> Iterator[RetopoState]:
    made = opened(source)
    yield made
    check(made.network)
    made.close()


def curves(state: RetopoState) -> list[int]:
    """The chains that were drawn."""
    return [chain.id for chain in state.network.chains.values() if not chain.marked]


def quads_of(state: RetopoState) -> int:
    return len(state.shown.body.mesh.quads)


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
    assert state.shown.fresh and not state.waiting and not state.message
    assert state.shown.undoable == 4


def test_a_stroke_that_closes_and_a_quick_one_stay_on_the_surface(state: RetopoState) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 9)
    drag(state, *np.stack([np.cos(angle), np.sin(angle)], axis=1).tolist())
    (chain,) = curves(state)
    assert state.network.chains[chain].loose
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
        axes = state.view.axes
        x, y = at(state, place)
        state.press(x, y, turn=turn)
        state.move(x + 30.0, y + 10.0)
        state.release(x + 30.0, y + 10.0)
        assert not np.allclose(state.view.axes, axes)
        keys(state, "3")
    assert not curves(state) and state.calls == ()


def test_a_spine_shows_its_patch_before_it_is_made(state: RetopoState) -> None:
    keys(state, "i")
    press(state, (-1.5, 0.0), (1.5, 0.0))
    state.settle()
    preview = state.preview
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
    assert width == pytest.approx(2.0 * state.brush, rel=0.02)
    assert state.preview is None
    keys(state, "]")
    assert state.brush > 0.5 * width and state.shown.undoable == 1, "a brush is no step"


def test_nearer_by_the_spine_is_narrower(state: RetopoState) -> None:
    keys(state, "i")
    hover(state, (0.0, 0.0))
    before = state.brush
    for _ in range(5):
        state.wheel(1.0)
    assert state.brush == pytest.approx(before / 1.15**5)
    keys(state, "v")
    for _ in range(5):
        state.wheel(-1.0)
    assert state.brush == before


def test_completions_are_shown_stepped_through_and_taken_as_shown(state: RetopoState) -> None:
    keys(state, "i")
    drag(state, (-1.5, 0.0), (1.5, 0.0))
    keys(state, "a")
    hover(state, (0.0, 0.9))
    first = state.preview
    assert first is not None and first.count > 1 and first.number == 0
    keys(state, "-")
    second = state.preview
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
    hover(state, (4.5, 4.5))
    assert state.preview is not None and state.preview.count == 0
    click(state, (4.5, -4.5))
    assert "nothing can be completed here" in state.message
    assert len(state.network.patches) == 2


def test_a_plane_cuts_loops_and_a_stroke_joins_them_to_a_cylinder(source: PatternSource) -> None:
    state = opened(source, tube())
    try:
        # Across the tube, from beside it to beside it.
        state.look_along((1.0, 0.0, 0.0))
        keys(state, "l")
        for z in (-1.0, 1.0):
            press(state, (0.0, -1.4, z), (0.0, 1.4, z))
            state.settle()
            preview = state.preview
            assert preview is not None and len(preview.curves) == 1
            assert np.abs(preview.curves[0][:, 2] - z).max() < 0.01
            line = state.plane_line
            assert line is not None and line[0] != line[1]
            state.release(*at(state, (0.0, 1.4, z)))
            state.settle()
        loops = [state.network.chains[c] for c in curves(state)]
        assert len(loops) == 2 and all(chain.loose for chain in loops)
        keys(state, "c + . .")
        assert state.option(state.mode, state.mode.options[0]) == 5
        drag(state, (1.0, 0.0, -1.0), (1.0, 0.0, 1.0))
        assert [len(patch.corners) for patch in state.network.patches.values()] == [4] * 5
        assert state.calls is not None and state.calls[-1].arguments["division"] == 5
        keys(state, "l")
        drag(state, (0.0, 2.0, -1.0), (0.0, 2.5, -1.0))
        assert state.message == "drag a line across a part of the surface"
        check(state.network)
    finally:
        state.close()


def test_curves_are_erased_by_a_click_a_scribble_and_a_key(state: RetopoState) -> None:
    for y in (-2.0, -1.0, 1.0, 2.0):
        drag(state, (-2.0, y), (2.0, y))
    keys(state, "e")
    hover(state, (0.0, 2.02))
    assert len(state.chains_meant()) == 1
    click(state, (0.0, 2.02))
    assert len(curves(state)) == 3
    drag(state, (1.0, -3.0), (1.0, 0.0))
    (left,) = curves(state)
    assert state.network.chains[left].points[0, 1] == pytest.approx(1.0, abs=0.02)
    hover(state, (0.0, 1.0))
    keys(state, "Delete")
    assert curves(state) == [] and state.shown.undoable == 7
    keys(state, "u u")
    assert len(curves(state)) == 3
    keys(state, "U E")
    assert curves(state) == []
    hover(state, (3.0, 3.0))
    keys(state, "Delete")
    assert state.message == "put the pointer on a curve"


def test_corners_are_toggled_and_wedges_switched(state: RetopoState) -> None:
    square(state)
    keys(state, "j")
    click(state, SQUARE[2])
    (patch,) = state.network.patches.values()
    assert len(patch.corners) == 3
    click(state, SQUARE[2])
    # A T-junction below the square becomes a corner of it, too.
    keys(state, "d")
    drag(state, (0.0, -3.0), (0.0, -1.5))
    keys(state, "j")
    (patch,) = state.network.patches.values()
    assert len(patch.corners) == 4
    drag(state, (0.0, -1.0), (0.0, -1.5))
    (patch,) = state.network.patches.values()
    assert len(patch.corners) == 5
    assert state.calls is not None and set(state.calls[-1].arguments) == {"at", "wedge"}


def test_a_corner_is_pulled_and_shown_on_its_way(state: RetopoState) -> None:
    square(state)
    keys(state, "g")
    hover(state, SQUARE[2])
    assert len(state.snaps()) == 1
    press(state, SQUARE[2], (2.2, 2.0))
    state.settle()
    preview = state.preview
    assert preview is not None and len(preview.curves) == 2
    quads = quads_of(state)
    state.release(*at(state, (2.2, 2.0)))
    state.settle()
    drawn = [state.network.chains[c].points for c in curves(state)]
    for curve in preview.curves:
        assert (
            min(np.abs(curve - points).max() for points in drawn if points.shape == curve.shape)
            < 1e-9
        )
    assert quads_of(state) == quads and not state.message
    places = np.array([node.point[:2] for node in state.network.nodes.values()])
    assert np.abs(places - (2.2, 2.0)).sum(axis=1).min() < 0.02


def test_a_curve_is_drawn_anew_and_made_smooth(state: RetopoState) -> None:
    drag(state, (-2.0, 0.0), (-1.0, 0.6), (0.0, -0.6), (1.0, 0.6), (2.0, 0.0))

    def wave() -> float:
        (chain,) = curves(state)
        return float(np.abs(state.network.chains[chain].points[:, 1]).max())

    before = wave()
    keys(state, "f")
    hover(state, (-0.5, 0.0))
    assert len(state.chains_meant()) == 1
    click(state, (-0.5, 0.0))
    assert wave() < before and not state.message
    keys(state, "r")
    drag(state, (-1.99, 0.0), (0.0, 1.2), (1.99, 0.0))
    assert 1.0 < wave() < 1.25 and not state.message
    keys(state, "z")
    click(state, (0.0, 1.1))
    assert state.calls is not None
    assert state.calls[-1].tool in ("align", "redraw")


def test_what_is_drawn_on_one_half_is_on_both(source: PatternSource) -> None:
    state = opened(source, tube())
    try:
        keys(state, "M")
        plane = state.shown.state.plane
        assert plane is not None and not state.message
        normal = np.array(plane.normal)
        # A square on the half that is worked on, seen from there; the tube has many planes.
        lengthwise = abs(normal[2]) < 0.5
        state.look_along(normal if lengthwise else (1.0, 0.0, 0.0))
        right, up = state.view.axes[:2]
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


def test_a_tangle_becomes_one_corner(state: RetopoState) -> None:
    drag(state, (-2.0, 0.0), (2.0, 0.0))
    drag(state, (-2.0, -0.4), (2.0, 0.3))
    keys(state, "k")
    (cross,) = [node for node in state.network.nodes.values() if node.valence == 4]
    click(state, cross.point.tolist())
    assert state.message == "" or "nothing" in state.message
    assert [node.valence for node in state.network.nodes.values()].count(4) == 1


def test_flow_lines_are_drawn_and_cleared(state: RetopoState) -> None:
    square(state)
    keys(state, "w")
    drag(state, (-1.5, 0.4), (1.5, -0.4))
    (patch,) = state.network.patches.values()
    assert len(filling_of(patch).flows) == 1 and quads_of(state) > 0
    click(state, (0.0, 0.0))
    (patch,) = state.network.patches.values()
    assert filling_of(patch).flows == () and not state.message


def test_the_wheel_changes_counts_and_clicks_pin_them(state: RetopoState) -> None:
    square(state)
    keys(state, "t")
    hover(state, (0.0, -1.5))
    (chain,) = state.chains_meant()
    before = {c: state.network.chains[c].count for c in curves(state)}
    scale = state.view.scale
    state.wheel(1.0)
    state.settle()
    now = state.network.chains
    assert now[chain].count == before[chain] + 1 and now[chain].pinned
    assert sum(now[c].count for c in curves(state)) % 2 == 0 and state.view.scale == scale
    click(state, (0.0, -1.5))
    assert not state.network.chains[chain].pinned
    click(state, (0.0, -1.5))
    assert state.network.chains[chain].pinned
    strip_before = {c: state.network.chains[c].count for c in curves(state)}
    state.wheel(-1.0, shift=True)
    state.settle()
    after = {c: state.network.chains[c].count for c in curves(state)}
    assert sorted(strip_before[c] - after[c] for c in after) == [0, 0, 1, 1]
    # In other modes it needs a modifier, and beside curves the wheel zooms.
    keys(state, "d")
    hover(state, (0.0, -1.5))
    state.wheel(1.0, modifier=True)
    state.settle()
    assert state.network.chains[chain].count == after[chain] + 1
    state.wheel(1.0)
    assert state.view.scale > scale
    keys(state, "t")
    for _ in range(20):
        hover(state, (0.0, -1.5))
        state.wheel(-1.0)
    state.settle()
    assert state.network.chains[chain].count == 1 and "the least is 1" in state.message


def test_the_target_edge_is_a_brush_of_counts(state: RetopoState) -> None:
    square(state)
    few = quads_of(state)
    keys(state, "t [ [ [ [ [")
    assert quads_of(state) > few
    keys(state, "] ] ] ] ] C")
    assert quads_of(state) == few


def test_fills_are_stepped_through_and_back(state: RetopoState) -> None:
    square(state, ((0.0, 2.0), (-1.9, 0.6), (-1.2, -1.6), (1.2, -1.6), (1.9, 0.6)))
    hover(state, (0.0, 0.0))
    (patch,) = state.network.patches.values()
    first = filling_of(patch).choice
    assert state.patch_under() == patch.id and first is not None
    keys(state, "n")
    (patch,) = state.network.patches.values()
    second = filling_of(patch).choice
    assert second is not None and second.quads != first.quads and second.by == "user"
    keys(state, "b")
    (patch,) = state.network.patches.values()
    back = filling_of(patch).choice
    assert back is not None and replace(back, by="program") == first
    keys(state, "y")
    click(state, (0.0, 0.0))
    (patch,) = state.network.patches.values()
    assert filling_of(patch).choice == second
    assert "patch of 5 sides" in texts(state)
    hover(state, (4.0, 4.0))
    assert state.patch_under() is None
    keys(state, "n")
    assert "no patch here" in state.message


def test_what_ends_would_snap_to_is_shown(state: RetopoState) -> None:
    drag(state, (-2.0, 0.0), (2.0, 0.0))
    hover(state, (2.1, 0.1))
    (end,) = state.snaps()
    assert end[:2] == pytest.approx([2.0, 0.0], abs=0.03)
    hover(state, (0.0, 0.1))
    (side,) = state.snaps()
    assert side == pytest.approx([0.0, 0.0, 0.0], abs=0.03)
    press(state, (2.1, 0.1), (2.0, 2.0), (-2.0, 0.15))
    assert len(state.snaps()) == 2
    state.release(*at(state, (-2.0, 0.15)))
    state.settle()
    assert len(state.network.nodes) == 2, "both ends are joined"
    hover(state, (0.0, -3.0))
    assert state.snaps() == []
    before = state.sizes.snap
    keys(state, "]")
    assert state.sizes.snap == pytest.approx(1.15 * before) and state.calls is not None
    assert state.calls[-1].tool == "sizes"


def test_refusals_are_told_and_change_nothing(state: RetopoState) -> None:
    keys(state, "c")
    drag(state, (-1.0, 0.0), (1.0, 0.0))
    assert state.message and not state.shown.undoable and state.calls == ()
    assert state.message in " ".join(texts(state)) or len(state.message) > 60
    keys(state, "u")
    assert state.message == "there is nothing to undo"
    keys(state, "d")
    click(state, (0.0, 0.0))
    assert state.message.startswith("hold the button")
    keys(state, "e ]")
    assert state.message == "erase has no brush"
    keys(state, "t")
    hover(state, (0.0, 0.0))
    keys(state, "+")
    assert state.message == "put the pointer on a curve"
    assert state.calls == ()


def test_the_script_of_a_session_gives_the_same_mesh(
    state: RetopoState, source: PatternSource
) -> None:
    square(state)
    keys(state, "a")
    hover(state, (0.0, 1.4))
    click(state, (0.0, 1.4))
    keys(state, "t")
    hover(state, (0.0, -1.5))
    state.wheel(1.0)
    state.wheel(1.0)
    keys(state, "u U")
    hover(state, (0.0, 0.0))
    keys(state, "n")
    assert state.calls is not None
    again = Editor(sheet(), source)
    for call in state.calls:
        assert again.do(call).changed
        again.fill()
    one, other = state.shown.body.mesh, welded(again.fill())
    assert np.array_equal(one.vertices, other.vertices)
    assert np.array_equal(one.quads, other.quads) and len(one.quads) > 0


def test_while_quads_are_made_all_else_goes_on(
    state: RetopoState, source: PatternSource, monkeypatch: pytest.MonkeyPatch
) -> None:
    square(state)
    keys(state, "i")
    drag(state, (-1.0, 3.0), (1.0, 3.0))
    body, old = state.shown.body, sorted(state.network.patches)
    assert len(old) == 2 and quads_of(state) > 0
    slow, begun = threading.Event(), threading.Event()
    fill = Editor.fill

    def waiting(self: Editor) -> object:
        begun.set()
        assert slow.wait(60.0)
        return fill(self)

    monkeypatch.setattr(Editor, "fill", waiting)
    keys_at = [at(state, point) for point in ((0.0, -1.5), (0.0, 1.5))]
    KEYS.press(state, "d")
    state.move(*keys_at[0])
    state.press(*keys_at[0])
    state.move(0.0, 0.0)
    state.release(*keys_at[1])
    assert begun.wait(60.0)
    try:
        # The curve is there at once; the quads of the patch it cuts are not shown, others are.
        state.poll()
        assert len(state.network.patches) == 3 and not state.shown.fresh
        assert state.shown.body is body
        (stale,) = state.shown.stale()
        assert stale in old and "working …" in texts(state)
        hover_at = at(state, (0.0, 3.0))
        state.move(*hover_at)
        assert state.patch_under() in set(old) - {stale}
        # More calls wait, the view turns, and previews are of the network that is seen.
        state.undo()
        state.undo()
        assert state.waiting == 3 and len(state.network.patches) == 3
        assert state.wheel(1.0) and state.drag_view(3.0, 0.0)
        KEYS.press(state, "a")
        state.move(*at(state, (1.6, 0.0)))
        state._latest.wait()
        state.poll()
        assert state.preview is not None and state.preview.network is state.network
        assert state.preview.count > 0
        state.save_mesh()
        assert state.files is None or "still being made" in state.message
    finally:
        slow.set()
    state.settle()
    assert state.shown.fresh and len(state.network.patches) == 1
    assert state.shown.stale() == frozenset() and not state.waiting
    # What was previewed on the network before is gone with it.
    assert state.preview is None or state.preview.network is state.network
    assert state.calls is not None
    assert [call.tool for call in state.calls[-3:]] == ["stroke", "undo", "undo"]


def test_what_goes_wrong_in_a_thread_is_not_lost(
    state: RetopoState, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(self: Editor) -> object:
        raise ZeroDivisionError("a fault")

    monkeypatch.setattr(Editor, "fill", broken)
    with pytest.raises(ZeroDivisionError, match="a fault"):
        drag(state, (-1.0, 0.0), (1.0, 0.0))


def test_a_session_that_has_patches_gets_its_quads(source: PatternSource) -> None:
    editor = Editor(sheet(), source)
    for k in range(4):
        line = [[*SQUARE[k - 1], 0.0], [*SQUARE[k], 0.0]]
        assert editor.do(Call("stroke", {"points": line})).changed
    state = RetopoState(editor)
    try:
        state.settle()
        assert quads_of(state) > 0 and state.shown.fresh
        state.save_script()
        assert state.calls is None, "it did not begin from the bare surface"
    finally:
        state.close()


def test_every_tool_of_the_table_has_a_mode_and_a_key_of_its_own() -> None:
    made = modes()
    assert {mode.tool for mode in made} == set(TOOLS) - set(NO_MODES)
    known = [mode.key for mode in made if mode.key]
    assert len(set(known)) == len(known)
    assert set(MODE_KEYS) == set(known) and set(MODE_KEYS) <= set(ACTIONS)
    listed = " ".join(names for names, _ in KEY_HELP).split()
    others = set(ACTIONS) - set(MODE_KEYS)
    names = {"Delete": "Del", "BackTab": "Tab"}
    assert {names.get(key, key) for key in others} - {"Tab"} <= set(listed)


def test_a_new_tool_is_a_mode_by_its_entry_in_the_table() -> None:
    def act(work: object, arguments: object) -> Result:
        raise AssertionError

    at_point = Argument(Vector(), "a point")
    click_one = mode_of(
        Tool(
            "shine",
            "Make it shine.",
            {
                "at": at_point,
                "how": Argument(Word(("a", "b")), "how", "b"),
                "times": Argument(Number(1, 9, whole=True), "times", 3),
                "twice": Argument(Flag(), "twice", False),
                "radius": Argument(Number(0.0), "reach", None),
            },
            act,
        )
    )
    assert click_one is not None
    assert (click_one.gesture, click_one.places, click_one.key) == ("click", ("at",), "")
    assert [(o.name, o.values[:2], o.number) for o in click_one.options] == [
        ("how", ("b", "a"), False),
        ("times", (3, 1), True),
        ("twice", (False, True), False),
    ]
    assert (click_one.brush, click_one.given_as) == ("brush", "radius")
    two = mode_of(Tool("shift", "Shift.", {"at": at_point, "to": at_point}, act))
    assert two is not None and (two.gesture, two.places) == ("drag", ("at", "to"))
    none = mode_of(Tool("tidy", "Tidy.", {}, act))
    assert none is not None and none.gesture == "act"
    wants = {"amount": Argument(Number(), "how much")}
    assert mode_of(Tool("measure", "Measure.", wants, act)) is None


def test_the_panel_is_clicked(state: RetopoState) -> None:
    room = state.room

    def press_panel(x: float, y: float) -> None:
        state.press(x - room[0] / 2.0, y - room[1] / 2.0)
        state.release(x - room[0] / 2.0, y - room[1] / 2.0)

    number = next(k for k, mode in enumerate(state.modes) if mode.tool == "cylinder")
    x, y, width, height = mode_box(room[0], number, len(state.modes))
    press_panel(x + width / 2.0, y + height / 2.0)
    assert state.mode.tool == "cylinder"
    names = [option.name for option in state.mode.options]
    row = names.index("caps")
    count = len(state.modes)
    y = options_top(count) - 22.0 * row
    assert option_under(room[0], room[0] + 40.0, y, count, len(names)) == row
    press_panel(room[0] + 40.0, y)
    assert state.option(state.mode, state.mode.options[row]) == "always"
    assert "always" in " ".join(texts(state))
    assert state.foot is None and state.calls == ()
    state.next_mode(-1)
    assert state.mode is state.modes[number - 1]


def test_escape_lets_go_and_leaves_the_help(state: RetopoState) -> None:
    press(state, (-1.0, 0.0), (1.0, 0.0))
    assert state.holding and len(state.line) > 2
    assert state.leave() and not state.holding and state.line == []
    state.release(*at(state, (1.0, 0.0)))
    state.settle()
    assert curves(state) == []
    keys(state, "h")
    assert "Keys" in texts(state)
    assert state.leave() and not state.leave()


def test_looks_and_sizes_of_the_picture(state: RetopoState) -> None:
    square(state)
    keys(state, "x m m")
    assert not state.quads_shown and state.model_look == "hidden"
    keys(state, "x m")
    for key, axis in (("1", 0), ("2", 1), ("3", 2)):
        keys(state, f"v {key}")
        assert np.allclose(state.view.axes[2], np.eye(3)[axis])
        keys(state, key)
        assert np.allclose(state.view.axes[2], -np.eye(3)[axis]), "twice: from behind"
    keys(state, "Z Z Z v F")
    assert state.upright == "y"


def test_what_the_pointer_is_on_is_what_is_seen_there(source: PatternSource) -> None:
    state = opened(source, tube())
    try:
        state.look_along((1.0, 0.0, 0.0))
        rng = np.random.default_rng(4)
        z, y = rng.uniform(-2.9, 2.9, 40), rng.uniform(-0.95, 0.95, 40)
        for one in np.stack([np.sqrt(1.0 - y * y), y, z], axis=1).tolist():
            foot = foot_at(state.view, state.ground, *at(state, one))
            assert foot is not None
            # The tube has flat facets, at most 1 - cos(pi / 48) within the round one.
            assert np.abs(foot.points[0, 1:] - one[1:]).max() < 1e-9
            assert 0.0 <= one[0] - foot.points[0, 0] < 0.02
        assert foot_at(state.view, state.ground, *at(state, (0.0, 1.2, 0.0))) is None
        places = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.3, 0.0]])
        assert visible(state.view, state.ground, places).tolist() == [True, False, True]
    finally:
        state.close()
