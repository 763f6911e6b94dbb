"""Keys of the authors' layout: by hand, there and back, and that a key has one meaning."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb._native.core.code import is_disk_code
from patterndb._native.store.ddqkey import smallest_key
from patterndb.core.code import canonical_code
from patterndb.core.quadmesh import QuadMesh
from patterndb.errors import InvalidCodeError
from patterndb.store.ddqkey import Columns, columns_of, fewest_digits, key_text, patch_of_key
from tests.support.meshes import CUP, DOUBLET, ONE, TRIANGLE, disks, grid, star
from tests.support.reference.code import mirrored
from tests.support.reference.halfedge import as_complex, border_loop, fans


def code_of(quads: list[list[int]]) -> np.ndarray:
    return canonical_code(QuadMesh.from_quads(quads).twin)[0]


def keyed(quads: list[list[int]]) -> tuple[str, Columns]:
    faces, twin = smallest_key(code_of(quads), False)
    return key_text(faces), columns_of(twin)


def test_one_quad() -> None:
    assert keyed(ONE) == ("###", Columns("x0000-x0001-x0000-x0001", "", 0, 4, 4, 0))


def test_two_quads_side_by_side() -> None:
    """From one corner of the strip the inner edge is the first after the border edge that
    leaves the corner ("1##..."), from the next it is the second, and that key is less."""
    assert keyed(grid(1, 2)) == (
        "#1####",
        Columns("x0000-x0001x0002-x0000-x0002x0001", "", 0, 4, 6, 0),
    )


def test_the_triangle_of_three() -> None:
    """Face 0 meets 1 and 2 at its first and second edge. Face 1 has its two border edges
    before the one it shares with 2, which has it first. From every corner it is the same."""
    assert keyed(TRIANGLE) == (
        "12###21##",
        Columns("x0000x0001-x0002x0000-x0001x0002", "v0003:0000000000000001", 1, 3, 7, 0),
    )


@pytest.mark.parametrize(
    ("quads", "singularities", "irregular", "corners", "vertices"),
    [
        (star(5), "v0005:0000000000000001", 1, 5, 11),
        (star(6), "v0006:0000000000000001", 1, 6, 13),
        (CUP, "v0003:0000000000000004", 4, 0, 8),
        (DOUBLET, "v0002:0000000000000001", 1, 2, 5),
    ],
)
def test_columns(
    quads: list[list[int]], singularities: str, irregular: int, corners: int, vertices: int
) -> None:
    _, columns = keyed(quads)
    assert columns.singularities == singularities
    assert columns.boundary_ids.count("-") == max(corners, 1) - 1
    found = (columns.n_singularities, columns.n_corners, columns.n_vertices, columns.n_concave)
    assert found == (irregular, corners, vertices, 0)


@given(disks(most=20), st.booleans(), st.integers(0, 3))
def test_there_and_back(twin: list[int], clockwise: bool, more: int) -> None:
    code = canonical_code(np.array(twin, np.int32))[0]
    faces, rooted = smallest_key(code, clockwise)
    n = len(code) // 4
    key = key_text(faces, fewest_digits(n) + more)
    again = patch_of_key(key, n)
    assert again.tolist() == rooted.tolist()
    found, flipped, _, chiral = canonical_code(again)
    assert found.tolist() == code.tolist()
    assert flipped == (clockwise and chiral)
    assert patch_of_key(key.upper(), n).tolist() == rooted.tolist()


@given(disks(most=20))
def test_the_key_is_the_smallest_by_plain_python(twin: list[int]) -> None:
    own = canonical_code(np.array(twin, np.int32))[0]
    for clockwise in (False, True):
        start = (own.astype(np.int64) - 1).tolist()
        disk = mirrored(start) if clockwise else start
        keys = [plain_key(disk, h) for h in plain_starts(disk)]
        faces, rooted = smallest_key(own, clockwise)
        assert key_text(faces, 2) == min(keys)
        assert columns_of(rooted) == plain_columns(rooted.tolist())


def plain_starts(twin: list[int]) -> list[int]:
    quads = as_complex(twin)
    vertex = fans(quads)
    loop = border_loop(quads, twin.index(-1))
    at = [vertex[h] for h in range(len(twin))]
    corners = [h for h in loop if at.count(at[h]) != 2]
    return corners or list(loop)


def plain_key(twin: list[int], start: int) -> str:
    entry = [start]
    number = {start // 4: 0}
    fields: list[int] = []
    for h in entry:
        for r in range(1, 4):
            t = twin[h // 4 * 4 + (h + r) % 4]
            if t >= 0 and t // 4 not in number:
                number[t // 4] = len(number)
                entry.append(t)
            fields.append(-1 if t < 0 else number[t // 4])
    return "".join("##" if f < 0 else f"{f:02x}" for f in fields)


def plain_columns(twin: list[int]) -> Columns:
    quads = as_complex(twin)
    vertex = fans(quads)
    at = [vertex[h] for h in range(len(twin))]
    loop = border_loop(quads, 0)
    names: dict[int, str] = {}
    for h in loop:
        if h not in names:
            label = f"x{len(set(names.values())):04x}"
            names[h] = label
            g = h ^ 2
            while twin[g] >= 0:
                g = twin[g] ^ 2
            names[g] = label
    turns = [at.count(at[h]) for h in loop]
    text = "".join(("-" if turns[i] != 2 and i else "") + names[h] for i, h in enumerate(loop))
    border = {at[h] for h in loop}
    inner = sorted(at.count(v) for v in set(at) - border if at.count(v) != 4)
    return Columns(
        text,
        "-".join(f"v{k:04x}:{inner.count(k):016x}" for k in sorted(set(inner))),
        len(inner),
        sum(k != 2 for k in turns),
        len(set(at)),
        sum(k > 2 for k in turns),
    )


def every_gluing(faces: list[int]) -> Iterator[list[int]]:
    """All ways to pair edges of faces that name each other, known ones by which a face was
    reached aside."""
    n = len(faces) // 3
    twin = [-1] * (4 * n)
    reached = 0
    free: dict[tuple[int, int], list[int]] = {}
    for i, other in enumerate(faces):
        h = 4 * (i // 3) + 1 + i % 3
        if other == reached + 1:
            reached += 1
            twin[h], twin[4 * other] = 4 * other, h
        elif other >= 0:
            free.setdefault((h // 4, other), []).append(h)
    pairs = [p for p in free if p[0] < p[1]]
    ways = [list(itertools.permutations(free[p[::-1]])) for p in pairs]
    for choice in itertools.product(*ways):
        for pair, back in zip(pairs, choice, strict=True):
            for a, b in zip(free[pair], back, strict=True):
                twin[a], twin[b] = b, a
        yield twin


@settings(max_examples=300)
@given(disks(most=9))
def test_of_all_gluings_one_makes_a_disk(twin: list[int]) -> None:
    """What patterndb.store.ddqkey says of keys, tried: so a key has one meaning."""
    faces, rooted = smallest_key(canonical_code(np.array(twin, np.int32))[0], False)
    made = [
        glued.copy()
        for glued in every_gluing(faces.tolist())
        if is_disk_code(np.array(glued, np.int32))
    ]
    assert made == [rooted.tolist()]


@pytest.mark.parametrize("border", ["##", "#0", "0#", " #", "# "])
def test_a_border_may_be_padded(border: str) -> None:
    key = f"{border}{border}01" + 3 * border
    assert patch_of_key(key, 2).tolist() == patch_of_key("##1###", 2).tolist()


@pytest.mark.parametrize(
    ("key", "n_faces", "words"),
    [
        ("", 1, "has 0 characters"),
        ("##", 1, "has 2 characters"),
        ("###", 0, "nFaces is 0"),
        ("###", -1, "nFaces is -1"),
        ("###", 1 << 40, "nFaces is"),
        ("#" * 51, 1, "has 51 characters"),
        ("##g###", 2, "'g' at 2 of topology is no hexadecimal number"),
        ("##-###", 2, "'-' at 2"),
        ("00-1##" * 2, 2, "at 2"),
        ("##2###", 2, "names face 2, but there are 2"),
        ("#####1", 2, "not reached"),
        ("##1##0", 2, "named back"),
        ("#2####1##", 3, "reaches face 2 before face 1"),
        ("0##", 1, "names itself 1 times"),
        ("##1######", 3, "not reached"),
        ("111000", 2, "named back"),
        ("1#1#0#", 2, "do not make a disk"),
        ("١##", 1, "no hexadecimal number"),
    ],
)
def test_what_is_no_key(key: str, n_faces: int, words: str) -> None:
    with pytest.raises(InvalidCodeError, match=words):
        patch_of_key(key, n_faces)


def test_too_few_digits() -> None:
    faces, _ = smallest_key(code_of(grid(1, 17)), False)
    assert len(key_text(faces)) == 2 * 51
    with pytest.raises(ValueError, match="17 faces need 2"):
        key_text(faces, 1)
