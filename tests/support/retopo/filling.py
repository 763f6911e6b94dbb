"""What tests of filled networks share: counts, meshes and what must hold of them."""

from __future__ import annotations

import numpy as np

from patterndb_sketch.retopo.filling import FilledNetwork, RetopoMesh, side_lengths
from patterndb_sketch.retopo.network import Network, are_equal
from tests.support.retopo.editors import (
    SIZES,
    same_arrays,
)

EDGE = SIZES.edge


def counts(network: Network) -> dict[int, int]:
    return {c: chain.count for c, chain in network.chains.items()}


def different(one: Network, two: Network) -> set[int]:
    """The chains whose counts differ."""
    a, b = counts(one), counts(two)
    assert a.keys() == b.keys()
    return {c for c in a if a[c] != b[c]}


def assert_even(network: Network) -> None:
    for patch in network.patches.values():
        sides = side_lengths(network, patch)
        assert min(sides) >= 1
        assert sum(sides) >= 4
        assert sum(sides) % 2 == 0


def edges_of(mesh: RetopoMesh) -> set[tuple[int, int]]:
    edges = [(q[k - 1], q[k]) for q in mesh.quads.tolist() for k in range(4)]
    assert len(set(edges)) == len(edges), "two quads pass an edge the same way"
    return set(edges)


def assert_welded(found: FilledNetwork, mesh: RetopoMesh) -> None:
    """Every patch's quads are there with its places, bit for bit."""
    start = 0
    for patch in sorted(found.placed):
        placed = found.placed[patch]
        rows = mesh.quads[start : start + len(placed.quads)]
        assert same_arrays(mesh.vertices[rows], placed.vertices[placed.quads])
        assert (mesh.patch[start : start + len(rows)] == patch).all()
        start += len(rows)
    assert start == len(mesh.quads)
    used = np.unique(mesh.quads)
    assert used.tolist() == list(range(len(mesh.vertices)))


def same_fills(one: FilledNetwork, two: FilledNetwork) -> bool:
    return (
        are_equal(one.network, two.network)
        and one.notes == two.notes
        and one.placed.keys() == two.placed.keys()
        and all(
            same_arrays(getattr(one.placed[p], name), getattr(two.placed[p], name))
            for p in one.placed
            for name in ("quads", "vertices", "normals", "flipped")
        )
    )
