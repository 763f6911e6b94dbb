"""Rows of a class are checked as it is loaded: whatever stands in them, no kernel indexes by it."""

from __future__ import annotations

import random
import sqlite3
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import patterndb
from patterndb._native.core.code import code_starts, rooted_code
from patterndb.core.pattern import Pattern
from patterndb.core.patternclass import PatternClass
from patterndb.errors import DatabaseError, InvalidCodeError
from patterndb.store.classes import FOLLOWING
from tests.support.store.learnt import change

#: Wrong values for every column that is read, for a pattern with corners and one without.
WRONG = {
    "code": ["x''", "x'ff'", "x'00000009'", "x'01000000'", "x'00000000'", "code || x'00'", "7"],
    "n_reflex": ["n_reflex + 1", "-1", "1 << 40", "'one'", "NULL", "0.5"],
    "n_quads": ["n_quads + 1", "-1", "1 << 40", "NULL"],
    "n_irregular": ["n_irregular + 1", "-1", "1 << 40", "x'00'"],
    "chiral": ["1 - chiral", "2", "-1"],
}


def spoil(path: Path, row: int, column: str, value: str) -> None:
    """Change a value as a damaged page would, past the checks of the tables."""
    change(
        path,
        "PRAGMA ignore_check_constraints = ON",
        "PRAGMA writable_schema = ON",
        "UPDATE sqlite_schema SET sql = replace(replace(sql, 'STRICT', ''), 'NOT NULL', '') "
        "WHERE name = 'pattern'",
    )
    change(
        path,
        "PRAGMA ignore_check_constraints = ON",
        f"UPDATE pattern SET {column} = {value} WHERE id = {row}",
    )
    connection = sqlite3.connect(path)
    schema = Path(patterndb.__file__).parents[1] / "schema.sql"
    with sqlite3.connect(":memory:") as fresh:
        fresh.executescript(schema.read_text(encoding="utf-8"))
        (sql,) = fresh.execute("SELECT sql FROM sqlite_schema WHERE name = 'pattern'").fetchone()
    connection.execute("PRAGMA writable_schema = ON")
    connection.execute("UPDATE sqlite_schema SET sql = ? WHERE name = 'pattern'", (sql,))
    connection.commit()
    connection.close()


def test_every_column_that_is_checked_is_spoiled_above() -> None:
    assert set(FOLLOWING) <= set(WRONG)


@pytest.mark.parametrize(
    ("column", "value"), [(column, value) for column, values in WRONG.items() for value in values]
)
@pytest.mark.parametrize("n_sides", [0, 5])
def test_a_wrong_row_is_named_with_its_column(
    column: str, value: str, n_sides: int, full: Path
) -> None:
    with patterndb.open(full) as database:
        row = int(database.pattern_class(n_sides).ids[-1])
    spoil(full, row, column, value)
    with patterndb.open(full) as database:
        with pytest.raises(DatabaseError, match=f"pattern {row:016x} is damaged") as caught:
            database.pattern_class(n_sides)
        assert column in str(caught.value)
        assert database.verify()


@pytest.mark.parametrize(
    ("column", "statement"),
    [
        ("frequency", "UPDATE occurrence SET patches = -1000"),
        ("uses", "INSERT INTO usage SELECT id, -1, 'learned' FROM pattern"),
        ("origin", "UPDATE mesh SET origin = 'elsewhere'"),
        ("origin", "DELETE FROM occurrence"),
    ],
)
def test_what_other_tables_have_of_a_pattern_is_checked(
    column: str, statement: str, full: Path
) -> None:
    change(full, "PRAGMA ignore_check_constraints = ON", statement)
    with patterndb.open(full) as database:
        with pytest.raises(DatabaseError, match=f"is damaged: {column}"):
            database.pattern_class(5)
        assert database.verify()


def test_loading_gives_what_describing_anew_gives(full: Path) -> None:
    with patterndb.open(full) as database:
        for n_sides in database.sides_histogram():
            loaded = database.pattern_class(n_sides)
            patterns = [loaded.pattern(row) for row in range(len(loaded))]
            made = PatternClass.from_patterns(n_sides, patterns)
            for name in ("ids", "corners", "words", "word_start", "signature", "rotation"):
                assert np.array_equal(getattr(loaded, name), getattr(made, name)), name
            for name in ("reflected", "lengths", "joins", "n_loops", "min_valence", "max_valence"):
                assert np.array_equal(getattr(loaded, name), getattr(made, name)), name


def test_no_changed_byte_of_a_code_is_believed(full: Path) -> None:
    """Every answer is as it was, or an error of ours: the loaded arrays never differ unseen."""
    chance = random.Random(5)
    connection = sqlite3.connect(full)
    for _ in range(150):
        number, blob = connection.execute(
            "SELECT id, code FROM pattern WHERE n_sides = 5 ORDER BY random() LIMIT 1"
        ).fetchone()
        at = chance.randrange(len(blob))
        spoiled = blob[:at] + bytes([blob[at] ^ chance.randrange(1, 256)]) + blob[at + 1 :]
        connection.execute("UPDATE pattern SET code = ? WHERE id = ?", (spoiled, number))
        connection.commit()
        with patterndb.open(full) as database, pytest.raises(DatabaseError, match=f"{number:016x}"):
            database.pattern_class(5)
        connection.execute("UPDATE pattern SET code = ? WHERE id = ?", (blob, number))
        connection.commit()
    connection.close()


def test_a_code_that_is_no_disk_is_told_by_name_when_its_pattern_is_made(full: Path) -> None:
    with patterndb.open(full) as database:
        patterns = database.pattern_class(4)
    # Canonical it is not: the corner that it begins at is another.
    other = next(
        (row, bytes(turned.tolist()))
        for row in range(len(patterns))
        if patterns.rotations[row] == 1
        for turned in [_begin_elsewhere(patterns.pattern(row))]
        if turned is not None
    )
    row, code = other
    codes = list(patterns.codes)
    codes[row] = code
    patterns = replace(patterns, codes=codes)
    with pytest.raises(InvalidCodeError, match=f"{int(patterns.ids[row]):016x}"):
        patterns.pattern(row)


def _begin_elsewhere(pattern: Pattern) -> np.ndarray | None:
    """Another, larger code of the same disk; None where all codes are equal."""

    twin = pattern.twin()
    q = len(twin) // 4
    starts = np.empty(4 * q, np.int32)
    for start in starts[: code_starts(twin, starts)].tolist():
        code = np.zeros(4 * q, np.uint16)
        rooted_code(twin, q, start, False, code, *(np.empty(q, np.int32) for _ in range(3)), False)
        if not np.array_equal(code, pattern.code):
            return code
    return None
