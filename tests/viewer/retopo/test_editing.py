"""Curves that are there, changed in the window of retopology."""

from __future__ import annotations

import numpy as np
import pytest

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
    square,
)
from viewer.retopo import RetopoState


def test_curves_are_erased_by_a_click_a_scribble_and_a_key(state: RetopoState) -> None:
    for y in (-2.0, -1.0, 1.0, 2.0):
        drag(state, (-2.0, y), (2.0, y))
    keys(state, "e")
    hover(state, (0.0, 2.02))
    assert len(state.tool.chains_meant()) == 1
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
    assert state.editing.calls is not None and set(state.editing.calls[-1].arguments) == {
        "at",
        "wedge",
    }


def test_a_corner_is_pulled_and_shown_on_its_way(state: RetopoState) -> None:
    square(state)
    keys(state, "g")
    hover(state, SQUARE[2])
    assert len(state.tool.snaps()) == 1
    press(state, SQUARE[2], (2.2, 2.0))
    state.settle()
    preview = state.tool.preview
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
    assert len(state.tool.chains_meant()) == 1
    click(state, (-0.5, 0.0))
    assert wave() < before and not state.message
    keys(state, "r")
    drag(state, (-1.99, 0.0), (0.0, 1.2), (1.99, 0.0))
    assert 1.0 < wave() < 1.25 and not state.message
    keys(state, "z")
    click(state, (0.0, 1.1))
    assert state.editing.calls is not None
    assert state.editing.calls[-1].tool in ("align", "redraw")


def test_a_tangle_becomes_one_corner(state: RetopoState) -> None:
    drag(state, (-2.0, 0.0), (2.0, 0.0))
    drag(state, (-2.0, -0.4), (2.0, 0.3))
    keys(state, "k")
    (cross,) = [node for node in state.network.nodes.values() if node.valence == 4]
    click(state, cross.point.tolist())
    assert state.message == "" or "nothing" in state.message
    assert [node.valence for node in state.network.nodes.values()].count(4) == 1
