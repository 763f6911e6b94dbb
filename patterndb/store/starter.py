"""The starter database: learned from CC0 and public-domain meshes, shipped in compact form.

What a query asks is read from the compact file in the package (:mod:`patterndb.store.compact`), a
block a class. An SQLite file is made of it in the user's cache folder when something else is asked:
statistics, the content hash, a merge, SQL. That copy is opened as immutable, and its name tells the
content, so a newer package brings a new one.
"""

from __future__ import annotations

import contextlib
import hashlib
import sqlite3
from collections.abc import Callable, Collection, Generator, Sequence
from functools import cached_property
from importlib.resources import files
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from patterndb.core.code import MAX_CLASS, pattern_id
from patterndb.core.pattern import Pattern
from patterndb.core.patternclass import PatternClass
from patterndb.errors import DatabaseError
from patterndb.store import compact, reading
from patterndb.store.classes import parse_class, parse_codes
from patterndb.store.connection import Mode, connect, read_schema
from patterndb.store.database import Database
from patterndb.store.records import Mesh
from patterndb.system.caches import cache_folders, is_trusted, make_trusted
from patterndb.system.deadline import refuse_if_late
from patterndb.system.files import replace_file, write_beside

PACKED_NAME = "starter.compact"

#: Bytes that hold the head of the file.
_HEAD = 65536


class StarterDatabase(Database):
    """The starter database, as any other that is open for reading.

    Classes, frequencies, names of patterns and the choice of meshes come out of the package;
    whatever else is asked makes the SQLite file, if it is not there yet.
    """

    def __init__(
        self,
        say: Callable[[str], None] | None = None,
        progress: compact.Progress | None = None,
    ) -> None:
        """Open it; ``say`` and ``progress`` are told while the SQLite file is made, which takes
        seconds. Raises DatabaseError if the package was built without one, or it is damaged."""
        packed = files("patterndb") / "data" / PACKED_NAME
        if not packed.is_file():
            raise DatabaseError(
                "this installation has no starter database; give --db FILE, or reinstall patterndb"
            )
        self.path = Path(str(packed))
        self.mode: Mode = "read"
        self._packed = packed
        self._say = say
        self._progress = progress
        self._ids: dict[int, NDArray[np.int64]] = {}
        self._immutable = True
        self._begin_sharing()
        with packed.open("rb") as file:
            self._head = compact.parse_head(file.read(_HEAD))

    @cached_property
    def _connection(self) -> sqlite3.Connection:  # pyright: ignore[reportIncompatibleVariableOverride]
        """The SQLite file, made if need be: the methods of Database that ask it find it here."""
        self.path = unpack_starter(self._packed.read_bytes(), self._say, self._progress)
        return connect(self.path, immutable=True)

    def close(self) -> None:
        """Close the file; the object is of no use afterwards."""
        if "_connection" in self.__dict__:
            self._connection.close()

    def __enter__(self) -> StarterDatabase:
        return self

    # Asking

    def sides_histogram(self) -> dict[int, int]:
        """Number of patterns by number of sides."""
        return {n_sides: count for n_sides, (count, _, _) in self._head.classes.items()}

    def sides(self) -> list[int]:
        """Numbers of sides of which there are patterns, ascending."""
        return list(self._head.classes)

    def meshes(self) -> list[Mesh]:
        """All meshes, by name."""
        held = map(self._meshes.make_mesh, range(len(self._meshes.rows)))
        return sorted(held, key=lambda mesh: (mesh.name, mesh.sha256))

    def pattern(self, name: str) -> Pattern:
        """The pattern whose name begins with ``name``; NotFoundError if not exactly one."""
        return reading.find_in_classes(name, self._head.classes, self.pattern_class)

    def pattern_class(self, n_sides: int) -> PatternClass:
        """All patterns of ``n_sides`` sides, in default order."""
        with self._lock:
            if n_sides not in self._classes:
                if n_sides in self._head.classes:
                    patterns = parse_class(n_sides, self._read(*self._head.classes[n_sides][1:]))
                else:
                    patterns = PatternClass.from_patterns(n_sides, [])
                self._classes[n_sides] = patterns
            return self._classes[n_sides]

    def frequencies(self, ids: NDArray[np.int64]) -> NDArray[np.int64]:
        """(k,) int64 patches that reduce to the patterns of these ids (k,); 0 for unknown ones."""
        result = np.zeros(len(ids), np.int64)
        for top in np.unique(ids >> 56).tolist():
            for n_sides in self._head.classes:
                if min(n_sides, MAX_CLASS) == top:
                    refuse_if_late("the patterns were read")
                    patterns = self.pattern_class(n_sides)
                    order = np.argsort(patterns.ids)
                    held = patterns.ids[order]
                    at = np.minimum(np.searchsorted(held, ids), len(held) - 1)
                    here = held[at] == ids
                    result[here] = patterns.frequency[order][at[here]]
        return result

    def pattern_ids(
        self,
        n_sides: int | None,
        meshes: Sequence[str] | None = None,
        licences: Sequence[str] | None = None,
    ) -> NDArray[np.int64]:
        """As :meth:`Database.pattern_ids`."""
        every = self._numbered_ids if n_sides is None else self._class_ids(n_sides)
        if meshes is None and licences is None:
            return np.sort(every)
        chosen = reading.choose_meshes(self.known_meshes(), meshes, licences)
        before = 0 if n_sides is None else self._count_before(n_sides)
        places = np.unique(self._meshes.place[np.isin(self._meshes.owner, list(chosen))]) - before
        return np.sort(every[places[(places >= 0) & (places < len(every))]])

    def known_meshes(self) -> list[reading.KnownMesh]:
        """What every mesh can be chosen by: name, hash and licence."""
        return [
            reading.KnownMesh(k, row["name"], bytes.fromhex(row["sha256"]), row["licence"])
            for k, row in enumerate(self._meshes.rows)
        ]

    def count_in_meshes(
        self, ids: NDArray[np.int64], hashes: Collection[str]
    ) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
        """As :meth:`Database.count_in_meshes`."""
        # One more than there are, which is never met, stands for those that are unknown.
        every = np.append(self._numbered_ids, -1)
        is_chosen = np.array([row["sha256"] in hashes for row in self._meshes.rows], np.bool_)
        here = is_chosen[self._meshes.owner]
        places = self._meshes.place[here]
        patches = np.zeros(len(every), np.int64)
        np.add.at(patches, places, self._meshes.patches[here])
        n_meshes = np.bincount(places, minlength=len(every)).astype(np.int32)
        order = np.argsort(every)
        at = order[np.minimum(np.searchsorted(every, ids, sorter=order), len(every) - 1)]
        at = np.where(every[at] == ids, at, -1)
        return patches[at], n_meshes[at]

    def count_by_mesh(self, number: int) -> dict[str, int]:
        """As :meth:`Database.count_by_mesh`."""
        place = self._find_place(number)
        at = np.flatnonzero(self._meshes.place == (-1 if place is None else place))
        patches: list[int] = self._meshes.patches[at].tolist()
        owners: list[int] = self._meshes.owner[at].tolist()
        names = [str(self._meshes.rows[k]["name"]) for k in owners]
        return reading.sum_by_name(list(zip(patches, names, strict=True)))

    def uses(self) -> dict[int, int]:
        """How often fills were accepted: never, for nothing is recorded in the starter."""
        return {}

    def _refuse_unsound(self) -> None:
        """Refuse nothing: the whole file was compared with its hash as it was unpacked or found."""

    @contextlib.contextmanager
    def _change(self) -> Generator[sqlite3.Connection]:
        # The message names the file that can be copied: it shall be there.
        assert self._connection
        with super()._change() as connection:
            yield connection

    @cached_property
    def _meshes(self) -> compact.CompactMeshes:
        return compact.parse_meshes(self._read(*self._head.meshes))

    def _find_place(self, number: int) -> int | None:
        """By what number meshes name the pattern of an id; None for an unknown one."""
        for n_sides in self._head.classes:
            if min(n_sides, MAX_CLASS) == number >> 56:
                at = np.flatnonzero(self._class_ids(n_sides) == number)
                if len(at):
                    return self._count_before(n_sides) + int(at[0])
        return None

    def _count_before(self, n_sides: int) -> int:
        """Patterns of fewer sides: they are numbered class by class."""
        return sum(count for n, (count, _, _) in self._head.classes.items() if n < n_sides)

    @cached_property
    def _numbered_ids(self) -> NDArray[np.int64]:
        """(p,) ids of all patterns, in the order in which they are numbered."""
        found = [self._class_ids(n) for n in self._head.classes]
        return np.concatenate([np.zeros(0, np.int64), *found])

    def _class_ids(self, n_sides: int) -> NDArray[np.int64]:
        """(p,) ids of the patterns of a class, in the order in which they are numbered."""
        if n_sides not in self._ids:
            codes: list[bytes] = []
            if n_sides in self._head.classes:
                codes = parse_codes(self._read(*self._head.classes[n_sides][1:]))
            self._ids[n_sides] = np.array([pattern_id(code, n_sides) for code in codes], np.int64)
        return self._ids[n_sides]

    def _read(self, begin: int, end: int) -> bytes:
        with self._packed.open("rb") as file:
            file.seek(begin)
            return file.read(end - begin)


