"""Grids of near parallelograms: Coons' patch with four corners, a disk in any loop."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from patterndb.geometry.points import Points
from patterndb_sketch.surfacing import tessellation
from patterndb_sketch.surfacing.methods import MOST_GRIDS, SurfaceRequest, make_smooth
from patterndb_sketch.surfacing.parallelograms import (
    FEWEST,
    choose_spans,
    count_along,
    fill_with_parallelograms,
    make_sector_grid,
    place_inner,
    rank_corners,
)
from patterndb_sketch.surfacing.patch import as_triangles
from patterndb_sketch.surfacing.surfaces import surface_loop
from query.placing import Surface
from tests.support.surfacing.intended import list_intended, of_net
from tests.support.surfacing.quads import assert_disk_within
from tests.support.surfacing.strips import draw_strip, measure_strip
from tests.support.surfacing.surfacedistance import distance
from tests.support.surfacing.tessellation import as_loop


def outline(net: Points) -> Points:
    """The border of a net (m, n, 3) once around."""
    return np.concatenate([net[:-1, 0], net[-1, :-1], net[:0:-1, -1], net[0, :0:-1]])


@settings(max_examples=40, deadline=None)
@given(st.lists(st.integers(2, 6), min_size=3, max_size=6).map(tuple))
def test_a_sector_grid_is_a_disk_of_quads_with_regular_sectors(spans: tuple[int, ...]) -> None:
    sides = len(spans)
    grid = make_sector_grid(spans)
    ahead = np.roll(spans, -1)
    n_inner = 1 + sum(s - 1 for s in spans) + int(((np.array(spans) - 1) * (ahead - 1)).sum())
    assert grid.energy.shape == (grid.border + n_inner,) * 2
    assert grid.border == 2 * sum(spans) and len(grid.quads) == int((np.array(spans) * ahead).sum())
    assert np.diff(grid.starts).tolist() == count_along(spans).tolist()
    halves = np.concatenate([grid.quads[:, [0, 1, 2]], grid.quads[:, [0, 2, 3]]])
    assert_disk_within(grid.border, halves)
    uses = np.bincount(grid.quads.ravel())
    expected = np.full(len(uses), 4)
    expected[: grid.border] = 2
    expected[grid.starts[:-1]] = 1
    assert (
        np.sort(uses[grid.border :]) == np.sort(np.r_[sides, expected[grid.border + 1 :]])
    ).all()
    assert (uses[: grid.border] == expected[: grid.border]).all()
    # The ring: what is beside the border, each side's from one corner's to the next's.
    beside = set(grid.quads[(grid.quads < grid.border).any(axis=1)].ravel().tolist())
    assert set(np.concatenate(grid.ring).tolist()) == {v for v in beside if v >= grid.border}
    assert [len(row) for row in grid.ring] == (np.diff(grid.starts) - 1).tolist()
    assert all(grid.ring[s][-1] == grid.ring[(s + 1) % sides][0] for s in range(sides))


@settings(max_examples=60, deadline=None)
@given(st.lists(st.integers(2, 12), min_size=3, max_size=6).map(tuple))
def test_sides_get_as_many_quads_as_they_have_edges(spans: tuple[int, ...]) -> None:
    """Counts that some grid has are kept, unless they are too few or too many."""
    counts = count_along(spans)
    corners = np.r_[0, np.cumsum(counts)[:-1]].tolist()
    vertices = int(counts.sum())
    assume(2 * len(spans) * FEWEST <= vertices)
    found = count_along(choose_spans(vertices, corners))
    even = round(vertices / (2 * len(spans))) * 2 * len(spans) / vertices
    assert np.abs(found - even * counts).max() <= 2.0


@pytest.mark.parametrize("spans", [(4, 4, 4, 4), (2, 5, 3, 4)])
def test_with_four_corners_it_is_coons_patch(spans: tuple[int, ...]) -> None:
    rng = np.random.default_rng(2)
    grid = make_sector_grid(spans)
    border = rng.normal(size=(grid.border, 3))
    points = np.r_[border, place_inner(grid, border)]
    around = np.r_[border, border[:1]]
    low, right, high, left = (
        around[a : b + 1] for a, b in zip(grid.starts, grid.starts[1:], strict=False)
    )
    high, left = high[::-1], left[::-1]
    s = (np.arange(len(low)) / (len(low) - 1))[:, None, None]
    t = (np.arange(len(left)) / (len(left) - 1))[None, :, None]
    coons = (1 - t) * low[:, None] + t * high[:, None] + (1 - s) * left[None] + s * right[None]
    coons -= (1 - s) * (1 - t) * low[0] + s * (1 - t) * low[-1]
    coons -= (1 - s) * t * high[0] + s * t * high[-1]
    inner = coons[1:-1, 1:-1].reshape(-1, 3)
    gaps = np.linalg.norm(inner[:, None] - points[None, grid.border :], axis=2)
    assert gaps.min(axis=1).max() < 1e-3 and gaps.min(axis=0).max() < 1e-3


@settings(max_examples=20, deadline=None)
@given(st.integers(3, 60), st.integers(0, 2**32 - 1), st.booleans())
def test_any_loop_is_filled_with_a_disk(n: int, seed: int, bent: bool) -> None:
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.random(n)) * 2 * np.pi + np.arange(n) * 1e-3
    points = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    points *= 1 + 0.3 * rng.random((n, 1))
    if bent:
        points[:, 2] = rng.normal(size=n)
    choices = rank_corners(points)
    assert choices and all(3 <= len(one.corners) <= 6 for one in choices)
    assert [one.score for one in choices] == sorted(one.score for one in choices)
    assert len({one.corners for one in choices}) == len(choices)
    for choice in (*choices[:2], choices[-1]):
        assert list(choice.corners) == sorted(set(choice.corners))
        mesh = fill_with_parallelograms(points, choice.corners)
        assert np.isfinite(mesh.points).all()
        assert_disk_within(n, mesh.triangles)
        if not bent:
            assert np.abs(mesh.points[:, 2]).max() < 1e-9


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_the_choice_does_not_depend_on_place_size_turn_or_start(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = next(cycle for cycle in list_intended() if cycle.name == "cup quarter").loop.points
    best = rank_corners(points)[0]
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    shift = int(rng.integers(len(points)))
    moved = np.roll(3.7 * points @ turn + rng.normal(size=3), -shift, axis=0)
    again = rank_corners(moved)[0]
    # The box's diagonal turns with the loop a little, and the score with it.
    corners = sorted((c + shift) % len(points) for c in again.corners)
    assert corners == list(best.corners)


def test_corners_that_are_named_are_tried() -> None:
    angle = 2 * np.pi * np.arange(48) / 48
    circle = np.stack([np.cos(angle), np.sin(angle), 0.4 * np.cos(2 * angle)], axis=1)
    named = [5, 17, 29, 41]
    assert tuple(named) in {one.corners for one in rank_corners(circle, named)}


def test_strips_are_surfaced_and_lie_near_the_pipe() -> None:
    for degrees, height in ((90.0, 0.1), (180.0, 1.0), (250.0, 0.5), (330.0, 3.0)):
        assert len(draw_strip(degrees, height).curves) == 4
        found = {m: measure_strip(degrees, height, m) for m in ("chords", "area", "smooth")}
        assert all(one is not None for one in found.values())
        far, answered = found["smooth"]
        # The arcs are sampled: their chords alone are up to this far from them.
        assert answered == "smooth" and far < 0.01


def test_bent_patches_of_a_saddle_are_nearer_than_by_chords() -> None:
    x, y = np.meshgrid(np.linspace(-1, 1, 9), np.linspace(-1, 1, 7), indexing="ij")
    patch = of_net("saddle", "", np.stack([x, y, 0.5 * x * y + 0.3 * x**2], axis=-1))
    loop, meant = patch.loop, Surface.from_arrays(patch.vertices, patch.triangles)
    steps = np.linalg.norm(np.roll(loop.points, -1, axis=0) - loop.points, axis=1)
    far = {}
    for name in ("smooth", "chords", "area"):
        made = surface_loop(loop, SurfaceRequest(method=name), steps.mean())
        points = np.concatenate([loop.points, made.points])
        far[name] = distance(Surface.from_arrays(points, as_triangles(made.faces)), meant).mean
    assert far["smooth"] < 0.5 * min(far["chords"], far["area"])


@pytest.mark.parametrize(("crossing", "method"), [(0, "smooth"), (1, "smooth"), (99, "chords")])
def test_grids_that_cross_themselves_give_way_to_others_and_then_to_chords(
    crossing: int, method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: list[int] = []

    def find(*_: object) -> list[int]:
        calls.append(1)
        return [1] if len(calls) <= crossing else []

    monkeypatch.setattr(tessellation, "find_self_intersections", find)
    loop = next(cycle for cycle in list_intended() if cycle.name == "cup quarter").loop
    made = make_smooth(loop, SurfaceRequest(method="smooth"), 0.3, None)
    assert made.method == method
    assert len(calls) == min(crossing + 1, MOST_GRIDS)
    assert ("crosses itself" in made.note) == (method == "chords")


def test_a_figure_eight_is_filled_without_crossings_or_says_why_not() -> None:
    angle = 2 * np.pi * np.arange(24) / 24
    points = np.stack([np.sin(angle), np.sin(2 * angle), 0.3 * np.cos(angle)], axis=1)
    made = surface_loop(as_loop(points), SurfaceRequest(method="smooth"), 0.3)
    assert made.self_intersections == 0 or made.note
