"""Read a database: patterns by name and source, meshes, occurrences, counts, the content hash."""

from __future__ import annotations

import difflib
import hashlib
import json
import sqlite3
from collections import Counter
from collections.abc import Callable, Collection, Generator, Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import PurePath
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from patterndb.core.code import MAX_CLASS
from patterndb.core.packing import unpack
from patterndb.core.pattern import Pattern
from patterndb.core.patternclass import PatternClass
from patterndb.core.shortcode import restore
from patterndb.errors import NotFoundError
from patterndb.store.records import (
    Mesh,
    Occurrence,
    OccurrenceRow,
    Statistics,
    check_hash,
)
from patterndb.system.progress import report_progress

T = TypeVar("T")


def get_id_range(n_sides: int) -> tuple[int, int]:
    """Smallest and largest id of the class (of all classes from MAX_CLASS on together)."""
    first = min(n_sides, MAX_CLASS) << 56
    return first, first + (1 << 56) - 1


def read_data_version(connection: sqlite3.Connection) -> int:
    """A number that changes when another connection has changed the file."""
    return connection.execute("PRAGMA data_version").fetchone()[0]


def read_frequencies(connection: sqlite3.Connection, ids: NDArray[np.int64]) -> NDArray[np.int64]:
    """(k,) int64 frequency of every pattern; 0 for those that are not there."""
    wanted = ids.tolist()
    found: dict[int, int] = dict(
        connection.execute(
            "SELECT pattern_id, sum(patches) FROM occurrence "
            "WHERE pattern_id IN (SELECT value FROM json_each(?)) GROUP BY pattern_id",
            (json.dumps(wanted),),
        )
    )
    return np.array([found.get(number, 0) for number in wanted], np.int64)


def count_in_meshes(
    connection: sqlite3.Connection, ids: NDArray[np.int64], hashes: Collection[str]
) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """How many patches of the patterns (k,) certain meshes have, and how many of these meshes.

    hashes: SHA-256 of the meshes, hexadecimal. Returns (k,) int64 and (k,) int32.
    """
    numbers = ids.tolist()
    found = {
        number: (patches, meshes)
        for number, patches, meshes in connection.execute(
            "SELECT pattern_id, sum(patches), count(*) FROM occurrence "
            "WHERE pattern_id IN (SELECT value FROM json_each(?)) AND mesh_id IN "
            "(SELECT id FROM mesh WHERE lower(hex(sha256)) IN (SELECT value FROM json_each(?))) "
            "GROUP BY pattern_id",
            (json.dumps(numbers), json.dumps(sorted(hashes))),
        )
    }
    counts = np.array([found.get(number, (0, 0)) for number in numbers], np.int64).reshape(-1, 2)
    return counts[:, 0], counts[:, 1].astype(np.int32)


def count_by_mesh(connection: sqlite3.Connection, number: int) -> dict[str, int]:
    """Patches of a pattern by name of mesh, the most first."""
    rows = connection.execute(
        "SELECT patches, name FROM occurrence JOIN mesh ON mesh.id = mesh_id WHERE pattern_id = ?",
        (number,),
    )
    return sum_by_name(rows.fetchall())


def sum_by_name(counts: Sequence[tuple[int, str]]) -> dict[str, int]:
    """Add the counts of one name; the names with the most first, then by name."""
    found: dict[str, int] = {}
    for count, name in counts:
        found[name] = found.get(name, 0) + count
    return dict(sorted(found.items(), key=lambda item: (-item[1], item[0])))


def find_pattern(connection: sqlite3.Connection, name: str) -> Pattern:
    """The pattern whose name (16 hexadecimal digits) begins with ``name``.

    Raises NotFoundError if there is none, or more than one.
    """
    rows = connection.execute(
        "SELECT code, frequency, origin FROM counted_pattern WHERE id BETWEEN ? AND ? LIMIT 2",
        parse_name(name),
    ).fetchall()
    code, frequency, origin = choose_only(rows, name)
    symbols, _ = restore([code])
    return Pattern.from_trusted_code(symbols, frequency=frequency, origin=origin)


