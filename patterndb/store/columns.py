"""The columns of schema.sql, for the statements that name them all, and what fills them."""

from __future__ import annotations

from collections.abc import Sequence

from patterndb.core import description as d

_MESH = (
    "sha256, name, author, source, licence, basic_limit, side_limit, convex_limit, prepared, "
    "quads_read, quads_used, basic_patches, side_patches, convex_patches, distinct_patches, origin"
)
#: Where the four columns of the learning options stand among those of a mesh.
OPTIONS = slice(5, 9)

#: What follows from a pattern's code; :func:`derived` gives the values.
_DERIVED = (
    "n_sides, corners, n_reflex, n_quads, n_irregular, valences, n_chords, n_loops, "
    "self_crossing, rotations, chiral, label, signature, sig_rotation, sig_reflected, "
    "lengths, joins"
)


def _marks(columns: str) -> str:
    return ", ".join("?" for _ in columns.split(","))


# All put together from the constants above, and from nothing else.
SELECT_MESHES = f"SELECT id, {_MESH} FROM mesh ORDER BY sha256"  # noqa: S608
INSERT_MESH = f"INSERT INTO mesh ({_MESH}) VALUES ({_marks(_MESH)})"  # noqa: S608
SELECT_PATTERNS = f"SELECT id, code, {_DERIVED} FROM pattern"  # noqa: S608
INSERT_PATTERN = (
    f"INSERT INTO pattern (id, code, {_DERIVED}, origin) "  # noqa: S608
    f"VALUES (?, ?, {_marks(_DERIVED)}, ?)"
)
INSERT_OCCURRENCE = (
    "INSERT INTO occurrence (pattern_id, mesh_id, patches, mirrored_patches, example) "
    "VALUES (?, ?, ?, ?, ?)"
)


def derived(counts: Sequence[int], lists: Sequence[bytes]) -> tuple[int | bytes, ...]:
    """The derived columns of a pattern, from its row of counts and its packed lists (see
    :mod:`patterndb.core.description`)."""
    corners, valences, label, signature, lengths, joins = lists
    return (
        counts[d.N_CORNERS],
        corners,
        counts[d.N_REFLEX],
        counts[d.N_QUADS],
        counts[d.N_IRREGULAR],
        valences,
        counts[d.N_CHORDS],
        counts[d.N_LOOPS],
        counts[d.SELF_CROSSING],
        counts[d.ROTATIONS],
        counts[d.CHIRAL],
        label,
        signature,
        counts[d.SIG_ROTATION],
        counts[d.SIG_REFLECTED],
        lengths,
        joins,
    )
