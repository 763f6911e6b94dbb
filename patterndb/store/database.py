"""A pattern database: the functions of this folder, as methods of one object."""

from __future__ import annotations

import sqlite3
import threading
from collections.abc import Callable, Collection, Generator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Concatenate, Literal, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from patterndb.core.code import Code
from patterndb.core.pattern import Pattern
from patterndb.core.patternclass import PatternClass
from patterndb.errors import DatabaseError, InvalidCodeError, NotFoundError
from patterndb.store import classes, compact, ddq, reading, verification, writing
from patterndb.store.connection import (
    Mode,
    atomic,
    connect,
    explained,
    is_half_written,
    roll_back,
)
from patterndb.store.records import (
    Learned,
    LearningOptions,
    Mesh,
    Occurrence,
    Provenance,
    Statistics,
)
from patterndb.verbs import DatabaseVerbs

Outcome = Literal["imported", "unchanged", "updated"]

P = ParamSpec("P")
T = TypeVar("T")


class Database(DatabaseVerbs):
    """An open pattern database; a context manager that closes it.

    Classes are kept in memory once loaded, until something is written: through this object, or
    by another program, which is noticed when a class is asked for.

    Threads may share it. Each question and each change waits for those of other threads; lists of
    fills, which work on classes, do not.
    """

    def __init__(self, path: Path | str, mode: Mode = "read", *, immutable: bool = False) -> None:
        """Open ``path``; see :func:`patterndb.store.connection.connect` for mode and errors."""
        self.path = Path(path)
        self.mode: Mode = mode
        self._immutable = immutable
        self._connection = connect(self.path, mode, immutable=immutable)
        self._begin_sharing()

    def _begin_sharing(self) -> None:
        """Make what threads share: the lock on the connection and what hangs on it, classes, and
        the number by which SQLite tells that others have written."""
        self._lock = threading.RLock()
        self._classes: dict[int, PatternClass] = {}
        self._seen_version = -1

    def __enter__(self) -> Database:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        try:
            patterns, meshes = sum(self.sides_histogram().values()), len(self.meshes())
        except DatabaseError:
            return f"<Database {self.path}: closed or damaged>"
        words = "1 pattern" if patterns == 1 else f"{patterns:,} patterns"
        of = "1 mesh" if meshes == 1 else f"{meshes:,} meshes"
        return f"<Database {self.path}: {words} of {of}, open to {self.mode}>"

    def close(self) -> None:
        """Close the file; the object is of no use afterwards."""
        with self._lock:
            self._connection.close()

    # Asking

    def statistics(self, *, signatures: bool = True) -> Statistics:
        """Return counts over the whole database, with its content hash.

        signatures: count signatures and ``patterns_met``, too, for which all rows are read; without
        them it takes a tenth of the time.
        """
        return self._ask(reading.read_statistics, signatures=signatures)

    def sides_histogram(self) -> dict[int, int]:
        """Number of patterns by number of sides."""
        return self._ask(reading.count_by_sides)

    def sides(self) -> list[int]:
        """Numbers of sides of which there are patterns, ascending; found without counting them."""
        return self._ask(reading.list_sides)

    def content_hash(self) -> str:
        """Hash of everything learned; equal for databases that learned the same."""
        return self._ask(reading.hash_content)

    def meshes(self) -> list[Mesh]:
        """All meshes, by name."""
        return self._ask(reading.list_meshes)

    def find_mesh(self, sha256: str) -> Mesh | None:
        """The mesh of a file with this SHA-256 (hexadecimal), or None."""
        return self._ask(reading.find_mesh, bytes.fromhex(sha256))

    def known_meshes(self) -> list[reading.KnownMesh]:
        """What every mesh can be chosen by: name, hash and licence."""
        return self._ask(reading.list_known)

    def pattern(self, name: str) -> Pattern:
        """The pattern whose name begins with ``name``; NotFoundError if not exactly one."""
        return self._ask(reading.find_pattern, name)

    def occurrences(self, pattern: Pattern) -> list[Occurrence]:
        """The meshes that hold the pattern."""
        return self._ask(reading.list_occurrences, pattern.id)

    def pattern_class(self, n_sides: int) -> PatternClass:
        """All patterns of ``n_sides`` sides, in default order.

        Loaded once, and again after another program has written to the file. A large class is
        kept in the user's cache folder (:mod:`patterndb.store.classes`), and shares its memory
        with other processes.
        """
        with self._lock:
            # Looked at before loading: a write between the two is seen the next time.
            version = self._ask(reading.read_data_version)
            if version != self._seen_version:
                self._classes.clear()
                self._seen_version = version
            if n_sides not in self._classes:
                self._classes[n_sides] = self._ask(classes.read_class, self.path, n_sides)
            return self._classes[n_sides]

    def frequencies(self, ids: NDArray[np.int64]) -> NDArray[np.int64]:
        """(k,) int64 patches that reduce to the patterns of these ids (k,); 0 for unknown ones."""
        return self._ask(reading.read_frequencies, ids)

    def count_in_meshes(
        self, ids: NDArray[np.int64], hashes: Collection[str]
    ) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
        """Count patches (k,) int64 of the patterns of these ids (k,) in the meshes of these
        SHA-256 (hexadecimal), and in how many of them (k,) int32 they occur."""
        return self._ask(reading.count_in_meshes, ids, hashes)

    def count_by_mesh(self, number: int) -> dict[str, int]:
        """Patches of the pattern of this id by name of mesh, the most first; none for an
        unknown one."""
        return self._ask(reading.count_by_mesh, number)

    def pattern_ids(
        self,
        n_sides: int | None,
        meshes: Sequence[str] | None = None,
        licences: Sequence[str] | None = None,
    ) -> NDArray[np.int64]:
        """Ids (k,) int64, ascending, of the patterns of ``n_sides`` sides (None: of any number)
        that occur in meshes of these names (or first digits of hashes) and of these licences.

        ``*`` in a licence stands for anything, and letters' case does not matter. Raises
        NotFoundError, naming what comes near, if no mesh has a name or licence. More at
        :func:`patterndb.store.reading.find_pattern_ids`.
        """
        return self._ask(reading.find_pattern_ids, n_sides, meshes, licences)

    def uses(self) -> dict[int, int]:
        """How often fills were accepted, by pattern id; those never used are left out."""
        return self._ask(reading.read_uses)

    def verify(self) -> list[str]:
        """Everything that is wrong with the database, in words."""
        with self._lock:
            return verification.verify(self._connection)

    def _refuse_unsound(self) -> None:
        """Raise DatabaseError where anything is wrong that would go into another database."""
        findings = self.verify()
        if findings:
            more = f", and {len(findings) - 1} more findings" if len(findings) > 1 else ""
            raise DatabaseError(
                f"{self.path} is damaged ({findings[0]}{more}); 'patterndb verify --db {self.path} "
                "--repair NEW' saves what is sound in it"
            )

    def export_ddq(
        self,
        path: Path | str,
        *,
        digits: int | None = None,
        progress: Callable[[int, int], None] | None = None,
    ) -> ddq.Exported:
        """Write the patterns that occur in meshes for the program of the paper's authors.

        See :func:`patterndb.store.ddq.write_table` for digits, progress and errors.
        """
        return self._ask(ddq.write_table, Path(path), digits, progress)

    def compact(self) -> bytes:
        """What was learned, as a small file (:mod:`patterndb.store.compact`)."""
        return self._ask(compact.dump)

    def _ask(
        self,
        question: Callable[Concatenate[sqlite3.Connection, P], T],
        *args: P.args,
        **kw: P.kwargs,
    ) -> T:
        """Put a question to the file; what SQLite says of a damaged one is explained."""
        with self._lock, explained(self.path):
            try:
                try:
                    return question(self._connection, *args, **kw)
                except sqlite3.OperationalError as error:
                    if not is_half_written(error):
                        raise
                    # A writer was killed while this was open.
                    roll_back(self.path)
                    return question(self._connection, *args, **kw)
            except (ValueError, IndexError, KeyError, TypeError, OverflowError) as error:
                # What stands in the file is not of its column's type or range, or is missing.
                raise DatabaseError(
                    f"{self.path} is damaged ({error}); 'patterndb verify' reports what is wrong"
                ) from error

    # Changing

    def add_mesh(
        self,
        name: str,
        sha256: str,
        provenance: Provenance,
        options: LearningOptions,
        learned: Learned,
    ) -> int:
        """Write what a mesh taught, in one step; return how many patterns are new.

        A mesh with the same bytes that was learned with other options is replaced.
        """
        digest = bytes.fromhex(sha256)
        with self._change() as connection:
            old = connection.execute("SELECT id FROM mesh WHERE sha256 = ?", (digest,)).fetchall()
            if old:
                writing.remove_meshes(connection, [row[0] for row in old])
            mesh = Mesh(
                name,
                sha256,
                provenance,
                options,
                quads_read=learned.quads_read,
                quads_used=learned.quads_used,
                basic=learned.basic,
                side=learned.side,
                convex=learned.convex,
                distinct=learned.distinct,
                patterns=len(learned.codes),
                origin=learned.origin,
                left_out=learned.left_out,
            )
            return writing.add_mesh(connection, mesh, learned)

    def import_ddq(
        self, table: ddq.PatchTable, provenance: Provenance | None = None
    ) -> tuple[Outcome, int]:
        """Write the patterns of a table of :func:`patterndb.store.ddq.read_table` in one step.

        The table is kept as one imported mesh under its file's hash: its occurrences count in
        the patterns' frequencies, and ``remove`` takes it out again. Returns what became of it
        ("imported", "unchanged", or "updated": it was there, and only what is said of where it
        comes from changed) and how many patterns are new.
        """
        given = provenance or Provenance()
        held = self.find_mesh(table.sha256)
        if held is None:
            new = self.add_mesh(
                table.name, table.sha256, given, LearningOptions.none(), table.learned
            )
            return "imported", new
        return self.complete_provenance(held, given), 0

    def complete_provenance(self, held: Mesh, given: Provenance) -> Outcome:
        """Change the provenance of a mesh to what is given, where something is; return
        "updated", or "unchanged" where nothing differs."""
        old = held.provenance
        wanted = Provenance(
            given.author or old.author, given.source or old.source, given.licence or old.licence
        )
        if wanted == old:
            return "unchanged"
        self.update_provenance(held.sha256, held.name, wanted)
        return "updated"

    def update_provenance(self, sha256: str, name: str, provenance: Provenance) -> None:
        """Change the name of a mesh and where it comes from."""
        with self._change() as connection:
            writing.update_provenance(connection, bytes.fromhex(sha256), name, provenance)

    def record_use(self, pattern: Pattern | Code, count: int = 1) -> int:
        """Record that ``count`` fills of the pattern were accepted; return its uses so far.

        pattern: a pattern, as ``fill.pattern`` is, or a canonical code. One that the database
        does not hold is written, with the origin it has (that of a code is "learned").

        Raises InvalidCodeError for a code that is not canonical or can be reduced, ValueError
        for a count below 1, DatabaseError if the database is open for reading only.
        """
        wanted = writing.check_use(pattern, count)
        with self._lock:
            held = {n: c for n, c in self._classes.items() if n != wanted.n_sides}
            with self._change() as connection:
                is_ours = reading.read_data_version(connection) == self._seen_version
                total = writing.record_use(connection, wanted, count)
            if is_ours:
                self._classes |= held  # none but its own class is another now
            return total

    def remove(self, names: Sequence[str]) -> tuple[int, int]:
        """Take meshes out, by name or by the first digits of their SHA-256.

        Returns how many meshes and how many patterns went. Raises NotFoundError, and
        changes nothing, if one of the names is unknown or stands for several meshes.
        """
        with self._change() as connection:
            ids: list[int] = []
            for name in names:
                found = reading.find_mesh_ids(connection, name)
                if not found:
                    known = {mesh.name for mesh in reading.list_known(connection)}
                    near = reading.offer_names(name, known)
                    raise NotFoundError(f"no mesh {name!r}{near}; 'patterndb meshes' lists them")
                if len(found) > 1:
                    raise NotFoundError(
                        f"{len(found)} meshes are called {name!r}; name one by its SHA-256 "
                        "('patterndb meshes --json' tells)"
                    )
                ids += found
            ids = sorted(set(ids))
            return len(ids), writing.remove_meshes(connection, ids)

    def merge(self, other: Database) -> tuple[int, int, int]:
        """Add all meshes of another database; return (added, replaced, already there).

        Raises DatabaseError where :meth:`verify` finds anything wrong with the other.
        """
        if other.path.resolve() == self.path.resolve():
            raise DatabaseError(f"{self.path} cannot be merged into itself")
        with ExitStack() as stack:
            # In one order, else two that are merged into each other wait for ever.
            for database in sorted((self, other), key=id):
                stack.enter_context(database._lock)
            other._refuse_unsound()
            connection = stack.enter_context(self._change())
            try:
                return writing.merge_database(connection, other._connection)
            except InvalidCodeError as error:
                raise DatabaseError(
                    f"{other.path} is damaged ({error}); 'patterndb verify' reports what is wrong"
                ) from error

    @contextmanager
    def _change(self) -> Generator[sqlite3.Connection]:
        if self._immutable:
            raise DatabaseError(
                f"{self.path} is shared and never written to; copy it ('patterndb merge "
                f"{self.path} --db my.db') and give the copy as --db my.db"
            )
        if self.mode == "read":
            raise DatabaseError(
                f"{self.path} is open for reading only; open it with mode='write', or give "
                "--db FILE for a database of your own"
            )
        with self._lock, atomic(self._connection) as connection:
            self._classes.clear()
            yield connection


