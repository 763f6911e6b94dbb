"""The network of car-like bodies: corners, edges and boxes, the same for all of them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from bodies import CARS, COMPONENTS

from patterndb_sketch.features.registration.boxes import read_car
from tests.support.features.bodies import NAMES, made

BOXES, CORNERS = read_car().boxes, read_car().corners


@pytest.mark.parametrize("name", NAMES)
def test_network_endpoints_coincide(name: str) -> None:
    """Curves meet in the corners, edges run from corner to corner, and faces close."""
    half = made(name)
    curves = {one.name: one for one in half.features}
    for corner, names in CORNERS.items():
        at = half.corners[corner]
        first, *others = (curves[one].points for one in names)
        assert np.linalg.norm(first[[0, -1]] - at, axis=1).min() < 1e-9
        for other in others:
            assert np.linalg.norm(other - at, axis=1).min() < 2e-6, (corner, names)
    for box in BOXES:
        for edge in box.edges:
            chain = [curves[one].points for one in edge.curves]
            for one, two in pairwise(chain):
                assert np.linalg.norm(one[-1] - two[0]) < 2e-6
            line = np.concatenate(chain)
            start, end = (
                int(np.argmin(np.linalg.norm(line - half.corners[which], axis=1)))
                for which in edge.ends
            )
            assert start < end, edge
            wanted = [half.corners[which] for which in edge.ends]
            assert np.linalg.norm(line[[start, end]] - wanted) < 4e-6


def test_the_boxes_are_boxes_without_their_open_faces() -> None:
    assert [box.component for box in BOXES] == list(COMPONENTS)
    used = [name for box in BOXES for edge in box.edges for name in edge.curves]
    named = {curve.name for curve in made("sedan").features}
    assert set(used) == named
    for box in BOXES:
        assert len(box.faces) + len(box.open) == 6
        ends = [frozenset(edge.ends) for edge in box.edges]
        assert len(set(ends)) == len(ends)
        assert len(frozenset().union(*ends)) == 8
        sides = [
            frozenset((a, b)) for face in box.faces.values() for a, b in pairwise([*face, face[0]])
        ]
        assert set(sides) == set(ends)
        assert all(sides.count(end) <= 2 for end in ends)
        # Two that share an edge pass it in opposite senses.
        directed = [pair for face in box.faces.values() for pair in pairwise([*face, face[0]])]
        assert len(set(directed)) == len(directed)
        # An open face leaves out what no face has: edges with both faces open are left out.
        assert sum(sides.count(end) for end in ends) == 4 * len(box.faces)


@pytest.mark.parametrize("name", NAMES)
def test_box_faces_are_seen_from_outside(name: str) -> None:
    half = made(name)
    for box in BOXES:
        corners = {end for edge in box.edges for end in edge.ends}
        middle = np.mean([half.corners[one] for one in corners], axis=0)
        sign = -1.0 if box.hollow else 1.0
        for name, face in box.faces.items():
            a, b, c, d = (half.corners[one] for one in face)
            out = np.cross(c - a, d - b) @ ((a + b + c + d) / 4.0 - middle)
            assert sign * out > 0.0, (box.component, name)


def test_all_bodies_have_one_network_and_no_two_are_alike() -> None:
    every = [*CARS, "random 0"]
    lists = [[(one.name, one.component) for one in made(name).features] for name in every]
    assert all(one == lists[0] for one in lists)
    assert len(CARS) == 13
    shapes = np.array([
        np.concatenate([made(name).corners[corner] for corner in CORNERS]) for name in every
    ])  # fmt: skip
    apart = np.linalg.norm(shapes[:, None] - shapes[None], axis=2)
    assert apart[~np.eye(len(every), dtype=bool)].min() > 0.1
    # No few of them explain the rest: a shape model has many directions.
    values = np.linalg.svd(shapes[:13] - shapes[:13].mean(axis=0), compute_uv=False) ** 2
    assert values[0] < 0.8 * values.sum() and (values > 1e-4 * values.sum()).sum() >= 8
