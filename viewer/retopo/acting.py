"""Acting: the half of the viewer that asks the editor, and keeps what was asked as a script."""

from __future__ import annotations

from typing import Protocol

from sketch.retopo.editor import Call, Editor, Outcome, State
from sketch.retopo.filling import RetopoMesh
from sketch.retopo.ground import Ground
from sketch.retopo.network import Network
from sketch.retopo.sizes import Sizes
from viewer.retopo.work import Shown, Work

#: Seconds that a call is waited for: what is done at once is shown at once.
AT_ONCE = 0.05


class Files(Protocol):
    """Writes what is worked on, and says where it is; ``tick`` is called often, and may write
    what is to be found after a crash. OSError as writing does."""

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

    def __init__(self, editor: Editor, files: Files | None) -> None:
        self.ground = editor.ground
        self.message = ""
        self.files = files
        bare = all(chain.marked for chain in editor.network.chains.values())
        self.calls: tuple[Call, ...] | None = () if bare and not editor.undoable else None
        self._work = Work(editor)
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
        return new or bool(done)

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
        if self.files is None:
            self.message = "sessions cannot be saved here"
            return
        state = self.shown.state
        try:
            self.message = self.files.save_session(self.ground, state)
        except OSError as error:
            self.message = f"not saved: {error}"
        else:
            self._saved = state

    def save_mesh(self) -> None:
        """Save the quads."""
        shown = self.shown
        if self.files is None:
            self.message = "meshes cannot be saved here"
        elif not shown.fresh:
            self.message = "the quads are still being made; save them in a moment"
        elif not shown.filled.placed:
            self.message = "there are no quads to save; close a loop of curves"
        else:
            try:
                self.message = self.files.save_mesh(shown.body.mesh)
            except OSError as error:
                self.message = f"not saved: {error}"

    def save_script(self) -> None:
        """Save all calls since the window was opened."""
        if self.files is None:
            self.message = "scripts cannot be saved here"
        elif self.calls is None:
            self.message = "this did not begin from the bare surface: a script would not make it"
        elif not self.calls:
            self.message = "nothing has been done that a script could do again"
        else:
            try:
                self.message = self.files.save_script(self.calls)
            except OSError as error:
                self.message = f"not saved: {error}"

    def _told(self, call: Call, outcome: Outcome) -> None:
        if outcome.refused is not None:
            self.message = outcome.refused
        elif outcome.notes:
            self.message = "; ".join(outcome.notes)
        elif not outcome.changed:
            self.message = f"{call.tool}: nothing changed"
        if outcome.changed and self.calls is not None:
            self.calls = (*self.calls, call)