@dataclass(frozen=True, slots=True, eq=False)
class DatabaseComparison:
    """The difference of two databases, the first and the second.

    alike:    do they answer every question alike? Their content hashes are equal then, and so are
              the patterns that they have seen, with their frequencies.
    meshes:   those that only the first, and only the second holds, by name. A mesh is known by the
              hash of its file.
    retaught: meshes of both that were learned with different options, as the first has them.
    ids:      two ascending (k,) int64 arrays of patterns' ids that only one of them holds.
    both:     how many patterns both hold.
    recounted: (k,) int64 ids of those of both that were seen in different numbers of patches.
    """

    alike: bool
    meshes: tuple[list[Mesh], list[Mesh]]
    retaught: list[Mesh]
    ids: tuple[NDArray[np.int64], NDArray[np.int64]]
    both: int
    recounted: NDArray[np.int64]


def compare_databases(first: Database, second: Database) -> DatabaseComparison:
    """Compare two databases, mesh by mesh and pattern by pattern.

    Example: ``compare_databases(patterndb.open("a.db"), patterndb.open("b.db")).alike``
    """
    of_first = {mesh.sha256: mesh for mesh in first.meshes()}
    of_second = {mesh.sha256: mesh for mesh in second.meshes()}
    ids, frequencies = _patterns_of(first)
    other_ids, other_frequencies = _patterns_of(second)
    _, here, there = np.intersect1d(ids, other_ids, assume_unique=True, return_indices=True)
    changed = frequencies[here] != other_frequencies[there]
    same_content = first.content_hash() == second.content_hash()
    return DatabaseComparison(
        # The hash is of meshes and sums that were stored: a damaged table may not agree with it.
        alike=same_content
        and np.array_equal(ids[frequencies > 0], other_ids[other_frequencies > 0])
        and not changed.any(),
        meshes=(
            [mesh for sha256, mesh in of_first.items() if sha256 not in of_second],
            [mesh for sha256, mesh in of_second.items() if sha256 not in of_first],
        ),
        retaught=[
            mesh
            for sha256, mesh in of_first.items()
            if sha256 in of_second and of_second[sha256].options != mesh.options
        ],
        ids=(
            np.setdiff1d(ids, other_ids, assume_unique=True),
            np.setdiff1d(other_ids, ids, assume_unique=True),
        ),
        both=len(here),
        recounted=ids[here][changed],
    )


def _patterns_of(database: Database) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(p,) int64 ids, ascending, and (p,) int64 frequencies of all patterns."""
    classes = [database.pattern_class(n) for n in database.sides()]
    ids = np.concatenate([np.zeros(0, np.int64), *(held.ids for held in classes)])
    seen = np.concatenate([np.zeros(0, np.int64), *(held.frequency for held in classes)])
    order = np.argsort(ids)
    return ids[order], seen[order]
