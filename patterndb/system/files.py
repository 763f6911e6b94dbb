"""Reading regular files alone, and writing files so that no half-written one is ever seen."""

from __future__ import annotations

import contextlib
import errno
import os
import stat
import tempfile
from collections.abc import Iterator
from io import BufferedReader
from pathlib import Path

from patterndb.errors import PatternDBError

#: What is said of pipes, sockets and devices: they could block, or never end.
IRREGULAR = "not a regular file but a pipe, socket or device; write it to a file first"

_O_BINARY: int = getattr(os, "O_BINARY", 0)  # Windows alone translates line ends without it


def open_regular(path: Path | str) -> BufferedReader:
    """Open a regular file to read its bytes; links are followed.

    Raises OSError as opening does, and for a pipe, a socket or a device.
    """
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


def make_readable(path: Path) -> None:
    """Give a file that ``mkstemp`` made, for its owner alone, the mode that ``open`` gives."""
    mask = os.umask(0)
    os.umask(mask)
    path.chmod(0o666 & ~mask)


def replace_file(path: Path, content: str | bytes) -> None:
    """Write ``content`` beside ``path`` and move it there in one step.

    A symbolic link stays one: what it leads to is replaced. Raises OSError as writing does; the
    old file, if there was one, is then still there.
    """
    path = Path(os.path.realpath(path)) if path.is_symlink() else path
    data = content.encode() if isinstance(content, str) else content
    handle, name = tempfile.mkstemp(dir=path.absolute().parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            # Else a crash of the machine could leave the new name with nothing in it.
            file.flush()
            os.fsync(file.fileno())
        make_readable(Path(name))
        Path(name).replace(path)
    except BaseException:
        with contextlib.suppress(OSError):
            Path(name).unlink()
        raise
