"""Untangling large fills: tangles one by one, on folds and within reflex outlines."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from patterndb._native.query.placing.untangle import find_pieces
from patterndb.geometry.points import Points
from patterndb.geometry.quadshape import flipped
from query import Fill
from query.placing import Surface, enclose_region, place
from query.placing import untangle as untangling
from query.placing.laplace import HeldQuads
from query.placing.projection import SurfaceProjector, lay_on_disk, settle_whole
from query.placing.untangle import untangle
from tests.support.query.placing import grid

Height = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]

UP = np.array([0.0, 0.0, 1.0])


def folds(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    return 0.5 * np.sin(4.0 * x) * np.cos(2.4 * y)


def sheet(height: Height, n: int = 100) -> Surface:
    x, y = np.meshgrid(*[np.linspace(-2.0, 2.0, n + 1)] * 2, indexing="ij")
    k = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    quads = np.stack([k, k + n + 1, k + n + 2, k + 1], axis=1)
    faces = np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])
    return Surface.from_arrays(np.stack([x, y, height(x, y)], axis=-1).reshape(-1, 3), faces)


def wavy(edges: int, depth: float) -> Points:
    """(4 edges, 2) a square whose sides swing out and in, twice each."""
    t = np.arange(edges) / edges
    off = 0.5 * depth * np.sin(4.0 * np.pi * t)
    side = np.stack([2.0 * t - 1.0, -1.0 - off], axis=1)
    parts = [side]
    for _ in range(3):
        parts.append(parts[-1] @ np.array([[0.0, 1.0], [-1.0, 0.0]]))
    return np.concatenate(parts)


def on(height: Height, flat: Points, surface: Surface) -> Points:
    return surface.nearest(np.c_[flat, height(flat[:, 0], flat[:, 1])]).points


def crumpled(fill: Fill, seed: int, n_tangles: int) -> tuple[Points, NDArray[np.bool_]]:
    """A flat grid of 30 x 30 in which some vertices, far from one another, are thrown across."""
    chance = np.random.default_rng(seed)
    n = 30
    side = np.arange(n)
    border = np.concatenate(
        [
            np.c_[side, 0 * side],
            np.c_[0 * side + n, side],
            np.c_[n - side, 0 * side + n],
            np.c_[0 * side, n - side],
        ]
    ).astype(float)
    at = place(fill, np.c_[border, np.zeros(len(border))]).vertices.copy()
    thrown = np.zeros(len(at), np.bool_)
    middles = [(6, 6), (24, 6), (6, 24), (24, 24), (15, 15)][:n_tangles]
    for middle in middles:
        k = int(np.linalg.norm(at[:, :2] - middle, axis=1).argmin())
        at[k, :2] += chance.uniform(1.5, 2.0, 2) * chance.choice([-1, 1], 2)
        thrown[k] = True
    return at, thrown


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32), st.integers(1, 5))
def test_tangles_are_opened_and_nothing_else_moves(seed: int, n_tangles: int) -> None:
    fill = grid(30, 30)
    at, thrown = crumpled(fill, seed, n_tangles)
    normals = np.tile(UP, (len(at), 1))
    net = HeldQuads.of(fill.quads, fill.n_vertices, fill.perimeter)
    assert flipped(fill.quads, at, normals).any()
    made = untangle(net, at, normals)
    assert not flipped(fill.quads, made, normals).any()
    moved = np.linalg.norm(made - at, axis=1) > 0.0
    far = np.linalg.norm(at[:, None, :2] - at[thrown][None, :, :2], axis=2).min(axis=1) > 11.0
    assert moved.any() and not (moved & far).any()
    assert (made[: fill.perimeter] == at[: fill.perimeter]).all()


def test_a_tangle_that_cannot_be_opened_keeps_no_other_from_it() -> None:
    fill = grid(30, 30)
    at, _ = crumpled(fill, 3, 2)
    normals = np.tile(UP, (len(at), 1))
    net = HeldQuads.of(fill.quads, fill.n_vertices, fill.perimeter)
    # Two corners of the boundary change places: the quads there are crossed, come what may.
    last = np.flatnonzero((np.abs(at[:, :2] - 30.0) < 3.5).all(axis=1) & (at[:, 0] == 30.0))
    at[last] = at[last[::-1]]
    stuck = flipped(fill.quads, at, normals) & np.isin(fill.quads, last).any(axis=1)
    assert stuck.any()
    made = untangle(net, at, normals)
    remain = flipped(fill.quads, made, normals)
    middle = made[fill.quads].mean(axis=1)
    assert remain.any()
    assert (middle[remain, :2] > 20.0).all()


@settings(max_examples=40)
@given(st.integers(0, 2**32))
def test_pieces_have_no_free_vertex_in_common(seed: int) -> None:
    chance = np.random.default_rng(seed)
    fill = grid(9, 7)
    free = chance.random(fill.n_vertices) < 0.3
    quads = fill.quads[free[fill.quads].any(axis=1)]
    found = find_pieces(quads, free)
    # By brute force: names spread over common free vertices until nothing changes.
    name = np.arange(len(quads))
    while True:
        least = np.full(fill.n_vertices, len(quads))
        np.minimum.at(least, quads, np.repeat(name[:, None], 4, axis=1))
        least[~free] = len(quads)
        spread = np.minimum(name, least[quads].min(axis=1))
        if (spread == name).all():
            break
        name = spread
    same = name[:, None] == name[None]
    assert (same == (found[:, None] == found[None])).all()


@pytest.mark.parametrize("edges", [12, 30])
def test_within_a_wavy_outline_over_folds_nothing_flips(edges: int) -> None:
    surface = sheet(folds)
    fill = grid(edges, edges)
    points = on(folds, wavy(edges, 0.5), surface)
    placed = place(fill, points, surface)
    assert len(placed.flipped) == 0
    assert (placed.vertices[: fill.perimeter] == points).all()
    assert placed.off_surface < 1e-6
    # The net of the least squared edges does flip: it is not what is taken.
    assert not placed.at_rest


def test_smoothing_that_flips_nothing_shortens_the_net() -> None:
    surface = sheet(folds)
    fill = grid(20, 20)
    points = on(folds, wavy(20, 0.5), surface)
    net = HeldQuads.of(fill.quads, fill.n_vertices, fill.perimeter)
    region = enclose_region(surface, points)
    projector = SurfaceProjector(region.surface, net)
    start = lay_on_disk(region, net, points)
    assert start is not None
    start = untangle(net, start, projector.find_normals(start))
    start[fill.perimeter :] = region.surface.nearest(start[fill.perimeter :]).points

    def stretch(vertices: Points) -> float:
        edge = vertices[fill.quads] - vertices[np.roll(fill.quads, 1, axis=1)]
        return float((edge**2).sum())

    rest = settle_whole(projector, start)
    assert not (projector.find_flipped(rest.vertices) & ~projector.find_flipped(start)).any()
    assert stretch(rest.vertices) < stretch(start)
    assert (rest.vertices[: fill.perimeter] == points).all()
    assert rest.rounds >= 1


def test_what_untangling_does_not_move_is_not_untangled_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fill = grid(6, 6)
    turn = 2.0 * np.pi * (np.arange(fill.perimeter) + 0.5) / fill.perimeter
    # An eight: what lies in one half of it is always turned over.
    eight = np.stack([np.cos(turn), np.sin(turn) * np.cos(turn), np.zeros_like(turn)], axis=1)
    still: list[bool] = []

    def watch(net: HeldQuads, vertices: Points, *more: Any) -> Points:
        moved = untangle(net, vertices, *more)
        still.append(bool(np.abs(moved - vertices).max() <= 1e-9))
        return moved

    monkeypatch.setattr(untangling, "untangle", watch)
    flat = sheet(lambda x, _: np.zeros_like(x), 40)
    region = enclose_region(flat, eight)
    assert len(place(fill, eight, region).flipped)
    assert any(still)
    # After one that moved nothing comes none from the same place, but for other beginnings.
    assert still.count(True) <= 3 and len(still) <= 12
