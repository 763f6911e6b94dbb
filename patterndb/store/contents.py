"""The content of a database as one hash, and the check that it is what it claims to be."""

from __future__ import annotations

import hashlib
import itertools
import sqlite3
from collections.abc import Sequence
from typing import Any

import numpy as np

from patterndb.core.code import canonical_code, decode, format_id
from patterndb.core.disk import Disk
from patterndb.core.packing import unpack, unpack_many
from patterndb.core.patternclass import ORIGINS
from patterndb.core.reduction import reduce_disk
from patterndb.core.shortcode import restore
from patterndb.errors import InvalidCodeError, PatternDBError
from patterndb.store import writing
from patterndb.store.checksums import find_changed_tables
from patterndb.store.columns import read_in_parts
from patterndb.store.reading import options_of
from patterndb.store.tallies import find_wrong_tallies

#: Findings after which verify() stops listing; a damaged database has as many as rows.
MAX_FINDINGS = 100

#: Patterns that are read at a time, and examples.
READ_AT_ONCE = 1000
EXAMPLES_AT_ONCE = 10_000

#: Faces are numbered in 32 bits.
LARGEST_FACE = 1 << 31

#: Bytes of a SHA-256.
SHA256_SIZE = 32


def hash_content(connection: sqlite3.Connection) -> str:
    """SHA-256 over meshes and the sums of their occurrences, whatever order they came in.

    Equal hashes mean that the same was learned. An occurrence tells its pattern by the id, a hash
    of the code. Everything else that follows from a code is left out; so are row ids of meshes,
    which depend on the order of ingestion, and how often patterns were used, with those that are
    there for nothing else. Only meshes are read: the sums of their occurrences
    (:mod:`patterndb.store.checksums`) are kept by every write, and :func:`verify` checks them.
    """
    total = hashlib.sha256()
    sums = dict(connection.execute("SELECT id, occurrence_sum FROM mesh").fetchall())
    for mesh_id, *row in connection.execute(writing.SELECT_MESHES):
        total.update(repr((row, sums[mesh_id])).encode("utf-8", "surrogateescape"))
    return total.hexdigest()


#: Every pattern whose frequency or origin does not follow from its occurrences and uses.
_COUNTED = """
SELECT id, frequency, total, pattern.origin, coalesce(met, usage.origin) AS expected
FROM pattern LEFT JOIN usage ON usage.pattern_id = pattern.id JOIN (
    SELECT pattern.id AS counted, coalesce(sum(patches), 0) AS total, max(mesh.origin) AS met
    FROM pattern
        LEFT JOIN occurrence ON occurrence.pattern_id = pattern.id
        LEFT JOIN mesh ON mesh.id = mesh_id
    GROUP BY pattern.id
) ON counted = pattern.id
WHERE frequency <> total OR expected IS NULL OR pattern.origin <> expected
"""


def verify(connection: sqlite3.Connection) -> list[str]:
    """Everything that is wrong with the database, in words; empty where it is sound.

    Checks the file (SQLite's own integrity, types and foreign keys), every pattern (its code is a
    canonical disk's, reduced, its id and columns follow from it), that frequencies are the
    sums of the occurrences and origins follow from them, that every pattern occurs in a
    mesh or was used, that meshes and examples can be what they say, that the counts kept by every
    write are those of the rows (:mod:`patterndb.store.tallies`), and that the rows of tables add up
    to their checksums (:mod:`patterndb.store.checksums`). Whatever stands in the file, it ends in
    findings and not in an error.
    """
    found: list[str] = []
    # The sums last: they say less of what is wrong than any other check.
    checks = (
        _check_file,
        _check_counts,
        _check_meshes,
        _check_examples,
        _check_patterns,
        find_wrong_tallies,
        _check_sums,
    )
    for check in checks:
        if len(found) >= MAX_FINDINGS or NOT_READ_ON in found:
            break
        try:
            found += check(connection)
        except sqlite3.DatabaseError as error:
            found.append(f"SQLite: {error}")
        except _UNREADABLE as error:
            what = check.__name__.removeprefix("_check_").removeprefix("find_wrong_")
            found.append(f"{what} cannot be read to the end ({type(error).__name__}: {error})")
    return found[:MAX_FINDINGS]


#: How SQLite's findings begin that are about pages of the file, not about rows in them.
_PAGES = "*** in database"

#: The finding after one of these.
NOT_READ_ON = "its pages are damaged, so that nothing else in the file was checked"

#: What values that are not of their column's type or range give when they are read.
_UNREADABLE = (TypeError, ValueError, LookupError, OverflowError, PatternDBError)


