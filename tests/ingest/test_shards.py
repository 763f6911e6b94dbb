from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ingest.shards import cut_into_shards
from patterndb.core.quadmesh import QuadMesh
from tests.support.meshes import Quads, beside, grid, mesh_of_file, quad_soups
from tests.support.shared import EXAMPLES


def assert_partition(mesh: QuadMesh, largest: int) -> None:
    component = mesh.components()
    shard = cut_into_shards(mesh.twin, component, largest)
    assert shard.shape == (mesh.n_quads,)
    sizes = np.bincount(shard)
    assert (sizes > 0).all(), "numbers are left out"
    assert sizes.max() <= largest
    for c in np.unique(component):
        inside = component == c
        if inside.sum() <= largest:
            assert len(np.unique(shard[inside])) == 1, "a small component is cut"
        else:
            # Halves of halves: none is smaller than half of what fits, nor shared.
            own = np.bincount(shard[inside])
            assert own[own > 0].min() >= largest // 2
            assert not np.isin(shard[~inside], shard[inside]).any()


@given(quad_soups(), st.integers(1, 45))
def test_shards_part_the_quads(quads: Quads, largest: int) -> None:
    assert_partition(QuadMesh.from_quads(quads), largest)


@pytest.mark.parametrize("largest", [1, 7, 64, 500, 10_000])
def test_shards_of_an_example(largest: int) -> None:
    assert_partition(mesh_of_file(EXAMPLES / "head.obj"), largest)


def test_small_components_share_a_shard() -> None:
    mesh = QuadMesh.from_quads(beside(*[grid(1, 2)] * 7))
    shard = cut_into_shards(mesh.twin, mesh.components(), 5)
    assert np.bincount(shard).tolist() == [4, 4, 4, 2]


def test_shards_are_compact() -> None:
    """A grid is cut across: few edges lead from one shard to another."""
    mesh = QuadMesh.from_quads(grid(32, 32))
    shard = cut_into_shards(mesh.twin, mesh.components(), 64)
    inner = np.flatnonzero(mesh.twin >= 0)
    across = (shard[inner >> 2] != shard[mesh.twin[inner] >> 2]).mean()
    assert across < 0.2


def test_no_quads() -> None:
    assert len(cut_into_shards(np.zeros(0, np.int32), np.zeros(0, np.int32), 8)) == 0
