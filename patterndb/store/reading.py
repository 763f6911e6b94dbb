"""Read a database: patterns by class, name and source, meshes, occurrences, statistics."""

from __future__ import annotations

import difflib
import json
import sqlite3
from collections.abc import Callable, Collection, Generator, Iterable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import PurePath
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from patterndb.core import description as d
from patterndb.core.code import MAX_CLASS
from patterndb.core.packing import unpack
from patterndb.core.pattern import Pattern
from patterndb.core.patternclass import ORIGINS, ClassPart, PatternClass
from patterndb.core.shortcode import pack_symbols, restore
from patterndb.errors import DatabaseError, InvalidCodeError, NotFoundError
from patterndb.store.columns import (
    MOST_32,
    MOST_64,
    check_blobs,
    read_numbers,
    refuse_disorder,
    say_wrong,
)
from patterndb.store.records import LearningOptions, Mesh, Occurrence, Provenance
from patterndb.system.progress import report_progress

T = TypeVar("T")


def get_id_range(n_sides: int) -> tuple[int, int]:
    """Smallest and largest id of the class (of all classes from MAX_CLASS on together)."""
    first = min(n_sides, MAX_CLASS) << 56
    return first, first + (1 << 56) - 1


def read_data_version(connection: sqlite3.Connection) -> int:
    """A number that changes when another connection has changed the file."""
    return connection.execute("PRAGMA data_version").fetchone()[0]


#: Columns of a pattern that follow from its code, and where its description tells them.
FOLLOWING = {
    "n_reflex": d.N_REFLEX,
    "n_quads": d.N_QUADS,
    "n_irregular": d.N_IRREGULAR,
    "chiral": d.CHIRAL,
}


def load_class(connection: sqlite3.Connection, n_sides: int) -> PatternClass:
    """All patterns of ``n_sides`` sides, in default order.

    All but the counts is made of the codes, so that nothing is indexed by what was read. Raises
    DatabaseError, which names pattern and column, where a code is not the canonical one of a disk
    of so many sides, or a column does not follow from it or holds what it cannot.
    """
    return PatternClass.from_parts(n_sides, _read_parts(connection, n_sides))


#: Patterns of a class that are read and described at a time: some ten megabytes.
READ_AT_ONCE = 10_000

_SELECT_CLASS = """
SELECT id, code, frequency, coalesce(uses, 0),
    (SELECT count(*) FROM occurrence WHERE occurrence.pattern_id = id),
    pattern.origin, n_reflex, n_quads, n_irregular, chiral
FROM pattern LEFT JOIN usage ON usage.pattern_id = id
WHERE id BETWEEN ? AND ? AND n_sides = ? ORDER BY id
"""


def _read_parts(connection: sqlite3.Connection, n_sides: int) -> Generator[ClassPart]:
    """Read the patterns of a class part by part; the next is read while one is described."""
    low, high = get_id_range(n_sides)
    cursor = connection.execute(_SELECT_CLASS, (low, high, n_sides))
    with (
        ThreadPoolExecutor(1, "patterndb-reading") as pool,
        report_progress(f"reading the patterns of {n_sides} sides, once") as report,
    ):
        ahead: Future[ClassPart] | None = None
        last: int | None = None
        while rows := cursor.fetchmany(READ_AT_ONCE):
            refuse_disorder([row[0] for row in rows], last)
            last = rows[-1][0]
            one, ahead = ahead, pool.submit(_make_part, n_sides, rows)
            if one is not None:
                yield one.result()
            # Ids are hashes, and so evenly spread.
            report((rows[-1][0] - low) / (high - low))
        # SQLite's own copy of the pages is of no use to the next question.
        connection.execute("PRAGMA shrink_memory")
        if ahead is not None:
            yield ahead.result()


