"""Drafts on surfaces where curves are drawn already: these stay, and the rest is filled."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import KDTree

from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.draft.fieldmesh import cut_along_curves, remesh_evenly
from patterndb_sketch.retopo.draft.frames import TangentFrames
from patterndb_sketch.retopo.editor import Call, Retopology
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling.fills import filling_of
from patterndb_sketch.retopo.filling.report import Report, report_mesh
from patterndb_sketch.retopo.network import Network, check_network
from query.engine import PatternSource
from tests.support.retopo.editors import do
from tests.support.retopo.networks import sphere

EDGE = 0.2

LOOP = Call("loop", {"at": [0.95, 0.0, 0.3], "normal": [0.0, 0.0, 1.0]})
LOWER = Call("loop", {"at": [0.95, 0.0, -0.3], "normal": [0.0, 0.0, 1.0]})
RING = Call("cylinder", {"points": [[0.95, 0, 0.3], [1, 0, 0], [0.95, 0, -0.3]], "caps": "never"})
STROKE = Call("stroke", {"points": [[1, 0, 0], [0.8, 0.6, 0], [0.3, 0.9, 0.2]]})
SPINE = Call("spine", {"points": [[0.9, 0, -0.4], [1, 0, 0], [0.9, 0, 0.4]], "width": 0.6})
CROSSING = Call("stroke", {"points": [[0.7, -0.7, 0.0], [1, 0, 0.1], [0.7, 0.7, 0.0]]})

DRAWN = {
    "a loop": [LOOP],
    "an open stroke": [STROKE],
    "a patch": [SPINE],
    "a ring of patches": [LOOP, LOWER, RING],
    "a patch and a stroke that ends on it": [SPINE, CROSSING],
}


def polyline(network: Network) -> np.ndarray:
    """(n, 3) all points of curves that are drawn."""
    parts = [chain.points for chain in network.chains.values() if not chain.marked]
    return np.concatenate([np.empty((0, 3)), *parts])


def corners_of(network: Network, patch: int) -> set[bytes]:
    """Where a patch has its corners."""
    one = network.patches[patch]
    nodes = [network.origin(one.loop[k]) for k in one.corners]
    return {network.nodes[node].point.tobytes() for node in nodes}


def measure(editor: Retopology) -> Report:
    found = editor.fill()
    return report_mesh(found, editor.surface, editor.mesh(found))


@pytest.mark.parametrize("calls", DRAWN.values(), ids=DRAWN)
def test_what_is_drawn_stays_and_the_rest_is_filled(
    calls: list[Call], source: PatternSource
) -> None:
    editor = Retopology(sphere(), source)
    for call in calls:
        assert editor.do(call).changed
        editor.fill()
    before = editor.network
    outcome = do(editor, "draft", edge=EDGE)
    assert outcome.changed
    after = editor.network
    check_network(after, patches=False)
    # Every curve runs where it ran, point for point; some are cut where lines end on them.
    away, _ = KDTree(polyline(after)).query(polyline(before))
    assert away.max() == 0.0
    # Patches are those that were there, with their corners.
    for patch in before.patches:
        kept = [p for p in after.patches if corners_of(after, p) == corners_of(before, patch)]
        assert len(kept) == 1
    made = measure(editor)
    assert made.unfilled == made.open_edges == made.tangled == 0
    assert made.flipped <= 0.02 * made.quads
    assert made.euler == 2
    assert max(made.to_surface, made.from_surface) < 0.02
    do(editor, "undo")
    assert editor.network is before or len(editor.network.chains) == len(before.chains)


def test_patches_whose_borders_are_cut_are_not_fitted(source: PatternSource) -> None:
    """Lines end on their borders, so that they have other ids; their quads stay as placed."""
    editor = Retopology(sphere(), source)
    for call in (LOOP, LOWER, RING):
        assert editor.do(call).changed
    editor.fill()
    before = editor.network
    do(editor, "draft", edge=EDGE)
    after = editor.fill().network
    assert before.patches.keys() - after.patches.keys()
    corners = [corners_of(before, patch) for patch in before.patches]
    kept = [patch for patch in after.patches if corners_of(after, patch) in corners]
    assert len(kept) == len(before.patches)
    held = {patch: bool(filling_of(after.patches[patch]).moved[0]) for patch in after.patches}
    assert held == {patch: patch not in kept for patch in after.patches}


def test_quads_have_edges_along_a_stroke_from_end_to_end(source: PatternSource) -> None:
    """What is drawn is a line of edges of the mesh, not one that quads lie across."""
    editor = Retopology(sphere(), source)
    do(editor, "stroke", **STROKE.arguments)
    line = polyline(editor.network)
    do(editor, "draft", edge=EDGE)
    found = editor.fill()
    mesh = editor.mesh(found)
    quads = mesh.quads
    edges = np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2)
    tree = KDTree(line)
    near = tree.query(mesh.vertices)[0] < 0.02
    along = edges[near[edges].all(axis=1)]
    lengths = np.linalg.norm(mesh.vertices[along[:, 0]] - mesh.vertices[along[:, 1]], axis=1)
    whole = np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
    # Each is that of two quads; lines that cross it may have an end near it.
    assert lengths.sum() / 2 == pytest.approx(whole, rel=0.15)


@pytest.mark.parametrize("seed", range(6))
def test_any_drawing_is_drafted_around_or_refused(seed: int, source: PatternSource) -> None:
    rng = np.random.default_rng(seed)
    editor = Retopology(sphere(), source)
    for _ in range(int(rng.integers(1, 4))):
        ahead = rng.normal(size=(3, 3))
        ahead /= np.linalg.norm(ahead, axis=1)[:, None]
        places = [ahead[0], ahead[0] + 0.5 * ahead[1], ahead[0] + 0.5 * ahead[1] + 0.4 * ahead[2]]
        points = [(p / np.linalg.norm(p)).tolist() for p in places]
        kind = rng.integers(3)
        if kind == 0:
            editor.do(Call("loop", {"at": points[0], "normal": ahead[1].tolist()}))
        elif kind == 1:
            editor.do(Call("spine", {"points": points, "width": 0.4}))
        else:
            editor.do(Call("stroke", {"points": points}))
        editor.fill()
    before = editor.state
    outcome = editor.do(Call("draft", {"edge": EDGE, "symmetry": False}))
    if outcome.refused is not None:
        assert editor.state is before
        return
    check_network(editor.network, patches=False)
    made = measure(editor)
    assert made.unfilled == made.open_edges == made.tangled == 0
    assert made.euler == 2
    if before.network.chains:
        assert KDTree(polyline(editor.network)).query(polyline(before.network))[0].max() == 0.0


def test_patches_all_over_leave_nothing_to_draft(source: PatternSource) -> None:
    editor = Retopology(sphere(), source)
    for call in (LOOP, LOWER, Call("cylinder", {**RING.arguments, "caps": "always"})):
        assert editor.do(call).changed
    outcome = editor.do(Call("draft", {"edge": EDGE}))
    assert outcome.refused is not None and "nothing left to draft" in outcome.refused


def cut(network: Network, surface: Surface, edge: float) -> TangentFrames:
    return cut_along_curves(
        network, TangentFrames.of(Surface.from_arrays(*remesh_evenly(surface, edge)).orient()), edge
    )


@pytest.mark.parametrize(
    ("calls", "euler", "parts"),
    [
        # A ball cut along an open curve is a disk; along a loop it is two.
        ([STROKE], 1, 1),
        ([LOOP], 2, 2),
        ([LOOP, LOWER], 2, 3),
        # What the patch covers is left out.
        ([SPINE], 1, 1),
        ([LOOP, LOWER, RING], 2, 2),
    ],
    ids=["stroke", "loop", "two loops", "patch", "ring"],
)
def test_a_mesh_that_is_cut_has_the_curves_as_its_borders(
    calls: list[Call], euler: int, parts: int, source: PatternSource
) -> None:
    editor = Retopology(sphere(), source)
    for call in calls:
        assert editor.do(call).changed
    mesh = cut(editor.network, editor.surface, 0.4 * EDGE)
    assert mesh.euler == euler
    # Parts do not touch: as many as triangles reach each other in.
    seen = np.full(len(mesh.triangles), -1)
    for first in range(len(seen)):
        stack = [first] if seen[first] < 0 else []
        while stack:
            f = stack.pop()
            if seen[f] >= 0:
                continue
            seen[f] = first
            stack += [int(g) // 3 for g in mesh.across[3 * f : 3 * f + 3] if g >= 0]
    assert len(np.unique(seen)) == parts
    # Borders are on the curves, and reach all along them.
    rim = mesh.vertices[mesh.on_border]
    network = editor.network
    free = set(network.chains) - {
        c for c in network.chains if {2 * c, 2 * c + 1} <= network.patch_of().keys()
    }
    line = np.concatenate([network.chains[c].points for c in sorted(free)])
    assert KDTree(line).query(rim)[0].max() < 0.02
    assert KDTree(rim).query(line)[0].max() < 0.4 * EDGE


def test_curves_too_close_for_the_edge_are_refused_with_their_place(
    source: PatternSource,
) -> None:
    editor = Retopology(sphere(), source)
    for x in np.linspace(0.0, 0.05, 6):
        line = [[1.0, x, -0.3], [1.0, x, 0.0], [1.0, x, 0.3]]
        assert editor.do(Call("stroke", {"points": line, "snap": 0.002})).changed
    with pytest.raises(RefusedError, match=r"too close to each other at \("):
        cut(editor.network, editor.surface, 0.1)
