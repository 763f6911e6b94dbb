"""A network of twenty patches that is known exactly, filled by quads."""

from __future__ import annotations

import numpy as np
import pytest

import patterndb
from patterndb_sketch.surfacing.networkfile import read_network
from query.placing import quality
from tests.support.shared import SHARED
from tests.support.surfacing.quads import assert_closed, assert_disk_within, filled, loops, together


@pytest.mark.parametrize(("edges", "smooth"), [(2.5, False), (4.0, True), (8.0, True)])
def test_the_trebol_becomes_a_closed_mesh_of_quads(edges: float, smooth: bool) -> None:
    network = read_network(SHARED / "data" / "curves" / "salvi" / "trebol_network.json")
    assert len(network.cycles) == 20
    spacing = float(np.median([curve.length for curve in network.curves])) / edges
    sampling, of = loops(network, spacing)
    patches = []
    with patterndb.open() as db:
        for loop in of:
            triangles, patch = filled(db, loop, smooth, spacing)
            n = len(loop.points)
            assert_disk_within(n, patch.quads)
            assert set(triangles[triangles < n]) == set(patch.quads[patch.quads < n])
            assert (patch.n_flipped, patch.note) == (0, "")
            patches.append(patch)
    points, quads = together(sampling, of, patches)
    assert_closed(quads, 2)
    assert {patch.n_irregular for patch in patches} <= {0, 1, 2}
    # Angles are within some 10 degrees of right ones on average.
    assert quality(quads.astype(np.int32), points) < 4 * np.radians(14) ** 2
