"""Curves that cross or end between the samples of others are joined, and nothing else is."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.spatial import KDTree

from patterndb.geometry.points import Points
from patterndb_sketch.curvenetwork.crossings import join_smooth_crossings
from patterndb_sketch.curvenetwork.drawing import find_loose_ends
from patterndb_sketch.curvenetwork.joining import join_polylines
from patterndb_sketch.curvenetwork.polylines import pack_curves
from patterndb_sketch.curvenetwork.smoothcurves import guess_curves
from patterndb_sketch.curvenetwork.survey import find_settled_curves
from patterndb_sketch.surfacing import find_cycles

SEEDS = st.integers(0, 2**32 - 1)


def height(x: Points, y: Points) -> Points:
    return 0.3 * np.sin(1.3 * x) * np.cos(y)


def grid_on_a_wave(
    chance: np.random.Generator, columns: int, rows: int
) -> tuple[list[Points], Points]:
    """Curves x = i and y = j on a wave, each sampled at places of its own, and the crossings."""
    drawn: list[Points] = []
    for j in range(rows + 1):
        x = uneven(chance, columns)
        drawn.append(
            np.stack([x, np.full(len(x), float(j)), height(x, np.full(len(x), j))], axis=1)
        )
    for i in range(columns + 1):
        y = uneven(chance, rows)
        drawn.append(
            np.stack([np.full(len(y), float(i)), y, height(np.full(len(y), i), y)], axis=1)
        )
    i, j = (a.ravel().astype(float) for a in np.mgrid[: columns + 1, : rows + 1])
    return drawn, np.stack([i, j, height(i, j)], axis=1)


def uneven(chance: np.random.Generator, length: int) -> Points:
    """Ascending numbers from 0 to a length, 8 to 16 to the unit, no two gaps alike."""
    gaps = chance.uniform(0.7, 1.0, int(chance.integers(8, 17)) * length)
    return np.r_[0.0, np.cumsum(gaps) / gaps.sum() * length]


def turn_and_mix(drawn: list[Points], chance: np.random.Generator) -> list[Points]:
    order = chance.permutation(len(drawn))
    return [np.ascontiguousarray(drawn[k][:: chance.choice([-1, 1])]) for k in order]


def circle(normal: int, start: float, n: int) -> Points:
    turn = start + 2 * np.pi * np.arange(n + 1) / n
    points = np.zeros((n + 1, 3))
    points[:, (normal + 1) % 3], points[:, (normal + 2) % 3] = np.cos(turn), np.sin(turn)
    points[-1] = points[0]
    return points


class TestJoined:
    @settings(deadline=None, max_examples=30)
    @given(SEEDS)
    def test_a_grid_on_a_wave(self, seed: int) -> None:
        chance = np.random.default_rng(seed)
        columns, rows = (int(n) for n in chance.integers(1, 5, 2))
        drawn, crossings = grid_on_a_wave(chance, columns, rows)
        result = join_polylines(drawn)
        network = result.network
        assert len(network.nodes) == len(crossings)
        gaps, which = KDTree(crossings).query(network.nodes)
        assert len(set(np.asarray(which).tolist())) == len(crossings)
        assert np.max(gaps) < 2e-3
        assert len(network.curves) == columns * (rows + 1) + rows * (columns + 1)
        assert result.notes == ()

    @settings(deadline=None, max_examples=15)
    @given(SEEDS)
    def test_order_and_senses_change_nothing(self, seed: int) -> None:
        chance = np.random.default_rng(seed)
        drawn, _ = grid_on_a_wave(chance, 3, 2)
        one, other = join_polylines(drawn), join_polylines(turn_and_mix(drawn, chance))
        assert sorted(map(tuple, one.network.nodes)) == sorted(map(tuple, other.network.nodes))

    @settings(deadline=None, max_examples=15)
    @given(SEEDS)
    def test_great_circles_make_eight_patches(self, seed: int) -> None:
        chance = np.random.default_rng(seed)
        circles = [
            circle(k, float(chance.uniform(0, 6)), int(chance.integers(24, 90))) for k in range(3)
        ]
        network = join_polylines(circles).network
        assert len(network.nodes) == 6
        assert len(network.curves) == 12
        found = find_cycles(network)
        assert sorted(len(cycle.curves) for cycle in found.cycles) == [3] * 8
        assert not found.once

    @settings(deadline=None, max_examples=15)
    @given(SEEDS)
    def test_ends_on_an_arc(self, seed: int) -> None:
        chance = np.random.default_rng(seed)
        at = np.sort(chance.uniform(0, 2 * np.pi, 3))
        rails = [np.array([[np.cos(t), np.sin(t), 0.0], [np.cos(t), np.sin(t), 2.0]]) for t in at]
        rings = [circle(2, float(chance.uniform(0, 6)), 40) for _ in range(2)]
        rings[1] = rings[1] + [0.0, 0.0, 2.0]
        network = join_polylines([*rings, *rails]).network
        ends = np.concatenate(rails)
        if min(np.diff(np.r_[at, at[0] + 2 * np.pi])) > 0.05:
            assert len(network.nodes) == 6
            # Rails stay, up to what meets exactly anyway: rings come to them.
            assert np.max(KDTree(network.nodes).query(ends)[0]) <= 4e-6


class TestLeftAlone:
    def test_straight_lines(self) -> None:
        lines = [np.array([[0.0, 0, 0], [1, 0, 0]]), np.array([[0.5, -1, 1e-3], [0.5, 1, 1e-3]])]
        packed = pack_curves(lines)
        settled, put = find_settled_curves(packed, 1e-6)
        joined = join_smooth_crossings(packed, settled, put, 1e-6)
        assert all(map(np.array_equal, joined, lines))
        assert len(join_polylines(lines, tolerance=0.0).network.curves) == 2

    @settings(deadline=None, max_examples=30)
    @given(SEEDS, st.floats(0.4, 3.0))
    def test_curves_that_pass_farther_off_than_their_guess(self, seed: int, times: float) -> None:
        chance = np.random.default_rng(seed)
        rings = [circle(k, float(chance.uniform(0, 6)), 60) for k in range(2)]
        # The second one, larger, passes the first at its poles by so many sagittas.
        sagitta = float(guess_curves(pack_curves(rings[:1])).sagitta.max())
        rings[1] = rings[1] * (1 + times * sagitta)
        assert len(join_polylines(rings, tolerance=0.0).network.curves) == 2


class TestGuesses:
    @settings(deadline=None, max_examples=30)
    @given(SEEDS)
    def test_guesses_pass_the_samples_and_keep_to_an_arc(self, seed: int) -> None:
        chance = np.random.default_rng(seed)
        line = circle(2, float(chance.uniform(0, 6)), int(chance.integers(20, 90)))
        curves = guess_curves(pack_curves([line]))
        edges = np.arange(len(line) - 1)
        for share, end in ((0.0, line[:-1]), (1.0, line[1:])):
            at, _ = curves.locate(edges, np.full(len(edges), share))
            assert np.abs(at - end).max() < 1e-12
        shares = chance.uniform(0, 1, len(edges))
        at, slope = curves.locate(edges, shares)
        off = np.abs(np.linalg.norm(at, axis=1) - 1.0)
        assert (off <= curves.fit[edges]).all()
        ahead, _ = curves.locate(edges, shares + 1e-6)
        assert np.abs((ahead - at) / 1e-6 - slope).max() < 1e-4


class TestLooseEnds:
    @settings(deadline=None, max_examples=30)
    @given(SEEDS)
    def test_the_tolerance_told_joins_them(self, seed: int) -> None:
        chance = np.random.default_rng(seed)
        drawn, crossings = grid_on_a_wave(chance, 3, 2)
        short = [line.copy() for line in drawn]
        for line in short[4:6]:
            line[[0, -1]] = 0.5 * (line[[0, -1]] + line[[1, -2]])
        found = join_polylines(short)
        assert len(found.loose) == 4
        assert [one.gap for one in found.loose] == sorted(
            (one.gap for one in found.loose), reverse=True
        )
        tolerance = float(found.notes[-1].split("a tolerance of ")[1].split(" ")[0])
        assert found.loose[0].gap <= tolerance <= 1.1 * found.loose[0].gap + 1e-9
        mended = join_polylines(short, tolerance=tolerance)
        assert mended.loose == ()
        assert len(mended.network.nodes) == len(crossings)

    @settings(deadline=None, max_examples=30)
    @given(SEEDS)
    @example(353)
    def test_gaps_are_the_distances(self, seed: int) -> None:
        chance = np.random.default_rng(seed)
        drawn = [chance.uniform(0, 1, (int(chance.integers(2, 5)), 3)) for _ in range(8)]
        network = join_polylines(drawn, tolerance=1e-9).network
        found = {tuple(one.place): one for one in find_loose_ends(network)}
        dense = [
            np.concatenate([np.linspace(a, b, 400) for a, b in pairwise(p)])
            for p in (curve.points for curve in network.curves)
        ]
        degree = np.bincount([node for curve in network.curves for node in curve.nodes])
        for number, curve in enumerate(network.curves):
            for end in (0, -1):
                if degree[curve.nodes[end]] > 1:
                    # Curves drawn at random met there.
                    assert tuple(curve.points[end]) not in found
                    continue
                others = np.concatenate([d for k, d in enumerate(dense) if k != number])
                nearest = np.linalg.norm(others - curve.points[end], axis=1).min()
                one = found.get(tuple(curve.points[end]))
                if one is None:
                    assert nearest > 0.1 * curve.length - 1e-9
                else:
                    assert one.gap <= nearest + 1e-9


def test_steps_too_short_to_have_a_direction_are_no_bends() -> None:
    """Points that differ by less than what can be squared are samples as others are."""
    bent = [[0.0, 0.0, 0.0], [1e-200, 0.0, 0.0], [2e-200, 0.0, 0.0], [1.0, 0.1, 0.0], [2.0, 0, 0]]
    with np.errstate(divide="raise", invalid="raise", over="raise"):
        curves = guess_curves(pack_curves([np.array(bent)]))
    assert all(np.isfinite(part).all() for part in (curves.bends, curves.after, curves.sagitta))
