"""The one way to a database file: connect(), which makes and checks it, and atomic() to change it.

``schema.sql`` is the schema and the only place where it stands. What stands in a file's schema is
run: a trigger or a view planted in a database would act whenever it is read or written. So a file
with another schema than schema.sql is rejected.
"""

from __future__ import annotations

import contextlib
import re
import sqlite3
import time
from collections.abc import Generator
from functools import cache, partial
from importlib.resources import files
from pathlib import Path
from typing import Literal
from urllib.parse import quote

from patterndb.errors import DatabaseError, TimeLimitError
from patterndb.system.deadline import is_late

APPLICATION_ID = 0x50617444
SCHEMA_VERSION = 1

Mode = Literal["read", "write", "create"]

#: What is done with the file, for the message where it is locked.
Doing = Literal["reading", "beginning", "committing"]

#: Seconds to wait for another process's write to end before giving up.
BUSY_SECONDS = 10.0
#: Page cache, KiB: a class of 60,000 patterns fits.
CACHE_KIB = 65536
#: Bytes of the largest text or blob: lists of some million ids are passed as one text.
LARGEST_VALUE = 256 << 20
#: Bytes of the longest statement; those of schema.sql have a fiftieth.
LONGEST_STATEMENT = 100_000
#: Steps of SQLite's machine between two looks at the clock and at Ctrl-C: some milliseconds.
STEPS_BETWEEN_LOOKS = 100_000
#: While SQLite reads the schema, and the statistics that ANALYZE left, it computes what a column
#: there is said to be, before anyone can look at that: bytes of the largest value, steps between
#: two looks, and seconds. Ours take some milliseconds.
LARGEST_IN_SCHEMA = 1 << 20
STEPS_IN_SCHEMA = 1000
SECONDS_FOR_SCHEMA = 5.0


def connect(
    path: Path | str, mode: Mode = "read", *, immutable: bool = False
) -> sqlite3.Connection:
    """Open the database at ``path`` with every pragma set.

    read, write: it must exist. create: as write, and made if there is no file (or an empty
    one). immutable: nobody writes to the file while it is open (a database shipped with a
    program).

    Raises DatabaseError if the file is not a pattern database, has another version of the
    schema, is damaged, or cannot be opened so.
    """
    path = Path(path)
    if re.match(r"[A-Za-z][\w+.-]+:[/\\]", str(path)) and not path.exists():
        raise DatabaseError(
            f"{path} is an address, not a file; a service is asked by --server URL, or "
            "patterndb.connect(URL)"
        )
    if path.is_dir():
        raise DatabaseError(f"{path} is a directory; name a database file in it")
    if mode != "create" and not path.exists():
        raise DatabaseError(
            f"there is no database at {path}; 'patterndb ingest MESH... --db {path}' makes one"
        )
    if path.exists() and not path.is_file():
        # Opening a pipe would wait for ever for someone to write to it.
        raise DatabaseError(f"{path} is not a file, but a pipe or a device; name a database file")
    if mode == "create" and not path.parent.exists():
        raise DatabaseError(f"there is no folder {path.parent} to make {path.name} in")
    uri = (
        f"file:{quote(str(path.absolute()))}?mode="
        + {"read": "ro", "write": "rw", "create": "rwc"}[mode]
    )
    if immutable:
        uri += "&immutable=1"
    connection = _open(uri, path)
    try:
        with explained(path):
            try:
                _prepare(connection, path, mode)
            except sqlite3.OperationalError as error:
                if not is_half_written(error):
                    raise
                roll_back(path)
                _prepare(connection, path, mode)
    except BaseException:
        connection.close()
        raise
    return connection


