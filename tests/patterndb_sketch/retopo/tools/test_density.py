"""The density brush: where it is drawn edges are as long as it asks for."""

from __future__ import annotations

import json
import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from patterndb.geometry.polyline import arc_length
from patterndb_sketch.retopo.editor import Call, Retopology
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.filling.placing import divide_chain, divide_lengths
from patterndb_sketch.retopo.network import EVEN, Chain, Density, Paint
from patterndb_sketch.retopo.network.density import LEAST, MOST
from patterndb_sketch.retopo.session import RETOPO_SESSION, RetopoSession
from patterndb_sketch.retopo.symmetry import Plane, mirror_density, mirror_paint
from patterndb_sketch.retopo.tools.insertloop import find_edge_at
from query.engine import PatternSource
from tests.support.retopo.editors import (
    SIZES,
    chain_at,
    do,
    drawn_grid,
    drawn_octants,
    line,
    same_arrays,
)
from tests.support.retopo.filling import assert_even, assert_welded, counts
from tests.support.retopo.networks import plane, sphere

Z = np.array([[0.0, 0.0, 1.0]])


def dab(
    x: float, y: float, radius: float = 1.0, factor: float = 2.0, *, sets: bool = False
) -> Paint:
    at = np.array([[x, y, 0.0]])
    return Paint(at, at.copy(), Z.copy(), radius, factor, sets)


def density_at(density: Density, *places: tuple[float, float]) -> list[float]:
    points = np.array([[x, y, 0.0] for x, y in places])
    return density.at(points, np.repeat(Z, len(points), axis=0)).tolist()


class TestDensity:
    def test_it_falls_evenly_from_the_line_to_the_radius(self) -> None:
        stroke = Paint(np.array([[0.0, 0.0, 0.0]]), np.array([[2.0, 0.0, 0.0]]), Z.copy(), 0.5, 4.0)
        places = [(0.0, 0.0), (1.3, 0.0), (1.0, 0.25), (1.0, 0.5), (2.5, 0.0), (2.25, 0.0)]
        found = density_at(EVEN.painted(stroke), *places)
        assert found == pytest.approx([4.0, 4.0, 2.0, 1.0, 1.0, 2.0])

    def test_a_later_stroke_is_laid_over_what_is_there(self) -> None:
        twice = EVEN.painted(dab(0, 0)).painted(dab(0, 0))
        assert density_at(twice, (0, 0)) == pytest.approx([4.0])
        coarse = EVEN.painted(dab(0, 0)).painted(dab(0, 0, factor=0.25))
        assert density_at(coarse, (0, 0)) == pytest.approx([0.5])
        even = twice.painted(dab(0, 0, 1.0, 1.0, sets=True))
        half = density_at(twice, (0.5, 0))[0] ** 0.5
        assert density_at(even, (0, 0), (0.5, 0)) == pytest.approx([1.0, half])

    def test_it_stays_within_bounds(self) -> None:
        fine, coarse = EVEN, EVEN
        for _ in range(5):
            fine, coarse = fine.painted(dab(0, 0)), coarse.painted(dab(0, 0, factor=0.5))
        assert density_at(fine, (0, 0)) == pytest.approx([MOST])
        assert density_at(coarse, (0, 0)) == pytest.approx([LEAST])
        # What is over the bound is not kept in store: one stroke back takes effect at once.
        assert density_at(fine.painted(dab(0, 0, factor=0.5)), (0, 0)) == pytest.approx([MOST / 2])

    def test_the_far_side_of_a_sheet_is_not_painted(self) -> None:
        density = EVEN.painted(dab(0, 0))
        assert density.at(np.zeros((1, 3)), -Z).tolist() == [1.0]

    def test_a_line_is_measured_by_the_integral_over_it(self) -> None:
        # Along a line through the middle of a dab, also one of two points.
        density = EVEN.painted(dab(0, 0, 0.8, 3.0))
        t = np.linspace(-2.0, 2.0, 200_001)
        r = np.minimum(abs(t) / 0.8, 1.0)
        value = 3.0 ** (1.0 - r * r * (3.0 - 2.0 * r))
        wanted = float((0.5 * (value[1:] + value[:-1]) * np.diff(t)).sum())
        for n in (2, 3, 40, 801):
            x = np.linspace(-2.0, 2.0, n)
            points = np.stack([x, 0 * x, 0 * x], axis=1)
            lengths, measured = density.measure(points, np.repeat(Z, n, axis=0))
            assert lengths[-1] == pytest.approx(4.0)
            assert measured[-1] == pytest.approx(wanted, rel=0.01)
            assert (np.diff(measured) > 0.0).all()

    def test_where_nothing_is_painted_lengths_are_the_lines_own(self) -> None:
        points = np.random.default_rng(1).random((30, 3))
        up = np.repeat(Z, 30, axis=0)
        for density in (EVEN, EVEN.painted(dab(50, 50))):
            lengths, measured = density.measure(points, up)
            assert measured is lengths
            assert same_arrays(lengths, arc_length(points))

    def test_densities_compare_by_what_was_painted(self) -> None:
        assert EVEN.painted(dab(0, 0)) == EVEN.painted(dab(0, 0))
        assert EVEN.painted(dab(0, 0)) != EVEN.painted(dab(0, 1))
        assert EVEN.painted(dab(0, 0)) != EVEN
        assert hash(dab(0, 0)) == hash(dab(0, 0))


