"""The place of a polyline that is nearest to a point."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb.geometry.polyline import find_nearest_on


@settings(max_examples=120)
@given(st.integers(0, 10**6), st.sampled_from([2, 3]))
def test_the_nearest_point_of_a_polyline(seed: int, dimensions: int) -> None:
    """Against many points along it."""
    rng = np.random.default_rng(seed)
    line = rng.normal(size=(int(rng.integers(1, 6)), dimensions))
    point = rng.normal(size=dimensions)
    away, piece, share = find_nearest_on(line, point)
    ends = line if len(line) > 1 else line[[0, 0]]
    t = np.linspace(0.0, 1.0, 400)[:, None]
    dense = np.concatenate([a + t * (b - a) for a, b in pairwise(ends)])
    least = np.linalg.norm(dense - point, axis=1).min()
    assert least - 0.02 < away <= least + 1e-12
    at = ends[piece] + share * (ends[piece + 1] - ends[piece])
    assert np.linalg.norm(at - point) == pytest.approx(away)