def connect_unchecked(path: Path) -> sqlite3.Connection:
    """Open a database for reading whatever stands in it, to recover what can be read of it.

    Bytes that are not UTF-8 are read with signs of replacement. Raises DatabaseError if there is no
    file, or it cannot be opened.
    """
    if not path.is_file():
        raise DatabaseError(f"there is no database at {path}")
    connection = _open(f"file:{quote(str(path.absolute()))}?mode=ro", path)
    try:
        # What else is wrong with it shows when it is read.
        with contextlib.suppress(sqlite3.Error, UnicodeDecodeError):
            _load_schema(connection, path)
    except BaseException:
        connection.close()
        raise
    connection.text_factory = partial(str, encoding="utf-8", errors="replace")
    return connection


def _open(uri: str, path: Path) -> sqlite3.Connection:
    with explained(path):
        connection = sqlite3.connect(
            uri,
            uri=True,
            timeout=BUSY_SECONDS,
            isolation_level=None,  # transactions are atomic()'s, none begins by itself
            check_same_thread=False,
        )
        _harden(connection)
    return connection


def is_half_written(error: sqlite3.Error) -> bool:
    """Does SQLite say that a write was broken off, which who only reads cannot take back?"""
    return getattr(error, "sqlite_errorcode", None) == sqlite3.SQLITE_READONLY_ROLLBACK


def roll_back(path: Path) -> None:
    """Take back a write that was broken off, as a kill leaves it: reading needs that first.

    Raises DatabaseError where this user may not write the file or its folder.
    """
    try:
        connection = sqlite3.connect(
            f"file:{quote(str(path.absolute()))}?mode=rw", uri=True, timeout=BUSY_SECONDS
        )
        try:
            _harden(connection)
            _load_schema(connection, path)
        finally:
            connection.close()
    except sqlite3.OperationalError as error:
        if error.sqlite_errorcode & 0xFF not in (sqlite3.SQLITE_READONLY, sqlite3.SQLITE_CANTOPEN):
            raise
        raise DatabaseError(
            f"a write to {path} was broken off, and what it left must be taken back before anyone "
            f"can read; you may not write {path.name}, {path.name}-journal or their folder. Let "
            f"someone who may read it once: 'patterndb stats --db {path}'"
        ) from error


def _harden(connection: sqlite3.Connection) -> None:
    """Believe as little of the file as SQLite can: its schema may call no functions with effects,
    pages are checked as they are read, and values and statements have limits."""
    connection.execute("PRAGMA trusted_schema = OFF")
    connection.execute("PRAGMA cell_size_check = ON")
    connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LARGEST_VALUE)
    connection.setlimit(sqlite3.SQLITE_LIMIT_SQL_LENGTH, LONGEST_STATEMENT)
    connection.setlimit(sqlite3.SQLITE_LIMIT_TRIGGER_DEPTH, 1)  # there are none
    # Python 3.12 and later.
    setconfig = getattr(connection, "setconfig", None)
    if setconfig is not None:
        setconfig(getattr(sqlite3, "SQLITE_DBCONFIG_DEFENSIVE"), True)  # noqa: B009
    # Python looks for Ctrl-C whenever it is called, so that ends a statement as well.
    connection.set_progress_handler(is_late, STEPS_BETWEEN_LOOKS)


def _load_schema(connection: sqlite3.Connection, path: Path) -> None:
    """Have SQLite read the schema, within limits of its own; later statements find it read.

    Raises DatabaseError where that does not end.
    """
    until = time.monotonic() + SECONDS_FOR_SCHEMA
    connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LARGEST_IN_SCHEMA)
    connection.set_progress_handler(lambda: is_late() or time.monotonic() > until, STEPS_IN_SCHEMA)
    try:
        connection.execute("SELECT count(*) FROM sqlite_schema").fetchone()
    except sqlite3.OperationalError as error:
        if error.sqlite_errorcode == sqlite3.SQLITE_INTERRUPT and time.monotonic() > until:
            raise DatabaseError(
                f"{path} is not a pattern database, or damaged: reading its schema takes more than "
                f"{SECONDS_FOR_SCHEMA:g} s"
            ) from error
        raise
    finally:
        connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LARGEST_VALUE)
        connection.set_progress_handler(is_late, STEPS_BETWEEN_LOOKS)


