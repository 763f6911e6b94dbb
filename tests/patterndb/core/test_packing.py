from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from patterndb.core import packing
from patterndb.core.packing import (
    LIMIT,
    PackedRows,
    pack,
    pack_many,
    take_rows,
    take_stretches,
    unpack,
    unpack_many,
)

numbers = st.one_of(st.integers(0, 200), st.integers(0, LIMIT - 1))


def packed(values: list[int]) -> bytes:
    """Seven bits a byte, lowest first, the high bit saying that more follow."""
    out: list[int] = []
    for value in values:
        while value > 127:
            out.append(value % 128 + 128)
            value //= 128
        out.append(value)
    return bytes(out)


@given(st.lists(numbers))
def test_packing_is_as_described_and_comes_back(values: list[int]) -> None:
    assert pack(values) == packed(values) == pack(np.array(values, np.int64))
    assert unpack(pack(values)).tolist() == values
    assert unpack(pack(values)).dtype == np.int32


@given(st.lists(st.lists(numbers)))
def test_packed_lists_one_after_the_other_are_one_list(lists: list[list[int]]) -> None:
    assert unpack(b"".join(map(pack, lists))).tolist() == [v for values in lists for v in values]


@given(st.lists(numbers), st.one_of(st.integers(max_value=-1), st.integers(LIMIT, 2**62)))
def test_what_does_not_fit_is_refused(values: list[int], wrong: int) -> None:
    if wrong >= -(2**62):
        with pytest.raises(ValueError, match="must lie in"):
            pack([*values, wrong])


@given(st.lists(numbers), st.integers(128, 255))
def test_a_number_cut_short_is_refused(values: list[int], last: int) -> None:
    with pytest.raises(ValueError, match="end in the middle"):
        unpack(pack(values) + bytes([last]))


@given(st.lists(st.lists(numbers)))
def test_many_lists_at_once(lists: list[list[int]]) -> None:
    blobs = [pack(values) for values in lists]
    flat, offsets = unpack_many(blobs)
    assert [flat[a:b].tolist() for a, b in itertools.pairwise(offsets)] == lists
    assert offsets[0] == 0
    assert pack_many(flat, offsets) == blobs


@given(st.lists(st.lists(st.binary(max_size=5))), st.data())
def test_rows_are_joined_and_taken(parts: list[list[bytes]], data: st.DataObject) -> None:
    rows = [row for part in parts for row in part]
    joined = PackedRows.join([PackedRows.of(part) for part in parts])
    assert joined == PackedRows.of(rows)
    assert list(joined) == rows
    places = st.lists(st.integers(0, len(rows) - 1)) if rows else st.just([])
    at = np.array(data.draw(places), np.int64)
    taken = take_rows(joined, at)
    assert isinstance(taken, PackedRows)
    assert list(taken) == take_rows(rows, at) == [rows[i] for i in at.tolist()]
    # Of rows in the middle of others, as the census has them.
    first = data.draw(st.integers(0, len(rows)))
    part = PackedRows(joined.raw, joined.ends[first:])
    assert list(PackedRows.join([part, part])) == 2 * rows[first:]


@given(st.lists(st.integers(0, 9)), st.data(), st.integers(1, 4))
def test_stretches_are_taken_some_at_a_time(
    values: list[int], data: st.DataObject, at_once: int
) -> None:
    flat = np.array(values, np.int16)
    starts = data.draw(st.lists(st.integers(0, len(values))))
    sizes = [data.draw(st.integers(0, len(values) - start)) for start in starts]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(packing, "TAKEN_AT_ONCE", at_once)
        taken = take_stretches(flat, np.array(starts, np.int64), np.array(sizes, np.int64))
    assert taken.dtype == flat.dtype
    assert taken.tolist() == [
        value
        for start, size in zip(starts, sizes, strict=True)
        for value in values[start : start + size]
    ]
