"""Every method of the table surfaces loops and networks; a new one is found by itself."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import patterndb
from patterndb.geometry.points import Points
from patterndb_sketch.curvenetwork.network import CurveNetwork, InvalidNetworkError
from patterndb_sketch.surfacing.methods import (
    DEFAULT_METHOD,
    METHODS,
    SurfaceRequest,
    SurfacingMethod,
    describe_methods,
)
from patterndb_sketch.surfacing.patch import as_triangles
from patterndb_sketch.surfacing.surfaces import surface, surface_loop
from tests.support.shared import CHECKOUT
from tests.support.surfacing.networks import cube, prism, torus
from tests.support.surfacing.quads import assert_closed, assert_disk_within
from tests.support.surfacing.tessellation import as_loop
from viewer.surfacing.commands import COMMANDS


def around(n: int, radius: object = 1.0, height: object = 0.0) -> Points:
    """A closed polyline of n points around the z axis."""
    angle = 2.0 * np.pi * np.arange(n) / n
    across = np.asarray(radius) * np.array([np.cos(angle), np.sin(angle)])
    return np.stack([*across, np.broadcast_to(height, n)], axis=1).astype(float)


def standard_loops() -> dict[str, Points]:
    """Loops of an even number of vertices, as quads need it: flat, bent, concave, crossing."""
    angle = 2.0 * np.pi * np.arange(24) / 24
    side = np.linspace(0.0, 1.0, 4, endpoint=False)
    flat = np.zeros(4)
    square = np.concatenate(
        [
            np.stack([side, flat, flat], axis=1),
            np.stack([flat + 1.0, side, flat], axis=1),
            np.stack([1.0 - side, flat + 1.0, flat], axis=1),
            np.stack([flat, 1.0 - side, flat], axis=1),
        ]
    )
    figure = np.stack([np.sin(angle), np.sin(2.0 * angle), 0.3 * np.cos(angle)], axis=1)
    return {
        "circle": around(16),
        "square": square,
        "saddle": around(24, 1.0, 0.5 * np.cos(2.0 * angle)),
        "star": around(24, 1.0 + 0.3 * np.cos(5.0 * angle)),
        "ribbon": around(24, 1.0, np.cos(3.0 * angle)),
        "eight": figure,
    }


@pytest.fixture(scope="module")
def db() -> patterndb.Database:
    return patterndb.open(None)


@pytest.mark.parametrize("name", list(standard_loops()))
@pytest.mark.parametrize("method", METHODS.values(), ids=list(METHODS))
def test_a_loop_becomes_a_disk_with_exactly_its_boundary(
    method: SurfacingMethod, name: str, db: patterndb.Database
) -> None:
    points = standard_loops()[name]
    loop = as_loop(points)
    made = surface_loop(loop, SurfaceRequest(method=method.name), 0.3, db)
    assert made.method in METHODS
    # Another method may stand in, and says why.
    assert made.method == method.name or made.note
    faces = as_triangles(made.faces)
    assert_disk_within(len(points), faces)
    assert faces.max() < len(points) + len(made.points)
    assert np.isfinite(made.points).all()
    assert np.array_equal(loop.points, points)
    if METHODS[made.method].makes_quads:
        assert {piece.shape[1] for piece in made.faces} == {4}


@pytest.mark.parametrize("method", METHODS.values(), ids=list(METHODS))
@pytest.mark.parametrize(
    ("network", "euler"), [(cube(), 2), (prism(), 2), (torus(), 0)], ids=["cube", "prism", "torus"]
)
def test_a_closed_network_becomes_a_watertight_surface(
    method: SurfacingMethod, network: CurveNetwork, euler: int, db: patterndb.Database
) -> None:
    made = surface(network, method=method.name, db=db)
    assert [patch.method for patch in made.patches] == [method.name] * len(network.cycles)
    assert_closed(made.triangles, euler)
    assert np.array_equal(made.points[: len(made.sampling.points)], made.sampling.points)


@pytest.mark.parametrize("method", METHODS.values(), ids=list(METHODS))
def test_what_a_method_needs_is_asked_for(method: SurfacingMethod) -> None:
    if method.needs_database:
        with pytest.raises(InvalidNetworkError, match=f"{method.name} come from a pattern"):
            surface(cube(), method=method.name)
        lone = surface_loop(as_loop(around(16)), SurfaceRequest(method=method.name), 0.3)
        assert lone.method != method.name
    else:
        made = surface(cube(), method=method.name)
        assert {patch.method for patch in made.patches} == {method.name}


def test_the_table_names_its_methods() -> None:
    assert list(METHODS) == [method.name for method in METHODS.values()]
    assert SurfaceRequest().method == DEFAULT_METHOD
    assert not METHODS[DEFAULT_METHOD].needs_database
    with pytest.raises(InvalidNetworkError, match=f"there are {', '.join(METHODS)}"):
        SurfaceRequest(method="none of them")


@pytest.mark.parametrize("method", METHODS.values(), ids=list(METHODS))
def test_all_who_offer_a_choice_offer_every_method(method: SurfacingMethod) -> None:
    assert method.help in describe_methods().lower()
    assert method.name in next(one.tip for one in COMMANDS if "m" in one.keys)
    options = Path(CHECKOUT, "docs", "cli.md").read_text().split("\n| `--method ", 1)[1]
    assert method.name in options.split("`", 1)[0].split("\\|")
    assert f"\n| `{method.name}` |" in Path(CHECKOUT, "docs", "surfacing.md").read_text()
