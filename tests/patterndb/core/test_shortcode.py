"""Short codes: half as long, one for every code, and nothing else is read as one."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from patterndb.core.code import canonical_code, decode
from patterndb.core.packing import pack, unpack
from patterndb.core.quadmesh import QuadMesh
from patterndb.core.shortcode import lengthen, restore, shorten
from patterndb.errors import InvalidCodeError
from tests.support.meshes import disks, grid


def packed(twin: list[int]) -> bytes:
    return pack(canonical_code(np.array(twin, np.int32))[0])


@given(st.lists(disks(), max_size=4))
def test_codes_come_back(twins: list[list[int]]) -> None:
    codes = [packed(twin) for twin in twins]
    short = shorten(codes)
    assert lengthen(short) == codes
    symbols, offsets = restore(short)
    assert [symbols[a:b].tolist() for a, b in pairwise(offsets)] == [
        unpack(code).tolist() for code in codes
    ]


def test_numbers_of_several_bytes_come_back() -> None:
    code = packed(QuadMesh.from_quads(grid(90, 91)).twin.tolist())
    (short,) = shorten([code])
    assert lengthen([short]) == [code]
    assert len(short) < 0.6 * len(code)


def read_one(short: bytes) -> list[int] | None:
    """The half-edges that a short code stands for, by its definition; None where it is none."""
    numbers: list[int] = []
    number, place = 0, 0
    for byte in short:
        number |= (byte & 127) << (7 * place)
        place += 1
        if byte < 128:
            if place > 3 or (place > 1 and byte == 0):
                return None
            numbers.append(number)
            number, place = 0, 0
    if place:
        return None
    twin: dict[int, int] = {}
    at = 0
    for number in numbers:
        while at in twin:
            at += 1
        twin[at] = -1
        if number:
            if at + number in twin:
                return None
            twin[at], twin[at + number] = at + number, at
    if not twin or len(twin) % 4 or set(twin) != set(range(len(twin))):
        return None
    return [twin[h] for h in range(len(twin))]


@given(st.binary(max_size=12) | st.lists(st.integers(0, 5), max_size=16).map(bytes))
@example(b"\x00\x00\x00\x80\x00")
@example(b"\x00\x00\x00\xff\xff\xff\x7f")
@example(b"\x01\x01")
def test_any_bytes_are_read_as_the_definition_says(short: bytes) -> None:
    expected = read_one(short)
    if expected is None:
        with pytest.raises(InvalidCodeError) as caught:
            restore([short])
        assert caught.value.row == 0
    else:
        symbols, _ = restore([short])
        assert (symbols.astype(np.int32) - 1).tolist() == expected
        assert shorten(lengthen([short])) == [short]


@given(st.lists(disks(), min_size=1, max_size=3), st.binary(max_size=6), st.integers(0))
def test_the_row_that_is_no_code_is_told(twins: list[list[int]], junk: bytes, where: int) -> None:
    short = shorten([packed(twin) for twin in twins])
    where %= len(short) + 1
    if read_one(junk) is None:
        with pytest.raises(InvalidCodeError) as caught:
            restore([*short[:where], junk, *short[where:]])
        assert caught.value.row == where


@pytest.mark.parametrize("code", [b"", b"\x00\x00", bytes([9, 0, 0, 0]), bytes([1, 0, 0, 0])])
def test_what_does_not_pair_its_edges_cannot_be_shortened(code: bytes) -> None:
    good = packed(QuadMesh.from_quads(grid(1, 2)).twin.tolist())
    assert decode(unpack(good).astype(np.uint16)) is not None
    with pytest.raises(InvalidCodeError) as caught:
        shorten([good, code])
    assert caught.value.row == 1
