"""A whole database in a small file: what was learned, without what follows from it.

About a twentieth of the database's size, for shipping; unpacking works out the rest again.
The file is xz-compressed: a line that names the format, one line of JSON (meshes, sizes of
the columns), then columns of packed numbers. Codes are sorted, so that neighbours are alike
and compress well; each mesh then names its patterns by their places in that order.
"""

from __future__ import annotations

import itertools
import json
import lzma
import sqlite3
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from patterndb.core.code import pattern_id
from patterndb.core.packing import pack, pack_many, unpack, unpack_many
from patterndb.errors import DatabaseError
from patterndb.store import writing
from patterndb.store.connection import atomic, connect
from patterndb.store.reading import options_of
from patterndb.store.records import Learned, Provenance
from patterndb.store.writing import SELECT_MESHES

FORMAT = b"patterndb compact 2\n"
#: As version 2, but for the last entry of every mesh, its origin: all were learned.
FORMAT_1 = b"patterndb compact 1\n"

#: Columns of a mesh: places of its patterns (ascending, as differences), patches as the code
#: is and mirrored, numbers in each example, and those numbers.
COLUMNS = ("places", "own", "mirrored", "example_sizes", "examples")


def dump(connection: sqlite3.Connection) -> bytes:
    """The compact file of a database: what was learned, not how often it was used."""
    patterns = connection.execute(
        "SELECT id, n_sides, code FROM pattern WHERE frequency > 0"
    ).fetchall()
    patterns.sort(key=lambda row: (row[1], len(row[2]), row[2]))
    place = {row[0]: i for i, row in enumerate(patterns)}
    codes, offsets = unpack_many([row[2] for row in patterns])
    columns = [
        pack([row[1] for row in patterns]),
        pack(np.diff(offsets) // 4),
        pack(codes),
    ]
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
        meshes.append([sha256.hex(), *fields])
    header = {"meshes": meshes, "columns": [len(c) for c in columns]}
    body = FORMAT + json.dumps(header, ensure_ascii=False).encode() + b"\n" + b"".join(columns)
    return lzma.compress(body, preset=9)


def load(data: bytes, path: Path) -> None:
    """Make the database of a compact file at ``path``, which must not exist.

    Raises DatabaseError if the data is not such a file.
    """
    meshes, columns = _parse(data)
    sides = unpack(columns[0])
    sizes = unpack(columns[1]).astype(np.int64)
    codes = pack_many(unpack(columns[2]), np.r_[0, np.cumsum(4 * sizes)])
    connection = connect(path, "create")
    try:
        # Nothing is lost if this is cut short: the file is thrown away then.
        connection.execute("PRAGMA synchronous = OFF")
        connection.execute("PRAGMA journal_mode = MEMORY")
        with atomic(connection):
            ids = [pattern_id(c, s) for c, s in zip(codes, sides.tolist(), strict=True)]
            writing.add_patterns(connection, ids, codes)
            for i, mesh in enumerate(meshes):
                first = 3 + len(COLUMNS) * i
                _load_mesh(connection, mesh, columns[first : first + len(COLUMNS)], codes, sides)
        connection.execute("VACUUM")
    finally:
        connection.close()


def _parse(data: bytes) -> tuple[list[list[object]], list[bytes]]:
    try:
        body = lzma.decompress(data)
    except lzma.LZMAError as error:
        raise DatabaseError(f"the compact database is damaged ({error})") from error
    if not body.startswith((FORMAT, FORMAT_1)):
        raise DatabaseError("this is not a compact database, or one of another version")
    line, found, _ = body[len(FORMAT) :].partition(b"\n")
    try:
        header = json.loads(line)
        meshes, sizes = header["meshes"], header["columns"]
    except (ValueError, TypeError, KeyError) as error:
        raise DatabaseError(f"the compact database is cut short ({error})") from error
    if body.startswith(FORMAT_1):
        for mesh in meshes:
            mesh.append("learned")
    ends = np.cumsum([len(FORMAT) + len(line) + len(found), *sizes]).tolist()
    if ends[-1] != len(body):
        raise DatabaseError("the compact database is cut short")
    return meshes, [body[a:b] for a, b in itertools.pairwise(ends)]


def _load_mesh(
    connection: sqlite3.Connection,
    mesh: Sequence[object],
    columns: Sequence[bytes],
    codes: list[bytes],
    sides: NDArray[np.int32],
) -> None:
    places = np.cumsum(unpack(columns[0]))
    own, mirrored, sizes = (unpack(c) for c in columns[1:4])
    sha256, name, author, source, licence, basic, side, convex, prepared, *counts, origin = mesh
    learned = Learned(
        *counts,  # pyright: ignore[reportArgumentType]
        codes=[codes[i] for i in places.tolist()],
        sides=sides[places],
        patches=np.stack([own, mirrored], axis=1).astype(np.int64),
        examples=pack_many(unpack(columns[4]), np.r_[0, np.cumsum(sizes, dtype=np.int64)]),
        origin=str(origin),
    )
    writing.add_mesh(
        connection,
        str(name),
        bytes.fromhex(str(sha256)),
        Provenance(author, source, licence),  # pyright: ignore[reportArgumentType]
        options_of(basic, side, convex, prepared),
        learned,
    )
