"""The meshes of the tests are what their script models, and what it promises of them."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from ingest.formats import read_mesh
from tests.support.meshes import mesh_of_file, models
from tests.support.models import MODELS, is_manifold

#: Border loops and handles of the models.
TOPOLOGY = {
    "chair": (0, 3),
    "frame": (0, 2),
    "glove": (1, 0),
    "knot": (0, 1),
    "mask": (4, 0),
    "ring": (0, 1),
    "shield": (2, 0),
    "trough": (1, 0),
}


def test_every_model_has_its_file() -> None:
    assert {path.stem for path in models()} == set(MODELS) == set(TOPOLOGY)


@pytest.mark.parametrize("path", models(), ids=lambda path: path.stem)
def test_the_file_is_what_the_script_models(path: Path) -> None:
    name = path.stem
    points, quads = MODELS[name]()
    mesh = read_mesh(path)
    assert mesh.corners.reshape(-1, 4).tolist() == quads
    assert np.abs(mesh.points - points).max() < 1e-3
    assert is_manifold(points, quads)
    assert 100 <= len(quads) <= 200


@pytest.mark.parametrize("path", models(), ids=lambda path: path.stem)
def test_models_are_varied(path: Path) -> None:
    mesh = mesh_of_file(path)
    n_border = int((mesh.twin < 0).sum())
    loops, handles = TOPOLOGY[path.stem]
    assert (n_border > 0) == (loops > 0)
    n_edges = (len(mesh.twin) + n_border) // 2
    assert mesh.n_vertices - n_edges + mesh.n_quads == 2 - 2 * handles - loops
    assert len(set(mesh.components().tolist())) == 1
    valences = Counter(np.bincount(mesh.quads.ravel()).tolist())
    assert {3, 4, 5} <= set(valences)
