"""Patterns from and for the program of the paper's authors: a table in an SQLite file.

The layout, and which points of it are interpretation, stand in docs/database.md. A file from
elsewhere is not trusted: every row is checked by itself, and one that is wrong is left out
with the reason, for the others are none the worse for it.
"""

from __future__ import annotations

import contextlib
import hashlib
import sqlite3
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

import numpy as np

from patterndb._native.store.ddqkey import smallest_key, survey
from patterndb.core.code import Code, canonical_code
from patterndb.core.packing import pack
from patterndb.core.reduction import reduce_disk
from patterndb.core.shortcode import restore
from patterndb.errors import DatabaseError, NotFoundError
from patterndb.store import ddqkey
from patterndb.store.connection import APPLICATION_ID, atomic, explained
from patterndb.store.records import Learned
from patterndb.system.files import open_regular, write_beside

TABLE = "Patches"
NUMBERS = ("nSingularities", "nCorners", "nFaces", "nVertices", "nOccurrences", "nConcaveCorners")
COLUMNS = ("topology", "boundaryIDs", "singularities", *NUMBERS)

#: No value of a row may have more bytes; a key of 16,383 faces, the most that a code of ours
#: can name, has 786,384 in the authors' width.
MAX_VALUE_BYTES = 1 << 20
#: Patches of one row. Sums over millions of rows stay far below 2**63.
MOST_OCCURRENCES = 1 << 40
#: Refused rows that are told one by one; the number of all is told as well.
TOLD = 100
#: Characters of a key that a message shows.
SHOWN = 40
#: Rows between two reports of progress.
STEP = 2000

#: What to call with rows done and rows in all.
Progress = Callable[[int, int], None]

_CREATE = """
CREATE TABLE Patches (
    topology        TEXT PRIMARY KEY,
    boundaryIDs     TEXT NOT NULL,
    singularities   TEXT NOT NULL,
    nSingularities  INTEGER CHECK (nSingularities >= 0),
    nCorners        INTEGER CHECK (nCorners >= 0),
    nFaces          INTEGER CHECK (nFaces > 0),
    nVertices       INTEGER CHECK (nVertices > 0),
    nOccurrences    INTEGER CHECK (nOccurrences > 0),
    nConcaveCorners INTEGER CHECK (nConcaveCorners >= 0)
);
"""
# The authors' program names this index in its queries.
_INDEX = """
CREATE INDEX Patches_index ON Patches (
    nCorners ASC, nSingularities ASC, singularities ASC, nOccurrences DESC, nFaces ASC
)
"""
_INSERT = "INSERT INTO Patches VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)"
_SELECT = f"SELECT {', '.join(COLUMNS)} FROM {TABLE} WHERE rowid = ?"  # noqa: S608


@dataclass(frozen=True, slots=True)
class RefusedRow:
    """A row that was left out: its rowid, the first characters of its key, and why."""

    rowid: int
    key: str
    reason: str


@dataclass(frozen=True, slots=True, eq=False)
class PatchTable:
    """What a file holds.

    sha256: of its bytes. rows: in all; refused: of these left out; told: the first of them.
    unlike: rows taken whose nSingularities is not the number of irregular vertices.
    learned: the patterns, reduced and merged, with their occurrences.
    """

    name: str
    sha256: str
    rows: int
    refused: int
    told: list[RefusedRow]
    unlike: int
    learned: Learned


@dataclass(frozen=True, slots=True)
class Exported:
    """What was written: patterns, rows (two of a pattern whose mirror image occurs as well),
    and the sum of their occurrences."""

    patterns: int
    rows: int
    occurrences: int


class _Text(bytes):
    """A TEXT value before anyone knows whether it is UTF-8; a BLOB comes as plain bytes."""


# Reading


