"""Several databases asked as one: their patterns together, frequencies added with a weight each.

Nothing is copied: classes are united in memory when they are asked for, of what each database
gives, and again where one of them gives another class since. A mesh that several hold counts once,
as the first of them learned it, so that a union with weights of 1 lists what the first would with
the others merged into it.
"""

from __future__ import annotations

import math
import os
import threading
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

from patterndb.core.classunion import ClassShare, unite_classes, weigh_patches
from patterndb.core.code import Code
from patterndb.core.pattern import Pattern
from patterndb.core.patternclass import PatternClass
from patterndb.errors import DatabaseError, InvalidCodeError
from patterndb.store import reading
from patterndb.store.connection import Mode
from patterndb.store.database import Database
from patterndb.store.records import Mesh
from patterndb.store.starter import StarterDatabase
from patterndb.verbs import QueryVerbs


@dataclass(frozen=True, slots=True)
class UnionMember:
    """A database of a union.

    name: as its user named it. weight: what its frequencies count.
    """

    database: Database
    name: str
    weight: float = 1.0


@dataclass(frozen=True, slots=True)
class MemberOccurrence:
    """A database that holds a pattern.

    patches: in which this database saw it. meshes: names of its meshes that have it, the one with
    the most patches first; none where it is there for its uses alone. A mesh that an earlier
    database of the union holds too is told here as well, though it counts there.
    """

    database: str
    weight: float
    patches: int
    meshes: tuple[str, ...]

    def to_json(self) -> dict[str, object]:
        """The holder as JSON takes it."""
        return {
            "database": self.database,
            "weight": self.weight,
            "patches": self.patches,
            "meshes": list(self.meshes),
        }


