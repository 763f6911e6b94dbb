"""Curves pulled in the viewer of feature curves, and the pins that hold them."""

from __future__ import annotations

import threading

import numpy as np
import pytest

from patterndb_sketch.features import editing
from patterndb_sketch.features.edits import snap_curve
from patterndb_sketch.features.snap import Snap
from tests.support.viewer.tents import (
    ON_RIDGE,
    at,
    curve_of,
    drag,
    drawn,
    held,
    keys,
    line_of,
    tent,
)
from viewer.features import FeatureState
from viewer.features.pointing import PIN, make_matrix_camera


def test_a_pulled_sample_is_pinned_where_the_pointer_is(curved: FeatureState) -> None:
    base, snap = curve_of(curved), held(curved)
    begun = at(curved, *line_of(curved)[len(line_of(curved)) // 2])
    target = at(curved, 0.05, 0.06, -0.06)
    drag(curved, begun, (begun[0], begun[1] - 8.0), target)
    curve = curve_of(curved)
    assert curve.key == base.key and len(curve.constraints) == 1
    sample, point = curve.constraints[0]
    # The sample moved in the picture as the pointer did, and lies on the model.
    seen = make_matrix_camera(curved.camera.view, curved.editing.model, curved.camera.room)
    moved = seen.seen_at(point[None])[0] - seen.seen_at(snap.curve.samples[sample][None])[0]
    assert moved == pytest.approx(np.array(target) - begun, abs=1e-6)
    assert curved.editing.model.measure_distances(point[None])[0] < 1e-9
    alone = snap.with_constraints(((sample, point),)).curve
    assert (held(curved).curve.samples == alone.samples).all()
    found = held(curved).curve
    on = found.spline.evaluate(found.parameters[[sample]])[0]
    assert np.linalg.norm(on - point) < 1e-9
    # However often the pointer moved, it was one step.
    keys(curved, "u")
    assert curve_of(curved) is base
    keys(curved, "U")
    assert curve_of(curved) is curve


def test_a_pin_is_pulled_again_and_taken_away(curved: FeatureState) -> None:
    begun = at(curved, *line_of(curved)[60])
    drag(curved, begun, (begun[0] + 4.0, begun[1] - 30.0))
    sample, point = curve_of(curved).constraints[0]
    head = np.array(at(curved, *point)) + PIN
    curved.move(*head.tolist())
    under = curved.under()
    assert under is not None and under.pin == sample
    drawn(curved)
    drag(curved, tuple(head.tolist()), (head[0] - 9.0, head[1] + 12.0))
    again = curve_of(curved)
    assert [number for number, _ in again.constraints] == [sample]
    assert not np.allclose(again.constraints[0][1], point)
    # Where the pin was before leaves no trace.
    alone = Snap.begin(tent(), again.clicked).with_constraints(again.constraints).curve
    assert (held(curved).curve.samples == alone.samples).all()
    curved.move(*at(curved, *again.constraints[0][1]))
    keys(curved, "d")
    assert curve_of(curved).constraints == ()
    assert np.abs(line_of(curved)[:, 1:]).max() < ON_RIDGE
    keys(curved, "d")
    assert curved.message == "put the pointer on a pin"


def test_a_pull_beside_the_model_keeps_the_last_place(curved: FeatureState) -> None:
    begun = at(curved, *line_of(curved)[60])
    far = (-curved.camera.room[0] / 2.0 + 2.0, curved.camera.room[1] / 2.0 - 2.0)
    drag(curved, begun, (begun[0], begun[1] - 20.0), far)
    assert "the pointer left the model" in curved.message
    point = curve_of(curved).constraints[0][1]
    assert np.linalg.norm(np.array(at(curved, *point)) - begun) < 40.0


def test_the_curve_in_hand_is_shown_as_it_was_until_it_is_made(
    curved: FeatureState, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun = at(curved, *line_of(curved)[60])
    drag(curved, begun, (begun[0], begun[1] - 30.0))
    line, point = line_of(curved), curve_of(curved).constraints[0][1]
    going_on = threading.Event()

    def slow(*arguments: object) -> Snap:
        going_on.wait()
        return snap_curve(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(editing, "snap_curve", slow)
    x, y = at(curved, *point)
    try:
        curved.press(x, y)
        curved.move(x + 8.0, y)
        assert line_of(curved) is line and not np.allclose(
            curve_of(curved).constraints[0][1], point
        )
        drawn(curved)
    finally:
        going_on.set()
    curved.settle()
    assert line_of(curved) is not line
    curved.release(x + 8.0, y)
    keys(curved, "u")
    assert line_of(curved) is line


def test_keys_wait_until_the_button_is_up(curved: FeatureState) -> None:
    begun = at(curved, *line_of(curved)[60])
    curved.move(*begun)
    curved.press(*begun)
    assert curved.holding
    curved.release(*begun)
    assert not curved.holding and curve_of(curved).constraints == ()
