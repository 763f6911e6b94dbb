"""Filling: counts, fills and places of patches, and the mesh that they make together."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from editor_cases import (
    SIZES,
    chain_at,
    do,
    drawn_grid,
    drawn_octants,
    line,
    patch_around,
    same_arrays,
)
from retopo_cases import plane, sphere

import patterndb
from query.engine import PatternSource
from sketch.retopo.editor import Call, Editor
from sketch.retopo.errors import InvalidRetopoError, RefusedError
from sketch.retopo.filling import (
    Cache,
    Choice,
    FilledNetwork,
    Filling,
    Flow,
    RetopoMesh,
    changed,
    chosen_anew,
    completed,
    counted,
    divided,
    filling_of,
    freed,
    irregular_vertices,
    lengths,
    open_edges,
    ranked,
    stepped,
    strip,
    suits,
    taken,
    welded,
    with_flow,
    without_flows,
)
from sketch.retopo.filling.finding import patch_at
from sketch.retopo.filling.report import hausdorff, report
from sketch.retopo.ground import Ground
from sketch.retopo.network import Network, equal, with_choice, with_count

EDGE = SIZES.edge


@pytest.fixture(scope="module")
def source() -> Iterator[PatternSource]:
    with patterndb.open() as opened:
        yield opened


@pytest.fixture(scope="module")
def grid(source: PatternSource) -> Network:
    """3 x 3 patches of 4 x 4 quads."""
    return drawn_grid(source).fill().network


def counts(network: Network) -> dict[int, int]:
    return {c: chain.count for c, chain in network.chains.items()}


def different(one: Network, two: Network) -> set[int]:
    """The chains whose counts differ."""
    a, b = counts(one), counts(two)
    assert a.keys() == b.keys()
    return {c for c in a if a[c] != b[c]}


def assert_even(network: Network) -> None:
    for patch in network.patches.values():
        sides = lengths(network, patch)
        assert min(sides) >= 1
        assert sum(sides) >= 4
        assert sum(sides) % 2 == 0


def test_a_square_grid_is_counted_by_its_lengths(grid: Network) -> None:
    used = {half >> 1 for patch in grid.patches.values() for half in patch.loop}
    assert {grid.chains[c].count for c in used} == {4}
    assert all(lengths(grid, patch) == (4, 4, 4, 4) for patch in grid.patches.values())
    border = set(grid.chains) - used
    assert {grid.chains[c].count for c in border} == {0}, "no patch is beside it"
    again, notes = counted(grid, EDGE)
    assert again is grid
    assert notes == ()


def test_settled_counts_stay_where_something_is_drawn(source: PatternSource) -> None:
    editor = drawn_grid(source)
    before = editor.fill().network
    do(editor, "stroke", points=line((1, 1.5), (2, 1.5)))
    after = editor.fill().network
    assert_even(after)
    kept = before.chains.keys() & after.chains.keys()
    assert len(before.chains) - len(kept) == 2
    assert all(before.chains[c].count == after.chains[c].count for c in kept)
    halves = [c for c in after.chains.keys() - kept if after.chains[c].length < 0.6]
    assert sorted(after.chains[c].count for c in halves) == [2, 2, 2, 2]


def test_pinned_counts_stay_and_others_do_not(grid: Network) -> None:
    pinned = chain_at(grid, 0.5, 0)
    other = chain_at(grid, 2.5, 0)
    network = with_count(with_count(grid, pinned, 8, pinned=True), other, 8)
    chosen, notes = chosen_anew(network, EDGE)
    assert notes == ()
    assert_even(chosen)
    assert chosen.chains[pinned].count == 8
    assert chosen.chains[other].count == 4
    free = freed(chosen, [pinned])
    assert free.chains[pinned].count == 8
    assert not free.chains[pinned].pinned
    assert chosen_anew(free, EDGE)[0].chains[pinned].count == 4
    with pytest.raises(InvalidRetopoError, match="there is no chain 9999"):
        freed(grid, [9999])


def test_pins_that_cannot_be_are_told_with_their_names(grid: Network) -> None:
    patch = grid.patches[patch_around(grid, 1.5, 1.5)]
    chains = [half >> 1 for half in patch.loop]
    network = grid
    for chain, count in zip(chains, (3, 4, 4, 4), strict=True):
        network = with_count(network, chain, count, pinned=True)
    for made, notes in (counted(network, EDGE), chosen_anew(network, EDGE)):
        (note,) = notes
        assert f"around patch {patch.id} add up to an odd number" in note
        assert all(str(chain) in note for chain in chains)
        assert all(made.chains[c].count == network.chains[c].count for c in chains)
        others = [p for p in made.patches.values() if p.id != patch.id]
        assert all(sum(lengths(made, p)) % 2 == 0 for p in others)


def test_one_count_more_changes_a_few_others(grid: Network) -> None:
    border = chain_at(grid, 0.5, 0)
    made, notes = changed(grid, EDGE, {border: 5})
    assert notes == ()
    assert_even(made)
    assert made.chains[border].count == 5
    assert made.chains[border].pinned
    assert len(different(grid, made) - {border}) <= 3
    loosely, _ = changed(grid, EDGE, {border: 5}, pin=False)
    assert not loosely.chains[border].pinned
    assert loosely.chains[border].count == 5


def test_two_counts_more_change_nothing_else_where_that_is_even(grid: Network) -> None:
    border = chain_at(grid, 0.5, 0)
    made, _ = changed(grid, EDGE, {border: 6})
    assert_even(made)
    assert len(different(grid, made)) <= 4


def test_counts_below_one_and_unknown_chains_are_refused(grid: Network) -> None:
    with pytest.raises(RefusedError, match="would have 0 edges; the least is 1"):
        changed(grid, EDGE, {chain_at(grid, 0.5, 0): 0})
    with pytest.raises(InvalidRetopoError, match="there is no chain 9999"):
        changed(grid, EDGE, {9999: 3})


def test_a_curve_of_no_patch_is_counted_too(source: PatternSource) -> None:
    editor = Editor(plane(), source, SIZES)
    do(editor, "stroke", points=line((0, 0), (1, 0)))
    do(editor, "subdivide", at=[0.5, 0, 0], count=7)
    assert editor.network.chains[chain_at(editor.network, 0.5, 0)].count == 7
    assert editor.fill().network is editor.network


def test_strips_run_straight_through_quads(grid: Network) -> None:
    across = chain_at(grid, 0.5, 0)
    wanted = {chain_at(grid, 0.5, y) for y in range(4)}
    assert set(strip(grid, across)) == wanted
    assert strip(grid, across)[0] == across
    inner = chain_at(grid, 1, 1.5)
    assert set(strip(grid, inner)) == {chain_at(grid, x, 1.5) for x in range(4)}


def test_strips_end_where_sides_are_of_several_curves(source: PatternSource) -> None:
    editor = drawn_grid(source)
    do(editor, "stroke", points=line((1.5, 1), (1.5, 2)))
    network = editor.network
    # Of the cells above and below the one that is cut, the sides next to it are two curves each.
    assert set(strip(network, chain_at(network, 1.5, 0))) == {chain_at(network, 1.5, 0)}
    cut = {chain_at(network, x, y) for x in (1.25,) for y in (1, 2)}
    assert set(strip(network, chain_at(network, 1.25, 1))) == cut
    along = strip(network, chain_at(network, 0, 1.5))
    assert set(along) == {chain_at(network, x, 1.5) for x in (0, 1, 1.5, 2, 3)}


def test_a_loop_through_a_row_is_twelve_quads_more(source: PatternSource) -> None:
    editor = drawn_grid(source)
    before = welded(editor.fill())
    assert len(before.quads) == 9 * 16
    do(editor, "subdivide", at=[0.5, 0, 0], by=1, strip=True)
    found = editor.fill()
    assert len(welded(found).quads) == len(before.quads) + 12
    fives = [c for c, chain in found.network.chains.items() if chain.count == 5]
    assert set(fives) == {chain_at(found.network, 0.5, y) for y in range(4)}


def test_every_patch_is_filled_for_its_counts(source: PatternSource) -> None:
    editor = drawn_grid(source)
    do(editor, "stroke", points=line((0, 0.5), (0.5, 1), (0.5, 1.5), (1, 2)))
    do(editor, "erase", at=[2, 2.5, 0])
    do(editor, "corner", at=[2.5, 0, 0])
    do(editor, "subdivide", at=[1.5, 0, 0], count=7)
    found = editor.fill()
    assert found.notes == ()
    assert found.placed.keys() == found.network.patches.keys()
    kinds = {len(patch.corners) for patch in found.network.patches.values()}
    assert len(kinds) > 2
    for patch, placed in found.placed.items():
        at = found.network.patches[patch]
        choice = filling_of(at).choice
        assert choice is not None
        assert suits(found.network, at)
        assert choice.by == "program"
        assert choice.lengths == lengths(found.network, at)
        assert same_arrays(choice.faces, placed.quads)
        assert placed.perimeter == choice.perimeter
        assert len(placed.flipped) == 0
        assert np.allclose(np.linalg.norm(placed.normals, axis=1), 1.0)


def test_the_first_of_the_list_is_taken_and_others_on_demand(
    source: PatternSource, grid: Network
) -> None:
    patch = patch_around(grid, 1.5, 1.5)
    network, _ = changed(grid, EDGE, {chain_at(grid, 1.5, 1): 6, chain_at(grid, 1, 1.5): 6})
    listed = list(ranked(network, network.patches[patch], source))
    assert len(listed) > 4
    for number in (0, 3):
        made = taken(network, patch, source, number)
        assert filling_of(made.patches[patch]).choice == Choice.of(listed[number], "user")
    flowing = with_flow(network, patch, np.array([[1.02, 1.4, 0], [1.5, 1.5, 0], [1.6, 1.98, 0]]))
    with pytest.raises(RefusedError, match="has no fill 900; its list is shorter"):
        taken(flowing, patch, source, 900)
    # Stepping goes round the list, both ways.
    first = taken(network, patch, source, 0)
    assert equal(stepped(first, patch, source, 3), taken(network, patch, source, 3))
    assert equal(stepped(first, patch, source, -1), taken(network, patch, source, len(listed) - 1))
    assert equal(stepped(stepped(first, patch, source, 5), patch, source, -5), first)
    assert equal(stepped(first, patch, source, len(listed)), first)
    # From no fill, one on is the first, and one back the last.
    none = with_choice(network, patch, None)
    assert equal(stepped(none, patch, source, 1), first)
    last = taken(network, patch, source, len(listed) - 1)
    assert equal(stepped(none, patch, source, -1), last)


def test_what_the_user_took_is_kept_for_other_counts_where_it_fits(
    source: PatternSource,
) -> None:
    editor = drawn_grid(source)
    do(editor, "subdivide", at=[1.5, 1, 0], count=6)
    editor.fill()
    do(editor, "choose", at=[1.5, 1.5, 0], number=2)
    patch = patch_at(editor.network, editor.ground, [1.5, 1.5, 0])
    chosen = filling_of(editor.network.patches[patch]).choice
    assert chosen is not None
    assert chosen.by == "user"
    assert filling_of(editor.fill().network.patches[patch]).choice == chosen
    do(editor, "subdivide", at=[1.5, 1, 0], by=2)
    again = filling_of(editor.fill().network.patches[patch]).choice
    assert again is not None
    assert again.lengths != chosen.lengths
    fits = [
        fill
        for fill in ranked(editor.network, editor.network.patches[patch], source)
        if Choice.of(fill).code == chosen.code
    ]
    assert (again.by, again.code) == ("user", chosen.code) if fits else again.by == "program"


def test_flow_lines_lead_the_edges_until_they_are_cleared(source: PatternSource) -> None:
    editor = drawn_grid(source)
    before = editor.fill().network
    patch = patch_around(before, 1.5, 1.5)
    across = [[1.02, 1.4, 0], [1.5, 1.5, 0], [1.6, 1.98, 0]]
    do(editor, "flow", points=across)
    assert filling_of(editor.network.patches[patch]).choice is None
    found = editor.fill()
    filling = filling_of(found.network.patches[patch])
    former = filling_of(before.patches[patch]).choice
    assert former is not None
    assert filling.choice is not None
    assert filling.choice.code != former.code, "no regular grid turns from side to side"
    assert len(filling.flows) == 1
    listed = ranked(found.network, found.network.patches[patch], source)
    assert next(listed).flow_distance is not None
    do(editor, "flow", clear=[1.5, 1.5, 0])
    assert filling_of(editor.network.patches[patch]).flows == ()
    cleared = filling_of(editor.fill().network.patches[patch])
    assert cleared.choice == former
    assert editor.do(Call("flow", {"clear": [1.5, 1.5, 0]})).refused is not None
    with pytest.raises(RefusedError, match="has no flow lines"):
        without_flows(editor.network, patch)


def test_a_flow_line_that_leads_nowhere_leaves_its_patch_empty_and_is_told(
    source: PatternSource, grid: Network
) -> None:
    patch = patch_around(grid, 0.5, 0.5)
    made = with_flow(grid, patch, np.array([[0.45, 0.02, 0], [0.5, 0.05, 0], [0.48, 0.02, 0]]))
    found = completed(made, plane(), source, EDGE)
    assert found.placed.keys() == grid.patches.keys() - {patch}
    (note,) = found.notes
    assert note.startswith(f"patch {patch} cannot be filled: the stroke")
    assert len(welded(found).quads) == 8 * 16


def test_a_patch_of_an_odd_border_is_refused_and_told(source: PatternSource, grid: Network) -> None:
    patch = grid.patches[patch_around(grid, 0.5, 0.5)]
    network = grid
    for half, count in zip(patch.loop, (3, 4, 4, 4), strict=True):
        network = with_count(network, half >> 1, count, pinned=True)
    with pytest.raises(RefusedError, match="has 15 edges around it, and a fill needs an even"):
        ranked(network, network.patches[patch.id], source)
    found = completed(network, plane(), source, EDGE)
    assert patch.id not in found.placed
    assert any("has 15 edges around it" in note for note in found.notes)


def test_fillings_keep_what_they_are_given() -> None:
    filling = Filling().with_moved([3, 7], [[1, 2, 3], [0.1, -0.0, 1e300]])
    which, places = filling.moved_vertices
    assert which.tolist() == [3, 7]
    assert same_arrays(places, np.array([[1, 2, 3], [0.1, -0.0, 1e300]]))
    assert filling.with_choice(None) == Filling(), "places are those of one fill"
    assert Flow.of([[1, 2, 3], [4, 5, 6]]).points.tolist() == [[1, 2, 3], [4, 5, 6]]


def test_borders_are_divided_evenly_with_ends_that_are_exact(grid: Network) -> None:
    for chain in grid.chains.values():
        for count in (1, 2, 7):
            points, normals = divided(replace(chain, count=count))
            assert points.shape == normals.shape == (count + 1, 3)
            around = chain.round
            assert same_arrays(points[[0, -1]], around[[0, -1]])
            steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
            assert steps.max() <= chain.length / count * (1 + 1e-9)
            if not chain.marked:
                assert np.allclose(steps, chain.length / count, rtol=1e-3)


def neighbours(placed_quads: np.ndarray, n: int) -> list[set[int]]:
    found: list[set[int]] = [set() for _ in range(n)]
    for quad in placed_quads.tolist():
        for a, b in zip(quad, [*quad[1:], quad[0]], strict=True):
            found[a].add(b)
            found[b].add(a)
    return found


def test_inside_is_laplace_on_the_plane(source: PatternSource) -> None:
    editor = drawn_grid(source)
    do(editor, "stroke", points=line((0, 0.5), (0.6, 1.2), (1, 2)))
    do(editor, "subdivide", at=[2.5, 0, 0], count=7)
    found = editor.fill()
    inner = 0
    for placed in found.placed.values():
        beside = neighbours(placed.quads, len(placed.vertices))
        for v in range(placed.perimeter, len(placed.vertices)):
            mean = placed.vertices[sorted(beside[v])].mean(axis=0)
            assert np.linalg.norm(placed.vertices[v] - mean) < 1e-9
            inner += 1
        assert placed.at_rest
    assert inner > 50


def test_a_cap_of_eight_by_eight_lies_on_the_sphere(source: PatternSource) -> None:
    editor = Editor(sphere(), source)
    do(editor, "loop", at=[1, 0, 0.2], normal=[0, 0, 1])
    for k in range(4):
        turn = np.pi / 4 + k * np.pi / 2
        do(editor, "corner", at=[np.cos(turn), np.sin(turn), 0.2])
    for chain in list(editor.network.chains.values()):
        do(editor, "subdivide", at=chain.points[len(chain.points) // 2].tolist(), count=8)
    found = editor.fill()
    (placed,) = found.placed.values()
    assert len(placed.quads) == 64
    assert len(placed.flipped) == 0
    assert placed.at_rest
    feet = editor.ground.nearest(placed.vertices).points
    assert np.linalg.norm(feet - placed.vertices, axis=1).max() < 1e-9


def edges_of(mesh: RetopoMesh) -> set[tuple[int, int]]:
    edges = [(q[k - 1], q[k]) for q in mesh.quads.tolist() for k in range(4)]
    assert len(set(edges)) == len(edges), "two quads pass an edge the same way"
    return set(edges)


def assert_welded(found: FilledNetwork, mesh: RetopoMesh) -> None:
    """Every patch's quads are there with its places, bit for bit."""
    start = 0
    for patch in sorted(found.placed):
        placed = found.placed[patch]
        rows = mesh.quads[start : start + len(placed.quads)]
        assert same_arrays(mesh.vertices[rows], placed.vertices[placed.quads])
        assert (mesh.patch[start : start + len(rows)] == patch).all()
        start += len(rows)
    assert start == len(mesh.quads)
    used = np.unique(mesh.quads)
    assert used.tolist() == list(range(len(mesh.vertices)))


