"""Sliders: values, and places on their lines."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from viewer.slider import Slider

ALPHA = Slider("alpha", 0.0, 1.0, 0.01, ends=("few", "many"))
ANGLE = Slider("angle", 0.0, 180.0, 1.0, unit="°")
MODE = Slider("mode", -3.0, 3.0, 0.1)
STIFF = Slider("stiffness", 1.0, 100.0, digits=3)
ALL = (ALPHA, ANGLE, MODE, STIFF)


@given(st.sampled_from(ALL), st.floats(-0.5, 1.5))
def test_values_are_within_the_ends_and_rounded_to_steps(slider: Slider, share: float) -> None:
    value = slider.value(share)
    assert slider.low <= value <= slider.high
    if slider.digits:
        assert value == float(f"{value:.{slider.digits}g}")
        tolerance = 10.0 ** (1 - slider.digits) / math.log(slider.high / slider.low)
    else:
        steps = value / slider.step
        assert steps == pytest.approx(round(steps), abs=1e-9)
        tolerance = 0.5001 * slider.step / (slider.high - slider.low)
    assert slider.share(value) == pytest.approx(min(max(share, 0.0), 1.0), abs=tolerance)
    # What is rounded already stays as it is.
    assert slider.value(slider.share(value)) == value


@given(st.sampled_from(ALL), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_farther_right_is_never_less(slider: Slider, one: float, other: float) -> None:
    low, high = sorted((one, other))
    assert slider.value(low) <= slider.value(high)


def test_equal_ways_of_a_logarithmic_slider_multiply_by_equal_factors() -> None:
    assert [STIFF.value(k / 4.0) for k in range(5)] == [1.0, 3.16, 10.0, 31.6, 100.0]
    assert STIFF.share(10.0) == pytest.approx(0.5)


@given(st.sampled_from(ALL), st.floats(0.0, 1.0), st.sampled_from([-0.04, -1e-5, 1e-5, 0.04]))
def test_moving_goes_on_until_the_end(slider: Slider, share: float, by: float) -> None:
    value = slider.value(share)
    after = slider.moved(value, by)
    assert slider.low <= after <= slider.high
    if (by > 0.0 and value < slider.high) or (by < 0.0 and value > slider.low):
        assert (after - value) * by > 0.0
    else:
        assert after == value
    assert slider.moved(value, 0.0) == value


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"low": 1.0, "high": 1.0}, "no range"),
        ({"low": 0.0, "high": np.inf}, "no range"),
        ({"low": 0.0, "high": 1.0, "digits": 2}, "begins above 0"),
        ({"low": 0.0, "high": 1.0, "step": 0.0}, "a step above 0"),
        ({"low": 1.0, "high": 2.0, "digits": -1}, "no negative digits"),
    ],
)
def test_sliders_without_a_range_are_refused(wrong: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Slider("x", **wrong)  # type: ignore[arg-type]