class TestDivision:
    def test_all_edges_of_a_chain_are_as_long_by_density(self, source: PatternSource) -> None:
        network = drawn_grid(source, 1).fill().network
        chain = network.chains[chain_at(network, 0.5, 0.0)]
        density = EVEN.painted(dab(0, 0, 0.7, 4.0))
        ends = divide_lengths(chain, density)
        lengths, measured = density.measure(chain.round, chain.round_normals)
        steps = np.diff(np.interp(ends, lengths, measured))
        assert len(ends) == chain.count + 1
        assert steps == pytest.approx(np.full(chain.count, measured[-1] / chain.count))
        points, normals = divide_chain(chain, density)
        assert same_arrays(points[[0, -1]], chain.points[[0, -1]])
        assert same_arrays(normals[[0, -1]], chain.normals[[0, -1]])

    @given(st.floats(0.0, 1.0))
    def test_an_edge_is_found_where_it_lies(self, share: float) -> None:
        x = np.linspace(0.0, 3.0, 31)
        points = np.stack([x, 0 * x, 0 * x], axis=1)
        chain = Chain(0, 1, 2, points, np.repeat(Z, 31, axis=0), 7)
        for density in (EVEN, EVEN.painted(dab(0, 0, 1.5, 5.0))):
            ends = divide_lengths(chain, density)
            found = find_edge_at(chain, 30.0 * share, density)
            assert ends[found] - 1e-9 <= 3.0 * share <= ends[found + 1] + 1e-9


