"""The kernels of all modes against sets of quads in plain Python, row by row."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from ingest import learn
from ingest.prepare import prepare
from patterndb.core.packing import unpack
from patterndb.core.quadmesh import QuadMesh
from patterndb.store import Learned, LearningOptions
from tests.support.meshes import (
    SHAPES,
    Quads,
    beside,
    examples,
    mesh_of_file,
    models,
    quad_soups,
    refined,
    shared_meshes,
    star,
    wrapped,
)
from tests.support.reference import enumeration as reference
from tests.support.shared import DATA

LIMITS = [(4, 8, 10), (5, 0, 0), (0, 9, 0), (0, 0, 12), (3, 7, 7), (2, 0, 14)]
MANY_SHARDS = 7


def codes_of(learned: Learned) -> list[tuple[int, ...]]:
    return [tuple(unpack(code).tolist()) for code in learned.codes]


def assert_as_reference(quads: Quads | NDArray[np.int32], options: LearningOptions) -> None:
    """Counts of each mode; patterns with their patches by handedness; and examples: one of
    the smallest patches of each."""
    given_mesh = QuadMesh.from_quads(quads)
    mesh = prepare(given_mesh) if options.prepare else given_mesh
    expected = reference.learn(mesh.twin, options.basic, options.side, options.convex)
    # Faces need not be numbered from 0, nor without gaps.
    faces = 3 * np.arange(given_mesh.n_quads) + 2
    sides = {code: sum(k != 2 for k in _around(code)) for code in expected.patterns}
    for shard_quads in (MANY_SHARDS, 1 << 30):
        learned = learn(np.array(quads, np.int32), options, faces=faces, shard_quads=shard_quads)
        assert (learned.quads_read, learned.quads_used) == (given_mesh.n_quads, mesh.n_quads)
        assert (learned.basic, learned.side, learned.convex) == (
            expected.basic,
            expected.side,
            expected.convex,
        )
        codes = codes_of(learned)
        patches = [tuple(row) for row in learned.patches.tolist()]
        assert dict(zip(codes, patches, strict=True)) == expected.patterns
        assert learned.distinct == sum(map(sum, patches))
        assert dict(zip(codes, learned.sides.tolist(), strict=True)) == sides
        # Quads of the mesh by their places in the file.
        number = {int(f): q for q, f in enumerate(faces[mesh.source_quad])}
        for code, example in zip(codes, learned.examples, strict=True):
            patch = frozenset(number[f] for f in np.cumsum(unpack(example)).tolist())
            assert patch in expected.examples[code]
            assert len(patch) == min(map(len, expected.examples[code]))


def _around(code: tuple[int, ...]) -> list[int]:
    """Quads at the boundary vertices of a code's disk."""
    mesh = reference.PatchMesh([symbol - 1 for symbol in code])
    everything = frozenset(range(mesh.n_quads))
    count = mesh.count(everything)
    return [count[mesh.vertex[h]] for h in mesh.border(everything)]


@settings(max_examples=50)
@given(quad_soups(most=16), st.sampled_from(LIMITS), st.booleans())
def test_random_meshes(quads: Quads, limits: tuple[int, int, int], prepared: bool) -> None:
    assert_as_reference(quads, LearningOptions(*limits, prepare=prepared))


#: The far sides of the two quads beyond a side are one edge: the pattern is not the one before.
FOLDED = [
    [9, 0, 2, 5],
    [6, 7, 4, 3],
    [7, 8, 5, 4],
    [8, 6, 9, 5],
    [9, 10, 7, 6],
    [10, 11, 8, 7],
    [11, 3, 6, 8],
    [0, 1, 10, 9],
    [1, 0, 11, 10],
]


def test_a_strip_that_folds_on_itself() -> None:
    assert_as_reference(FOLDED, LearningOptions(0, 9, 0, prepare=False))


@pytest.mark.parametrize("prepared", [False, True], ids=["as it is", "prepared"])
@pytest.mark.parametrize("name", SHAPES)
def test_shapes(name: str, prepared: bool) -> None:
    assert_as_reference(SHAPES[name], LearningOptions(4, 8, 12, prepared))


