"""Closed curves in the viewer of feature curves: closed by a click, by a key, opened again."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.session import FEATURE_SESSION, FeatureSession
from patterndb_sketch.features.snap import SnapSettings
from tests.support.viewer.tents import click, curve_of, drawn, held, keys, line_of
from viewer.features import FeatureState
from viewer.features.facts import CLOSING, HINTS

#: The radii of the frustum's rim, at z = 0, and of its foot, and where that is.
TOP, FOOT, HEIGHT = 0.5, 0.9, -0.5


def frustum() -> Surface:
    """A cone cut off at z = 0, whose rim there is a circle of radius TOP."""
    count = 72
    turn = np.arange(count) * 2.0 * np.pi / count
    circle = np.stack([np.cos(turn), np.sin(turn), np.zeros(count)], axis=1)
    rings = [circle * 1e-3, circle * TOP, circle * FOOT + [0.0, 0.0, HEIGHT]]
    a = np.arange(count)
    b = (a + 1) % count
    faces = [np.stack([low + a, low + count + a, low + b], axis=1) for low in (0, count)] + [
        np.stack([low + b, low + count + a, low + count + b], axis=1) for low in (0, count)
    ]
    return Surface.from_soup(PolygonMesh.from_faces(np.concatenate(rings), np.concatenate(faces)))


def beside(count: int = 7) -> Points:
    """(count, 3) places beside the rim, on the top."""
    turn = 0.2 + np.arange(count) * 2.0 * np.pi / count
    radius = TOP - 0.03 - 0.015 * np.sin(3.0 * np.arange(count))
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), np.zeros(count)], axis=1)


@pytest.fixture
def state() -> Iterator[FeatureState]:
    state = FeatureState(frustum())
    drawn(state)
    state.camera.look_along((0.0, 0.0, 1.0))
    yield state
    state.close()


def at(state: FeatureState, place: Points) -> tuple[float, float]:
    x, y, _ = state.camera.view.seen(place).tolist()
    return x, y


def draw_around(state: FeatureState) -> None:
    keys(state, "c")
    for place in beside():
        click(state, *at(state, place))


def assert_rim(state: FeatureState) -> None:
    """The line shown is the whole rim, and ends where it begins."""
    line = line_of(state)
    assert (line[0] == line[-1]).all()
    assert np.abs(np.linalg.norm(line[:, :2], axis=1) - TOP).max() < 0.01
    angles = np.unwrap(np.arctan2(line[:, 1], line[:, 0]))
    assert abs(angles[-1] - angles[0]) == pytest.approx(2.0 * np.pi)


def test_a_click_on_the_first_point_closes_and_finishes(state: FeatureState) -> None:
    """Not before there are three; the hint says so, and one undo takes the curve back."""
    places = beside()
    keys(state, "c")
    for count, place in enumerate(places[:3], 1):
        click(state, *at(state, place))
        state.move(*at(state, places[0]))
        assert state.closing == (count == 3)
        assert (CLOSING in drawn(state)) == (count == 3)
    state.move(*at(state, places[1]))
    assert not state.closing and HINTS[3] in drawn(state)
    for place in places[3:]:
        click(state, *at(state, place))
    click(state, *at(state, places[0]))
    assert state.editing.clicks is None and curve_of(state).closed
    assert len(curve_of(state).clicked) == len(places)
    assert_rim(state)
    assert any("closed" in text for text in drawn(state))
    keys(state, "u")
    assert not state.editing.edits.curves


def test_a_key_closes_and_opens_a_curve(state: FeatureState) -> None:
    """While it is drawn and afterwards, as steps that can be taken back."""
    draw_around(state)
    keys(state, "l")
    assert state.editing.preview is not None and state.editing.preview.closed
    keys(state, "BackSpace")
    assert state.editing.preview.closed and len(state.editing.preview.clicked) == 6
    click(state, *at(state, beside()[-1]))
    keys(state, "Enter")
    assert_rim(state)
    keys(state, "l")
    assert not curve_of(state).closed
    line = line_of(state)
    assert np.linalg.norm(line[0] - line[-1]) > 0.1
    keys(state, "u")
    assert_rim(state)
    keys(state, "U l")
    assert_rim(state)


def test_too_few_clicks_stay_open(state: FeatureState) -> None:
    keys(state, "l")
    assert state.message == "select a curve first: click on it"
    keys(state, "c l")
    assert state.message == "click three points of the model at least"
    for place in beside()[:2]:
        click(state, *at(state, place))
    keys(state, "l")
    assert "needs at least 3 places" in state.message
    assert state.editing.preview is not None and not state.editing.preview.closed
    click(state, *at(state, beside()[2]))
    keys(state, "l")
    assert state.editing.preview.closed
    keys(state, "BackSpace")
    assert not state.editing.preview.closed


def test_pins_stay_where_they_are_when_a_curve_is_closed(state: FeatureState) -> None:
    """At the samples that are nearest then; the closed curve passes through them."""
    draw_around(state)
    keys(state, "Enter")
    numbers = (10, 40)
    places = held(state).curve.samples[list(numbers)] * [1.02, 1.02, 1.0]
    curve = curve_of(state)
    for number, place in zip(numbers, places, strict=True):
        curve = curve.pinned(number, place)
    state.editing.revise(curve)
    state.settle()
    keys(state, "l")
    found = held(state).curve
    assert found.spline.closed and len(found.constraints) == 2
    for number, place in found.constraints:
        met = found.spline.evaluate(found.parameters[number])[0]
        assert met == pytest.approx(np.asarray(place), abs=1e-9)
    assert sorted(tuple(p) for _, p in found.constraints) == sorted(map(tuple, places))


def test_sessions_keep_curves_closed(state: FeatureState, tmp_path: Path) -> None:
    """What is read is shown as it was, stays closed when it is changed, and can be opened."""
    draw_around(state)
    click(state, *at(state, beside()[0]))
    FEATURE_SESSION.write(tmp_path / "a.session", state.editing.session())
    kept: FeatureSession = FEATURE_SESSION.read(tmp_path / "a.session")
    other = FeatureState(frustum(), session=kept, settings=SnapSettings())
    try:
        drawn(other)
        keys(other, "Tab")
        assert curve_of(other).closed
        assert (line_of(other) == line_of(state)).all()
        keys(other, ".")
        assert_rim(other)
        keys(other, "l")
        assert not curve_of(other).closed
    finally:
        other.close()
