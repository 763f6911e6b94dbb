"""Curves without length or area, and curves that go out and back, end in no division by zero."""

from __future__ import annotations

import json
import warnings

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from patterndb.errors import PatternDBError
from patterndb.geometry.points import Points
from patterndb_sketch.curvenetwork.network import Curve, CurveNetwork, Cycle
from patterndb_sketch.surfacing.cycles import find_cycles
from patterndb_sketch.surfacing.cycles.closing import list_half_curves
from patterndb_sketch.surfacing.cycles.measures import measure_cycles, rate_badness
from patterndb_sketch.surfacing.methods import METHODS
from patterndb_sketch.surfacing.networkfile import parse_drawing
from patterndb_sketch.surfacing.surfaces import surface

CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)

SIDES = ((0, 1), (1, 3), (3, 2), (2, 0), (4, 5), (5, 7), (7, 6), (6, 4), (0, 4), (1, 5), (2, 6))


def measure_line(a: Points, b: Points, n: int) -> Points:
    share = np.linspace(0.0, 1.0, n)[:, None]
    return (1.0 - share) * a + share * b


def draw_degenerate(rng: np.random.Generator) -> Points:
    """A curve that goes out and back, has hardly any length, or lies on itself."""
    a, b = CORNERS[rng.integers(8)], CORNERS[rng.integers(8)]
    little = 10.0 ** float(rng.choice([-300, -170, -20, -17, -12, -8, -4, -2]))
    way = rng.normal(size=3)
    n = int(rng.integers(2, 9))
    return [
        np.array([a, a + little * way, a]),
        np.array([a, (a + b) / 2.0 + way, a]),
        np.array([a, a + little * way]),
        np.array([a, b, a, b]),
        np.array([a, (a + b) / 2.0, (a + b) / 2.0 + little * way, (a + b) / 2.0, b]),
        np.concatenate([measure_line(a, a + way, n), measure_line(a + way, a, 3)[1:]]),
        a + little * rng.normal(size=(n, 3)),
        np.concatenate([measure_line(a, b, 4), measure_line(b, a, 4)[1:] + little * way]),
        np.array([a, a + way, a + little * way, a + way, a]),
    ][int(rng.integers(9))]


def draw_curves(rng: np.random.Generator) -> list[Points]:
    """Some edges of a cube, with one to three degenerate curves among them."""
    some = rng.permutation(len(SIDES))[: int(rng.integers(1, len(SIDES) + 1))]
    curves = [measure_line(*CORNERS[list(SIDES[k])], int(rng.integers(2, 5))) for k in some]
    for _ in range(int(rng.integers(1, 4))):
        curves.insert(int(rng.integers(len(curves) + 1)), draw_degenerate(rng))
    size = 10.0 ** float(rng.choice([0, 0, 0, -9, 9, -30, 30]))
    return [size * (curve + float(rng.choice([0.0, 0.0, 1e6]))) for curve in curves]


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32), st.sampled_from([None, 1e-3, 1e-2, 0.3]))
@example(313, None)
def test_degenerate_curves_are_surfaced_or_refused(seed: int, tolerance: float | None) -> None:
    curves = draw_curves(np.random.default_rng(seed))
    size = float(np.abs(np.concatenate(curves)).max())
    document = {"curves": [{"id": k, "points": c.tolist()} for k, c in enumerate(curves)]}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            network = parse_drawing(
                json.dumps(document).encode(), None if tolerance is None else tolerance * size
            ).network
            found = find_cycles(network)
        except PatternDBError:
            return
        for name in (name for name, one in METHODS.items() if not one.needs_database):
            if found.cycles:
                made = surface(network, found.cycles, method=name)
                assert np.isfinite(made.points).all()


@pytest.mark.parametrize("size", [1.0, 1e-17, 1e-100, 1e-200, 1e-300])
def test_a_closed_curve_that_goes_out_and_back_encloses_nothing(size: float) -> None:
    for points in (
        [[0, 0, 0], [1, 0, 0], [0, 0, 0]],
        [[0, 0, 0], [1, 0, 0], [2, 0, 0], [1, 0, 0], [0, 0, 0]],
    ):
        at = size * np.array(points, float)
        network = CurveNetwork((Curve(at, (0, 0), 0, 0),), at[:1])
        cycles = [Cycle(((0, False),))]
        halves = list_half_curves(network, np.ones(1, np.bool_))
        measures = measure_cycles(network, halves, cycles)
        assert np.isfinite(measures.inward).all() and np.isfinite(measures.flatness).all()
        assert rate_badness(measures, np.ones(1), np.ones(1)) == np.inf
        assert find_cycles(network).cycles == ()
