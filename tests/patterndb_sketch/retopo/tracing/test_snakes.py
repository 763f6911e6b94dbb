"""Snakes: curvature of the surface, and curves that move to ridges and valleys."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from patterndb._native.retopo.tools.salience import sum_dots
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.network import (
    Network,
    add_borders,
    add_chain,
    add_loop,
    check_network,
    set_choice,
)
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tools.align import align_chain, align_nearest, align_node, move_snake
from patterndb_sketch.retopo.tools.salience import MODES, REACH, WIDTH, Mode, Salience
from patterndb_sketch.retopo.tools.stroke import insert_stroke
from patterndb_sketch.retopo.tracing import SurfaceCurve, clean_stroke
from tests.support.retopo.networks import SIZES, drawn, even, flat, plane
from tests.support.retopo.networks import up as plane_up
from tests.support.retopo.surfaces import bumps, sphere

#: Of the edges of the cube.
RADIUS = 0.1

#: How far the ridge, the middle of a rounded edge of the cube, is from the cube's middle.
RIDGE = 0.5 - RADIUS + RADIUS / np.sqrt(2.0)


@cache
def cube(segments: int, flat_ones: int, inside_out: bool = False) -> Surface:
    """A cube from -0.5 to 0.5, its edges rounded by a radius, with 2 * segments strips across
    each and squares of ``flat_ones`` rows on its sides; inside out its edges are valleys."""
    inner = 0.5 - RADIUS
    bend = np.tan(np.linspace(np.pi / 4.0, 0.0, segments + 1))[:-1]
    row = np.concatenate(
        [
            np.c_[np.full(segments, -inner), -bend],
            np.c_[np.linspace(-inner, inner, flat_ones + 1), np.zeros(flat_ones + 1)],
            np.c_[np.full(segments, inner), bend[::-1]],
        ]
    )
    m = len(row)
    x, y = (grid.ravel() for grid in np.meshgrid(np.arange(m), np.arange(m), indexing="ij"))
    towards = np.c_[row[x, 1], row[y, 1], np.ones(m * m)]
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    top = np.c_[row[x, 0], row[y, 0], np.full(m * m, inner)] + RADIUS * towards
    k = np.arange(m * m).reshape(m, m)
    a, b, c, d = (part.ravel() for part in (k[:-1, :-1], k[1:, :-1], k[1:, 1:], k[:-1, 1:]))
    faces = np.concatenate([np.c_[a, b, c], np.c_[a, c, d]])
    points, triangles = [], []
    for axis in range(3):
        for sign in (1, -1):
            triangles.append((faces if sign > 0 else faces[:, ::-1]) + len(points) * m * m)
            points.append(sign * np.roll(top, axis, axis=1))
    together = np.concatenate(triangles)
    places = np.round(np.concatenate(points), 9)
    return Surface.from_arrays(places, together[:, ::-1] if inside_out else together).orient()


def sizes(edge: float) -> Sizes:
    return Sizes(snap=0.02, spine=0.1, autocompletion=0.1, brush=0.1, edge=edge, sampling=0.004)


def beside(surface: Surface, off: float, half: float = 0.25) -> SurfaceCurve:
    """A line on the top of the cube, parallel to an edge along y, and this far off its plane."""
    line = even([[0.5 - off, -half, 0.5], [0.5 - off, half, 0.5]], step=0.004)
    return SurfaceCurve(line, surface.nearest(line).normals, False)


def off_ridge(points: np.ndarray) -> np.ndarray:
    return np.hypot(points[:, 0] - RIDGE, points[:, 2] - RIDGE)


@pytest.mark.parametrize("edge", [RADIUS / 2, RADIUS, 2 * RADIUS])
@pytest.mark.parametrize("tessellation", [(2, 1), (6, 12)])
def test_a_line_beside_a_rounded_edge_moves_to_its_ridge(
    edge: float, tessellation: tuple[int, int]
) -> None:
    surface, at = cube(*tessellation), sizes(edge)
    stroke = beside(surface, 2.0 * RADIUS)
    salience = Salience.of(surface, edge)
    network = insert_stroke(Network(), surface, at, stroke).network
    (chain,) = network.chains
    edit = align_nearest(
        network, surface, at, salience, stroke.points[60], stroke.normals[60], "ridge"
    )
    check_network(edit.network)
    line = edit.network.chains[chain]
    assert off_ridge(stroke.points).min() > 1.4 * RADIUS
    middle = np.abs(line.points[:, 1]) < 0.05
    assert middle.sum() > 10
    assert off_ridge(line.points[middle]).max() < 0.2 * RADIUS
    # Its ends stay, exactly; it is led from them, and does not fold.
    assert (line.points[[0, -1]] == stroke.points[[0, -1]]).all()
    assert (np.diff(line.points[:, 1])[3:-3] > -1e-4).all()
    feet = surface.nearest(line.points)
    assert np.linalg.norm(feet.points - line.points, axis=1).max() < 2e-3


def test_noise_of_the_triangles_hardly_matters() -> None:
    smooth, at = cube(6, 24), sizes(RADIUS)
    shake = np.random.default_rng(0).normal(0.0, 0.02 * RADIUS, smooth.vertices.shape)
    surface = Surface.from_arrays(smooth.vertices + shake, smooth.triangles).orient()
    foot = surface.nearest(beside(smooth, 2.0 * RADIUS).points)
    salience = Salience.of(surface, at.edge)
    points, _, _ = move_snake(foot.points, foot.normals, False, surface, at, salience, "ridge")
    assert off_ridge(points[np.abs(points[:, 1]) < 0.05]).max() < 0.05 * RADIUS


@pytest.mark.parametrize("mode", MODES)
def test_inside_out_the_edges_are_valleys(mode: Mode) -> None:
    surface, at = cube(2, 1, True), sizes(RADIUS)
    stroke = beside(surface, 1.5 * RADIUS)
    salience = Salience.of(surface, at.edge)
    network = insert_stroke(Network(), surface, at, stroke).network
    (chain,) = network.chains
    if mode == "ridge":
        with pytest.raises(RefusedError, match="no ridge"):
            align_chain(network, surface, at, salience, chain, mode)
        return
    done = align_chain(network, surface, at, salience, chain, mode).network
    check_network(done)
    line = done.chains[chain].points
    assert off_ridge(line[np.abs(line[:, 1]) < 0.05]).max() < 0.2 * RADIUS


def test_a_closed_curve_around_the_cube_moves_to_four_edges() -> None:
    surface, at = cube(2, 1), sizes(RADIUS)
    side = 0.5 - RADIUS
    turn = np.linspace(-np.pi / 4, np.pi / 4, 12)
    corner = side + RADIUS * np.c_[np.cos(turn), np.sin(turn)] @ _turned(np.pi / 4)
    ring = np.concatenate([corner @ _turned(k * np.pi / 2) for k in range(4)])
    line = even(np.c_[ring, np.full(len(ring), 0.5 - 1.8 * RADIUS)], True, 0.004)
    foot = surface.nearest(line)
    network, chain = add_loop(Network(), foot.points, foot.normals)
    salience = Salience.of(surface, at.edge)
    done = align_chain(network, surface, at, salience, chain, "ridge").network
    check_network(done, patches=False)
    points = done.chains[chain].points
    flat_side = np.abs(points[:, :2]).min(axis=1) < 0.25
    high, out = points[flat_side, 2], np.abs(points[flat_side, :2]).max(axis=1)
    assert flat_side.sum() > 200
    assert np.hypot(high - RIDGE, out - RIDGE).max() < 0.2 * RADIUS


def _turned(angle: float) -> np.ndarray:
    return np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])


def test_on_a_plane_a_line_stays() -> None:
    salience = Salience.of(plane(), SIZES.edge)
    line = even([[0.0, 0.0], [1.0, 0.7]])
    for mode in MODES:
        points, normals, last = move_snake(
            line, plane_up(line), False, plane(), SIZES, salience, mode
        )
        assert last < 1e-9
        assert np.abs(points - line).max() < 1e-9
        assert np.abs(normals - plane_up(line)).max() < 1e-9
    network = drawn([[0.0, 0.0], [1.0, 0.7]])
    (chain,) = network.chains
    with pytest.raises(RefusedError, match="no ridge or valley"):
        align_chain(network, plane(), SIZES, salience, chain)


def test_curvature_is_that_of_spheres_tubes_and_cubes_whatever_the_triangles() -> None:
    """Against what is known of smooth surfaces, with the width small beside their radii."""
    ball = sphere(4)
    edge = 0.2
    felt, pull = Salience.of(ball, edge).feel(ball.vertices[:200], ball.normals[:200], "ridge")
    # Weights are by straight distance, and fall short of the flat disk's by about edge^2.
    assert felt == pytest.approx(edge, rel=0.05)
    assert np.linalg.norm(pull, axis=1).max() < 0.05 * edge
    none, _ = Salience.of(ball, edge).feel(ball.vertices[:200], ball.normals[:200], "valley")
    assert none.max() < 1e-3
    both, _ = Salience.of(ball, edge).feel(ball.vertices[:200], ball.normals[:200], "both")
    assert both == pytest.approx(felt)
    at = np.array([[RIDGE, y, RIDGE] for y in np.linspace(-0.1, 0.1, 5)])
    small = 0.1 * RADIUS
    for surface, rough in ((cube(2, 1), 0.3), (cube(12, 1), 0.02)):
        foot = surface.nearest(at)
        felt, _ = Salience.of(surface, 3.0 * small).feel(foot.points, foot.normals, "ridge")
        assert felt == pytest.approx(3.0 * small / RADIUS, rel=rough + 0.05)


def test_the_pull_is_the_gradient_of_the_feature_over_itself() -> None:
    """Against differences, along the surface, where the feature is strong."""
    surface = cube(6, 12)
    edge = RADIUS
    salience = Salience.of(surface, edge)
    x = np.linspace(0.5 - 2.5 * RADIUS, 0.5 - 1.1 * RADIUS, 8)
    at = np.c_[x, np.full(len(x), 0.05), np.full(len(x), 0.5)]
    up = np.tile([0.0, 0.0, 1.0], (len(x), 1))
    step = 1e-5
    for axis in (0, 1):
        off = np.zeros(3)
        off[axis] = step
        more, less = (salience.feel(at + s * off, up, "ridge")[0] for s in (1, -1))
        feature, pull = salience.feel(at, up, "ridge")
        slope = (more - less) / (2.0 * step)
        faint = np.deg2rad(1.0)
        assert pull[:, axis] == pytest.approx(edge**2 * slope / (feature + faint), abs=1e-4 * edge)


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_sums_over_cells_are_those_over_all_dots(seed: int) -> None:
    """The kernel, against all pairs of points and dots."""
    rng = np.random.default_rng(seed)
    salience = Salience.of(bumps(1), 10.0 ** rng.uniform(-2.0, 0.0))
    at = rng.uniform(-0.3, 1.3, (20, 3))
    up = rng.normal(size=(20, 3))
    width = WIDTH * salience.edge
    ways = salience.points[None] - at[:, None]
    far = np.linalg.norm(ways, axis=2) / width
    weight = np.exp(-0.5 * far**2) * (far <= REACH) * (up @ salience.normals.T > 0.0)
    expected = np.empty((20, 4, 6))
    expected[:, 0] = weight @ salience.tensors
    expected[:, 1:] = np.einsum("nd,ndc,dk->nck", weight, ways, salience.tensors)
    found = sum_dots(
        at,
        up,
        salience.points,
        salience.normals,
        salience.tensors,
        salience._low,
        salience._keys,
        salience._starts,
        width,
    )
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-15)


@settings(max_examples=10)
@given(st.integers(0, 2**32 - 1))
def test_the_direction_of_a_curve_does_not_matter(seed: int) -> None:
    rng = np.random.default_rng(seed)
    surface = bumps(2)
    size = replace(Sizes.of(surface.diagonal), sampling=0.01)
    salience = Salience.of(surface, size.edge)
    ends = rng.uniform(0.1, 0.9, (2, 2))
    if np.linalg.norm(ends[1] - ends[0]) < 0.2:
        return
    line = clean_stroke(np.c_[ends, np.zeros(2)], surface, size, closed=False)
    mode: Mode = MODES[int(rng.integers(3))]
    one, up, last = move_snake(line.points, line.normals, False, surface, size, salience, mode)
    back = line.points[::-1].copy(), line.normals[::-1].copy()
    two, down, other = move_snake(*back, False, surface, size, salience, mode)
    assert np.abs(one - two[::-1]).max() < 1e-6
    assert np.abs(up - down[::-1]).max() < 1e-4
    assert last == pytest.approx(other, abs=1e-5)
    assert (one[[0, -1]] == line.points[[0, -1]]).all()
    feet = surface.nearest(one)
    assert np.linalg.norm(feet.points - one, axis=1).max() < 1e-9


def test_what_is_felt_turns_with_the_surface() -> None:
    surface = bumps(3)
    turn = Rotation.from_rotvec([0.3, -1.1, 0.7]).as_matrix()
    other = Surface.from_arrays(surface.vertices @ turn.T, surface.triangles).orient()
    at, up = surface.vertices[100:200], surface.normals[100:200]
    for mode in MODES:
        one, pull = Salience.of(surface, 0.1).feel(at, up, mode)
        two, pulled = Salience.of(other, 0.1).feel(at @ turn.T, up @ turn.T, mode)
        # Dots are taken together by cells, which do not turn.
        assert np.abs(one - two).max() < 0.05 * one.max()
        assert np.abs(np.einsum("nc,nc->n", pull, up)).max() < 1e-12
        assert np.median(np.linalg.norm(pull @ turn.T - pulled, axis=1)) < 0.01


def test_the_sides_of_a_thin_sheet_do_not_feel_each_other() -> None:
    # Two sheets, back to back and closer than a target edge; the lower one has a ridge.
    low = [[-1, -1, 0], [1, -1, 0], [1, 0, 0.0], [-1, 0, 0], [1, 1, 0], [-1, 1, 0]]
    ridge = np.array(low, float) + np.array([0, 0, -0.01])
    ridge[2:4, 2] -= 0.3
    points = np.concatenate([np.array(low, float), ridge])
    up = [[0, 1, 2], [0, 2, 3], [3, 2, 4], [3, 4, 5]]
    down = [[c + 6, b + 6, a + 6] for a, b, c in up]
    surface = Surface.from_arrays(points, up + down).orient()
    salience = Salience.of(surface, 0.4)
    feature, pull = salience.feel([[0, 0.1, 0.0]], [[0, 0, 1.0]], "both")
    assert feature[0] == 0.0 and not pull.any()
    feature, _ = salience.feel([[0, 0.1, -0.28]], [[0, 0, -1.0]], "ridge")
    assert feature[0] > 0.1


def test_a_corner_moves_and_its_curves_follow() -> None:
    surface, at = cube(2, 1), sizes(RADIUS)
    stroke = beside(surface, 1.6 * RADIUS)
    network = insert_stroke(Network(), surface, at, stroke).network
    across = even([[0.5 - 1.6 * RADIUS, 0.0, 0.5], [-0.2, 0.0, 0.5]], step=0.004)
    network = insert_stroke(
        network, surface, at, SurfaceCurve(across, surface.nearest(across).normals, False)
    ).network
    (tee,) = [node for node in network.nodes.values() if node.valence == 3]
    salience = Salience.of(surface, at.edge)
    edit = align_nearest(network, surface, at, salience, tee.point, tee.normal, "ridge")
    check_network(edit.network)
    assert (edit.nodes, edit.chains) == ((), ())
    moved = edit.network.nodes[tee.id]
    assert off_ridge(moved.point[None])[0] < 0.2 * RADIUS
    for node in network.nodes.values():
        if node.id != tee.id:
            assert (edit.network.nodes[node.id].point == node.point).all()
    assert edit.network.nodes[tee.id].corner_flags == tee.corner_flags


def test_patches_stay_and_crossings_are_told() -> None:
    surface, at = cube(2, 1), sizes(RADIUS)
    salience = Salience.of(surface, at.edge)
    network = Network()
    corners = np.array([[0.32, -0.2, 0.5], [0.32, 0.2, 0.5], [0.1, 0.2, 0.5], [0.1, -0.2, 0.5]])
    chains: list[int] = []
    for k in range(4):
        line = even(np.stack([corners[k], corners[(k + 1) % 4]]), step=0.004)
        network = insert_stroke(
            network, surface, at, SurfaceCurve(line, surface.nearest(line).normals, False)
        ).network
    (patch,) = network.patches
    network = set_choice(network, patch, "a fill")
    chains = [c.id for c in network.chains.values() if np.ptp(c.points[:, 0]) < 1e-9]
    side = max(chains, key=lambda c: network.chains[c].points[0, 0])
    edit = align_chain(network, surface, at, salience, side, "ridge")
    check_network(edit.network)
    assert edit.network.patches == network.patches
    assert not any("crosses" in note for note in edit.notes)
    # A curve in between is run over.
    between = even([[0.36, -0.1, 0.5], [0.36, 0.3, 0.5]], step=0.004)
    network, _ = add_chain(network, between, np.tile([0.0, 0.0, 1.0], (len(between), 1)))
    edit = align_chain(network, surface, at, salience, side, "ridge")
    check_network(edit.network, patches=False)
    assert any("crosses" in note for note in edit.notes)


def test_what_cannot_be_aligned_is_refused() -> None:
    surface, at = cube(2, 1), sizes(RADIUS)
    salience = Salience.of(surface, at.edge)
    network = insert_stroke(Network(), surface, at, beside(surface, 2 * RADIUS)).network
    (chain,) = network.chains
    with pytest.raises(RefusedError, match="no curve is near"):
        align_nearest(network, surface, at, salience, (-0.4, 0, 0.5), (0, 0, 1))
    with pytest.raises(InvalidRetopoError, match="ridge, valley, both"):
        align_chain(network, surface, at, salience, chain, "crest")  # pyright: ignore
    with pytest.raises(InvalidRetopoError, match="target edge"):
        align_chain(network, surface, replace(at, edge=0.05), salience, chain)
    with pytest.raises(InvalidRetopoError, match="no chain 999"):
        align_chain(network, surface, at, salience, 999)
    with pytest.raises(InvalidRetopoError, match="no node 999"):
        align_node(network, surface, at, salience, 999)
    short, few = add_chain(Network(), [[0.3, 0, 0.5], [0.3, 0.1, 0.5]], [[0, 0, 1]] * 2)
    with pytest.raises(RefusedError, match="fewer than 5"):
        align_chain(short, surface, at, salience, few)
    for bad in (0.0, -1.0, np.nan, 1e-9):
        with pytest.raises(InvalidRetopoError, match="target edge"):
            Salience.of(surface, bad)
    bordered = add_borders(Network(), plane(), 0.02)
    (border,) = bordered.chains
    none = Salience.of(plane(), SIZES.edge)
    with pytest.raises(RefusedError, match="border"):
        align_chain(bordered, plane(), SIZES, none, border)
    line = insert_stroke(bordered, plane(), SIZES, flat([[5, 0], [4, 0]])).network
    (tee,) = [node for node in line.nodes.values() if node.valence == 3]
    (end,) = [node for node in line.nodes.values() if node.open]
    with pytest.raises(RefusedError, match="border"):
        align_node(line, plane(), SIZES, none, tee.id)
    with pytest.raises(RefusedError, match="no ridge or valley is near the corner"):
        align_node(line, plane(), SIZES, none, end.id)
