"""A whole database in a small file: what was learned, without what follows from it.

About a tenth of the database's size, for shipping. A line names the format, a line of JSON tells
what follows: a block a class (:mod:`patterndb.store.classblocks`), which can be read on its own,
then one block of the meshes and of what each of them holds. The latter is xz-compressed: a line of
JSON (meshes, sizes of the columns), then columns of packed numbers. Patterns are numbered class
by class in the order of the blocks; each mesh names its own by these numbers.
"""

from __future__ import annotations

import itertools
import json
import lzma
import sqlite3
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from patterndb.core.code import pattern_id
from patterndb.core.packing import pack, unpack, unpack_many
from patterndb.core.patternclass import ORIGINS
from patterndb.core.shortcode import shorten
from patterndb.errors import DatabaseError
from patterndb.store import writing
from patterndb.store.checksums import sum_tables
from patterndb.store.classblocks import dump_class, order_codes, parse_columns, split_codes
from patterndb.store.connection import atomic, connect
from patterndb.store.reading import load_class
from patterndb.store.statistics import count_by_sides
from patterndb.store.tallies import tally_anew
from patterndb.store.writing import SELECT_MESHES

FORMAT = b"patterndb compact 3\n"

#: Columns of a mesh: numbers of its patterns (ascending, as differences), patches as the code
#: is and mirrored, numbers in each example, and those numbers.
COLUMNS = ("places", "own", "mirrored", "example_sizes", "examples")

#: Pages are written front to back, and hardly read again.
CACHE_KIB = 8192

#: Patterns that are described and written at a time: some megabytes.
BATCH = 1024

#: Limit of a mesh's patterns, and those left out, where its row does not tell them.
_NO_LIMIT = [0, 0]

Progress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True)
class CompactHead:
    """What the head of a compact file tells.

    classes: by number of sides, ascending, how many patterns there are, and where in the file the
    block begins and ends. meshes: where the block of meshes does.
    """

    classes: dict[int, tuple[int, int, int]]
    meshes: tuple[int, int]


def dump(connection: sqlite3.Connection) -> bytes:
    """The compact file of a database: what was learned, not how often it was used."""
    blocks: list[bytes] = []
    classes: list[list[int]] = []
    place: dict[int, int] = {}
    for n_sides in count_by_sides(connection):
        patterns = load_class(connection, n_sides)
        met = np.flatnonzero(patterns.frequency > 0)
        order = met[order_codes([patterns.codes[i] for i in met.tolist()])]
        if not len(order):
            continue
        for number in patterns.ids[order].tolist():
            place[number] = len(place)
        blocks.append(dump_class(patterns))
        classes.append([n_sides, len(order), len(blocks[-1])])
    blocks.append(_dump_meshes(connection, place))
    head = json.dumps({"classes": classes, "meshes": len(blocks[-1])}).encode()
    return FORMAT + head + b"\n" + b"".join(blocks)


def _dump_meshes(connection: sqlite3.Connection, place: dict[int, int]) -> bytes:
    columns: list[bytes] = []
    meshes: list[list[object]] = []
    for mesh_id, sha256, *fields in connection.execute(SELECT_MESHES):
        rows = connection.execute(
            "SELECT pattern_id, patches - mirrored_patches, mirrored_patches, example "
            "FROM occurrence WHERE mesh_id = ?",
            (mesh_id,),
        ).fetchall()
        rows.sort(key=lambda row: place[row[0]])
        examples, ends = unpack_many([row[3] for row in rows])
        columns += [
            pack(np.diff([place[row[0]] for row in rows], prepend=0)),
            pack([row[1] for row in rows]),
            pack([row[2] for row in rows]),
            pack(np.diff(ends)),
            pack(examples),
        ]
        # Files of meshes without a limit are as before there was one.
        meshes.append([sha256.hex(), *(fields if any(fields[-2:]) else fields[:-2])])
    header = {"meshes": meshes, "columns": [len(c) for c in columns]}
    body = json.dumps(header, ensure_ascii=False).encode() + b"\n" + b"".join(columns)
    return lzma.compress(body, preset=9)


