"""Normals along curves: carried to the network, kept by files, followed by patches."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from patterndb_sketch.curvenetwork.network import InvalidNetworkError
from patterndb_sketch.surfacing import Surfacing, find_cycles, surface, write_network
from patterndb_sketch.surfacing.networkfile import read_network


def octant(n: int, tilt: float = 0.0, sense: float = 1.0) -> dict[str, object]:
    """Eight octants of a ball by three great circles, with normals that lean by so much."""
    t = 2 * np.pi * np.arange(n + 1) / n + 0.1
    t[-1] = t[0]
    flat = np.stack([np.cos(t), np.sin(t), 0 * t], axis=1)
    curves = []
    for k, name in enumerate("abc"):
        points = np.roll(flat, k, axis=1)
        normals = sense * (points + tilt * np.roll([0.0, 0.0, 1.0], k))
        curves.append({"id": name, "points": points.tolist(), "normals": normals.tolist()})
    return {"curves": curves}


def write(path: Path, document: object) -> Path:
    path.write_text(json.dumps(document))
    return path


def bump(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """A hill over a square whose sides bend by a fifth of its height."""
    return 0.1 * (x**2 - y**2) + 0.5 * (1 - x**2) * (1 - y**2)


def hill(sense: float) -> dict[str, object]:
    """The four sides of the hill, with its normals."""
    t = np.linspace(-1, 1, 41)
    one = np.ones_like(t)
    curves = []
    for name, x, y in (("s", t, -one), ("e", one, t), ("n", -t, one), ("w", -one, -t)):
        slope_x = 0.2 * x - x * (1 - y**2)
        slope_y = -0.2 * y - y * (1 - x**2)
        normals = sense * np.stack([-slope_x, -slope_y, one], axis=1)
        points = np.stack([x, y, bump(x, y)], axis=1)
        curves.append({"id": name, "points": points.tolist(), "normals": normals.tolist()})
    return {"curves": curves}


def measure_gap(made: Surfacing) -> float:
    """The mean height of inner vertices above or below the hill."""
    x, y, z = made.points[len(made.sampling.points) :].T
    return float(np.abs(z - bump(x, y)).mean())


@pytest.mark.parametrize("sense", [1.0, -2.5])
def test_patches_leave_curves_as_the_normals_have_it(tmp_path: Path, sense: float) -> None:
    document = hill(sense)
    network = read_network(write(tmp_path / "hill.json", document))
    guided = surface(network, find_cycles(network).cycles)
    assert any("normals followed along 4 of 4" in note for note in guided.notes)
    for curve in document["curves"]:  # pyright: ignore[reportGeneralTypeIssues]
        del curve["normals"]
    plain = read_network(write(tmp_path / "plain.json", document))
    without = surface(plain, find_cycles(plain).cycles)
    assert not without.notes
    assert measure_gap(guided) < 0.5 * measure_gap(without)
    n = len(without.sampling.points)
    assert np.array_equal(guided.points[:n], without.points[:n])


@pytest.mark.parametrize("sense", [1.0, -2.5])
def test_normals_go_with_curves_that_are_cut(tmp_path: Path, sense: float) -> None:
    document = octant(60, sense=sense)
    network = read_network(write(tmp_path / "ball.json", document))
    assert len(network.curves) == 12
    for curve in network.curves:
        assert curve.normals is not None
        lengths = np.linalg.norm(curve.normals, axis=1)
        assert np.allclose(lengths, 1.0)
        # Cut at nodes between samples: as the ball's own there, too.
        radial = curve.points / np.linalg.norm(curve.points, axis=1, keepdims=True)
        assert np.allclose(curve.normals * np.sign(sense), radial, atol=5e-3)
    made = surface(network, find_cycles(network).cycles)
    assert len(made.patches) == 8
    assert any("normals followed along 12 of 12" in note for note in made.notes)


def test_files_keep_normals(tmp_path: Path) -> None:
    network = read_network(write(tmp_path / "ball.json", octant(24, tilt=0.3)))
    write_network(tmp_path / "again.json", network)
    again = read_network(tmp_path / "again.json")
    for one, two in zip(network.curves, again.curves, strict=True):
        assert one.normals is not None and two.normals is not None
        assert np.allclose(one.normals, two.normals, atol=1e-15)


@pytest.mark.parametrize(
    ("normals", "what"),
    [
        ([[0, 0, 1]], "2 points and 1 normals"),
        ([[0, 0, 1], [0, 0, 0]], "normal 1 of curve 'a'.*no direction"),
        ([[0, 0, 1], [0, 0, "up"]], r"curves\[0\]"),
    ],
)
def test_what_are_no_normals_is_refused(tmp_path: Path, normals: object, what: str) -> None:
    document = {"curves": [{"id": "a", "points": [[0, 0, 0], [1, 0, 0]], "normals": normals}]}
    with pytest.raises(InvalidNetworkError, match=what):
        read_network(write(tmp_path / "a.json", document))
