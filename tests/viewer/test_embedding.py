"""The flat drawing: no quad flipped, boundary convex or at least simple, always the same."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from patterndb.core.disk import Disk
from patterndb.core.quadmesh import QuadMesh
from patterndb.geometry.embedding import (
    LONGEST_SIDE,
    embed_disk,
    find_flipped_quads,
    make_outline,
)
from tests.support.smalldisks import read_small_disks
from tests.support.viewer.disks import ALL, disk, expand, pattern, refined


def turns(loop: np.ndarray) -> np.ndarray:
    """Cross product of the edges before and after every point, in squared edge lengths."""
    before, after = loop - np.roll(loop, 1, axis=0), np.roll(loop, -1, axis=0) - loop
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    return cross / np.maximum((before**2).sum(axis=1), (after**2).sum(axis=1))


def winding(loop: np.ndarray) -> float:
    """How often a closed polygon turns round, 1 for a simple one, counter-clockwise."""
    edge = np.roll(loop, -1, axis=0) - loop
    direction = edge[:, 0] + 1j * edge[:, 1]
    return float(np.angle(np.roll(direction, -1) / direction).sum() / (2.0 * np.pi))


def check(d: Disk) -> None:
    convex = embed_disk(d, bend=False)
    bent = embed_disk(d)
    for points in (convex, bent):
        assert points.shape == (d.n_vertices, 2) and points.dtype == np.float64
        assert np.isfinite(points).all()
        assert np.abs(points).max() == pytest.approx(1.0)
        assert not find_flipped_quads(d.quads, points).any()
        # All quads upright and the boundary winding once: the drawing overlaps nowhere.
        assert winding(points[: d.perimeter]) == pytest.approx(1.0)
    if d.perimeter > 4:
        assert (turns(convex[: d.perimeter]) > 1e-4).all()
    assert np.array_equal(bent, embed_disk(d))
    if (d.corner_counts() == 1).all():
        assert np.array_equal(convex, bent)


@pytest.mark.parametrize("name", ALL)
def test_small_disks(name: str) -> None:
    check(disk(ALL[name]))


@pytest.mark.parametrize("name", ALL)
def test_refined_disks(name: str) -> None:
    check(refined(ALL[name], 4))


def test_a_large_fill() -> None:
    check(refined(ALL["pentagon"], 8))
    check(refined(ALL["plus"], 9))


def test_many_nested_doublets() -> None:
    # 0 and 2 are joined through n vertices of valence 2.
    n = 9
    quads = [[0, 3 + i, 2, 4 + i] for i in range(n)]
    check(disk(quads))


def test_a_valence_of_nine() -> None:
    n = 9
    quads = [[0, 2 * i + 1, 2 * i + 2, (2 * i + 2) % (2 * n) + 1] for i in range(n)]
    check(disk(quads))


@settings(max_examples=60, deadline=None)
@given(
    name=st.sampled_from(["two quads", "doublet", "triangle", "pentagon", "ring", "L", "plus"]),
    data=st.data(),
)
def test_expansions(name: str, data: st.DataObject) -> None:
    p = pattern(ALL[name])
    n = p.n_chords + p.n_loops
    widths = data.draw(st.lists(st.integers(1, 9), min_size=n, max_size=n))
    d = expand(p, widths)
    for points in (embed_disk(d), embed_disk(d, bend=False)):
        assert not find_flipped_quads(d.quads, points).any()


def test_many_small_disks() -> None:
    for _, _, quads in read_small_disks()[::7]:
        check(Disk.from_twin(QuadMesh.from_quads(np.array(quads)).twin))


def test_flipped_tells_flipped_quads() -> None:
    quads = np.array([[0, 1, 2, 3]], np.int32)

    def one(*points: tuple[float, float]) -> bool:
        return bool(find_flipped_quads(quads, np.array(points, np.float64))[0])

    assert not one((0, 0), (1, 0), (1, 1), (0, 1))
    assert not one((0, 0), (2, 0), (0.5, 0.5), (0, 2))  # concave
    assert one((0, 0), (0, 1), (1, 1), (1, 0))  # clockwise
    assert one((0, 0), (1, 1), (1, 0), (0, 1))  # a bow tie
    assert one((0, 0), (1, 0), (2, 0), (3, 0))  # no area


@example([2, 4, 10, 21])
@example([39, 1, 39])
@given(st.lists(st.integers(1, 40), min_size=3, max_size=12))
def test_the_outline_closes_whatever_the_lengths(lengths: list[int]) -> None:
    # A strip of quads is a stand-in: only corners and lengths matter to the outline.
    perimeter = sum(lengths)
    corners = np.r_[0, np.cumsum(lengths)[:-1]].astype(np.int32)
    quads = np.stack([corners] * 4, axis=1)
    d = Disk(quads, perimeter, perimeter, corners)
    points = make_outline(d).points()
    loop = np.stack([points.real, points.imag], axis=1)
    assert LONGEST_SIDE < 1.0
    assert (turns(loop) > 0.0).all()
    assert winding(loop) == pytest.approx(1.0)
    assert loop[corners[1], 1] == pytest.approx(loop[0, 1])
