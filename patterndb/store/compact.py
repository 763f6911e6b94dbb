"""A whole database in a small file: what was learned, without what follows from it.

About a tenth of the database's size, for shipping. A line names the format, a line of JSON has the
sizes of what follows: a block a class (:func:`patterndb.store.classes.dump_class`), which can be
read on its own, then a block of the meshes and of what each of them holds. Patterns are numbered
class by class in the order of the blocks; each mesh names its own by these numbers.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from patterndb.core.packing import PackedRows
from patterndb.core.shortcode import shorten
from patterndb.errors import DatabaseError
from patterndb.store.classes import (
    dump_block,
    dump_class,
    load_class,
    parse_block,
    parse_codes,
)
from patterndb.store.connection import atomic, connect
from patterndb.store.reading import list_sides, select_meshes
from patterndb.store.records import INSERT_OCCURRENCE, INSERT_PATTERN, Mesh, OccurrenceRow
from patterndb.store.writing import describe_patterns, insert_mesh

FORMAT = b"patterndb compact 1\n"

#: Pages are written front to back, and hardly read again.
CACHE_KIB = 8192

#: Rows that are described and written at a time: some megabytes.
BATCH = 1024

Progress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True)
class CompactHead:
    """What the head of a compact file holds.

    classes: by number of sides, ascending, how many patterns there are, and where in the file the
    block begins and ends. meshes: where the block of meshes does.
    """

    classes: dict[int, tuple[int, int, int]]
    meshes: tuple[int, int]


@dataclass(frozen=True, slots=True, eq=False)
class CompactMeshes:
    """Meshes of a compact file, and their o occurrences, mesh by mesh, by number of pattern.

    rows: values of the table mesh by column, bytes in hexadecimal, with ``patterns``.
    owner, place: (o,) int64 numbers of the mesh, from 0, and of the pattern.
    patches, mirrored: (o,) int64 all patches, and those that are mirror images.
    examples: o packed examples.
    """

    rows: list[dict[str, Any]]
    owner: NDArray[np.int64]
    place: NDArray[np.int64]
    patches: NDArray[np.int64]
    mirrored: NDArray[np.int64]
    examples: PackedRows

    def make_mesh(self, number: int) -> Mesh:
        """Make the mesh of a row."""
        row = self.rows[number]
        return Mesh.from_columns({**row, "sha256": bytes.fromhex(row["sha256"])})


def dump(connection: sqlite3.Connection) -> bytes:
    """Return the compact file of a database: what was learned, not how often it was used."""
    blocks: list[bytes] = []
    classes: list[list[int]] = []
    numbered: list[NDArray[np.int64]] = []
    for n_sides in list_sides(connection):
        ids, block = dump_class(load_class(connection, n_sides))
        if len(ids):
            numbered.append(ids)
            blocks.append(block)
            classes.append([n_sides, len(ids), len(block)])
    blocks.append(_dump_meshes(connection, np.concatenate([np.zeros(0, np.int64), *numbered])))
    head = json.dumps({"classes": classes, "meshes": len(blocks[-1])}).encode()
    return FORMAT + head + b"\n" + b"".join(blocks)


def _dump_meshes(connection: sqlite3.Connection, ids: NDArray[np.int64]) -> bytes:
    """Dump meshes with their occurrences; a pattern's number is the place of its id in ``ids``."""
    by_id = np.argsort(ids)
    rows: list[dict[str, Any]] = []
    parts: list[NDArray[np.int64]] = []
    examples: list[bytes] = []
    for row in select_meshes(connection, "ORDER BY sha256"):
        row = {k: v.hex() if isinstance(v, bytes) else v for k, v in row.items()}
        mesh_id = row.pop("id")
        rows.append(row)
        held = connection.execute(
            "SELECT pattern_id, patches, mirrored_patches, example FROM occurrence "
            "WHERE mesh_id = ?",
            (mesh_id,),
        ).fetchall()
        if not held:
            continue
        pattern_ids, patches, mirrored, own = zip(*held, strict=True)
        place = by_id[np.searchsorted(ids, np.array(pattern_ids, np.int64), sorter=by_id)]
        order = np.argsort(place)
        columns = np.array([place, patches, mirrored], np.int64)[:, order]
        columns[0] = np.diff(columns[0], prepend=0)
        parts.append(columns)
        examples += [own[k] for k in order.tolist()]
    step, patches, mirrored = np.concatenate([np.zeros((3, 0), np.int64), *parts], axis=1)
    packed = PackedRows.of(examples)
    arrays = {
        "step": step,
        "own": patches - mirrored,
        "mirrored": mirrored,
        "example_sizes": np.diff(packed.ends),
        "examples": packed.raw,
    }
    return dump_block(arrays, rows)


