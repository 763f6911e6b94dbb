"""Strips that are bent around a limb are patches, and their other sides are not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from patterndb_sketch.retopo.network import AtNode, Network, NetworkBuilder, check_network
from patterndb_sketch.retopo.network.patches import is_strip

UP = np.array([0.0, 0.0, 1.0])


def around(begin: float, end: float, z: float, n: int = 60) -> tuple[np.ndarray, np.ndarray]:
    """Points and normals on the unit cylinder, angles in degrees."""
    t = np.deg2rad(np.linspace(begin, end, n))
    out = np.stack([np.cos(t), np.sin(t), 0 * t], axis=1)
    return out + z * UP, out


def along(angle: float, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
    points = np.linspace(around(angle, angle, low, 1)[0][0], around(angle, angle, high, 1)[0][0], 9)
    return points, np.repeat(around(angle, angle, 0, 1)[1], 9, axis=0)


def strip(angle: float, height: float) -> list[tuple[np.ndarray, np.ndarray]]:
    """The sides of a strip this far around, counter-clockwise seen from outside."""
    points, normals = around(angle, 0, height)
    return [
        around(0, angle, 0.0),
        along(angle, 0.0, height),
        (points, normals),
        tuple(a[::-1] for a in along(0, 0.0, height)),  # type: ignore[list-item]
    ]


@given(st.floats(5, 355), st.floats(0.05, 2.0))
def test_a_strip_is_one_however_far_it_goes_around(angle: float, height: float) -> None:
    sides = strip(angle, height)
    assert is_strip(sides)
    turned = [(line[::-1], up[::-1]) for line, up in reversed(sides)]
    assert not is_strip(turned)


def test_a_ring_of_four_curves_around_a_limb_is_none() -> None:
    sides = [around(90 * k, 90 * (k + 1), 0.0) for k in range(4)]
    assert not is_strip(sides)
    assert not is_strip([(line[::-1], up[::-1]) for line, up in reversed(sides)])


@pytest.mark.parametrize("angle", [90, 135, 150, 180])
def test_a_ring_around_a_limb_falls_into_two_patches_wherever_it_is_parted(angle: int) -> None:
    """Two loops and two curves between them: what is left of the shorter strip is one, too."""
    builder = NetworkBuilder(Network(longest=100.0))
    nodes = {
        (a, z): builder.add_node(around(a, a, z, 1)[0][0], around(a, a, z, 1)[1][0])
        for a in (0, angle)
        for z in (0.0, 0.1)
    }
    for z in (0.0, 0.1):
        first, last = AtNode(nodes[0, z]), AtNode(nodes[angle, z])
        builder.add_chain(*around(0, angle, z), first, last)
        builder.add_chain(*around(angle, 360, z), last, first)
    for a in (0, angle):
        builder.add_chain(*along(a, 0.0, 0.1), AtNode(nodes[a, 0.0]), AtNode(nodes[a, 0.1]))
    network = builder.finish()
    check_network(network)
    assert sorted(len(patch.corners) for patch in network.patches.values()) == [4, 4]
