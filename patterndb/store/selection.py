"""Which patterns occur in meshes of certain names or licences: filters by source."""

from __future__ import annotations

import difflib
import json
import sqlite3
from collections.abc import Sequence
from fnmatch import fnmatchcase

import numpy as np
from numpy.typing import NDArray

from patterndb.errors import NotFoundError
from patterndb.store import reading

#: Names that a message offers where one is unknown.
OFFERED = 3


def pattern_ids(
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
    low, high = reading.id_range(n_sides)
    if meshes is None and licences is None:
        rows = connection.execute(
            "SELECT id FROM pattern WHERE id BETWEEN ? AND ? AND n_sides = ? ORDER BY id",
            (low, high, n_sides),
        )
    else:
        chosen = _chosen(connection, meshes, licences)
        # The rows of one class lie together; only the last class holds several numbers of sides.
        rows = connection.execute(
            "SELECT DISTINCT pattern_id FROM occurrence WHERE pattern_id BETWEEN ? AND ? "
            "AND mesh_id IN (SELECT value FROM json_each(?)) AND (? >> 56 < ? OR "
            "(SELECT n_sides FROM pattern WHERE id = pattern_id) = ?) ORDER BY pattern_id",
            (low, high, json.dumps(sorted(chosen)), low, reading.MAX_CLASS, n_sides),
        )
    return np.array([row[0] for row in rows.fetchall()], np.int64)


def _of_any_class(
    connection: sqlite3.Connection, meshes: Sequence[str] | None, licences: Sequence[str] | None
) -> NDArray[np.int64]:
    if meshes is None and licences is None:
        rows = connection.execute("SELECT id FROM pattern ORDER BY id")
    else:
        rows = connection.execute(
            "SELECT DISTINCT pattern_id FROM occurrence "
            "WHERE mesh_id IN (SELECT value FROM json_each(?)) ORDER BY pattern_id",
            (json.dumps(sorted(_chosen(connection, meshes, licences))),),
        )
    return np.array([row[0] for row in rows.fetchall()], np.int64)


def _chosen(
    connection: sqlite3.Connection, meshes: Sequence[str] | None, licences: Sequence[str] | None
) -> set[int]:
    """Ids of the meshes that meet both."""
    known = connection.execute("SELECT id, name, licence FROM mesh").fetchall()
    chosen = {row[0] for row in known}
    if meshes is not None:
        named: set[int] = set()
        for name in meshes:
            found = reading.mesh_ids(connection, name)
            if not found:
                raise NotFoundError(
                    f"no mesh {name!r}{_near(name, {row[1] for row in known})}; "
                    "'patterndb meshes' lists them"
                )
            named.update(found)
        chosen &= named
    if licences is not None:
        licensed: set[int] = set()
        for pattern in licences:
            wanted = pattern.strip().lower()
            found = [
                number
                for number, _, licence in known
                if licence is not None
                and (licence.lower() == wanted or fnmatchcase(licence.lower(), wanted))
            ]
            if not found:
                raise NotFoundError(
                    f"no mesh has the licence {pattern!r}; there are: {_licences(known)}"
                )
            licensed.update(found)
        chosen &= licensed
    return chosen


def _near(name: str, known: set[str]) -> str:
    """What comes near the name, as a part of a sentence; nothing where nothing does."""
    lower = {one.lower(): one for one in sorted(known)}
    near = difflib.get_close_matches(name.lower(), list(lower), OFFERED)
    near += [one for one in lower if name and name.lower() in one and one not in near]
    if not near:
        return ""
    return " (did you mean " + " or ".join(repr(lower[one]) for one in near[:OFFERED]) + "?)"


def _licences(known: Sequence[tuple[int, str, str | None]]) -> str:
    told = sorted({licence for _, _, licence in known if licence})
    unknown = sum(licence is None for _, _, licence in known)
    return ", ".join([*told, *([f"{unknown} meshes without any"] if unknown else [])]) or "none"
