"""Counts that every write keeps, so that statistics need no look at every row.

``tally`` counts patterns by sides, irregular vertices and chirality, ``handedness`` in how many
handednesses patterns were met, and ``signature`` holds the hashes of all patterns' signatures, as
many at a time as were written together. That adds nothing to be seen to the time of a write: a row
or two for each number of sides, where an index of signatures would take an eighth of it.

Where tables were filled at once (:func:`tally_anew`) all is counted from the rows, as :func:`verify
<patterndb.store.contents.verify>` does to see that it is still so (:func:`find_wrong_tallies`).
"""

from __future__ import annotations

import json
import sqlite3
from collections import Counter, defaultdict
from collections.abc import Collection, Generator, Iterable, Mapping, Sequence
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from patterndb.errors import DatabaseError
from patterndb.store.columns import read_in_parts

#: Bytes of the hash that stands for a signature: among ten million, two that are equal by chance
#: are not to be expected.
SIGNATURE_SIZE = 8

#: What is counted of a pattern: sides, irregular vertices, whether it is chiral, signature's hash.
TALLIED = "n_sides, n_irregular, chiral, signature"
Tallied = tuple[int, int, int, bytes]

#: Patterns that are counted at a time where all are: some ten megabytes.
COUNTED_AT_ONCE = 50_000

#: Whether some patches of a pattern are as its code, and some mirrored.
_MET = "max(patches > mirrored_patches) AS own, max(mirrored_patches > 0) AS mirrored"

_WRONG = "the counts that it keeps of its patterns are not of these"


def add_tallied(connection: sqlite3.Connection, patterns: Sequence[Tallied]) -> None:
    """Count patterns that were written. Belongs inside atomic(), as all that writes here."""
    counts, hashes = _tally(patterns)
    _change_counts(connection, counts)
    _append_signatures(connection, hashes)


def take_off_tallied(connection: sqlite3.Connection, patterns: Sequence[Tallied]) -> None:
    """No longer count patterns that were deleted.

    The hashes of each number of sides of theirs are written anew, as one row. Raises DatabaseError
    where the counts do not hold these patterns.
    """
    counts, gone = _tally(patterns)
    _change_counts(connection, {what: -count for what, count in counts.items()})
    connection.execute("DELETE FROM tally WHERE patterns = 0")
    for n_sides, some in gone.items():
        held = np.sort(_read_signatures(connection, n_sides))
        left = _take_out(held, np.sort(_as_numbers(some)))
        connection.execute("DELETE FROM signature WHERE n_sides = ?", (n_sides,))
        if len(left):
            _append_signatures(connection, {n_sides: left.tobytes()})


def _tally(patterns: Iterable[Tallied]) -> tuple[Counter[tuple[int, int, int]], dict[int, bytes]]:
    """How many patterns are alike, and the hashes of their signatures by number of sides.

    Raises DatabaseError where a signature is none, as it may be in a damaged file."""
    counts: Counter[tuple[int, int, int]] = Counter()
    hashes: defaultdict[int, list[bytes]] = defaultdict(list)
    for n_sides, n_irregular, chiral, signature in patterns:
        if type(signature) is not bytes or len(signature) != SIGNATURE_SIZE:
            raise _say_wrong()
        counts[n_sides, n_irregular, chiral] += 1
        hashes[n_sides].append(signature)
    return counts, {n: b"".join(some) for n, some in hashes.items()}


def _change_counts(
    connection: sqlite3.Connection, changes: Mapping[tuple[int, int, int], int]
) -> None:
    # Counts are never below 0 (CHECK): an upsert would see that before it adds.
    connection.executemany(
        "INSERT OR IGNORE INTO tally (n_sides, n_irregular, chiral, patterns) VALUES (?, ?, ?, 0)",
        changes,
    )
    try:
        connection.executemany(
            "UPDATE tally SET patterns = patterns + ? "
            "WHERE n_sides = ? AND n_irregular = ? AND chiral = ?",
            ((count, *what) for what, count in changes.items()),
        )
    except sqlite3.IntegrityError as error:
        raise _say_wrong() from error


def _append_signatures(connection: sqlite3.Connection, hashes: Mapping[int, bytes]) -> None:
    connection.executemany(
        "INSERT INTO signature (n_sides, hashes) VALUES (?, ?)", sorted(hashes.items())
    )


def _read_signatures(connection: sqlite3.Connection, n_sides: int) -> NDArray[np.uint64]:
    """The hashes (p,) of the patterns of ``n_sides`` sides, as numbers, in no order."""
    rows = connection.execute("SELECT hashes FROM signature WHERE n_sides = ?", (n_sides,))
    parts = [row[0] for row in rows]
    if any(type(part) is not bytes or not part or len(part) % SIGNATURE_SIZE for part in parts):
        raise _say_wrong()
    return _as_numbers(b"".join(parts))


def _as_numbers(hashes: bytes) -> NDArray[np.uint64]:
    return np.frombuffer(hashes, "<u8")


