"""Strokes into the network: snapping, T-junctions, crossings, closed strokes, known ends."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.network import (
    AtChain,
    AtNode,
    Free,
    Network,
    add_borders,
    add_loop,
    are_equal,
    check_network,
    cut_chain,
    find_nearest_place,
    measure_enclosed,
    trace_outline,
)
from patterndb_sketch.retopo.network.crossings import find_crossings, find_self_crossings
from patterndb_sketch.retopo.network.samples import take_samples
from patterndb_sketch.retopo.tools.patch import make_patch
from patterndb_sketch.retopo.tools.stroke import insert_stroke
from patterndb_sketch.retopo.tracing import SurfaceCurve, clean_stroke
from tests.support.retopo.networks import (
    SIZES,
    chain_between,
    drawn,
    even,
    flat,
    genus,
    node_at,
    plane,
    sphere,
    square,
    up,
)


def areas(network: Network) -> list[float]:
    """Of all patches, rounded, in order."""
    found = [trace_outline(network, patch.loop) for patch in network.patches.values()]
    return sorted(round(measure_enclosed(points, normals).area, 6) for points, normals in found)


def test_a_chord_of_a_square_makes_two_t_junctions() -> None:
    network = drawn([[1, 0], [1, 1]], network=square())
    assert areas(network) == pytest.approx([1.0, 1.0])
    for x, y, side in ((1, 0, 1), (1, 1, -1)):
        node = network.nodes[node_at(network, x, y)]
        assert node.valence == 3 and sum(node.corner_flags) == 2 and node.cut
        # The straight wedge is the one that the chord is not in.
        half = node.ends[node.corner_flags.index(False)]
        after = node.ends[(node.corner_flags.index(False) + 1) % 3]
        xs = [network.chains[h >> 1].directed(h)[0][1][0] - x for h in (half, after)]
        assert np.sign(xs).tolist() == [-side, side]
    assert [len(p.corners) for p in network.patches.values()] == [4, 4]


@pytest.mark.parametrize("longest", [3.9, 4.1])
def test_a_loop_too_long_for_a_patch_is_told_and_can_be_made_one(longest: float) -> None:
    corners = [[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]]
    network = Network(longest=longest)
    notes: list[tuple[str, ...]] = []
    for pair in itertools.pairwise(corners):
        edit = insert_stroke(network, plane(), SIZES, flat(pair))
        network = edit.network
        notes.append(edit.notes)
    assert notes[:3] == [()] * 3
    if longest > 4.0:
        assert notes[3] == () and areas(network) == [1.0]
        return
    assert not network.patches
    assert "is 4 long, and none above 3.9" in notes[3][0]
    made = make_patch(network, plane(), plane().nearest([[0.5, 0.5, 0.0]]))
    assert areas(made.network) == [1.0]


def test_a_crossing_is_a_corner_of_all_four_wedges() -> None:
    network = drawn([[0, 0], [1, 0]], [[0.5, -0.5], [0.5, 0.5]])
    node = network.nodes[node_at(network, 0.5, 0)]
    assert node.corner_flags == (True,) * 4
    assert len(network.nodes) == 5 and len(network.chains) == 4


def test_ends_snap_to_open_ends_before_corners_before_sides() -> None:
    # An open end at 0.09, a corner at 0.06, a side right there: all within the radius of 0.1.
    network = drawn(
        [[0, 1], [0.06, 0], [1, 0]], [[-0.5, -1], [-0.09, 0]], [[-0.5, 0.02], [-0.2, 0.02]]
    )
    place = find_nearest_place(take_samples(network), [0.06, 0, 0], [0, 0, 1], 0.1)
    assert place is not None
    network, corner = cut_chain(network, place.chain, place.place)
    done = insert_stroke(network, plane(), SIZES, flat([[0, 0], [0, -1]]))
    joined = done.network.nodes[node_at(done.network, -0.09, 0)]
    assert joined.valence == 2 and joined.corner_flags == (True, True)
    # Without the open end, the corner; without that, the side.
    away = insert_stroke(network, plane(), SIZES, flat([[0.03, 0], [0.5, -1]])).network
    assert away.nodes[corner].valence == 3
    side = drawn([[0.5, 0.07], [0.5, 1]], network=network)
    assert side.nodes[node_at(side, 0.5, 0)].valence == 3


def test_a_snapped_end_takes_the_stroke_along_less_and_less() -> None:
    network = drawn([[0, 0], [2, 0]])
    made = insert_stroke(network, plane(), SIZES, flat([[2, 0.08], [2, 1.08]]))
    (chain,) = made.chains
    line = made.network.chains[chain].points
    assert line[0].tolist() == [2.0, 0.0, 0.0]
    assert line[-1] == pytest.approx([2, 1.08, 0])
    assert line[:, 1] == pytest.approx(np.linspace(0.0, 1.08, len(line)), abs=1e-9)


def test_a_joint_is_a_corner_or_smooth_on_request() -> None:
    network = drawn([[0, 0], [1, 0]])
    sharp = insert_stroke(network, plane(), SIZES, flat([[1, 0], [2, 0]]))
    assert len(sharp.network.chains) == 2
    assert sharp.network.nodes[node_at(sharp.network, 1, 0)].corner_flags == (True, True)
    smooth = insert_stroke(network, plane(), SIZES, flat([[1, 0], [2, 0]]), smooth=(True, False))
    check_network(smooth.network)
    (chain,) = smooth.network.chains.values()
    assert len(smooth.network.nodes) == 2 and chain.length == pytest.approx(2.0)


def test_known_ends_are_taken_without_looking() -> None:
    network = square()
    chain = chain_between(network, (0, 0), (2, 0))
    corner = node_at(network, 2, 1)
    made = insert_stroke(
        network,
        plane(),
        SIZES,
        flat([[0.3, 0.2], [1.7, 0.9]]),
        AtChain(chain, 50.0),
        AtNode(corner),
    )
    check_network(made.network)
    (new,) = [made.network.chains[c] for c in made.chains if made.network.chains[c].end == corner]
    assert new.points[0] == pytest.approx([1, 0, 0])
    free = insert_stroke(network, plane(), SIZES, flat([[1, 0.05], [1, 0.95]]), Free(), Free())
    assert len(free.nodes) == 2 and len(free.patches) == 0
    with pytest.raises(InvalidRetopoError, match="no node"):
        insert_stroke(network, plane(), SIZES, flat([[1, 0], [1, 1]]), AtNode(999))
    with pytest.raises(InvalidRetopoError, match="no ends"):
        insert_stroke(network, plane(), SIZES, flat([[1, 0], [1, 1], [2, 1]], True), Free())


def test_a_hand_that_overshoots_leaves_no_splinter() -> None:
    bent = [[1, 0.5], [1.02, 0.03], [1.06, -0.03], [1.03, -0.05]]
    network = drawn(bent, network=square())
    assert len(network.chains) == 4 + 2
    assert min(chain.length for chain in network.chains.values()) > 0.3
    assert genus(network) == 0


def test_strokes_through_a_corner_go_through_it() -> None:
    network = drawn([[0, 0], [1, 0]], [[0.5, -0.5], [0.5, 0.5]], [[0, -0.502], [1, 0.502]])
    assert network.nodes[node_at(network, 0.5, 0)].valence == 6
    assert len(network.chains) == 6
    assert genus(network) == 0


def test_a_stroke_that_runs_over_the_samples_of_others_crosses_once_each() -> None:
    # All samples lie on one grid: points on segments, and points on points.
    lines = [[[0, y], [1, y]] for y in (0.2, 0.4, 0.6)]
    network = drawn(*lines, [[0.3, 0], [0.3, 1]], [[0.5, 0], [0.5, 1]], [[0.1, 0.1], [0.7, 0.7]])
    assert genus(network) == 0
    check_network(network)
    crossed = [node for node in network.nodes.values() if node.valence > 2]
    # Three by two, and the diagonal through (0.2, 0.2), (0.4, 0.4), (0.6, 0.6), (0.3, 0.3)
    # and (0.5, 0.5).
    assert len(crossed) == 6 + 5


def test_closed_strokes_snap_to_nothing_and_have_no_corner() -> None:
    t = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    ring = np.c_[1 + 0.43 * np.cos(t), 0.5 + 0.43 * np.sin(t)]
    inside = insert_stroke(square(), plane(), SIZES, flat(ring, True))
    (chain,) = inside.chains
    assert inside.network.chains[chain].is_closed_loop
    assert not inside.patches and len(inside.network.patches) == 1
    wide = np.c_[1 + 0.8 * np.cos(t), 0.5 + 0.8 * np.sin(t)]
    done = insert_stroke(square(), plane(), SIZES, flat(wide, True)).network
    check_network(done)
    assert genus(done) == 0
    # Between the square's long sides, two caps beyond them, and two ends of the square.
    assert len(done.patches) == 5
    assert sum(node.valence == 4 for node in done.nodes.values()) == 4


def test_a_figure_eight_crosses_itself_once() -> None:
    t = np.linspace(0, 2 * np.pi, 300, endpoint=False)
    eight = np.c_[np.sin(t), np.sin(2 * t)]
    network = insert_stroke(Network(), plane(), SIZES, flat(eight, True)).network
    check_network(network)
    assert genus(network) == 0
    (node,) = network.nodes.values()
    assert node.valence == 4 and all(node.corner_flags)
    assert node.point == pytest.approx([0, 0, 0], abs=0.01)
    assert len(network.chains) == 2 and not network.patches


def test_an_open_stroke_with_loops_crosses_itself_at_each() -> None:
    t = np.linspace(0, 6 * np.pi, 120)
    curl = np.c_[0.1 * t + np.sin(t), np.cos(t)]
    line = even(curl, step=0.2)
    found = find_self_crossings(line, up(line), False)
    network = insert_stroke(Network(), plane(), SIZES, SurfaceCurve(line, up(line), False)).network
    check_network(network)
    assert genus(network) == 0
    pairs = itertools.combinations(range(len(line) - 1), 2)
    met = [crossing(line[i : i + 2, :2], line[j : j + 2, :2]) for i, j in pairs if j > i + 1]
    expected = sum(p is not None for p in met)
    assert sum(node.valence == 4 for node in network.nodes.values()) == len(found) == expected > 4
    assert sum(node.open for node in network.nodes.values()) == 2


def test_the_two_sides_of_a_thin_sheet_do_not_cross() -> None:
    vertices = np.array(
        [[x, y, z] for z in (0.0, 0.01) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))], float
    )
    surface = Surface.from_arrays(vertices, [[4, 5, 6], [4, 6, 7], [0, 2, 1], [0, 3, 2]]).orient()
    top = even([[-0.5, 0, 0.01], [0.5, 0, 0.01]])
    below = even([[0, -0.5, 0], [0, 0.5, 0]])
    network = insert_stroke(Network(), surface, SIZES, SurfaceCurve(top, up(top), False)).network
    network = insert_stroke(network, surface, SIZES, SurfaceCurve(below, -up(below), False)).network
    check_network(network)
    assert len(network.chains) == 2 and len(network.nodes) == 4
    other = even([[0, -0.5, 0.01], [0, 0.5, 0.01]])
    network = insert_stroke(network, surface, SIZES, SurfaceCurve(other, up(other), False)).network
    assert len(network.chains) == 1 + 4


def test_what_runs_beyond_a_border_is_left_out() -> None:
    network = add_borders(Network(), plane(), 0.02)
    line = even([[4, 0], [6, 0], [6, 1], [4, 1]])
    stroke = SurfaceCurve(line, up(line), False)
    done = insert_stroke(network, plane(), SIZES, stroke, Free(), Free()).network
    check_network(done)
    inner = [chain for chain in done.chains.values() if not chain.marked]
    assert [round(chain.length, 6) for chain in inner] == [1.0, 1.0]
    assert max(chain.points[:, 0].max() for chain in inner) == pytest.approx(5.0)


def test_a_stroke_from_a_corner_to_itself_without_length_is_refused() -> None:
    network = square()
    corner = AtNode(node_at(network, 0, 0))
    with pytest.raises(RefusedError, match="draw it longer"):
        insert_stroke(network, plane(), SIZES, flat([[0, 0], [0.01, 0]]), corner, corner)


def segments(draw: list[tuple[int, int, int, int]]) -> list[Points]:
    return [np.array([[a, b], [c, d]], float) / 97.0 for a, b, c, d in draw]


def crossing(one: Points, two: Points) -> Points | None:
    """Of two segments, by solving for it."""
    a, b = one[1] - one[0], two[0] - two[1]
    matrix = np.array([a, b]).T
    if abs(np.linalg.det(matrix)) < 1e-9:
        return None
    s, t = np.linalg.solve(matrix, two[0] - one[0])
    return one[0] + s * a if 0 < s < 1 and 0 < t < 1 else None


PLACE = st.integers(0, 400)


@settings(max_examples=60)
@given(st.lists(st.tuples(PLACE, PLACE, PLACE, PLACE), min_size=1, max_size=6), st.randoms())
def test_straight_strokes_make_their_arrangement(draw, random) -> None:
    lines = [s for s in segments(draw) if np.linalg.norm(s[1] - s[0]) > 0.5]
    met = [crossing(a, b) for a, b in itertools.combinations(lines, 2)]
    points = [p for p in met if p is not None]
    apart = [*points, *(end for line in lines for end in line)]
    for a, b in itertools.combinations(apart, 2):
        if np.linalg.norm(a - b) < 0.05:
            return  # no general position
    for a, b in itertools.permutations(lines, 2):
        for end in a:
            share = np.clip((end - b[0]) @ (b[1] - b[0]) / ((b[1] - b[0]) @ (b[1] - b[0])), 0, 1)
            if np.linalg.norm(end - b[0] - share * (b[1] - b[0])) < 1.1 * SIZES.snap:
                return  # the one would be joined to the other
    networks: list[Network] = []
    for order in range(2):
        network = Network()
        for line in lines:
            made = insert_stroke(network, plane(), SIZES, flat(line), Free(), Free())
            network = made.network
        check_network(network)
        assert genus(network) == 0
        assert len(network.nodes) == 2 * len(lines) + len(points)
        assert len(network.chains) == len(lines) + 2 * len(points)
        for p in points:
            node = network.nodes[node_at(network, *p)]
            assert node.valence == 4 and all(node.corner_flags)
        networks.append(network)
        if order == 0:
            random.shuffle(lines)
    one, two = networks
    # Whatever the order of the strokes, the same patches.
    assert areas(one) == pytest.approx(areas(two), abs=1e-5)
    assert sum(areas(one)) <= 17.1
    # Mirrored strokes make the mirrored patches.
    mirrored = Network()
    for line in lines:
        mirrored = insert_stroke(
            mirrored, plane(), SIZES, flat(line * [-1, 1]), Free(), Free()
        ).network
    assert areas(mirrored) == pytest.approx(areas(two), abs=1e-5)


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1))
def test_crossings_are_those_of_all_pairs_of_segments(seed: int) -> None:
    rng = np.random.default_rng(seed)
    network = Network()
    loops = [np.c_[rng.uniform(-1, 1, (7, 2)), np.zeros(7)] for _ in range(3)]
    for line in loops:
        network, _ = add_loop(network, line, up(line))
    stroke = np.c_[rng.uniform(-1, 1, (9, 2)), np.zeros(9)]
    found = find_crossings(stroke, up(stroke), True, take_samples(network))
    expected: list[tuple[float, float]] = []
    for i in range(9):
        one = stroke[[i, (i + 1) % 9], :2]
        for line in loops:
            for j in range(7):
                p = crossing(one, line[[j, (j + 1) % 7], :2])
                if p is not None:
                    part = np.linalg.norm(p - one[0]) / np.linalg.norm(one[1] - one[0])
                    expected.append((i + float(part), float(p[0])))
    assert found.along == pytest.approx([s for s, _ in sorted(expected)], abs=1e-4)
    # A closed curve crosses a closed curve as often to the right as to the left.
    for chain in network.chains:
        of = found.chain == chain
        assert found.rightward[of].sum() * 2 == of.sum()


def test_great_circles_of_a_sphere_make_eight_triangles() -> None:
    t = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    flat_ring = np.c_[np.cos(t), np.sin(t), np.zeros(200)]
    tilted = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
    network = Network()
    for axis in range(3):
        ring = np.roll(flat_ring, axis, axis=1) @ tilted
        stroke = clean_stroke(ring, sphere(), SIZES, True)
        network = insert_stroke(network, sphere(), SIZES, stroke).network
        check_network(network)
        assert genus(network) == 0
    assert len(network.nodes) == 6 and len(network.chains) == 12
    assert [len(p.corners) for p in network.patches.values()] == [3] * 8
    total = sum(
        measure_enclosed(*trace_outline(network, p.loop)).area for p in network.patches.values()
    )
    assert total == pytest.approx(8 * math.sqrt(3) * 0.7, rel=0.2)


def test_a_refused_stroke_leaves_the_network_as_it_was() -> None:
    network = square()
    copy = Network(
        dict(network.nodes), dict(network.chains), dict(network.patches), network.next_id
    )
    corner = AtNode(node_at(network, 0, 0))
    with pytest.raises(RefusedError):
        insert_stroke(network, plane(), SIZES, flat([[0, 0], [0.01, 0]]), corner, corner)
    assert are_equal(network, copy)
