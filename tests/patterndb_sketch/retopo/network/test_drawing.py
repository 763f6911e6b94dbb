"""The network stays a drawing on its surface, whatever is drawn: Euler's formula, after each
stroke.

Strokes along others and back along themselves, several through one place, over open ends, over
chains that lie on each other; and on a surface with a handle.
"""

from __future__ import annotations

import itertools
from contextlib import suppress

import numpy as np
import pytest
import trimesh
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike

from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network import (
    AtNode,
    Free,
    Network,
    NetworkBuilder,
    add_chain,
    add_loop,
    are_equal,
    check_network,
    count_genus,
    count_handles,
)
from patterndb_sketch.retopo.network.crossings import FaceStep, find_first_order
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tools.erase import erase_chains
from patterndb_sketch.retopo.tools.stroke import DOUBLED, insert_stroke
from patterndb_sketch.retopo.tracing import SurfaceCurve, clean_stroke
from tests.support.retopo.networks import SIZES, drawn, even, flat, genus, node_at, plane, up


def sound(network: Network) -> None:
    check_network(network)
    assert genus(network) == count_genus(network.nodes, network.chains) == 0


def after(network: Network, *points: ArrayLike) -> Network:
    for line in points:
        network = insert_stroke(network, plane(), SIZES, flat(line)).network
        sound(network)
    return network


def nearest(network: Network, point: np.ndarray) -> int:
    """The node nearest to a place of the plane; loose ends next to a crossing are left out."""
    away = {n.id: float(np.linalg.norm(n.point[:2] - point)) for n in network.nodes.values()}
    node = min(away, key=away.__getitem__)
    assert away[node] < 0.01
    return node


def along(points: np.ndarray, begin: np.ndarray, end: np.ndarray) -> bool:
    """Do points (n, 2) lie next to the line from a place to another?"""
    step = (end - begin) / np.linalg.norm(end - begin)
    return bool(np.abs((points - begin) @ [-step[1], step[0]]).max() < 1.2 * SIZES.snap)


def torus() -> Surface:
    return Surface.of(
        trimesh.creation.torus(1.0, 0.4, major_sections=48, minor_sections=24)
    ).orient()


def test_handles_are_those_of_the_classification_of_surfaces() -> None:
    ring, ball = torus(), trimesh.creation.icosphere(subdivisions=2)
    assert count_handles(ring) == 1
    assert count_handles(Surface.of(ball).orient()) == count_handles(plane()) == 0
    # Holes in it change nothing, and parts add.
    assert count_handles(Surface.from_arrays(ring.vertices, ring.triangles[40:]).orient()) == 1
    both = np.concatenate([ring.vertices, ring.vertices + 5.0, ball.vertices - 5.0])
    n = len(ring.vertices)
    triangles = np.concatenate([ring.triangles, ring.triangles + n, ball.faces + 2 * n])
    assert count_handles(Surface.from_arrays(both, triangles).orient()) == 2
    # Two balls that touch in a vertex.
    touching = np.concatenate([ball.vertices, 2.0 * ball.vertices[:1] - ball.vertices])
    m = len(ball.vertices)
    turned = np.concatenate([ball.faces, ball.faces[:, ::-1] + m])
    assert count_handles(Surface.from_arrays(touching, turned).orient()) == 0