def parse_head(data: bytes) -> CompactHead:
    """Return the head of a compact file, of its first bytes or all of them.

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


def parse_meshes(block: bytes) -> CompactMeshes:
    """Return what the block of meshes holds. Raises DatabaseError where it is damaged."""
    arrays, rows = parse_block(block)
    try:
        sizes = np.array([row["patterns"] for row in rows], np.int64)
        begins = np.cumsum(sizes) - sizes
        # Numbers are differences within each mesh.
        place = np.cumsum(arrays["step"])
        before = np.r_[0, place][begins]
        mirrored = arrays["mirrored"]
        return CompactMeshes(
            rows,
            np.repeat(np.arange(len(rows)), sizes),
            place - np.repeat(before, sizes),
            arrays["own"] + mirrored,
            mirrored,
            PackedRows(arrays["examples"], np.cumsum(np.r_[0, arrays["example_sizes"]])),
        )
    except (ValueError, TypeError, KeyError, IndexError) as error:
        raise DatabaseError(f"the compact database is damaged ({error})") from error


def load(data: bytes, path: Path, progress: Progress | None = None) -> None:
    """Make the database of a compact file at ``path``, which must not exist.

    progress: called with the number of rows written, and of all. Raises DatabaseError if the data
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
        connection.execute(f"PRAGMA cache_size = {-CACHE_KIB:d}")
        with atomic(connection):
            _fill_tables(connection, data, head, meshes, progress)
    finally:
        connection.close()


def _fill_tables(
    connection: sqlite3.Connection,
    data: bytes,
    head: CompactHead,
    meshes: CompactMeshes,
    progress: Progress | None,
) -> None:
    n_patterns = sum(n for n, _, _ in head.classes.values())
    if len(meshes.place) and not 0 <= meshes.place.min() <= meshes.place.max() < n_patterns:
        raise DatabaseError("the compact database is damaged: a mesh has patterns it does not hold")
    mesh_ids = [
        insert_mesh(connection, meshes.make_mesh(k), bytes.fromhex(row["occurrence_sum"]))
        for k, row in enumerate(meshes.rows)
    ]
    total = n_patterns + len(meshes.place)
    # Rows are written in the order of their keys, front to back.
    numbered: list[NDArray[np.int64]] = [np.zeros(0, np.int64)]
    done = 0
    for n_sides, (_, begin, end) in head.classes.items():
        codes = parse_codes(data[begin:end])
        rows = [
            row
            for first in range(0, len(codes), BATCH)
            for row in describe_patterns(shorten(codes[first : first + BATCH]))
        ]
        if any(row.n_sides != n_sides for row in rows):
            raise DatabaseError("the compact database is damaged: a code has other sides")
        numbered.append(np.array([row.id for row in rows], np.int64))
        connection.executemany(INSERT_PATTERN, sorted(rows))
        done += len(rows)
        if progress is not None:
            progress(done, total)
    pattern_ids = np.concatenate(numbered)[meshes.place]
    owners = np.array(mesh_ids, np.int64)[meshes.owner]
    order = np.lexsort((owners, pattern_ids))
    for first in range(0, len(order), BATCH):
        at = order[first : first + BATCH]
        columns = (pattern_ids, owners, meshes.patches, meshes.mirrored)
        rows = zip(
            *(column[at].tolist() for column in columns), meshes.examples.take(at), strict=True
        )
        connection.executemany(INSERT_OCCURRENCE, map(OccurrenceRow._make, rows))
        done += len(at)
        if progress is not None:
            progress(done, total)
