"""Ends of chords bound the turning, and every candidate is what it must be."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb_sketch.curvenetwork.network import InvalidNetworkError
from patterndb_sketch.surfacing.chords import (
    HUGGING,
    NEAR_EDGES,
    NEAR_SHARE,
    find_candidates,
    find_endpoints,
)
from patterndb_sketch.surfacing.sampling import Loop
from tests.support.surfacing.chords import SHAPES, ring, strip

SLACK = 1e-6


def vertex_angles(points: np.ndarray) -> np.ndarray:
    """Turning angle at every vertex, by the arc cosine."""
    steps = np.roll(points, -1, axis=0) - points
    steps /= np.linalg.norm(steps, axis=1)[:, None]
    return np.arccos(np.clip((steps * np.roll(steps, 1, axis=0)).sum(axis=1), -1, 1))


def off_normal_plane(loop: Loop, e: int, p: int) -> float:
    """Degrees between the chord from e to p and the normal plane at e, the least of those for
    the tangents that count there."""
    points, n = loop.points, len(loop.points)
    chord = (points[p] - points[e]) / np.linalg.norm(points[p] - points[e])
    incoming = points[e] - points[e - 1]
    outgoing = points[(e + 1) % n] - points[e]
    incoming /= np.linalg.norm(incoming)
    outgoing /= np.linalg.norm(outgoing)
    tangents = [incoming + outgoing]
    if loop.corners[e]:
        tangents += [incoming, outgoing]
    # The angle to the plane is what is missing to 90 degrees of the angle to its normal.
    to_normals = [math.acos(abs(chord @ t) / np.linalg.norm(t)) for t in tangents]
    return min(abs(90 - math.degrees(angle)) for angle in to_normals)


def arc_over_chord(points: np.ndarray, i: int, j: int) -> float:
    closed = np.concatenate([points, points[:1]])
    along = np.r_[0, np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))]
    way = along[j] - along[i]
    return min(way, along[-1] - way) / float(np.linalg.norm(points[i] - points[j]))


def wild_loop(seed: int) -> Loop:
    """A closed curve in space of random waves, in random pieces with corners between them."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(8, 160))
    t = np.linspace(0, 2 * math.pi, n, endpoint=False)
    points = np.c_[np.cos(t), np.sin(t), 0 * t]
    for k in range(1, 5):
        amount = rng.normal(size=(2, 3)) * 0.5 / k
        points = points + np.outer(np.cos(k * t), amount[0]) + np.outer(np.sin(k * t), amount[1])
    corners = rng.random(n) < 0.1 * rng.integers(2)
    return Loop(points, corners, np.arange(n))


LOOPS = st.one_of(
    st.integers(0, 10**6).map(wild_loop),
    st.sampled_from([ring(curves()) for curves in SHAPES.values()]),
)


@given(LOOPS, st.floats(5, 120))
def test_between_neighbouring_ends_the_loop_turns_by_at_most_the_bound_and_one_angle(
    loop: Loop, degrees: float
) -> None:
    bound = math.radians(degrees)
    turning = vertex_angles(loop.points)
    ends = find_endpoints(loop, bound)
    assert len(ends) >= 1 and (np.diff(ends) > 0).all()
    assert set(np.flatnonzero(loop.corners)) <= set(ends.tolist())
    for i, a in enumerate(ends):
        b = ends[i + 1] if i + 1 < len(ends) else ends[0] + len(turning)
        between = turning[np.arange(a + 1, b) % len(turning)]
        assert between.sum() <= bound + turning.max() + SLACK
        # In fact the bound itself holds.
        assert between.sum() <= bound * (1 + SLACK) + SLACK


def test_the_bound_is_not_spent_on_straight_stretches() -> None:
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 0]], float)
    assert len(find_endpoints(ring([square], 0.01))) == 4


def test_a_maximum_of_curvature_is_an_end() -> None:
    t = np.linspace(-1, 1, 81)
    bend = np.c_[t, np.sqrt(t**2 + 0.05**2), 0 * t]
    loop = ring([bend, np.array([bend[-1], [0, 3, 0], bend[0]])], 0.025)
    sharpest = np.flatnonzero(np.abs(loop.points[:, 0]) + loop.points[:, 1] < 0.06)
    assert np.isin(find_endpoints(loop, math.radians(60)), sharpest).any()