def on_one_side(network: Network, chain: int) -> bool:
    """Is there one patch beside a chain?"""
    taken = network.patch_of()
    return (2 * chain in taken) != (2 * chain + 1 in taken)


def test_neighbours_share_their_vertices(source: PatternSource) -> None:
    editor = drawn_grid(source)
    do(editor, "stroke", points=line((0, 0.5), (0.5, 1), (0.5, 1.5), (1, 2)))
    found = editor.fill()
    mesh = welded(found)
    assert_welded(found, mesh)
    assert len(np.unique(mesh.vertices, axis=0)) == len(mesh.vertices), "none is there twice"
    edges = edges_of(mesh)
    once = [e for e in edges if e[::-1] not in edges]
    outer = {c for c in found.network.chains if on_one_side(found.network, c)}
    around = sum(found.network.chains[c].count for c in outer)
    assert len(once) == len(open_edges(mesh)) == around > 40
    n_edges = (len(edges) + len(once)) // 2
    assert len(mesh.vertices) - n_edges + len(mesh.quads) == 1
    nodes = found.network.nodes
    for v in np.flatnonzero(mesh.node >= 0).tolist():
        assert same_arrays(mesh.vertices[v], nodes[int(mesh.node[v])].point)
    assert ((mesh.node >= 0) & (mesh.chain >= 0)).sum() == 0
    on_chains = sum(found.network.chains[c].count - 1 for c in set(mesh.chain.tolist()) - {-1})
    assert (mesh.chain >= 0).sum() == on_chains


