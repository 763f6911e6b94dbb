"""Edge loops that are inserted, and pairs of irregular vertices that are moved."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from editor_cases import SIZES, chain_at, do, drawn_grid, drawn_octants, line, patch_around
from hypothesis import given, settings
from hypothesis import strategies as st
from retopo_cases import plane, sphere

import patterndb
from patterndb.halfedge import Int32Array
from query.engine import PatternSource, fills
from query.identity import quads_key
from query.polyline import arc_length
from query.solving.chords import Chords
from query.weld import weld
from sketch.retopo.editor import Call, Editor
from sketch.retopo.editor.editor import TOOLS
from sketch.retopo.editor.topology import TOPOLOGY
from sketch.retopo.errors import RefusedError
from sketch.retopo.filling import (
    Choice,
    RetopoMesh,
    completed,
    filling_of,
    irregular_vertices,
    lengths,
    ranked,
    suits,
    welded,
)
from sketch.retopo.filling.expansion import Expansion
from sketch.retopo.filling.looping import edge_at, insert_loop, nearest_edge
from sketch.retopo.filling.moving import least_changes, move_pair
from sketch.retopo.ground import Ground
from sketch.retopo.network import Network, check, equal, with_count
from sketch.retopo.quadimport import imported

UP = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def source() -> Iterator[PatternSource]:
    with patterndb.open() as opened:
        yield opened


@pytest.fixture(autouse=True)
def tools(monkeypatch: pytest.MonkeyPatch) -> None:
    """The editor has these tools, whether its table lists them or not."""
    for tool in TOPOLOGY:
        monkeypatch.setitem(TOOLS, tool.name, tool)


@pytest.fixture(scope="module")
def filled_grid(source: PatternSource) -> Network:
    """3 x 3 patches of 4 x 4 quads, filled."""
    return drawn_grid(source).fill().network


def choice_of(network: Network, patch: int) -> Choice:
    choice = filling_of(network.patches[patch]).choice
    assert choice is not None
    return choice


def assert_sound(network: Network) -> None:
    """Every patch is even, and its fill a disk with its counts."""
    check(network)
    for patch in network.patches.values():
        sides = lengths(network, patch)
        assert sum(sides) % 2 == 0 and suits(network, patch)
        choice = choice_of(network, patch.id)
        weld(choice.faces, choice.n_vertices, sum(sides))


def assert_manifold(mesh: RetopoMesh) -> None:
    """No edge has more than two quads, and none is passed twice the same way."""
    ends = zip(mesh.quads.ravel(), np.roll(mesh.quads, -1, axis=1).ravel(), strict=True)
    edges = [(int(a), int(b)) for a, b in ends]
    assert max(Counter(edges).values()) == 1
    assert max(Counter((min(e), max(e)) for e in edges).values()) <= 2


def key(choice: Choice) -> bytes:
    faces = choice.faces
    return quads_key(faces, weld(faces, choice.n_vertices, choice.perimeter), False)


def split(choice: Choice, half: int) -> tuple[Int32Array, list[int]]:
    """The quads of a choice with the strip through a half-edge split, and the boundary edges
    that it crosses; edge by edge, in plain Python."""
    quads = choice.faces.tolist()
    quads_at: dict[frozenset[int], list[tuple[int, int]]] = {}
    for q, quad in enumerate(quads):
        for e in range(4):
            quads_at.setdefault(frozenset((quad[e], quad[(e + 1) % 4])), []).append((q, e))
    crossed: dict[frozenset[int], None] = {}
    stack = [frozenset((quads[half // 4][half % 4], quads[half // 4][(half % 4 + 1) % 4]))]
    while stack:
        edge = stack.pop()
        if edge in crossed:
            continue
        crossed[edge] = None
        for q, e in quads_at[edge]:
            stack.append(frozenset((quads[q][(e + 2) % 4], quads[q][(e + 3) % 4])))
    perimeter, n = choice.perimeter, choice.n_vertices
    rim = [u for u in range(perimeter) if frozenset((u, (u + 1) % perimeter)) in crossed]
    name: dict[object, int] = {}
    for u in range(perimeter):
        name[u] = len(name)
        if u in rim:
            name[frozenset((u, (u + 1) % perimeter))] = len(name)
    for one in [*range(perimeter, n), *(edge for edge in crossed if edge not in name)]:
        name[one] = len(name)
    made: list[list[int]] = []
    for q, quad in enumerate(quads):
        a, b, c, d = (name[v] for v in quad)
        ab, bc, cd, da = (name.get(frozenset((quad[e], quad[(e + 1) % 4]))) for e in range(4))
        if ab is not None and bc is not None:
            middle = name[("middle", q)] = len(name)
            made += [[a, ab, middle, da], [ab, b, bc, middle]]
            made += [[middle, bc, c, cd], [da, middle, cd, d]]
        elif ab is not None:
            made += [[a, ab, cd, d], [ab, b, c, cd]]
        elif bc is not None:
            made += [[a, b, bc, da], [da, bc, c, d]]
        else:
            made.append([a, b, c, d])
    return np.array(made, np.int32), rim


@settings(max_examples=40)
@given(st.data())
def test_any_fill_is_read_and_its_strips_are_doubled(
    source: PatternSource, data: st.DataObject
) -> None:
    """As quads that are split one by one: learned, relaxed and constructed fills alike."""
    sides = data.draw(st.lists(st.integers(1, 7), min_size=2, max_size=6))
    sides[0] += sum(sides) % 2
    if sum(sides) < 4:
        sides[0] += 2
    listed = list(fills(source, sides, limit=30, per_pattern=2))
    choice = Choice.of(listed[data.draw(st.integers(0, len(listed) - 1))])
    read = Expansion.of(choice)
    assert (read.pattern.code.tobytes(), read.widths) == (choice.code, choice.widths)
    same = read.resized(choice.widths[: read.pattern.n_chords])
    assert key(same) == key(choice)
    assert (same.rotation, same.mirrored) == (choice.rotation, choice.mirrored)
    # A pattern that is not known is recognised.
    found = Expansion.of(replace(choice, widths=(), origin="imported"))
    assert key(found.resized(found.widths)) == key(choice)
    half = data.draw(st.integers(0, len(read.twin) - 1))
    quads, rim = split(choice, half)
    longer = [
        n + sum(start <= u < start + n for u in rim)
        for start, n in zip(np.cumsum([0, *choice.lengths]), choice.lengths, strict=False)
    ]
    made = read.widened([int(read.chord[half])], rim, tuple(longer))
    assert made.lengths == tuple(longer)
    assert made.n_irregular == choice.n_irregular
    twin = weld(quads, int(quads.max()) + 1, sum(longer))
    assert key(made) == quads_key(quads, twin, False)
    again = Expansion.of(made)
    assert (again.widths, again.first, again.strict) == (made.widths, again.first, read.strict)
    if rim:
        assert {read.across(u) for u in rim} == set(rim)


def test_a_loop_through_a_row_is_twelve_quads_more(
    source: PatternSource, filled_grid: Network
) -> None:
    before = len(drawn_quads(source, filled_grid))
    at = np.array([0.4, 0.03, 0.0])
    edit = insert_loop(filled_grid, plane(), source, SIZES, at, UP)
    assert edit.notes == () and edit.patches == ()
    assert_sound(edit.network)
    assert len(drawn_quads(source, edit.network)) == before + 12
    more = {
        c: edit.network.chains[c].count - chain.count for c, chain in filled_grid.chains.items()
    }
    assert {c for c, n in more.items() if n} == {chain_at(filled_grid, 0.5, y) for y in range(4)}
    assert {edit.network.chains[c].count for c, n in more.items() if n} == {5}
    # What it becomes is what the list would offer for these counts.
    patch = patch_around(filled_grid, 0.5, 1.5)
    listed = ranked(edit.network, edit.network.patches[patch], source)
    assert choice_of(edit.network, patch) == Choice.of(next(listed))


def drawn_quads(source: PatternSource, network: Network) -> Int32Array:
    """The quads of the mesh, which must be manifold."""
    found = completed(network, plane(), source, SIZES.edge)
    assert found.network is network, "counts and fills are there"
    mesh = welded(found)
    assert_manifold(mesh)
    return mesh.quads


def test_a_strip_that_comes_back_at_right_angles_makes_both_counts_grow(
    source: PatternSource,
) -> None:
    editor = drawn_grid(source, 2)
    arc = [[2, 0, 0], [3, 0.2, 0], [3.4, 1.5, 0], [3, 3, 0], [1.5, 3.4, 0], [0.2, 3, 0], [0, 2, 0]]
    do(editor, "stroke", points=arc)
    do(editor, "corner", at=[2, 2, 0], wedge=[2.1, 2.1, 0])
    do(editor, "corner", at=[2, 1, 0], wedge=[2.1, 1, 0])
    bow = next(c for c, chain in editor.network.chains.items() if 4.0 < chain.length < 12.0)
    do(editor, "subdivide", at=editor.network.chains[bow].points[40].tolist(), count=8)
    before = editor.fill()
    assert sorted(len(patch.corners) for patch in before.network.patches.values()) == [4] * 5
    steps = editor.undoable
    do(editor, "insertloop", at=[0.01, 0.3, 0])
    after = editor.fill()
    assert_sound(after.network)
    assert_manifold(welded(after))
    assert editor.undoable == steps + 1
    for x, y in ((0.5, 0), (0, 0.5), (1, 0.5), (0.5, 1), (0.5, 2), (2, 0.5)):
        chain = chain_at(after.network, x, y)
        assert after.network.chains[chain].count == 5, (x, y)
    both = lengths(after.network, after.network.patches[patch_around(after.network, 0.5, 0.5)])
    assert both == (5, 5, 5, 5)
    assert after.network.chains[bow].count == 8
    # Both ways through the corner cell, once through the others on the way.
    assert len(welded(after).quads) - len(welded(before).quads) == 9 + 4 + 4 + 8
    do(editor, "undo")
    assert equal(editor.network, before.network)


def test_a_strip_around_a_ball_is_closed(source: PatternSource) -> None:
    """Through fills with irregular vertices, from wherever it begins."""
    editor = drawn_octants(source)
    before = editor.fill()
    chain = next(iter(before.network.chains.values()))
    at = chain.points[len(chain.points) // 3]
    do(editor, "insertloop", at=at.tolist())
    after = editor.fill()
    assert_sound(after.network)
    mesh, former = welded(after), welded(before)
    assert_manifold(mesh)
    gained = {
        c: after.network.chains[c].count - one.count for c, one in before.network.chains.items()
    }
    assert gained[chain.id] >= 1
    grown = sum(gained.values())
    sides = sum(sum(lengths(after.network, p)) for p in after.network.patches.values())
    assert (
        sides - sum(sum(lengths(before.network, p)) for p in before.network.patches.values())
        == 2 * grown
    )
    assert len(mesh.vertices) - len(mesh.quads) == 2
    assert same_poles(irregular_vertices(mesh)[1], irregular_vertices(former)[1])


def around(network: Network) -> int:
    """Edges around all patches."""
    return sum(sum(lengths(network, patch)) for patch in network.patches.values())


def same_poles(one: Int32Array, two: Int32Array) -> bool:
    """A loop makes and takes no irregular vertex."""
    return sorted(one.tolist()) == sorted(two.tolist())


@settings(max_examples=12)
@given(st.integers(0, 2**32 - 1))
def test_loops_anywhere_keep_what_must_hold(source: PatternSource, seed: int) -> None:
    """In a network with irregular patches, from curves and from within patches."""
    rng = np.random.default_rng(seed)
    editor = mixed(source)
    before = editor.fill()
    former = welded(before)
    at = rng.uniform(0.02, 1.98, 2)
    outcome = editor.do(Call("insertloop", {"at": [*at.tolist(), 0.0]}))
    assert outcome.refused is None and outcome.changed
    assert_sound(editor.network)
    after = editor.fill()
    mesh = welded(after)
    assert_manifold(mesh)
    assert after.network.patches.keys() == before.network.patches.keys()
    for patch in before.network.patches:
        one, two = choice_of(before.network, patch), choice_of(after.network, patch)
        assert (one.code, one.by) == (two.code, two.by)
        assert one.lengths == two.lengths or sum(two.lengths) > sum(one.lengths)
    assert len(mesh.quads) > len(former.quads)
    assert same_poles(irregular_vertices(mesh)[1], irregular_vertices(former)[1])
    editor.do(Call("undo"))
    assert equal(editor.network, before.network)


def mixed(source: PatternSource) -> Editor:
    """Two by two cells, one cut into triangles, one in two, others with sides of several counts
    and of several curves."""
    editor = drawn_grid(source, 2)
    do(editor, "stroke", points=line((1.5, 0), (1.5, 1)))
    do(editor, "stroke", points=line((0, 0), (1, 1)))
    do(editor, "subdivide", at=[1.3, 1, 0], count=5)
    return editor


def test_pinned_counts_grow_too_and_stay_pinned(source: PatternSource) -> None:
    editor = drawn_grid(source, 2)
    do(editor, "subdivide", at=[0.5, 0, 0], count=6, strip=True)
    editor.fill()
    do(editor, "insertloop", at=[0.3, 0, 0])
    chain = editor.network.chains[chain_at(editor.network, 0.5, 1)]
    assert (chain.count, chain.pinned) == (7, True)


def test_where_there_are_no_quads_no_loop_is_inserted(source: PatternSource) -> None:
    editor = drawn_grid(source, 1)
    do(editor, "stroke", points=line((3, 0), (4, 0)))
    before = editor.state
    for at in ([3.5, 0, 0], [-2, -2, 0]):
        outcome = editor.do(Call("insertloop", {"at": at}))
        assert outcome.refused == "there is no patch here; point into one"
    assert editor.state is before


def test_no_loop_makes_a_boundary_longer_than_can_be(filled_grid: Network) -> None:
    """The call before it says so, and the network stays as it was."""
    network = filled_grid
    for y in range(4):
        network = with_count(network, chain_at(network, 0.5, y), 996)
    with patterndb.open() as opened, pytest.raises(RefusedError, match="2000 are the most"):
        insert_loop(network, plane(), opened, SIZES, np.array([0.5, 0.0, 0.0]), UP)


def test_edges_of_a_chain_are_told_by_arc_length(filled_grid: Network) -> None:
    chain = filled_grid.chains[chain_at(filled_grid, 0.5, 0)]
    along = arc_length(chain.points)
    for place in np.linspace(0, len(chain.points) - 1, 41):
        length = np.interp(place, np.arange(len(along)), along)
        wanted = min(int(4 * length / along[-1]), 3)
        assert edge_at(chain, float(place)) == wanted


def test_a_loop_through_an_imported_mesh_goes_on_to_its_borders(source: PatternSource) -> None:
    """Its patches hold all their vertices; those on the way are placed anew, which is told."""
    side = np.linspace(0.0, 1.0, 7)
    vertices = np.array([[x, y, 0.0] for y in side for x in side])
    vertices[24, :2] += 0.03
    quads = [[7 * j + i, 7 * j + i + 1, 7 * j + i + 8, 7 * j + i + 7]
             for j in range(6) for i in range(6)]  # fmt: skip
    found = imported(vertices, quads)
    at, up = np.array([0.5, 0.02, 0.0]), UP
    edit = insert_loop(found.network, found.ground, source, found.sizes, at, up)
    assert_sound(edit.network)
    assert edit.notes and all("placed anew" in note for note in edit.notes)
    total = sum(len(choice_of(edit.network, p).faces) for p in edit.network.patches)
    assert total == 42


def pair_case(source: PatternSource) -> Editor:
    """One square cell of sides 8, 8, 6, 6 whose fill has a pair of irregular vertices."""
    editor = drawn_grid(source, 1)
    for at, count in (((0.5, 0), 8), ((1, 0.5), 8), ((0.5, 1), 6), ((0, 0.5), 6)):
        do(editor, "subdivide", at=[*at, 0], count=count)
    editor.fill()
    return editor


def inner_poles(network: Network, source: PatternSource) -> np.ndarray:
    """(k, 3) irregular vertices inside the patches, by valence."""
    found = completed(network, plane(), source, SIZES.edge)
    assert found.network is network, "counts and fills are there"
    mesh = welded(found)
    assert_manifold(mesh)
    which, valence = irregular_vertices(mesh)
    inside = (mesh.node[which] < 0) & (mesh.chain[which] < 0)
    return mesh.vertices[which[inside]][np.argsort(valence[inside], kind="stable")]


def test_a_pair_follows_the_drag_and_comes_back(source: PatternSource) -> None:
    editor = pair_case(source)
    former = editor.network
    (patch,) = former.patches
    before = choice_of(former, patch)
    poles = inner_poles(former, source)
    assert len(poles) == 2
    moved = 0
    for by in ([0.2, 0, 0], [-0.2, 0, 0], [0, 0.2, 0], [0, -0.2, 0], [0.15, -0.15, 0]):
        at = poles.mean(axis=0)
        outcome = editor.do(Call("movepair", {"at": at.tolist(), "to": (at + by).tolist()}))
        if outcome.refused is not None:
            assert "can move this way while its border stays" in outcome.refused
            assert editor.network is former
            continue
        moved += 1
        assert_sound(editor.network)
        after = choice_of(editor.network, patch)
        assert (after.code, after.lengths, after.by) == (before.code, before.lengths, "user")
        assert (after.rotation, after.mirrored) == (before.rotation, before.mirrored)
        assert after.widths != before.widths
        there = inner_poles(editor.network, source)
        assert (there - poles).mean(axis=0) @ np.array(by) > 0.0
        do(editor, "undo")
        assert equal(editor.network, former)
    assert moved >= 2


def test_longer_drags_take_pairs_further(source: PatternSource) -> None:
    network = pair_case(source).network
    poles = inner_poles(network, source)
    at = poles.mean(axis=0)
    (patch,) = network.patches
    far: list[float] = []
    for way in np.array([[1.0, 0, 0], [-1.0, 0, 0], [0, 1.0, 0], [0, -1.0, 0]]):
        along = [0.0]
        for length in (0.1, 0.25, 0.5, 1.0):
            try:
                edit = move_pair(network, plane(), source, SIZES, patch, at, length * way)
            except RefusedError:
                continue
            along.append(float(((inner_poles(edit.network, source) - poles) @ way).mean()))
        assert sorted(along) == pytest.approx(along, abs=0.02)
        far.append(along[-1])
    assert max(far) > 0.1


def test_a_pair_without_room_or_drag_stays(source: PatternSource, filled_grid: Network) -> None:
    patch = patch_around(filled_grid, 1.5, 1.5)
    at = np.array([1.5, 1.5, 0.0])
    edit = move_pair(filled_grid, plane(), source, SIZES, patch, at, np.zeros(3))
    assert edit.network is filled_grid
    with pytest.raises(RefusedError, match="no irregular vertices inside"):
        move_pair(filled_grid, plane(), source, SIZES, patch, at, [0.1, 0, 0])
    # Of three sides, counts alone say where the irregular vertex is.
    editor = drawn_octants(source)
    network = editor.fill().network
    three = next(iter(network.patches))
    top = sphere().nearest(np.array([[0.6, 0.6, 0.6]])).points[0]
    with pytest.raises(RefusedError, match="can move this way while its border stays"):
        move_pair(network, editor.ground, source, editor.sizes, three, top, [0.1, 0.0, 0.0])


def test_least_changes_keep_all_sides_and_are_no_sums(source: PatternSource) -> None:
    """Every change by at most 1 each way is a sum of them, found by brute force."""
    for sides in ((6, 6, 8, 8), (5, 4, 6, 3, 4), (4, 5, 4, 5)):
        for fill in fills(source, sides, limit=3, per_pattern=1, strict=True):
            chords = Chords.from_label(fill.pattern.label)
            steps = least_changes(chords)
            assert all((chords.side_lengths(step) == 0).all() for step in steps)
            assert {(-step).tobytes() for step in steps} == {step.tobytes() for step in steps}
            if chords.n > 8:
                continue
            for change in product((-1, 0, 1), repeat=chords.n):
                left = np.array(change, np.int32)
                if (chords.side_lengths(left) == 0).all():
                    while left.any():
                        left = left - next(step for step in steps if within(step, left))


def within(step: Int32Array, change: Int32Array) -> bool:
    return bool((step * change >= 0).all() and (np.abs(step) <= np.abs(change)).all())


def test_the_nearest_edge_of_quads_is_the_nearest(source: PatternSource) -> None:
    placed = next(iter(drawn_grid(source, 1).fill().placed.values()))
    for x, y, middle in ((0.5, 0.38, (0.5, 0.375)), (0.49, 0.6, (0.5, 0.625))):
        half = nearest_edge(placed, np.array([x, y, 0.0]))
        tail = placed.quads.ravel()[half]
        head = np.roll(placed.quads, -1, axis=1).ravel()[half]
        at = (placed.vertices[tail] + placed.vertices[head]) / 2
        assert np.linalg.norm(at[:2] - middle) < 0.13


def test_grounds_need_not_be_flat(source: PatternSource) -> None:
    """On a ball nothing leaves it."""
    editor = drawn_octants(source)
    editor.fill()
    do(editor, "insertloop", at=[0.0, 0.6, 0.8])
    mesh = welded(editor.fill())
    ground: Ground = editor.ground
    off = np.linalg.norm(ground.nearest(mesh.vertices).points - mesh.vertices, axis=1)
    assert off.max() < 1e-9
