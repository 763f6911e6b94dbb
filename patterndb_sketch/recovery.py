"""Where work is saved, what is kept of it in case of a crash, and what a crash left.

The autosave writes a recovery file every half minute, next to the session or in a given folder
where there is none yet:

    spot.retopo  ->  spot.retopo.1234-5ef2c0d9.recovery        unnamed.1234-5ef2c0d9.recovery

with the number of the process that writes it and a number of its own, so that two windows do not
take each other's; then a digest of the session that the work began from, if there is one
(``spot.retopo.1234-5ef2c0d9-c2b1...recovery``). A file whose process is gone was left by a crash,
or by a window that was closed with unsaved work: :func:`find_recoveries` finds these. It is removed
once the work is saved, or discarded by the user.

:class:`SessionWriter` adds where a session is saved and what the file was when it was opened;
:class:`WorkKeeper` keeps work that has no sessions. Neither knows a window.
"""

from __future__ import annotations

import contextlib
import math
import operator
import os
import re
import secrets
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from patterndb.errors import PatternDBError
from patterndb.system.files import replace_file
from patterndb.system.knownfiles import KnownFiles, digest_file
from patterndb_sketch.sessions import SessionFormat

Work = TypeVar("Work")
Kept = TypeVar("Kept")
Lost = TypeVar("Lost")

#: Seconds between two writes, as in the released program of Takayama et al. 2013.
EVERY = 30.0

ENDING = ".recovery"
UNNAMED = "unnamed"

#: What this process writes. Its number alone would not tell: a system may give it again, and the
#: first process of every container has the same.
_OWN: set[str] = set()


@dataclass(frozen=True, slots=True)
class Recovery:
    """What a crash left. written: when, in seconds since 1970, as time.time() has them. base: the
    digest of the session that the work began from, "" where that is not known."""

    path: Path
    written: float
    base: str = ""


class Autosave(Generic[Work]):
    """Writes the states of what is worked on to a recovery file.

    Call :meth:`tick` often, as from a timer every second: it writes when it is time and something
    changed. A kill then loses what was done in the last EVERY seconds, and between two ticks. A
    state is immutable, so that ticks may come from another thread than edits do.

    Differs from the released program: the named session is never overwritten but by hand, and
    drawings that have no name yet are saved, too.
    """

    def __init__(
        self,
        encode: Callable[[Work], bytes],
        state: Work,
        *,
        session: Path | None = None,
        base: str = "",
        folder: Path | None = None,
        unnamed: str = UNNAMED,
        same: Callable[[Work, Work], bool] = operator.is_,
        every: float = EVERY,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """For work whose state, given, needs no saving.

        encode: gives the content of a session with a state. session: the file that is worked on,
        base: its digest, in hexadecimal digits. folder: where recovery files are while there is no
        session, whose names begin with ``unnamed`` then; with neither, nothing is written until
        :meth:`saved` names a session. same: is there nothing to save in one state that the other
        has not? every: seconds. clock: gives seconds, from anywhere on.
        """
        self._encode, self._same = encode, same
        self._every = every
        self._clock = clock
        self._folder, self._unnamed = folder, unnamed
        self._kept = self._saved = state
        self._at = clock()
        self._token = f"{os.getpid()}-{secrets.token_hex(4)}"
        _OWN.add(self._token)
        self.path = self._path(session, base)

    def tick(self, state: Work) -> bool:
        """Write the state if it is another than the last kept and it is time; was it written?

        OSError as writing does; it is tried again after as long.
        """
        now = self._clock()
        if state is self._kept or self.path is None or now - self._at < self._every:
            return False
        self._at = now
        if self._same(state, self._kept):
            self._kept = state
            return False
        replace_file(self.path, self._encode(state))
        self._kept = state
        return True

    def saved(self, state: Work, session: Path | None, base: str = "") -> None:
        """The user saved this state: the recovery file so far is of no use any more, and the next
        is beside the session that it was saved to, or where it was if that is no session. base:
        the digest of what was saved."""
        self._remove()
        self.path = self._path(session, base)
        self._kept = self._saved = state
        self._at = self._clock()

    def close(self, state: Work | None = None) -> Path | None:
        """End: without a state, nothing is wanted any more and the recovery file goes.

        With one that no session has, it is written once more, and the path returned: whoever
        closes a window has not said that the work may go. OSError as writing does.
        """
        _OWN.discard(self._token)
        path = self.path
        if state is None or path is None or self._same(state, self._saved):
            self._remove()
            self.path = None
            return None
        self._at = -math.inf
        self.tick(state)
        return path

    def _path(self, session: Path | None, base: str) -> Path | None:
        ending = f".{self._token}{base and f'-{base}'}{ENDING}"
        if session is not None:
            return session.with_name(session.name + ending)
        return None if self._folder is None else self._folder / (self._unnamed + ending)

    def _remove(self) -> None:
        if self.path is not None:
            # One that cannot go is offered once more; that is no reason to fail at the end.
            with contextlib.suppress(OSError):
                self.path.unlink(missing_ok=True)


def find_recoveries(
    session: Path | None = None, folder: Path | None = None, unnamed: str = UNNAMED
) -> list[Recovery]:
    """What crashes left of work on a session, or with None of unnamed work in a folder; the latest
    first. Files of programs that still run are not among them.

    Read one as a session; remove it once its state is saved, or the user does not want it.
    """
    where = session.absolute().parent if session is not None else folder
    if where is None or not where.is_dir():
        return []
    stem = unnamed if session is None else session.name
    form = re.compile(re.escape(stem) + r"\.((\d+)-[0-9a-f]+)(?:-([0-9a-f]+))?" + re.escape(ENDING))
    found: list[Recovery] = []
    for path in where.iterdir():
        match = form.fullmatch(path.name)
        if match is None or match[1] in _OWN or _is_running(int(match[2])):
            continue
        with contextlib.suppress(FileNotFoundError):
            found.append(Recovery(path, path.stat().st_mtime, match[3] or ""))
    return sorted(found, key=lambda one: (-one.written, one.path.name))


def _is_running(process: int) -> bool:
    """Does another process of this number run?"""
    if process == os.getpid():
        return False
    if os.name != "posix":
        # There a signal 0 ends a process: better to offer too much.
        return False
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        return True
    # One that has ended keeps its number until the program that started it asks what became of it.
    with contextlib.suppress(OSError):
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    return True


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
