"""Half a sketch and its mirror image: one network, joined in the plane."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb_sketch.curvenetwork.drawing import Drawing
from patterndb_sketch.curvenetwork.network import CurveNetwork, InvalidNetworkError
from patterndb_sketch.surfacing import find_cycles, network_of_polylines, surface
from patterndb_sketch.surfacing.mirroring import (
    describe_plane,
    find_mirror_plane,
    mirror_drawing,
    parse_plane,
)


def half_vase(
    meridians: Sequence[float], rings: int = 4, samples: int = 30, short: float = 0.0
) -> CurveNetwork:
    """Meridians at parts of half a turn, 0 to 1, and half rings that end on y = 0.

    short: by how much rings stop before the plane.
    """
    heights = np.linspace(0.0, 2.0, samples)
    radius = 0.8 + 0.3 * np.sin(2.0 * heights)
    lines = [
        np.stack([radius * np.cos(np.pi * part), radius * np.sin(np.pi * part), heights], axis=1)
        for part in meridians
    ]
    for k in np.linspace(0, samples - 1, rings).round().astype(int):
        angle = np.linspace(short, np.pi - short, samples)
        height = np.full(samples, heights[k])
        lines.append(
            np.stack([radius[k] * np.cos(angle), radius[k] * np.sin(angle), height], axis=1)
        )
    return network_of_polylines(lines, tolerance=0.02)


def turn_about(seed: int) -> np.ndarray:
    turn, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return turn


def move(network: CurveNetwork, turn: np.ndarray, by: np.ndarray) -> CurveNetwork:
    lines = [curve.points @ turn.T + by for curve in network.curves]
    return network_of_polylines(lines)


def assert_symmetric(network: CurveNetwork, normal: np.ndarray, offset: float) -> None:
    """Every node and every curve has its image."""
    images = network.nodes - 2.0 * ((network.nodes @ normal) - offset)[:, None] * normal
    gaps = np.linalg.norm(network.nodes[:, None] - images[None], axis=2).min(axis=0)
    assert gaps.max() < 1e-9
    assert len({tuple(node) for node in network.nodes.round(9).tolist()}) == len(network.nodes)


@pytest.mark.parametrize("meridians", [(0, 0.25, 0.5, 0.75, 1), (0.25, 0.5, 0.75), (0.125, 0.625)])
@pytest.mark.parametrize("short", [0.0, 0.002])
def test_half_a_vase_becomes_a_whole_one(meridians: Sequence[float], short: float) -> None:
    """With curves in the plane, and without: patches go across it then."""
    half = half_vase(meridians, short=short)
    plane = find_mirror_plane(half)
    assert describe_plane(plane) == "y = 0"
    whole = mirror_drawing(Drawing(half), plane).network
    assert_symmetric(whole, np.array([0.0, 1.0, 0.0]), 0.0)
    n_meridians = 2 * len(meridians) - sum(part in (0, 1) for part in meridians)
    found = find_cycles(whole).cycles
    made = surface(whole, found)
    # Three bands of cells; the two rims may be closed by lids.
    assert len(found) - 3 * n_meridians in (0, 1, 2)
    assert all(patch.surface is not None for patch in made.patches)
    edges = np.sort(made.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    uses = np.unique(edges, axis=0, return_counts=True)
    open_edges = uses[0][uses[1] == 1]
    assert (uses[1] <= 2).all()
    # Welded in the plane: what is open lies at the rims.
    heights = made.points[open_edges][..., 2]
    assert (np.isclose(heights, 0.0) | np.isclose(heights, 2.0)).all()


@settings(max_examples=6, deadline=None)
@given(st.integers(0, 2**32), st.floats(-5, 5))
def test_the_plane_is_found_wherever_it_lies(seed: int, shift: float) -> None:
    turn = turn_about(seed)
    by = np.full(3, shift)
    half = move(half_vase((0.25, 0.5, 0.75)), turn, by)
    plane = find_mirror_plane(half)
    normal = turn @ [0.0, 1.0, 0.0]
    assert abs(np.array(plane.normal) @ normal) == pytest.approx(1.0, abs=1e-6)
    assert (np.array(plane.point) - by) @ normal == pytest.approx(0.0, abs=1e-6)
    whole = mirror_drawing(Drawing(half), plane).network
    assert_symmetric(whole, np.array(plane.normal), np.array(plane.point) @ plane.normal)


def test_either_side_of_the_plane_may_be_drawn() -> None:
    half = half_vase((0, 0.5, 1))
    other = move(half, np.diag([1.0, -1.0, 1.0]), np.zeros(3))
    nodes = [mirror_drawing(Drawing(one), parse_plane("y")).network.nodes for one in (half, other)]
    one, two = ({tuple(node) for node in at.round(9).tolist()} for at in nodes)
    assert one == two


def test_names_cycles_and_stages_have_images() -> None:
    half = half_vase((0, 0.5, 1))
    given_cycles = find_cycles(half).cycles
    drawing = Drawing(
        CurveNetwork(half.curves, half.nodes, given_cycles),
        (tuple(range(len(half.curves))),),
    )
    whole = mirror_drawing(drawing, parse_plane("y"))
    network = whole.network
    assert len(network.cycles) == 2 * len(given_cycles)
    assert set(whole.stages[0]) == set(range(len(network.curves)))
    names = {curve.id for curve in half.curves}
    images = [curve for curve in network.curves if curve.id not in names]
    flat = sum(bool(np.abs(curve.points[:, 1]).max() < 1e-9) for curve in half.curves)
    assert len(images) == len(half.curves) - flat
    assert all(str(curve.id).endswith("_mirrored") for curve in images)
    assert "y = 0" in whole.notes[-1]


@pytest.mark.parametrize(
    ("text", "point", "normal"),
    [
        ("x", (0, 0, 0), (1, 0, 0)),
        ("Z", (0, 0, 0), (0, 0, 1)),
        ("y=-1.5", (0, -1.5, 0), (0, 1, 0)),
        ("0,2,0,3", (0, 1.5, 0), (0, 1, 0)),
        ("1,1,0,0", (0, 0, 0), (0.5**0.5, 0.5**0.5, 0)),
    ],
)
def test_planes_are_read_and_written(text: str, point: object, normal: object) -> None:
    plane = parse_plane(text)
    assert np.allclose(plane.point, point) and np.allclose(plane.normal, normal)
    again = parse_plane(describe_plane(plane).replace(" ", ""))
    assert np.allclose(again.normal, plane.normal, atol=1e-5)


@pytest.mark.parametrize(
    "text", ["", "w", "x=", "x=a", "1,2,3", "0,0,0,1", "1,2,3,nan", "net.json"]
)
def test_what_is_not_a_plane_is_refused(text: str) -> None:
    if text == "x=":
        assert parse_plane(text) == parse_plane("x")
        return
    with pytest.raises(InvalidNetworkError, match="not a plane"):
        parse_plane(text)


def test_what_cannot_be_mirrored_is_refused() -> None:
    half = half_vase((0.25, 0.5, 0.75))
    with pytest.raises(InvalidNetworkError, match="beyond the plane x = 0"):
        mirror_drawing(Drawing(half), parse_plane("x"))
    with pytest.raises(InvalidNetworkError, match="no curve ends on the plane"):
        mirror_drawing(Drawing(half), parse_plane("y=-3"))
    whole = mirror_drawing(Drawing(half), parse_plane("y")).network
    assert all(len(one) != 1 for one in _ends(whole))
    quarter = [np.array([[0, 0, 1], [0, 2, 1.0]]) + np.array([k, 0, 0]) for k in (1, 2, 3)]
    quarter += [np.array([[0, 0, 1], [4, 0, 1.0]]) + np.array([0, k, 0]) for k in (1, 2, 3)]
    with pytest.raises(InvalidNetworkError, match="as well; name the plane"):
        find_mirror_plane(network_of_polylines(quarter))


def _ends(network: CurveNetwork) -> list[list[int]]:
    at: list[list[int]] = [[] for _ in network.nodes]
    for number, curve in enumerate(network.curves):
        for node in curve.nodes:
            at[node].append(number)
    return at
