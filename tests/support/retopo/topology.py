"""What tests of loops and pairs share."""

from __future__ import annotations

from collections import Counter

import numpy as np

from patterndb.core.halfedge import Int32Array
from patterndb_sketch.retopo.filling import (
    Choice,
    RetopoMesh,
    fill_network,
    filling_of,
    has_suitable_fill,
    side_lengths,
    weld_patches,
)
from patterndb_sketch.retopo.network import Network, check_network
from query.engine import PatternSource
from query.recognition import hash_quads, weld
from tests.support.retopo.editors import SIZES
from tests.support.retopo.networks import plane

UP = np.array([0.0, 0.0, 1.0])


def choice_of(network: Network, patch: int) -> Choice:
    choice = filling_of(network.patches[patch]).choice
    assert choice is not None
    return choice


def assert_sound(network: Network) -> None:
    """Every patch is even, and its fill a disk with its counts."""
    check_network(network)
    for patch in network.patches.values():
        sides = side_lengths(network, patch)
        assert sum(sides) % 2 == 0 and has_suitable_fill(network, patch)
        choice = choice_of(network, patch.id)
        weld(choice.faces, choice.n_vertices, sum(sides))


def assert_manifold(mesh: RetopoMesh) -> None:
    """No edge has more than two quads, and none is passed twice the same way."""
    ends = zip(mesh.quads.ravel(), np.roll(mesh.quads, -1, axis=1).ravel(), strict=True)
    edges = [(int(a), int(b)) for a, b in ends]
    assert max(Counter(edges).values()) == 1
    assert max(Counter((min(e), max(e)) for e in edges).values()) <= 2


def key(choice: Choice) -> bytes:
    faces = choice.faces
    return hash_quads(faces, weld(faces, choice.n_vertices, choice.perimeter), False)


def drawn_quads(source: PatternSource, network: Network) -> Int32Array:
    """The quads of the mesh, which must be manifold."""
    found = fill_network(network, plane(), source, SIZES.edge)
    assert found.network is network, "counts and fills are there"
    mesh = weld_patches(found)
    assert_manifold(mesh)
    return mesh.quads


def around(network: Network) -> int:
    """Edges around all patches."""
    return sum(sum(side_lengths(network, patch)) for patch in network.patches.values())


def same_poles(one: Int32Array, two: Int32Array) -> bool:
    """A loop makes and takes no irregular vertex."""
    return sorted(one.tolist()) == sorted(two.tolist())
