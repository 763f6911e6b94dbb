"""Work of windows without sessions: kept in case of a crash, offered, opened as one step."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from patterndb_sketch.recovery import WorkKeeper
from tests.support.display.six_windows import starter
from viewer.saver import Saver

SIZE = (900, 600)


def write(path: Path, *_: object) -> None:
    path.write_text("saved")


def explorer(folder: Path, surface: Any = None) -> Saver:
    from viewer.explore import ExplorerSaver
    from viewer.explorer_state import ExplorerState

    return ExplorerSaver(ExplorerState(starter(), surface=surface), folder, write, SIZE)


def surfacing(folder: Path, dome: Any = None) -> Saver:
    from tests.support.viewer.domes import FROM_ABOVE, Finder, growing_dome
    from viewer.surfacing.state import SurfacingState
    from viewer.surfacing.window import SurfacingSaver

    state = SurfacingState(growing_dome() if dome is None else dome, find=Finder(), **FROM_ABOVE)
    state.settle()
    return SurfacingSaver(state, folder, write, SIZE)


def shapes(folder: Path) -> Saver:
    from tests.support.viewer.shapes import car_shapes, car_template
    from viewer.shapes.state import ShapesState
    from viewer.shapes.window import ShapesSaver

    return ShapesSaver(ShapesState(car_shapes(), car_template()), folder / "car.obj", SIZE)


def draw_boundary(saver: Saver) -> None:
    """A square with a stroke across, and other wishes than at first."""
    from viewer.pointerstroke import PointerMode

    state = saver.state
    saver.drawn()
    state.begin(PointerMode.CORNERS)
    for x, y in ((-90.0, -80.0), (95.0, -70.0), (80.0, 85.0), (-85.0, 75.0)):
        state.press(x, y)
        state.release(x, y)
    state.close_boundary()
    state.exploration.keep_step()
    state.begin(PointerMode.STROKE)
    state.press(0.0, -80.0)
    for y in np.linspace(-80.0, 80.0, 9).tolist():
        state.move(2.0, y)
    state.release(2.0, 80.0)
    state.finder.toggle_strict()
    state.exploration.keep_step()
    assert len(state.finder.strokes) == 1


def switch_and_ink(saver: Saver) -> None:
    """A patch switched off, a method of another, a stroke that became curves, and one that did
    not."""
    state = saver.state
    saver.drawn()
    edits, made = state.surfaces.edits, state.surfaces.made
    cycles = [made.task.whole(patch.cycle) for patch in state.surfaces.patches]
    state.surfaces.steps.step(edits.switched_off(cycles[0]).with_method_of(cycles[1], "chords"))
    state.surfaces.ask()
    state.surfaces.change_alpha(0.25)
    state.settle()
    state.poll()
    state.begin_drawing()
    state.press(-30.0, 30.0)
    for x, y in ((-50.0, 40.0), (-70.0, 30.0)):
        state.move(x, y)
    state.release(-70.0, 30.0)
    assert len(state.surfaces.edits.inks) == 1


def pull(saver: Saver) -> None:
    """A shape that was changed, and a curve held."""
    shaping = saver.state.shaping
    shaping.nudge(0, 0.7)
    shaping.nudge(1, -0.3)
    shaping.toggle_held(shaping.lines[0].name)


def tell_question(saver: Saver) -> object:
    state = saver.state
    contour = state.contour
    return (
        [side.tolist() for side in contour.sides],
        (contour.corners, contour.lengths, contour.placed),
        [(one.start, one.end, one.points.tolist()) for one in state.finder.strokes],
        state.exploration.steps.now.choices,
        [fill.pattern.name for fill in state.finder.fills],
    )


def tell_surface(saver: Saver) -> object:
    edits = saver.state.surfaces.edits
    made = saver.state.surfaces.made
    return (
        [curve.points.tolist() for curve in edits.drawing.network.curves],
        (edits.drawing.stages, edits.stage, edits.given, edits.added, edits.banned),
        (edits.method, dict(edits.methods), saver.state.surfaces.settings),
        [[part.tolist() for part in ink.parts] for ink in edits.inks],
        [ink.surfacing is made.surfacing for ink in edits.inks],
        made.surfacing.points.tolist(),
    )


def tell_shape(saver: Saver) -> object:
    shaping = saver.state.shaping
    choice = shaping.choice
    wishes = (choice.origin, choice.held, choice.hold, choice.stiffness)
    return shaping.points.tolist(), choice.coefficients.tolist(), wishes


Case = tuple[Callable[..., Saver], Callable[[Saver], None], Callable[[Saver], object]]

CASES: dict[str, Case] = {
    "explore": (explorer, draw_boundary, tell_question),
    "surface": (surfacing, switch_and_ink, tell_surface),
    "shape-model": (shapes, pull, tell_shape),
}


def keep_now(saver: Saver) -> None:
    """Half a minute is over."""
    assert isinstance(saver.files, WorkKeeper) and saver.files.autosave is not None
    saver.files.autosave._at = -1e9
    saver.keep()


def leave_behind(folder: Path, case: Case) -> tuple[Path, object]:
    """What a window left that was killed after something was done, and what that was."""
    make, do, tell = case
    saver: Any = make(folder)
    saver.watch()
    keep_now(saver)
    assert not list(folder.iterdir()), "nothing was done yet"
    do(saver)
    saver.ready()
    saver.state.poll()
    was = tell(saver)
    keep_now(saver)
    (kept,) = folder.iterdir()
    again = kept.stat().st_mtime_ns
    keep_now(saver)
    assert kept.stat().st_mtime_ns == again, "nothing has changed since"
    # As a kill would: nobody says what becomes of the work.
    saver.files.autosave = None
    saver.end(discarded=False)
    return kept.rename(kept.with_name(f"unnamed-{saver.kind}.999999999-abc.recovery")), was


@pytest.mark.parametrize("name", CASES)
def test_what_a_crash_left_is_one_step_and_goes_when_it_is_saved(tmp_path: Path, name: str) -> None:
    make, _, tell = CASES[name]
    path, was = leave_behind(tmp_path, CASES[name])
    saver: Any = make(tmp_path)
    saver.watch()
    assert saver.state.message.endswith("R opens it in place of what is here")
    lost = saver.find_lost_work()
    assert lost is not None and not saver.would_lose()
    lost.open()
    saver.ready()
    saver.state.poll()
    assert tell(saver) == was and saver.would_lose() and path.exists()
    saver.state.recover()
    assert saver.state.message == "there is nothing that a crash left"
    state = saver.state
    work = {"explore": "exploration", "surface": "surfaces", "shape-model": "shaping"}[name]
    assert getattr(state, work).steps.undoable == 1
    # A crash now leaves one file or the other.
    keep_now(saver)
    assert len(list(tmp_path.iterdir())) == 2
    saver.save_ways()[0].write(tmp_path / "saved.obj")
    assert [one.name for one in tmp_path.iterdir()] == ["saved.obj"] and not saver.would_lose()
    saver.end(discarded=True)
    assert [one.name for one in tmp_path.iterdir()] == ["saved.obj"]


@pytest.mark.parametrize("name", CASES)
def test_only_a_window_that_asked_leaves_nothing(tmp_path: Path, name: str) -> None:
    make, do, _ = CASES[name]
    for discarded in (True, False):
        saver: Any = make(tmp_path)
        saver.watch()
        do(saver)
        keep_now(saver)
        assert len(list(tmp_path.iterdir())) == 1
        saver.end(discarded=discarded)
        assert len(list(tmp_path.iterdir())) == (not discarded)
    (kept,) = tmp_path.iterdir()
    # Opened, and then not wanted, it does not come back.
    other: Any = make(tmp_path)
    other.watch()
    assert other.find_lost_work() is not None, "an end that was not asked for offers it"
    other.find_lost_work().open()
    other.end(discarded=True)
    assert not kept.exists()


@pytest.mark.parametrize("name", CASES)
def test_what_cannot_be_opened_is_told_and_stays(tmp_path: Path, name: str) -> None:
    make = CASES[name][0]
    path, _ = leave_behind(tmp_path, CASES[name])
    content = path.read_bytes()
    of = json.loads(content)["of"].encode()
    for wrong, said in (
        (content.replace(of, b"f" * len(of)), "of something else"),
        (b"nothing", "which cannot be read"),
        (content.replace(b'"version":1', b'"version":2'), "version 2; "),
        (content[:-3], "which cannot be read"),
    ):
        path.write_bytes(wrong)
        saver: Any = make(tmp_path)
        saver.watch()
        assert said in saver.state.message and saver.find_lost_work() is None
        saver.end(discarded=True)
        assert path.read_bytes() == wrong
