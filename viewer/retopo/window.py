"""The window of retopology, a thin shell on its state; pictures without one."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from numpy.typing import ArrayLike

from patterndb.system.knownfiles import KnownFiles
from patterndb_sketch.retopo.editor import Retopology, State
from patterndb_sketch.retopo.files import RetopoFiles, WriteMesh
from patterndb_sketch.retopo.script import Script
from patterndb_sketch.retopo.session import RetopoSession, autosave_session
from viewer import saver, style
from viewer.facts import FactSheet
from viewer.picture import WINDOW, check_png, save_sheet
from viewer.retopo.facts import describe_network, tell_hint
from viewer.retopo.keys import COMMANDS, KEYS
from viewer.retopo.picture import RetopoPainter
from viewer.retopo.pointing import find_side
from viewer.retopo.state import RetopoState
from viewer.stage import Drawn

#: Where the name of a side is written, and its size, in points.
SIDE_AT, SIDE_SIZE = (12.0, 12.0), 13.0


def show(
    editor: Retopology,
    *,
    title: str = "",
    session: Path | None = None,
    script: Path | None = None,
    begun: Script | None = None,
    write_mesh: WriteMesh | None = None,
    known: KnownFiles | None = None,
    keys: str = "",
    folder: Path | str = ".",
    window_size: tuple[int, int] = WINDOW,
) -> None:
    """Retopologise a surface in a window, until it is closed.

    editor: with the surface, and what has been done before. title: of the window.
    session: where the session is saved; None for a new file in the folder. script: likewise
    where calls are saved; if it is given, at the end in any case. What is not saved is kept beside
    the session, or in the folder, in case of a crash. begun: how a script of what was done before
    begins, with how it names the surface; by default only with the title as that name.
    write_mesh: writes quads. known: what the session was when it was read; by default as it is
    now. keys: pressed first, with spaces
    between. folder: for what keys save. window_size: pixels.

    Raises ValueError for a key there is not, DisplayError if no window can be opened here, and
    OSError if the script cannot be written at the end.
    """
    pressed = KEYS.check(keys)
    # Qt is imported for windows alone: pictures need none.
    from viewer.shell.probe import check_display

    check_display()
    folder = Path(folder)
    said = Script(title, ()) if begun is None else begun
    name = Path(said.surface).name
    files = RetopoFiles(folder, session, script, said, write_mesh, None, known)
    files.autosave = autosave_session(
        RetopoSession(editor.surface, editor.state, name),
        session=session,
        base="" if session is None else files.known.digest(session),
        folder=folder,
    )
    state = RetopoState(editor, files=files)
    state.message = files.find_lost(editor.surface)
    from viewer.retopo.docks import RetopoWindow
    from viewer.shell.opening import open_window

    shell = RetopoSaver(state, files, window_size)
    open_window(shell, pressed, title or "Retopology", RetopoWindow)


def draw(
    editor: Retopology,
    path: Path | str,
    *,
    toward: ArrayLike | None = None,
    sides: Sequence[str] = (),
    size: tuple[int, int] = (1200, 800),
    keys: str = "",
    title: str = "",
) -> None:
    """Write a picture of an editor's network and its quads to a PNG, without a window.

    toward: (3,) the direction from the surface to the viewer, None for one from the front left
    and above. sides: names of :data:`~viewer.retopo.pointing.VIEW_SIDES`; each is drawn, in place
    of that, beside and below each other. size: pixels, of each. keys: pressed first, such as
    "m x". All else as for :func:`show`. Patches without a fill get one.

    Raises PictureFormatError if path is not a PNG, ValueError for a key or a side there is not,
    and OSError as writing does.
    """
    pressed = KEYS.check(keys)
    path = check_png(path)
    for side in sides:
        find_side("z", side)
    files = RetopoFiles(path.parent, None, None, Script(title, ()), None)
    state = RetopoState(editor, files=files)
    try:
        shell = RetopoSaver(state, files, size)
        shell.drawn()
        if toward is not None:
            state.camera.look_along(toward)
        shell.play(pressed)
        state.settle()
        sheet: list[Drawn] = []
        for side in sides:
            state.camera.look_from(find_side(state.camera.upright, side))
            drawn = shell.drawn()
            drawn.scene.text(*SIDE_AT, side, SIDE_SIZE, colour=style.FAINT_TEXT, align="left")
            sheet.append(drawn)
        save_sheet(path, sheet or [shell.drawn()], size[1])
    finally:
        state.close()


class RetopoSaver(saver.SessionSaver):
    """Draws the state, obeys keys, and writes pictures."""

    kind = "retopo"
    suffix = ".retopo"
    files: RetopoFiles
    commands = COMMANDS
    state: RetopoState

    def __init__(self, state: RetopoState, files: RetopoFiles, size: tuple[int, int]) -> None:
        super().__init__(state, KEYS, files, size)
        self._painter = RetopoPainter()

    def drawn(self) -> Drawn:
        return self._painter.compose(self.state, float(self.size[0]), float(self.size[1]))

    def draw_live(self, width: float, height: float) -> Drawn:
        return self._painter.compose(self.state, width, height, axes=True)

    def describe(self, sheet: FactSheet) -> None:
        describe_network(sheet, self.state)

    def first_hint(self) -> str:
        empty = all(chain.marked for chain in self.state.network.chains.values())
        waits = self.state.editing.waiting or self.state.tool.holding
        if not empty or waits:
            return ""
        return (
            "Drag on the surface: a curve. Curves that close a loop become quads.\n"
            "8 makes a first draft of all of it; F1 lists all that can be done."
        )

    def hint(self) -> str:
        return tell_hint(self.state)

    def is_held(self) -> bool:
        return self.state.tool.holding

    def kept_work(self) -> State:
        return self.state.shown.state

    def end(self, *, discarded: bool) -> None:
        self.state.close()
        self.state.editing.take()
        written = True
        try:
            written = self.files.end_script(self.state.editing.calls)
        finally:
            super().end(discarded=discarded or written)

    def would_lose(self) -> str:
        if self.state.tool.holding:
            return "A line is being drawn, and nothing of it is saved."
        return "The session is not saved." if self.state.editing.unsaved else ""
