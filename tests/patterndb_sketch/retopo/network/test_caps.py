"""Loops that the surface tells to be patches, and patches made by hand: ends of limbs, rings."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface, SurfacePoints
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network import (
    Network,
    add_borders,
    check_network,
    trace_outline,
    walk_face,
)
from patterndb_sketch.retopo.network.flooding import flood_triangles, make_wall
from patterndb_sketch.retopo.network.patches import ROUNDNESS
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tools.autocomplete import autocomplete
from patterndb_sketch.retopo.tools.corner import toggle_corner
from patterndb_sketch.retopo.tools.cylinder import join_loops
from patterndb_sketch.retopo.tools.patch import drop_patch, find_loop, make_patch
from patterndb_sketch.retopo.tools.spine import draw_spine
from patterndb_sketch.retopo.tools.stroke import insert_stroke
from patterndb_sketch.retopo.tracing import clean_stroke
from tests.support.retopo.networks import genus


def turned(profile: Points, sections: int = 48) -> Surface:
    """A surface of revolution about z of a profile (n, 2) of radius and height, its ends on z."""
    turn = np.linspace(0.0, 2.0 * np.pi, sections, endpoint=False)
    rings = np.stack(
        [
            profile[1:-1, :1] * np.cos(turn),
            profile[1:-1, :1] * np.sin(turn),
            np.broadcast_to(profile[1:-1, 1:], (len(profile) - 2, sections)),
        ],
        axis=-1,
    ).reshape(-1, 3)
    low, high = [0.0, 0.0, profile[0, 1]], [0.0, 0.0, profile[-1, 1]]
    k = np.arange(sections)
    after = (k + 1) % sections
    triangles = [np.stack([np.full(sections, len(rings)), after, k], axis=1)]
    for ring in range(len(profile) - 3):
        a, b = ring * sections + k, ring * sections + after
        triangles += [
            np.stack([a, b, b + sections], axis=1),
            np.stack([a, b + sections, a + sections], axis=1),
        ]
    last = (len(profile) - 3) * sections
    triangles.append(np.stack([last + k, last + after, np.full(sections, len(rings) + 1)], axis=1))
    return Surface.from_arrays(
        np.concatenate([rings, [low, high]]), np.concatenate(triangles)
    ).orient()


@cache
def finger(length: float = 6.0) -> Surface:
    """A tube of radius 1 about z, closed by half balls at z = 0 and above ``length``."""
    t = np.linspace(-np.pi / 2, 0.0, 12)
    below = np.c_[np.cos(t), np.sin(t)]
    z = np.arange(0.1, length, 0.1)
    middle = np.c_[np.ones(len(z)), z]
    return turned(np.concatenate([below, middle, [0.0, length] + below[::-1] * [1.0, -1.0]]))


@cache
def tin() -> Surface:
    """A tube of radius 1 from z = 0 to 4 with flat ends and sharp rims."""
    r, z = np.linspace(0.0, 1.0, 11)[:, None], np.linspace(0.0, 4.0, 41)[1:-1, None]
    bottom, top = np.c_[r, np.zeros_like(r)], np.c_[r[::-1], np.full_like(r, 4.0)]
    return turned(np.concatenate([bottom, np.c_[np.ones_like(z), z], top]))


def ring(z: float, radius: float = 1.0) -> Points:
    t = np.linspace(0.0, 2.0 * np.pi, 90, endpoint=False)
    return np.c_[radius * np.cos(t), radius * np.sin(t), np.full(90, z)]


def feet(surface: Surface, *point: float) -> SurfacePoints:
    return surface.nearest(np.array([point]))


def ringed(surface: Surface, *heights: float, corners: int = 4) -> tuple[Network, Sizes]:
    """Rings around z with corners at even angles, drawn as a user does."""
    sizes = Sizes.of(surface.diagonal)
    network = add_borders(Network(longest=2.0 * surface.diagonal), surface, sizes.sampling)
    for z in heights:
        stroke = clean_stroke(ring(z), surface, sizes, True)
        network = insert_stroke(network, surface, sizes, stroke).network
        for k in range(corners):
            at = ring(z)[90 * k // corners]
            foot = surface.nearest(at[None])
            network = toggle_corner(network, sizes, foot.points[0], foot.normals[0]).network
            check_network(network)
    assert genus(network) == 0
    return network, sizes


def left_of(network: Network) -> list[float]:
    """Of every patch, on which side of its loop about z it is: 1 above, -1 below."""
    found: list[float] = []
    for patch in network.patches.values():
        points, normals = trace_outline(network, patch.loop)
        along = np.roll(points, -1, axis=0) - points
        found.append(float(np.sign(np.cross(normals, along)[:, 2].sum())))
    return found


@pytest.mark.parametrize("corners", [2, 3, 4, 7])
def test_below_the_sharp_rim_of_a_tin_its_end_is_a_patch(corners: int) -> None:
    network, _ = ringed(tin(), 3.7, corners=corners)
    assert left_of(network) == [1.0]
    (patch,) = network.patches.values()
    assert len(patch.corners) == corners
    # With one corner it is none, and around the middle neither side is an end.
    assert not ringed(tin(), 3.7, corners=1)[0].patches
    assert not ringed(tin(), 2.0)[0].patches


@settings(max_examples=12, deadline=None)
@given(st.floats(4.0, 6.8))
def test_a_ring_around_a_finger_has_its_tip_up_to_the_bound(z: float) -> None:
    # Beyond the ring: half a ball and a piece of the tube, or a part of the half ball.
    beyond = 2.0 * np.pi * (1.0 + max(6.0 - z, 0.0)) if z < 6.0 else 2.0 * np.pi * (7.0 - z)
    radius = 1.0 if z < 6.0 else np.sqrt(1.0 - (z - 6.0) ** 2)
    ratio = beyond / (np.pi * radius**2)
    if abs(ratio - ROUNDNESS) < 0.5 or radius < 0.6:
        return
    surface = finger()
    sizes = Sizes.of(surface.diagonal)
    network = Network(longest=2.0 * surface.diagonal, surface=surface)
    stroke = clean_stroke(ring(z, radius), surface, sizes, True)
    network = insert_stroke(network, surface, sizes, stroke).network
    for angle in (0.0, 2.0, 4.0):
        foot = feet(surface, radius * np.cos(angle), radius * np.sin(angle), z)
        network = toggle_corner(network, sizes, foot.points[0], foot.normals[0]).network
    check_network(network)
    # Never the hand.
    assert left_of(network) == ([1.0] if ratio < ROUNDNESS else [])


def test_an_end_with_a_curve_or_a_hole_in_it_is_none() -> None:
    # Another ring further up: the end belongs to that.
    network, _ = ringed(finger(), 6.0, 5.6)
    assert left_of(network) == [1.0]
    (patch,) = network.patches.values()
    assert trace_outline(network, patch.loop)[0][:, 2].mean() == pytest.approx(6.0, abs=0.05)
    # Without the triangles at the tip.
    whole = finger()
    top = whole.vertices[whole.triangles][:, :, 2].max(axis=1) > 6.99
    holed = Surface.from_arrays(whole.vertices, whole.triangles[~top]).orient()
    assert not ringed(holed, 6.0)[0].patches


def test_around_a_handle_there_is_no_end() -> None:
    mesh = trimesh.creation.torus(1.0, 0.3, major_sections=64, minor_sections=32)
    surface = Surface.of(mesh).orient()
    sizes = Sizes.of(surface.diagonal)
    t = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    line = np.c_[1.0 + 0.3 * np.cos(t), np.zeros(60), 0.3 * np.sin(t)]
    network = insert_stroke(
        Network(), surface, sizes, clean_stroke(line, surface, sizes, True)
    ).network
    for at in line[::20]:
        foot = surface.nearest(at[None])
        network = toggle_corner(network, sizes, foot.points[0], foot.normals[0]).network
    check_network(network)
    assert not network.patches


@settings(max_examples=20, deadline=None)
@given(st.floats(0.2, 5.8), st.floats(0.5, 40.0))
def test_flooding_stops_at_walls_and_beyond_its_area(z: float, most: float) -> None:
    surface = finger()
    wall = make_wall(surface, [(ring(z), True)])
    assert wall is not None
    middle = surface.vertices[surface.triangles].mean(axis=1)[:, 2]
    seeds = np.flatnonzero(middle > 6.8)[:1].astype(np.int32)
    found = flood_triangles(surface, wall.crossed, seeds, most)
    # By heights: all above the ring that it does not cross.
    expected = np.flatnonzero((middle > z) & ~wall.crossed)
    area = surface.areas[expected].sum()
    if found is None:
        assert area > most
    else:
        assert sorted(found[0].tolist()) == expected.tolist()
        assert found[1] == pytest.approx(area) and area <= most
    # The wall is where the ring is.
    assert np.abs(middle[wall.crossed] - z).max() < 0.2


def test_the_cap_of_a_cylinder_knows_the_ends_of_limbs() -> None:
    surface = tin()
    sizes = Sizes.of(surface.diagonal)
    network = Network(longest=2.0 * surface.diagonal)
    for z in (3.8, 2.0):
        stroke = clean_stroke(ring(z), surface, sizes, True)
        network = insert_stroke(network, surface, sizes, stroke).network
    stroke = clean_stroke(
        np.array([[1.0, 0, 2.0], [1.0, 0, 2.9], [1.0, 0, 3.8]]), surface, sizes, False
    )
    done = join_loops(network, surface, sizes, stroke).network
    check_network(done)
    # Four around, and the top; below there is more than an end.
    assert len(done.patches) == 5


@pytest.mark.parametrize("height", [0.5, 2.5, 4.0])
def test_by_hand_any_loop_around_a_place_is_a_patch_and_none_again(height: float) -> None:
    network, _ = ringed(tin(), 2.0)
    assert not network.patches
    made = make_patch(network, tin(), feet(tin(), 0.7, 0.7, height))
    check_network(made.network, patches=False)
    assert left_of(made.network) == [1.0 if height > 2.0 else -1.0]
    with pytest.raises(RefusedError, match="already"):
        make_patch(made.network, tin(), feet(tin(), 0.7, 0.7, height))
    gone = drop_patch(made.network, tin(), feet(tin(), 0.7, 0.7, height)).network
    assert not gone.patches and gone.chains.keys() == network.chains.keys()
    with pytest.raises(RefusedError, match="no patch"):
        drop_patch(gone, tin(), feet(tin(), 0.7, 0.7, height))


def test_a_patch_let_go_stays_so_while_others_are_drawn() -> None:
    network, sizes = ringed(tin(), 3.7)
    gone = drop_patch(network, tin(), feet(tin(), 0.0, 0.0, 4.0)).network
    other = insert_stroke(gone, tin(), sizes, clean_stroke(ring(1.0), tin(), sizes, True)).network
    assert not other.patches
    # Another corner on its loop, and it is looked at anew.
    foot = feet(tin(), *ring(3.7)[11])
    again = toggle_corner(other, sizes, foot.points[0], foot.normals[0]).network
    assert left_of(again) == [1.0]


def test_what_can_be_no_patch_by_hand_is_refused() -> None:
    surface = tin()
    with pytest.raises(RefusedError, match="no curve yet"):
        make_patch(Network(), surface, feet(surface, 1, 0, 2))
    network, sizes = ringed(surface, 1.0, 3.0)
    with pytest.raises(RefusedError, match="several loops"):
        make_patch(network, surface, feet(surface, -1, 0, 2))
    plain, _ = ringed(surface, 2.0, corners=1)
    with pytest.raises(RefusedError, match="fewer than two corners"):
        make_patch(plain, surface, feet(surface, -1, 0, 3))
    line = np.array([[1.0, 0.0, 1.0], [1.0, 0.0, 2.0]])
    single, sizes = ringed(surface, 1.0)
    stem = insert_stroke(single, surface, sizes, clean_stroke(line, surface, sizes, False)).network
    with pytest.raises(RefusedError, match="open end"):
        make_patch(stem, surface, feet(surface, 0.0, 1.0, 2.0))


@settings(max_examples=15, deadline=None)
@given(st.floats(0.0, 2.0 * np.pi), st.floats(0.1, 3.9))
def test_the_loop_around_a_place_is_on_the_side_it_is_on(angle: float, z: float) -> None:
    network, _ = ringed(tin(), 2.0)
    half = find_loop(network, tin(), feet(tin(), np.cos(angle), np.sin(angle), z))
    points, normals = trace_outline(network, walk_face(network.nodes, network.chains, half)[0])
    along = np.roll(points, -1, axis=0) - points
    above = np.cross(normals, along)[:, 2].sum() > 0.0
    if abs(z - 2.0) > 0.01:
        assert above == (z > 2.0)


def slit() -> tuple[Network, Surface, Sizes]:
    """On a tin, two rings with one curve between them; beyond them patches."""
    network, sizes = ringed(tin(), 0.3, 3.7)
    line = np.array([[1.0, 0.0, 0.3], [1.0, 0.0, 2.0], [1.0, 0.0, 3.7]])
    network = insert_stroke(network, tin(), sizes, clean_stroke(line, tin(), sizes, False)).network
    return network, tin(), sizes


def test_a_strip_closed_by_one_curve_is_open_to_spines_and_suggestions() -> None:
    network, surface, sizes = slit()
    check_network(network)
    assert genus(network) == 0
    stroke = clean_stroke(np.array([[-0.9, 0.4, 0.3], [-0.9, 0.4, 1.2]]), surface, sizes, False)
    drawn = draw_spine(network, surface, stroke, sizes).network
    check_network(drawn, patches=False)
    assert genus(drawn) == 0
    (new,) = [p for p in drawn.patches.values() if p.id not in network.patches and len(p.loop) <= 5]
    assert len(new.corners) == 4
    # It stands on the ring, which has a T-junction for the patch beyond.
    below = trace_outline(drawn, new.loop)[0][:, 2]
    assert below.min() == pytest.approx(0.3, abs=0.02) and below.max() < 1.5
    foot = feet(surface, *ring(0.3)[38])
    found = autocomplete(network, surface, foot.points[0], foot.normals[0], sizes).network
    check_network(found, patches=False)
    assert genus(found) == 0 and len(found.chains) > len(network.chains)
