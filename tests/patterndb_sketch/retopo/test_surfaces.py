"""Whole surfaces retopologised by scripts, and the scripts of examples/retopo/ as they stand."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import trimesh

import patterndb
from ingest.formats import read_mesh
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.draft.fieldmesh import remesh_evenly
from patterndb_sketch.retopo.editor import Retopology
from patterndb_sketch.retopo.filling import FilledNetwork, weld_patches
from patterndb_sketch.retopo.filling.report import find_open_loops, hausdorff, report_mesh
from patterndb_sketch.retopo.network import check_network
from patterndb_sketch.retopo.network.faces import count_genus, count_handles
from patterndb_sketch.retopo.script import EXPORT, Script, read_script, script_of
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.symmetry import cut_half, propose_plane
from tests.support.meshes import examples, shared_meshes
from tests.support.shared import DATA, EXAMPLES, SHARED, list_shared

SCRIPTS = EXAMPLES / "retopo"
SURFACES = SHARED / "data" / "surfaces"

#: Distances from surface to quads and back may have this part of the surface's diagonal.
NEAR = 0.01

#: How far vertices may be off the surface: a tenth of the distance of a curve's samples.
ON_SURFACE = 2e-4


def make_bean() -> Surface:
    """Model a bent ellipsoid."""
    ball = trimesh.creation.icosphere(subdivisions=4)
    points = ball.vertices * [0.8, 1.0, 1.4]
    points[:, 0] += 0.3 * points[:, 2] ** 2
    return Surface.from_arrays(points, ball.faces).orient()


def make_frame() -> Surface:
    """Round off the bar with two eyes."""
    quads = read_mesh(DATA / "meshes" / "frame.obj")
    corners = quads.corners.reshape(-1, 4)
    triangles = np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])
    rounded = trimesh.remesh.subdivide_loop(quads.points, triangles, iterations=2)
    return Surface.from_arrays(*rounded).orient()


#: Surfaces that are made here, and the edges of their drafts; the examples draw on larger ones,
#: of which the fastest is played where the surfaces are.
MADE = {"bean": (make_bean, 0.12), "frame": (make_frame, 0.3)}
PLAYED = ["bean", *(path.stem for path in list_shared(SURFACES, "hand_closed.obj"))]


def draft_script(edge: float) -> Script:
    """Draft the whole of a surface."""
    calls = [
        {"tool": "open", "surface": "made"},
        {"tool": "draft", "edge": edge, "symmetry": False},
    ]
    return script_of([json.dumps(call) for call in calls])


@cache
def played(name: str) -> tuple[Surface, FilledNetwork]:
    if name in MADE:
        make, edge = MADE[name]
        script, surface = draft_script(edge), make()
    else:
        script = read_script(SCRIPTS / f"{name}.jsonl")
        surface = Surface.from_polygons(read_mesh(SURFACES / Path(script.surface).name)).orient()
    with patterndb.open() as database:
        editor = Retopology(surface, database)
        for line in script.lines:
            # Filled once, at the end: a benchmark plays scripts with fills after every call.
            if line.call.tool != EXPORT:
                assert editor.do(line.call).refused is None, line
        return surface, editor.fill()


@pytest.mark.parametrize("name", PLAYED)
def test_the_mesh_of_quads_is_a_closed_surface_of_the_kind_of_the_surface(name: str) -> None:
    surface, found = played(name)
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


@pytest.mark.parametrize("name", PLAYED)
def test_every_patch_has_quads_none_is_flipped_and_the_report_says_the_same(name: str) -> None:
    surface, found = played(name)
    check_network(found.network)
    made = report_mesh(found, surface)
    assert found.notes == ()
    assert (made.unfilled, made.flipped, made.open_edges, made.tangled) == (0, 0, 0, 0)
    assert made.euler == 2
    assert max(made.irregular) <= 6
    # Each valence v counts 4 - v towards 4 times the Euler characteristic.
    assert sum(count * (4 - valence) for valence, count in made.irregular.items()) == 4 * 2


@pytest.mark.parametrize("name", PLAYED)
def test_quads_and_surface_are_near_to_each_other(name: str) -> None:
    surface, found = played(name)
    mesh = weld_patches(found)
    assert max(hausdorff(mesh.vertices, mesh.quads, surface)) < NEAR
    # Vertices are on the surface, those of curves on chords between samples of these.
    off = np.linalg.norm(surface.nearest(mesh.vertices).points - mesh.vertices, axis=1)
    assert off.max() < ON_SURFACE * surface.diagonal


@pytest.mark.parametrize("path", sorted(SCRIPTS.glob("*.jsonl")), ids=lambda path: path.stem)
def test_scripts_name_surfaces_relatively(path: Path) -> None:
    script = read_script(path)
    assert not Path(script.surface).is_absolute()
    # They are not part of the project.
    assert (SURFACES / Path(script.surface).name).is_file() == SURFACES.is_dir()
    assert script.lines


@pytest.mark.parametrize(
    "name",
    [
        *("bean", "frame"),
        *(f"{path.stem}.draft" for path in list_shared(SURFACES, "spot.obj")),
    ],
)
def test_drafts_are_closed_meshes_near_the_surface(name: str) -> None:
    surface, found = played(name)
    check_network(found.network, patches=False)
    made = report_mesh(found, surface)
    assert (made.unfilled, made.flipped, made.open_edges, made.tangled) == (0, 0, 0, 0)
    assert made.euler == 2 - 2 * count_handles(surface)
    assert max(made.to_surface, made.from_surface) < 0.02


def test_all_tunnels_are_in_the_network_and_in_the_quads() -> None:
    surface, found = played("frame")
    handles = 2
    network = found.network
    check_network(network)
    assert count_handles(surface) == handles
    assert count_genus(network.nodes, network.chains) == handles
    assert not find_open_loops(network)
    made = report_mesh(found, surface)
    assert (made.unfilled, made.open_edges, made.tangled) == (0, 0, 0)
    assert made.euler == 2 - 2 * handles


#: Symmetric meshes: of the examples, and of artists.
HALVED = [
    *(path for path in examples() if path.stem in ("dog", "head")),
    *shared_meshes("q_fox", "q_dog", "q_telescope", "q_sheep"),
]


@pytest.mark.parametrize("path", HALVED, ids=lambda path: path.stem)
def test_halves_are_remeshed_as_evenly_as_their_surface_is_large(path: Path) -> None:
    # A triangle that folds over looks for the surface at the other end of the limb.
    whole = Surface.from_polygons(read_mesh(path)).orient()
    half = cut_half(whole, propose_plane(whole).plane).surface
    edge = 0.4 * Sizes.of(whole.diagonal).edge
    vertices, triangles = remesh_evenly(half, edge)
    made = Surface.from_arrays(vertices, triangles).orient()
    assert not made.repairs.dropped and len(made.vertices) == len(vertices)
    assert np.diff(made.adjacency.side_start).max() == 2
    due = half.areas.sum() / (np.sqrt(3.0) / 4.0 * edge**2)
    assert len(triangles) < 2.0 * due
    assert 0.9 < made.areas.sum() / half.areas.sum() < 1.1