def test_a_curve_may_go_round_a_handle_of_the_surface() -> None:
    ring = torus()
    sizes = Sizes.of(ring.diagonal)
    turn = np.linspace(0.0, 2.0 * np.pi, 80, endpoint=False)
    short = np.c_[1.0 + 0.4 * np.cos(turn), np.zeros(80), 0.4 * np.sin(turn)]
    long = np.c_[1.4 * np.cos(turn), 1.4 * np.sin(turn), np.zeros(80)]
    network = Network()
    for line, goes_round in ((short, 0), (long, 1)):
        network = insert_stroke(network, ring, sizes, clean_stroke(line, ring, sizes, True)).network
        check_network(network)
        assert genus(network) == goes_round
    (node,) = network.nodes.values()
    assert node.valence == 4 and len(network.chains) == 2


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.booleans())
@example(276, True)
def test_a_stroke_along_a_curve_is_that_curve(seed: int, backwards: bool) -> None:
    rng = np.random.default_rng(seed)
    t = np.linspace(-1.0, 1.0, 30)
    line = np.c_[t, 0.3 * np.sin(3.0 * t)]
    before = after(Network(), line)
    # To and fro across it, and not over itself.
    aside = 0.5 * DOUBLED * SIZES.snap
    again = line + np.c_[np.zeros(30), rng.uniform(-aside, aside, 30)]
    with pytest.raises(RefusedError, match="lies on a curve that is there"):
        insert_stroke(before, plane(), SIZES, flat(again[::-1] if backwards else again))
    # What goes on beyond its end continues it: nothing is there twice.
    longer = np.r_[again, [[1.5, 0.4], [2.0, 0.0]]]
    done = after(before, longer[::-1] if backwards else longer)
    whole = even(np.r_[line, [[1.5, 0.4], [2.0, 0.0]]])
    length = float(np.linalg.norm(np.diff(whole, axis=0), axis=1).sum())
    assert sum(chain.length for chain in done.chains.values()) == pytest.approx(length, rel=0.1)


@pytest.mark.parametrize("times", [2, 3, 4])
@pytest.mark.parametrize("aside", [0.0, 0.03])
def test_a_stroke_there_and_back_is_one_curve(times: int, aside: float) -> None:
    ends = [[0.0, k * aside] if k % 2 == 0 else [1.0, k * aside] for k in range(times + 1)]
    line = even(ends)
    stroke = clean_stroke(line, plane(), SIZES, False)
    network = insert_stroke(Network(), plane(), SIZES, stroke).network
    sound(network)
    network = after(network, [[0.5, -0.5], [0.5, 0.5]])
    assert len([n for n in network.nodes.values() if n.point[0] < 0.2]) <= 2


@settings(max_examples=40)
@given(st.lists(st.tuples(st.floats(0, np.pi), st.floats(-1, 1)), min_size=2, max_size=5))
def test_lines_next_to_one_place_meet_soundly(lines: list[tuple[float, float]]) -> None:
    network = Network()
    for angle, aside in lines:
        along = np.array([np.cos(angle), np.sin(angle)])
        across = np.array([-along[1], along[0]]) * aside * 0.005
        with suppress(RefusedError):  # it may lie on another
            network = after(network, [across - along, across + along])


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1))
def test_strokes_over_chains_that_lie_on_each_other_stay_whole(seed: int) -> None:
    rng = np.random.default_rng(seed)
    network = Network()
    # Some chains exactly, and some nearly, in one place, without a node: as after pulling.
    for _ in range(int(rng.integers(2, 5))):
        line = even([[-1.0, 0.0], [0.0, float(rng.choice([0.0, 1e-9, 0.004]))], [1.0, 0.0]])
        network, _ = add_chain(network, line, up(line))
    t = np.linspace(0.0, 2.0 * np.pi, 90, endpoint=False)
    for _ in range(2):
        ring = np.c_[0.5 * np.cos(t), 0.5 * np.sin(t), np.zeros(90)]
        network, _ = add_loop(network, ring, up(ring))
    for _ in range(3):
        begin, end = np.add(rng.uniform(-1, 1, (2, 2)), [[0.0, 1.5], [0.0, -1.5]])
        stroke = flat([begin, end])
        try:
            made = insert_stroke(network, plane(), SIZES, stroke, Free(), Free())
        except RefusedError:
            continue
        sound(made.network)
        # From its start to its end along its own chains, and those that it lies on.
        line = made.network.chains.values()
        ends = {tuple(p): nearest(made.network, p) for p in (begin, end)}
        reached = {ends[tuple(begin)]}
        for _ in line:
            for chain in line:
                own = along(chain.points[:, :2], begin, end)
                if (own or chain.length < 0.05) and {chain.start, chain.end} & reached:
                    reached |= {chain.start, chain.end}
        assert ends[tuple(end)] in reached
        network = made.network