def _prepare(connection: sqlite3.Connection, path: Path, mode: Mode) -> None:
    _load_schema(connection, path)
    connection.execute("PRAGMA foreign_keys = ON")
    connection.execute("PRAGMA temp_store = MEMORY")
    connection.execute(f"PRAGMA cache_size = {-CACHE_KIB:d}")
    _check(connection, path, mode)


def _check(connection: sqlite3.Connection, path: Path, mode: Mode) -> None:
    application = connection.execute("PRAGMA application_id").fetchone()[0]
    version = connection.execute("PRAGMA user_version").fetchone()[0]
    tables = connection.execute("SELECT count(*) FROM sqlite_schema").fetchone()[0]
    if mode == "create" and application == 0 and version == 0 and tables == 0:
        try:
            # A crash on the way leaves an empty file.
            connection.executescript(f"BEGIN IMMEDIATE;\n{read_schema()}\nCOMMIT;")
        except sqlite3.OperationalError:
            # Another process may have made it since we looked.
            if connection.in_transaction:
                connection.execute("ROLLBACK")
            if connection.execute("PRAGMA application_id").fetchone()[0] != APPLICATION_ID:
                raise
        return
    if application == 0 and tables == 0:
        raise DatabaseError(
            f"{path} is empty: nothing was ever written to it; 'patterndb ingest MESH... --db "
            f"{path}' fills it"
        )
    if application != APPLICATION_ID:
        raise DatabaseError(f"{path} is an SQLite file of another kind, not a pattern database")
    if version != SCHEMA_VERSION:
        raise DatabaseError(
            f"{path} has version {version} of the schema, and this patterndb reads only version "
            f"{SCHEMA_VERSION}; learn its meshes again: 'patterndb ingest MESH... --db NEW.db'"
        )
    change = _find_schema_change(connection)
    if change is not None:
        raise DatabaseError(
            f"{path} has another schema than a pattern database: {change}. It was changed by "
            "another program, or is damaged; restore it from a copy, or learn its meshes again"
        )


def read_schema() -> str:
    """Return the text of schema.sql, from the installed package or from the checkout."""
    packaged = files("patterndb") / "schema.sql"
    if packaged.is_file():
        return packaged.read_text(encoding="utf-8")
    return (Path(__file__).parents[2] / "schema.sql").read_text(encoding="utf-8")


#: What ANALYZE makes: tables of SQLite's own, by which it plans.
_OF_SQLITE = {
    "sqlite_stat1": "CREATE TABLE sqlite_stat1(tbl,idx,stat)",
    "sqlite_stat4": "CREATE TABLE sqlite_stat4(tbl,idx,neq,nlt,ndlt,sample)",
}

_TOKEN = re.compile(r"--[^\n]*|/\*.*?\*/|'(?:[^']|'')*'|\w+|\s+|.", re.DOTALL)

#: Entries of a schema that are read: ours has a tenth, and one too many is named.
_MOST_OBJECTS = 100


def _find_schema_change(connection: sqlite3.Connection) -> str | None:
    """Find what in a file's schema is not as in schema.sql, in words; None where all is."""
    expected = _list_expected()
    found: set[str] = set()
    rows = connection.execute("SELECT type, name, tbl_name, sql FROM sqlite_schema")
    for kind, name, table, sql in rows.fetchmany(_MOST_OBJECTS):
        if any(not isinstance(x, str) for x in (kind, name, table)) or name in found:
            return "an entry of its schema is damaged"
        if kind == "table" and _OF_SQLITE.get(name) == sql:
            continue
        if name not in expected or expected[name][0] != kind:
            return f"it has a {kind} {name!r} that patterndb does not make"
        if expected[name] != (kind, table, _strip_comments(sql)):
            return f"its {kind} {name!r} is not as patterndb makes it"
        found.add(name)
    for name, (kind, _, _) in expected.items():
        if name not in found:
            return f"it lacks the {kind} {name!r}"
    return None


