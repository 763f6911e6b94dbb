"""Check that a database is what it claims to be, whatever stands in the file."""

from __future__ import annotations

import itertools
import sqlite3
from collections.abc import Generator, Sequence
from typing import Any, NamedTuple

import numpy as np

from patterndb.core.code import canonical_code, decode, format_id
from patterndb.core.disk import Disk
from patterndb.core.packing import unpack, unpack_many
from patterndb.core.patternclass import ORIGINS
from patterndb.core.reduction import reduce_disk
from patterndb.core.shortcode import restore
from patterndb.errors import InvalidCodeError, PatternDBError
from patterndb.store.classes import reject_disorder
from patterndb.store.reading import select_meshes, sum_occurrences
from patterndb.store.records import (
    SELECT_PATTERNS,
    SELECT_USAGE,
    Mesh,
    OccurrenceRow,
    PatternRow,
    UsageRow,
)
from patterndb.store.writing import describe_patterns

#: Findings after which verify() stops listing; a damaged database has as many as rows.
MAX_FINDINGS = 100

#: Patterns that are read at a time, and examples.
READ_AT_ONCE = 1000
EXAMPLES_AT_ONCE = 10_000

#: Faces are numbered in 32 bits.
LARGEST_FACE = 1 << 31

#: Bytes of a SHA-256.
SHA256_SIZE = 32


def verify(connection: sqlite3.Connection) -> list[str]:
    """Find everything that is wrong with the database, in words; nothing where it is sound.

    Checks the file (SQLite's own integrity, types and foreign keys), every pattern (its code is a
    canonical disk's, reduced, its id and columns follow from it), that every pattern occurs in a
    mesh or was used, that meshes and examples can be what they claim, and that the occurrences of a
    mesh are those that were written with it. Whatever stands in the file, it ends in findings and
    not in an error.
    """
    found: list[str] = []
    checks = (_check_file, _check_counts, _check_meshes, _check_occurrences, _check_patterns)
    for check in checks:
        if len(found) >= MAX_FINDINGS or NOT_READ_ON in found:
            break
        try:
            found += check(connection)
        except sqlite3.DatabaseError as error:
            found.append(f"SQLite: {error}")
        except UNREADABLE as error:
            what = check.__name__.removeprefix("_check_")
            found.append(f"{what} cannot be read to the end ({type(error).__name__}: {error})")
    return found[:MAX_FINDINGS]


#: How SQLite's findings begin that are about pages of the file, not about rows in them.
_PAGES = "*** in database"

#: The finding after one of these.
NOT_READ_ON = "its pages are damaged, so that nothing else in the file was checked"

#: What values that are not of their column's type or range give when they are read.
UNREADABLE = (TypeError, ValueError, LookupError, OverflowError, PatternDBError)


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


def _check_counts(connection: sqlite3.Connection) -> list[str]:
    found = [
        f"pattern {format_id(number)} occurs in no mesh and was never used"
        for (number,) in connection.execute(
            "SELECT id FROM pattern WHERE id NOT IN (SELECT pattern_id FROM usage) "
            "AND NOT EXISTS (SELECT 1 FROM occurrence WHERE pattern_id = pattern.id)"
        )
    ]
    for use in map(UsageRow._make, connection.execute(SELECT_USAGE)):
        if type(use.uses) is not int or use.uses < 1 or use.origin not in ORIGINS:
            number = format_id(use.pattern_id)
            found.append(f"pattern {number} was used {use.uses!r} times as {use.origin!r}")
    return found


def _check_meshes(connection: sqlite3.Connection) -> list[str]:
    found: list[str] = []
    patches: dict[int, int] = dict(
        connection.execute("SELECT mesh_id, sum(patches) FROM occurrence GROUP BY mesh_id")
    )
    for row in select_meshes(connection, "ORDER BY sha256"):
        try:
            if len(row["sha256"]) != SHA256_SIZE:
                found.append(f"mesh {row['name']} has a hash of {len(row['sha256'])} bytes")
            mesh = Mesh.from_columns(row)
            found += list_mesh_faults(mesh, patches.get(row["id"], 0))
        except UNREADABLE as error:
            found.append(f"mesh {row['name']} cannot be read ({error})")
    return found


