"""The databases that a service answers from: each opened once, and asked by many threads."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import patterndb
from patterndb.errors import NotFoundError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from patterndb.core.pattern import Pattern
    from patterndb.core.patternclass import PatternClass
    from patterndb.store import Database

T = TypeVar("T")

#: How the starter database is called.
STARTER = "starter"


class ServedDatabase:
    """A database that threads share, by its name.

    To :func:`query.fills` it is a source of patterns like any other.
    """

    def __init__(self, name: str, path: Path | None) -> None:
        """Open it for reading; path: None for the starter database."""
        self.name = name
        self.path = path
        self._database = patterndb.open(path)
        # Questions wait for each other: those that take seconds have a connection of their own.
        self._apart = patterndb.open(path)

    def close(self) -> None:
        """Close the file."""
        self._database.close()
        self._apart.close()

    def ask(self, question: Callable[[Database], T]) -> T:
        """Ask it something that is answered in milliseconds."""
        return question(self._database)

    def ask_slowly(self, question: Callable[[Database], T]) -> T:
        """Ask it something that takes seconds, which nobody else who asks shall wait for."""
        return question(self._apart)

    def pattern_class(self, n_sides: int) -> PatternClass:
        """All patterns of ``n_sides`` sides, in default order."""
        return self._database.pattern_class(n_sides)

    def pattern(self, name: str) -> Pattern:
        """The pattern whose name begins so; NotFoundError if not exactly one."""
        return self._database.pattern(name)

    def sides_histogram(self) -> dict[int, int]:
        """The number of patterns by number of sides."""
        return self._database.sides_histogram()

    def frequencies(self, ids: NDArray[np.int64]) -> NDArray[np.int64]:
        """(k,) int64 patches that reduce to the patterns of these ids (k,)."""
        return self._database.frequencies(ids)

    def pattern_ids(
        self,
        n_sides: int | None,
        meshes: Sequence[str] | None = None,
        licences: Sequence[str] | None = None,
    ) -> NDArray[np.int64]:
        """As :meth:`patterndb.store.Database.pattern_ids`."""
        return self._database.pattern_ids(n_sides, meshes, licences)


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
            self._databases[name] = ServedDatabase(name, path)

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
                list(fills(database, sides, limit=2))


#: Boundaries whose fills are asked for at the start: the numbers of sides that people draw.
WARMING = ((2, 2, 2, 2), (2, 2, 2, 2, 2), (2, 2, 2), (2, 2, 2, 2, 2, 2), (2, 2))
