"""Tracking a crease: the cheapest way, exactly; other creases beside it; pins that say which."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from patterndb.core.halfedge import Int64Array
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.points import Floats, Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.fishbone import cut, track_crease
from patterndb_sketch.features.fishbone.cut import LEAP
from patterndb_sketch.features.snap import Snap, SnapSettings, snap


def price(
    rows: tuple[int, ...],
    costs: Floats,
    cross: Floats,
    bends: Points,
    change: float,
    reach: Int64Array,
) -> float:
    """What rows cost, as the docstring has it."""
    total = sum(float(costs[i, j]) for i, j in enumerate(rows))
    for i in range(len(rows) - 1):
        j, k = rows[i], rows[i + 1]
        one, other = bends[i, j], bends[i + 1, k]
        apart = cross[i] * abs(j - k)
        leap = LEAP * apart + change * (np.linalg.norm(one) + np.linalg.norm(other))
        near = apart + change * np.linalg.norm(one - other) if abs(j - k) <= reach[i] else np.inf
        total += min(leap, near)
    return total


@given(st.integers(0, 10_000))
def test_no_way_is_cheaper(seed: int) -> None:
    """Against all ways, with holes and held rows."""
    rng = np.random.default_rng(seed)
    m, k = int(rng.integers(1, 6)), int(rng.integers(1, 6))
    costs = rng.random((m, k))
    costs[rng.random((m, k)) < 0.2] = np.inf
    costs[np.arange(m), rng.integers(0, k, m)] = rng.random(m)
    cross = rng.random(m - 1) * rng.choice([0.05, 0.5])
    bends, change = rng.normal(size=(m, k, 3)), float(rng.choice([0.0, 0.2, 1.0]))
    reach = rng.integers(0, 4, m - 1)
    found = track_crease(costs, cross, bends, change, reach)
    best = min(
        price(rows, costs, cross, bends, change, reach) for rows in product(range(k), repeat=m)
    )
    assert found.cost == pytest.approx(best)
    own = price(tuple(found.rows.tolist()), costs, cross, bends, change, reach)
    assert own == pytest.approx(best)


def test_without_a_price_of_change_it_is_the_cut() -> None:
    rng = np.random.default_rng(2)
    costs, cross = rng.random((30, 40)), 0.1 * rng.random(29)
    found = track_crease(costs, cross, rng.normal(size=(30, 40, 3)), 0.0, np.full(29, 40))
    plain = cut(costs, cross)
    assert (found.rows == plain.rows).all() and found.cost == pytest.approx(plain.cost)


def test_a_negative_price_is_told() -> None:
    with pytest.raises(InvalidFeatureError, match="price of another crease is -1"):
        track_crease(np.ones((2, 2)), 0.1, np.zeros((2, 2, 3)), -1.0, np.ones(1, np.int64))


#: Where the two creases of a terrace are, in y: a strong one and a weak one beside it.
STRONG, WEAK = 0.0, 0.08


def terrace() -> Surface:
    """Sheets along x that bend by 70 degrees at STRONG, and by 25 the same way at WEAK."""
    y = np.array([-0.1, STRONG, WEAK, 1.0])
    rises = np.tan(np.radians([85.0, 15.0, -10.0])) * np.diff(y)
    z = np.r_[0.0, np.cumsum(rises)] - rises[0]
    x = np.linspace(0.0, 4.0, 41)
    points = np.array([(a, b, c) for a in x for b, c in zip(y, z, strict=True)])
    i, j = np.meshgrid(np.arange(40), np.arange(3), indexing="ij")
    a = (4 * i + j).ravel()
    return Surface.from_soup(
        PolygonMesh.from_faces(
            points, np.concatenate([np.c_[a, a + 4, a + 1], np.c_[a + 1, a + 4, a + 5]])
        )
    )


def beside(model: Surface) -> Points:
    """A stroke along the weak crease that is drawn nearer to the strong one."""
    x = np.linspace(0.4, 2.2, 6)
    above = np.stack([x, np.full(6, 0.03), np.full(6, 3.0)], axis=1)
    return model.cast_rays(above, np.tile([0.0, 0.0, -1.0], (6, 1))).points


@pytest.mark.parametrize("at", [0.5, 0.2])
def test_one_pin_brings_the_whole_curve_to_its_crease(at: float) -> None:
    """The curve jumped to the stronger neighbour; a pin on the weak one mends all of it, when it is
    given at once and when it is dragged there."""
    model = terrace()
    rough = beside(model)
    begun = Snap.begin(model, rough)
    m = len(begun.curve.samples)
    assert np.abs(begun.curve.spline.sample(100)[:, 1] - STRONG).mean() < 0.01
    sample = int(at * m)
    x = begun.curve.samples[sample, 0]
    height = float(model.vertices[np.abs(model.vertices[:, 1] - WEAK) < 1e-9][0, 2])
    pin = [(sample, np.array([x, WEAK, height]))]
    for curve in (
        snap(model, rough, constraints=pin),
        begun.with_constraints(pin).again().curve,
    ):
        assert np.abs(curve.spline.sample(100)[5:-5, 1] - WEAK).max() < 0.01
    # The paper's cut leaves the crease beside the pin.
    plain = snap(model, rough, SnapSettings(continuity=0.0), constraints=pin)
    assert np.abs(plain.spline.sample(100)[5:-5, 1] - WEAK).max() > 0.04


def test_a_pin_on_no_crease_is_met_all_the_same() -> None:
    model = terrace()
    rough = beside(model)
    place = model.nearest(np.array([[2.0, 0.5, 0.0]])).points[0]
    found = snap(model, rough, constraints=[(20, place)])
    on = found.spline.evaluate(found.parameters[[20]])[0]
    assert np.linalg.norm(on - place) < 1e-9
