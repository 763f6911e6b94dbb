"""Fairing across curves: normals agree where the surface goes on, creases and curves stay."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from patterndb_sketch.curvenetwork.network import Curve, CurveNetwork, Cycle
from patterndb_sketch.surfacing.fairing import find_smooth_curves
from patterndb_sketch.surfacing.methods import SurfaceRequest
from patterndb_sketch.surfacing.patch import Surfacing
from patterndb_sketch.surfacing.sampling import (
    default_spacing,
    sample,
)
from patterndb_sketch.surfacing.surfaces import LoopMemory, surface
from patterndb_sketch.surfacing.tessellation import area
from tests.support.surfacing.networks import cube, faces_network, shuffled, torus

FAIR = SurfaceRequest(fair=True)


def bent(network: CurveNetwork, onto: object, edges: int = 40) -> CurveNetwork:
    """The network with its straight curves put onto a surface, point by point."""
    shares = np.linspace(0.0, 1.0, edges + 1)[:, None]
    nodes = onto(network.nodes)  # type: ignore[operator]
    curves: list[Curve] = []
    for curve in network.curves:
        a, b = curve.points[[0, -1]]
        points = onto((1.0 - shares) * a + shares * b)  # type: ignore[operator]
        points[[0, -1]] = nodes[list(curve.nodes)]
        curves.append(replace(curve, points=points))
    return CurveNetwork(tuple(curves), nodes, network.cycles)


def onto_sphere(points: Points) -> Points:
    return points / np.linalg.norm(points, axis=-1, keepdims=True)


def octants() -> CurveNetwork:
    """A sphere in eight: three curves around each patch, four at each node."""
    points = np.concatenate([np.eye(3), -np.eye(3)])
    faces = [
        [x, y, z] if (x < 3) ^ (y < 3) ^ (z < 3) else [x, z, y]
        for x in (0, 3)
        for y in (1, 4)
        for z in (2, 5)
    ]
    return bent(faces_network(points, faces), onto_sphere)


def cubed_sphere() -> CurveNetwork:
    """A sphere in six: at each node three curves, none of which goes on in another."""
    flat = cube()
    centred = faces_network(
        2.0 * flat.nodes - 1.0, [list(flat.walk(cycle)) for cycle in flat.cycles]
    )
    return bent(centred, onto_sphere)


def barrel() -> CurveNetwork:
    """A round can whose side bulges, in four, with two flat lids."""
    angles = np.arange(4) * math.pi / 2.0
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    points = np.concatenate([np.c_[ring, np.full(4, -1.0)], np.c_[ring, np.full(4, 1.0)]])
    faces = [[i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i] for i in range(4)]
    network = faces_network(points, [*faces, [3, 2, 1, 0], [4, 5, 6, 7]])

    def onto(points: Points) -> Points:
        radius = 1.3 - 0.3 * points[..., 2:] ** 2
        flat = points[..., :2] / np.linalg.norm(points[..., :2], axis=-1, keepdims=True)
        return np.concatenate([radius * flat, points[..., 2:]], axis=-1)

    return bent(network, onto)


def angles_across(made: Surfacing, curves: Sequence[int]) -> NDArray[np.float64]:
    """Degrees between the two faces at every edge of some curves."""
    triangles = made.triangles
    corners = made.points[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    beside: dict[frozenset[int], list[int]] = {}
    for face, (a, b, c) in enumerate(triangles.tolist()):
        for edge in ((a, b), (b, c), (c, a)):
            beside.setdefault(frozenset(edge), []).append(face)
    found: list[float] = []
    for curve in curves:
        along = made.sampling.along[curve].tolist()
        for edge in pairwise(along):
            one, other = normals[beside[frozenset(edge)]]
            found.append(math.degrees(math.acos(min(1.0, max(-1.0, float(one @ other))))))
    return np.array(found)


def far_from_sphere(made: Surfacing) -> NDArray[np.float64]:
    """How far the middles of faces are from the unit sphere."""
    return np.abs(np.linalg.norm(made.points[made.triangles].mean(axis=1), axis=1) - 1.0)


@pytest.mark.parametrize("network", [octants(), cubed_sphere()], ids=["octants", "cube"])
def test_a_sphere_in_patches_has_one_normal_along_its_curves(network: CurveNetwork) -> None:
    before, after = surface(network), surface(network, request=FAIR)
    every = range(len(network.curves))
    assert after.notes == (f"faired across {len(every)} of {len(every)} curves between patches",)
    assert angles_across(after, every).mean() < angles_across(before, every).mean()
    assert angles_across(after, every).max() < angles_across(before, every).max()
    # The sphere itself bends from face to face: no curve stands out by more than its other edges.
    assert angles_across(after, every).mean() < math.degrees(2.0 * after.sampling.spacing)
    # Nothing but the curves told where the sphere is: it is nearer, too.
    assert far_from_sphere(after).mean() < 0.8 * far_from_sphere(before).mean()
    assert far_from_sphere(after).max() < far_from_sphere(before).max()
    assert [patch.note for patch in after.patches] == [""] * len(network.cycles)
    for one, other in zip(before.patches, after.patches, strict=True):
        assert all(map(np.array_equal, one.faces, other.faces))


def test_curves_stay_to_the_bit() -> None:
    network = octants()
    before, after = surface(network), surface(network, request=FAIR)
    n = len(before.sampling.points)
    assert before.points[:n].tobytes() == after.points[:n].tobytes()
    assert len(before.points) == len(after.points)
    assert not np.array_equal(before.points, after.points)
    # What is told of patches is that of the moved ones.
    for patch in after.patches:
        assert patch.surface is not None
        assert patch.surface.points.tobytes() in after.points.tobytes()
    assert after.area == pytest.approx(area(after.points, after.triangles), rel=1e-9)


def test_creases_stay() -> None:
    # A cube has nothing else, and is flat; a barrel's rims break, its sides go on.
    flat = cube()
    assert np.array_equal(surface(flat).points, surface(flat, request=FAIR).points)
    network = barrel()
    made = surface(network, request=FAIR)
    sampling = made.sampling
    smooth = find_smooth_curves(network, sampling, network.cycles)
    upright = [i for i, curve in enumerate(network.curves) if np.ptp(curve.points[:, 2]) > 1.0]
    assert [one.curve for one in smooth] == upright
    assert made.notes == ("faired across 4 of 12 curves between patches",)
    before = surface(network)
    assert angles_across(made, upright).mean() < 0.5 * angles_across(before, upright).mean()
    rims = sorted(set(range(12)) - set(upright))
    assert angles_across(made, rims).min() > 45.0
    lids = [np.unique(np.concatenate(patch.faces)) for patch in before.patches[4:]]
    assert all(np.array_equal(before.points[lid], made.points[lid]) for lid in lids)


def test_a_patch_beside_a_flat_one_gives_way_alone() -> None:
    # A quarter of a pipe's arc goes on from a floor, along a curve.
    angle = np.linspace(0.0, math.pi / 2.0, 30)
    bend = np.stack([np.sin(angle), np.zeros(30), 1.0 - np.cos(angle)], axis=1)
    wave = 0.3 * np.sin(math.pi * np.linspace(0.0, 1.0, 30))[:, None]
    far = bend[-1] + np.linspace(0.0, 1.0, 30)[:, None] * [0.0, 2.0, 0.0]
    nodes = np.array(
        [[-1.0, 0, 0], [-1.0, 2, 0], [0, 0, 0], [0, 2, 0], bend[-1], bend[-1] + [0, 2, 0]]
    )
    shapes = [
        (nodes[[0, 1]], (0, 1)), (nodes[[0, 2]], (0, 2)), (nodes[[1, 3]], (1, 3)),
        (nodes[[2, 3]], (2, 3)), (bend, (2, 4)), (np.add(bend, [0, 2, 0]), (3, 5)),
        (far + wave * [0.0, 0.0, 1.0], (4, 5)),
    ]  # fmt: skip
    curves: list[Curve] = []
    for i, (points, ends) in enumerate(shapes):
        points = points.copy()
        points[[0, -1]] = nodes[list(ends)]
        curves.append(Curve(points, ends, i, i))
    cycles = (
        Cycle(((0, False), (2, False), (3, True), (1, True))),
        Cycle(((3, False), (5, False), (6, True), (4, True))),
    )
    network = CurveNetwork(tuple(curves), nodes, cycles)
    before, after = surface(network), surface(network, request=FAIR)
    floor = np.unique(np.concatenate(after.patches[0].faces))
    assert np.ptp(after.points[floor, 2]) == 0.0
    assert angles_across(after, [3]).mean() < angles_across(before, [3]).mean()


def test_the_result_knows_no_order_and_no_memory() -> None:
    network = octants()
    made = surface(network, request=FAIR)
    other = surface(shuffled(network, 3), request=FAIR)
    assert np.allclose(
        np.sort(made.points.round(9), axis=0), np.sort(other.points.round(9), axis=0)
    )
    memory = LoopMemory()
    surface(network, memory=memory)
    again = surface(network, request=FAIR, memory=memory)
    assert all(patch.reused for patch in again.patches)
    assert again.points.tobytes() == made.points.tobytes()
    # Unfaired is as before: memory keeps surfaces as their own loops have them.
    assert surface(network, memory=memory).points.tobytes() == surface(network).points.tobytes()


def test_other_methods_and_coarse_cages_stay_as_they_are() -> None:
    network = octants()
    for method in ("chords", "area"):
        plain, fair = (surface(network, method=method, fair=f) for f in (False, True))
        assert np.array_equal(plain.points, fair.points)
        assert fair.notes == ("faired across 0 of 12 curves between patches",)
    cage = torus(6, 4)
    sampling = sample(cage, default_spacing(cage))
    assert find_smooth_curves(cage, sampling, cage.cycles) == []