def _make_part(n_sides: int, rows: list[tuple[Any, ...]]) -> ClassPart:
    """Check rows of :data:`_SELECT_CLASS`, and describe their codes."""
    ids, short, *columns = zip(*rows, strict=True)
    check_blobs(ids, "code", short)
    frequency = read_numbers(ids, "frequency", columns[0], 0, MOST_64)
    uses = read_numbers(ids, "uses", columns[1], 0, MOST_64)
    n_meshes = read_numbers(ids, "occurrences", columns[2], 0, MOST_32)
    number_of = {name: number for number, name in enumerate(ORIGINS)}
    origin = np.array([number_of.get(name, -1) for name in columns[3]], np.int8)
    _refuse(ids, "origin", origin < 0, f"is none of {', '.join(ORIGINS)}")
    try:
        symbols, offsets = restore(short)
        described = d.describe_symbols(symbols, offsets)
    except InvalidCodeError as error:
        assert error.row is not None
        raise say_wrong(ids[error.row], "code", f"is damaged ({error})") from error
    wrong = described.counts[:, d.N_CORNERS] != n_sides
    _refuse(ids, "code", wrong, f"is not of {n_sides} sides")
    for (name, at), values in zip(FOLLOWING.items(), columns[4:], strict=True):
        stored = read_numbers(ids, name, values, 0, MOST_32)
        _refuse(ids, name, stored != described.counts[:, at], "does not follow from its code")
    return ClassPart(
        pack_symbols(symbols, offsets),
        described,
        ids=np.array(ids, np.int64),
        frequency=frequency,
        n_meshes=n_meshes.astype(np.int32),
        uses=uses,
        origin=origin,
    )


def _refuse(ids: Sequence[int], column: str, wrong: NDArray[np.bool_], why: str) -> None:
    if wrong.any():
        raise say_wrong(ids[int(wrong.argmax())], column, why)


def read_frequencies(connection: sqlite3.Connection, ids: NDArray[np.int64]) -> NDArray[np.int64]:
    """(k,) int64 frequency of every pattern; 0 for those that are not there."""
    wanted = ids.tolist()
    found: dict[int, int] = dict(
        connection.execute(
            "SELECT id, frequency FROM pattern WHERE id IN (SELECT value FROM json_each(?))",
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


_PATTERN = "SELECT code, frequency, origin FROM pattern WHERE id "


def find_pattern(connection: sqlite3.Connection, name: str) -> Pattern:
    """The pattern whose name (16 hexadecimal digits) begins with ``name``.

    Raises NotFoundError if there is none, or more than one.
    """
    rows = connection.execute(_PATTERN + "BETWEEN ? AND ? LIMIT 2", parse_name(name)).fetchall()
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


_MESHES = """
SELECT name, sha256, author, source, licence, basic_limit, side_limit, convex_limit, prepared,
    quads_read, quads_used, basic_patches, side_patches, convex_patches, distinct_patches,
    (SELECT count(*) FROM occurrence WHERE mesh_id = mesh.id), origin,
    pattern_limit, patterns_left_out
FROM mesh
"""


def list_meshes(connection: sqlite3.Connection) -> list[Mesh]:
    """All meshes, by name."""
    return [make_mesh(row) for row in connection.execute(_MESHES + "ORDER BY name, sha256")]


def find_mesh(connection: sqlite3.Connection, sha256: bytes) -> Mesh | None:
    """The mesh of a file with this hash."""
    row = connection.execute(_MESHES + "WHERE sha256 = ?", (sha256,)).fetchone()
    return None if row is None else make_mesh(row)


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
        KnownMesh(number, name, _check_hash(sha256), licence)
        for number, name, sha256, licence in rows
    ]


def _check_hash(value: object) -> bytes:
    """The SHA-256 of a mesh's row. Raises DatabaseError for what is no bytes: of a number, bytes()
    would make as many zeros."""
    if not isinstance(value, bytes):
        raise DatabaseError(
            f"the SHA-256 of a mesh is {repr(value)[:40]}, no bytes: the file is damaged; "
            "'patterndb verify' tells what is wrong"
        )
    return value


def make_mesh(row: tuple[object, ...]) -> Mesh:
    """A mesh of its row: name, hash, provenance, options, what was found, patterns, origin, and
    the limit of its patterns with those left out."""
    name, sha256, author, source, licence, basic, side, convex, prepared, *counts = row
    *counts, most, left_out = counts
    return Mesh(
        str(name),
        _check_hash(sha256).hex(),
        Provenance(author, source, licence),  # pyright: ignore[reportArgumentType]
        options_of(basic, side, convex, prepared, most),
        *counts,  # pyright: ignore[reportArgumentType]
        left_out=left_out,  # pyright: ignore[reportArgumentType]
    )


def options_of(
    basic: object, side: object, convex: object, prepared: object, most_patterns: object
) -> LearningOptions:
    """The learning options that a mesh's columns tell."""
    if not (basic or side or convex):
        return LearningOptions.none()
    return LearningOptions(
        basic,  # pyright: ignore[reportArgumentType]
        side,  # pyright: ignore[reportArgumentType]
        convex,  # pyright: ignore[reportArgumentType]
        bool(prepared),
        most_patterns,  # pyright: ignore[reportArgumentType]
    )


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
