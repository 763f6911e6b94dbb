"""Dragging curves: a simulated drag lands where it should, in both kinds of views."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from vtkmodules.vtkRenderingCore import vtkCamera

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.drag import MatrixCamera, begin_drag, move_drag
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.splines import fit_spline
from tests.support.features.models import sphere, sphere_model, together

SPHERE = sphere_model()
SIZE = (800, 600)
EYE, FOCUS, UP = (4.0, -3.0, 2.0), (0.1, 0.0, -0.1), (0.0, 0.1, 1.0)

PERSPECTIVE = MatrixCamera.perspective(EYE, FOCUS, UP, 0.6, SIZE, (0.5, 50.0))
PARALLEL = MatrixCamera.parallel(EYE, FOCUS, UP, 2.6, SIZE, (0.5, 50.0))
both_views = pytest.mark.parametrize("view", [PERSPECTIVE, PARALLEL], ids=["with", "without"])


def latitude(height: float = 0.3, m: int = 120, radius: float = 1.0) -> np.ndarray:
    """Samples on the sphere, round it at about a height."""
    turn = np.linspace(-np.pi, np.pi, m)
    round_it = np.stack([np.cos(turn), np.sin(turn), np.full(m, height)], axis=1)
    return sphere_model(radius).nearest(radius * round_it).points


def front_sample(view: MatrixCamera, samples: np.ndarray) -> int:
    """The number of the sample that is farthest to the front."""
    return int(
        np.argmin(np.linalg.norm(samples - view.rays(np.array([[400.0, 300.0]]))[0], axis=1))
    )


class TestView:
    @both_views
    def test_is_that_of_the_drawing_library(self, view: MatrixCamera) -> None:
        camera = vtkCamera()
        camera.SetPosition(*EYE)
        camera.SetFocalPoint(*FOCUS)
        camera.SetViewUp(*UP)
        camera.SetClippingRange(0.5, 50.0)
        camera.SetViewAngle(np.degrees(0.6))
        camera.SetParallelProjection(view is PARALLEL)
        camera.SetParallelScale(1.3)
        theirs = camera.GetCompositeProjectionTransformMatrix(SIZE[0] / SIZE[1], -1.0, 1.0)
        matrix = np.array([[theirs.GetElement(i, j) for j in range(4)] for i in range(4)])
        assert view.matrix == pytest.approx(matrix, abs=1e-9)

    @both_views
    @given(st.integers(0, 2**32))
    def test_rays_pass_through_what_is_seen(self, view: MatrixCamera, seed: int) -> None:
        points = np.random.default_rng(seed).uniform(-1.0, 1.0, (20, 3))
        origins, ways = view.rays(view.seen_at(points))
        assert np.linalg.norm(ways, axis=1) == pytest.approx(np.ones(20))
        off = np.cross(points - origins, ways)
        assert np.abs(off).max() < 1e-9
        assert (np.einsum("nc,nc->n", points - origins, ways) > 0.0).all()
        if view is PARALLEL:
            assert np.ptp(ways, axis=0).max() < 1e-9

    def test_the_middle_and_what_is_behind(self) -> None:
        for view in (PERSPECTIVE, PARALLEL):
            assert view.seen_at(np.array([FOCUS]))[0] == pytest.approx([400.0, 300.0])
        behind = 2.0 * np.array([EYE]) - FOCUS
        assert np.isnan(PERSPECTIVE.seen_at(behind)).all()

    def test_refusals(self) -> None:
        for matrix, size, what in (
            (np.eye(3), SIZE, "4, 4"),
            (np.zeros((4, 4)), SIZE, "inverted"),
            (np.eye(4), (0, 600), "shows nothing"),
        ):
            with pytest.raises(InvalidFeatureError, match=what):
                MatrixCamera(matrix, size)
        with pytest.raises(InvalidFeatureError, match="along the line of sight"):
            MatrixCamera.parallel([0, 0, 1], [0, 0, 0], [0, 0, 1], 1.0, SIZE, (0.1, 9.0))


class TestDrag:
    @both_views
    @settings(max_examples=40)
    @given(st.integers(0, 2**32))
    def test_lands_where_it_should(self, view: MatrixCamera, seed: int) -> None:
        """Press near a sample, go as far as from the sample to a target: it is at the target,
        and the curve refitted passes through it."""
        rng = np.random.default_rng(seed)
        samples = latitude()
        chosen = front_sample(view, samples) + int(rng.integers(-15, 16))
        at = view.seen_at(samples)[chosen]
        pressed = at + rng.uniform(-1.0, 1.0, 2)
        drag = begin_drag(view, SPHERE, samples, pressed)
        assert abs(drag.sample - chosen) <= 1
        # A place of the surface that is seen from here: what a ray to it meets first.
        aim = samples[chosen] + rng.uniform(-0.3, 0.3, 3)
        seen = SPHERE.cast_rays(*view.rays(view.seen_at(aim[None])))
        assume(seen.found[0])
        target = seen.points[0]
        path = view.seen_at(target[None])[0] - view.seen_at(samples)[drag.sample]
        for share in (0.3, 0.7, 1.0):
            drag = move_drag(drag, SPHERE, pressed + share * path)
        assert drag.point == pytest.approx(target, abs=1e-9) and not drag.missed
        number, point = drag.constraint
        fit = fit_spline(samples, constraints=[(number, point)])
        assert np.linalg.norm(fit.spline(fit.parameters[number])[0] - target) < 1e-8

    @both_views
    def test_without_moving_the_sample_stays(self, view: MatrixCamera) -> None:
        samples = latitude()
        pressed = view.seen_at(samples)[front_sample(view, samples)] + [2.0, 3.0]
        drag = begin_drag(view, SPHERE, samples, pressed)
        assert (drag.point == samples[drag.sample]).all()
        assert move_drag(drag, SPHERE, pressed).point == pytest.approx(drag.point, abs=1e-9)

    @both_views
    def test_the_front_most_of_two_layers_counts(self, view: MatrixCamera) -> None:
        model = Surface.from_soup(PolygonMesh.from_faces(*together(sphere(), sphere(radius=0.6))))
        samples = latitude(radius=0.6)
        inner = front_sample(view, samples)
        pressed = view.seen_at(samples)[inner]
        drag = begin_drag(view, model, samples, pressed)
        drag = move_drag(drag, model, pressed + np.array([5.0, -7.0]))
        # The curve was on the inner sphere; what is seen there is the outer.
        assert np.linalg.norm(drag.point) > 0.95
        assert drag.point @ (np.array(EYE) - FOCUS) > 0.0
        alone = move_drag(drag, sphere_model(0.6), pressed + np.array([5.0, -7.0]))
        assert np.linalg.norm(alone.point) < 0.61

    @both_views
    def test_a_ray_that_misses_keeps_the_last_hit(self, view: MatrixCamera) -> None:
        samples = latitude()
        pressed = view.seen_at(samples)[front_sample(view, samples)]
        drag = begin_drag(view, SPHERE, samples, pressed)
        away = move_drag(drag, SPHERE, pressed + np.array([900.0, 0.0]))
        assert away.missed and (away.point == samples[drag.sample]).all()
        hit = move_drag(away, SPHERE, pressed + np.array([20.0, 10.0]))
        assert not hit.missed and np.linalg.norm(hit.point - drag.point) > 0.01
        again = move_drag(hit, SPHERE, pressed + np.array([0.0, -900.0]))
        assert again.missed and (again.point == hit.point).all()
        assert again.constraint[0] == drag.sample

    @both_views
    @settings(max_examples=30)
    @given(st.integers(0, 2**32))
    def test_the_nearest_sample_in_the_window(self, view: MatrixCamera, seed: int) -> None:
        rng = np.random.default_rng(seed)
        samples = latitude()
        # Of a curve on the front alone none is hidden.
        front = samples[np.abs(np.arange(120) - front_sample(view, samples)) < 20]
        pressed = rng.uniform(0.0, 1.0, 2) * SIZE
        drag = begin_drag(view, SPHERE, front, pressed)
        away = np.linalg.norm(view.seen_at(front) - pressed, axis=1)
        assert drag.sample == np.argmin(away)

    def test_the_back_of_a_curve_is_not_taken_for_its_front(self) -> None:
        level = MatrixCamera.parallel([0.0, -4, 0], [0, 0, 0], [0, 0, 1], 2.6, SIZE, (0.5, 50.0))
        samples = latitude(0.0, 121)
        # Front and back are seen at the same places; the back a little nearer to the pointer.
        seen = level.seen_at(samples)
        back = int(np.argmax(samples[:, 1]))
        drag = begin_drag(level, SPHERE, samples, seen[back] + [0.5, 0.0])
        assert samples[drag.sample, 1] < 0.0
        # Where no visible one is near, the hidden one is meant.
        behind = samples[samples[:, 1] > 0.3]
        drag = begin_drag(level, SPHERE, behind, level.seen_at(behind)[4])
        assert drag.sample == 4

    def test_refusals(self) -> None:
        samples = latitude()
        with pytest.raises(InvalidFeatureError, match="in front of the camera"):
            begin_drag(PERSPECTIVE, SPHERE, samples + 3.0 * np.array(EYE), [1, 2])
        with pytest.raises(InvalidFeatureError, match="two numbers"):
            begin_drag(PERSPECTIVE, SPHERE, samples, [1, 2, 3])
        with pytest.raises(InvalidFeatureError, match="two numbers"):
            move_drag(begin_drag(PERSPECTIVE, SPHERE, samples, [1, 2]), SPHERE, [1, np.nan])