def test_a_ball_of_eight_patches_is_closed(source: PatternSource) -> None:
    editor = drawn_octants(source)
    found = editor.fill()
    mesh = welded(found)
    assert_welded(found, mesh)
    edges = edges_of(mesh)
    assert {(b, a) for a, b in edges} == edges
    assert len(open_edges(mesh)) == 0
    assert len(mesh.vertices) - len(edges) // 2 + len(mesh.quads) == 2
    feet = editor.ground.nearest(mesh.vertices).points
    assert np.linalg.norm(feet - mesh.vertices, axis=1).max() < 1e-9
    assert all(len(placed.flipped) == 0 for placed in found.placed.values())
    wrong, valence = irregular_vertices(mesh)
    assert valence.tolist() == [3] * 8
    assert (mesh.node[wrong] == -1).all()
    told = report(found, editor.ground, mesh)
    assert (told.patches, told.unfilled, told.irregular) == ({3: 8}, 0, {3: 8})
    assert (told.flipped, told.open_edges, told.tangled, told.euler) == (0, 0, 0, 2)
    assert (told.vertices, told.quads) == (len(mesh.vertices), len(mesh.quads))
    assert 0.0 < told.to_ground < 0.002


def test_an_empty_network_is_an_empty_mesh(source: PatternSource) -> None:
    found = completed(Network(), plane(), source, EDGE)
    mesh = welded(found)
    assert (mesh.vertices.shape, mesh.quads.shape) == ((0, 3), (0, 4))
    told = report(found, plane())
    assert (told.patches, told.quads, told.euler, told.to_ground) == ({}, 0, 0, 1.0)


