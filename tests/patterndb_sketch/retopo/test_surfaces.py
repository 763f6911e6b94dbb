"""A whole surface retopologised by a script of examples/retopo/, and all scripts as they stand."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

import patterndb
from ingest.formats import read_mesh
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.draft.remesh import remesh_evenly
from patterndb_sketch.retopo.editor import Retopology
from patterndb_sketch.retopo.filling import FilledNetwork, weld_patches
from patterndb_sketch.retopo.filling.report import find_open_loops, hausdorff, report_mesh
from patterndb_sketch.retopo.network import check_network
from patterndb_sketch.retopo.network.faces import count_genus, count_handles
from patterndb_sketch.retopo.script import play_script, read_script
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.symmetry import cut_half, propose_plane
from tests.support.shared import EXAMPLES, MESHES, SHARED

SCRIPTS = EXAMPLES / "retopo"
SURFACES = SHARED / "data" / "surfaces"

#: The fastest of the scripts.
NAME = "hand_closed"

#: Distances from surface to quads and back may have this part of the surface's diagonal.
NEAR = 0.01

#: How far vertices may be off the surface: a tenth of the distance of a curve's samples.
ON_SURFACE = 2e-4

pytestmark = pytest.mark.skipif(
    not (SURFACES / f"{NAME}.obj").is_file(), reason="the surfaces are not beside the checkout"
)


@cache
def played() -> tuple[Surface, FilledNetwork]:
    script = read_script(SCRIPTS / f"{NAME}.jsonl")
    surface = Surface.from_polygons(read_mesh(SURFACES / Path(script.surface).name)).orient()
    with patterndb.open() as database:
        editor = Retopology(surface, database)
        for line, outcome in play_script(script, editor, lambda *_: None):
            assert outcome.refused is None, line
        return surface, editor.fill()


def test_the_mesh_of_quads_is_a_closed_surface_of_the_kind_of_the_surface() -> None:
    surface, found = played()
    mesh = weld_patches(found)
    assert mesh.quads.shape[1] == 4
    assert all(len(set(quad)) == 4 for quad in mesh.quads.tolist())
    # Every edge has one quad on either side, which pass it in opposite ways.
    directed = np.stack([mesh.quads.ravel(), np.roll(mesh.quads, -1, axis=1).ravel()], axis=1)
    pairs = {tuple(edge) for edge in directed.tolist()}
    assert len(pairs) == len(directed)
    assert {(b, a) for a, b in pairs} == pairs
    # Around every vertex the quads are one fan.
    after = {}
    for quad in mesh.quads.tolist():
        for k in range(4):
            after[quad[k], quad[k - 3]] = quad[k - 1]
    for vertex in range(len(mesh.vertices)):
        spokes = [b for a, b in after if a == vertex]
        at, seen = spokes[0], 0
        while seen == 0 or at != spokes[0]:
            at, seen = after[vertex, at], seen + 1
        assert seen == len(spokes)
    quads_euler = len(mesh.vertices) - len(pairs) // 2 + len(mesh.quads)
    sides = {tuple(sorted((t[k], t[k - 1]))) for t in surface.triangles.tolist() for k in range(3)}
    assert quads_euler == len(surface.vertices) - len(sides) + len(surface.triangles)


def test_every_patch_has_quads_none_is_flipped_and_the_report_says_the_same() -> None:
    surface, found = played()
    check_network(found.network)
    made = report_mesh(found, surface)
    assert found.notes == ()
    assert (made.unfilled, made.flipped, made.open_edges, made.tangled) == (0, 0, 0, 0)
    assert made.euler == 2
    assert max(made.irregular) <= 6
    # Each valence v counts 4 - v towards 4 times the Euler characteristic.
    assert sum(count * (4 - valence) for valence, count in made.irregular.items()) == 4 * 2


def test_quads_and_surface_are_near_to_each_other() -> None:
    surface, found = played()
    mesh = weld_patches(found)
    assert max(hausdorff(mesh.vertices, mesh.quads, surface)) < NEAR
    # Vertices are on the surface, those of curves on chords between samples of these.
    off = np.linalg.norm(surface.nearest(mesh.vertices).points - mesh.vertices, axis=1)
    assert off.max() < ON_SURFACE * surface.diagonal


@pytest.mark.parametrize("path", sorted(SCRIPTS.glob("*.jsonl")), ids=lambda path: path.stem)
def test_scripts_name_surfaces_that_are_there(path: Path) -> None:
    script = read_script(path)
    assert not Path(script.surface).is_absolute()
    assert (SURFACES / Path(script.surface).name).is_file()
    assert script.lines


@pytest.mark.parametrize("name", ["spot.draft", "hand_closed.draft", "penguin.draft"])
def test_scripts_that_draft_give_closed_meshes_near_the_surface(name: str) -> None:
    script = read_script(SCRIPTS / f"{name}.jsonl")
    surface = Surface.from_polygons(read_mesh(SURFACES / Path(script.surface).name)).orient()
    with patterndb.open() as database:
        editor = Retopology(surface, database)
        for line, outcome in play_script(script, editor, lambda *_: None):
            assert outcome.refused is None, line
        found = editor.fill()
    check_network(found.network, patches=False)
    made = report_mesh(found, surface)
    assert (made.unfilled, made.flipped, made.open_edges, made.tangled) == (0, 0, 0, 0)
    assert made.euler == 2
    assert max(made.to_surface, made.from_surface) < 0.02


def test_a_boot_has_all_its_tunnels_in_the_network_and_in_the_quads() -> None:
    script = read_script(SCRIPTS / "boot.jsonl")
    surface = Surface.from_polygons(read_mesh(SURFACES / "boot.obj")).orient()
    with patterndb.open() as database:
        editor = Retopology(surface, database)
        for line in script.lines:
            # Filled once, at the end: a benchmark plays it with fills after every call.
            assert editor.do(line.call).refused is None, line
        found = editor.fill()
    network = found.network
    check_network(network)
    handles = count_handles(surface)
    assert handles == 12
    assert count_genus(network.nodes, network.chains) == handles
    assert not find_open_loops(network)
    made = report_mesh(found, surface)
    assert (made.unfilled, made.open_edges, made.tangled) == (0, 0, 0)
    assert made.euler == 2 - 2 * handles


@pytest.mark.parametrize("name", ["q_fox", "q_dog", "q_telescope", "q_sheep"])
def test_halves_of_animals_are_remeshed_as_evenly_as_their_surface_is_large(name: str) -> None:
    # A triangle that folds over looks for the surface at the other end of the limb.
    whole = Surface.from_polygons(read_mesh(MESHES / f"{name}.obj")).orient()
    half = cut_half(whole, propose_plane(whole).plane).surface
    edge = 0.4 * Sizes.of(whole.diagonal).edge
    vertices, triangles = remesh_evenly(half, edge)
    made = Surface.from_arrays(vertices, triangles).orient()
    assert not made.repairs.dropped and len(made.vertices) == len(vertices)
    assert np.diff(made.adjacency.side_start).max() == 2
    due = half.areas.sum() / (np.sqrt(3.0) / 4.0 * edge**2)
    assert len(triangles) < 2.0 * due
    assert 0.9 < made.areas.sum() / half.areas.sum() < 1.1
