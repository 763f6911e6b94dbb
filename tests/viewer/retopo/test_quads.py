"""Counts and fills in the window of retopology."""

from __future__ import annotations

from dataclasses import replace

from patterndb_sketch.retopo.filling.fills import filling_of
from tests.support.viewer.sheets import click, curves, drag, hover, keys, quads_of, square, texts
from viewer.retopo import RetopoState


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
    (chain,) = state.tool.chains_meant()
    before = {c: state.network.chains[c].count for c in curves(state)}
    scale = state.camera.view.scale
    state.wheel(1.0)
    state.settle()
    now = state.network.chains
    assert now[chain].count == before[chain] + 1 and now[chain].pinned
    assert sum(now[c].count for c in curves(state)) % 2 == 0 and state.camera.view.scale == scale
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
    assert state.camera.view.scale > scale
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
    assert state.tool.patch_under() == patch.id and first is not None
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
    assert state.tool.patch_under() is None
    keys(state, "n")
    assert "no patch here" in state.message
