"""Frames: curves that do not lie on a model are refused, and the turn in which they do is found."""

from __future__ import annotations

import numpy as np
import pytest

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.registration import register
from patterndb_sketch.features.registration.frame import (
    LEAST_ON,
    TURNS,
    Turn,
    check_frame,
    find_scale,
    find_turn,
    measure_share_on,
    sample_curves,
)
from patterndb_sketch.features.splines import Spline
from tests.support.features.registration import car_curves, car_model, car_template, laid


def test_there_are_24_turns_and_each_has_its_inverse() -> None:
    """All keep lengths and handedness; the first does nothing; each is read as it is written."""
    points = np.random.default_rng(1).normal(size=(5, 3))
    corner = np.eye(3)
    assert len(set(TURNS)) == 24 and str(TURNS[0]) == "x,y,z"
    for turn in TURNS:
        assert Turn.parse(str(turn)) == turn
        turned = turn.turn_points(corner)
        assert np.linalg.det(turned) == pytest.approx(1.0)
        back = [other for other in TURNS if (other.turn_points(turned) == corner).all()]
        assert len(back) == 1
        assert (back[0].turn_points(turn.turn_points(points)) == points).all()


@pytest.mark.parametrize("number", range(1, 24, 3))
def test_a_wrong_frame_is_refused_and_the_right_one_is_found(number: int) -> None:
    model = TURNS[number].turn_model(car_model())
    curves = car_curves()
    assert measure_share_on(model, sample_curves(curves.values())) < LEAST_ON
    turn, share = find_turn(model, curves.values())
    assert share > 0.9
    assert (turn.turn_model(model).vertices == car_model().vertices).all()
    with pytest.raises(InvalidFeatureError, match=f"--turn {turn}"):
        register(model, curves, car_template())


@pytest.mark.parametrize(
    ("scale", "number"),
    [(1000.0, 0), (0.001, 7), (39.37007874, 7), (0.0254, 0), (100.0, 7), (3.280839895, 0)],
)
def test_another_unit_of_length_is_told(scale: float, number: int) -> None:
    """Of a model that is turned, too: by the ratio, with which the curves would lie on it."""
    turned = TURNS[number].turn_model(car_model())
    model = Surface.from_soup(PolygonMesh.from_faces(scale * turned.vertices, turned.triangles))
    found, turn, share = find_scale(model, car_curves().values())
    assert found == pytest.approx(scale) and share > 0.9
    assert turn == find_turn(turned, car_curves().values())[0]
    with pytest.raises(InvalidFeatureError, match=f"{found:g} times as large"):
        register(model, car_curves(), car_template())


@pytest.mark.parametrize("scale", [0.8, 2.0])
def test_a_model_of_another_size_is_refused(scale: float) -> None:
    """Scaled by what is no ratio of units."""
    model = car_model()
    other = Surface.from_soup(PolygonMesh.from_faces(scale * model.vertices, model.triangles))
    with pytest.raises(InvalidFeatureError, match="is it another model's network"):
        register(other, car_curves(), car_template())


def test_the_curves_of_the_other_half_are_refused() -> None:
    """They lie on the model, which is symmetric; the template would be inside out. A model that is
    mirrored itself is the same model."""
    model, mirror = car_model(), np.array([1.0, -1.0, 1.0])
    curves = {
        name: Spline(one.degree, one.knots, mirror * one.control)
        for name, one in car_curves().items()
    }
    check_frame(model, curves.values())
    with pytest.raises(InvalidFeatureError, match="those of the other half"):
        register(model, curves, car_template())
    mirrored = Surface.from_soup(PolygonMesh.from_faces(model.vertices * mirror, model.triangles))
    found = register(mirrored, car_curves(), car_template()).points
    assert found == pytest.approx(laid().points, abs=1e-6)


def test_mirror_images_along_the_car_are_refused() -> None:
    """From nose to tail and upside down: with the turn that is as good, as cars are symmetric."""
    for axis in (0, 2):
        sign = np.where(np.arange(3) == axis, -1.0, 1.0)
        model = car_model()
        other = Surface.from_soup(PolygonMesh.from_faces(model.vertices * sign, model.triangles))
        with pytest.raises(InvalidFeatureError, match="--turn ") as raised:
            register(other, car_curves(), car_template())
        turn = Turn.parse(str(raised.value).split("--turn ")[1].split(")")[0])
        again = register(turn.turn_model(other), car_curves(), car_template())
        assert again.points == pytest.approx(laid().points, abs=1e-6)


def test_the_network_of_another_model_is_refused() -> None:
    """No turn brings them together: the message says so."""
    model = car_model()
    away = Surface.from_soup(
        PolygonMesh.from_faces(model.vertices + np.array([0.0, 9.0, 0.0]), model.triangles)
    )
    with pytest.raises(InvalidFeatureError, match="is it another model's network"):
        register(away, car_curves(), car_template())


@pytest.mark.parametrize("text", ["", "x,y", "x,-y,z", "x,x,z", "a,b,c"])
def test_what_is_no_turn_is_told(text: str) -> None:
    with pytest.raises(InvalidFeatureError, match="is no turn"):
        Turn.parse(text)