class DatabaseUnion(QueryVerbs):
    """Several open databases that are asked as one; a context manager that closes them.

    Threads may share it, as they may a :class:`patterndb.store.database.Database`.
    """

    def __init__(self, members: Sequence[UnionMember]) -> None:
        """Unite the databases, which the union closes.

        Raises ValueError for none, or a weight that is not above 0, DatabaseError for two that
        are one file.
        """
        if not members:
            raise ValueError("a union needs at least one database")
        for member in members:
            if not (math.isfinite(member.weight) and member.weight > 0):
                raise ValueError(
                    f"the weight of {member.name} is {member.weight:g}; give a number above 0"
                )
        paths = [member.database.path.resolve() for member in members]
        for member, path in zip(members, paths, strict=True):
            if paths.count(path) > 1:
                raise DatabaseError(f"{member.name} is given twice; give it once, with a weight")
        self.members = tuple(members)
        self._lock = threading.RLock()
        # With the classes that each was made of: a database that has changed gives another.
        self._classes: dict[int, tuple[list[PatternClass], PatternClass]] = {}

    def __enter__(self) -> DatabaseUnion:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        names = ", ".join(
            member.name if member.weight == 1 else f"{member.name}={member.weight:g}"
            for member in self.members
        )
        return f"<DatabaseUnion of {names}>"

    def close(self) -> None:
        """Close the databases; the object is of no use afterwards."""
        with ExitStack() as stack:
            for member in self.members:
                stack.callback(member.database.close)

    # Asking

    def sides_histogram(self) -> dict[int, int]:
        """Number of patterns by number of sides."""
        return {n: len(self.pattern_class(n)) for n in self.sides()}

    def sides(self) -> list[int]:
        """Numbers of sides of which there are patterns, ascending."""
        return sorted({n for member in self.members for n in member.database.sides()})

    def meshes(self) -> list[Mesh]:
        """All meshes, by name; one that several databases hold as the first has it."""
        found: dict[str, Mesh] = {}
        for member in self.members:
            for mesh in member.database.meshes():
                found.setdefault(mesh.sha256, mesh)
        return sorted(found.values(), key=lambda mesh: (mesh.name, mesh.sha256))

    def pattern(self, name: str) -> Pattern:
        """The pattern whose name begins with ``name``; NotFoundError if not exactly one."""
        return reading.find_in_classes(name, self.sides(), self.pattern_class)

    def pattern_class(self, n_sides: int) -> PatternClass:
        """All patterns of ``n_sides`` sides, in default order; frequencies are sums with weights.

        Raises DatabaseError where two databases have unlike patterns of one id.
        """
        with self._lock:
            parts = [member.database.pattern_class(n_sides) for member in self.members]
            made_of, united = self._classes.get(n_sides, ((), None))
            if united is not None and all(a is b for a, b in zip(made_of, parts, strict=True)):
                return united
            shares: list[ClassShare] = []
            shared = self._shared_hashes()
            for member, patterns, hashes in zip(self.members, parts, shared, strict=True):
                patches, n_meshes = patterns.frequency, patterns.n_meshes
                if hashes:
                    counted = member.database.count_in_meshes(patterns.ids, hashes)
                    patches, n_meshes = patches - counted[0], n_meshes - counted[1]
                shares.append(ClassShare(patterns, member.weight, patches, n_meshes))
            try:
                united = unite_classes(n_sides, shares)
            except InvalidCodeError as error:
                raise DatabaseError(
                    f"{self!r} cannot be asked together ({error}); 'patterndb verify' tells "
                    "whether one of them is damaged"
                ) from error
            self._classes[n_sides] = parts, united
            return united

    def frequencies(self, ids: NDArray[np.int64]) -> NDArray[np.int64]:
        """(k,) int64 patches that reduce to the patterns of these ids (k,), sums with weights; 0
        for unknown ones."""
        counts: list[NDArray[np.int64]] = []
        for member, hashes in zip(self.members, self._shared_hashes(), strict=True):
            patches = member.database.frequencies(ids)
            if hashes:
                patches = patches - member.database.count_in_meshes(ids, hashes)[0]
            counts.append(patches)
        return weigh_patches(counts, [member.weight for member in self.members])

    def pattern_ids(
        self,
        n_sides: int | None,
        meshes: Sequence[str] | None = None,
        licences: Sequence[str] | None = None,
    ) -> NDArray[np.int64]:
        """As :meth:`patterndb.store.database.Database.pattern_ids`, of meshes in any of them."""
        if meshes is None and licences is None:
            found = [member.database.pattern_ids(n_sides) for member in self.members]
            return np.unique(np.concatenate(found))
        known: list[reading.KnownMesh] = []
        owner: list[int] = []
        for at, (member, shared) in enumerate(
            zip(self.members, self._shared_hashes(), strict=True)
        ):
            for mesh in member.database.known_meshes():
                if mesh.sha256.hex() not in shared:
                    known.append(replace(mesh, number=len(known)))
                    owner.append(at)
        chosen = reading.choose_meshes(known, meshes, licences)
        found = [np.zeros(0, np.int64)]
        for at, member in enumerate(self.members):
            hashes = [known[k].sha256.hex() for k in sorted(chosen) if owner[k] == at]
            if hashes:
                found.append(member.database.pattern_ids(n_sides, hashes))
        return np.unique(np.concatenate(found))

    def uses(self) -> dict[int, int]:
        """How often fills were accepted, by pattern id, over all of them."""
        found: dict[int, int] = {}
        for member in self.members:
            for number, uses in member.database.uses().items():
                found[number] = found.get(number, 0) + uses
        return dict(sorted(found.items()))

    def find_occurrences(self, pattern: Pattern) -> list[MemberOccurrence]:
        """Find the databases that hold a pattern, in their order, with its meshes in each.

        None holds a pattern that a query made, as one of a family or by construction, until it is
        learned or used.
        """
        holders: list[MemberOccurrence] = []
        for member in self.members:
            counts = member.database.count_by_mesh(pattern.id)
            if counts or pattern.id in member.database.uses():
                holders.append(
                    MemberOccurrence(
                        member.name, member.weight, sum(counts.values()), tuple(counts)
                    )
                )
        return holders

    def _shared_hashes(self) -> list[set[str]]:
        """For each member the hashes of its meshes that an earlier one holds too."""
        seen: set[str] = set()
        shared: list[set[str]] = []
        for member in self.members:
            own = {mesh.sha256.hex() for mesh in member.database.known_meshes()}
            shared.append(own & seen)
            seen |= own
        return shared

    # Changing

    def find_writable(self) -> UnionMember:
        """Find the first database that is open for writing: where uses are recorded.

        Raises DatabaseError, saying what would mend it, if there is none.
        """
        for member in self.members:
            if member.database.mode != "read":
                return member
        raise DatabaseError(
            f"none of {', '.join(member.name for member in self.members)} is open for writing: "
            "open them with mode='write', with a database of your own among them whose file and "
            "folder you may write (the starter database is never written to)"
        )

    def record_use(self, pattern: Pattern | Code, count: int = 1) -> int:
        """Record in the first database that is open for writing that ``count`` fills of the
        pattern were accepted; return its uses there so far.

        As :meth:`patterndb.store.database.Database.record_use`; DatabaseError if none is open
        for writing.
        """
        return self.find_writable().database.record_use(pattern, count)


def open_union(
    databases: Sequence[tuple[str, Path | None, float]],
    mode: Mode = "read",
    open_starter: Callable[[], Database] = StarterDatabase,
) -> DatabaseUnion:
    """Open databases, each by name, file and weight, as one; no file is the starter database.

    mode: "read", or "write": the first whose file this user may write is opened so, the others for
    reading. Raises what opening one of them raises, and DatabaseError if none may be written.
    """
    if mode == "create":
        raise ValueError("a union is of databases that are there; open it to read or to write")
    members: list[UnionMember] = []
    is_open = mode == "read"
    with ExitStack() as stack:
        for name, path, weight in databases:
            writes = not is_open and path is not None and _is_writable(path)
            database = (
                open_starter() if path is None else Database(path, "write" if writes else "read")
            )
            is_open |= writes
            stack.callback(database.close)
            members.append(UnionMember(database, name, weight))
        union = DatabaseUnion(members)
        if not is_open:
            union.find_writable()
        # They are the union's to close now.
        stack.pop_all()
    return union


def _is_writable(path: Path) -> bool:
    """May this user write the database of this file, and the journal beside it?"""
    return os.access(path, os.W_OK) and os.access(path.absolute().parent, os.W_OK)