def _check_file(connection: sqlite3.Connection) -> list[str]:
    try:
        told = [row[0] for row in connection.execute("PRAGMA integrity_check(20)")]
    except sqlite3.DatabaseError as error:
        return [f"SQLite: {error}", NOT_READ_ON]
    found = [] if told == ["ok"] else [f"SQLite: {text}" for text in told]
    if any(text.startswith(_PAGES) for text in told):
        # To read on in a tree whose pages refer to each other in a circle might never end.
        return [*found, NOT_READ_ON]
    return found + [
        f"row {row[1]} of {row[0]} refers to a row of {row[2]} that is missing"
        for row in connection.execute("PRAGMA foreign_key_check")
    ]


def _check_sums(connection: sqlite3.Connection) -> list[str]:
    return [
        f"the rows of table {table} are not those that were written: they do not add up to its "
        "checksum"
        for table in find_changed_tables(connection)
    ]


def _check_counts(connection: sqlite3.Connection) -> list[str]:
    found: list[str] = []
    for number, frequency, patches, origin, expected in connection.execute(_COUNTED):
        if frequency != patches or expected is None:
            found.append(
                f"pattern {format_id(number)} has frequency {frequency}, but {patches} patches"
                + ("" if patches else ", and was never used")
            )
        elif origin != expected:
            found.append(f"pattern {format_id(number)} is {expected}, but said to be {origin}")
    for number, uses, origin in connection.execute("SELECT pattern_id, uses, origin FROM usage"):
        if type(uses) is not int or uses < 1 or origin not in ORIGINS:
            found.append(f"pattern {format_id(number)} was used {uses!r} times as {origin!r}")
    for name, patches, mirrored in connection.execute(
        "SELECT mesh.name, sum(patches), distinct_patches FROM mesh "
        "LEFT JOIN occurrence ON mesh_id = mesh.id GROUP BY mesh.id "
        # Every pattern that was left out has a patch.
        "HAVING coalesce(sum(patches), 0) > distinct_patches - patterns_left_out "
        "OR (patterns_left_out = 0 AND coalesce(sum(patches), 0) <> distinct_patches)"
    ):
        found.append(f"mesh {name} has {patches} patches in its patterns, but counted {mirrored}")
    for name, patterns, most in connection.execute(
        "SELECT mesh.name, count(*), pattern_limit FROM mesh JOIN occurrence ON mesh_id = mesh.id "
        "WHERE pattern_limit > 0 GROUP BY mesh.id HAVING count(*) > pattern_limit"
    ):
        found.append(f"mesh {name} has {patterns} patterns, more than its limit of {most}")
    return found


def _check_meshes(connection: sqlite3.Connection) -> list[str]:
    found: list[str] = []
    for _, *row in connection.execute(writing.SELECT_MESHES):
        sha256, name, *rest, origin, most, left_out = row
        *_, _, _, basic_patches, side_patches, convex_patches, distinct = rest
        patches = [basic_patches, side_patches, convex_patches]
        try:
            options_of(*writing.pick_options(row))
            if left_out and not most:
                found.append(f"mesh {name} has {left_out} patterns left out, but had no limit")
            if len(sha256) != SHA256_SIZE:
                found.append(f"mesh {name} has a hash of {len(sha256)} bytes, not {SHA256_SIZE}")
            # A patch is found by one mode or more.
            if origin == "learned" and not max(patches) <= distinct <= sum(patches):
                found.append(f"mesh {name} has {distinct} patches, but {patches} by modes")
        except _UNREADABLE as error:
            found.append(f"mesh {name} cannot be read ({error})")
    return found


def _check_examples(connection: sqlite3.Connection) -> list[str]:
    found: list[str] = []
    rows = connection.execute(
        "SELECT pattern.id, mesh.name, example, pattern.n_quads, mesh.origin, mirrored_patches, "
        "chiral FROM occurrence JOIN pattern ON pattern.id = pattern_id "
        "JOIN mesh ON mesh.id = mesh_id"
    )
    while len(found) < MAX_FINDINGS and (some := rows.fetchmany(EXAMPLES_AT_ONCE)):
        _, _, examples, n_quads, origins, mirrored, chiral = zip(*some, strict=True)
        fewest = [
            n if origin == "learned" else 0 for n, origin in zip(n_quads, origins, strict=True)
        ]
        if not are_examples_sound(examples, fewest) or any(
            own and not other for own, other in zip(mirrored, chiral, strict=True)
        ):
            # Only then is each looked at by itself.
            found += _list_wrong_examples(some)
    return found


