"""Where the work of a retopology is saved: its session, its quads, its script, and recovery."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from patterndb.geometry.surface import Surface
from patterndb.system.knownfiles import FileChangedError, KnownFiles
from patterndb_sketch.recovery import Autosave, SessionWriter
from patterndb_sketch.retopo.editor import Call, State
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.filling import RetopoMesh
from patterndb_sketch.retopo.script import Script, ScriptLine, write_script
from patterndb_sketch.retopo.session import RETOPO_SESSION, RetopoSession

#: Writes quads to a file.
WriteMesh = Callable[[Path, RetopoMesh], None]


class RetopoFiles(SessionWriter[State, State]):
    """Writes files into a folder under names that are free; session and script always into the
    same.

    script: the file of the script, None for a new one. begun: how the script begins.
    write_mesh: writes quads, None where they cannot be saved.
    """

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
