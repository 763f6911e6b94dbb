"""The window of retopology, a thin shell on its state; pictures without one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from numpy.typing import ArrayLike

from patterndb.geometry.surface import Surface
from patterndb.system.knownfiles import FileChangedError, KnownFiles
from patterndb_sketch.retopo.editor import Call, Retopology, State
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.filling import RetopoMesh
from patterndb_sketch.retopo.script import Script, ScriptLine, write_script
from patterndb_sketch.retopo.session import (
    RETOPO_SESSION,
    RetopoSession,
    autosave_session,
)
from patterndb_sketch.sessions import Autosave
from viewer import saver, style
from viewer.facts import FactSheet
from viewer.picture import WINDOW, Drawn, check_png, save_sheet
from viewer.retopo.facts import describe_network, tell_hint
from viewer.retopo.keys import COMMANDS, KEYS
from viewer.retopo.picture import RetopoPainter
from viewer.retopo.pointing import find_side
from viewer.retopo.state import RetopoState
from viewer.sessions import SessionWriter

#: Writes quads to a file.
WriteMesh = Callable[[Path, RetopoMesh], None]


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
    files = RetopoWriter(folder, session, script, said, write_mesh, None, known)
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
    """Write a picture of an editor's network and its quads to a PNG, without a window and
    OpenGL: the same everywhere.

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
    files = RetopoWriter(path.parent, None, None, Script(title, ()), None)
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


class RetopoWriter(SessionWriter[State, State]):
    """Writes files into a folder under names that are free; session and script always into the
    same."""

    def __init__(
        self,
        folder: Path,
        session: Path | None,
        script: Path | None,
        begun: Script,
        write_mesh: WriteMesh | None,
        autosave: Autosave[State] | None = None,
        known: KnownFiles | None = None,
    ) -> None:
        super().__init__(folder, session, autosave, known)
        self._script, self._begun = script, begun
        if script is not None:
            self.known.note_once(script)
        self._ends_with_script = script is not None
        self._write_mesh = write_mesh

    def find_lost(self, surface: Surface) -> str:
        """Read what a crash left of work on a surface, and say so; "" if it left nothing."""

        def read(path: Path) -> State | str:
            kept = RETOPO_SESSION.read(path)
            return kept.state if kept.surface.is_same(surface) else (
                f"of another surface, {kept.name or 'unnamed'}; rename it to end in .retopo, and "
                "give it as --session to go on from it"
            )  # fmt: skip

        return self.find_recovery(read)

    def read_again(self, surface: Surface) -> State:
        """Read the session that is in the file by now; InvalidRetopoError if it is of another
        surface."""
        path = self.session_path
        if path is None:
            raise InvalidRetopoError("there is no session to be read: none was saved yet")
        self.known.note(path)
        kept = RETOPO_SESSION.read(path)
        if not kept.surface.is_same(surface):
            raise InvalidRetopoError(
                f"{path} is of another surface by now, {kept.name or 'unnamed'}: open it in "
                "another window"
            )
        return kept.state

    def save_session(self, surface: Surface, state: State) -> str:
        """Replace the session's file, whole or not at all."""
        path = self.session_path or self.free("retopo", ".retopo")
        kept = RetopoSession(surface, state, Path(self._begun.surface).name)
        self.replace_session(path, lambda: RETOPO_SESSION.write(path, kept))
        self.note_saved(state, path)
        return f"saved {path}"

    def end_script(self, calls: tuple[Call, ...] | None) -> bool:
        """At the end: write the script that was asked for, once; False if none was, or there is
        nothing to write."""
        wanted, self._ends_with_script = self._ends_with_script and bool(calls), False
        if wanted:
            try:
                self.save_script(calls or ())
            except FileChangedError as error:
                # The window is closed: nobody can be asked, and both are kept.
                self._script = self.free(error.path.stem, error.path.suffix)
                raise InvalidRetopoError(f"{error}; {self.save_script(calls or ())}") from error
        return wanted

    def save_mesh(self, mesh: RetopoMesh) -> str:
        """Write the quads."""
        if self._write_mesh is None:
            return "meshes cannot be saved here: no way to write them was given"
        path = self.free("quads", ".obj")
        self._write_mesh(path, mesh)
        return f"saved {path}"

    def save_script(self, calls: tuple[Call, ...]) -> str:
        """Replace the script's file."""
        path = self._script or self.free("retopo", ".jsonl")
        before = self._begun.lines
        first = 2 + len(before)
        lines = tuple(ScriptLine(number, call) for number, call in enumerate(calls, first))
        said = replace(self._begun, lines=(*before, *lines))

        def move(other: Path) -> None:
            self._script = other

        self.known.save(path, lambda: write_script(path, said), move=move)
        self._script = path
        return f"saved {path}"


class RetopoSaver(saver.SessionSaver):
    """Draws the state, obeys keys, and writes pictures."""

    kind = "retopo"
    suffix = ".retopo"
    files: RetopoWriter
    commands = COMMANDS
    state: RetopoState

    def __init__(self, state: RetopoState, files: RetopoWriter, size: tuple[int, int]) -> None:
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
