from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from patterndb._native.ingest.hashing import (
    double_map,
    double_set,
    find,
    hash_symbols,
    random_pairs,
)

#: Part of the slots of a table that may be filled.
LOAD = 0.625

# Few different low bits, so that keys collide and runs wrap round the table's end.
lanes = st.one_of(st.integers(1, 40), st.sampled_from([15, 31, 2**64 - 1, 2**63 + 15, 16, 32]))
keys_ = st.lists(st.tuples(lanes, lanes), unique=True, max_size=60)


def filled(keys: list[tuple[int, int]]) -> tuple[NDArray[np.uint64], NDArray[np.int32]]:
    """A map from every key to its place, doubled where it is too full."""
    table, values = np.zeros((4, 2), np.uint64), np.zeros(4, np.int32)
    for i, (a, b) in enumerate(keys):
        if i + 1 > LOAD * len(table):
            table, values = double_map(table, values)
        slot = find(table, np.uint64(a), np.uint64(b))
        assert slot < 0, "a key is found that is not there"
        table[-1 - slot] = a, b
        values[-1 - slot] = i
    return table, values


@given(keys_)
def test_every_key_is_found_with_its_value(keys: list[tuple[int, int]]) -> None:
    table, values = filled(keys)
    assert len(table) * LOAD >= len(keys)
    for i, (a, b) in enumerate(keys):
        slot = find(table, np.uint64(a), np.uint64(b))
        assert values[slot] == i
    assert (table != 0).any(axis=1).sum() == len(keys)


@given(keys_, st.tuples(lanes, lanes))
def test_a_doubled_table_holds_the_same(
    keys: list[tuple[int, int]], other: tuple[int, int]
) -> None:
    table, values = filled(keys)
    bigger = double_set(table)
    map_keys, map_values = double_map(table, values)
    assert len(bigger) == len(map_keys) == 2 * len(table)
    np.testing.assert_array_equal(bigger, map_keys)
    for a, b in keys:
        slot = find(bigger, np.uint64(a), np.uint64(b))
        assert slot >= 0
        assert map_values[slot] == values[find(table, np.uint64(a), np.uint64(b))]
    absent = find(bigger, np.uint64(other[0]), np.uint64(other[1])) < 0
    assert absent == (other not in keys)


def test_random_pairs_are_fixed_and_distinct() -> None:
    pairs = random_pairs(20_000)
    assert len(np.unique(pairs.ravel())) == pairs.size
    np.testing.assert_array_equal(random_pairs(100), pairs[:100])
    # No bit is set much more often than not, in either lane.
    bits = (pairs[:, :, None] >> np.arange(64, dtype=np.uint64)) & np.uint64(1)
    assert np.abs(bits.mean(axis=0) - 0.5).max() < 0.02


@given(st.lists(st.lists(st.integers(0, 65535), max_size=8), unique_by=tuple, max_size=30))
def test_hashes_of_symbols_tell_lists_apart(lists: list[list[int]]) -> None:
    hashes = {hash_symbols(np.array(x, np.uint16), len(x)) for x in lists}
    assert len(hashes) == len(lists)


@given(st.lists(st.integers(0, 65535), min_size=1, max_size=8))
def test_only_the_first_symbols_count(symbols: list[int]) -> None:
    code = np.array(symbols, np.uint16)
    n = len(symbols) - 1
    assert hash_symbols(code, n) == hash_symbols(code[:n], n)