def test_vertices_moved_by_hand_stay_and_what_they_flip_is_told(
    source: PatternSource, grid: Network
) -> None:
    patch = patch_around(grid, 1.5, 1.5)
    filling = filling_of(grid.patches[patch])
    assert filling.choice is not None
    before = completed(grid, plane(), source, EDGE)
    inner = filling.choice.perimeter + 4
    near = before.placed[patch].vertices[inner] + [0.05, 0.05, 0]
    for place, flips in ((near, False), (np.array([2.4, 2.4, 0]), True)):
        network = with_choice(grid, patch, filling.with_moved([inner], [place]))
        found = completed(network, plane(), source, EDGE)
        placed = found.placed[patch]
        assert same_arrays(placed.vertices[inner], place)
        others = np.arange(len(placed.vertices)) != inner
        assert same_arrays(placed.vertices[others], before.placed[patch].vertices[others])
        assert bool(len(placed.flipped)) == flips
        assert any("flipped" in note for note in found.notes) == flips
    every = before.placed[patch].vertices * [1, 1, 0] + [0, 0, 0.5]
    whole = filling.with_moved(np.arange(len(every)), every)
    found = completed(with_choice(grid, patch, whole), plane(), source, EDGE)
    assert same_arrays(found.placed[patch].vertices, every)


