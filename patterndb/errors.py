"""Every error this project raises on purpose.

One root, :class:`PatternDBError`, so that a caller can catch all of them; each
subclass also inherits the builtin it specialises, so that a caller who has
never heard of patterndb still catches the right thing. A message says what is
wrong, where, and what would mend it.
"""

from __future__ import annotations

from pathlib import Path


class PatternDBError(Exception):
    """Root of all errors raised on purpose."""


class InvalidMeshError(PatternDBError, ValueError):
    """A mesh, or the file that should hold one, is not what it must be."""


class MeshFileError(InvalidMeshError):
    """A mesh file cannot be read as it stands.

    ``path``, ``line`` (1-based, None in a binary body) and ``token`` (the
    offending text, None where there is none) say where; the message repeats
    them for people.
    """

    def __init__(
        self,
        message: str,
        *,
        path: Path | str,
        line: int | None = None,
        token: str | None = None,
    ) -> None:
        self.path = Path(path)
        self.line = line
        self.token = token
        where = str(path) if line is None else f"{path}:{line}"
        at = "" if token is None else f" (at {_shorten(token)!r})"
        super().__init__(f"{where}: {message}{at}")


class UnsupportedFormatError(MeshFileError):
    """The file's format is unknown, or cannot hold quads."""


class InvalidCodeError(PatternDBError, ValueError):
    """A pattern code does not describe a pattern.

    ``row`` is its place among the codes that were given, from 0; None where one was.
    """

    def __init__(self, message: str, row: int | None = None) -> None:
        self.row = row
        super().__init__(message)


class InvalidBoundaryError(PatternDBError, ValueError):
    """A boundary cannot be filled with quads, or is not a boundary at all."""


class DatabaseError(PatternDBError, RuntimeError):
    """A database file cannot be used: not ours, too new, damaged, read-only or locked."""


class TimeLimitError(PatternDBError, TimeoutError):
    """A time limit was over before there was an answer, which is no sign that there is none."""


class ClusterError(PatternDBError, ConnectionError):
    """A cluster that was to learn cannot be used: unlike versions, no workers, or it was lost."""


class NotFoundError(PatternDBError, LookupError):
    """No mesh or pattern of that name, id or code in the database."""


class AddressSpaceError(PatternDBError, MemoryError):
    """The process may not use the memory that a query needs."""


class MissingExtraError(PatternDBError, ImportError):
    """An optional dependency is needed and not installed."""


def _shorten(token: str, limit: int = 60) -> str:
    return token if len(token) <= limit else token[: limit - 1] + "…"
