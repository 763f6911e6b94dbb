"""Reading regular files alone, and writing files so that no half-written one is ever seen.

A file is written in a folder of its own beside the one that it replaces, and moved there when it is
whole. The folder is locked meanwhile: one that nobody has locked was left by a process that was
killed, and the next file that is written beside it takes it away.
"""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
import stat
import sys
import tempfile
import time
from collections.abc import Generator, Iterator
from io import BufferedReader
from pathlib import Path

if sys.platform != "win32":
    import fcntl

from patterndb.errors import PatternDBError

#: What is said of pipes, sockets and devices: they could block, or never end.
IRREGULAR = "not a regular file but a pipe, socket or device; write it to a file first"

#: How files begin that a program has compressed, which program, and what unpacks them.
_COMPRESSED = (
    (b"\x1f\x8b", "gzip", "gunzip"),
    (b"BZh", "bzip2", "bunzip2"),
    (b"\xfd7zXZ\0", "xz", "unxz"),
    (b"\x28\xb5\x2f\xfd", "zstd", "unzstd"),
    (b"PK\x03\x04", "zip", "unzip"),
)

#: How the names of folders begin in which files are being written.
UNFINISHED = ".patterndb-"

#: Seconds after which such a folder is nobody's any more, where folders cannot be locked (Windows).
ABANDONED_SECONDS = 3600.0

#: What tempfile lets others do with its folders: nothing.
_OWN_MODE = 0o700

_O_BINARY: int = getattr(os, "O_BINARY", 0)  # Windows alone translates line ends without it


def may_name_file(name: str) -> bool:
    """Can a file have this name? Texts of documents may hold what none can: a zero, or half of a
    surrogate pair."""
    try:
        return b"\0" not in os.fsencode(name)
    except UnicodeEncodeError:
        return False


def explain_compression(data: bytes) -> str | None:
    """Say that the content of a file is compressed and what to do; None if it is not."""
    for beginning, name, command in _COMPRESSED:
        if data.startswith(beginning):
            return f"the file is compressed ({name}); unpack it first, with {command}"
    return None


def open_regular(path: Path | str) -> BufferedReader:
    """Open a regular file to read its bytes; links are followed.

    Raises OSError as opening does, and for a pipe, a socket or a device, or a name that no file
    can have.
    """
    if not may_name_file(str(path)):
        raise OSError(errno.EINVAL, "no file can have this name", ascii(str(path)))
    # O_NONBLOCK lets the open of a pipe return that nobody writes to.
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | _O_BINARY)
    mode = os.fstat(descriptor).st_mode
    if not stat.S_ISREG(mode):
        os.close(descriptor)
        if stat.S_ISDIR(mode):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        raise OSError(errno.EINVAL, IRREGULAR, str(path))
    return os.fdopen(descriptor, "rb")


def read_lines(
    path: Path, longest: int, error: type[PatternDBError]
) -> Iterator[tuple[int, bytes]]:
    """Yield the lines of a file that are not blank, with their numbers from 1.

    A mark of the order of bytes at the beginning is left out. Raises ``error`` for a line of more
    than ``longest`` bytes, and OSError as :func:`open_regular` does.
    """
    with open_regular(path) as file:
        number = 0
        while line := file.readline(longest + 1):
            number += 1
            if len(line) > longest:
                raise error(f"{path}: line {number} has more than {longest:,} bytes")
            if line.strip():
                yield number, line.removeprefix(b"\xef\xbb\xbf") if number == 1 else line


def replace_file(path: Path, content: str | bytes) -> None:
    """Write ``content`` beside ``path`` and move it there in one step.

    A symbolic link stays one: what it leads to is replaced. Raises OSError as writing does; the
    old file, if there was one, is then still there.
    """
    path = Path(os.path.realpath(path)) if path.is_symlink() else path
    data = content.encode() if isinstance(content, str) else content
    with write_beside(path) as fresh:
        fresh.write_bytes(data)


@contextlib.contextmanager
def write_beside(path: Path) -> Generator[Path]:
    """Give a path to write a file at; when the block ends, the file is moved to ``path``.

    What else the block leaves beside the file (SQLite's journals) goes. Where it raises, ``path``
    is as it was. Raises OSError where nothing can be written there.
    """
    parent = path.absolute().parent
    remove_unfinished(parent)
    try:
        folder, lock = _make_locked(parent)
    except OSError as error:
        # The name that its folder would have had says nothing to whoever named the file.
        raise OSError(error.errno, error.strerror, str(path)) from error
    fresh = folder / path.name
    try:
        yield fresh
        # Else a crash of the machine could leave the new name with nothing in it.
        with fresh.open("rb+") as file:
            os.fsync(file.fileno())
        fresh.replace(path)
    except OSError as error:
        # A disk that is full, say: nobody knows the file by its name in that folder.
        if error.filename is not None and Path(error.filename) != fresh:
            raise
        raise OSError(error.errno, error.strerror, str(path)) from error
    except PatternDBError as error:
        error.args = (str(error).replace(str(fresh), str(path)), *error.args[1:])
        raise
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        if lock is not None:
            os.close(lock)


def remove_unfinished(folder: Path) -> None:
    """Take away what processes that were killed had begun to write in a folder."""
    with contextlib.suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if entry.name.startswith(UNFINISHED):
                _remove_if_left(Path(entry.path))


def _make_locked(parent: Path) -> tuple[Path, int | None]:
    """A new folder, and the descriptor that keeps it locked, if it can be."""
    while True:
        folder = Path(tempfile.mkdtemp(dir=parent, prefix=UNFINISHED))
        try:
            lock = _lock(folder, wait=True)
        except FileNotFoundError:
            continue
        # Another process may have taken it for one that was left, before it was locked.
        if lock is None or folder.exists():
            return folder, lock
        os.close(lock)


def _remove_if_left(folder: Path) -> None:
    """Remove a folder in which nobody is writing any more, if it is this user's and one of ours:
    one that holds files alone, and is for its owner alone. A folder of another kind has only the
    name, which whoever may write beside it could have given to what must stay."""
    with contextlib.suppress(OSError):
        if sys.platform == "win32":
            if time.time() - folder.stat().st_mtime > ABANDONED_SECONDS:
                shutil.rmtree(folder, ignore_errors=True)
            return
        lock = _lock(folder, wait=False)
        if lock is None:
            return
        try:
            found = os.fstat(lock)
            if found.st_uid != os.getuid() or stat.S_IMODE(found.st_mode) != _OWN_MODE:
                return
            # By the open folder: its name may be another's by now.
            with os.scandir(lock) as entries:
                held = [(entry.name, entry.is_file(follow_symlinks=False)) for entry in entries]
            if all(is_file for _, is_file in held):
                for name, _ in held:
                    os.unlink(name, dir_fd=lock)
                folder.rmdir()
        finally:
            os.close(lock)


def _lock(folder: Path, *, wait: bool) -> int | None:
    """Lock a folder until the descriptor is closed; None where another process has it locked, or
    folders cannot be. Raises OSError if it is none, or cannot be opened."""
    if sys.platform == "win32":
        return None
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except OSError:
        os.close(descriptor)
        return None
    return descriptor
