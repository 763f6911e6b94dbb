"""Surfaces whose triangles are turned against each other: turned alike, or refused by name."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb.errors import InvalidMeshError
from patterndb.geometry.adjacency import orient_triangles
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.editor import Call, Retopology
from query.engine import PatternSource
from tests.support.retopo.networks import plane, sphere


def count_against(surface: Surface) -> int:
    """Sides whose neighbour is turned the other way."""
    across, corner = surface.adjacency.across, surface.triangles.ravel()
    inner = np.flatnonzero(across >= 0)
    return int((corner[inner] == corner[across[inner]]).sum())


def measure_volume(surface: Surface) -> float:
    corner = surface.vertices[surface.triangles]
    return float(np.linalg.det(corner).sum() / 6.0)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 1.0))
def test_a_closed_surface_is_turned_outward_whatever_was_turned(seed: int, share: float) -> None:
    ball = trimesh.creation.icosphere(subdivisions=2)
    over = np.random.default_rng(seed).random(len(ball.faces)) < share
    faces = np.where(over[:, None], ball.faces[:, ::-1], ball.faces)
    surface = Surface.from_arrays(ball.vertices, faces).orient()
    assert count_against(surface) == 0
    # Where most of it is turned inward, that is meant: it may be the wall of a hollow.
    inward = over.mean() > 0.6 and measure_volume(surface) < 0.0
    assert measure_volume(surface) > 0.0 or inward or over.all()
    kept = np.sort(surface.triangles, axis=1) == np.sort(faces, axis=1)
    assert kept.all() and surface.repairs.turned == int(
        (surface.triangles != faces).any(axis=1).sum()
    )


def test_what_is_turned_alike_stays_bit_for_bit_inside_out_too() -> None:
    ball = trimesh.creation.icosphere(subdivisions=2)
    for faces in (ball.faces, ball.faces[:, ::-1]):
        faces = np.ascontiguousarray(faces, np.int32)
        assert orient_triangles(np.asarray(ball.vertices), faces).triangles is faces
    assert sphere().repairs.turned == plane().repairs.turned == 0


def test_parts_are_turned_by_themselves() -> None:
    ball = trimesh.creation.icosphere(subdivisions=1)
    n, k = len(ball.faces), len(ball.vertices)
    hollow = ball.faces[:, ::-1].copy()
    hollow[3] = hollow[3, ::-1]
    alternate = ball.faces.copy()
    alternate[::2] = alternate[::2, ::-1]
    vertices = np.concatenate([ball.vertices, ball.vertices + 5.0, ball.vertices - 5.0])
    surface = Surface.from_arrays(
        vertices, np.concatenate([ball.faces, hollow + k, alternate + 2 * k])
    ).orient()
    assert (surface.triangles[:n] == ball.faces).all()
    # One triangle of the hollow was wrong; the part as such is inside out, as it was.
    turned = (surface.triangles[n : 2 * n] != hollow + k).any(axis=1)
    assert np.flatnonzero(turned).tolist() == [3]
    out = surface.triangles[2 * n :]
    middle = surface.vertices[out].mean(axis=1) + 5.0
    across = np.cross(*(surface.vertices[out[:, e]] - surface.vertices[out[:, 0]] for e in (1, 2)))
    assert (np.einsum("tc,tc->t", across, middle) > 0.0).all()


def test_a_one_sided_surface_is_refused_by_name_with_the_place() -> None:
    n = 24
    t = np.linspace(0.0, 2.0 * np.pi, n, endpoint=False)
    rows = [
        np.stack(
            [
                (2.0 + s * np.cos(t / 2.0)) * np.cos(t),
                (2.0 + s * np.cos(t / 2.0)) * np.sin(t),
                s * np.sin(t / 2.0),
            ],
            axis=1,
        )
        for s in (-0.5, 0.5)
    ]
    faces = []
    for k in range(n):
        a, b = k, k + n
        c, d = (k + 1, k + 1 + n) if k + 1 < n else (n, 0)
        faces += [[a, c, b], [b, c, d]]
    with pytest.raises(InvalidMeshError, match=r"one-sided, as a Moebius strip.* at \(.*cut it"):
        Surface.from_arrays(np.concatenate(rows), faces).orient()


def test_alternate_triangles_take_a_draft_and_a_patch(source: PatternSource) -> None:
    ball = trimesh.creation.icosphere(subdivisions=3)
    faces = ball.faces.copy()
    faces[::2] = faces[::2, ::-1]
    editor = Retopology(Surface.from_arrays(ball.vertices, faces).orient(), source)
    outcome = editor.do(Call("loop", {"at": [0.6, 0.0, 0.8], "normal": [0.0, 0.0, 1.0]}))
    assert outcome.refused is None
    outcome = editor.do(Call("cylinder", {"points": [[0.6, 0, 0.8], [0.9, 0, 0.4]]}))
    assert outcome.refused is not None and "loop" in outcome.refused
    (chain,) = editor.network.chains.values()
    assert (np.einsum("nc,nc->n", chain.normals, chain.points) > 0.9).all()