def file_hash(path: Path) -> str:
    """SHA-256 of the file's bytes, hexadecimal, by which the database knows it."""
    with open_regular(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def read_table(path: Path | str, progress: Progress | None = None) -> PatchTable:
    """Read, check and reduce the patches of a file in the authors' layout.

    Raises DatabaseError if it is no such file or none of its rows can be used, NotFoundError
    if it has no rows, OSError as reading files does.
    """
    path = Path(path)
    with _opened(path) as connection:
        sha256 = file_hash(path)
        _check_layout(connection, path)
        total = connection.execute(f"SELECT count(*) FROM {TABLE}").fetchone()[0]  # noqa: S608
        if total == 0:
            raise NotFoundError(f"{path} has no row in its table {TABLE}: nothing to import")
        counts: dict[bytes, list[int]] = {}
        refused = unlike = 0
        told: list[RefusedRow] = []
        rowids = connection.execute(f"SELECT rowid FROM {TABLE} ORDER BY rowid")  # noqa: S608
        for done, (rowid,) in enumerate(rowids):
            if progress is not None and done % STEP == 0:
                progress(done, total)
            key = ""
            try:
                # One at a time: a row that cannot be read must not end the reading.
                values = connection.execute(_SELECT, (rowid,)).fetchone()
                key = _shown(values[0])
                code, sides, mirrored, number, alike = _pattern_of(values)
            except (sqlite3.Error, ValueError) as error:
                refused += 1
                if len(told) < TOLD:
                    told.append(RefusedRow(rowid, key, _reason(error)))
                continue
            unlike += not alike
            counts.setdefault(code, [sides, 0, 0])[1 + mirrored] += number
        if progress is not None:
            progress(total, total)
        if file_hash(path) != sha256:
            raise DatabaseError(f"{path} changed while it was being read; import it again")
    if not counts:
        raise DatabaseError(
            f"{path}: none of its {total} rows can be used; row {told[0].rowid}: {told[0].reason}"
        )
    table = np.array(list(counts.values()), np.int64)
    learned = Learned(
        *(0, 0, 0, 0, 0),
        distinct=int(table[:, 1:].sum()),
        codes=list(counts),
        sides=table[:, 0].astype(np.int32),
        patches=table[:, 1:].copy(),
        examples=[b""] * len(counts),
        origin="imported",
    )
    return PatchTable(path.name, sha256, total, refused, told, unlike, learned)


@contextlib.contextmanager
def _opened(path: Path) -> Generator[sqlite3.Connection]:
    """The file, read as it stands: nothing is made beside it, no lock is taken."""
    if path.is_dir():
        raise DatabaseError(f"{path} is a directory; name the SQLite file in it")
    with open_regular(path) as file:  # says what is wrong better than SQLite does
        empty = not file.read(1)
    if empty:
        raise DatabaseError(f"{path} is empty: it is no SQLite file")
    for suffix in ("-wal", "-journal"):
        beside = path.with_name(path.name + suffix)
        if beside.exists() and beside.stat().st_size:
            raise DatabaseError(
                f"{path} is open in another program, or was not closed ({beside.name} is beside "
                "it); close it there, or open it once with 'sqlite3'"
            )
    with explained(path):
        connection = sqlite3.connect(
            f"file:{quote(str(path.absolute()))}?mode=ro&immutable=1", uri=True
        )
        try:
            connection.text_factory = _Text
            connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MAX_VALUE_BYTES)
            connection.execute("PRAGMA trusted_schema = OFF")
            connection.execute("PRAGMA cell_size_check = ON")
            yield connection
        finally:
            connection.close()


def _check_layout(connection: sqlite3.Connection, path: Path) -> None:
    """Is there a table with the columns? Raises DatabaseError."""
    if connection.execute("PRAGMA application_id").fetchone()[0] == APPLICATION_ID:
        raise DatabaseError(
            f"{path} is a pattern database itself; 'patterndb merge {path} --db OUT.db' adds it"
        )
    row = connection.execute(
        "SELECT type, rootpage FROM sqlite_schema WHERE name = ? COLLATE NOCASE", (TABLE,)
    ).fetchone()
    if row is None:
        raise DatabaseError(f"{path} has no table {TABLE}: it is in another layout")
    if row[0] != b"table" or not row[1]:
        raise DatabaseError(f"{path}: {TABLE} is no ordinary table")
    there = {
        row[0].decode(errors="replace").lower()
        for row in connection.execute("SELECT name FROM pragma_table_info(?)", (TABLE,))
    }
    missing = [name for name in COLUMNS if name.lower() not in there]
    if there & {"rowid", "_rowid_", "oid"}:
        raise DatabaseError(f"{path}: the table {TABLE} has a column in place of its rowid")
    if missing:
        raise DatabaseError(f"{path}: the table {TABLE} lacks the column {', '.join(missing)}")
    try:
        connection.execute(f"SELECT rowid FROM {TABLE} LIMIT 1").fetchone()  # noqa: S608
    except sqlite3.OperationalError as error:
        raise DatabaseError(
            f"{path}: the table {TABLE} has no rowid ({error}); copy it into one that has"
        ) from error


def _pattern_of(values: tuple[object, ...]) -> tuple[bytes, int, bool, int, bool]:
    """The packed code, sides, whether mirrored, and occurrences that a row tells, and whether
    its nSingularities is right. Raises ValueError with the reason."""
    row = dict(zip(COLUMNS, values, strict=True))
    topology = row["topology"]
    if not isinstance(topology, _Text):
        raise ValueError(f"topology is {_kind(topology)}, not text")
    numbers: dict[str, int] = {}
    for name in NUMBERS:
        value = row[name]
        if not isinstance(value, int):
            raise ValueError(f"{name} is {_kind(value)}, not a whole number")
        numbers[name] = value
    number = numbers["nOccurrences"]
    if not 1 <= number <= MOST_OCCURRENCES:
        raise ValueError(f"nOccurrences is {number}, not 1..{MOST_OCCURRENCES}")
    twin = ddqkey.patch_of_key(topology.decode(), numbers["nFaces"])
    _, corner, valences, n_vertices, n_concave = survey(twin)
    n_corners = int(corner.sum())
    for name, found in (
        ("nVertices", n_vertices),
        ("nCorners", n_corners),
        ("nConcaveCorners", n_concave),
    ):
        if numbers[name] != found:
            raise ValueError(f"{name} is {numbers[name]}, but topology has {found}")
    code, mirrored, _, _ = canonical_code(reduce_disk(twin))
    alike = numbers["nSingularities"] == len(valences)
    return pack(code), n_corners, mirrored, number, alike


