"""The databases that a service answers from: each opened once, and asked by many threads."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import patterndb
from patterndb.errors import NotFoundError

if TYPE_CHECKING:
    from patterndb.store import Database

#: How the starter database is called.
STARTER = "starter"


@dataclass(frozen=True, slots=True, eq=False)
class ServedDatabase:
    """A database that threads share, by its name.

    path: its file; None for the starter database. opened: for what is answered in milliseconds, and
    as a source of patterns. slow: for questions that take seconds, on a connection of its own, so
    that no other waits for them.
    """

    name: str
    path: Path | None
    opened: Database
    slow: Database

    @classmethod
    def open(cls, name: str, path: Path | None) -> ServedDatabase:
        """Open it for reading."""
        return cls(name, path, patterndb.open(path), patterndb.open(path))

    def close(self) -> None:
        """Close the file."""
        self.opened.close()
        self.slow.close()


class Catalogue:
    """The databases of a service by their names; the first is asked where none is named."""

    def __init__(self, paths: Sequence[Path | None]) -> None:
        """Open all of them; raises DatabaseError where one cannot be.

        A file goes by its name without the suffix, and where several have the same, by that with
        a number: meshes, meshes-2.
        """
        self._databases: dict[str, ServedDatabase] = {}
        for path in paths or (None,):
            wanted = name = STARTER if path is None else path.stem
            number = 1
            while name in self._databases:
                number += 1
                name = f"{wanted}-{number}"
            self._databases[name] = ServedDatabase.open(name, path)

    def close(self) -> None:
        """Close all files."""
        for database in self._databases.values():
            database.close()

    def __iter__(self) -> Iterator[ServedDatabase]:
        return iter(self._databases.values())

    @property
    def names(self) -> list[str]:
        """The names, the default first."""
        return list(self._databases)

    def find(self, name: str | None) -> ServedDatabase:
        """The database of a name, or the first; raises NotFoundError, naming those there are."""
        if name is None:
            return next(iter(self._databases.values()))
        found = self._databases.get(name)
        if found is None:
            raise NotFoundError(
                f"there is no database {name[:64]!r}; there is {', '.join(self._databases)}"
            )
        return found

    def warm(self, is_stopping: Callable[[], bool]) -> None:
        """Load what nearly every question needs, so that the first need not wait."""
        from query import fills

        for database in self._databases.values():
            for sides in WARMING:
                if is_stopping():
                    return
                list(fills(database.opened, sides, limit=2))


#: Boundaries whose fills are asked for at the start: the numbers of sides that people draw.
WARMING = ((2, 2, 2, 2), (2, 2, 2, 2, 2), (2, 2, 2), (2, 2, 2, 2, 2, 2), (2, 2))