@cache
def _list_expected() -> dict[str, tuple[str, str, str]]:
    """Kind, table and statement of all that schema.sql makes, by name."""
    with contextlib.closing(sqlite3.connect(":memory:")) as fresh:
        fresh.executescript(read_schema())
        rows = fresh.execute("SELECT name, type, tbl_name, sql FROM sqlite_schema").fetchall()
    return {name: (kind, table, _strip_comments(sql)) for name, kind, table, sql in rows}


def _strip_comments(sql: object) -> str:
    """A statement without comments and with single spaces: those of schema.sql may change."""
    tokens = _TOKEN.findall(str(sql or ""))  # SQLite's own indices have none
    return " ".join(t for t in tokens if not t.isspace() and not t.startswith(("--", "/*")))


@contextlib.contextmanager
def atomic(connection: sqlite3.Connection) -> Generator[sqlite3.Connection]:
    """The only way to change a database: all of the block, or nothing of it.

    Takes the write lock at once, so that a second writer waits here and not half-way.
    """
    path = _path(connection)
    with explained(path, "beginning"):
        connection.execute("BEGIN IMMEDIATE")
    try:
        with explained(path):
            yield connection
        # A reader may hold this up for too long; then it is all taken back as well.
        with explained(path, "committing"):
            connection.execute("COMMIT")
    except BaseException:
        if connection.in_transaction:
            connection.execute("ROLLBACK")
        raise


@contextlib.contextmanager
def explained(path: Path, doing: Doing = "reading") -> Generator[None]:
    """Turn SQLite's errors into ours, with what would mend them.

    Raises KeyboardInterrupt where Ctrl-C ended a statement, TimeLimitError where the thread's
    deadline (:mod:`patterndb.system.deadline`) did.
    """
    try:
        yield
    except sqlite3.IntegrityError as error:
        # Nothing that is written breaks a rule of the schema, unless what stands there does.
        raise DatabaseError(
            f"{path} is damaged: it cannot be changed so ({error}); 'patterndb verify' reports "
            "what is wrong"
        ) from error
    except UnicodeDecodeError as error:
        # SQLite's message quotes the file, where that is not text.
        raise DatabaseError(
            f"{path} is damaged (its schema is not text); restore it from a copy, or learn its "
            "meshes again"
        ) from error
    except sqlite3.DatabaseError as error:
        text = str(error)
        code = getattr(error, "sqlite_errorcode", 0)
        if code == sqlite3.SQLITE_INTERRUPT:
            if is_late():
                raise TimeLimitError(
                    f"the time limit was over before {path} was read; allow more seconds"
                ) from error
            # Nothing else interrupts: what Ctrl-C raised within SQLite's call is lost there.
            raise KeyboardInterrupt from error
        if is_half_written(error):
            why = f"a write to {path} was broken off; open it again, which takes that back"
        elif "not a database" in text:
            why = f"{path} is not an SQLite file"
        elif "locked" in text or "busy" in text:
            # Readers hold up nothing but the end of a write, and only a write holds up the rest.
            why = (
                f"{path} is being read by another process, for longer than {BUSY_SECONDS:g} s: "
                "nothing was written; try again when it has finished"
                if doing == "committing"
                else f"{path} is being written by another process; try again when it has finished"
            )
        elif "readonly" in text:
            why = f"{path} cannot be written: it, or its folder, is read-only"
        elif "unable to open" in text:
            why = f"{path} cannot be opened; check that it may be read"
        elif "full" in text:
            why = f"no space left to write {path}; only what was there before is kept"
        elif "malformed" in text or "corrupt" in text:
            why = f"{path} is damaged ({text}); restore it from a copy, or learn its meshes again"
        else:
            why = f"{path}: {text}"
        raise DatabaseError(why) from error


def _path(connection: sqlite3.Connection) -> Path:
    return Path(connection.execute("PRAGMA database_list").fetchone()[2] or ":memory:")
