"""A roof with a ridge along x at y = 0, for the viewer of feature curves."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.edits import DrawnCurve
from patterndb_sketch.features.snap import Snap
from tests.support.viewer.sayings import read_sheet
from viewer.facts import FactSheet
from viewer.features import FeatureState
from viewer.features.facts import describe_features, tell_hint
from viewer.features.keys import KEYS
from viewer.features.picture import FeaturePainter
from viewer.keymap import Effect

#: The ridge's ends, and places beside it that a user may click.
ENDS = np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])


BESIDE = ((-0.7, 0.04), (0.0, -0.05), (0.7, 0.03))


def grid() -> tuple[Points, NDArray[np.int64]]:
    """Points (v, 3) and triangles (t, 3) of the roof z = -|y|, in both senses by turns."""
    n, m = 16, 12
    x, y = np.meshgrid(np.linspace(-1.0, 1.0, n + 1), np.linspace(-0.6, 0.6, m + 1))
    points = np.stack([x.ravel(), y.ravel(), -np.abs(y.ravel())], axis=1)
    a = (np.arange(m)[:, None] * (n + 1) + np.arange(n)).ravel()
    quads = np.stack([a, a + 1, a + n + 2, a + n + 1], axis=1)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    faces[::3] = faces[::3, ::-1]
    return points, faces


@cache
def tent() -> Surface:
    """The roof."""
    return Surface.from_soup(PolygonMesh.from_faces(*grid()))


def opened(**options: object) -> FeatureState:
    """A state on the roof, drawn once, and seen from above."""
    state = FeatureState(tent(), **options)  # type: ignore[arg-type]
    drawn(state)
    state.camera.look_along((0.0, 0.0, 1.0))
    return state


def drawn(state: FeatureState) -> list[str]:
    """The texts of the picture and beside it."""
    sheet = FactSheet()
    describe_features(sheet, state)
    seen = [text.text for text in FeaturePainter().compose(state, 1040.0, 860.0).scene.texts]
    return [*seen, *read_sheet(sheet), tell_hint(state), state.message]


def at(state: FeatureState, *point: float) -> tuple[float, float]:
    """Where a point of space is seen."""
    x, y, _ = state.camera.view.seen(np.array(point))
    return float(x), float(y)


def click(state: FeatureState, x: float, y: float) -> None:
    """A click at a place of the picture."""
    state.move(x, y)
    state.press(x, y)
    state.release(x, y)
    state.settle()


def drag(state: FeatureState, *places: tuple[float, float]) -> None:
    """A drag through places of the picture."""
    state.move(*places[0])
    state.press(*places[0])
    for place in places[1:]:
        state.move(*place)
        state.settle()
    state.release(*places[-1])
    state.settle()


def keys(state: FeatureState, text: str) -> None:
    """Keys, each once all before is done."""
    for key in text.split():
        assert KEYS.press(state, key) is Effect.REDRAW
        state.settle()


def picked(state: FeatureState, places: tuple[tuple[float, float], ...] = BESIDE) -> None:
    """A curve through places of the roof, finished."""
    keys(state, "c")
    for x, y in places:
        click(state, *at(state, x, y, -abs(y)))
    keys(state, "Enter")


#: How far a curve may be off the ridge: ribs are sampled so densely.
ON_RIDGE = 0.01


def curve_of(state: FeatureState) -> DrawnCurve:
    curve = state.editing.curve
    assert curve is not None
    return curve


def line_of(state: FeatureState, curve: DrawnCurve | None = None) -> np.ndarray:
    look = state.editing.look(curve_of(state) if curve is None else curve)
    assert look is not None
    return look.line


def held(state: FeatureState) -> Snap:
    snap = state.editing.snap_of(curve_of(state))
    assert snap is not None
    return snap