def parse_name(name: str) -> tuple[int, int]:
    """The smallest and the largest id of patterns whose name begins so; NotFoundError for what
    begins no name."""
    text = name.strip().lower()
    if not text or len(text) > 16 or set(text) - set("0123456789abcdef"):
        raise NotFoundError(f"{name!r} is no pattern name: give 2 to 16 hexadecimal digits")
    low = int(text.ljust(16, "0"), 16)
    high = min(int(text.ljust(16, "f"), 16), 2**63 - 1)
    return min(low, 2**63 - 1), high


def choose_only(found: Sequence[T], name: str) -> T:
    """The one that was found under a name; NotFoundError if there are none or several."""
    if not found:
        raise NotFoundError(f"no pattern's name begins with {name}")
    if len(found) > 1:
        raise NotFoundError(f"more than one pattern's name begins with {name}; give more digits")
    return found[0]


def find_in_classes(
    name: str, sides: Iterable[int], pattern_class: Callable[[int], PatternClass]
) -> Pattern:
    """The pattern whose name begins with ``name``, in classes of these numbers of sides, of which
    those that cannot hold it are not asked for; NotFoundError if there are none or several."""
    low, high = parse_name(name)
    found: list[Pattern] = []
    for n_sides in sides:
        first, last = get_id_range(n_sides)
        if low <= last and first <= high:
            patterns = pattern_class(n_sides)
            rows = np.flatnonzero((patterns.ids >= low) & (patterns.ids <= high))[:2]
            found += [patterns.pattern(row) for row in rows.tolist()]
    return choose_only(found, name)


def list_occurrences(connection: sqlite3.Connection, pattern_id: int) -> list[Occurrence]:
    """The meshes that hold the pattern, the one with most patches first."""
    return [
        Occurrence(name, patches, mirrored, tuple(np.cumsum(unpack(example)).tolist()))
        for name, patches, mirrored, example in connection.execute(
            "SELECT mesh.name, patches, mirrored_patches, example FROM occurrence "
            "JOIN mesh ON mesh.id = mesh_id WHERE pattern_id = ? "
            "ORDER BY patches DESC, mesh.name, mesh.sha256",
            (pattern_id,),
        )
    ]


def select_meshes(
    connection: sqlite3.Connection, rest: str, values: Sequence[Any] = ()
) -> Generator[dict[str, Any]]:
    """Read rows of meshes, each by column, with ``patterns``, the number of their patterns.

    rest: the statement from its condition on.
    """
    cursor = connection.cursor()
    cursor.row_factory = sqlite3.Row
    cursor.execute(
        "SELECT *, (SELECT count(*) FROM occurrence WHERE mesh_id = mesh.id) AS patterns "  # noqa: S608
        f"FROM mesh {rest}",
        values,
    )
    for row in cursor:
        yield dict(row)


def list_meshes(connection: sqlite3.Connection) -> list[Mesh]:
    """All meshes, by name."""
    return [Mesh.from_columns(row) for row in select_meshes(connection, "ORDER BY name, sha256")]


def find_mesh(connection: sqlite3.Connection, sha256: bytes) -> Mesh | None:
    """The mesh of a file with this hash."""
    rows = select_meshes(connection, "WHERE sha256 = ?", (sha256,))
    return next(map(Mesh.from_columns, rows), None)


@dataclass(frozen=True, slots=True)
class KnownMesh:
    """What a mesh can be chosen by: number is its id, or its place in a compact file."""

    number: int
    name: str
    sha256: bytes
    licence: str | None


def find_mesh_ids(connection: sqlite3.Connection, name: str) -> list[int]:
    """Ids of the meshes of this name, or whose SHA-256 begins with it (8 digits and more)."""
    return choose_named(list_known(connection), name)


