"""patterndb: a database of the patterns in hand-made quad meshes.

import patterndb, ingest, query

with patterndb.open("my.db", "create") as db:
    ingest.ingest(db, ["head.obj", "hand.obj"])
    for fill in query.fills(db, query.Boundary((3, 5, 4, 6))):
        ...
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from patterndb.errors import PatternDBError

if TYPE_CHECKING:
    from patterndb.store import Database, LearningOptions, Provenance
    from patterndb.store.connection import Mode

__version__ = "0.1.0"

__all__ = ["Database", "LearningOptions", "PatternDBError", "Provenance", "open"]


def __getattr__(name: str) -> Any:
    # The store imports compiled kernels; --help and reading a mesh must not wait for them.
    if name not in ("Database", "LearningOptions", "Provenance"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module("patterndb.store"), name)


def open(
    path: Path | str | None = None,
    mode: Mode = "read",
    *,
    say: Callable[[str], None] | None = None,
) -> Database:
    """Open a pattern database; without a path, the starter database that comes along.

    mode: "read", "write" (it must exist) or "create" (made if it does not). The starter
    database can only be read, and is unpacked by its first use, which takes some time;
    ``say`` is told so. Raises DatabaseError, saying what would mend it.

    Example: ``patterndb.open().statistics().patterns``
    """
    from patterndb.store import Database

    if path is not None:
        return Database(path, mode)
    if mode != "read":
        raise ValueError("the starter database is never written to; give a path of your own")
    from patterndb.store.starter import starter_path

    return Database(starter_path(say), immutable=True)
