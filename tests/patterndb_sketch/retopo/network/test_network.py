"""The network of curves: its structure, equation 1, places, cuts, patches and borders."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from patterndb.geometry.points import Points
from patterndb.geometry.polyline import at_lengths
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.network import (
    AtChain,
    AtNode,
    BrokenNetworkError,
    Free,
    Network,
    NetworkBuilder,
    add_borders,
    add_chain,
    add_loop,
    are_equal,
    check_network,
    cut_chain,
    find_nearest_node,
    find_nearest_place,
    find_patches,
    measure_enclosed,
    set_choice,
    set_count,
    take_samples,
    trace_outline,
)
from patterndb_sketch.retopo.network.samples import split_count
from tests.support.retopo.networks import (
    SIZES,
    chain_between,
    drawn,
    even,
    faces,
    genus,
    node_at,
    plane,
    sphere,
    square,
    up,
)


def circle(n: int = 400, radius: float = 1.0, z: float = 0.0) -> Points:
    t = np.linspace(0.0, 2.0 * np.pi, n, endpoint=False)
    return np.c_[radius * np.cos(t), radius * np.sin(t), np.full(n, z)]


def test_a_circle_is_round_and_clockwise_it_is_not() -> None:
    found = measure_enclosed(circle(), up(circle()))
    assert found.roundness == pytest.approx(1.0, rel=0.01)
    assert found.encloses
    back = measure_enclosed(circle()[::-1], up(circle()))
    assert back.roundness == pytest.approx(-1.0, rel=0.01)
    assert not back.encloses


def test_a_loop_round_a_cylinder_encloses_neither_side() -> None:
    line = circle(z=1.0)
    normals = circle()
    for points, above in ((line, normals), (line[::-1], normals[::-1])):
        found = measure_enclosed(points, above)
        assert abs(found.roundness) < 0.01
        assert not found.encloses


@pytest.mark.parametrize("latitude", [-80.0, -30.0, 3.0, 10.0, 45.0, 70.0])
def test_a_latitude_circle_is_as_round_as_its_sine(latitude: float) -> None:
    angle = math.radians(latitude)
    line = circle(radius=math.cos(angle), z=math.sin(angle))
    found = measure_enclosed(line, line)
    assert found.roundness == pytest.approx(math.sin(angle), abs=1e-3)
    assert found.encloses == (math.sin(angle) > 0.1)


@pytest.mark.parametrize("length", [1.0, 8.0, 40.0, 1000.0])
def test_ribbons_enclose_however_long(length: float) -> None:
    line = even([[0, 0], [length, 0], [length, 1], [0, 1]], True, 0.1)
    found = measure_enclosed(line, up(line))
    assert found.roundness == pytest.approx(math.pi * length / (1.0 + length) ** 2, rel=1e-6)
    assert found.encloses
    assert not measure_enclosed(line[::-1], up(line)).encloses


def test_a_figure_eight_and_a_line_there_and_back_enclose_nothing() -> None:
    t = np.linspace(0.0, 2.0 * np.pi, 200, endpoint=False)
    eight = np.c_[np.sin(t), np.sin(2 * t), np.zeros(200)]
    assert not measure_enclosed(eight, up(eight)).encloses
    line = even([[0, 0], [1, 0.3]])
    both = np.concatenate([line, line[-2:0:-1]])
    assert not measure_enclosed(both, up(both)).encloses
    assert not measure_enclosed(both[:1], up(both[:1])).encloses


def test_four_strokes_make_a_square() -> None:
    network = square()
    (patch,) = network.patches.values()
    assert len(network.nodes) == len(network.chains) == 4
    assert [len(side) for side in patch.sides] == [1, 1, 1, 1]
    assert all(node.corner_flags == (True, True) for node in network.nodes.values())
    around, _ = trace_outline(network, patch.loop)
    assert measure_enclosed(around, up(around)).area == pytest.approx(2.0)


@given(
    st.lists(st.integers(0, 359), min_size=2, max_size=9, unique_by=lambda degree: degree // 8),
    st.randoms(),
)
def test_ends_are_counter_clockwise_whatever_order_they_come_in(degrees: list[int], random) -> None:
    random.shuffle(degrees)
    builder = NetworkBuilder(Network())
    node = builder.add_node([0.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    towards: dict[int, int] = {}
    for degree in degrees:
        angle = math.radians(degree)
        # Some bend on their way, some arrive and some leave.
        far = [math.cos(angle) - 0.3 * math.sin(angle), math.sin(angle) + 0.3 * math.cos(angle)]
        line = even([[0, 0], [0.5 * math.cos(angle), 0.5 * math.sin(angle)], far])
        if degree % 2:
            half = 2 * builder.add_chain(line, up(line), AtNode(node), Free())
        else:
            half = 2 * builder.add_chain(line[::-1], up(line), Free(), AtNode(node)) + 1
        towards[half] = degree
    network = builder.finish()
    check_network(network)
    around = [towards[half] for half in network.nodes[node].ends]
    first = around.index(min(around))
    assert around[first:] + around[:first] == sorted(degrees)


@given(
    st.booleans(),
    st.integers(3, 9),
    st.lists(st.floats(0.0, 1.0), min_size=1, max_size=5),
    st.floats(0.0, 1.0),
)
def test_places_of_before_cuts_stay_where_they_were(
    closed: bool, n: int, cuts: list[float], asked: float
) -> None:
    angles = np.linspace(0.0, 5.0, n)
    line = np.c_[np.cos(angles), np.sin(angles), np.zeros(n)]
    if closed:
        network, chain = add_loop(Network(), line, up(line))
    else:
        network, chain = add_chain(Network(), line, up(line))
    old = network.chains[chain]
    builder = NetworkBuilder(network)
    nodes: list[int] = []
    for cut in cuts:
        nodes.append(builder.cut_chain(chain, cut * old.segments))
    now, place = builder.locate(chain, asked * old.segments)
    expected = at_places(old.round, asked * old.segments)
    # A cut next to a sample is at the sample, which moves what is between by as much.
    step = np.linalg.norm(np.diff(old.round, axis=0), axis=1).max()
    assert at_places(builder.chains[now].round, place) == pytest.approx(expected, abs=0.3 * step)
    wanted = [at_places(old.round, cut * old.segments) for cut in cuts]
    for node, point in zip(nodes, wanted, strict=True):
        assert np.linalg.norm(builder.nodes[node].point - point) <= 0.1 * step + 1e-12
    for node in nodes:
        if node in builder.nodes and builder.nodes[node].ends:
            builder.flag(builder.nodes[node].ends[0], len(builder.nodes[node].ends) > 1)
    done = builder.finish()
    check_network(done)
    assert sum(c.length for c in done.chains.values()) == pytest.approx(old.length, rel=0.02)


def at_places(line: Points, place: float) -> Points:
    k = np.arange(len(line))
    return np.array([np.interp(place, k, line[:, c]) for c in range(3)])


@given(st.integers(0, 40), st.floats(0.01, 10.0), st.floats(0.01, 10.0))
def test_counts_split_in_proportion_and_keep_their_sum(count: int, one: float, two: float) -> None:
    first, last = split_count(count, one, two)
    if count == 0:
        assert (first, last) == (0, 0)
    elif count == 1:
        assert (first, last) == (1, 1)
    else:
        assert first + last == count
        assert first >= 1 and last >= 1
        assert abs(first - count * one / (one + two)) <= 1.0


def test_a_cut_without_a_corner_leaves_the_chain_as_it_was() -> None:
    network = set_count(square(), chain_between(square(), (0, 0), (2, 0)), 12, True)
    chain = chain_between(network, (0, 0), (2, 0))
    builder = NetworkBuilder(network)
    builder.cut_chain(chain, 30.0)
    done = builder.finish()
    check_network(done)
    again = done.chains[chain_between(done, (0, 0), (2, 0))]
    assert again.points.tobytes() == network.chains[chain].points.tobytes()
    assert (again.count, again.pinned) == (12, True)


def test_a_corner_cut_in_splits_the_count() -> None:
    network = set_count(square(), chain_between(square(), (0, 0), (2, 0)), 12, True)
    done, node = cut_chain(network, chain_between(network, (0, 0), (2, 0)), 25.0)
    check_network(done)
    assert done.nodes[node].point == pytest.approx([0.5, 0, 0])
    assert done.chains[chain_between(done, (0, 0), (0.5, 0))].count == 3
    assert done.chains[chain_between(done, (0.5, 0), (2, 0))].count == 9
    (patch,) = done.patches.values()
    assert len(patch.corners) == 5


def test_edits_leave_the_old_network_as_it_was() -> None:
    network = square()
    copy = replace(
        network,
        nodes={k: replace(node) for k, node in network.nodes.items()},
        chains={k: replace(chain) for k, chain in network.chains.items()},
        patches={k: replace(patch) for k, patch in network.patches.items()},
    )
    chain = chain_between(network, (0, 0), (2, 0))
    cut_chain(network, chain, 7.0)
    builder = NetworkBuilder(network)
    builder.remove_chain(chain)
    builder.finish(forget=True)
    line = even([[1, 0], [1, 1]])
    add_chain(network, line, up(line), AtChain(chain, 50.0), Free())
    assert are_equal(network, copy)
    assert not are_equal(network, set_count(network, chain, 3))
    with pytest.raises(ValueError, match="read-only"):
        network.chains[chain].points[0] = 0.0


def test_patches_that_do_not_change_keep_their_ids_and_choices() -> None:
    network = drawn([[0, 0], [4, 0]], network=None)
    for line in ([[0, 0], [0, 1]], [[0, 1], [4, 1]], [[4, 1], [4, 0]], [[2, 0], [2, 1]]):
        network = drawn(line, network=network)
    left, right = sorted(
        network.patches.values(), key=lambda p: trace_outline(network, p.loop)[0][:, 0].mean()
    )
    network = set_choice(set_choice(network, left.id, "one"), right.id, "two")
    done = drawn([[3, 0], [3, 1]], network=network)
    assert done.patches[left.id].choice == "one"
    assert right.id not in done.patches
    assert sorted(str(p.choice) for p in done.patches.values()) == ["None", "None", "one"]


def test_a_loop_longer_than_allowed_is_no_patch() -> None:
    network = square()
    assert find_patches(network, network.nodes, ()).patches.keys() == network.patches.keys()
    short = replace(network, longest=5.9, patches={})
    assert not find_patches(short, network.nodes, ()).patches
    enough = replace(network, longest=6.1, patches={})
    assert len(find_patches(enough, network.nodes, ()).patches) == 1


def test_a_loop_can_be_made_a_patch_against_equation_one() -> None:
    line = np.c_[circle(80)[:, :2], np.zeros(80)]
    normals = circle(80)
    network, chain = add_loop(Network(), line, normals)
    builder = NetworkBuilder(network)
    for place in (0.0, 40.0):
        node = builder.cut_chain(chain, place)
        for half in builder.nodes[node].ends:
            builder.flag(half, True)
    plain = builder.finish()
    check_network(plain)
    assert not plain.patches
    builder = NetworkBuilder(plain)
    half = 2 * min(plain.chains)
    done = builder.finish(also=[half])
    check_network(done)
    (patch,) = done.patches.values()
    assert half in patch.loop
    open_end, single = add_chain(Network(), even([[0, 0], [1, 0]]), up(even([[0, 0], [1, 0]])))
    with pytest.raises(InvalidRetopoError, match="can be no patch"):
        NetworkBuilder(open_end).finish(also=[2 * single])


@pytest.mark.parametrize("arrives", [False, True])
def test_a_patch_is_asked_for_by_a_curve_that_is_joined_to_its_next(arrives: bool) -> None:
    network, chain = add_loop(Network(), np.c_[circle(80)[:, :2], np.zeros(80)], circle(80))
    builder = NetworkBuilder(network)
    for place in (0.0, 40.0):
        node = builder.cut_chain(chain, place)
        for half in builder.nodes[node].ends:
            builder.flag(half, True)
    # No corner: the two curves that meet here become one.
    between = builder.cut_chain(chain, 20.0)
    half = next(h for h in builder.nodes[between].ends if not h & 1)
    if arrives:
        half = next(h for h in builder.nodes[between].ends if h & 1) ^ 1
    done = builder.finish(also=[half])
    check_network(done)
    assert half >> 1 not in done.chains and between not in done.nodes
    (patch,) = done.patches.values()
    assert all(h & 1 == half & 1 for h in patch.loop)


def test_samples_are_those_of_all_chains() -> None:
    network = drawn([[0, 0], [1, 0]], [[0.5, 0], [0.5, 1]])
    network, loop = add_loop(network, circle(20) + np.array([3.0, 0.0, 0.0]), up(circle(20)))
    of = take_samples(network)
    assert len(of.points) == sum(len(c.points) for c in network.chains.values())
    for k, chain in enumerate(of.ids):
        mine = slice(of.starts[k], of.starts[k + 1])
        line = network.chains[int(chain)]
        assert (of.points[mine] == line.points).all()
        assert (of.chain[mine] == chain).all()
        assert (of.place[mine] == np.arange(len(line.points))).all()
        assert of.is_closed_loop[k] == line.is_closed_loop == (chain == loop)
        assert (of.node[of.starts[k]], of.node[of.starts[k + 1] - 1]) == (line.start, line.end)
    for node in network.nodes.values():
        rows = np.flatnonzero(of.node == node.id)
        assert len(rows) == node.valence
        assert (of.points[rows] == node.point).all()


@given(st.floats(-1.5, 4.5), st.floats(-1.5, 1.5))
def test_nearest_places_are_those_of_a_fine_sampling(x: float, y: float) -> None:
    network = drawn([[0, 0], [1, 0]], [[0.5, 0], [0.5, 1]])
    network, _ = add_loop(network, circle(20) + np.array([3.0, 0.0, 0.0]), up(circle(20)))
    at = np.array([x, y, 0.0])
    best = np.inf
    for chain in network.chains.values():
        fine = at_lengths(chain.round, np.linspace(0.0, chain.length, 4000))
        best = min(best, float(np.linalg.norm(fine - at, axis=1).min()))
    found = find_nearest_place(take_samples(network), at, [0, 0, 1], 10.0)
    assert found is not None
    assert found.distance == pytest.approx(best, abs=2e-3)
    chain = network.chains[found.chain]
    spot = at_places(chain.round, found.place)
    assert np.linalg.norm(spot - at) == pytest.approx(found.distance, abs=1e-9)
    assert find_nearest_place(take_samples(network), at, [0, 0, -1], 10.0) is None
    if found.distance > 0.0:
        assert (
            find_nearest_place(take_samples(network), at, [0, 0, 1], 0.99 * found.distance) is None
        )


def test_nearest_nodes_are_of_the_valence_asked_for() -> None:
    network = drawn([[0, 0], [1, 0]], [[0.5, 0], [0.5, 1]])
    at, normal = [0.1, 0.0, 0.0], [0.0, 0.0, 1.0]
    one = find_nearest_node(network, at, normal, 5.0, range(1, 2))
    three = find_nearest_node(network, at, normal, 5.0, range(2, 9))
    assert one is not None and one.id == node_at(network, 0, 0)
    assert three is not None and three.valence == 3
    assert find_nearest_node(network, at, normal, 0.05, range(1, 9)) is None
    assert find_nearest_node(network, at, [0.0, 0.0, -1.0], 5.0, range(1, 9)) is None


def test_borders_are_marked_loops_that_get_a_patch_on_the_surface_only() -> None:
    network = add_borders(Network(), plane(), SIZES.sampling)
    check_network(network)
    (chain,) = network.chains.values()
    assert chain.is_closed_loop and chain.marks == ("", "border")
    assert chain.length == pytest.approx(40.0)
    for corner in plane().vertices:
        assert (chain.points == corner).all(axis=1).any()
    cut = drawn([[-5, 1], [5, 1]], network=network)
    assert genus(cut) == 0
    assert len(cut.patches) == 2
    for patch in cut.patches.values():
        around, normals = trace_outline(cut, patch.loop)
        assert measure_enclosed(around, normals).area > 0
        assert not any(cut.mark(half) for half in patch.loop)
    assert not add_borders(Network(), sphere(), 0.1).chains


def test_borders_that_touch_in_a_vertex_are_told_apart() -> None:
    vertices = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [-1, 0, 0], [-1, -1, 0]], float)
    surface = Surface.from_arrays(vertices, [[0, 1, 2], [0, 3, 4]]).orient()
    network = add_borders(Network(), surface, 0.1)
    check_network(network)
    assert len(network.chains) == 2
    for chain in network.chains.values():
        assert measure_enclosed(chain.points, chain.normals).area == pytest.approx(0.5)


def test_check_finds_what_is_broken() -> None:
    network = square()
    chain = network.chains[chain_between(network, (0, 0), (2, 0))]
    node = network.nodes[node_at(network, 0, 0)]
    (patch,) = network.patches.values()
    wrong: list[tuple[str, Network]] = [
        ("does not end exactly", changed(network, replace(chain, points=chain.points + 1e-12))),
        ("not length 1", changed(network, replace(chain, normals=2.0 * chain.normals))),
        ("not finite", changed(network, replace(chain, points=chain.points * np.nan))),
        ("count", changed(network, replace(chain, count=-1))),
        ("pinned", changed(network, replace(chain, pinned=True))),
        ("marks", changed(network, replace(chain, marks=("", "wall")))),
        ("is not there", changed(network, replace(chain, start=999))),
        ("flags", changed(network, replace(node, corner_flags=(False, False)))),
        ("flag for each", changed(network, replace(node, corner_flags=(True,)))),
        ("leaves another", changed(network, replace(node, ends=(*node.ends, 2 * chain.id + 1)))),
        ("not once among", changed(network, replace(node, ends=node.ends[:1]))),
        ("no patch", replace(network, patches={})),
        ("not a face", changed(network, replace(patch, corners=(0, 1, 2)))),
        ("next_id", replace(network, next_id=patch.id)),
        ("is kept as", replace(network, nodes={**network.nodes, 77: node}, next_id=100)),
    ]
    check_network(network)
    for words, broken in wrong:
        with pytest.raises(BrokenNetworkError):
            check_network(broken)
        assert words
    for words, broken in wrong[:8]:
        with pytest.raises(BrokenNetworkError, match=words.split()[0]):
            check_network(broken)


def changed(network: Network, thing: object) -> Network:
    for name in ("nodes", "chains", "patches"):
        things = getattr(network, name)
        key = getattr(thing, "id")  # noqa: B009
        if key in things:
            return replace(network, **{name: {**things, key: thing}})
    raise AssertionError("nothing of that id")


def test_bad_input_is_refused_in_words() -> None:
    network = square()
    line = even([[0, 0], [1, 0]])
    with pytest.raises(InvalidRetopoError, match="no node 99"):
        add_chain(network, line, up(line), AtNode(99))
    with pytest.raises(InvalidRetopoError, match="no chain 99"):
        add_chain(network, line, up(line), AtChain(99, 1.0))
    with pytest.raises(InvalidRetopoError, match="is not on chain"):
        cut_chain(network, chain_between(network, (0, 0), (2, 0)), 1e6)
    with pytest.raises(InvalidRetopoError, match="one each"):
        add_chain(network, line, up(line)[:-1])
    with pytest.raises(InvalidRetopoError, match="3 or more"):
        add_loop(network, line[:2], up(line[:2]))
    with pytest.raises(InvalidRetopoError, match="1 or more"):
        set_count(network, min(network.chains), 0, True)
    with pytest.raises(InvalidRetopoError, match="no patch 99"):
        set_choice(network, 99, None)
    with pytest.raises(RefusedError, match="one place"):
        corner = AtNode(node_at(network, 0, 0))
        add_chain(network, line[:2], up(line[:2]), corner, corner)


def test_every_half_chain_is_in_one_face() -> None:
    network = drawn([[0, 0], [2, 0]], [[1, -1], [1, 1]], [[0.5, -0.5], [1.7, 0.9]])
    halves = [half for loop in faces(network) for half in loop]
    assert sorted(halves) == sorted(h for c in network.chains for h in (2 * c, 2 * c + 1))
