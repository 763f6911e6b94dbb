"""Frames: curves that do not lie on a model are refused, and the turn in which they do is found."""

from __future__ import annotations

import numpy as np
import pytest
from registration_cases import car_curves, car_model, car_template

from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.registration import register
from patterndb_sketch.features.registration.frame import (
    LEAST_ON,
    TURNS,
    Turn,
    find_turn,
    measure_share_on,
    sample_curves,
)


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


@pytest.mark.parametrize("number", range(1, 24))
def test_every_wrong_frame_is_refused_and_the_right_one_is_found(number: int) -> None:
    model = TURNS[number].turn_model(car_model())
    curves = car_curves()
    assert measure_share_on(model, sample_curves(curves.values())) < LEAST_ON
    turn, share = find_turn(model, curves.values())
    assert share > 0.9
    assert (turn.turn_model(model).points == car_model().points).all()
    with pytest.raises(InvalidFeatureError, match=f"--turn {turn}"):
        register(model, curves, car_template())


def test_the_network_of_another_model_is_refused() -> None:
    """No turn brings them together: the message says so."""
    model = car_model()
    away = type(model).from_arrays(model.points + np.array([0.0, 9.0, 0.0]), model.triangles)
    with pytest.raises(InvalidFeatureError, match="is it another model's network"):
        register(away, car_curves(), car_template())


@pytest.mark.parametrize("text", ["", "x,y", "x,-y,z", "x,x,z", "a,b,c"])
def test_what_is_no_turn_is_told(text: str) -> None:
    with pytest.raises(InvalidFeatureError, match="is no turn"):
        Turn.parse(text)
