"""The window of retopology: pictures without a window, files, and simulated events."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from sheets import ASPECT, SQUARE, at, drag, hover, keys, opened, sheet, square, tube

import patterndb
from query.engine import PatternSource
from sketch.retopo.autosave import Autosave
from sketch.retopo.editor import Call, Editor
from sketch.retopo.filling import RetopoMesh, welded
from sketch.retopo.network import equal
from sketch.retopo.script import Script, play, read_script
from sketch.retopo.sessionfile import read_session
from viewer import DisplayError, PictureFormatError, opengl
from viewer.explorer_picture import save_drawn
from viewer.keymap import Effect
from viewer.panel import PANEL
from viewer.retopo import RetopoState, draw, show
from viewer.retopo.keys import KEYS
from viewer.retopo.palette import CORNER, CURVE, FLOW, INK, MARKED, SIDES, SNAP, VALENCES
from viewer.retopo.picture import Painter
from viewer.retopo.window import RetopoWindow, Saver, Writer
from viewer.scene import HEIGHT
from viewer.style import PAPER, rgb

SIZE = (720, 450)


@pytest.fixture(scope="module")
def source() -> Iterator[PatternSource]:
    with patterndb.open() as opened:
        yield opened


@pytest.fixture
def state(source: PatternSource) -> Iterator[RetopoState]:
    made = opened(source)
    yield made
    made.close()


def read(path: Path) -> np.ndarray:
    from matplotlib.image import imread

    return np.asarray(imread(path))[..., :3]


def writer(folder: Path, **paths: Path) -> Writer:
    def write_mesh(path: Path, mesh: RetopoMesh) -> None:
        path.write_text(f"{len(mesh.quads)} quads")

    session, script = paths.get("session"), paths.get("script")
    return Writer(folder, session, script, Script("sheet.obj", ()), write_mesh)


def painted(state: RetopoState, colour: str) -> int:
    """How many triangles of this very colour the picture has, but for those of round bands."""
    colours = Painter().compose(state, ASPECT).solid.colours[:, 0]
    return int((np.abs(colours - rgb(colour)).max(axis=1) < 1e-6).sum())


def banded(state: RetopoState, colour: str) -> int:
    """The same of bands, which are darker at their rims."""
    colours = Painter().compose(state, ASPECT).solid.colours
    dark = np.abs(colours - 0.72 * rgb(colour)).max(axis=2) < 1e-6
    return int(dark.any(axis=1).sum())


def test_all_that_there_is_is_drawn(state: RetopoState) -> None:
    assert banded(state, MARKED) > 0, "the border of the sheet"
    assert banded(state, CURVE) == 0
    keys(state, "d")
    drag(state, (-3.0, 3.0), (3.0, 3.0))
    hover(state, (4.5, -4.5))
    rims = painted(state, CORNER)
    assert rims == 2 * 24 and painted(state, PAPER) == 2 * 24, "two hollow ends"
    square(state, ((0.0, 2.0), (-1.9, 0.6), (-1.2, -1.6), (1.2, -1.6), (1.9, 0.6)))
    hover(state, (4.5, -4.5))
    assert painted(state, CORNER) == (2 + 5) * 24
    drag(state, (0.0, -3.5), (0.0, -1.6))
    hover(state, (4.5, -4.5))
    # One more open end, and a disc and a half disc.
    assert painted(state, CORNER) == (3 + 5 + 1) * 24 + 12
    body = state.shown.body
    shapes = {3: 3, 5: 5}
    for valence, colour in VALENCES.items():
        assert painted(state, colour) == shapes[valence] * int((body.valences == valence).sum())
    assert len(body.irregular) > 0
    assert painted(state, SNAP) == 0
    hover(state, (-3.0, 3.0))
    assert painted(state, SNAP) > 0
    keys(state, "w")
    drag(state, (-1.4, 0.0), (1.4, 0.0))
    assert painted(state, FLOW) > 0
    keys(state, "x")
    assert painted(state, VALENCES[5]) == 0
    # From below, the sheet hides it all; and one can see through it.
    keys(state, "3")
    hover(state, (40.0, 40.0))
    assert banded(state, CURVE) == painted(state, CORNER) == 0
    keys(state, "m")
    assert banded(state, CURVE) > 0


def test_patches_have_the_colour_of_their_sides(state: RetopoState) -> None:
    square(state)
    hover(state, (4.5, -4.5))
    drawn = Painter().compose(state, ASPECT).solid.colours.reshape(-1, 3)
    ratio = drawn / rgb(SIDES[4])
    flat = np.ptp(ratio, axis=1) < 1e-5
    assert flat.sum() >= 6 * len(state.shown.body.mesh.quads)


def test_the_half_that_is_an_image_is_darker(source: PatternSource) -> None:
    state = opened(source, tube())
    try:
        before = Painter().compose(state, ASPECT).solid.colours.sum()
        keys(state, "M")
        plane = state.shown.state.plane
        assert plane is not None
        count = len(state.ground.triangles)
        drawn = Painter().compose(state, ASPECT).solid.colours[:count]
        whole = Painter()._shading.model(state.skin, state.view, "solid", (0.0, 0.0))[1]
        beyond = (plane.heights(state.ground.vertices) < 0.0)[state.ground.triangles]
        ratio = (drawn / whole).mean(axis=2)
        assert np.allclose(ratio[beyond], 0.84) and np.allclose(ratio[~beyond], 1.0)
        assert beyond.any() and drawn.sum() < before
    finally:
        state.close()


def test_what_is_drawn_is_seen(state: RetopoState) -> None:
    places = [at(state, (-1.0, 0.0)), at(state, (1.0, 0.5))]
    state.move(*places[0])
    state.press(*places[0])
    state.move(*places[1])
    assert banded(state, INK) > 0
    state.release(*places[1])
    state.settle()
    assert banded(state, INK) == 0


def test_numbers_of_edges_are_written_in_the_mode_of_counts(state: RetopoState) -> None:
    square(state)
    keys(state, "t")

    def numbers() -> list[tuple[str, bool]]:
        texts = Painter().compose(state, ASPECT).scene.texts
        return sorted((t.text, t.bold) for t in texts if t.text.isdigit() and t.size == 11.0)

    counts = [c.count for c in state.network.chains.values() if not c.marked]
    assert numbers() == sorted((str(n), False) for n in counts)
    hover(state, (0.0, -1.5))
    state.wheel(1.0)
    state.settle()
    assert sum(bold for _, bold in numbers()) == 1
    keys(state, "3")
    assert numbers() == [], "hidden by the sheet"


def test_an_off_screen_picture_is_the_same_every_time(
    tmp_path: Path, source: PatternSource
) -> None:
    editor = Editor(sheet(), source)
    for k in range(4):
        line = [[*SQUARE[k - 1], 0.0], [*SQUARE[k], 0.0]]
        editor.do(Call("stroke", {"points": line}))
    for name in "ab":
        draw(editor, tmp_path / f"{name}.png", toward=(0, 0, 1), size=(480, 320))
    image = read(tmp_path / "a.png")
    assert image.shape == (320, 480, 3)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    # The patch is warm, the sheet is grey.
    assert 1500 < (image[..., 0] - image[..., 2] > 0.05).sum() < 15000
    draw(editor, tmp_path / "c.png", size=(480, 320), keys="x m m", bare=False, title="sheet")
    assert (read(tmp_path / "c.png").min(axis=2) > 0.9).mean() > 0.7
    with pytest.raises(ValueError, match="no key 'zz'"):
        draw(editor, tmp_path / "d.png", keys="zz")
    with pytest.raises(PictureFormatError):
        draw(editor, tmp_path / "d.jpg")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.png", "b.png", "c.png"]


def test_everything_is_saved(tmp_path: Path, state: RetopoState, source: PatternSource) -> None:
    files = writer(tmp_path)
    state.files = files
    saver = Saver(state, files, SIZE)
    assert saver.play(["o", "S"]) is Effect.NOTHING
    assert "nothing has been done" in state.message and not list(tmp_path.iterdir())
    square(state)
    assert state.unsaved
    saver.play(["s", "p", "o", "S", "s"])
    assert state.message == f"saved {tmp_path / 'retopo-1.retopo'}" and not state.unsaved
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["quads-1.obj", "retopo-1.jsonl", "retopo-1.png", "retopo-1.retopo"]
    kept = read_session(tmp_path / "retopo-1.retopo")
    assert equal(kept.state.network, state.network) and kept.name == "sheet.obj"
    quads = len(state.shown.body.mesh.quads)
    assert (tmp_path / "quads-1.obj").read_text() == f"{quads} quads"
    script = read_script(tmp_path / "retopo-1.jsonl")
    assert script.surface == "sheet.obj"
    again = Editor(sheet(), source)
    assert len(list(play(script, again, lambda _path, _found: None))) == 4
    assert np.array_equal(welded(again.fill()).vertices, state.shown.body.mesh.vertices)
    assert read(tmp_path / "retopo-1.png").shape[:2] == (SIZE[1], SIZE[0])
    lost = writer(tmp_path / "no")
    state.files = lost
    for key in "spSo":
        state.message = ""
        Saver(state, lost, SIZE).obey(key)
        assert state.message.startswith("not saved: "), key
    state.files = None
    for key in "sSo":
        state.message = ""
        KEYS.press(state, key)
        assert "cannot be saved here" in state.message


def test_sessions_and_scripts_go_into_the_files_that_were_named(
    tmp_path: Path, state: RetopoState
) -> None:
    paths = {"session": tmp_path / "mine.zip", "script": tmp_path / "mine.jsonl"}
    paths["session"].write_bytes(b"older")
    state.files = writer(tmp_path, **paths)
    square(state)
    Saver(state, writer(tmp_path), SIZE).play(["s", "S", "s", "S"])
    assert sorted(tmp_path.iterdir()) == sorted(paths.values())
    assert len(read_session(paths["session"]).state.network.patches) == 1


def test_a_crash_would_lose_half_a_minute(tmp_path: Path, state: RetopoState) -> None:
    now = [0.0]
    autosave = Autosave(state.ground, state.shown.state, folder=tmp_path, clock=lambda: now[0])
    state.files = Writer(tmp_path, None, None, Script("sheet.obj", ()), None, autosave)
    square(state)
    state.poll()
    assert list(tmp_path.iterdir()) == []
    now[0] = 31.0
    state.poll()
    (kept,) = tmp_path.iterdir()
    assert equal(read_session(kept).state.network, state.network)
    state.save_session()
    assert [path.name for path in tmp_path.iterdir()] == ["retopo-1.retopo"]
    state.undo()
    state.settle()
    now[0] = 62.0
    autosave.path = tmp_path / "no" / "where"
    assert state.poll() and state.message.startswith("nothing is kept in case of a crash")


def test_quitting_asks_once_if_work_would_be_lost(tmp_path: Path, state: RetopoState) -> None:
    files = writer(tmp_path)
    state.files = files
    saver = Saver(state, files, SIZE)
    assert saver.obey("q") is Effect.QUIT
    square(state)
    assert saver.obey("q") is Effect.REDRAW and "not saved" in state.message
    assert saver.obey("h") is Effect.REDRAW
    assert saver.obey("q") is Effect.REDRAW, "something else was pressed in between"
    assert saver.obey("q") is Effect.QUIT
    saver.obey("s")
    assert saver.play(["q", "i"]) is Effect.QUIT and state.mode.tool == "stroke"


def test_the_window_obeys_events_and_shows_the_picture(tmp_path: Path, state: RetopoState) -> None:
    try:
        opengl.prepare_opengl(off_screen=True)
    except DisplayError as error:
        assert "libegl1" in str(error)
        return
    from vtkmodules.vtkRenderingUI import vtkGenericRenderWindowInteractor

    files = writer(tmp_path)
    state.files = files
    saver = Saver(state, files, SIZE)
    window = RetopoWindow(state, saver, KEYS, SIZE, "sheet", off_screen=True)
    interactor = vtkGenericRenderWindowInteractor()
    window.listen(interactor)
    room = HEIGHT * SIZE[0] / SIZE[1] - PANEL

    def send(
        event: str,
        point: tuple[float, float] | None = None,
        key: str = "",
        *,
        held: tuple[int, int] = (0, 0),
    ) -> None:
        if point is not None:
            unit = SIZE[1] / HEIGHT
            x, y = at(state, point)
            x, y = (x + room / 2.0) * unit, (y + HEIGHT / 2.0) * unit
            interactor.SetEventInformation(round(x), round(y), *held, "\0", 0, "")
        elif key:
            code = key if len(key) == 1 else "\0"
            interactor.SetEventInformation(0, 0, 0, 0, code, 0, key)
        interactor.InvokeEvent(event)
        state.settle()
        interactor.InvokeEvent("TimerEvent")

    def press(*points: tuple[float, float]) -> None:
        send("MouseMoveEvent", points[0])
        send("LeftButtonPressEvent", points[0])
        for point in points[1:]:
            send("MouseMoveEvent", point)
        send("LeftButtonReleaseEvent", points[-1])

    try:
        send("KeyPressEvent", key="d")
        for k in range(4):
            press(SQUARE[k - 1], SQUARE[k])
        (patch,) = state.network.patches.values()
        assert len(patch.corners) == 4
        send("KeyPressEvent", key="a")
        send("MouseMoveEvent", (0.0, 1.6))
        assert state.preview is not None and state.preview.count > 0
        press((0.0, 1.6))
        assert len(state.network.patches) == 2
        chains = state.network.chains
        below = next(c.id for c in chains.values() if c.points[:, 1].max() < -1.4 and c.count)
        count, scale = chains[below].count, state.view.scale
        # With Control the wheel changes the curve under the pointer, with Shift its strip.
        send("MouseMoveEvent", (0.0, -1.5))
        send("MouseWheelForwardEvent", (0.0, -1.5), held=(1, 0))
        assert state.network.chains[below].count == count + 1 and state.view.scale == scale
        before = {c: chain.count for c, chain in state.network.chains.items()}
        send("MouseWheelBackwardEvent", (0.0, -1.5), held=(0, 1))
        fewer = [c for c, chain in state.network.chains.items() if chain.count < before[c]]
        assert below in fewer and len(fewer) >= 2
        send("MouseWheelForwardEvent", (0.0, -1.5))
        assert state.view.scale > scale
        axes, focus = state.view.axes, state.view.focus
        send("RightButtonPressEvent", (0.0, 0.0))
        send("MouseMoveEvent", (0.4, -0.6))
        send("RightButtonReleaseEvent", (0.4, -0.6))
        assert not np.allclose(state.view.axes, axes)
        send("MiddleButtonPressEvent", (0.0, 0.0))
        send("MouseMoveEvent", (0.3, 0.1))
        send("MiddleButtonReleaseEvent", (0.3, 0.1))
        assert not np.allclose(state.view.focus, focus)
        send("KeyPressEvent", key="U")
        assert state.message == "there is nothing to redo"
        send("KeyPressEvent", key="s")
        assert equal(read_session(tmp_path / "retopo-1.retopo").state.network, state.network)
        send("KeyPressEvent", key="3")
        send("KeyPressEvent", key="i")
        window.redraw()
        window.save(tmp_path / "window.png")
        save_drawn(tmp_path / "drawn.png", saver.drawn(), SIZE[1])
    finally:
        window.close()
    shown, painted = (read(tmp_path / f"{name}.png") for name in ("window", "drawn"))
    # Text and edges are smoothed differently; everything else is the same picture.
    assert shown.shape == painted.shape
    assert np.abs(shown - painted).mean() < 0.02


def test_a_window_leaves_a_script_and_no_recovery_file(
    tmp_path: Path, source: PatternSource, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Shell:
        """A window without one: it draws a square, and something else if it is told to."""

        fail = False

        def __init__(self, state: RetopoState, saver: Saver, *_: object) -> None:
            self.state, self.saver = state, saver

        def run(self) -> None:
            self.saver.drawn()
            KEYS.press(self.state, "3")
            square(self.state)
            self.state.poll()
            kept = [path for path in tmp_path.iterdir() if path.suffix == ".recovery"]
            assert len(kept) == 1
            if self.fail:
                raise ZeroDivisionError

        def close(self) -> None:
            pass

    monkeypatch.setattr("viewer.retopo.window.RetopoWindow", Shell)
    monkeypatch.setattr("viewer.retopo.window.prepare_opengl", lambda **_: None)
    monkeypatch.setattr(
        "viewer.retopo.window.Autosave", lambda *a, **k: Autosave(*a, **(k | {"every": 0.0}))
    )
    editor, script = Editor(sheet(), source), tmp_path / "done.jsonl"
    show(
        editor,
        title="sheet",
        script=script,
        begun=Script("sheet.obj", ()),
        folder=tmp_path,
        keys="i",
    )
    assert [path.name for path in tmp_path.iterdir()] == ["done.jsonl"]
    assert [line.call.tool for line in read_script(script).lines] == ["stroke"] * 4
    script.unlink()
    monkeypatch.setattr(Shell, "fail", True)
    with pytest.raises(ZeroDivisionError):
        show(Editor(sheet(), source), folder=tmp_path)
    (left,) = tmp_path.iterdir()
    assert left.suffix == ".recovery", "only a clean end takes it away"
    with pytest.raises(ValueError, match="no key"):
        show(editor, keys="zz")


def test_keys_wait_while_something_is_drawn(tmp_path: Path, state: RetopoState) -> None:
    saver = Saver(state, writer(tmp_path), SIZE)
    x, y = at(state, (0.0, 0.0))
    state.move(x, y)
    state.press(x, y)
    assert saver.obey("i") is Effect.REDRAW and state.message == "let go of the button first"
    assert state.mode.tool == "stroke"
    assert saver.obey("Escape") is Effect.REDRAW and not state.holding
    assert saver.obey("i") is Effect.REDRAW and state.mode.tool == "spine"