@given(
    st.lists(
        st.tuples(st.floats(0, 3), st.integers(0, 1), st.integers(0, 2), st.integers(0, 2)),
        min_size=1,
        max_size=6,
    ),
    st.floats(0, 2),
)
def test_the_order_of_crossings_is_the_first_in_which_faces_follow(drawn_steps, near) -> None:
    drawn_steps = sorted(drawn_steps, key=lambda step: step[0])
    along = np.array([s[0] for s in drawn_steps])
    steps = [FaceStep(part, before, beyond) for _, part, before, beyond in drawn_steps]

    def follow(order: tuple[int, ...]) -> bool:
        at: dict[int, int] = {}
        for k, i in enumerate(order):
            # No further ahead than is near the first that is left.
            if along[i] > min(along[j] for j in order[k:]) + near:
                return False
            if at.get(steps[i].part, steps[i].before) != steps[i].before:
                return False
            at[steps[i].part] = steps[i].after
        return True

    orders = itertools.permutations(range(len(steps)))  # in lexicographic order
    expected = next(filter(follow, orders), tuple(range(len(steps))))
    assert tuple(find_first_order(steps, along, near)) == expected


@settings(max_examples=40)
@given(st.floats(-0.099, 0.099), st.floats(-0.5, 0.5), st.booleans())
def test_an_open_end_that_a_stroke_passes_is_joined(gap: float, x: float, closed: bool) -> None:
    # From below, short of the stroke or beyond it by the gap.
    stem = [[x, -0.8], [x, -gap]]
    if closed:
        line = [[-1.0, 0.0], [1.0, 0.0], [1.0, 1.0], [-1.0, 1.0]]
        network = after(Network(), stem)
        network = insert_stroke(network, plane(), SIZES, flat(line, True)).network
        sound(network)
    else:
        network = after(Network(), stem, [[-1.0, 0.0], [1.0, 0.0]])
    node = network.nodes[node_at(network, x, 0.0)]
    assert node.valence == 3 and node.cut
    # A T-junction, straight on the far side.
    half = node.ends[node.corner_flags.index(False)]
    line = network.chains[half >> 1].directed(half)[0]
    assert sum(node.corner_flags) == 2 and line[1][0] > x - 1e-9
    (left,) = [c for c in network.chains.values() if c.points[:, 1].min() < -0.5]
    assert left.points[:, 1].max() == pytest.approx(0.0, abs=1e-9)
    # Without the stem the stroke is one curve again.
    done = erase_chains(network, [left.id]).network
    sound(done)
    assert len(done.chains) == 1


def test_an_open_end_further_off_is_left_alone() -> None:
    network = after(Network(), [[0.0, -0.8], [0.0, -0.11]], [[-1.0, 0.0], [1.0, 0.0]])
    assert len(network.chains) == 2 and len(network.nodes) == 4
    # ... and so is one with a curve between, and what the stroke's own ends are near to.
    network = drawn([[-0.5, -0.04], [0.5, -0.04]], [[0.0, -0.8], [0.0, -0.04]])
    crossed = after(network, [[-1.0, 0.0], [1.0, 0.01]])
    assert crossed.nodes[node_at(crossed, 0.0, -0.04)].valence == 3


def test_what_would_pass_through_a_curve_is_refused() -> None:
    ring = even([[0, 0], [1, 0], [1, 1], [0, 1]], closed=True)
    network = Network(surface=plane())
    builder = NetworkBuilder(network)
    chain = builder.add_loop(ring, up(ring))
    node = builder.cut_chain(chain, 0.0)
    inside, outside = even([[0, 0], [0.5, 0.5]]), even([[0, 0], [-0.5, -0.5]])
    one = builder.add_chain(inside, up(inside), AtNode(node))
    two = builder.add_chain(outside, up(outside), AtNode(node))
    kept = builder.finish()
    sound(kept)
    ends = [kept.chains[c].end for c in (one, two)]
    through = even([[0.5, 0.5], [1.5, 0.5], [1.5, -0.5], [-0.5, -0.5]])
    with pytest.raises(RefusedError, match="pass through"):
        NetworkBuilder(kept).add_chain(through, up(through), AtNode(ends[0]), AtNode(ends[1]))
    # As a stroke it crosses the ring.
    stroke = SurfaceCurve(through, up(through), False)
    made = insert_stroke(kept, plane(), SIZES, stroke, AtNode(ends[0]), AtNode(ends[1])).network
    sound(made)
    assert not are_equal(made, kept)
