"""The windows on a real display: what a pointer, keys and a window manager do to them."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from tests.support.display.hands import PATIENCE, PROGRAM, Shown, end, read_within
from tests.support.display.jobs import JOBS, draw_boundary, draw_square, find_rail


@pytest.mark.parametrize("name", JOBS)
def test_a_window_from_opening_to_closing(shown: Shown, name: str) -> None:
    job, kept = JOBS[name], shown.folder / JOBS[name].file
    shown.open(name)
    job.do(shown)
    shown.until(job.done)
    # Another size: all is drawn again, over all of the new room.
    active = ("getactivewindow", "windowsize", "--sync")
    shown.do(*active, 1000, 690)
    shown.until("window.width() == 1000 and window.height() > 600 and window.picture.width() > 300")
    shown.until("window.saver.draw_live(*window.picture.room).scene.width == window.picture.width()"
                " or window.saver.kind == 'browse'")  # fmt: skip
    shown.do(*active, 800, 560)
    shown.until("window.width() == 800")
    assert shown.tell(job.done)
    if job.undo:
        shown.keys("ctrl+z")
        shown.until(f"not ({job.done})")
        shown.keys("ctrl+shift+z")
        shown.until(job.done.replace("state.finder.rank == 1", "state.finder.rank == 0"))
    if not job.file:
        shown.close_by_manager()
        shown.until("not window.isVisible()")
        return
    # Nothing is lost by mistake: closing asks, and Cancel keeps the window.
    shown.until("bool(window.saver.would_lose())")
    shown.close_by_manager()
    shown.press_button("Cancel")
    assert shown.tell("window.isVisible()") and not kept.exists()
    # Saved, the window closes without a question.
    shown.keys("ctrl+s")
    if job.asks:
        shown.name_file(kept)
    shown.until("not window.saver.would_lose()")
    assert kept.stat().st_size > 0
    shown.close_by_manager()
    shown.until("not window.isVisible()")


@pytest.mark.parametrize("name", [name for name, job in JOBS.items() if job.file])
def test_closing_with_and_without_saving(shown: Shown, name: str) -> None:
    job, kept = JOBS[name], shown.folder / JOBS[name].file
    for answer in ("Discard", "Save"):
        shown.open(name)
        job.do(shown)
        shown.until(f"({job.done}) and bool(window.saver.would_lose())")
        shown.close_by_manager()
        shown.press_button(answer)
        if answer == "Save" and job.asks:
            shown.name_file(kept)
        shown.until("not window.isVisible()")
        assert kept.exists() == (answer == "Save")


@pytest.mark.parametrize("name", [name for name, job in JOBS.items() if job.file])
def test_work_that_cannot_be_saved_is_kept_in_the_window(shown: Shown, name: str) -> None:
    job = JOBS[name]
    # Nobody can make a file there.
    nowhere = Path("/sys") / job.file
    shown.open(name)
    job.do(shown)
    shown.until(f"({job.done}) and bool(window.saver.would_lose())")
    if name == "shape-model":
        shown.tell("setattr(window.saver, '_output', __import__('pathlib').Path('/sys/car.obj'))")
    elif not job.asks:
        nowhere_too = f"__import__('pathlib').Path({str(nowhere)!r})"
        shown.tell(f"setattr(window.saver.files, 'session_path', {nowhere_too})")
    shown.close_by_manager()
    shown.press_button("Save")
    if job.asks:
        shown.name_file(nowhere)
    shown.until("'not saved' in state.message")
    assert shown.tell("window.isVisible() and bool(window.saver.would_lose())")
    assert shown.tell(job.done)


#: How to get ready for drawing in a window, and the line (n, 2) in places that was drawn then.
STROKES = {
    "explore": "state.finder.strokes[-1].points",
    "retopo": "next(c for c in state.network.chains.values() if not c.marked).points",
    "surface": "state.surfaces.edits.inks[-1].parts[0]",
    "features": "",
    "shape-model": "",
}


def bow(count: int = 40) -> np.ndarray:
    """(count, 2) places along a bow, each in a pixel of its own."""
    t = np.linspace(0.0, 1.0, count)
    return np.stack([-80.0 + 160.0 * t, 60.0 * np.sin(np.pi * t) - 20.0], axis=1)


@pytest.mark.parametrize("name", STROKES)
def test_a_fast_stroke_arrives_whole_and_has_no_hook(shown: Shown, name: str) -> None:
    shown.open(name)
    path = bow()
    if name == "explore":
        draw_boundary(shown)
        shown.until("state.finder.rank == 1")
        shown.keys("s")
        # From side to side of the boundary.
        path = np.stack([path[:, 0] * 1.1, 0.5 * path[:, 1]], axis=1)
    elif name == "features":
        JOBS[name].do(shown)
        shown.until(JOBS[name].done + " and not state.editing.clicks")
    elif name == "shape-model":
        path = find_rail(shown) + 0.3 * (path - path[0])
    else:
        shown.keys("d")
    shown.tell("moves.clear()")
    # Let go, and go on at once: nothing of that belongs to the stroke.
    asked = shown.drag(path, seconds=0.5)
    beyond = np.array([[30.0, 150.0], [60.0, 170.0], [100.0, 180.0]])
    for pixel in shown.find_pixels(beyond):
        shown.do("mousemove", *pixel)
    moves = np.array(shown.until(f"len(moves) >= {len(path) + len(beyond)} and moves"))
    # Half pixels are lost where a picture has an odd width.
    offset = np.round(2.0 * (moves[0] - asked[0])) / 2.0
    assert np.abs(offset).max() <= 1.0
    wanted = {tuple(place) for place in (asked + offset).tolist()}
    came = {tuple(place) for place in moves.tolist()}
    assert len(wanted) == len(path) == 40 and wanted <= came, "every place of the pointer arrives"
    if not STROKES[name]:
        return
    drawn = asked + offset
    shown.until("not getattr(getattr(state, 'editing', None), 'waiting', False)")
    line = np.array(shown.tell(
        f"(state.camera.view if hasattr(state, 'camera') else state.view).seen({STROKES[name]})"
        "[:, :2].tolist()"
    ))  # fmt: skip
    fine = np.concatenate([a + np.linspace(0.0, 1.0, 50)[:, None] * (b - a)
                           for a, b in pairwise(drawn)])  # fmt: skip
    if name == "explore":
        # Its ends are moved to the middle of edges of the boundary.
        line = line[2:-2]
    off = np.linalg.norm(line[:, None] - fine[None], axis=2).min(axis=1)
    assert off.max() < 1.0, "within a pixel of where the pointer went"
    if name != "explore":
        ends = np.linalg.norm(line[[0, -1]][:, None] - drawn[[0, -1]][None], axis=2).min(axis=1)
        assert ends.max() < 1.5, "it ends where the button came up"


def test_a_drag_goes_on_outside_the_window_and_ends_there(shown: Shown) -> None:
    shown.open("retopo")
    shown.keys("d")
    start, out = shown.find_pixels(np.array([[0.0, 0.0], [40.0, 60.0]]))
    shown.do("mousemove", *start, "mousedown", 1, "mousemove", *out, "mousemove", 2, 2)
    shown.until("state.tool.holding")
    shown.do("mouseup", 1)
    shown.until("not state.tool.holding and not state.editing.waiting")
    chains = shown.tell("sorted(state.network.chains)")
    # Back in the window nothing is held any more.
    for pixel in shown.find_pixels(np.array([[-50.0, -50.0], [-20.0, 70.0]])):
        shown.do("mousemove", *pixel)
    shown.until("not state.editing.waiting")
    assert not shown.tell("state.tool.holding")
    assert shown.tell("sorted(state.network.chains)") == chains
    # The same with the button that turns: the view stays as it was when the button came up.
    axes = shown.tell("state.camera.view.axes.tolist()")
    shown.do("mousemove", *start, "mousedown", 3, "mousemove", *out, "mousemove", 2, 2)
    shown.do("mouseup", 3)
    turned = shown.tell("state.camera.view.axes.tolist()")
    assert turned != axes
    shown.do("mousemove", *start, "mousemove", *out)
    assert shown.tell("state.camera.view.axes.tolist()") == turned


@pytest.mark.parametrize(
    ("name", "draw", "strips", "key"),
    [
        ("retopo", draw_square, "len(state.tool.strips_under())", "T"),
        ("explore", draw_boundary, "len(state.strips_under())", "t"),
    ],
)
def test_strands_follow_the_pointer(
    shown: Shown, name: str, draw: Callable[[Shown], None], strips: str, key: str
) -> None:
    """Two cross in the quad that it rests on; beside quads there are none, nor after the key."""
    shown.open(name)
    draw(shown)
    shown.until(
        "len(state.shown.body.mesh.quads)"
        if name == "retopo"
        else "state.finder.placed is not None"
    )
    inside, outside = shown.find_pixels(np.array([[12.0, -9.0], [170.0, 140.0]]))
    shown.do("mousemove", *outside, "mousemove", *inside)
    shown.until(f"{strips} in (1, 2)")
    shown.do("mousemove", *outside)
    shown.until(f"{strips} == 0")
    shown.keys(key)
    shown.do("mousemove", *inside)
    assert shown.tell(strips) == 0
    shown.keys(key)
    shown.until(f"{strips} in (1, 2)")


def test_keys_repeat_and_only_where_the_focus_is(shown: Shown) -> None:
    shown.open("browse")
    shown.do("keydown", "Right", "sleep", 1.5, "keyup", "Right")
    assert shown.until("state.position") > 2, "a key that is held down goes on"
    assert shown.tell("state.mirrored") is False
    # A field has the focus: letters are its own.
    shown.keys("ctrl+p")
    shown.until("app.activeModalWidget() is not None and app.activeModalWidget().isActiveWindow()")
    shown.do("type", "mirror")
    shown.until("app.activeModalWidget().field.text() == 'mirror'")
    assert shown.tell("state.mirrored") is False
    shown.keys("Return")
    shown.until("state.mirrored")
    # Another window has it: the pointer alone does not take it back.
    shown.tell("[globals().update(other=QLineEdit()), other.resize(200, 60), other.show()] and 0")
    shown.until("other.isActiveWindow()")
    shown.do("mousemove", *shown.find_pixels(np.zeros((1, 2)))[0])
    shown.do("type", "mt")
    shown.until("other.text() == 'mt'")
    assert shown.tell("(state.mirrored, state.tinted)") == [True, shown.tell("state.tinted")]
    assert shown.tell("other.isActiveWindow()")
    # A click does.
    shown.do("click", 1)
    shown.until("window.isActiveWindow()")
    shown.keys("m")
    shown.until("not state.mirrored")
    assert shown.tell("other.close()")
    shown.close_by_manager()
    shown.until("not window.isVisible()")


@pytest.mark.parametrize("name", ["browse", "retopo"])
def test_ctrl_c_ends_a_window(display: dict[str, str], tmp_path: Path, name: str) -> None:
    with (tmp_path / "stderr").open("w") as errors:
        process = subprocess.Popen(
            [sys.executable, str(PROGRAM), str(tmp_path), name],
            env=display, stdout=subprocess.PIPE, stderr=errors, text=True,
        )  # fmt: skip
    try:
        assert process.stdout is not None
        said = read_within(os.dup(process.stdout.fileno()))
        assert said == "shown", (tmp_path / "stderr").read_text()
        process.send_signal(signal.SIGINT)
        assert process.wait(PATIENCE) == 130
        assert "Traceback" not in (tmp_path / "stderr").read_text()
    finally:
        end(process)


def test_edges_are_smoothed_when_nothing_moves_any_more(shown: Shown) -> None:
    shown.open("retopo")
    draw_square(shown)
    # As where OpenGL is slow: what a picture took is only known when edges were smoothed.
    drawn = "(setattr(window.picture, '_slow', True), window.refresh())"
    smooth = "window.picture.renderer.GetUseFXAA()"
    assert not shown.tell(f"({drawn}, {smooth})[1]")
    shown.until(f"bool({smooth}) and not window.picture._still.isActive()")
