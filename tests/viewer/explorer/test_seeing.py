"""What the fill explorer sees: views, rays, and what hides what."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb._native.viewer.solid import fill_triangles
from patterndb.geometry.polyline import arc_length
from query.drawingbase import DrawingBase
from tests.support.viewer.domed import DOME
from viewer.camera import View, fit_view
from viewer.solid import Hiding, Solid, spread_farthest

Points = np.ndarray[tuple[int, ...], np.dtype[np.float64]]


def paint_reference(corners: Points, shape: tuple[int, int]) -> np.ndarray:
    """(h, w) which triangle is seen at a pixel, -1 for none; see viewer.solid.paint."""
    seen = np.full(shape, -1)
    best = np.full(shape, -np.inf)
    for t, (a, b, c) in enumerate(corners):
        m = np.array([[a[0], b[0], c[0]], [a[1], b[1], c[1]], [1.0, 1.0, 1.0]])
        if abs(np.linalg.det(m)) < 1e-9:
            continue
        for i in range(shape[0]):
            for j in range(shape[1]):
                weights = np.linalg.solve(m, [j + 0.5, i + 0.5, 1.0])
                z = weights @ [a[2], b[2], c[2]]
                if weights.min() >= 0.0 and z > best[i, j]:
                    best[i, j], seen[i, j] = z, t
    return seen


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_the_nearest_triangle_is_seen_at_every_pixel(seed: int) -> None:
    chance = np.random.default_rng(seed)
    corners = chance.uniform(-3.0, 13.0, (6, 3, 3))
    colours = np.repeat(np.arange(1.0, 7.0), 9).reshape(6, 3, 3).astype(np.float32)
    depth = np.full((9, 11), -np.inf, np.float32)
    image = np.zeros((9, 11, 3), np.float32)
    fill_triangles(corners, colours, depth, image)
    wanted = paint_reference(corners, (9, 11))
    assert (np.round(image[..., 0]).astype(int) - 1 == wanted).all()
    assert (np.isneginf(depth) == (wanted < 0)).all()
    nearby = spread_farthest(depth)
    for i, j in ((0, 0), (4, 5), (8, 10)):
        around = depth[max(i - 1, 0) : i + 2, max(j - 1, 0) : j + 2]
        assert nearby[i, j] == around.min()


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


def test_what_lies_behind_is_hidden() -> None:
    view = View(np.eye(3), np.zeros(3), 100.0)
    solid = Solid.of(view, (300.0, 300.0), DOME, None)
    hiding = Hiding(solid, 600.0, 600.0)
    top = np.array([[0.0, 0.0, 0.8], [1.0, 0.3, 0.8 - 0.2 * 1.09]])
    shift = np.array([300.0, 300.0, 0.0])
    assert hiding.visible(view.seen(top) + shift).all()
    assert not hiding.visible(view.seen(top - (0.0, 0.0, 1.0)) + shift).any()
    beside = np.array([[2.8, 0.0, -5.0]])
    assert hiding.visible(view.seen(beside) + shift).all()
