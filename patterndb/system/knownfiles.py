"""Files that are worked on: one that somebody else has changed meanwhile is not replaced.

Two windows, or two scripts, may work on one file. Each has its :class:`KnownFiles`, which remembers
what the file was when it was opened or saved last, by its content. Before the file is replaced it
is looked at again.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from patterndb.errors import PatternDBError
from patterndb.system.files import open_regular

#: Bytes of a digest: two contents that differ never have the same in practice.
DIGEST_BYTES = 16

T = TypeVar("T")


class FileChangedError(PatternDBError, OSError):
    """A file is not as it was when it was opened or saved last; path: which."""

    def __init__(self, path: Path) -> None:
        self.path = path
        what = "has changed" if path.exists() else "was deleted"
        super().__init__(
            f"{path} {what} since it was opened or saved here, and is not replaced: reload it, "
            "save to another file, or overwrite it"
        )


@dataclass(frozen=True, slots=True)
class RefusedSave:
    """A save that was refused. path: of the file. move: has the next one go to another file; None
    where that is named with every save."""

    path: Path
    move: Callable[[Path], object] | None = None


def digest_file(path: Path) -> bytes | None:
    """Digest what a file holds; None where there is none, or none that can be read.

    Examples
    --------
    >>> digest_file(Path("no such file")) is None
    True
    """
    try:
        with open_regular(path) as file:
            digest = hashlib.blake2b(digest_size=DIGEST_BYTES)
            while part := file.read(1 << 20):
                digest.update(part)
            return digest.digest()
    except OSError:
        return None


class KnownFiles:
    """What files were when they were opened or saved last.

    refused: the save that was refused last, until one of that file is not.

    Examples
    --------
    >>> import tempfile
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = Path(folder.name) / "work.json"
    >>> mine, theirs = KnownFiles(), KnownFiles()
    >>> mine.note(path), theirs.note(path)
    (None, None)
    >>> theirs.save(path, lambda: path.write_text("theirs"))
    6
    >>> mine.save(path, lambda: path.write_text("mine"))
    Traceback (most recent call last):
        ...
    patterndb.system.knownfiles.FileChangedError: ...
    >>> mine.save(path, lambda: path.write_text("mine"), overwrite=True)
    4
    >>> folder.cleanup()
    """

    def __init__(self) -> None:
        self._digests: dict[Path, bytes | None] = {}
        self.refused: RefusedSave | None = None

    def note(self, path: Path | str) -> None:
        """Remember a file as it is now; call this before it is read, or to accept what it is."""
        self._digests[_resolve(path)] = digest_file(Path(path))

    def note_once(self, path: Path | str) -> None:
        """Remember a file as it is now, unless it is known already."""
        if _resolve(path) not in self._digests:
            self.note(path)

    def forget(self, path: Path | str) -> None:
        """Forget a file: the next save replaces it, whatever it holds."""
        self._digests.pop(_resolve(path), None)

    def mistrust(self, path: Path | str) -> None:
        """Remember a file as another than it is: work on it began from what it was before."""
        self._digests[_resolve(path)] = b""

    def digest(self, path: Path | str) -> str:
        """The digest of a file as it is remembered, in hexadecimal digits; "" for none."""
        return (self._digests.get(_resolve(path)) or b"").hex()

    def check(self, path: Path | str) -> None:
        """Raise FileChangedError if a file that is known is not as it is remembered."""
        at = _resolve(path)
        if at in self._digests and digest_file(at) != self._digests[at]:
            raise FileChangedError(Path(path))

    def save(
        self,
        path: Path | str,
        write: Callable[[], T],
        *,
        overwrite: bool = False,
        move: Callable[[Path], object] | None = None,
    ) -> T:
        """Write a file, unless it has changed since it was noted; return what ``write`` returns.

        A file that is not known is replaced, as one that a user has just chosen to be.

        Parameters
        ----------
        path
            The file.
        write
            Writes it.
        overwrite
            Replace it, whatever it holds by now.
        move
            See :class:`RefusedSave`.

        Raises
        ------
        FileChangedError
            The file has changed; nothing is written. Read it again after :meth:`note`, save to
            another path, or give ``overwrite``.
        """
        path = Path(path)
        if not overwrite:
            try:
                self.check(path)
            except FileChangedError:
                self.refused = RefusedSave(path, move)
                raise
        made = write()
        self.note(path)
        self.refused = None
        return made


def _resolve(path: Path | str) -> Path:
    return Path(os.path.realpath(path))