class TestTool:
    def test_counts_follow_and_an_even_brush_has_them_back(self, source: PatternSource) -> None:
        editor = drawn_grid(source)
        before = counts(editor.fill().network)
        do(editor, "density", at=[1.5, 1.5, 0.0], radius=1.5, times=2)
        after = counts(editor.fill().network)
        near = chain_at(editor.network, 1.0, 1.5)
        far = chain_at(editor.network, 0.0, 0.5)
        assert after[near] > before[near]
        assert after[near] > after[far] >= before[far]
        assert_even(editor.network)
        do(editor, "density", at=[1.5, 1.5, 0.0], radius=40.0, how="even")
        assert counts(editor.fill().network) == before
        do(editor, "density", anew=True)
        assert editor.network.density == EVEN
        assert counts(editor.fill().network) == before

    def test_vertices_on_curves_gather_under_the_brush(self, source: PatternSource) -> None:
        editor = drawn_grid(source)
        do(editor, "density", at=[0.0, 0.0, 0.0], radius=1.0, times=4)
        found = editor.fill()
        chain = found.network.chains[chain_at(found.network, 0.5, 0.0)]
        points, _ = divide_chain(chain, found.network.density)
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        if np.linalg.norm(points[0]) > 0.5:
            steps = steps[::-1]
        assert (np.diff(steps) > 0.0).all()
        mesh = editor.mesh(found)
        assert_welded(found, mesh)
        for point in points:
            assert np.linalg.norm(mesh.vertices - point, axis=1).min() < 1e-9

    def test_a_stroke_is_kept_by_as_few_points_as_its_radius_asks_for(
        self, source: PatternSource
    ) -> None:
        editor = drawn_grid(source)
        do(editor, "density", points=line((0.2, 0.5), (2.8, 0.5)), radius=0.4)
        (stroke,) = editor.network.density.strokes
        assert len(stroke.starts) <= math.ceil(2.6 / (0.125 * 0.4)) + 1
        assert stroke.ends[-1] == pytest.approx([2.8, 0.5, 0.0], abs=1e-6)
        assert np.array_equal(stroke.ends[:-1], stroke.starts[1:])

    def test_pinned_counts_stay_and_that_is_told(self, source: PatternSource) -> None:
        editor = drawn_grid(source, 1)
        for at in ((0.5, 0.0), (1.0, 0.5), (0.5, 1.0), (0.0, 0.5)):
            do(editor, "subdivide", at=[*at, 0.0], count=4)
        before = counts(editor.fill().network)
        told = do(editor, "density", at=[0.5, 0.5, 0.0], radius=3.0)
        assert any("pinned" in note for note in told.notes)
        assert counts(editor.fill().network) == before

    def test_patches_with_a_fill_of_the_users_stay_unless_painted(
        self, source: PatternSource
    ) -> None:
        editor = drawn_grid(source)
        editor.fill()
        do(editor, "choose", at=[2.5, 2.5, 0.0], number=1)
        before = editor.fill().network
        do(editor, "density", at=[0.5, 0.5, 0.0], radius=0.9, times=4)
        after = editor.fill().network
        outer = (chain_at(after, 3.0, 2.5), chain_at(after, 2.5, 3.0))
        assert all(after.chains[c].count == before.chains[c].count for c in outer)
        assert counts(after) != counts(before)

    def test_vertices_moved_by_hand_are_let_go_where_borders_are_divided_anew(
        self, source: PatternSource
    ) -> None:
        editor = drawn_grid(source)
        editor.fill()
        do(editor, "brush", at=[0.5, 0.5, 0.0], to=[0.55, 0.5, 0.0], radius=0.4)
        do(editor, "brush", at=[2.5, 2.5, 0.0], to=[2.55, 2.5, 0.0], radius=0.4)
        held = {p.id for p in editor.network.patches.values() if p.choice and p.choice.moved[0]}
        assert len(held) == 2
        do(editor, "density", at=[0.5, 0.5, 0.0], radius=0.7, times=1.05)
        kept = {p.id for p in editor.network.patches.values() if p.choice and p.choice.moved[0]}
        assert len(kept & held) == 1

    def test_what_is_painted_before_curves_are_there_is_heeded(self, source: PatternSource) -> None:
        first, then = Retopology(plane(), source, SIZES), Retopology(plane(), source, SIZES)
        brush = {"at": [0.5, 0.5, 0.0], "radius": 1.0, "times": 3}
        do(first, "density", **brush)
        for editor in (first, then):
            corners = [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)]
            for a, b in pairwise(corners):
                do(editor, "stroke", points=line(a, b))
        told = do(then, "density", **brush)
        assert told.notes == ()
        assert counts(first.fill().network) == counts(then.fill().network)
        assert {n for n in counts(first.network).values() if n} == {6}

    def test_undo_and_redo_are_exact(self, source: PatternSource) -> None:
        editor = drawn_grid(source)
        editor.fill()
        states = [editor.state]
        for x in (0.5, 1.5):
            do(editor, "density", at=[x, 0.5, 0.0], radius=0.6)
            editor.fill()
            states.append(editor.state)
        for state in states[-2::-1]:
            do(editor, "undo")
            assert editor.state.same(state)
        for state in states[1:]:
            do(editor, "redo")
            assert editor.state.same(state)
        assert not states[1].same(states[2])

    @pytest.mark.parametrize(
        ("arguments", "said"),
        [
            ({}, "one of points and at"),
            ({"at": [0, 0, 0], "points": line((0, 0), (1, 0))}, "one of points and at"),
            ({"at": [0, 0, 0], "how": "denser"}, '"finer"'),
            ({"at": [0, 0, 0], "times": 9}, "from 1 to 8"),
            ({"at": [900.0, 0, 0]}, "far from the surface"),
            ({"at": [0, 0, 0], "radius": 1e-9}, "radius"),
        ],
    )
    def test_what_makes_no_sense_is_refused_with_what_would(
        self, source: PatternSource, arguments: dict[str, object], said: str
    ) -> None:
        editor = drawn_grid(source, 1)
        with pytest.raises(InvalidRetopoError, match=said):
            editor.do(Call("density", arguments))


