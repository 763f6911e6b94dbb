"""Sessions: what a sketch tool works on, as one JSON file, and its autosave.

    {"kind": "retopology", "version": 1, "of": "", "content": {...}}

All tools share this envelope, one reader, one writer and one autosave; the content is the struct or
dataclass that a tool names in its :class:`SessionFormat`. Large arrays are packed, see
:mod:`patterndb.system.documents`.

The autosave writes a recovery file every half minute, next to the session or in a given folder
where there is none yet:

    spot.retopo  ->  spot.retopo.1234-5ef2c0d9.recovery        unnamed.1234-5ef2c0d9.recovery

with the number of the process that writes it and a number of its own, so that two windows do not
take each other's; then a digest of the session that the work began from, if there is one
(``spot.retopo.1234-5ef2c0d9-c2b1...recovery``). A file whose process is gone was left by a crash,
or by a window that was closed with unsaved work: :func:`find_recoveries` finds these. It is removed
once the work is saved, or discarded by the user.
"""

from __future__ import annotations

import contextlib
import hashlib
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

import numpy as np
from numpy.typing import ArrayLike

from patterndb.errors import PatternDBError
from patterndb.system.documents import (
    JsonModel,
    JsonValue,
    encode_json,
    name_file,
    parse_json,
    read_limited,
)
from patterndb.system.files import replace_file

VERSION = 1

#: Bytes that a session may have: those of a surface of some 15 million triangles.
MAX_BYTES = 1_000_000_000

Work = TypeVar("Work")
Content = TypeVar("Content")


class Envelope(JsonModel):
    """What every session has. of: a digest of what is worked on, "" where the content has it."""

    kind: str
    version: int
    content: Any
    of: str = ""


@dataclass(frozen=True, slots=True)
class SessionFormat(Generic[Work, Content]):
    """How a tool's work is kept.

    kind: its name. error: what is raised about a file. content: the type that is written and read.
    save: makes the content of the work. open: makes the work of a content, at its
    place in the document; raises ``error``.
    """

    kind: str
    error: type[PatternDBError]
    content: type[Content]
    save: Callable[[Work], Content]
    open: Callable[[Content, JsonValue], Work]

    def encode(self, work: Work, of: str = "") -> bytes:
        """Return the bytes of a session; the same work gives the same bytes."""
        return encode_json(Envelope(self.kind, VERSION, self.save(work), of), packed=True)

    def decode(self, data: bytes) -> Work:
        """Return the work in the bytes of a session; raises ``error`` with the place in them."""
        return self._decode(data)[0]

    def read(self, path: Path | str) -> Work:
        """Return the work in a file, bit for bit as it was written.

        Raises ``error`` with the file and the place in it; OSError.
        """
        return self.read_with_origin(path)[0]

    def read_with_origin(self, path: Path | str) -> tuple[Work, str]:
        """Return as :meth:`read` the work, and the digest of what it is on, "" for none."""
        path = Path(path)
        with name_file(path, self.error):
            return self._decode(read_limited(path, MAX_BYTES, self.error, "split the surface"))

    def _decode(self, data: bytes) -> tuple[Work, str]:
        try:
            document = parse_json(data, self.error, f"a session of {self.kind}")
        except self.error as reason:
            raise self.error(f"this is not a session of {self.kind}: {reason}") from None
        if not document.is_object or "kind" not in document.entries():
            document.fail(f'this is not a session of {self.kind}, which has "kind" and "version"')
        found = document.read(Envelope)
        if (found.kind, found.version) != (self.kind, VERSION):
            document.fail(
                f"this is {found.kind!r} version {found.version}; {self.kind!r} version {VERSION} "
                "is needed here"
            )
        place = document.at("content")
        content = place.read(self.content)
        with place.named():
            return self.open(content, place), found.of

    def write(self, path: Path | str, work: Work, of: str = "") -> None:
        """Write a session in one step; :meth:`read` gives it back bit for bit. Raises OSError."""
        replace_file(Path(path), self.encode(work, of))


def digest_arrays(*arrays: ArrayLike) -> str:
    """Return a short text that is the same for the same arrays alone."""
    found = hashlib.blake2b(digest_size=16)
    for one in map(np.ascontiguousarray, arrays):
        found.update(f"{one.shape}{one.dtype.str}".encode())
        found.update(one.tobytes())
    return found.hexdigest()


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
