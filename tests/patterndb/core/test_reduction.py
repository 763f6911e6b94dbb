"""Dissolving in one pass against collapsing polychords one by one, in any order."""

from __future__ import annotations

import random
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from patterndb.core.polychord import polychords
from patterndb.core.quadmesh import QuadMesh
from patterndb.core.reduction import reduce_disk
from patterndb.errors import InvalidMeshError
from tests.support.meshes import (
    CUBE,
    SHAPES,
    disks,
    examples,
    grid,
    mesh_of_file,
    models,
    random_patches,
    refined,
    shared_meshes,
    star,
)
from tests.support.reference import reduction as reference
from tests.support.reference.code import isomorphic, own_code
from tests.support.reference.halfedge import (
    as_complex,
    border_loop,
    border_vertices,
    fans,
    is_disk,
    next_edge,
)

FILES = [*examples(), *models()[::2], *shared_meshes("spot", "penguin", "q_cat", "q_cow")]
PATCHES_A_FILE = 40
ORDERS = 3


def outline(twin: list[int]) -> tuple[list[int], list[int]]:
    """The corner kinds in order, in their smallest rotation, and the irregular valences."""
    complex_ = as_complex(twin)
    vertex = fans(complex_)
    count = Counter(vertex.values())
    loop = border_loop(complex_, twin.index(-1))
    corners = [count[vertex[h]] for h in loop if count[vertex[h]] != 2]
    inner = set(count) - border_vertices(complex_, vertex)
    rotations = [corners[i:] + corners[:i] for i in range(len(corners))]
    return min(rotations, default=[]), sorted(count[v] for v in inner if count[v] != 4)


def assert_reduces(twin: list[int], seed: int, strict: bool) -> None:
    reduced = reduce_disk(np.array(twin, np.int32))
    result = reduced.tolist()
    code = own_code(result)
    for order in range(seed, seed + ORDERS):
        collapsed = reference.reduce_disk(twin, random.Random(order), strict)
        assert own_code(collapsed) == code, f"order {order} leaves another pattern"
    assert is_disk(as_complex(result))
    assert outline(result) == outline(twin), "a corner or an irregular vertex is another"
    assert reduce_disk(reduced).tolist() == result, "a pattern is no fixed point"


@given(disks(), st.integers(0, 2**32))
def test_grown_disks(twin: list[int], seed: int) -> None:
    assert_reduces(twin, seed, strict=False)


def refine(twin: list[int]) -> list[int]:
    """Each quad cut into four. Quad q's child e holds its corner e: its edges run along edge e,
    twice inside, and along edge e - 1."""
    fine = [-1] * (4 * len(twin))
    for h, t in enumerate(twin):
        child, after = 4 * h, 4 * next_edge(h)
        fine[child + 1], fine[after + 2] = after + 2, child + 1
        if t >= 0:
            # The first half of an edge meets the second half of its twin.
            far = 4 * next_edge(t) + 3
            fine[child], fine[far] = far, child
    return fine


@given(disks(most=6), st.integers(0, 2**32))
def test_refining_a_disk_does_not_change_its_pattern(twin: list[int], seed: int) -> None:
    """All that is new may collapse, except where a polychord crosses itself: so do its copies."""
    fine = refine(twin)
    assert_reduces(fine, seed, strict=False)
    pattern = reduce_disk(np.array(twin, np.int32))
    if not polychords(pattern).crosses_itself.any():
        again = reduce_disk(np.array(fine, np.int32))
        assert own_code(again.tolist()) == own_code(pattern.tolist())


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_patches_of_artists_meshes(path: Path) -> None:
    mesh = mesh_of_file(path)
    for i, twin in enumerate(random_patches(mesh, PATCHES_A_FILE, most=28, seed=len(path.stem))):
        assert_reduces(twin.tolist(), i, strict=True)


@pytest.mark.parametrize(
    ("twin", "quads"),
    [
        pytest.param(QuadMesh.from_quads(grid(5, 7)).twin, 1, id="a grid is one quad"),
        pytest.param(
            QuadMesh.from_quads(refined(refined(star(5)))).twin, 5, id="a star, refined twice"
        ),
        pytest.param(QuadMesh.from_quads(SHAPES["refined cup"]).twin, 5, id="a cup, refined"),
        pytest.param(QuadMesh.from_quads(refined(star(3))).twin, 3, id="a triangle, refined"),
    ],
)
def test_known_patterns(twin: NDArray[np.int32], quads: int) -> None:
    assert len(reduce_disk(twin)) == 4 * quads


def test_refinement_is_isomorphic_to_what_was_refined() -> None:
    cup = reduce_disk(QuadMesh.from_quads(SHAPES["refined cup"]).twin)
    assert isomorphic(cup.tolist(), QuadMesh.from_quads(SHAPES["cup"]).twin.tolist())


def test_a_closed_surface_is_no_disk() -> None:
    with pytest.raises(InvalidMeshError, match="no border"):
        reduce_disk(QuadMesh.from_quads(CUBE).twin)
