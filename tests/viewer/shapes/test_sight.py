"""What of a shape is in sight, and what is near to the pointer."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import KDTree

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.surface import Surface
from tests.support.viewer.shapes import keys, seen
from viewer.keymap import Effect
from viewer.shapes import ShapesState
from viewer.shapes.commands import KEYS
from viewer.shapes.sight import refine_line


def test_curves_in_sight_are_what_rays_meet_first(state: ShapesState) -> None:
    """Against rays through the triangles: a curve's vertex is in sight if nothing is in front
    of it, and not if something is, there and around. Beside the rim of what hides it, it may be
    either."""
    model = Surface.from_soup(PolygonMesh.from_faces(state.shaping.points, state.skin.vertices))
    around = 7.0 * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [-1, -1]])
    for turn in ((0.0, 0.0), (250.0, 40.0), (-120.0, 180.0)):
        state.camera.aim(state.camera.view.turned(*turn))
        places = np.concatenate(state.sight.lines)
        points = np.concatenate([state.shaping.points[one.vertices] for one in state.skin.lines])
        axes, far = state.camera.view.axes, 2.0 * state.shaping.size
        ahead = []
        for shift in around:
            starts = points + far * axes[2] + shift @ axes[:2] / state.camera.view.scale
            hits = model.cast_rays(starts, np.tile(-axes[2], (len(points), 1)))
            # A ray beside the shape meets nothing: then nothing is in front.
            ahead.append(np.where(hits.found, far - hits.distances, 0.0) * state.camera.view.scale)
        shown = state.sight.visible(places)
        clear, hidden = ahead[0] < 0.5, np.min(ahead, axis=0) > 25.0
        assert clear.sum() > 20 and hidden.sum() > 20
        # Between two of the rays there may be a seam that one sees through.
        assert shown[clear].all() and shown[hidden].mean() < 0.04


def test_the_nearest_curve_in_sight_is_grabbed(state: ShapesState) -> None:
    assert state.line_under() is None
    where = seen(state, "roof_rail")
    state.move(*where)
    line = state.under()
    assert line is not None and (line.title, line.mirrored) == ("roof rail", False)
    keys(state, "w")
    assert state.under() is None
    keys(state, "w 2")
    # From the side the image lies behind.
    state.move(*seen(state, "shoulder", mirrored=True))
    line = state.under()
    assert line is not None and not line.mirrored
    state.move(state.camera.room[0] / 2.0 + 40.0, 0.0)
    assert state.under() is None


def test_a_ghost_is_drawn_where_it_is_in_sight(state: ShapesState) -> None:
    """The lines of its drawing are in sight all along, whatever hides the shape itself; what is
    left out of a curve is not, or is a glimpse."""
    keys(state, "n n g")
    sight = state.ghost_sight
    assert sight is not None and state.ghost_sight is sight
    drawn = np.concatenate([refine_line(line, 2.0)[0] for line in sight.drawing])
    assert sight.visible(drawn).mean() > 0.97
    near = KDTree(drawn[:, :2])
    for line in sight.lines:
        fine, own = refine_line(line, 2.0)
        assert np.array_equal(fine[own], line)
        assert np.linalg.norm(np.diff(fine[:, :2], axis=0), axis=1).max() < 2.0 + 1e-9
        shown = sight.visible(fine)
        if shown.all() and np.linalg.norm(fine[0, :2] - fine[-1, :2]) > 20.0:
            assert near.query(fine[:, :2])[0].max() < 1e-6
    keys(state, "2")
    assert state.ghost_sight is not sight


def test_views_and_switches(state: ShapesState) -> None:
    first, scale = state.camera.view.axes.copy(), state.camera.view.scale
    for key, axis, sign in (("1", 0, -1.0), ("2", 1, -1.0), ("3", 2, 1.0)):
        keys(state, key)
        assert state.camera.view.axes[2] == pytest.approx(sign * np.eye(3)[axis], abs=1e-12)
        assert state.camera.view.scale <= scale
        # All of it is in the picture.
        assert (
            np.abs(state.sight.seen[:, :2]).max(axis=0) < np.array(state.camera.room) / 2.0
        ).all()
    keys(state, "v")
    assert np.array_equal(state.camera.view.axes, first)
    for key, name in (("e", "edges_shown"), ("w", "curves_shown")):
        before = getattr(state, name)
        keys(state, key)
        assert getattr(state, name) is not before
    assert KEYS.press(state, "Escape") is Effect.REDRAW and not state.dragging


def test_the_view_turns_shifts_and_zooms(state: ShapesState) -> None:
    nowhere = (0.0, state.camera.room[1] / 2.0 - 8.0)
    first = state.camera.view
    assert not state.press(*nowhere)
    assert state.move(40.0, nowhere[1] - 30.0)
    assert not state.release(40.0, nowhere[1] - 30.0)
    assert state.camera.view.axes == pytest.approx(first.turned(40.0, -30.0).axes)
    assert not state.shaping.choice.coefficients.any()
    # The other button turns even on a curve.
    at = seen(state, "shoulder")
    state.press(*at, turn=True)
    state.move(at[0] + 20.0, at[1])
    state.release(at[0] + 20.0, at[1])
    assert not state.shaping.choice.coefficients.any() and not state.shaping.choice.held
    assert state.wheel(2.0) and state.camera.view.scale > first.scale
    focus = state.camera.view.focus
    assert state.drag_view(10.0, 5.0) and not np.allclose(state.camera.view.focus, focus)
    assert not state.poll()
