"""Regions that are no disks of the surface: refused with the place, never filled over a void."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import trimesh
from numpy.typing import ArrayLike

from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.editor import Call, Retopology
from patterndb_sketch.retopo.filling import weld_patches
from patterndb_sketch.retopo.network.flooding import explain_no_disk
from patterndb_sketch.retopo.sizes import Sizes
from query.engine import PatternSource
from tests.support.retopo.editors import do, line


@cache
def plate(k: int, hole: float = 2.0) -> Surface:
    """A square from -5 to 5 of (2 k)^2 cells, with a square hole in its middle."""
    at = np.linspace(-5.0, 5.0, 2 * k + 1)
    x, y = np.meshgrid(at, at, indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), 0.0 * x.ravel()], axis=1)
    rows: list[list[int]] = []
    for i in range(2 * k):
        for j in range(2 * k):
            middle = np.abs([at[i] + at[i + 1], at[j] + at[j + 1]]).max() / 2.0
            if middle > hole:
                a, b = i * (2 * k + 1) + j, (i + 1) * (2 * k + 1) + j
                rows += [[a, b, b + 1], [a, b + 1, a + 1]]
    return Surface.from_arrays(points, rows).orient()


@cache
def torus() -> Surface:
    mesh = trimesh.creation.torus(3.0, 1.0, major_sections=48, minor_sections=24)
    return Surface.from_arrays(mesh.vertices, mesh.faces).orient()


@cache
def sleeve(open_end: bool) -> Surface:
    """A cone about z from radius 1 at 0 to 0.5 at 4, open at 0, and at 4 open or closed."""
    rings, around = 33, 48
    z = np.linspace(0.0, 4.0, rings)
    radius = 1.0 - z / 8.0
    turn = 2.0 * np.pi * np.arange(around) / around
    points = np.stack(
        [
            radius[:, None] * np.cos(turn),
            radius[:, None] * np.sin(turn),
            np.repeat(z[:, None], around, axis=1),
        ],
        axis=2,
    ).reshape(-1, 3)
    rows: list[list[int]] = []
    for i in range(rings - 1):
        for j in range(around):
            a, b = i * around + j, i * around + (j + 1) % around
            rows += [[a, b, b + around], [a, b + around, a + around]]
    if not open_end:
        last = (rings - 1) * around
        points = np.r_[points, [[0.0, 0.0, 4.0]]]
        rows += [[last + j, last + (j + 1) % around, len(points) - 1] for j in range(around)]
    return Surface.from_arrays(points, rows).orient()


def draw_square(editor: Retopology, half: float) -> None:
    corners = [(-half, -half), (half, -half), (half, half), (-half, half)]
    for k in range(4):
        do(editor, "stroke", points=line(corners[k - 1], corners[k]))


def measure_area(editor: Retopology) -> float:
    """The area of all quads, on a plane."""
    mesh = weld_patches(editor.fill())
    corner = mesh.vertices[mesh.quads]
    one, two = corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]
    return float((0.5 * np.cross(one, two)[:, 2]).sum())


def sizes_of(surface: Surface) -> Sizes:
    return Sizes.of(surface.diagonal)


def ring(radius: float, z: float, n: int = 200, middle: ArrayLike = (0, 0)) -> np.ndarray:
    turn = 2.0 * np.pi * np.arange(n) / n
    x, y = middle
    return np.stack([x + radius * np.cos(turn), y + radius * np.sin(turn), np.full(n, z)], axis=1)


@pytest.mark.parametrize("k", [5, 10, 40])
@pytest.mark.parametrize("half", [2.3, 3.0, 3.4])
def test_strokes_around_a_hole_of_the_surface_get_no_quads(
    source: PatternSource, k: int, half: float
) -> None:
    """However large the triangles are: at 2.3 the strokes cross those at the hole's border."""
    surface = plate(k)
    editor = Retopology(surface, source, sizes_of(surface))
    draw_square(editor, half)
    found = editor.fill()
    assert not found.placed
    assert any("a border of the surface lies within it, at (" in note for note in found.notes)
    # Curves to the border make patches of what is there.
    for x, y in ((1, 1), (-1, 1), (-1, -1), (1, -1)):
        do(editor, "stroke", points=line((half * x, half * y), (2.0 * x, 2.0 * y)))
    found = editor.fill()
    assert len(found.placed) == 4 and not any("has no quads" in note for note in found.notes)
    assert measure_area(editor) == pytest.approx(4.0 * half**2 - 16.0)


def test_a_patch_beside_a_hole_is_filled(source: PatternSource) -> None:
    surface = plate(10)
    editor = Retopology(surface, source, sizes_of(surface))
    for a, b in (((2, 1), (4, 1)), ((4, 1), (4, -1)), ((4, -1), (2, -1))):
        do(editor, "stroke", points=line(a, b))
    assert measure_area(editor) == pytest.approx(4.0)


def test_a_hole_cannot_be_made_a_patch(source: PatternSource) -> None:
    surface = plate(10)
    editor = Retopology(surface, source, sizes_of(surface))
    draw_square(editor, 3.0)
    assert editor.do(Call("patch", {"at": [2.9, 0, 0], "off": True})).changed
    outcome = editor.do(Call("patch", {"at": [2.9, 0, 0]}))
    assert outcome.refused is not None and "a border of the surface" in outcome.refused


def test_the_default_cap_of_a_cylinder_does_not_close_an_open_end(source: PatternSource) -> None:
    for open_end, patches in ((True, 4), (False, 5)):
        surface = sleeve(open_end)
        editor = Retopology(surface, source, sizes_of(surface))
        do(editor, "loop", at=[0.9, 0, 1.0], normal=[0, 0, 1])
        do(editor, "loop", at=[0.55, 0, 3.7], normal=[0, 0, 1])
        way = [[1.0 - z / 8.0, 0.0, z] for z in np.linspace(1.0, 3.7, 30).tolist()]
        before = editor.state
        if open_end:
            outcome = editor.do(Call("cylinder", {"points": way, "caps": "always"}))
            assert outcome.refused is not None and "no cap" in outcome.refused
            assert "a border of the surface lies within it" in outcome.refused
            assert editor.state is before
        do(editor, "cylinder", points=way)
        found = editor.fill()
        assert len(found.placed) == len(found.network.patches) == patches
        gap = surface.nearest(weld_patches(found).vertices).points - weld_patches(found).vertices
        assert np.linalg.norm(gap, axis=1).max() < 0.01 * surface.diagonal


def test_the_opening_of_a_torus_is_no_disk(source: PatternSource) -> None:
    """Seen from above, a circle along its top encloses what is no part of it."""
    surface = torus()
    editor = Retopology(surface, source, sizes_of(surface))
    around = ring(3.0, 1.0, 241)
    for k in range(4):
        part = around[60 * k : 60 * k + 61] if k < 3 else np.r_[around[180:], around[:1]]
        do(editor, "stroke", points=part.tolist())
    found = editor.fill()
    assert not found.placed
    why = explain_no_disk(surface, ring(3.0, 1.0))
    assert why is not None and "goes round a handle" in why


@pytest.mark.parametrize("radius", [0.3, 0.6, 0.9])
def test_disks_are_disks_and_what_is_beyond_them_is_none(radius: float) -> None:
    """On a torus: a small circle on its top, and the other way round, around the handle."""
    surface = torus()
    circle = ring(radius, 0.0, middle=(3.0, 0.0))
    points = surface.nearest(circle + np.array([0.0, 0.0, 1.0])).points
    assert explain_no_disk(surface, points) is None
    why = explain_no_disk(surface, points[::-1])
    assert why is not None and "handle" in why