def parse_head(data: bytes) -> CompactHead:
    """The head of a compact file, of its first bytes or all of them.

    Raises DatabaseError if they are not such a file's.
    """
    if not data.startswith(FORMAT):
        raise DatabaseError("this is not a compact database, or one of another version")
    line, found, _ = data[len(FORMAT) :].partition(b"\n")
    try:
        told = json.loads(line)
        at = len(FORMAT) + len(line) + len(found)
        classes: dict[int, tuple[int, int, int]] = {}
        for n_sides, patterns, size in told["classes"]:
            classes[int(n_sides)] = int(patterns), at, at + int(size)
            at += int(size)
        return CompactHead(classes, (at, at + int(told["meshes"])))
    except (ValueError, TypeError, KeyError) as error:
        raise DatabaseError(f"the compact database is cut short ({error})") from error


@dataclass(frozen=True, slots=True)
class PackedMeshes:
    """Meshes of a compact file, in the order in which they were learned.

    rows: of the table mesh, without ids, hashes in hexadecimal. columns: COLUMNS of each.
    """

    rows: list[list[object]]
    columns: list[list[bytes]]

    def places(self, mesh: int) -> NDArray[np.int64]:
        """Numbers of the patterns that a mesh has, ascending."""
        return np.cumsum(unpack(self.columns[mesh][0]), dtype=np.int64)

    def count_patches(self, mesh: int) -> NDArray[np.int64]:
        """Patches of each of these patterns, those that are mirror images among them."""
        _, own, mirrored, *_ = self.columns[mesh]
        return unpack(own).astype(np.int64) + unpack(mirrored)


def parse_meshes(block: bytes) -> PackedMeshes:
    """The block of meshes. Raises DatabaseError where it is damaged."""
    try:
        line, found, body = lzma.decompress(block).partition(b"\n")
        header = json.loads(line)
        rows, sizes = header["meshes"], header["columns"]
        rows = [row + _NO_LIMIT if row[-1] in ORIGINS else row for row in rows]
        ends = np.cumsum([0, *sizes]).tolist()
        if not found or ends[-1] != len(body) or len(sizes) != len(COLUMNS) * len(rows):
            raise ValueError("it is cut short")
    except (lzma.LZMAError, EOFError, ValueError, TypeError, KeyError) as error:
        raise DatabaseError(f"the compact database is damaged ({error})") from error
    columns = [body[a:b] for a, b in itertools.pairwise(ends)]
    step = len(COLUMNS)
    return PackedMeshes(rows, [columns[i : i + step] for i in range(0, len(columns), step)])


def load(data: bytes, path: Path, progress: Progress | None = None) -> None:
    """Make the database of a compact file at ``path``, which must not exist.

    progress: told how many patterns are written, of how many. Raises DatabaseError if the data
    is not such a file.
    """
    head = parse_head(data)
    if head.meshes[1] != len(data):
        raise DatabaseError("the compact database is cut short")
    meshes = parse_meshes(data[slice(*head.meshes)])
    connection = connect(path, "create")
    try:
        # Nothing is lost if this is cut short: the file is thrown away then.
        connection.execute("PRAGMA synchronous = OFF")
        connection.execute("PRAGMA journal_mode = MEMORY")
        connection.execute("PRAGMA temp_store = FILE")  # what sorts the index's rows
        connection.execute(f"PRAGMA cache_size = {-CACHE_KIB:d}")
        with atomic(connection):
            # Rows are written front to back: triggers and indices come when all are there.
            upkeep = connection.execute(
                "SELECT type, name, sql FROM sqlite_schema "
                "WHERE type IN ('trigger', 'index') AND sql IS NOT NULL"
            ).fetchall()
            for kind, name, _ in upkeep:
                connection.execute(f'DROP {kind} "{name}"')
            _fill_tables(connection, data, head, meshes, progress)
            for _, _, statement in upkeep:
                connection.execute(statement)
            sum_tables(connection)
            tally_anew(connection)
    finally:
        connection.close()