def choose_named(known: Sequence[KnownMesh], name: str) -> list[int]:
    """Numbers of the meshes of this name, or whose SHA-256 begins with it (8 digits and more)."""
    found = [mesh.number for mesh in known if mesh.name == name]
    if not found and len(name) >= 8:
        found = [m.number for m in known if m.sha256.hex().startswith(name.lower())]
    return found


def list_known(connection: sqlite3.Connection) -> list[KnownMesh]:
    """What every mesh can be chosen by, in the order in which they were learned."""
    rows = connection.execute("SELECT id, name, sha256, licence FROM mesh ORDER BY id")
    return [
        KnownMesh(number, name, check_hash(sha256), licence)
        for number, name, sha256, licence in rows
    ]


#: Names that a message offers where one is unknown.
OFFERED = 3

#: How alike their names must be, from 0 to 1 (difflib): "dgo" is offered "dog".
LEAST_ALIKE = 0.65


def find_pattern_ids(
    connection: sqlite3.Connection,
    n_sides: int | None,
    meshes: Sequence[str] | None = None,
    licences: Sequence[str] | None = None,
) -> NDArray[np.int64]:
    """Ids (k,) int64, ascending, of the patterns of ``n_sides`` sides (None: of any number)
    in certain meshes.

    meshes: names, or first digits (8 and more) of SHA-256 hashes; a name that several meshes
    have stands for all of them. licences: of these licences, letters' case aside; ``*``,
    ``?`` and ``[...]`` stand for others, so "cc*" takes every one that begins so. A mesh of
    which no licence is known has none of them. Where both are given, a mesh must meet both;
    without any, these are all patterns of the class, those that were only used included.

    Raises NotFoundError if no mesh has one of the names or licences; it tells which come near.
    """
    if n_sides is None:
        return _of_any_class(connection, meshes, licences)
    low, high = get_id_range(n_sides)
    if meshes is None and licences is None:
        rows = connection.execute(
            "SELECT id FROM pattern WHERE id BETWEEN ? AND ? AND n_sides = ? ORDER BY id",
            (low, high, n_sides),
        )
    else:
        chosen = choose_meshes(list_known(connection), meshes, licences)
        # The rows of one class lie together; only the last class holds several numbers of sides.
        rows = connection.execute(
            "SELECT DISTINCT pattern_id FROM occurrence WHERE pattern_id BETWEEN ? AND ? "
            "AND mesh_id IN (SELECT value FROM json_each(?)) AND (? >> 56 < ? OR "
            "(SELECT n_sides FROM pattern WHERE id = pattern_id) = ?) ORDER BY pattern_id",
            (low, high, json.dumps(sorted(chosen)), low, MAX_CLASS, n_sides),
        )
    return np.array([row[0] for row in rows.fetchall()], np.int64)


def _of_any_class(
    connection: sqlite3.Connection,
    meshes: Sequence[str] | None,
    licences: Sequence[str] | None,
) -> NDArray[np.int64]:
    if meshes is None and licences is None:
        rows = connection.execute("SELECT id FROM pattern ORDER BY id")
    else:
        rows = connection.execute(
            "SELECT DISTINCT pattern_id FROM occurrence "
            "WHERE mesh_id IN (SELECT value FROM json_each(?)) ORDER BY pattern_id",
            (json.dumps(sorted(choose_meshes(list_known(connection), meshes, licences))),),
        )
    return np.array([row[0] for row in rows.fetchall()], np.int64)


