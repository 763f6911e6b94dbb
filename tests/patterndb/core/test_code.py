from __future__ import annotations

import itertools
import random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from patterndb._native.core.code import clockwise_start, is_disk_code, rooted_code
from patterndb.core.code import MAX_QUADS, canonical_code, decode, pattern_id
from patterndb.core.disk import Disk
from patterndb.core.packing import pack
from patterndb.core.pattern import Pattern
from patterndb.core.quadmesh import QuadMesh
from patterndb.errors import InvalidCodeError, PatternDBError
from tests.support.meshes import CUBE, ONE, SHAPES, disks, grid, star
from tests.support.reference import code as reference
from tests.support.reference.halfedge import as_complex, components


def array(twin: list[int]) -> NDArray[np.int32]:
    return np.array(twin, np.int32)


def read_from(twin: list[int], h: int, clockwise: bool = False) -> tuple[int, ...]:
    n = len(twin) // 4
    code = np.zeros(4 * n, np.uint16)
    scratch = [np.empty(n, np.int32) for _ in range(3)]
    assert rooted_code(array(twin), n, h, clockwise, code, *scratch, False) == -1
    return tuple(code.tolist())


def renumbered(twin: list[int], chance: random.Random) -> list[int]:
    """The same disk with its quads in another order and their edges turned."""
    n = len(twin) // 4
    place = list(range(n))
    chance.shuffle(place)
    turn = [chance.randrange(4) for _ in range(n)]

    def name(h: int) -> int:
        return 4 * place[h // 4] + (h + turn[h // 4]) % 4

    result = [-1] * len(twin)
    for h, t in enumerate(twin):
        result[name(h)] = name(t) if t >= 0 else -1
    return result


@given(disks(), st.data())
def test_a_rooted_code_is_the_reference_s(twin: list[int], data: st.DataObject) -> None:
    h = data.draw(st.sampled_from([h for h, t in enumerate(twin) if t < 0]))
    assert read_from(twin, h) == reference.rooted_code(twin, h)
    seen_in_mirror = reference.rooted_code(reference.mirrored(twin), reference.flip(h))
    assert read_from(twin, h, clockwise=True) == seen_in_mirror


@given(disks())
def test_clockwise_starts_are_the_border_edges_of_the_mirror_image(twin: list[int]) -> None:
    mirror = reference.mirrored(twin)
    starts = {int(clockwise_start(array(twin), h)) for h in reference.code_starts(twin)}
    assert {reference.flip(h) for h in starts} == set(reference.code_starts(mirror))


@given(disks())
def test_the_canonical_code_is_the_reference_s(twin: list[int]) -> None:
    code, mirrored, rotations, chiral = canonical_code(array(twin))
    assert (tuple(code.tolist()), mirrored, rotations, chiral) == reference.canonical_code(twin)


@given(disks(), st.randoms(), st.booleans())
def test_numbering_and_mirror_image_do_not_change_the_code(
    twin: list[int], chance: random.Random, mirror: bool
) -> None:
    code, mirrored, rotations, chiral = canonical_code(array(twin))
    other = renumbered(reference.mirrored(twin) if mirror else twin, chance)
    again, now_mirrored, *symmetry = canonical_code(array(other))
    np.testing.assert_array_equal(again, code)
    assert symmetry == [rotations, chiral]
    assert now_mirrored == (chiral and mirrored != mirror)


@given(disks(), disks())
def test_codes_are_equal_exactly_where_disks_are_isomorphic(a: list[int], b: list[int]) -> None:
    equal = canonical_code(array(a))[0].tolist() == canonical_code(array(b))[0].tolist()
    assert equal == reference.isomorphic(a, b)


@given(disks())
def test_encode_decode_encode_is_the_identity(twin: list[int]) -> None:
    code, *flags = canonical_code(array(twin))
    decoded = decode(code)
    assert read_from(decoded.tolist(), 0) == tuple(code.tolist())
    again, mirrored, *rest = canonical_code(decoded)
    np.testing.assert_array_equal(again, code)
    assert (mirrored, rest) == (False, flags[1:])
    assert reference.isomorphic(decoded.tolist(), twin)


@given(disks(), st.randoms())
def test_a_code_read_from_anywhere_decodes(twin: list[int], chance: random.Random) -> None:
    h = chance.randrange(len(twin))
    code = reference.rooted_code(twin, h)
    assert reference.rooted_code(decode(np.array(code, np.uint16)).tolist(), 0) == code


def decodes(symbols: list[int]) -> bool:
    """Is the list accepted? If so it must be what it says."""
    try:
        twin = decode(np.array(symbols, np.int64)).tolist()
    except InvalidCodeError:
        return False
    assert len(twin) == len(symbols)
    assert all(twin[t] == h and t != h for h, t in enumerate(twin) if t >= 0), "not pairs of edges"
    assert set(components(as_complex(twin)).values()) == {0}
    assert reference.rooted_code(twin, 0) == tuple(symbols)
    return True


@given(st.lists(st.integers(0, 40), max_size=40))
def test_a_list_decodes_to_half_edges_or_is_refused(symbols: list[int]) -> None:
    decodes(symbols)


@given(st.lists(st.integers(-(2**62), 2**62), max_size=12))
def test_any_numbers_decode_or_are_refused(symbols: list[int]) -> None:
    decodes(symbols)


@given(disks(), st.data())
def test_a_damaged_code_decodes_or_is_refused(twin: list[int], data: st.DataObject) -> None:
    symbols = list(reference.own_code(twin))
    for _ in range(data.draw(st.integers(1, 3))):
        at = data.draw(st.integers(0, len(symbols) - 1))
        symbols[at] = data.draw(st.integers(0, len(symbols) + 4))
    decodes(symbols)


def all_codes(n: int) -> list[list[int]]:
    """Every list of symbols for n quads."""
    lists: list[list[int]] = [[]]
    for _ in range(4 * n):
        lists = [[*code, symbol] for code in lists for symbol in range(4 * n + 1)]
    return lists


def test_of_all_lists_for_one_quad_those_that_pair_its_edges_decode() -> None:
    accepted = [code for code in all_codes(1) if decodes(code)]
    # Ten ways to pair none, two or four of four edges.
    assert len(accepted) == 10


@pytest.mark.parametrize(
    ("symbols", "message"),
    [
        ([], "four symbols a quad"),
        ([0, 0, 0], "four symbols a quad"),
        ([0, 0, 0, 0, 0], "four symbols a quad"),
        ([5, 0, 0, 0], "symbol 0 names quad 1, but the code has 1"),
        ([5, 0, 0, 0, 0, 0, 0, 0], "does not name it back"),
        ([0, 0, 0, 0, 0, 0, 0, 0], "quad 1 is not reached"),
        ([6, 0, 0, 0, 0, 1, 0, 0], "first to reach quad 1"),
        ([9, 5, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0], "first to reach quad 1"),
    ],
)
def test_why_a_list_is_refused(symbols: list[int], message: str) -> None:
    with pytest.raises(InvalidCodeError, match=message):
        decode(np.array(symbols, np.uint16))


def test_an_edge_glued_to_itself_is_refused() -> None:
    with pytest.raises(InvalidCodeError):
        decode(np.array([1, 0, 0, 0], np.uint16))


def test_a_symbol_below_zero_is_refused() -> None:
    with pytest.raises(InvalidCodeError):
        decode(np.array([-100, 0, 0, 0], np.int64))


def test_a_closed_surface_has_no_code() -> None:
    with pytest.raises(InvalidCodeError, match="no border"):
        canonical_code(QuadMesh.from_quads(CUBE).twin)


def test_a_code_names_no_more_than_max_quads() -> None:
    strip = QuadMesh.from_quads(grid(1, MAX_QUADS)).twin
    code = canonical_code(strip)[0]
    # The last quad but one of a strip is named by the last.
    assert code.max() == 1 + 4 * (MAX_QUADS - 1)
    np.testing.assert_array_equal(canonical_code(decode(code))[0], code)
    longer = QuadMesh.from_quads(grid(1, MAX_QUADS + 1)).twin
    with pytest.raises(InvalidCodeError, match=str(MAX_QUADS + 1)):
        canonical_code(longer)


def test_ids_tell_the_class_and_do_not_depend_on_how_the_code_is_given() -> None:
    code = canonical_code(QuadMesh.from_quads(star(5)).twin)[0]
    assert pattern_id(code, 5) == pattern_id(pack(code), 5)
    assert pattern_id(code, 5) >> 56 == 5
    assert pattern_id(code, 5) != pattern_id(canonical_code(array([-1] * 4))[0], 5)
    assert pattern_id(b"x", 126) >> 56 == 126
    assert {pattern_id(b"x", n) for n in (127, 128, 999)} == {pattern_id(b"x", 127)}
    assert 0 <= pattern_id(b"x", 999) < 2**63


@given(disks())
def test_a_pattern_is_made_of_its_canonical_code_alone(twin: list[int]) -> None:
    code = canonical_code(array(twin))[0]
    assert Pattern.from_code(code).name == Pattern.from_disk(array(twin)).name
    for h in reference.code_starts(twin):
        other = np.array(reference.rooted_code(twin, h), np.uint16)
        if other.tolist() != code.tolist():
            with pytest.raises(InvalidCodeError, match="not canonical"):
                Pattern.from_code(other)
            break


@pytest.mark.parametrize("name", ["ring", "tube", "windowed"])
def test_what_is_no_disk_makes_no_pattern(name: str) -> None:
    code = canonical_code(QuadMesh.from_quads(SHAPES[name]).twin)[0]
    with pytest.raises(InvalidCodeError):
        Pattern.from_code(code)


def test_the_smallest_pattern() -> None:
    pattern = Pattern.from_disk(QuadMesh.from_quads(ONE).twin)
    assert pattern.code.tolist() == [0, 0, 0, 0]
    assert (pattern.n_sides, pattern.corners, pattern.rotations) == (4, (1, 1, 1, 1), 4)
    assert (pattern.chiral, pattern.label) == (False, ((0,), (1,), (0,), (1,)))


def test_is_disk_code_agrees_with_decoding_and_the_disk_it_makes() -> None:
    """Every list of symbols for one quad and a random many for more, sound or not."""
    generator = np.random.default_rng(20)
    lists = [np.array(t) for t in itertools.product(range(6), repeat=4)]
    for n in (2, 3, 4):
        sound = _some_codes(n)
        for _ in range(2000):
            code = sound[generator.integers(len(sound))].astype(np.int64).copy()
            code[generator.integers(len(code))] = generator.integers(4 * n + 2)
            lists.append(code)
        lists += sound
    kinds = set()
    for symbols in lists:
        try:
            Disk.from_twin(decode(symbols), 0)
            expected = symbols[0] == 0
        except PatternDBError:
            expected = False
        assert is_disk_code(symbols.astype(np.int32) - 1) == expected, symbols
        kinds.add(expected)
    assert kinds == {True, False}


def _some_codes(n: int) -> list[np.ndarray]:
    strip = np.array([[i, i + 1, n + 2 + i, n + 1 + i] for i in range(n)])
    return [canonical_code(QuadMesh.from_quads(strip).twin)[0]]
