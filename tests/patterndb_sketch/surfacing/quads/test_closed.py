"""Closed networks that are known exactly, filled by quads."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import patterndb
from patterndb_sketch.surfacing.networkfile import read_network
from query.placing import quality
from tests.support.surfacing.networkfiles import CLOSED, COUNTS
from tests.support.surfacing.quads import assert_closed, assert_disk_within, filled, loops, together


@pytest.mark.parametrize(("edges", "smooth"), [(2.5, False), (4.0, True), (8.0, True)])
@pytest.mark.parametrize("path", CLOSED, ids=lambda path: path.stem)
def test_a_closed_network_becomes_a_closed_mesh_of_quads(
    path: Path, edges: float, smooth: bool
) -> None:
    network = read_network(path)
    assert len(network.cycles) == COUNTS[path.stem][2]
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
    # Angles are within some 10 degrees of right ones on average, where corners of patches are.
    most = 20.0 if path.stem == "gem" else 14.0
    assert quality(quads.astype(np.int32), points) < 4 * np.radians(most) ** 2