@pytest.mark.parametrize("bound", [0.0, -1.0, math.nan, math.inf])
def test_a_bound_without_sense_is_refused(bound: float) -> None:
    with pytest.raises(InvalidNetworkError, match="turning bound"):
        find_endpoints(ring(SHAPES["bumper"]()), bound)


@given(LOOPS, st.floats(20, 90))
def test_every_candidate_is_nearly_perpendicular_and_cuts_off_more_than_a_sliver(
    loop: Loop, degrees: float
) -> None:
    found = find_candidates(loop, find_endpoints(loop, math.radians(degrees)))
    n = len(loop.points)
    started: Counter[int] = Counter()
    for i, j in found.chords.tolist():
        assert 2 <= j - i <= n - 2
        assert arc_over_chord(loop.points, i, j) > HUGGING
        fits = []
        for e, p in ((i, j), (j, i)):
            most = 40 if loop.corners[p] else 30
            if e in found.ends and off_normal_plane(loop, e, p) <= most + SLACK:
                fits.append(e)
        assert fits
        started.update(fits)
    assert len(found.chords) <= 2 * len(found.ends)


@given(LOOPS)
def test_no_chord_is_there_twice_and_the_counts_are_right(loop: Loop) -> None:
    ends = find_endpoints(loop)
    found = find_candidates(loop, ends)
    assert len({frozenset(chord) for chord in found.chords.tolist()}) == len(found.chords)
    assert (found.chords[:, 0] < found.chords[:, 1]).all()
    touched = set(found.chords.ravel().tolist())
    assert found.ends.tolist() == ends.tolist()
    assert found.n_unmatched == len(set(ends.tolist()) - touched)


@given(LOOPS)
@settings(max_examples=25)
def test_every_end_has_its_nearest_corner_and_its_closest_point_or_a_substitute(
    loop: Loop,
) -> None:
    found = find_candidates(loop, find_endpoints(loop))
    points, n = loop.points, len(loop.points)
    chords = {frozenset(chord) for chord in found.chords.tolist()}
    made_or_given = set(found.chords.ravel().tolist()) | set(found.ends.tolist())
    length = np.linalg.norm(points - np.roll(points, -1, axis=0), axis=1).sum()
    for e in found.ends.tolist():
        distance = np.linalg.norm(points - points[e], axis=1)
        partners = [
            p
            for p in range(n)
            if 2 <= abs(p - e) <= n - 2 and arc_over_chord(points, min(e, p), max(e, p)) > HUGGING
        ]
        lean = {p: off_normal_plane(loop, e, p) for p in partners}
        corners = [p for p in partners if loop.corners[p] and lean[p] <= 40]
        within = [p for p in partners if lean[p] <= 30]
        corner = min(corners, key=lambda p: distance[p], default=None)
        if corner is not None:
            assert frozenset((e, corner)) in chords
        if not within:
            continue
        least = min(distance[within])
        near = max(NEAR_EDGES * length / n, NEAR_SHARE * least) + SLACK
        partner = [q for q in made_or_given if frozenset((e, q)) in chords and q in lean]
        # Of several points as close as each other, any may be the one.
        assert any(
            (corner is not None and np.linalg.norm(points[corner] - points[closest]) <= near)
            or any(
                np.linalg.norm(points[q] - points[closest]) <= near and lean[q] <= 30 + SLACK
                for q in partner
            )
            for closest in within
            if distance[closest] <= least + SLACK
        )


def test_ribs_join_the_samples_across_a_ribbon() -> None:
    t = np.linspace(0, math.pi, 41)
    arch = np.c_[np.cos(t), 0 * t, np.sin(t)]
    loop = ring(strip(arch, arch + np.array([0, 0.5, 0])), 0.05)
    found = find_candidates(loop, find_endpoints(loop))
    across = np.abs(np.diff(loop.points[found.chords], axis=1)[:, 0])
    ribs = (np.abs(across - [0, 0.5, 0]) < 1e-9).all(axis=1)
    assert ribs.sum() == 3
    assert found.n_unmatched == 0


def test_an_end_without_a_partner_is_counted() -> None:
    # Only neighbours in a triangle: no chord at all.
    loop = Loop(np.eye(3), np.ones(3, bool), np.arange(3))
    found = find_candidates(loop, find_endpoints(loop))
    assert (len(found.chords), found.n_unmatched) == (0, 3)