class TestSymmetry:
    def test_both_sides_of_the_plane_are_painted_once(self) -> None:
        plane_x = Plane()
        density = mirror_density(EVEN.painted(dab(0.3, 0.0)), plane_x)
        left = density_at(density, (-0.3, 0.0), (-0.1, 0.2), (0.0, 0.0))
        right = density_at(density, (0.3, 0.0), (0.1, 0.2), (0.0, 0.0))
        assert left == pytest.approx(right)
        # Where both overlap it is the nearer one alone.
        assert right[2] == pytest.approx(density_at(EVEN.painted(dab(0.3, 0.0)), (0.0, 0.0))[0])

    @given(
        st.lists(st.tuples(st.floats(-2, 2), st.floats(-2, 2)), min_size=2, max_size=5),
        st.floats(0, 6),
    )
    def test_an_image_of_what_is_symmetric_adds_nothing(
        self, places: list[tuple[float, float]], angle: float
    ) -> None:
        points = np.array([[x, y, 0.0] for x, y in places])
        up = np.repeat(Z, len(points) - 1, axis=0)
        stroke = Paint(points[:-1].copy(), points[1:].copy(), up, 0.5, 2.0)
        plane = Plane.of([0.1, 0.0, 0.0], [math.cos(angle), math.sin(angle), 0.0])
        once = mirror_paint(stroke, plane)
        assert mirror_paint(once, plane) == once

    def test_while_it_is_on_and_after(self, source: PatternSource) -> None:
        editor = drawn_octants(source)
        # On the side that goes: its image is on the one that stays.
        do(editor, "density", at=[-0.9, 0.3, 0.3], radius=0.5, times=3)
        do(editor, "symmetry", on=True, axis="x")
        do(editor, "density", at=[-0.9, -0.3, 0.3], radius=0.5, times=3)
        found = editor.fill()
        mesh = editor.mesh(found)
        image = mesh.vertices * [-1.0, 1.0, 1.0]
        away = np.linalg.norm(image[:, None] - mesh.vertices, axis=2).min(axis=1)
        assert away.max() < 1e-9
        within = len(mesh.quads)
        do(editor, "symmetry", on=False)
        assert len(editor.mesh(editor.fill()).quads) == within
        assert all(len(one.starts) == 2 for one in editor.network.density.strokes)
        points, up = mesh.vertices, mesh.vertices
        value = editor.network.density.at(points, up)
        assert value == pytest.approx(editor.network.density.at(image, image))
        assert value.max() > 2.0


class TestSessions:
    def session(self, source: PatternSource) -> RetopoSession:
        editor = drawn_octants(source)
        do(editor, "density", at=[1.0, 0.1, 0.1], radius=0.5, times=3)
        do(editor, "density", points=[[1, 0.1, 0.1], [0.8, 0.6, 0.1]], radius=0.2, how="even")
        editor.fill()
        return RetopoSession(editor.surface, editor.state, "ball.obj")

    def test_density_is_kept_bit_for_bit(self, source: PatternSource) -> None:
        session = self.session(source)
        data = RETOPO_SESSION.encode(session)
        found = RETOPO_SESSION.decode(data)
        assert found.state.same(session.state)
        assert RETOPO_SESSION.encode(found) == data

    def test_without_paint_a_session_has_no_strokes_of_brushes(self, source: PatternSource) -> None:
        editor = Retopology(sphere(), source)
        data = RETOPO_SESSION.encode(RetopoSession(editor.surface, editor.state, "ball.obj"))
        density = json.loads(data)["content"]["network"]["density"]
        assert density == {"strokes": []}

    @pytest.mark.parametrize(
        ("old", "new", "said"),
        [
            (b'"radius":0.5', b'"radius":0.0', "radius"),
            (b'"factor":3.0', b'"factor":99.0', "0.125 to 8"),
            (b'"sets":false', b'"sets":3', "sets"),
            (b'"starts":[[', b'"starts":[[7,', "starts"),
        ],
    )
    def test_brush_strokes_that_are_none_are_refused_by_name(
        self, source: PatternSource, old: bytes, new: bytes, said: str
    ) -> None:
        data = replaced(RETOPO_SESSION.encode(self.session(source)), old, new)
        with pytest.raises(InvalidRetopoError, match=said):
            RETOPO_SESSION.decode(data)


def replaced(data: bytes, old: bytes, new: bytes) -> bytes:
    """Return a session with something else once in its document."""
    assert old in data
    return data.replace(old, new, 1)


@pytest.mark.parametrize("count", (3, 2_000))
def test_a_long_stroke_is_as_strong_as_the_strongest_of_its_segments(count: int) -> None:
    rng = np.random.default_rng(count)
    way = np.cumsum(rng.normal(size=(61, 3)) * 0.05, axis=0)
    normals = rng.normal(size=(60, 3))
    whole = Paint(way[:-1].copy(), way[1:].copy(), normals, 0.1, 2.0)
    points, up = way[rng.integers(61, size=count)], rng.normal(size=(count, 3))
    points = points + rng.normal(size=(count, 3)) * 0.05
    alone = [
        Paint(way[k : k + 1].copy(), way[k + 1 : k + 2].copy(), normals[k : k + 1].copy(),
                    0.1, 2.0).weigh(points, up)
        for k in range(60)
    ]  # fmt: skip
    found = whole.weigh(points, up)
    assert np.array_equal(found, np.max(alone, axis=0)) and 0.0 < found.max() <= 1.0
