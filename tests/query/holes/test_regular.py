"""Fills without irregular vertices inside: against exhaustive search, and regular regions."""

from __future__ import annotations

import random
from collections.abc import Iterator
from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb._native.query.recognition import weld_quads
from patterndb.core.halfedge import Int32Array
from query.holes.regular import (
    MOST_EDGES,
    MOST_LEFT,
    MOST_RIGHT,
    build_regular_fill,
    list_closed_walks,
    list_rectangles,
)

STEPS = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)])


#: The squares across the edges of a square; edge i runs from corner i to the next, corner 0 is the
#: lower left one.
BESIDE = ((0, -1), (1, 0), (0, 1), (-1, 0))

Disk = tuple[Int32Array, int, Int32Array]


def grow_lattice_disks(count: int, most: int, seed: int) -> Iterator[Disk]:
    """Yield disks of up to ``most`` lattice squares, a part of them with slits: quads, loop
    vertices first, how many vertices, and the quads at each loop vertex."""
    draw = random.Random(seed)
    for _ in range(count):
        squares = {(0, 0)}
        for _ in range(draw.randint(0, most - 1)):
            x, y = draw.choice(sorted(squares))
            dx, dy = draw.choice(BESIDE)
            squares.add((x + dx, y + dy))
        joined = {
            frozenset((one, (one[0] + dx, one[1] + dy)))
            for one in squares
            for dx, dy in BESIDE
            if (one[0] + dx, one[1] + dy) in squares
        }
        disk = glue(squares, joined)
        for _ in range(draw.randint(0, 4)):
            if not joined:
                break
            pair = draw.choice(sorted(joined, key=sorted))
            slit = glue(squares, joined - {pair})
            if slit is not None:
                joined, disk = joined - {pair}, slit
        if disk is not None and disk[2].max() <= 4:
            yield disk


def glue(squares: set[tuple[int, int]], joined: set[frozenset[tuple[int, int]]]) -> Disk | None:
    """The squares joined across some of their common edges; None where that is no disk."""
    root = {(one, corner): (one, corner) for one in sorted(squares) for corner in range(4)}

    def find(key: tuple[tuple[int, int], int]) -> tuple[tuple[int, int], int]:
        while root[key] != key:
            key = root[key]
        return key

    rim: dict[tuple[tuple[int, int], int], tuple[tuple[int, int], int]] = {}
    edges = 0
    for one in squares:
        for edge, (dx, dy) in enumerate(BESIDE):
            other = one[0] + dx, one[1] + dy
            if frozenset((one, other)) in joined:
                edges += 1
                root[find((one, edge))] = find((other, (edge + 3) % 4))
                root[find((one, (edge + 1) % 4))] = find((other, (edge + 2) % 4))
    for one in squares:
        for edge, (dx, dy) in enumerate(BESIDE):
            if frozenset((one, (one[0] + dx, one[1] + dy))) not in joined:
                tail = find((one, edge))
                if tail in rim:
                    return None
                rim[tail] = find((one, (edge + 1) % 4))
    loop = [min(rim)]
    while rim[loop[-1]] != loop[0]:
        loop.append(rim[loop[-1]])
    vertices = {find(key) for key in root}
    if len(loop) < len(rim) or len(vertices) - edges // 2 - len(rim) + len(squares) != 1:
        return None
    inner = sorted(vertices - set(loop))
    number = {key: i for i, key in enumerate([*loop, *inner])}
    quads = np.array(
        [[number[find((one, corner))] for corner in range(4)] for one in sorted(squares)], np.int32
    )
    corners = np.bincount(quads.ravel(), minlength=len(vertices))[: len(loop)]
    return quads, len(vertices), corners.astype(np.int32)


def list_all_closed(n: int) -> Int32Array:
    """All corners (c, n) of which the loop is a closed walk that turns once, by exhaustion."""
    every = np.array(list(product((1, 2, 3, 4), repeat=n)), np.int32)
    every = every[(2 - every).sum(axis=1) == 4]
    turned = np.cumsum(2 - every[:, 1:], axis=1)
    ways = np.hstack([np.zeros((len(every), 1), np.int64), turned & 3])
    total = turned.min(axis=1), turned.max(axis=1)
    within = (total[0] >= -MOST_RIGHT) & (total[1] <= MOST_LEFT)
    return every[(STEPS[ways].sum(axis=1) == 0).all(axis=1) & within]


CLOSED = {n: list_all_closed(n) for n in (4, 6, 8)}


def check_regular(corners: Int32Array, quads: Int32Array, n_vertices: int) -> None:
    """The quads are a disk on the loop with these corners, and regular inside."""
    n = len(corners)
    _, fault = weld_quads(quads, n_vertices, n)
    assert not fault
    valence = np.bincount(quads.ravel(), minlength=n_vertices)
    assert (valence[:n] == corners).all() and (valence[n:] == 4).all()


