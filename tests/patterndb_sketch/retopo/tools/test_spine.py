"""The spine tool in a network on the surface."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import trimesh

from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network import Network, are_equal, check_network
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tools.spine import draw_spine, preview_spine
from patterndb_sketch.retopo.tracing import SurfaceCurve, clean_stroke
from tests.support.retopo.boundaries import same_corners
from tests.support.retopo.planes import (
    SIZES,
    corners_of,
    plane_surface,
    polygons,
    stroke,
    t_junctions,
    up,
)

Polygon = list[tuple[float, float, bool]]

#: The tolerance of the cases: a sample, and what the parameterisation is off.
NEAR = 0.06

P = [(-5.0, -4.0, True), (5.0, -4.0, True), (5.0, -0.1, True), (-5.0, -0.1, True)]
P_CORNER: Polygon = [*P[:3], (0.6, -0.1, True), (-5.0, -0.1, True)]
RIGHT: Polygon = [(0.8, -3.0, True), (5.0, -3.0, True), (5.0, 7.0, True), (0.8, 7.0, True)]
RIGHT_CORNERS: Polygon = [*RIGHT, (0.8, 3.9, True), (0.8, 0.2, True)]
BENT: Polygon = [
    (0.8, -3.0, True),
    (5.0, -3.0, True),
    (4.0, 5.2, True),
    (0.8, 2.0, False),
]
SLANTED: Polygon = [(0.5, -3.0, True), (5.0, -3.0, True), (5.0, 7.0, True), (1.5, 7.0, True)]
A: Polygon = [(0.8, -3.0, True), (3.0, -3.0, True), (3.0, 1.0, True), (0.8, 1.0, True)]
B: Polygon = [(0.8, 3.0, True), (3.0, 3.0, True), (3.0, 7.0, True), (0.8, 7.0, True)]
LOW: Polygon = [(-5.0, -4.0, True), (5.0, -4.0, True), (5.0, 0.0, True), (-5.0, 0.0, True)]
HIGH: Polygon = [(-5.0, 4.0, True), (5.0, 4.0, True), (5.0, 7.0, True), (-5.0, 7.0, True)]

SPINE = stroke((0.0, 0.0), (0.0, 4.0))

CASES = {
    "a": ([], [(-1, 0), (1, 0), (1, 4), (-1, 4)], [], 4),
    "b": ([P], [(-1, -0.1), (1, -0.1), (1, 4), (-1, 4)], [], 3),
    "c": ([RIGHT], [(-1, 0), (0.8, 0), (0.8, 4), (-1, 4)], [], 3),
    "d": ([P_CORNER], [(-1, -0.1), (0.6, -0.1), (1, 4), (-1, 4)], [], 3),
    "e": ([RIGHT_CORNERS], [(-1, 0), (0.8, 0.2), (0.8, 3.9), (-1, 4)], [], 3),
    "f": ([BENT], [(-1, 0), (0.8, 0), (1, 4), (-1, 4)], [(0.8, 2)], 4),
    "g": ([SLANTED], [(-1, 0), (0.8, 0), (1, 4), (-1, 4)], [(1, 2)], 4),
    "resume": ([A, B], [(-1, 0), (0.8, 0), (0.8, 4), (-1, 4)], [(0.8, 1), (0.8, 3)], 4),
    "bridge": ([LOW, HIGH], [(-1, 0), (1, 0), (1, 4), (-1, 4)], [], 2),
}


@cache
def coarse_surface() -> Surface:
    """The same sheet in triangles several times as large as the patches, turned aslant."""
    n, turn = 5, 0.4
    x, y = np.meshgrid(np.linspace(-16, 16, n), np.linspace(-16, 16, n), indexing="ij")
    flat = np.stack([x.ravel(), y.ravel()], axis=1)
    flat = flat @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    k = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    faces = [np.stack([k, k + n, k + n + 1], axis=1), np.stack([k, k + n + 1, k + 1], axis=1)]
    return Surface.from_arrays(np.c_[flat, np.zeros(n * n)], np.concatenate(faces)).orient()


@pytest.mark.parametrize("surface", [plane_surface, coarse_surface])
@pytest.mark.parametrize("name", CASES)
def test_every_case_of_the_figure_has_its_patch(name: str, surface: Callable[[], Surface]) -> None:
    drawn, corners, junctions, curves = CASES[name]
    before = polygons(*drawn)
    kept = {patch: corners_of(before, patch) for patch in before.patches}
    edit = draw_spine(before, surface(), SPINE, SIZES)
    after = edit.network
    check_network(after)
    (made,) = (p for p in edit.patches if p not in kept and _is_new(after, p, kept))
    assert same_corners(corners_of(after, made), corners, NEAR), corners_of(after, made)
    found = t_junctions(after, made)
    assert len(found) == len(junctions)
    for junction in junctions:
        assert min(np.hypot(x - junction[0], y - junction[1]) for x, y in found) < NEAR
    old = sum(1 for chain in after.chains if chain not in edit.chains)
    assert old <= len(before.chains)
    # The patches that were there keep their corners; the new one's are T-junctions of theirs.
    assert len(after.patches) == len(before.patches) + 1
    for expected in kept.values():
        assert any(
            same_corners(corners_of(after, p), [tuple(c) for c in expected], 1e-9)
            for p in after.patches
        )
    assert len(preview_spine(before, surface(), SPINE, SIZES).curves(SIZES)) == curves


def _is_new(network: Network, patch: int, kept: dict[int, np.ndarray]) -> bool:
    corners = corners_of(network, patch)
    return not any(same_corners(corners, [tuple(c) for c in old], 1e-9) for old in kept.values())


def test_the_patch_behind_gets_two_t_junctions() -> None:
    before = polygons(P)
    after = draw_spine(before, plane_surface(), SPINE, SIZES).network
    behind = next(p for p in after.patches if (corners_of(after, p)[:, 1] < -3.9).any())
    found = sorted(t_junctions(after, behind))
    assert np.allclose(found, [(-1, -0.1), (1, -0.1)], atol=NEAR)


def test_one_spine_after_the_other_shares_their_boundary() -> None:
    network = draw_spine(Network(), plane_surface(), SPINE, SIZES).network
    for x in (1.9, 3.8, -1.9):
        edit = draw_spine(network, plane_surface(), stroke((x, 0.1), (x, 3.9)), SIZES)
        network = edit.network
        check_network(network)
        assert len(edit.chains) == 3
    assert len(network.patches) == 4
    # A row of four: every boundary between two is one chain with a patch on either side.
    assert len(network.chains) == 4 + 3 * 3


@pytest.mark.parametrize(
    ("drawn", "words"),
    [
        (SurfaceCurve(SPINE.points, SPINE.normals, True), "closed"),
        (replace(SPINE, points=SPINE.points[:2], normals=SPINE.normals[:2]), "longer"),
        (replace(SPINE, missed=3), "off the surface"),
    ],
)
def test_what_is_no_spine_is_refused(drawn: SurfaceCurve, words: str) -> None:
    with pytest.raises(RefusedError, match=words):
        draw_spine(Network(), plane_surface(), drawn, SIZES)


def test_a_patch_across_a_curve_is_refused_and_nothing_changes() -> None:
    before = polygons([(-5.0, 1.9, True), (5.0, 1.9, True), (5.0, 2.1, True), (-5.0, 2.1, True)])
    kept = replace(before)
    with pytest.raises(RefusedError, match="cross"):
        draw_spine(before, plane_surface(), SPINE, SIZES)
    assert are_equal(before, kept)


def test_a_stroke_beside_the_surface_border_is_refused_beyond_it() -> None:
    points = np.c_[np.linspace(7.5, 7.5, 40), np.linspace(-2, 2, 40), np.zeros(40)]
    with pytest.raises(RefusedError, match="beyond the surface"):
        draw_spine(Network(), plane_surface(), SurfaceCurve(points, up(points), False), SIZES)


@pytest.mark.parametrize("rounds", [1, 2, 3])
@pytest.mark.parametrize("share", [1.0, 0.5, 0.25])
def test_spines_are_as_wide_as_asked_on_triangles_of_any_size(rounds: int, share: float) -> None:
    ball = trimesh.creation.icosphere(subdivisions=rounds)
    surface = Surface.from_arrays(ball.vertices, ball.faces).orient()
    sizes = Sizes.of(surface.diagonal)
    sizes = replace(sizes, spine=share * sizes.spine)
    rng = np.random.default_rng(rounds)
    for _ in range(5):
        one, two = np.linalg.qr(rng.normal(size=(3, 3)))[0][:2]
        t = np.linspace(0.0, 4.0 * sizes.spine, 40)[:, None]
        drawn = clean_stroke(np.cos(t) * one + np.sin(t) * two, surface, sizes, False)
        edit = draw_spine(Network(longest=10.0), surface, drawn, sizes)
        check_network(edit.network)
        (patch,) = edit.network.patches.values()
        assert len(patch.corners) == 4
        # All four curves are on the ball's triangles, and the flanks half a width off.
        points = np.concatenate([chain.points for chain in edit.network.chains.values()])
        assert np.abs(surface.nearest(points).points - points).max() < 1e-6
        far = np.linalg.norm(points[:, None] - drawn.points, axis=2).min(axis=1).max()
        # Of 80 triangles neighbours turn by 36 degrees, which a flat map cannot have.
        assert far == pytest.approx(sizes.spine, rel=0.12 if rounds > 1 else 0.35)
