"""A retopology edited in a thread, as a window does it, without one: calls, fills, previews."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from patterndb_sketch.retopo.editing import RetopoEditing
from patterndb_sketch.retopo.editor import Call, Retopology
from patterndb_sketch.retopo.files import RetopoFiles
from patterndb_sketch.retopo.script import Script
from query.engine import PatternSource
from tests.support.viewer.sheets import SQUARE, sheet


@pytest.fixture
def editing(source: PatternSource, tmp_path: Path) -> Iterator[RetopoEditing]:
    files = RetopoFiles(tmp_path, None, None, Script("sheet", ()), None)
    made = RetopoEditing(Retopology(sheet(), source), files)
    yield made
    made.close()


def draw_square(editing: RetopoEditing) -> int:
    """Draw a square of four strokes; returns its patch."""
    corners = [[x, y, 0.0] for x, y in SQUARE]
    for a, b in zip(corners, [*corners[1:], corners[0]], strict=True):
        editing.do("stroke", points=np.linspace(a, b, 9).tolist())
    editing.settle()
    (patch,) = editing.network.patches
    return patch


def test_fills_are_paged_through_and_steps_taken_back(editing: RetopoEditing) -> None:
    patch = draw_square(editing)
    assert editing.shown.fresh and editing.shown.undoable == 4 and editing.list_empty() == ()
    at = editing.shown.body.point_in(patch)
    assert at is not None and editing.shown.body.patch_at(at) == patch
    editing.want_list(patch)
    editing.settle()
    first, choices = editing.place_in_list(patch), editing.list_choices(patch)
    assert first is not None and first.count == len(choices) > 1
    editing.do("choose", at=at.tolist(), by=1)
    editing.settle()
    place = editing.place_in_list(patch)
    assert place is not None and place.number == (first.number or 0) + 1
    editing.choose_fill(patch, 0)
    editing.settle()
    again = editing.place_in_list(patch)
    assert again is not None and again.number == 0
    editing.undo()
    editing.settle()
    assert editing.place_in_list(patch) == place
    assert editing.calls is not None and [c.tool for c in editing.calls[4:]] == [
        "choose",
        "choose",
        "undo",
    ]


def test_a_call_is_previewed_and_nothing_is_changed(editing: RetopoEditing) -> None:
    draw_square(editing)
    before = editing.shown
    editing.want_preview(Call("loop", {"at": [0, 3, 0], "normal": [1, 0, 0]}))
    editing.settle()
    found = editing.preview
    assert found is not None and not found.refused and len(found.curves) == 1
    assert np.abs(found.curves[0][:, 0]).max() < 1e-6
    editing.want_preview(Call("autocomplete", {"at": [2.0, 0.0, 0.0], "choice": 99}))
    editing.settle()
    found = editing.preview
    assert found is not None and found.network is editing.network
    assert editing.shown is before and len(editing.network.patches) == 1
    editing.want_preview(None)
    assert editing.preview is None


def test_work_is_saved_reloaded_and_rejected_calls_are_reported(editing: RetopoEditing) -> None:
    draw_square(editing)
    assert editing.unsaved and editing.save_session() and not editing.unsaved
    saved = editing.shown.state
    editing.do("erase", at=[0.0, -1.5, 0.0])
    editing.settle()
    assert editing.unsaved and not editing.network.patches
    editing.reload()
    editing.settle()
    assert editing.shown.state.same(saved) and editing.calls is None and not editing.unsaved
    editing.do("erase", at=[4.0, 4.0, 0.0])
    editing.settle()
    assert "near" in editing.message
    editing.recover()
    assert editing.message == "there is nothing that a crash left"