@given(st.sampled_from([4, 6, 8]), st.integers(0, 2**32))
@settings(max_examples=60, deadline=None)
def test_the_most_probable_closed_walks_come_first(n: int, seed: int) -> None:
    draw = np.random.default_rng(seed)
    logs = np.log(draw.dirichlet(np.full(4, 0.5), size=n) + 1e-5)
    at = np.arange(n)
    expected = np.sort(logs[at, CLOSED[n] - 1].sum(axis=1))[::-1]
    found = list_closed_walks(logs, 25, 100_000)
    scores = np.array([logs[at, corners - 1].sum() for corners in found])
    assert len(found) == min(25, len(expected))
    assert np.allclose(scores, expected[: len(scores)], atol=1e-4)
    known = {corners.tobytes() for corners in CLOSED[n]}
    assert len({corners.tobytes() for corners in found}) == len(found)
    assert all(corners.tobytes() in known for corners in found)


@pytest.mark.parametrize("n", [4, 6, 8])
def test_what_is_built_is_regular_and_nothing_is_missed(n: int) -> None:
    built = {}
    for corners in CLOSED[n]:
        made = build_regular_fill(corners)
        if made is not None:
            check_regular(corners, *made)
            built[corners.tobytes()] = made
    # Every disk of lattice squares with so many edges around, slits among them, is one of these.
    seen = set()
    for quads, n_vertices, corners in grow_lattice_disks(200, 6, seed=n):
        if len(corners) != n:
            continue
        for turn in range(n):
            assert np.roll(corners, turn).tobytes() in built
            seen.add(np.roll(corners, turn).tobytes())
        assert len(built[corners.tobytes()][0]) == len(quads)
        assert built[corners.tobytes()][1] == n_vertices
    assert seen


def test_regular_regions_are_reproduced() -> None:
    slits = 0
    for quads, n_vertices, corners in grow_lattice_disks(300, 40, seed=1):
        made = build_regular_fill(corners)
        assert made is not None
        check_regular(corners, *made)
        assert (len(made[0]), made[1]) == (len(quads), n_vertices)
        slits += bool((corners == 4).any())
        # Where the corners are known, the walk is the first that is listed.
        n = len(corners)
        if n <= MOST_EDGES:
            logs = np.full((n, 4), -5.0)
            logs[np.arange(n), corners - 1] = -0.1
            assert (list_closed_walks(logs, 1, 10_000)[0] == corners).all()
    assert slits > 5


def test_a_walk_that_winds_twice_is_no_fill() -> None:
    # Twice around a square of four cells: closed, and turns by eight quarters.
    twice = np.array([1, 2] * 8, np.int32)
    assert build_regular_fill(twice) is None
    # A walk that turns once in all but winds around some cells twice: a spiral over itself.
    right, up, left, down = 0, 1, 2, 3
    runs = [(right, 4), (up, 3), (left, 3), (down, 2), (right, 2), (up, 4), (left, 3), (down, 5)]
    ways = [way for way, length in runs for _ in range(length)]
    assert (STEPS[ways].sum(axis=0) == 0).all()
    turns = [(b - a + 1) % 4 - 1 for a, b in zip([ways[-1], *ways[:-1]], ways, strict=True)]
    corners = 2 - np.array(turns, np.int32)
    assert (2 - corners).sum() == 8
    assert build_regular_fill(corners) is None


@pytest.mark.parametrize(
    ("corners", "n_quads"),
    [
        ([1, 1, 1, 1], 1),
        ([1, 2, 1, 2, 1, 2, 1, 2], 4),
        ([1, 2, 2, 1, 1, 2, 2, 1], 3),
        ([1, 2, 1, 1, 3, 1, 1, 2], 3),
        ([1, 1, 3, 1, 1, 3, 1, 1, 3, 1, 1, 3], 5),
        ([4, 1, 1, 2, 1, 2, 1, 2, 1, 1], 4),
    ],
)
def test_named_shapes(corners: list[int], n_quads: int) -> None:
    made = build_regular_fill(np.array(corners, np.int32))
    assert made is not None
    check_regular(np.array(corners), *made)
    assert len(made[0]) == n_quads


@given(st.integers(2, 12), st.integers(0, 2**32))
def test_rectangles_come_in_order(half: int, seed: int) -> None:
    logs = np.log(np.random.default_rng(seed).dirichlet(np.full(4, 0.5), size=2 * half))
    at = np.arange(2 * half)
    found = list_rectangles(logs, 10**6)
    scores = [logs[at, corners - 1].sum() for corners in found]
    assert len(found) == half * (half - 1) // 2
    assert all(a >= b - 1e-9 for a, b in pairwise(scores))
    for corners in found[:20]:
        made = build_regular_fill(corners)
        assert made is not None
        check_regular(corners, *made)