def same_fills(one: FilledNetwork, two: FilledNetwork) -> bool:
    return (
        equal(one.network, two.network)
        and one.notes == two.notes
        and one.placed.keys() == two.placed.keys()
        and all(
            same_arrays(getattr(one.placed[p], name), getattr(two.placed[p], name))
            for p in one.placed
            for name in ("quads", "vertices", "normals", "flipped")
        )
    )


def test_what_was_placed_before_changes_no_result(source: PatternSource) -> None:
    """An editor that keeps places, and one that does not, through edits and undoing."""
    editor = drawn_grid(source, 2)
    calls = (
        Call("sizes", {"edge": 0.2}),
        Call("subdivide", {"at": [0.5, 0, 0], "by": 1}),
        Call("stroke", {"points": line((0, 0.5), (1, 0.6))}),
        Call("undo"),
        Call("knot", {"at": [1, 1, 0], "radius": 0.3}),
        Call("flow", {"points": line((0.1, 1.5), (0.8, 1.5))}),
        Call("undo"),
        Call("undo"),
        Call("redo"),
        Call("recount", {"edge": 0.15}),
    )
    kept = Cache()
    for call in calls:
        assert editor.do(call).changed
        network, ground, edge = editor.network, editor.ground, editor.sizes.edge
        fresh = completed(network, ground, source, edge)
        assert same_fills(fresh, completed(network, ground, source, edge, kept))
        assert same_fills(fresh, completed(network, ground, source, edge, kept))
        assert same_fills(fresh, editor.fill())


