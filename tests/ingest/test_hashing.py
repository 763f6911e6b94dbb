from __future__ import annotations

import numpy as np

from patterndb._native.ingest.hashing import random_pairs


def test_random_pairs_are_fixed_and_distinct() -> None:
    pairs = random_pairs(20_000)
    assert len(np.unique(pairs.ravel())) == pairs.size
    np.testing.assert_array_equal(random_pairs(100), pairs[:100])
    # No bit is set much more often than not, in either lane.
    bits = (pairs[:, :, None] >> np.arange(64, dtype=np.uint64)) & np.uint64(1)
    assert np.abs(bits.mean(axis=0) - 0.5).max() < 0.02
