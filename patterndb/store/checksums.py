"""Sums over the rows of tables, kept with each write: what changed otherwise does not add up.

What follows from a pattern's code is checked against the code. Nothing follows from the example of
an occurrence, a licence or a count of uses: for these the table ``checksum`` holds, for each table,
the sum modulo 2**128 of the hashes of its rows. A sum does not depend on the order of rows, and a
write adds what it adds and takes off what it takes off, without reading the rest.

Occurrences have a sum for each mesh, which stands in the mesh's row and is summed with it. The
number of the mesh in this file is not hashed, so that the same mesh, learned with the same options,
has the same sum in every database; the content hash is made of these sums.

It finds damage, not forgery: who can change a row on purpose can change the sum.
"""

from __future__ import annotations

import hashlib
import sqlite3
from collections.abc import Generator, Iterable
from contextlib import contextmanager
from typing import Any

from patterndb.errors import DatabaseError

#: The tables with a sum, and their columns in order: they are part of what is hashed. A pattern's
#: id is a hash of its code, and its other columns follow from that, from occurrences and uses.
SUMMED = {
    "mesh": (
        "id, sha256, name, author, source, licence, basic_limit, side_limit, convex_limit, "
        "prepared, quads_read, quads_used, basic_patches, side_patches, convex_patches, "
        "distinct_patches, origin, pattern_limit, patterns_left_out, occurrence_sum"
    ),
    "usage": "pattern_id, uses, origin",
}

#: Columns of an occurrence that are hashed, in order.
SUMMED_OCCURRENCE = "pattern_id, patches, mirrored_patches, example"

#: Bytes of a sum.
SIZE = 16

#: Occurrences that are read at a time.
SUMMED_AT_ONCE = 10_000

_MODULUS = 1 << (8 * SIZE)


def sum_rows(rows: Iterable[tuple[Any, ...]]) -> int:
    """Sum the hashes of rows, in whatever order they come."""
    total = 0
    for row in rows:
        # As Python spells them, numbers, texts and bytes differ whatever stands in them.
        word = hashlib.blake2b(repr(row).encode("utf-8", "surrogateescape"), digest_size=SIZE)
        total += int.from_bytes(word.digest(), "big")
    return total % _MODULUS


def select_rows(
    connection: sqlite3.Connection, table: str, where: str = "", values: tuple[Any, ...] = ()
) -> Iterable[tuple[Any, ...]]:
    """Read the rows of a table as they are hashed. where: a condition, or all."""
    condition = f" WHERE {where}" if where else ""
    return connection.execute(f"SELECT {SUMMED[table]} FROM {table}{condition}", values)  # noqa: S608


@contextmanager
def summed(
    connection: sqlite3.Connection, table: str, where: str, values: tuple[Any, ...]
) -> Generator[None]:
    """Bring a table's sum up to date with what the block does to the rows that meet a condition.

    Whether they are added, changed or deleted: they are read before and after.
    """
    before = sum_rows(select_rows(connection, table, where, values))
    yield
    after = sum_rows(select_rows(connection, table, where, values))
    add_to_sum(connection, table, after - before)


def add_to_sum(connection: sqlite3.Connection, table: str, difference: int) -> None:
    """Add to the sum of a table. Raises DatabaseError where the file has none that can be."""
    total = read_sums(connection).get(table)
    if total is None:
        raise DatabaseError(
            f"the file has no checksum of its table {table}: it is damaged; 'patterndb verify' "
            "tells what is wrong"
        )
    write_sum(connection, table, (total + difference) % _MODULUS)


def write_sum(connection: sqlite3.Connection, table: str, total: int) -> None:
    """Write the sum of a table."""
    connection.execute(
        "UPDATE checksum SET total = ? WHERE name = ?", (total.to_bytes(SIZE, "big"), table)
    )


def read_sums(connection: sqlite3.Connection) -> dict[str, int]:
    """Read the sums that stand in the file, by table; what is no sum is left out."""
    rows = connection.execute("SELECT name, total FROM checksum").fetchall()
    return {
        name: int.from_bytes(total, "big")
        for name, total in rows
        if isinstance(total, bytes) and len(total) == SIZE
    }


def write_occurrence_sum(connection: sqlite3.Connection, mesh_id: int, total: int) -> None:
    """Write the sum of a mesh's occurrences into its row; the sum of meshes is left as it is."""
    connection.execute(
        "UPDATE mesh SET occurrence_sum = ? WHERE id = ?",
        ((total % _MODULUS).to_bytes(SIZE, "big"), mesh_id),
    )


def sum_occurrences(connection: sqlite3.Connection) -> dict[int, int]:
    """Sum the occurrences of every mesh anew, by its id: of those meshes that have some."""
    totals: dict[int, int] = {}
    rows = connection.execute(f"SELECT mesh_id, {SUMMED_OCCURRENCE} FROM occurrence")  # noqa: S608
    while some := rows.fetchmany(SUMMED_AT_ONCE):
        of_mesh: dict[int, list[tuple[Any, ...]]] = {}
        for mesh_id, *row in some:
            of_mesh.setdefault(mesh_id, []).append(tuple(row))
        for mesh_id, own in of_mesh.items():
            totals[mesh_id] = (totals.get(mesh_id, 0) + sum_rows(own)) % _MODULUS
    return totals


def sum_tables(connection: sqlite3.Connection) -> None:
    """Sum whole tables anew: where they were filled at once."""
    for mesh_id, total in sum_occurrences(connection).items():
        write_occurrence_sum(connection, mesh_id, total)
    for table in SUMMED:
        write_sum(connection, table, sum_rows(select_rows(connection, table)))


def find_changed_tables(connection: sqlite3.Connection) -> list[str]:
    """Find the tables whose rows are not those that were written, or whose sum is missing."""
    held = read_sums(connection)
    changed = [
        table for table in SUMMED if held.get(table) != sum_rows(select_rows(connection, table))
    ]
    totals = sum_occurrences(connection)
    expected = dict(connection.execute("SELECT id, occurrence_sum FROM mesh").fetchall())
    found = {number: totals.get(number, 0).to_bytes(SIZE, "big") for number in expected | totals}
    return [*changed, "occurrence"] if found != expected else changed
