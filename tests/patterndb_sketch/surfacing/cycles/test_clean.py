"""The patches of clean networks are found, each of them and nothing else.

benchmarks/surfacing/clean_cycles.py asks all networks of the generator; here are some.
"""

from __future__ import annotations

import numpy as np
import pytest

from patterndb_sketch.curvenetwork.network import CurveNetwork
from patterndb_sketch.surfacing.cycles import find_cycles
from tests.support.surfacing.cleannetworks import CleanNetwork, list_clean_networks

#: Of every family so many, spread evenly.
EACH = 5

FAMILIES = (
    "flat sheets",
    "half pipes",
    "tubes",
    "domes",
    "spheres",
    "bottles",
    "Moebius strips",
    "boxes",
    "prisms",
    "walls",
    "handles",
    "open boxes",
    "car-like shells",
)

#: Families of which some are not found: RESULTS.md counts them.
LEFT = ("wavy sheets", "saddles", "bent sheets", "tori", "crossing sheets")


def list_family(family: str) -> list[CleanNetwork]:
    return [one for one in list_clean_networks() if one.family == family]


def check_found(some: list[CleanNetwork]) -> None:
    assert some
    for one in some:
        found = find_cycles(CurveNetwork(one.network.curves, one.network.nodes))
        assert one.compare(found.cycles) == (0, 0), one.name


@pytest.mark.parametrize("family", FAMILIES)
def test_what_is_meant_is_found_and_nothing_else(family: str) -> None:
    members = list_family(family)
    check_found(members[:: max(1, len(members) // EACH)])


def test_all_families_are_here() -> None:
    assert {one.family for one in list_clean_networks()} == {*FAMILIES, *LEFT}


@pytest.mark.parametrize("family", ["wavy sheets", "bent sheets"])
def test_bent_sheets_are_not_closed_by_their_rims(family: str) -> None:
    names = ("wavy 3 x 2, 0.6 high, 1 waves", "cylinder 270 deg, 3 x 2", "wavy 3 x 2, 0.3 high")
    check_found([one for one in list_family(family) if one.name.startswith(names)])


@pytest.mark.parametrize("sides", [12, 17])
def test_lids_of_many_corners_are_found_and_rims_that_go_straight_on_stay_open(sides: int) -> None:
    """A prism's lid is longer than the ways around over its sides; a car's ground is flat, too."""
    at = 2 * np.pi * np.arange(sides) / sides
    ring = np.stack([np.cos(at), np.sin(at), 0 * at], axis=1)
    edges = [(i, (i + 1) % sides) for i in range(sides)]
    edges += [(a + sides, b + sides) for a, b in edges] + [(i, i + sides) for i in range(sides)]
    prism = CurveNetwork.from_edges(np.concatenate([ring, ring + np.array([0.0, 0.0, 0.4])]), edges)
    found = {tuple(sorted(cycle.curves)) for cycle in find_cycles(prism).cycles}
    assert found >= {tuple(range(sides)), tuple(range(sides, 2 * sides))}
    assert len(found) == sides + 2
    for one in list_family("car-like shells"):
        assert find_cycles(CurveNetwork(one.network.curves, one.network.nodes)).once, one.name


def test_a_wall_on_a_sheet_is_told_as_a_patch_and_bounded_by_no_idle_curve() -> None:
    """Three squares at one curve, in whatever order they were drawn."""
    points = np.array(
        [[0, 0, 0], [0, 1, 0], [-1, 0, 0], [-1, 1, 0], [1, 0, 0], [1, 1, 0], [0, 0, 1], [0, 1, 1]],
        float,
    )
    edges = [(0, 1)] + [pair for k in (2, 4, 6) for pair in ((0, k), (1, k + 1), (k, k + 1))]
    for order in (edges, edges[::-1]):
        found = find_cycles(CurveNetwork.from_edges(points, order))
        assert len(found.cycles) == 3
        assert not found.unused
        assert len(found.once) == len(edges) - 1
