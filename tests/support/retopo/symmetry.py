"""Surfaces halved by planes, for the tests of symmetry."""

from __future__ import annotations

from functools import cache

import pytest
import trimesh

from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.network import SYMMETRY, Network, add_borders
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.symmetry import Half, Plane, cut_half

X = Plane()
TILTED = Plane.of((0.3, 0.3, -0.3), (1.0, 2.0, 3.0))
PLANES = pytest.mark.parametrize("plane", [X, TILTED], ids=["x", "tilted"])


def turned(mesh: trimesh.Trimesh) -> Surface:
    """A mesh turned, so that no vertex is on a plane by chance."""
    mesh.apply_transform(trimesh.transformations.rotation_matrix(0.7, [1, 2, 3]))
    return Surface.from_arrays(mesh.vertices, mesh.faces).orient()


@cache
def ball() -> Surface:
    return turned(trimesh.creation.icosphere(subdivisions=3))


@cache
def dome() -> Surface:
    """The upper half of the unit sphere, with a border near z = 0."""
    mesh = trimesh.creation.icosphere(subdivisions=3)
    kept = mesh.vertices[mesh.faces][:, :, 2].min(axis=1) > -1e-9
    return Surface.from_arrays(mesh.vertices, mesh.faces[kept]).orient()


@cache
def half(name: str, plane: Plane) -> Half:
    return cut_half({"ball": ball, "dome": dome}[name](), plane)


def empty(surface: Surface, sizes: Sizes) -> Network:
    return add_borders(Network(longest=4.0 * surface.diagonal), surface, sizes.sampling)


def seam(network: Network) -> list[int]:
    return [chain.id for chain in network.chains.values() if SYMMETRY in chain.marks]
