"""How models are shaded: smooth where they are smooth, alike in either sense."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.viewer.tents import grid, keys
from viewer.features import FeatureState
from viewer.skin import (
    AMBIENT,
    CREASED,
    EDGE,
    FILL,
    KEY,
    MATTE,
    OF_FILL,
    OF_KEY,
    SMOOTH,
    Skin,
    shade_model,
    smooth_normals,
)
from viewer.style import parse_colour


def test_normals_are_smooth_but_at_creases_whatever_the_sense(curved: FeatureState) -> None:
    model = curved.editing.model
    normals = smooth_normals(model.corners, model.triangles)
    assert np.linalg.norm(normals, axis=2) == pytest.approx(1.0)
    own = np.cross(
        model.corners[:, 1] - model.corners[:, 0], model.corners[:, 2] - model.corners[:, 0]
    )
    own /= np.linalg.norm(own, axis=1, keepdims=True)
    # Two slopes at a right angle: each keeps its own normal up to the ridge.
    assert np.einsum("tkc,tc->tk", normals, own) == pytest.approx(1.0)


@given(st.integers(0, 2**31))
def test_normals_equal_a_slow_reference(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points, faces = grid()
    points, faces = points[:40] + rng.normal(0.0, 0.03, (40, 3)), faces[(faces < 40).all(axis=1)]
    corners = points[faces]
    normals = smooth_normals(corners, faces.astype(np.int32))
    own = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(own, axis=1)
    unit = own / area[:, None]
    for t in rng.choice(len(faces), 5).tolist():
        for c in range(3):
            total = np.zeros(3)
            for u in np.flatnonzero((faces == faces[t, c]).any(axis=1)):
                cosine = unit[t] @ unit[u]
                share = np.clip((abs(cosine) - CREASED) / (SMOOTH - CREASED), 0.0, 1.0)
                total += np.sign(cosine) * share * area[u] * unit[u]
            assert normals[t, c] == pytest.approx(total / np.linalg.norm(total), abs=1e-9)


def test_a_model_is_shaded_alike_in_either_sense(state: FeatureState) -> None:
    skin = Skin.of(state.editing.model.corners, state.editing.model.triangles)
    seen, colours = shade_model(skin, state.camera.view, (0.0, 0.0), through=False)
    turned = Skin(skin.corners[:, ::-1], -skin.normals[:, ::-1])
    again, others = shade_model(turned, state.camera.view, (0.0, 0.0), through=False)
    assert (again[:, ::-1] == seen).all() and others[:, ::-1] == pytest.approx(colours, abs=1e-6)
    assert colours.min() > 0.3 and colours.max() <= 1.0


def test_shading_equals_a_slow_reference(state: FeatureState) -> None:
    keys(state, "v")
    skin, view = state.skin, state.camera.view
    seen, colours = shade_model(skin, view, (30.0, -20.0), through=False)
    assert seen == pytest.approx(view.seen(skin.corners) + np.array([30.0, -20.0, 0.0]))
    one, other = seen[:, 1, :2] - seen[:, 0, :2], seen[:, 2, :2] - seen[:, 0, :2]
    away = one[:, 0] * other[:, 1] < one[:, 1] * other[:, 0]
    normals = np.where(away[:, None, None], -1.0, 1.0) * (skin.normals @ view.axes.T)
    bright = AMBIENT + OF_KEY * np.clip(normals @ KEY, 0.0, 1.0)
    bright += OF_FILL * np.clip(normals @ FILL, 0.0, 1.0)
    bright *= 1.0 - EDGE * (1.0 - np.abs(normals[..., 2])) ** 3
    assert colours == pytest.approx(
        np.minimum(bright[..., None] * parse_colour(MATTE), 1.0), abs=1e-5
    )
