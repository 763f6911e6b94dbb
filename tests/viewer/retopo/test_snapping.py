"""Snapping in the window of retopology: finer from nearer by, and the same in a script."""

from __future__ import annotations

import numpy as np
import pytest

from patterndb_sketch.retopo.editor import Call, Retopology
from patterndb_sketch.retopo.filling import weld_patches
from patterndb_sketch.retopo.network import are_equal
from patterndb_sketch.retopo.table import TOOLS
from query.engine import PatternSource
from tests.support.viewer.sheets import (
    SQUARE,
    at,
    click,
    curves,
    drag,
    hover,
    keys,
    press,
    quads_of,
    sheet,
    square,
)
from viewer.retopo import RetopoState
from viewer.retopo.aiming import ZOOMS


def nearer(state: RetopoState, steps: int, point: tuple[float, float]) -> float:
    """Zoom about a point; how much larger things are."""
    hover(state, point)
    before = state.camera.view.scale
    for _ in range(steps):
        state.wheel(1.0)
    return state.camera.view.scale / before


def test_from_nearer_by_less_is_snapped_to(state: RetopoState) -> None:
    drag(state, (-2.0, 0.0), (2.0, 0.0))
    snap = state.sizes.snap
    beside = (0.0, 0.6 * snap)
    hover(state, beside)
    assert state.tool.reach == snap and len(state.tool.snaps()) == 1
    factor = nearer(state, 6, beside)
    assert state.tool.reach == pytest.approx(snap / factor) and state.tool.snaps() == []
    # As far from the curve on the screen as it snapped at first.
    hover(state, (0.0, 0.6 * snap / factor))
    assert len(state.tool.snaps()) == 1
    assert state.sizes.snap == snap, "what the user has said stays"
    # Never more than was said, and not so little that nothing is ever met.
    keys(state, "3")
    nearer(state, -1, beside)
    for _ in range(12):
        state.wheel(-1.0)
    assert state.tool.reach == snap
    for _ in range(60):
        state.wheel(1.0)
    assert state.tool.reach == pytest.approx(ZOOMS[0] * snap)


def test_what_is_shown_to_snap_does_and_what_is_not_does_not(state: RetopoState) -> None:
    drag(state, (-2.0, 0.0), (2.0, 0.0))
    snap = state.sizes.snap
    nearer(state, 8, (0.0, 0.0))
    off = 0.5 * snap
    for shift, joined in ((off, False), (0.5 * state.tool.reach, True)):
        before = len(state.network.nodes)
        press(state, (0.1, 3.0 * snap), (0.1, shift))
        assert (len(state.tool.snaps()) == 1) == joined
        state.release(*at(state, (0.1, shift)))
        state.settle()
        ends = [node for node in state.network.nodes.values() if node.valence == 3]
        assert len(ends) == joined
        assert len(state.network.nodes) == before + 2
        assert (
            state.editing.calls is not None
            and state.editing.calls[-1].arguments["snap"] == state.tool.reach
        )
        keys(state, "u")
    assert len(curves(state)) == 1


def test_calls_from_nearer_by_give_the_same_in_a_script(
    state: RetopoState, source: PatternSource
) -> None:
    square(state)
    nearer(state, 5, (0.2, -1.4))
    drag(state, (0.2, -1.51), (0.25, -2.1))
    keys(state, "g")
    drag(state, (0.25, -2.1), (0.4, -2.2))
    keys(state, "f")
    click(state, (0.3, -1.85))
    keys(state, "4")
    click(state, (0.5, -1.5))
    keys(state, "v")
    assert state.editing.calls is not None and len(state.editing.calls) >= 7
    assert sum("snap" in call.arguments for call in state.editing.calls) >= 3
    again = Retopology(sheet(), source)
    for call in state.editing.calls:
        assert again.do(call).changed
        again.fill()
    assert are_equal(again.network, state.network) and again.sizes == state.sizes
    assert np.array_equal(weld_patches(again.fill()).vertices, state.shown.body.mesh.vertices)
    assert quads_of(state) > 0


@pytest.mark.parametrize("factor", [0.3, 1.0, 2.5])
def test_a_call_s_radius_is_that_of_sizes_for_once(source: PatternSource, factor: float) -> None:
    def drawn(*, told: bool) -> Retopology:
        editor = Retopology(sheet(), source)
        snap = factor * editor.sizes.snap
        if not told:
            editor.do(Call("sizes", {"snap": snap}))
        given = {"snap": snap} if told else {}
        lines = [[[*SQUARE[k - 1], 0.0], [*SQUARE[k], 0.0]] for k in range(4)]
        lines.append([[0.0, -1.25, 0.0], [0.1, 1.35, 0.0]])
        for line in lines:
            assert editor.do(Call("stroke", {"points": line, **given})).changed
        return editor

    one, other = drawn(told=True), drawn(told=False)
    assert are_equal(one.network, other.network)
    assert one.sizes == Retopology(sheet(), source).sizes != other.sizes or factor == 1.0


def test_a_radius_out_of_proportion_is_an_error(source: PatternSource) -> None:
    editor = Retopology(sheet(), source)
    line = {"points": [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]}
    with pytest.raises(ValueError, match="stroke: snap is 1e-11; on this surface give"):
        editor.do(Call("stroke", line | {"snap": 1e-11}))
    assert not TOOLS["loop"].snaps
    with pytest.raises(ValueError, match="snap"):
        editor.do(Call("loop", {"at": [0, 0, 0], "normal": [1, 0, 0], "snap": 0.1}))


def test_with_ctrl_curves_are_moved_whatever_the_tool_is(state: RetopoState) -> None:
    """The one at the pointer where there are no quads, else the brush; the tool stays."""
    drag(state, (-2.0, 0.0), (2.0, 0.0))
    keys(state, "k")
    for made, begin in (("pull", (0.0, 0.0)), ("brush", (0.0, -1.5))):
        mode = state.tool.mode
        state.press(*at(state, begin), tweak=True)
        state.move(*at(state, (begin[0], begin[1] + 0.1)))
        state.move(*at(state, (begin[0], begin[1] + 0.3)))
        state.release(*at(state, (begin[0], begin[1] + 0.3)))
        state.settle()
        assert state.editing.calls is not None
        assert state.editing.calls[-1].tool == made, state.message
        assert state.tool.mode is mode
        if made == "pull":
            (chain,) = curves(state)
            assert state.network.chains[chain].points[:, 1].max() == pytest.approx(0.3, abs=0.05)
            keys(state, "u u")
            square(state)
            keys(state, "k")