def test_points_are_found_in_their_patches(source: PatternSource) -> None:
    editor = drawn_grid(source)
    for x, y in ((0.5, 0.5), (1.1, 2.9), (2.95, 0.05)):
        middle = (int(x) + 0.5, int(y) + 0.5)
        assert patch_at(editor.network, plane(), [x, y, 0.3]) == patch_around(
            editor.network, *middle
        )
    for x, y in ((-1, -1), (-0.01, 0.5), (3.01, 2.99)):
        with pytest.raises(RefusedError, match="there is no patch here"):
            patch_at(editor.network, plane(), [x, y, 0])
    assert patch_at(editor.network, plane(), [0, 0.5, 0]) == patch_around(editor.network, 0.5, 0.5)
    octants = drawn_octants(source)
    found = {
        patch_at(octants.network, octants.ground, [x, y, z])
        for x in (-1, 1)
        for y in (-1, 1)
        for z in (-1, 1)
    }
    assert len(found) == 8


def test_distances_of_known_shapes() -> None:
    box = trimesh.creation.box((2, 2, 2))
    ground = Ground.of(box.vertices, box.faces)
    corner = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    quads = np.array(
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    )
    assert hausdorff(corner, quads, ground) == pytest.approx((0.0, 0.0), abs=1e-15)
    diagonal = 2 * np.sqrt(3)
    out, back = hausdorff(corner * 1.25, quads, ground)
    assert out == pytest.approx(0.25 * np.sqrt(3) / diagonal)
    assert back == pytest.approx(0.25 / diagonal)
    # The top alone is 2 from the bottom.
    assert hausdorff(corner, quads[5:], ground) == pytest.approx((0.0, 2 / diagonal))
    assert hausdorff(corner, quads[:0], ground) == (1.0, 1.0)


def test_quads_that_pass_an_edge_the_same_way_are_told(source: PatternSource) -> None:
    editor = drawn_grid(source, 2)
    found = editor.fill()
    mesh = welded(found)
    doubled = replace(
        mesh,
        quads=np.concatenate([mesh.quads, mesh.quads[:1]]),
        patch=np.concatenate([mesh.patch, mesh.patch[:1]]),
    )
    assert report(found, editor.ground, mesh).tangled == 0
    assert report(found, editor.ground, doubled).tangled > 0