def list_mesh_faults(mesh: Mesh, patches: int) -> list[str]:
    """List what cannot be in the counts of a mesh, in words; patches: those of its patterns."""
    found: list[str] = []
    most, by_modes = mesh.options.most_patterns, (mesh.basic, mesh.side, mesh.convex)
    if mesh.left_out and not most:
        found.append(f"mesh {mesh.name} has {mesh.left_out} patterns left out, but had no limit")
    if most and mesh.patterns > most:
        found.append(
            f"mesh {mesh.name} has {mesh.patterns} patterns, more than its limit of {most}"
        )
    # Every pattern that was left out has a patch.
    if patches > mesh.distinct - mesh.left_out or (not mesh.left_out and patches != mesh.distinct):
        found.append(
            f"mesh {mesh.name} has {patches} patches in its patterns, but counted {mesh.distinct}"
        )
    if mesh.origin not in ("learned", "imported"):
        found.append(f"mesh {mesh.name} is {mesh.origin!r}, neither learned nor imported")
    # A patch is found by one mode or more.
    is_learned = mesh.origin == "learned"
    if is_learned and not max(by_modes) <= mesh.distinct <= sum(by_modes):
        found.append(f"mesh {mesh.name} has {mesh.distinct} patches, but {by_modes} by modes")
    return found


class _HeldOccurrence(NamedTuple):
    """An occurrence with what it must fit in the rows of its pattern and its mesh."""

    pattern_id: int
    mesh_id: int
    patches: int
    mirrored_patches: int
    example: bytes
    n_quads: int
    chiral: int
    name: str
    origin: str

    @property
    def fewest_quads(self) -> int:
        """Quads that the example has at least."""
        return self.n_quads if self.origin == "learned" else 0


def _check_occurrences(connection: sqlite3.Connection) -> list[str]:
    """Check examples and mirror images, and the sum of the occurrences of every mesh."""
    found: list[str] = []
    totals: dict[int, int] = {}
    rows = connection.execute(
        f"SELECT {', '.join(_HeldOccurrence._fields)} FROM occurrence "  # noqa: S608
        "JOIN pattern ON pattern.id = pattern_id JOIN mesh ON mesh.id = mesh_id"
    )
    while some := list(map(_HeldOccurrence._make, rows.fetchmany(EXAMPLES_AT_ONCE))):
        by_mesh: dict[int, list[OccurrenceRow]] = {}
        for one in some:
            row = OccurrenceRow(
                one.pattern_id, one.mesh_id, one.patches, one.mirrored_patches, one.example
            )
            by_mesh.setdefault(one.mesh_id, []).append(row)
        for mesh_id, own in by_mesh.items():
            totals[mesh_id] = sum_occurrences(own, totals.get(mesh_id, 0))
        fewest = [one.fewest_quads for one in some]
        if not are_examples_sound([one.example for one in some], fewest) or any(
            one.mirrored_patches and not one.chiral for one in some
        ):
            # Only then is each looked at by itself.
            found += _list_wrong_examples(some)
        if len(found) >= MAX_FINDINGS:
            return found
    for mesh_id, name, total in connection.execute("SELECT id, name, occurrence_sum FROM mesh"):
        if total != totals.get(mesh_id, 0).to_bytes(16, "big"):
            found.append(
                f"the occurrences of mesh {name} are not those that were written: they do not add "
                "up to its occurrence_sum"
            )
    return found


