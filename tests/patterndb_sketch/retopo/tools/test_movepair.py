"""Pairs of irregular vertices that are moved."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
import pytest

from patterndb.core.halfedge import Int32Array
from patterndb_sketch.retopo.editor import Call, Retopology
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling import fill_network, find_irregular_vertices, weld_patches
from patterndb_sketch.retopo.network import Network, are_equal
from patterndb_sketch.retopo.tools.movepair import find_least_changes, move_pair
from query.engine import PatternSource, fills
from tests.support.retopo.editors import SIZES, do, drawn_grid, drawn_octants, patch_around
from tests.support.retopo.networks import plane, sphere
from tests.support.retopo.topology import (
    assert_manifold,
    assert_sound,
    choice_of,
)


@pytest.fixture(scope="module")
def filled_grid(source: PatternSource) -> Network:
    """3 x 3 patches of 4 x 4 quads, filled."""
    return drawn_grid(source).fill().network


def pair_case(source: PatternSource) -> Retopology:
    """One square cell of sides 8, 8, 6, 6 whose fill has a pair of irregular vertices."""
    editor = drawn_grid(source, 1)
    for at, count in (((0.5, 0), 8), ((1, 0.5), 8), ((0.5, 1), 6), ((0, 0.5), 6)):
        do(editor, "subdivide", at=[*at, 0], count=count)
    editor.fill()
    return editor


def inner_poles(network: Network, source: PatternSource) -> np.ndarray:
    """(k, 3) irregular vertices inside the patches, by valence."""
    found = fill_network(network, plane(), source, SIZES.edge)
    assert found.network is network, "counts and fills are there"
    mesh = weld_patches(found)
    assert_manifold(mesh)
    which, valence = find_irregular_vertices(mesh)
    inside = (mesh.node[which] < 0) & (mesh.chain[which] < 0)
    return mesh.vertices[which[inside]][np.argsort(valence[inside], kind="stable")]


def test_a_pair_follows_the_drag_and_comes_back(source: PatternSource) -> None:
    editor = pair_case(source)
    former = editor.network
    (patch,) = former.patches
    before = choice_of(former, patch)
    poles = inner_poles(former, source)
    assert len(poles) == 2
    moved = 0
    for by in ([0.2, 0, 0], [-0.2, 0, 0], [0, 0.2, 0], [0, -0.2, 0], [0.15, -0.15, 0]):
        at = poles.mean(axis=0)
        outcome = editor.do(Call("movepair", {"at": at.tolist(), "to": (at + by).tolist()}))
        if outcome.refused is not None:
            assert "can move this way while its border stays" in outcome.refused
            assert editor.network is former
            continue
        moved += 1
        assert_sound(editor.network)
        after = choice_of(editor.network, patch)
        assert (after.code, after.lengths, after.by) == (before.code, before.lengths, "user")
        assert (after.rotation, after.mirrored) == (before.rotation, before.mirrored)
        assert after.widths != before.widths
        there = inner_poles(editor.network, source)
        assert (there - poles).mean(axis=0) @ np.array(by) > 0.0
        do(editor, "undo")
        assert are_equal(editor.network, former)
    assert moved >= 2


def test_longer_drags_take_pairs_further(source: PatternSource) -> None:
    network = pair_case(source).network
    poles = inner_poles(network, source)
    at = poles.mean(axis=0)
    (patch,) = network.patches
    far: list[float] = []
    for way in np.array([[1.0, 0, 0], [-1.0, 0, 0], [0, 1.0, 0], [0, -1.0, 0]]):
        along = [0.0]
        for length in (0.1, 0.25, 0.5, 1.0):
            try:
                edit = move_pair(network, plane(), source, SIZES, patch, at, length * way)
            except RefusedError:
                continue
            along.append(float(((inner_poles(edit.network, source) - poles) @ way).mean()))
        assert sorted(along) == pytest.approx(along, abs=0.02)
        far.append(along[-1])
    assert max(far) > 0.1


def test_a_pair_without_room_or_drag_stays(source: PatternSource, filled_grid: Network) -> None:
    patch = patch_around(filled_grid, 1.5, 1.5)
    at = np.array([1.5, 1.5, 0.0])
    edit = move_pair(filled_grid, plane(), source, SIZES, patch, at, np.zeros(3))
    assert edit.network is filled_grid
    with pytest.raises(RefusedError, match="no irregular vertices inside"):
        move_pair(filled_grid, plane(), source, SIZES, patch, at, [0.1, 0, 0])
    # Of three sides, counts alone say where the irregular vertex is.
    editor = drawn_octants(source)
    network = editor.fill().network
    three = next(iter(network.patches))
    top = sphere().nearest(np.array([[0.6, 0.6, 0.6]])).points[0]
    with pytest.raises(RefusedError, match="can move this way while its border stays"):
        move_pair(network, editor.surface, source, editor.sizes, three, top, [0.1, 0.0, 0.0])


def test_least_changes_keep_all_sides_and_are_no_sums(source: PatternSource) -> None:
    """Every change by at most 1 each way is a sum of them, found by brute force."""
    for sides in ((6, 6, 8, 8), (5, 4, 6, 3, 4), (4, 5, 4, 5)):
        for fill in fills(source, sides, limit=3, per_pattern=1, strict=True):
            label = fill.pattern.label
            steps = find_least_changes(label)
            assert all(keeps_lengths(step, label) for step in steps)
            assert {(-step).tobytes() for step in steps} == {step.tobytes() for step in steps}
            if fill.pattern.n_chords > 8:
                continue
            for change in product((-1, 0, 1), repeat=fill.pattern.n_chords):
                left = np.array(change, np.int32)
                if keeps_lengths(left, label):
                    while left.any():
                        left = left - next(step for step in steps if within(step, left))


def keeps_lengths(change: Int32Array, label: Sequence[Sequence[int]]) -> bool:
    """Do all sides stay as long?"""
    return not any(change[list(side)].sum() for side in label)


def within(step: Int32Array, change: Int32Array) -> bool:
    return bool((step * change >= 0).all() and (np.abs(step) <= np.abs(change)).all())
