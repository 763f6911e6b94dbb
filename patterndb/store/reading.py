"""What is asked of a database."""

from __future__ import annotations

import sqlite3

import numpy as np
from numpy.typing import NDArray

from patterndb.code import MAX_CLASS
from patterndb.errors import NotFoundError
from patterndb.label import join_matrices
from patterndb.packing import unpack
from patterndb.pattern import Pattern
from patterndb.patternclass import PatternClass
from patterndb.store.records import LearningOptions, Mesh, Occurrence, Provenance


def id_range(n_sides: int) -> tuple[int, int]:
    """Smallest and largest id of the class (of all classes from MAX_CLASS on together)."""
    first = min(n_sides, MAX_CLASS) << 56
    return first, first + (1 << 56) - 1


def pattern_class(connection: sqlite3.Connection, n_sides: int) -> PatternClass:
    """All patterns of ``n_sides`` sides, in default order."""
    low, high = id_range(n_sides)
    rows = connection.execute(
        "SELECT id, frequency, n_irregular, n_quads, valences, n_reflex, corners, n_loops, "
        "chiral, signature_id, sig_rotation, sig_reflected, code FROM pattern "
        "WHERE id BETWEEN ? AND ? AND n_sides = ? ORDER BY n_irregular, frequency DESC, id",
        (low, high, n_sides),
    ).fetchall()
    columns = list(zip(*rows, strict=True)) if rows else [()] * 13
    signatures = connection.execute(
        "SELECT id, lengths, joins FROM signature WHERE id BETWEEN ? AND ? AND n_sides = ? "
        "ORDER BY id",
        (low, high, n_sides),
    ).fetchall()
    signature_ids = np.array([s[0] for s in signatures], np.int64)
    valences = [unpack(v) if v else None for v in columns[4]]
    width = max(n_sides, 1)
    lengths = _flat([s[1] for s in signatures])
    joins = _flat([s[2] for s in signatures])
    lengths = lengths.reshape(-1, width)
    n_joins = lengths.sum(axis=1) // 2
    owner = np.repeat(np.arange(len(signatures)), n_joins)
    return PatternClass(
        n_sides=n_sides,
        ids=np.array(columns[0], np.int64),
        frequency=np.array(columns[1], np.int64),
        n_irregular=np.array(columns[2], np.int32),
        n_quads=np.array(columns[3], np.int32),
        min_valence=np.array([4 if v is None else v[0] for v in valences], np.int32),
        max_valence=np.array([4 if v is None else v[-1] for v in valences], np.int32),
        n_reflex=np.array(columns[5], np.int32),
        corners=_flat(columns[6]).astype(np.uint8).reshape(len(rows), n_sides),
        n_loops=np.array(columns[7], np.int32),
        chiral=np.array(columns[8], np.bool_),
        signature=np.searchsorted(signature_ids, np.array(columns[9], np.int64)).astype(np.int32),
        rotation=np.array(columns[10], np.int32),
        reflected=np.array(columns[11], np.bool_),
        codes=list(columns[12]),
        lengths=lengths,
        joins=join_matrices(n_sides, joins.reshape(-1, 2), owner, len(signatures)),
    )


def _flat(blobs: list[bytes] | tuple[bytes, ...]) -> NDArray[np.int32]:
    """The numbers of many packed blobs, one after the other."""
    return unpack(b"".join(blobs))


_PATTERN = "SELECT code, frequency, origin FROM pattern WHERE id "


def pattern(connection: sqlite3.Connection, name: str) -> Pattern:
    """The pattern whose name (16 hexadecimal digits) begins with ``name``.

    Raises NotFoundError if there is none, or more than one.
    """
    text = name.strip().lower()
    if not text or len(text) > 16 or set(text) - set("0123456789abcdef"):
        raise NotFoundError(f"{name!r} is no pattern name: give 2 to 16 hexadecimal digits")
    low = int(text.ljust(16, "0"), 16)
    high = min(int(text.ljust(16, "f"), 16), 2**63 - 1)
    rows = connection.execute(
        _PATTERN + "BETWEEN ? AND ? LIMIT 2", (min(low, 2**63 - 1), high)
    ).fetchall()
    if not rows:
        raise NotFoundError(f"no pattern's name begins with {name}")
    if len(rows) > 1:
        raise NotFoundError(f"more than one pattern's name begins with {name}; give more digits")
    code, frequency, origin = rows[0]
    return Pattern.from_trusted_code(
        unpack(code).astype(np.uint16), frequency=frequency, origin=origin
    )


def occurrences(connection: sqlite3.Connection, pattern_id: int) -> list[Occurrence]:
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
    (SELECT count(*) FROM occurrence WHERE mesh_id = mesh.id)
FROM mesh
"""


def meshes(connection: sqlite3.Connection) -> list[Mesh]:
    """All meshes, by name."""
    return [_mesh(row) for row in connection.execute(_MESHES + "ORDER BY name, sha256")]


def find_mesh(connection: sqlite3.Connection, sha256: bytes) -> Mesh | None:
    """The mesh of a file with this hash."""
    row = connection.execute(_MESHES + "WHERE sha256 = ?", (sha256,)).fetchone()
    return None if row is None else _mesh(row)


def mesh_ids(connection: sqlite3.Connection, name: str) -> list[int]:
    """Ids of the meshes of this name, or whose SHA-256 begins with it (8 digits and more)."""
    rows = connection.execute("SELECT id FROM mesh WHERE name = ?", (name,)).fetchall()
    if not rows and len(name) >= 8:
        rows = connection.execute(
            "SELECT id FROM mesh WHERE substr(lower(hex(sha256)), 1, ?) = ?",
            (len(name), name.lower()),
        ).fetchall()
    return [row[0] for row in rows]


def _mesh(row: tuple[object, ...]) -> Mesh:
    name, sha256, author, source, licence, basic, side, convex, prepared, *counts = row
    return Mesh(
        str(name),
        bytes(sha256).hex(),  # pyright: ignore[reportArgumentType]
        Provenance(author, source, licence),  # pyright: ignore[reportArgumentType]
        LearningOptions(basic, side, convex, bool(prepared)),  # pyright: ignore[reportArgumentType]
        *counts,  # pyright: ignore[reportArgumentType]
    )


def histogram(connection: sqlite3.Connection, column: str) -> dict[int, int]:
    """Patterns by ``n_sides`` or ``n_irregular``."""
    queries = {
        "n_sides": "SELECT n_sides, count(*) FROM pattern GROUP BY 1 ORDER BY 1",
        "n_irregular": "SELECT n_irregular, count(*) FROM pattern GROUP BY 1 ORDER BY 1",
    }
    return dict(connection.execute(queries[column]).fetchall())
