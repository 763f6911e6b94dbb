"""Acting: the half of the viewer that asks the editor, and keeps what was asked as a script."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from patterndb_sketch.retopo.editor import Call, Editor, Outcome, State
from patterndb_sketch.retopo.filling import RetopoMesh
from patterndb_sketch.retopo.ground import Ground
from patterndb_sketch.retopo.network import Network
from patterndb_sketch.retopo.sizes import Sizes
from viewer.card import format_count
from viewer.retopo.work import EditorWorker, Shown

#: Seconds that a call is waited for: what is done at once is shown at once.
AT_ONCE = 0.05


class RetopoFiles(Protocol):
    """Writes what is worked on, and says where it is; ``tick`` is called often, and may write
    what is to be found after a crash. OSError as writing does.

    lost: what a crash left, on the same ground; None if it left nothing."""

    lost: State | None

    def save_session(self, ground: Ground, state: State) -> str: ...
    def save_mesh(self, mesh: RetopoMesh) -> str: ...
    def save_script(self, calls: tuple[Call, ...]) -> str: ...
    def tick(self, state: State) -> None: ...


class Acting:
    """An editor, and calls of its tools.

    message: what was refused last and why, or what should be known. calls: those that changed
    something, in order; None if they do not begin from the bare surface, and are no script of
    what there is. files: for keys that save.
    """

    def __init__(self, editor: Editor, files: RetopoFiles | None) -> None:
        self.ground = editor.ground
        self.message = ""
        self.files = files
        bare = all(chain.marked for chain in editor.network.chains.values())
        self.calls: tuple[Call, ...] | None = () if bare and not editor.undoable else None
        self._work = EditorWorker(editor)
        self._seen = self._work.shown
        self._saved = self._seen.state

    def close(self) -> None:
        """Wait until nothing is being made any more."""
        self._work.close()

    @property
    def shown(self) -> Shown:
        """What there is to see."""
        return self._work.shown

    @property
    def network(self) -> Network:
        return self.shown.state.network

    @property
    def sizes(self) -> Sizes:
        return self.shown.state.sizes

    @property
    def waiting(self) -> int:
        """Calls that are not done with."""
        return self._work.waiting

    @property
    def working(self) -> tuple[str, ...]:
        """Their tools, in order; the first is at work."""
        return self._work.tools

    @property
    def unsaved(self) -> bool:
        """Has anything changed since the session was saved?"""
        return not self.shown.state.same(self._saved)

    def do(self, tool: str, **arguments: object) -> None:
        """Call a tool; what it comes to is shown as soon as it is there."""
        self._work.ask(Call(tool, arguments))
        self._work.wait(AT_ONCE)
        self.take()

    def take(self) -> bool:
        """Take what has been done since this was asked last; True if there is something new."""
        done = self._work.done()
        for call, outcome in done:
            self._told(call, outcome)
        shown = self._work.shown
        new, self._seen = shown is not self._seen, shown
        return self._work.lists.take() or new or bool(done)

    def tick(self) -> bool:
        """Time goes on: what a crash would lose may be written. True if that cannot be."""
        if self.files is None:
            return False
        try:
            self.files.tick(self.shown.state)
        except OSError as error:
            self.message = f"nothing is kept in case of a crash: {error}"
            return True
        return False

    def undo(self) -> None:
        """One step back."""
        self.do("undo")

    def redo(self) -> None:
        """One step forward again."""
        self.do("redo")

    def save_session(self) -> None:
        """Save the session."""
        state = self.shown.state
        if self._save("sessions", lambda files: files.save_session(self.ground, state)):
            self._saved = state

    def save_mesh(self) -> None:
        """Save the quads."""
        shown = self.shown
        if self.files is not None and not shown.fresh:
            self.message = "the quads are still being made; save them in a moment"
        elif self.files is not None and not shown.filled.placed:
            self.message = "there are no quads to save; close a loop of curves"
        else:
            self._save("meshes", lambda files: files.save_mesh(shown.body.mesh))

    def save_script(self) -> None:
        """Save all calls since the window was opened."""
        calls = self.calls
        if self.files is not None and calls is None:
            self.message = "this did not begin from the bare surface: a script would not make it"
        elif self.files is not None and not calls:
            self.message = "nothing has been done that a script could do again"
        else:
            self._save("scripts", lambda files: files.save_script(calls or ()))

    def recover(self) -> None:
        """Go on from what a crash left; only before anything else is done."""
        found = None if self.files is None else self.files.lost
        if self.files is None or found is None:
            self.message = "there is nothing that a crash left"
        elif self.shown.undoable or self.waiting:
            self.message = "undo what has been done first: the recovered session replaces it"
        else:
            self._work.begin(found)
            self.files.lost = None
            self.calls = None
            self.message = (
                "this is what the crash left; s saves it, and its file goes then. A script would "
                "not make it: none is recorded"
            )

    def drop_waiting(self) -> bool:
        """Drop what was asked for and has not begun; False if nothing is being made."""
        if not self.waiting:
            return False
        dropped = self._work.drop()
        if dropped:
            self.message = f"dropped: {format_count(dropped, 'step')} that had not begun"
        else:
            self.message = "what is being made cannot be stopped; u takes it back"
        return True

    def _save(self, what: str, save: Callable[[RetopoFiles], str]) -> bool:
        """Save something, and say where or why not; True if it is saved."""
        if self.files is None:
            self.message = f"{what} cannot be saved here"
            return False
        try:
            self.message = save(self.files)
        except OSError as error:
            self.message = f"not saved: {error}"
            return False
        return True

    def _told(self, call: Call, outcome: Outcome) -> None:
        if outcome.refused is not None:
            self.message = outcome.refused
        elif outcome.notes:
            self.message = "; ".join(outcome.notes)
        elif not outcome.changed:
            self.message = f"{call.tool}: nothing changed"
        if outcome.changed and self.calls is not None:
            self.calls = (*self.calls, call)