def are_examples_sound(examples: Sequence[Any], fewest: Sequence[Any]) -> bool:
    """Can all of these be examples, numbers of faces that ascend, of so many quads at least?"""
    if not set(map(type, examples)) <= {bytes} or not set(map(type, fewest)) <= {int}:
        return False
    try:
        steps, offsets = unpack_many(examples)
        enough = np.diff(offsets) >= np.array(fewest, np.int64)
    except UNREADABLE:
        return False
    sums = np.concatenate([[0], np.cumsum(steps, dtype=np.int64)])[offsets]
    is_later = np.ones(len(steps), np.bool_)
    # One that is empty begins where the next does, or at the end of all.
    is_later[offsets[:-1][np.diff(offsets) > 0]] = False
    return bool(
        enough.all() and (steps[is_later] >= 1).all() and (np.diff(sums) < LARGEST_FACE).all()
    )


def _list_wrong_examples(rows: list[_HeldOccurrence]) -> list[str]:
    found: list[str] = []
    for one in rows:
        if len(found) >= MAX_FINDINGS:
            break
        name = format_id(one.pattern_id)
        where = f"the example of pattern {name} in mesh {one.name}"
        try:
            steps = unpack(one.example)
        except UNREADABLE as error:
            found.append(f"{where} cannot be read ({error})")
            continue
        if len(steps) < one.fewest_quads:
            found.append(f"{where} has {len(steps)} quads, fewer than the pattern")
        elif (steps[1:] < 1).any() or steps.sum(dtype=np.int64) >= LARGEST_FACE:
            found.append(f"{where} has quads that no file numbers so")
        if one.mirrored_patches and not one.chiral:
            found.append(f"pattern {name} is its own mirror image, but has others")
    return found


def _check_patterns(connection: sqlite3.Connection) -> list[str]:
    found: list[str] = []
    # Some at a time: checking them takes long, and while a statement runs nobody else can write.
    for rows in _read_in_parts(connection):
        described = describe_sound([row.code for row in rows])
        for row, expected in zip(rows, described, strict=True):
            if isinstance(expected, Exception):
                found.append(f"pattern {format_id(row.id)}: {expected}")
            elif row != expected:
                found.append(
                    f"pattern {format_id(row.id)} has columns that do not follow from its code"
                )
        if len(found) >= MAX_FINDINGS:
            break
    return found


def _read_in_parts(connection: sqlite3.Connection) -> Generator[list[PatternRow]]:
    """Read the rows of patterns in order of their ids, some at a time.

    No statement stays open between two parts. Raises DatabaseError where the ids do not ascend: in
    a damaged tree a search for later ones might never end.
    """
    last = None
    while True:
        rows = [
            PatternRow._make(row)
            for row in connection.execute(
                f"{SELECT_PATTERNS} WHERE id > ? ORDER BY id LIMIT ?",
                (-1 << 63 if last is None else last, READ_AT_ONCE),
            )
        ]
        reject_disorder([row.id for row in rows], last)
        if rows:
            yield rows
        if len(rows) < READ_AT_ONCE:
            return
        last = rows[-1].id


def describe_sound(codes: Sequence[Any]) -> list[PatternRow | Exception]:
    """Describe patterns whose short codes may be anything.

    For each the row that follows from it, or the error with the reason why it is not the canonical
    code of a disk that cannot be reduced.
    """
    found: list[PatternRow | Exception] = []
    while len(found) < len(codes):
        found += _describe_until_fault(codes[len(found) :])
        if len(found) < len(codes):
            found.append(_find_fault(codes[len(found)]))
    return found


def _describe_until_fault(codes: Sequence[Any]) -> list[PatternRow]:
    """Describe the patterns before the first whose code is not sound."""
    n = next((k for k, code in enumerate(codes) if type(code) is not bytes), len(codes))
    while n:
        try:
            described = describe_patterns(codes[:n])
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


def _find_fault(short: Any) -> Exception:
    """Return the error of a code that is not sound."""
    try:
        check_code(short)
    except UNREADABLE as error:
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