def unpack_starter(
    data: bytes,
    say: Callable[[str], None] | None = None,
    progress: compact.Progress | None = None,
) -> Path:
    """The SQLite file of a compact one, in the user's cache folder, made where it is not there or
    not as it was made: beside it stands its hash.

    ``say`` and ``progress`` are told before and while it is made. Raises DatabaseError if the data
    is damaged, or if there is no folder to make it in.
    """
    digest = hashlib.sha256(read_schema().encode() + data).hexdigest()
    name = f"starter-{digest[:16]}.db"
    folders = cache_folders()
    failure: Exception | None = None
    for folder in folders:
        if is_trusted(folder) and _is_whole(folder / name):
            return folder / name
    for folder in folders:
        if not make_trusted(folder):
            continue
        try:
            # Another process may be first; its file is the same.
            with write_beside(folder / name) as fresh:
                if say is not None:
                    say(f"unpacking the starter database into {folder} (once)")
                compact.load(data, fresh, progress)
                content = _hash_file(fresh)
            replace_file(_hash_beside(folder / name), content)
        except (OSError, DatabaseError) as error:
            # No space left, say: the next folder may be on another disk.
            failure = error
            continue
        return folder / name
    reason = "" if failure is None else f" ({failure})"
    raise DatabaseError(
        f"no folder to unpack the starter database into{reason}; set PATTERNDB_CACHE to one "
        "of your own that can be written, with 100 MB to spare"
    )


def _hash_beside(path: Path) -> Path:
    return path.with_suffix(".sha256")


def _hash_file(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _is_whole(path: Path) -> bool:
    """Is a file there, with the hash that was written as it was made?"""
    try:
        return _hash_beside(path).read_text(encoding="ascii") == _hash_file(path)
    except (OSError, UnicodeDecodeError):
        return False
