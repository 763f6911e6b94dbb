"""verify() finds nothing on sound databases, and each of many ways to spoil one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from patterndb.core.code import canonical_code, pattern_id
from patterndb.core.packing import pack, unpack
from patterndb.core.quadmesh import QuadMesh
from patterndb.core.shortcode import shorten
from patterndb.errors import DatabaseError
from patterndb.store import Database
from patterndb.store.connection import atomic
from patterndb.store.verification import (
    LARGEST_FACE,
    MAX_FINDINGS,
    are_examples_sound,
    check_code,
    describe_sound,
)
from patterndb.store.writing import add_patterns
from tests.support.meshes import SHAPES, grid
from tests.support.store.learnt import change, content

ONE_PATTERN = "WHERE id = (SELECT min(id) FROM pattern WHERE n_irregular = 1)"


def findings(path: Path) -> list[str]:
    with Database(path) as db:
        return db.verify()


def code_of(name: str) -> bytes:
    return pack(canonical_code(QuadMesh.from_quads(SHAPES[name]).twin)[0])


def short_of(name: str) -> bytes:
    (short,) = shorten([code_of(name)])
    return short


def test_a_sound_database_has_no_findings(full: Path) -> None:
    assert findings(full) == []


#: A false but lawful value for every column of pattern that follows from its code.
COLUMNS = {
    "n_sides": "n_sides + 1",
    "n_reflex": "1 - min(n_reflex, 1)",
    "n_quads": "n_quads + 1",
    "n_irregular": "n_irregular + 1",
    "chiral": "1 - chiral",
    "signature": "x'00'",
}


def test_every_column_that_follows_from_the_code_is_spoiled_below(full: Path) -> None:
    with Database(full) as db:
        described = db._connection.execute("SELECT name FROM pragma_table_info('pattern')")
        assert {row[0] for row in described} - set(COLUMNS) == {"id", "code"}


@pytest.mark.parametrize("column", COLUMNS)
def test_a_changed_column_is_found(full: Path, column: str) -> None:
    change(full, f"UPDATE pattern SET {column} = {COLUMNS[column]} {ONE_PATTERN}")
    # The quads of an example are counted, too, and its mirror images, and patterns of a kind.
    words = {"n_quads": "fewer than the pattern", "chiral": "is its own mirror image"}
    counts = "of its patterns", "tallies cannot be read"
    first, *others = sorted(findings(full), key=lambda finding: "columns" not in finding)
    assert "columns that do not follow from its code" in first
    for finding in others:
        assert any(word in finding for word in (words.get(column, counts[0]), *counts))


#: What may stand in place of a code, and what is said of it.
CODES = {
    "another pattern": (short_of("star 6"), "do not follow from its code"),
    "nothing": (b"", "is no code"),
    "half a number": (b"\x00\x00\x00\x85", "is no code"),
    "a number in two ways": (b"\x00\x00\x00\x80\x00", "is no code"),
    "half a quad": (b"\x00\x00", "is no code"),
    "an edge beyond": (bytes([9, 0, 0, 0]), "is no code"),
    "an edge named twice": (bytes([0, 2, 1, 0]), "is no code"),
    "no disk": (short_of("ring"), "not a disk"),
    "not the smallest": (shorten([bytes([5, 0, 0, 0, 1, 0, 0, 0])])[0], "not canonical"),
    "not reduced": (
        shorten([pack(canonical_code(QuadMesh.from_quads(grid(2, 2)).twin)[0])])[0],
        "can be reduced further",
    ),
}


@pytest.mark.parametrize("name", CODES)
def test_a_changed_code_is_found(full: Path, name: str) -> None:
    code, message = CODES[name]
    change(full, f"UPDATE pattern SET code = x'{code.hex()}' {ONE_PATTERN}")
    (finding,) = findings(full)
    assert message in finding


@given(st.lists(st.sampled_from(["star 6", "one", *CODES]), max_size=12))
def test_many_codes_are_judged_as_each_by_itself(names: list[str]) -> None:
    codes = [CODES[name][0] if name in CODES else short_of(name) for name in names]
    codes += [None, 7, "x"][: len(codes) % 4]  # pyright: ignore[reportAssignmentType, reportOperatorIssue]
    together = describe_sound(codes)
    for code, told in zip(codes, together, strict=True):
        (alone,) = describe_sound([code])
        if isinstance(told, Exception):
            assert (type(told), str(told)) == (type(alone), str(alone))
            with pytest.raises(type(told)):
                check_code(code)
        else:
            assert told == alone
            check_code(code)


@given(
    st.lists(
        st.tuples(st.lists(st.integers(0, 3), max_size=4).map(pack), st.integers(0, 4))
        | st.tuples(st.sampled_from([b"\x80", None, 3, pack([2**31 - 1, 1])]), st.just(0)),
        max_size=6,
    )
)
def test_many_examples_are_judged_as_each_by_itself(examples: list[tuple[object, int]]) -> None:
    def is_sound(example: object, fewest: int) -> bool:
        if not isinstance(example, bytes) or example[-1:] >= b"\x80":
            return False
        faces = np.cumsum(unpack(example), dtype=np.int64)
        return (
            len(faces) >= fewest
            and bool((np.diff(faces) > 0).all())
            and int(faces.max(initial=0)) < LARGEST_FACE
        )

    expected = all(is_sound(*one) for one in examples)
    held = [example for example, _ in examples]
    assert are_examples_sound(held, [fewest for _, fewest in examples]) == expected


#: Statements, and words of the finding.
ROWS = {
    "occurrence gone": (
        "DELETE FROM occurrence WHERE pattern_id = (SELECT min(pattern_id) FROM occurrence)",
        "but counted",
    ),
    "patches": (
        "UPDATE occurrence SET patches = patches + 1 "
        "WHERE pattern_id = (SELECT min(pattern_id) FROM occurrence)",
        "but counted",
    ),
    "mesh total": (
        "UPDATE mesh SET distinct_patches = distinct_patches + 1 WHERE name = 'cup.obj'",
        "cup.obj",
    ),
    "mesh gone": ("DELETE FROM mesh WHERE name = 'cup.obj'", "missing"),
    "pattern gone": (f"DELETE FROM pattern {ONE_PATTERN}", "missing"),
    "id": (f"UPDATE pattern SET id = id + 1 {ONE_PATTERN}", "do not follow"),
    "use of nothing": ("INSERT INTO usage VALUES (1, 1, 'learned')", "missing"),
}


@pytest.mark.parametrize("name", ROWS)
def test_a_changed_row_is_found(full: Path, name: str) -> None:
    statement, words = ROWS[name]
    change(full, statement)
    found = findings(full)
    assert any(words in finding for finding in found), found


def test_a_pattern_in_no_mesh_is_found(full: Path) -> None:
    code = code_of("star 6")
    with Database(full, "write") as db, atomic(db._connection) as connection:
        connection.execute("DELETE FROM pattern WHERE code = ?", (short_of("star 6"),))
        add_patterns(connection, [pattern_id(code, 6)], [code])
    assert any("occurs in no mesh and was never used" in finding for finding in findings(full))


def test_a_damaged_page_is_found(full: Path) -> None:
    """By verify(), or on opening where the schema lies on it."""
    data = full.read_bytes()
    size = int.from_bytes(data[16:18], "big")
    for start in range(size, len(data), size):
        full.write_bytes(data[:start] + b"\xff" * 64 + data[start + 64 :])
        try:
            assert findings(full) != [], f"page {start // size + 1} is damaged"
        except DatabaseError as error:
            assert "is damaged" in str(error)


def test_findings_end_somewhere(full: Path) -> None:
    with Database(full) as db:
        patterns = db.statistics().patterns
    assert patterns > 10
    change(full, "UPDATE pattern SET signature = x'00'")
    assert len(findings(full)) == min(MAX_FINDINGS, patterns)


def test_two_codes_of_one_id_are_refused(full: Path) -> None:
    before = content(full)
    with Database(full, "write") as db:
        number = db._connection.execute("SELECT min(id) FROM pattern").fetchone()[0]
        with (
            pytest.raises(DatabaseError, match="collide"),
            atomic(db._connection) as connection,
        ):
            add_patterns(connection, [number], [code_of("star 6")])
    assert content(full) == before


def test_no_pattern_that_is_its_own_mirror_image_has_mirrored_patches(full: Path) -> None:
    with Database(full) as db:
        symmetric = db._connection.execute(
            "SELECT sum(mirrored_patches), count(*) FROM occurrence "
            "JOIN pattern ON id = pattern_id WHERE chiral = 0"
        ).fetchone()
    assert symmetric[0] == 0 < symmetric[1]


#: Statements that leave what no column may hold, past the checks of the tables.
UNLAWFUL = {
    "options out of range": "UPDATE mesh SET basic_limit = 1 << 40",
    "text that is none": "UPDATE mesh SET author = CAST(x'ff' AS TEXT)",
    "a short hash": "UPDATE mesh SET sha256 = x'00' WHERE name = 'cup.obj'",
    "an example cut short": "UPDATE occurrence SET example = x'ff'",
    "an example of no quads": "UPDATE occurrence SET example = x''",
    "an example that stands still": "UPDATE occurrence SET example = x'0000'",
    "patches by modes": "UPDATE mesh SET convex_patches = distinct_patches + 1",
    "a use of no origin": f"INSERT INTO usage SELECT id, 1, 'x' FROM pattern {ONE_PATTERN}",
    "an empty code": "UPDATE pattern SET code = x''",
    "huge symbols": "UPDATE pattern SET code = x'ffffffffffffffff7f'",
    "an id below 0": f"UPDATE pattern SET id = -5 {ONE_PATTERN}",
    "mirror images": "UPDATE occurrence SET mirrored_patches = 1 WHERE pattern_id IN "
    "(SELECT id FROM pattern WHERE chiral = 0)",
}


@pytest.mark.parametrize("name", UNLAWFUL)
def test_verify_ends_in_findings_whatever_stands_there(full: Path, name: str) -> None:
    change(full, "PRAGMA ignore_check_constraints = ON", UNLAWFUL[name])
    assert findings(full)


@pytest.mark.parametrize(
    "statement",
    [
        *(statement for statement, _ in ROWS.values()),
        *UNLAWFUL.values(),
        "UPDATE mesh SET distinct_patches = 127",
        "UPDATE mesh SET pattern_limit = 1",
        "UPDATE mesh SET patterns_left_out = 1",
        "UPDATE occurrence SET mirrored_patches = patches",
        "UPDATE pattern SET n_quads = n_quads + 1",
    ],
)
def test_what_verify_finds_is_not_merged(statement: str, full: Path, tmp_path: Path) -> None:
    change(full, "PRAGMA ignore_check_constraints = ON", statement)
    with Database(full) as other, Database(tmp_path / "new.db", "create") as db:
        empty = db.content_hash()
        found = other.verify()
        assert found
        with pytest.raises(DatabaseError, match="--repair"):
            db.merge(other)
        assert db.content_hash() == empty
        assert db.verify() == []
