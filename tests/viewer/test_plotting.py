"""What pyvista gets: meshes with their numbers, and plots that show them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import pyvista

import patterndb
from patterndb.errors import MissingExtraError
from patterndb_sketch.features.shapemodel import ShapeModel
from query.engine import PatternSource
from tests.support.shared import CHECKOUT
from tests.support.viewer.events import read
from tests.support.viewer.sheets import sheet
from viewer.picture import PictureError, check_rendering
from viewer.plotting import plot, to_pyvista

HEAD = CHECKOUT / "docs" / "meshes" / "head.obj"


@pytest.fixture(autouse=True)
def off_screen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pyvista, "OFF_SCREEN", True)


def test_a_mesh_keeps_its_faces_and_has_valences() -> None:
    mesh = patterndb.read(HEAD)
    made = mesh.to_pyvista()
    assert made.n_cells == mesh.n_faces and np.array_equal(made.points, mesh.points)
    assert np.array_equal(made.faces[1:5], mesh.corners[:4])
    assert made["valence"].sum() == len(mesh.corners)
    surface = mesh.surface()
    assert np.array_equal(surface.to_pyvista().regular_faces, surface.triangles)


def test_a_hole_and_its_fill(source: PatternSource) -> None:
    hole = patterndb.read(HEAD).hole(loop=[36])
    line = hole.to_pyvista()
    assert line.n_lines == 1 and line["vertex"].tolist() == hole.loop.tolist()
    fill = next(hole.fills(source))
    made = fill.to_pyvista()
    assert made["new"].sum() == fill.n_faces
    assert made.n_cells == hole.topology.mesh.n_faces + fill.n_faces


def test_fills_and_patterns_lie_flat(source: PatternSource) -> None:
    fill = next(patterndb.open().fills((3, 5, 4, 6)))
    made = fill.to_pyvista()
    assert made.n_cells == fill.n_quads and made.n_points == fill.n_vertices
    assert np.ptp(made.points[:, 2]) == 0.0
    assert np.bincount(made["side"] + 1)[1:].tolist() == [3, 5, 4, 6]
    pattern = fill.pattern.to_pyvista()
    assert pattern.n_cells == fill.pattern.n_quads
    assert len(set(pattern["side"].tolist()) - {-1}) == fill.pattern.n_sides


def test_networks_retopologies_and_shape_models(source: PatternSource) -> None:
    network = patterndb.read_network(CHECKOUT / "examples" / "networks" / "teacup.json")
    lines = network.to_pyvista()
    assert lines.n_lines == len(network.curves) == len(lines["curve"])
    empty = patterndb.Retopology(sheet(), source)
    assert empty.to_pyvista().n_cells == 0
    mesh = patterndb.read(HEAD)
    shapes = [mesh.points * size for size in ((1, 1, 1), (1.1, 1, 1), (1, 1.2, 0.9))]
    model = ShapeModel.build(shapes, mesh.quads()[0], features=())
    made = to_pyvista(model)
    assert np.allclose(made["mode 1"], model.modes[0] * model.deviations[0])
    assert np.allclose(made.points, model.mean)


def test_a_plot_shows_it(source: PatternSource, tmp_path: Path) -> None:
    mesh = patterndb.read(HEAD)
    plotter = mesh.plot(toward=(0.0, 0.0, 1.0))
    path = tmp_path / "a.png"
    plotter.screenshot(path)
    image = read(path)
    assert 0.15 < (image.min(axis=2) < 0.97).mean() < 0.7
    # Marks go on facing whoever turns the camera, and a second thing is added to the first.
    before = plotter.renderer.GetActors().GetNumberOfItems()
    assert next(mesh.hole(loop=[36]).fills(source)).plot(plotter=plotter) is plotter
    assert plotter.renderer.GetActors().GetNumberOfItems() > before
    plotter.close()


def test_a_machine_that_cannot_draw_says_what_it_needs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("viewer.picture.has_display", lambda: False)
    monkeypatch.setattr("viewer.picture.RENDERING", ("libNone.so.0",))
    with pytest.raises(PictureError, match="apt-get install libegl1"):
        check_rendering()
    monkeypatch.setattr("viewer.picture.has_display", lambda: True)
    check_rendering()


def test_what_cannot_be_shown_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(TypeError, match="int cannot be shown by pyvista"):
        to_pyvista(7)
    mesh = patterndb.read(HEAD)
    with pytest.raises(ValueError, match="no shading 'oil'"):
        plot(mesh, shading="oil")
    monkeypatch.setattr("patterndb.system.extras.find_spec", lambda name: None)
    with pytest.raises(MissingExtraError, match="plotting needs vtkmodules and pyvista"):
        mesh.plot()