def _take_out(held: NDArray[np.uint64], gone: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Take numbers out of others, each as often as it is there; both ascend."""
    first = np.searchsorted(held, gone)
    # The second of two equal ones takes the place after the first's, and so on.
    first += np.arange(len(gone)) - np.searchsorted(gone, gone)
    if len(gone) and (first.max() >= len(held) or not np.array_equal(held[first], gone)):
        raise _say_wrong()
    return np.delete(held, first)


def _say_wrong() -> DatabaseError:
    return DatabaseError(f"{_WRONG}; 'patterndb verify' tells what is wrong with the whole file")


def add_met(
    connection: sqlite3.Connection,
    occurrences: Iterable[tuple[int, int, int]],
    new: Collection[int],
) -> None:
    """Count the handednesses that occurrences add, before they are written.

    occurrences: of each its pattern's id, its patches and how many of them are mirrored, one for a
    pattern. new: patterns that were written just now, and so are in no other.
    """
    added = 0
    others: list[tuple[int, int, int]] = []
    for row in occurrences:
        number, patches, mirrored = row
        if number in new:
            added += (patches > mirrored) + (mirrored > 0)
        else:
            others.append(row)
    met = {
        number: (own, of_mirrored)
        for number, own, of_mirrored in connection.execute(
            f"SELECT pattern_id, {_MET} FROM occurrence "  # noqa: S608
            "WHERE pattern_id IN (SELECT value FROM json_each(?)) GROUP BY pattern_id",
            (json.dumps([row[0] for row in others]),),
        )
    }
    # One that was only used so far is in no mesh.
    neither = (0, 0)
    for number, patches, mirrored in others:
        own, of_mirrored = met.get(number, neither)
        added += (patches > mirrored and not own) + (mirrored > 0 and not of_mirrored)
    _add_handednesses(connection, added)


@contextmanager
def removing_occurrences(connection: sqlite3.Connection, mesh_id: int) -> Generator[None]:
    """No longer count the handednesses that were met in a mesh alone, whose occurrences the block
    deletes."""
    connection.execute("CREATE TEMP TABLE touched (id INTEGER PRIMARY KEY)")
    try:
        connection.execute(
            "INSERT INTO touched SELECT pattern_id FROM occurrence WHERE mesh_id = ?", (mesh_id,)
        )
        # A cross join begins with these patterns, not with all occurrences.
        of_touched = "touched CROSS JOIN occurrence ON pattern_id = touched.id"
        before = _count_met(connection, of_touched)
        yield
        _add_handednesses(connection, _count_met(connection, of_touched) - before)
    finally:
        connection.execute("DROP TABLE touched")


def _count_met(connection: sqlite3.Connection, source: str = "occurrence") -> int:
    """Count the handednesses of patterns that occur in a source of occurrences."""
    return connection.execute(
        "SELECT coalesce(sum(own + mirrored), 0) FROM "  # noqa: S608
        f"(SELECT {_MET} FROM {source} GROUP BY pattern_id)"
    ).fetchone()[0]


def _add_handednesses(connection: sqlite3.Connection, change: int) -> None:
    if change and not connection.execute("UPDATE handedness SET met = met + ?", (change,)).rowcount:
        raise _say_wrong()


def tally_anew(connection: sqlite3.Connection) -> None:
    """Count whole tables anew: where they were filled at once. Belongs inside atomic()."""
    for table in ("tally", "signature", "handedness"):
        connection.execute(f"DELETE FROM {table}")  # noqa: S608
    for some in _read_patterns(connection):
        add_tallied(connection, some)
    connection.execute("INSERT INTO handedness VALUES (?)", (_count_met(connection),))


def _read_patterns(connection: sqlite3.Connection) -> Generator[list[Tallied]]:
    """What is counted of all patterns, some at a time, class by class."""
    select = f"SELECT id, {TALLIED} FROM pattern"  # noqa: S608
    for rows in read_in_parts(connection, select, COUNTED_AT_ONCE):
        yield [(n_sides, irregular, chiral, own) for _, n_sides, irregular, chiral, own in rows]


def find_wrong_tallies(connection: sqlite3.Connection) -> list[str]:
    """Find the counts that are not those of the rows, in words."""
    found: list[str] = []
    counts: Counter[tuple[int, int, int]] = Counter()
    hashes: defaultdict[int, list[bytes]] = defaultdict(list)
    for some in _read_patterns(connection):
        of_some, signatures = _tally(some)
        counts += of_some
        for n_sides, own in signatures.items():
            hashes[n_sides].append(own)
    held = connection.execute("SELECT n_sides, n_irregular, chiral, patterns FROM tally")
    if {tuple(what): count for *what, count in held} != counts:
        found.append("the tally of patterns is not that of its patterns")
    classes = {row[0] for row in connection.execute("SELECT DISTINCT n_sides FROM signature")}
    if classes != hashes.keys() or any(
        not np.array_equal(
            np.sort(_read_signatures(connection, n)), np.sort(_as_numbers(b"".join(hashes[n])))
        )
        for n in classes
    ):
        found.append("the signatures that it keeps are not those of its patterns")
    if read_handednesses(connection) != _count_met(connection):
        found.append("the number of handednesses that were met is not that of its occurrences")
    return found


def read_tally(connection: sqlite3.Connection) -> list[tuple[int, int, int, int]]:
    """How many patterns have so many sides, irregular vertices and are chiral or not: rows of
    these three and the count, in order."""
    return connection.execute(
        "SELECT n_sides, n_irregular, chiral, patterns FROM tally ORDER BY 1, 2, 3"
    ).fetchall()


def count_signatures(connection: sqlite3.Connection) -> int:
    """Count the signatures that differ. Patterns of one have one number of sides."""
    count = 0
    for (n_sides,) in connection.execute("SELECT DISTINCT n_sides FROM signature").fetchall():
        ordered = np.sort(_read_signatures(connection, n_sides))
        count += 1 + int(np.count_nonzero(ordered[1:] != ordered[:-1]))
    return count


def read_handednesses(connection: sqlite3.Connection) -> int:
    """In how many handednesses patterns were met, all together."""
    return connection.execute("SELECT met FROM handedness").fetchone()[0]