def _fill_tables(
    connection: sqlite3.Connection,
    data: bytes,
    head: CompactHead,
    meshes: PackedMeshes,
    progress: Progress | None,
) -> None:
    n_patterns = sum(n for n, _, _ in head.classes.values())
    places = [meshes.places(k) for k in range(len(meshes.rows))]
    if any(len(p) and not 0 <= p[0] <= p[-1] < n_patterns for p in places):
        raise DatabaseError("the compact database is damaged: a mesh has patterns it does not hold")
    mesh_ids: list[int] = []
    frequency = np.zeros(n_patterns, np.int64)
    is_learned = np.zeros(n_patterns, np.bool_)
    for (sha256, *fields), columns, own in zip(meshes.rows, meshes.columns, places, strict=True):
        row = (bytes.fromhex(str(sha256)), *fields)
        mesh_ids.append(connection.execute(writing.INSERT_MESH, row).lastrowid or 0)
        frequency[own] += unpack(columns[1]) + unpack(columns[2])
        is_learned[own] |= fields[-3] == ORIGINS[0]
    total = n_patterns + sum(map(len, places))
    ids = np.empty(n_patterns, np.int64)
    done = 0
    for rows, at in _describe_classes(data, head):
        ids[at] = np.array([row[0] for row in rows], np.int64)
        origins = np.where(is_learned[at], *ORIGINS[:2]).tolist()
        connection.executemany(
            writing.INSERT_COUNTED_PATTERN,
            (
                (*row, origin, patches)
                for row, origin, patches in zip(rows, origins, frequency[at].tolist(), strict=True)
            ),
        )
        done += len(rows)
        if progress is not None:
            progress(done, total)
    for batch in _list_occurrences(meshes, places, ids, mesh_ids):
        connection.executemany(writing.INSERT_OCCURRENCE, batch)
        done += len(batch)
        if progress is not None:
            progress(done, total)


def _describe_classes(
    data: bytes, head: CompactHead
) -> Iterator[tuple[list[tuple[object, ...]], NDArray[np.int64]]]:
    """Patterns as rows of their table, without origin and frequency, in the order of ids, some
    at a time, and their numbers."""
    before = 0
    for n_sides, (_, begin, end) in head.classes.items():
        codes = split_codes(parse_columns(data[begin:end]))
        ids = np.array([pattern_id(code, n_sides) for code in codes], np.int64)
        order = np.argsort(ids)
        for first in range(0, len(codes), BATCH):
            at = order[first : first + BATCH]
            some: list[bytes] = [codes[i] for i in at.tolist()]
            rows: list[tuple[object, ...]] = []
            for number, columns in writing.describe_patterns(shorten(some)):
                if columns[1] != n_sides:
                    raise DatabaseError("the compact database is damaged: a code has other sides")
                rows.append((number, *columns))
            yield rows, before + at
        before += len(codes)


def _list_occurrences(
    meshes: PackedMeshes,
    places: Sequence[NDArray[np.int64]],
    ids: NDArray[np.int64],
    mesh_ids: Sequence[int],
) -> Iterator[list[tuple[int, int, int, int, bytes]]]:
    """All occurrences as rows of their table, in the order of its key, some at a time."""
    owner = np.repeat(np.array(mesh_ids, np.int64), [len(p) for p in places])
    pattern = ids[np.concatenate([np.zeros(0, np.int64), *places])]
    own, mirrored = (
        np.concatenate([np.zeros(0, np.int32), *(unpack(c[k]) for c in meshes.columns)])
        for k in (1, 2)
    )
    # The examples stay in one piece: as objects they would take most of the memory.
    examples = b"".join(columns[4] for columns in meshes.columns)
    cuts = [np.zeros(1, np.int64)]
    for columns in meshes.columns:
        ends = np.r_[0, 1 + np.flatnonzero(np.frombuffer(columns[4], np.uint8) < 128)]
        cuts.append(cuts[-1][-1] + ends[np.cumsum(unpack(columns[3]), dtype=np.int64)])
    byte = np.concatenate(cuts)
    order = np.lexsort((owner, pattern))
    for first in range(0, len(order), BATCH):
        at = order[first : first + BATCH]
        yield list(
            zip(
                pattern[at].tolist(),
                owner[at].tolist(),
                (own[at] + mirrored[at]).tolist(),
                mirrored[at].tolist(),
                [
                    examples[a:b]
                    for a, b in zip(byte[at].tolist(), byte[at + 1].tolist(), strict=True)
                ],
                strict=True,
            )
        )
