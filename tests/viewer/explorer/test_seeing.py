"""What the fill explorer sees: views and rays."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from patterndb.geometry.polyline import arc_length
from query.drawingbase import DrawingBase
from tests.support.viewer.domed import DOME
from viewer.camera import View, fit_view

Points = np.ndarray[tuple[int, ...], np.dtype[np.float64]]


@given(st.lists(st.tuples(st.floats(-300, 300), st.floats(-300, 300)), max_size=8))
def test_a_view_stays_a_view(drags: list[tuple[float, float]]) -> None:
    view = fit_view(DOME.vertices, (0.3, 0.1, 1.0), (0.0, 1.0, 0.0), 580.0, 580.0)
    for k, (x, y) in enumerate(drags):
        at = view.under(x, y)
        view = (view.turned(x, y), view.moved(x, y), view.zoomed(1.3, x, y), view.rolled())[k % 4]
        if k % 4 == 2:
            assert np.allclose(view.seen(at)[:2], (x, y))
    assert np.allclose(view.axes @ view.axes.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(view.axes) > 0.0
    assert np.allclose(view.seen(view.under(12.0, -7.0)), (12.0, -7.0, 0.0), atol=1e-6)


def test_what_is_clicked_is_what_is_seen_there() -> None:
    view = fit_view(DOME.vertices, (0.5, -0.3, 1.0), (0.0, 1.0, 0.0), 580.0, 580.0)
    for base in (DrawingBase(DOME), DrawingBase(None)):
        for x, y in ((0.0, 0.0), (60.0, -40.0), (-80.0, 30.0)):
            at = base.hit(view.under(x, y), view.axes[2])
            assert at is not None
            assert np.allclose(view.seen(at)[:2], (x, y), atol=1e-6)
            assert np.allclose(base.on(at[None])[0][0], at, atol=1e-9)
    assert DrawingBase(DOME).hit(view.under(5000.0, 0.0), view.axes[2]) is None


def test_paths_are_short_and_on_the_surface() -> None:
    base = DrawingBase(DOME)
    view = View(np.eye(3), np.zeros(3), 100.0)
    a, b = (base.hit(view.under(*at), view.axes[2]) for at in ((-130.0, -90.0), (120.0, 100.0)))
    assert a is not None and b is not None
    path = base.path(a, b)
    assert (path[0] == a).all() and (path[-1] == b).all()
    assert np.abs(base.on(path)[0] - path).max() < 1e-9
    t = np.linspace(0.0, 1.0, 400)[:, None]
    straight = base.on(a * (1 - t) + b * t)[0]
    assert arc_length(path)[-1] <= 1.005 * arc_length(straight)[-1]