def are_examples_sound(examples: Sequence[Any], fewest: Sequence[Any]) -> bool:
    """Can all of these be examples, numbers of faces that ascend, of so many quads at least?"""
    if not set(map(type, examples)) <= {bytes} or not set(map(type, fewest)) <= {int}:
        return False
    try:
        steps, offsets = unpack_many(examples)
        enough = np.diff(offsets) >= np.array(fewest, np.int64)
    except _UNREADABLE:
        return False
    sums = np.concatenate([[0], np.cumsum(steps, dtype=np.int64)])[offsets]
    is_later = np.ones(len(steps), np.bool_)
    # One that is empty begins where the next does, or at the end of all.
    is_later[offsets[:-1][np.diff(offsets) > 0]] = False
    return bool(
        enough.all() and (steps[is_later] >= 1).all() and (np.diff(sums) < LARGEST_FACE).all()
    )


def _list_wrong_examples(rows: list[tuple[Any, ...]]) -> list[str]:
    found: list[str] = []
    for number, name, example, n_quads, origin, mirrored, chiral in rows:
        if len(found) >= MAX_FINDINGS:
            break
        where = f"the example of pattern {format_id(number)} in mesh {name}"
        try:
            steps = unpack(example)
        except _UNREADABLE as error:
            found.append(f"{where} cannot be read ({error})")
            continue
        if origin == "learned" and len(steps) < n_quads:
            found.append(f"{where} has {len(steps)} quads, fewer than the pattern")
        elif (steps[1:] < 1).any() or steps.sum(dtype=np.int64) >= LARGEST_FACE:
            found.append(f"{where} has quads that no file numbers so")
        if mirrored and not chiral:
            found.append(f"pattern {format_id(number)} is its own mirror image, but has others")
    return found


def _check_patterns(connection: sqlite3.Connection) -> list[str]:
    found: list[str] = []
    # Some at a time: checking them takes long, and while a statement runs nobody else can write.
    for rows in read_in_parts(connection, writing.SELECT_PATTERNS, READ_AT_ONCE):
        for (number, *stored), told in zip(
            rows, describe_sound([row[1] for row in rows]), strict=True
        ):
            if isinstance(told, Exception):
                found.append(f"pattern {format_id(number)}: {told}")
            elif told != (number, tuple(stored)):
                found.append(
                    f"pattern {format_id(number)} has columns that do not follow from its code"
                )
        if len(found) >= MAX_FINDINGS:
            break
    return found


#: Id and described columns of a pattern, as :func:`writing.describe_patterns` has them.
Described = tuple[int, tuple[Any, ...]]


def describe_sound(codes: Sequence[Any]) -> list[Described | Exception]:
    """Describe patterns whose short codes may be anything.

    For each what :func:`writing.describe_patterns` tells, or the error that says why it is none:
    it must be the canonical code of a disk that cannot be reduced.
    """
    found: list[Described | Exception] = []
    while len(found) < len(codes):
        found += _describe_until_fault(codes[len(found) :])
        if len(found) < len(codes):
            found.append(_say_fault(codes[len(found)]))
    return found


def _describe_until_fault(codes: Sequence[Any]) -> list[Described]:
    """Describe the patterns before the first whose code is not sound."""
    n = next((k for k, code in enumerate(codes) if type(code) is not bytes), len(codes))
    while n:
        try:
            described = writing.describe_patterns(codes[:n])
            symbols, offsets = restore(codes[:n])
        except InvalidCodeError as error:
            assert error.row is not None
            n = error.row
            continue
        twins = symbols.astype(np.int32) - 1
        for k, (begin, end) in enumerate(itertools.pairwise(offsets.tolist())):
            if len(reduce_disk(twins[begin:end])) != end - begin:
                return described[:k]
        return described
    return []


def _say_fault(short: Any) -> Exception:
    """Say what is wrong with a code that is not sound."""
    try:
        check_code(short)
    except _UNREADABLE as error:
        return error
    return InvalidCodeError("it is not the canonical code of a disk")


def check_code(short: bytes) -> None:
    """Check a short code, which must be the canonical one of a disk that cannot be reduced.

    Raises PatternDBError, ValueError, TypeError, LookupError or OverflowError where it is not.
    """
    code, _ = restore([short])
    twin = decode(code)
    Disk.from_twin(twin)
    if not np.array_equal(canonical_code(twin)[0], code):
        raise InvalidCodeError("its code is not canonical")
    if len(reduce_disk(twin)) != len(twin):
        raise InvalidCodeError("it can be reduced further")