def choose_meshes(
    known: Sequence[KnownMesh],
    meshes: Sequence[str] | None,
    licences: Sequence[str] | None,
) -> set[int]:
    """Numbers of the meshes that meet both, as :func:`find_pattern_ids` says."""
    chosen = {mesh.number for mesh in known}
    if meshes is not None:
        named: set[int] = set()
        for name in meshes:
            found = choose_named(known, name)
            if not found:
                raise NotFoundError(
                    f"no mesh {name!r}{offer_names(name, {mesh.name for mesh in known})}; "
                    "'patterndb meshes' lists them"
                )
            named.update(found)
        chosen &= named
    if licences is not None:
        licensed: set[int] = set()
        for pattern in licences:
            wanted = pattern.strip().lower()
            found = [
                mesh.number
                for mesh in known
                if mesh.licence is not None
                and (mesh.licence.lower() == wanted or fnmatchcase(mesh.licence.lower(), wanted))
            ]
            if not found:
                raise NotFoundError(
                    f"no mesh has the licence {pattern!r}; there are: {_licences(known)}"
                )
            licensed.update(found)
        chosen &= licensed
    return chosen


def offer_names(name: str, known: set[str]) -> str:
    """Offer the names that come near one, as a part of a sentence; nothing where none does."""
    # Without suffixes: that two names end in .obj makes them no more alike.
    stems: dict[str, list[str]] = {}
    for one in sorted(known):
        stems.setdefault(_stem(one), []).append(one)
    wanted = _stem(name)
    near = difflib.get_close_matches(wanted, list(stems), OFFERED, LEAST_ALIKE)
    near += [one for one in stems if wanted and wanted in one and one not in near]
    if not near:
        return ""
    offered = [one for stem in near for one in stems[stem]][:OFFERED]
    return " (did you mean " + " or ".join(map(repr, offered)) + "?)"


def _stem(name: str) -> str:
    """The name in lower case, without its suffix."""
    return PurePath(name.lower()).stem


def _licences(known: Sequence[KnownMesh]) -> str:
    told = sorted({mesh.licence for mesh in known if mesh.licence})
    unknown = sum(mesh.licence is None for mesh in known)
    return ", ".join([*told, *([f"{unknown} meshes without any"] if unknown else [])]) or "none"


def read_uses(connection: sqlite3.Connection) -> dict[int, int]:
    """Uses by pattern id, of those that were used."""
    rows = connection.execute("SELECT pattern_id, uses FROM usage ORDER BY pattern_id")
    return dict(rows.fetchall())


def list_sides(connection: sqlite3.Connection) -> list[int]:
    """Numbers of sides of which there are patterns, ascending; nothing is counted."""
    rows = connection.execute(
        "WITH RECURSIVE class (sides) AS (SELECT min(n_sides) FROM pattern UNION ALL "
        "SELECT (SELECT min(n_sides) FROM pattern WHERE n_sides > sides) FROM class "
        "WHERE sides IS NOT NULL) SELECT sides FROM class WHERE sides IS NOT NULL"
    )
    return [n_sides for (n_sides,) in rows]


def count_by_sides(connection: sqlite3.Connection) -> dict[int, int]:
    """Patterns by number of sides."""
    rows = connection.execute("SELECT n_sides, count(*) FROM pattern GROUP BY 1 ORDER BY 1")
    return dict(rows.fetchall())


#: Signatures that are read at a time.
SIGNATURES_AT_ONCE = 50_000


def read_statistics(connection: sqlite3.Connection, *, signatures: bool = True) -> Statistics:
    """Count over the whole database.

    signatures: are signatures and patterns by their occurrences counted, too? All rows are read for
    that, which takes ten times as long as everything else: an index has the other counts.
    """
    by_sides: Counter[int] = Counter()
    by_irregular: Counter[int] = Counter()
    n_chiral = 0
    for n_sides, n_irregular, chiral, count in connection.execute(
        "SELECT n_sides, n_irregular, chiral, count(*) FROM pattern GROUP BY 1, 2, 3"
    ):
        by_sides[n_sides] += count
        by_irregular[n_irregular] += count
        n_chiral += count * chiral
    n_patterns = by_sides.total()
    n_signatures, n_met = _count_rows(connection, n_patterns) if signatures else (None, None)
    n_meshes, n_patches = connection.execute(
        "SELECT count(*), coalesce(sum(distinct_patches), 0) FROM mesh"
    ).fetchone()
    return Statistics(
        patterns=n_patterns,
        patterns_oriented=n_patterns + n_chiral,
        patterns_met=n_met,
        by_sides=dict(sorted(by_sides.items())),
        by_irregular=dict(sorted(by_irregular.items())),
        signatures=n_signatures,
        meshes=n_meshes,
        patches=n_patches,
        content_hash=hash_content(connection),
    )