WIDE = {
    "torus": wrapped(5, 5, around=True, along=True),
    "tube": wrapped(3, 6, around=True),
    "moebius": wrapped(3, 7, twist=True),
    "refined star 3": refined(star(3)),
    "refined star 6": refined(star(6)),
    "tube and star": beside(wrapped(2, 4, around=True), star(5, 2)),
}


@pytest.mark.parametrize("name", WIDE)
def test_growth_into_all_of_a_small_mesh(name: str) -> None:
    assert_as_reference(WIDE[name], LearningOptions(0, 24, 40, prepare=False))


def ball(mesh: QuadMesh, n: int, seed: int) -> NDArray[np.int32]:
    """The n quads nearest to a random one, by the mesh's own vertices."""
    found = [int(np.random.default_rng(seed).integers(mesh.n_quads))]
    for q in found:
        found += [t >> 2 for t in mesh.twin[4 * q : 4 * q + 4] if t >= 0 and t >> 2 not in found]
        if len(found) >= n:
            break
    return mesh.source[mesh.quads[list(dict.fromkeys(found))]]


@pytest.mark.parametrize("prepared", [False, True], ids=["as it is", "prepared"])
@pytest.mark.parametrize(
    "path",
    [*examples(), *models()[::2], *shared_meshes("spot", "q_cat", "q_spider", "chess_rook")],
    ids=lambda p: p.stem,
)
def test_pieces_of_artists_meshes(path: Path, prepared: bool) -> None:
    for seed in range(2):
        piece = ball(mesh_of_file(path), 32, seed)
        assert_as_reference(piece, LearningOptions(4, 8, 14, prepared))


#: What a third program counts of the shapes: basic, side, convex and distinct patches.
COUNTED: dict[str, list[int]] = json.loads((DATA / "shapes.json").read_text())


@pytest.mark.parametrize("name", SHAPES)
def test_a_third_program_counts_the_same(name: str) -> None:
    learned = learn(np.array(SHAPES[name], np.int32), LearningOptions(5, 10, 16, prepare=False))
    assert COUNTED[name] == [learned.basic, learned.side, learned.convex, learned.distinct]


@given(quad_soups(most=30), st.integers(1, 12))
def test_the_shards_do_not_matter(quads: Quads, shard_quads: int) -> None:
    array, options = np.array(quads, np.int32), LearningOptions(4, 12, 20, prepare=False)
    whole = learn(array, options)
    cut = learn(array, options, shard_quads=shard_quads)
    assert (cut.basic, cut.side, cut.convex) == (whole.basic, whole.side, whole.convex)
    assert rows_of(cut) == rows_of(whole)


def rows_of(learned: Learned) -> set[tuple[object, ...]]:
    rows = zip(
        learned.codes,
        learned.sides.tolist(),
        map(tuple, learned.patches.tolist()),
        learned.examples,
        strict=True,
    )
    return set(rows)


@pytest.mark.parametrize("prepared", [False, True], ids=["as it is", "prepared"])
def test_no_quads_teach_nothing(prepared: bool) -> None:
    learned = learn(np.zeros((0, 4), np.int32), LearningOptions(prepare=prepared))
    assert (learned.quads_read, learned.quads_used, learned.distinct) == (0, 0, 0)
    assert (learned.basic, learned.side, learned.convex) == (0, 0, 0)
    assert (list(learned.codes), list(learned.examples)) == ([], [])
    assert learned.patches.shape == (0, 2)


def test_faces_far_down_a_file_have_examples() -> None:
    faces = np.array([5_000_000])
    learned = learn(np.array(SHAPES["one"], np.int32), LearningOptions(1, 0, 0), faces=faces)
    assert unpack(learned.examples[0]).tolist() == [5_000_000]


@pytest.mark.parametrize("limits", [(-1, 0, 0), (0, 5000, 0), (0, 0, 0)])
def test_limits_that_make_no_sense_are_refused(limits: tuple[int, int, int]) -> None:
    with pytest.raises(ValueError, match=r"limit"):
        LearningOptions(*limits)
