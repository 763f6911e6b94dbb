"""Where a window saves its sessions, what it keeps in case of a crash, and what one left."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Generic, TypeVar

from patterndb.errors import PatternDBError
from patterndb.system.knownfiles import KnownFiles, digest_file
from patterndb_sketch.sessions import (
    UNNAMED,
    Autosave,
    Recovery,
    SessionFormat,
    find_recoveries,
)

Kept = TypeVar("Kept")
Lost = TypeVar("Lost")


def find_free_name(folder: Path, name: str, suffix: str) -> Path:
    """Find a path in a folder that no file has: the name with a number and the suffix."""
    count = 1
    while (path := folder / f"{name}-{count}{suffix}").exists():
        count += 1
    return path


class SessionWriter(Generic[Kept, Lost]):
    """Writes files into a folder under names that are free; the session always into one.

    session_path: None until it is known. known: what files were when they were opened or saved
    last; the session by default as it is now. autosave: keeps states in case of a crash, None for
    not at all. lost: what a crash left of this work; None if it left nothing. unnamed: how names of
    recovery files begin while there is no session.
    """

    unnamed = UNNAMED

    def __init__(
        self,
        folder: Path,
        session_path: Path | None,
        autosave: Autosave[Kept] | None = None,
        known: KnownFiles | None = None,
    ) -> None:
        self._folder, self.session_path, self.autosave = folder, session_path, autosave
        self.known = KnownFiles() if known is None else known
        if session_path is not None:
            self.known.note_once(session_path)
        self.lost: Lost | None = None
        self._left: Path | None = None
        self._is_behind = False

    def free(self, name: str, suffix: str) -> Path:
        """A name that no file in the folder has."""
        return find_free_name(self._folder, name, suffix)

    def find_recovery(self, read: Callable[[Path], Lost | str]) -> str:
        """Read what a crash left of this work, if it did, and say so; "" if it did not.

        read: reads a recovery file; a text says why it is of no use here.
        """
        said = ""
        for found in find_recoveries(self.session_path, self._folder, self.unnamed):
            try:
                lost = read(found.path)
            except (PatternDBError, OSError) as error:
                lost = f"which cannot be read: {error}"
            if isinstance(lost, str):
                said = said or f"a crash left {found.path.name}, {lost}"
                continue
            self.lost, self._left = lost, found.path
            self._is_behind = self._is_older(found)
            when = time.strftime("%d %B, %H:%M", time.localtime(found.written))
            return f"a crash left work of {when}: R opens it in place of what is here"
        return said

    def _is_older(self, found: Recovery) -> bool:
        """Was the session saved since the work began that a crash left?"""
        now = None if self.session_path is None else digest_file(self.session_path)
        if self.session_path is None or now is None:
            return False
        if found.base:
            return found.base != now.hex()
        return self.session_path.stat().st_mtime > found.written

    def replace_session(self, path: Path, write: Callable[[], object]) -> None:
        """Write the session to a file; FileChangedError if that has changed since it was opened or
        saved last, or since work began that a crash left and that was opened."""
        if self._is_behind and self._left is not None and self.lost is None:
            self._is_behind = False
            if path == self.session_path:
                self.known.mistrust(path)

        def move(other: Path) -> None:
            self.session_path = other

        self.known.save(path, write, move=move)

    def discard_lost(self) -> None:
        """Delete what a crash left; OSError as deleting does."""
        if self._left is not None:
            self._left.unlink(missing_ok=True)
        self.lost = self._left = None

    def note_saved(self, state: Kept, path: Path | None) -> None:
        """A state was saved, to a session or in another form (None): what was kept of it, or opened
        to begin with, goes."""
        self.session_path = path
        if self.autosave is not None:
            self.autosave.saved(state, path, "" if path is None else self.known.digest(path))
        self._drop_opened()

    def tick(self, state: Kept) -> str:
        """Keep a state in case of a crash, if it is time; says why that cannot be, else ""."""
        try:
            if self.autosave is not None:
                self.autosave.tick(state)
        except OSError as error:
            return f"nothing is kept in case of a crash: {error}"
        return ""

    def end(self, state: Kept | None) -> Path | None:
        """Keep nothing any more, but a last state that no session has: returns where that is."""
        autosave, self.autosave = self.autosave, None
        kept = None if autosave is None else autosave.close(state)
        if state is None or kept is not None:
            self._drop_opened()
        return kept

    def _drop_opened(self) -> None:
        """What a crash left was opened, and is saved now, kept anew, or not wanted: its file goes.
        One that cannot go is offered once more."""
        if self._left is not None and self.lost is None:
            with contextlib.suppress(OSError):
                self._left.unlink(missing_ok=True)
            self._left = None


class WorkKeeper(SessionWriter[Kept, Kept]):
    """Keeps what is done in a window in case of a crash where there are no sessions.

    form: of the work. of: a digest of what is worked on. state: the first, which needs no saving.
    folder: where recovery files are. same: is there nothing to save in the one that the other has
    not? is_usable: can work that was read go on here?
    """

    def __init__(
        self,
        form: SessionFormat[Kept, Any],
        of: str,
        state: Kept,
        folder: Path,
        same: Callable[[Kept, Kept], bool],
        is_usable: Callable[[Kept], bool] = lambda _: True,
    ) -> None:
        self.unnamed = f"unnamed-{form.kind}"
        self._form, self._of, self._is_usable = form, of, is_usable
        autosave = Autosave(
            lambda kept: form.encode(kept, of),
            state,
            folder=folder,
            unnamed=self.unnamed,
            same=same,
        )
        super().__init__(folder, None, autosave)

    def find_lost(self) -> str:
        """Read what a crash left of this work, and describe it; "" if it left nothing."""

        def read(path: Path) -> Kept | str:
            work, of = self._form.read_with_origin(path)
            if of != self._of or not self._is_usable(work):
                return "of something else; it is offered where that is opened in this folder"
            return work

        return self.find_recovery(read)