def _count_rows(connection: sqlite3.Connection, n_patterns: int) -> tuple[int, int]:
    """Count distinct signatures, and patterns and mirror images that meshes have."""
    with report_progress("counting signatures and occurrences") as report:
        parts: list[NDArray[np.uint64]] = [np.zeros(0, np.uint64)]
        cursor = connection.execute("SELECT signature FROM pattern")
        while rows := cursor.fetchmany(SIGNATURES_AT_ONCE):
            parts.append(np.frombuffer(b"".join([row[0] for row in rows]), np.uint64))
            report(len(parts) * SIGNATURES_AT_ONCE / (2 * n_patterns))
        # numpy.unique takes fifty times as long.
        ordered = np.sort(np.concatenate(parts))
        n_signatures = min(len(ordered), 1) + int(np.count_nonzero(ordered[1:] != ordered[:-1]))
        (n_met,) = connection.execute(
            "SELECT (SELECT count(DISTINCT pattern_id) FROM occurrence "
            "WHERE patches > mirrored_patches) + (SELECT count(DISTINCT pattern_id) "
            "FROM occurrence WHERE mirrored_patches > 0)"
        ).fetchone()
    return n_signatures, n_met


def sum_occurrences(rows: Iterable[OccurrenceRow], total: int = 0) -> int:
    """Add the hashes of occurrences to a sum modulo 2**128: their order does not matter.

    The id of the mesh is not hashed, so that the same mesh, learned with the same options, has the
    same sum in every database.
    """
    for row in rows:
        word = repr((row.pattern_id, row.patches, row.mirrored_patches, row.example))
        digest = hashlib.blake2b(word.encode("utf-8", "surrogateescape"), digest_size=16).digest()
        total += int.from_bytes(digest, "big")
    return total % (1 << 128)


def hash_content(connection: sqlite3.Connection) -> str:
    """SHA-256 over meshes and the sums of their occurrences, whatever order they came in.

    Equal hashes mean that the same was learned. An occurrence names its pattern by the id, a hash
    of the code. Everything else that follows from a code is left out; so are row ids of meshes,
    which depend on the order of ingestion, and how often patterns were used, with those that are
    there for nothing else.
    """
    total = hashlib.sha256()
    cursor = connection.cursor()
    cursor.row_factory = sqlite3.Row
    for row in cursor.execute("SELECT * FROM mesh ORDER BY sha256"):
        values = dict(row)
        occurrence_sum = values.pop("occurrence_sum")
        del values["id"]
        word = repr((list(values.values()), occurrence_sum))
        total.update(word.encode("utf-8", "surrogateescape"))
    return total.hexdigest()


def read_content_key(connection: sqlite3.Connection, n_sides: int) -> str:
    """Return what changes whenever a class of a database does, uses aside.

    All follows from meshes and their occurrences, which the content hash is made of, except the
    patterns that are there only because they were used. The key does not protect against forgery,
    so what is kept under it goes by the database's path as well.
    """
    unseen = connection.execute(
        "SELECT pattern_id, origin FROM usage WHERE pattern_id BETWEEN ? AND ? AND NOT EXISTS ("
        "SELECT 1 FROM occurrence WHERE occurrence.pattern_id = usage.pattern_id) ORDER BY 1",
        get_id_range(n_sides),
    ).fetchall()
    return repr((hash_content(connection), unseen))