def _kind(value: object) -> str:
    if value is None:
        return "NULL"
    if isinstance(value, _Text):
        return "text"
    return "a BLOB" if isinstance(value, bytes) else "a number"


def _shown(value: object) -> str:
    text = value.decode(errors="replace") if isinstance(value, bytes) else str(value)
    return text if len(text) <= SHOWN else text[: SHOWN - 1] + "…"


def _reason(error: Exception) -> str:
    if isinstance(error, UnicodeDecodeError):
        return f"topology is not UTF-8 (byte {error.start})"
    if isinstance(error, sqlite3.Error):
        if "too big" in str(error):
            return f"a value has more than {MAX_VALUE_BYTES} bytes"
        return f"SQLite: {error}"
    return str(error)


# Writing


def write_table(
    connection: sqlite3.Connection,
    path: Path,
    digits: int | None = None,
    progress: Progress | None = None,
) -> Exported:
    """Write the patterns of a database that occur in meshes to a new file at ``path``.

    digits: hexadecimal digits of every face in a key; the fewest that each row needs if None.
    Raises DatabaseError if there is a file at ``path`` or the digits are too few, NotFoundError
    if there are no patterns; then nothing is left at ``path``.
    """
    if path.exists():
        raise DatabaseError(f"there is {path} already; name another file, or remove that one")
    if not path.absolute().parent.is_dir():
        raise DatabaseError(f"there is no folder {path.parent} to make {path.name} in")
    total, largest = connection.execute(
        "SELECT count(*), max(n_quads) FROM pattern "
        "WHERE EXISTS (SELECT 1 FROM occurrence WHERE pattern_id = id)"
    ).fetchone()
    if total == 0:
        raise NotFoundError("the database has no pattern that occurs in a mesh")
    fewest = ddqkey.fewest_digits(largest)
    if digits is not None and not fewest <= digits <= ddqkey.AUTHORS_DIGITS:
        raise DatabaseError(
            f"{digits} digits do not do: the largest pattern has {largest} faces; give "
            f"{fewest}..{ddqkey.AUTHORS_DIGITS}"
        )
    with write_beside(path) as fresh:
        return _write(connection, fresh, total, digits, progress)


def _write(
    connection: sqlite3.Connection,
    path: Path,
    total: int,
    digits: int | None,
    progress: Progress | None,
) -> Exported:
    rows = occurrences = 0
    with contextlib.closing(sqlite3.connect(path, isolation_level=None)) as out:
        with explained(path):
            # Nothing is lost if this is cut short: the file is thrown away then.
            out.execute("PRAGMA synchronous = OFF")
            out.execute("PRAGMA journal_mode = MEMORY")
        with atomic(out):
            out.execute(_CREATE)
            for done, (short, own, mirrored) in enumerate(_read_counts(connection)):
                if progress is not None and done % STEP == 0:
                    progress(done, total)
                code, _ = restore([short])
                for number, clockwise in ((own, False), (mirrored, True)):
                    if number:
                        out.execute(_INSERT, _row(code, clockwise, number, digits))
                        rows += 1
                        occurrences += number
            out.execute(_INDEX)
    if progress is not None:
        progress(total, total)
    return Exported(total, rows, occurrences)


def _read_counts(connection: sqlite3.Connection) -> Iterator[tuple[bytes, int, int]]:
    """Read every pattern's code, with the occurrences of its own hand and of the other."""
    # Named here: what is wrong with the database is not to be said of the file that is written.
    with explained(Path(connection.execute("PRAGMA database_list").fetchone()[2])):
        yield from connection.execute(
            "SELECT code, sum(patches - mirrored_patches), sum(mirrored_patches) "
            "FROM pattern JOIN occurrence ON pattern_id = id GROUP BY id ORDER BY id"
        )


def _row(code: Code, clockwise: bool, number: int, digits: int | None) -> tuple[str | int, ...]:
    """The row of a pattern, or of its mirror image, that occurs so often."""
    faces, twin = smallest_key(code, clockwise)
    columns = ddqkey.columns_of(twin)
    return (
        ddqkey.key_text(faces, digits),
        columns.boundary_ids,
        columns.singularities,
        columns.n_singularities,
        columns.n_corners,
        len(code) // 4,
        columns.n_vertices,
        number,
        columns.n_concave,
    )
