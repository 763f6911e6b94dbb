"""The example meshes: the code makes what is committed, and each is what it is said to be."""

from __future__ import annotations

import json
import subprocess
import sys
from collections import Counter
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.support.shared import EXAMPLES

SAME_PLACE = 1e-3
"""How far, in centimetres, platforms may differ: ten units of the last decimal."""

LEAST_SINE = 0.01
"""The least sine of a corner's angle, seen along the normal: below it a quad counts as folded."""


@dataclass(frozen=True, slots=True)
class Expected:
    """What holds for one file: ranges are inclusive, ``irregular`` and ``six`` bounds,
    ``mirror`` the coordinate that the mirror changes."""

    quads: tuple[int, int]
    euler: int
    openings: int
    irregular: int
    six: int
    mirror: int | None


EXPECTED = {
    "head": Expected((400, 900), euler=1, openings=1, irregular=64, six=2, mirror=0),
    "hand": Expected((250, 500), euler=1, openings=1, irregular=52, six=0, mirror=None),
    "jug": Expected((200, 500), euler=0, openings=0, irregular=16, six=0, mirror=1),
    "dog": Expected((250, 600), euler=2, openings=0, irregular=86, six=2, mirror=0),
}


@dataclass(frozen=True, slots=True)
class Obj:
    """The points (n, 3) and quads (m, 4) of a file, and its leading comment."""

    points: NDArray[np.float64]
    quads: NDArray[np.int64]
    comment: str


def read(path: Path) -> Obj:
    """Reads the plain OBJ files the examples are."""
    lines = path.read_text(encoding="ascii").splitlines()
    faces = [[int(t) - 1 for t in line.split()[1:]] for line in lines if line.startswith("f ")]
    assert {len(face) for face in faces} == {4}, "a face is no quad"
    points = [[float(t) for t in line.split()[1:]] for line in lines if line.startswith("v ")]
    comment = "\n".join(line for line in lines if line.startswith("#"))
    assert lines[0].startswith("# ")
    return Obj(np.array(points), np.array(faces), comment)


def directed_edges(quads: NDArray[np.int64]) -> list[tuple[int, int]]:
    """Every quad's edges in its own direction."""
    return [(int(a), int(b)) for q in quads for a, b in pairwise([*q, q[0]])]


@pytest.fixture(params=sorted(EXPECTED))
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def mesh(name: str) -> Obj:
    return read(EXAMPLES / f"{name}.obj")


@pytest.fixture(scope="module")
def regenerated(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Two directories, each written by its own run of the script."""
    out = [tmp_path_factory.mktemp("first"), tmp_path_factory.mktemp("second")]
    for directory in out:
        script = [sys.executable, str(EXAMPLES / "make_examples.py"), "--out", str(directory)]
        subprocess.run(script, check=True, capture_output=True)
    return out


def test_every_file_is_expected() -> None:
    assert {path.stem for path in EXAMPLES.glob("*.obj")} == set(EXPECTED)


def test_regenerating_gives_the_committed_file(
    regenerated: list[Path], name: str, mesh: Obj
) -> None:
    first, second = (directory / f"{name}.obj" for directory in regenerated)
    assert first.read_bytes() == second.read_bytes()
    again = read(first)
    assert again.comment == mesh.comment
    np.testing.assert_array_equal(again.quads, mesh.quads)
    np.testing.assert_allclose(again.points, mesh.points, rtol=0, atol=SAME_PLACE)


def test_regenerating_gives_the_committed_network(regenerated: list[Path]) -> None:
    first, second = (directory / "networks" / "teacup.json" for directory in regenerated)
    assert first.read_bytes() == second.read_bytes()
    again = json.loads(first.read_text(encoding="ascii"))
    committed = json.loads((EXAMPLES / "networks" / "teacup.json").read_text(encoding="ascii"))
    assert again["stages"] == committed["stages"]
    for ours, theirs in zip(again["curves"], committed["curves"], strict=True):
        assert ours["id"] == theirs["id"]
        np.testing.assert_allclose(ours["points"], theirs["points"], rtol=0, atol=SAME_PLACE)


def test_the_comment_says_what_it_is(mesh: Obj) -> None:
    assert "make_examples.py" in mesh.comment
    assert "CC0-1.0" in mesh.comment


def test_manifold_and_consistently_oriented(name: str, mesh: Obj) -> None:
    n = len(mesh.points)
    assert EXPECTED[name].quads[0] <= len(mesh.quads) <= EXPECTED[name].quads[1]
    assert set(mesh.quads.ravel().tolist()) == set(range(n)), "an unused vertex"
    assert len(np.unique(mesh.points, axis=0)) == n, "two vertices in one place"
    assert len({frozenset(q) for q in mesh.quads.tolist()}) == len(mesh.quads), "a quad twice"
    assert all(len(set(q)) == 4 for q in mesh.quads.tolist())
    # Each direction of an edge at most once: at most two quads, and these agree.
    assert max(Counter(directed_edges(mesh.quads)).values()) == 1
    # The quads at every vertex are one fan: following edges about it reaches them all.
    fans: dict[int, list[tuple[int, int]]] = {}
    for q in mesh.quads.tolist():
        for k, v in enumerate(q):
            fans.setdefault(v, []).append((q[k - 3], q[k - 1]))
    for links in fans.values():
        follow = dict(links)
        start = next(iter(set(follow) - set(follow.values())), links[0][0])
        seen, at = 0, start
        while at in follow:
            at = follow.pop(at)
            seen += 1
        assert seen == len(links)


def test_one_component_of_the_expected_topology(name: str, mesh: Obj) -> None:
    directed = set(directed_edges(mesh.quads))
    edges = {(min(e), max(e)) for e in directed}
    neighbours: dict[int, list[int]] = {}
    for a, b in edges:
        neighbours.setdefault(a, []).append(b)
        neighbours.setdefault(b, []).append(a)
    reached, todo = {0}, [0]
    while todo:
        fresh = set(neighbours[todo.pop()]) - reached
        reached |= fresh
        todo += fresh
    assert len(reached) == len(mesh.points)
    assert len(mesh.points) - len(edges) + len(mesh.quads) == EXPECTED[name].euler
    # A border vertex has one border edge out, so that the borders fall into loops.
    out = {a: b for a, b in directed if (b, a) not in directed}
    loops = 0
    while out:
        loops += 1
        at = next(iter(out))
        while at in out:
            at = out.pop(at)
    assert loops == EXPECTED[name].openings


def test_valences(name: str, mesh: Obj) -> None:
    directed = set(directed_edges(mesh.quads))
    border = {v for a, b in directed if (b, a) not in directed for v in (a, b)}
    edges = {(min(e), max(e)) for e in directed}
    valence = Counter(v for e in edges for v in e)
    inside = Counter(k for v, k in valence.items() if v not in border)
    assert set(inside) <= {3, 4, 5, 6}
    assert sum(inside.values()) - inside[4] <= EXPECTED[name].irregular
    assert inside[6] <= EXPECTED[name].six
    assert {valence[v] for v in border} <= {3}


def test_outward(name: str, mesh: Obj) -> None:
    """The volume enclosed is positive; an opening is closed by a fan from its middle."""
    triangles = [mesh.points[mesh.quads[:, c]] for c in ((0, 1, 2), (0, 2, 3))]
    directed = set(directed_edges(mesh.quads))
    border = [(b, a) for a, b in directed if (b, a) not in directed]
    if border:
        edge = mesh.points[np.array(border)]
        middle = np.broadcast_to(edge[:, 0].mean(axis=0), (len(edge), 1, 3))
        triangles.append(np.concatenate([edge, middle], axis=1))
    t = np.concatenate(triangles)
    assert np.linalg.det(t).sum() / 6 > 100.0  # cubic centimetres: the hand, the least, has 180


def test_no_quad_is_folded(mesh: Obj) -> None:
    """At every corner the edges turn left, seen along the quad's normal and along the vertex's."""
    p = mesh.points[mesh.quads]
    ahead, behind = np.roll(p, -1, axis=1) - p, np.roll(p, 1, axis=1) - p
    lengths = np.linalg.norm(ahead, axis=2)
    assert lengths.min() > 0.1  # centimetres
    corner = np.cross(ahead, behind) / (lengths * np.linalg.norm(behind, axis=2))[..., None]
    face = np.cross(p[:, 2] - p[:, 0], p[:, 3] - p[:, 1])
    face /= np.linalg.norm(face, axis=1, keepdims=True)
    vertex = np.zeros_like(mesh.points)
    np.add.at(vertex, mesh.quads, corner / np.linalg.norm(corner, axis=2, keepdims=True))
    vertex /= np.linalg.norm(vertex, axis=1, keepdims=True)
    assert (corner * face[:, None]).sum(axis=2).min() > LEAST_SINE
    assert (corner * vertex[mesh.quads]).sum(axis=2).min() > LEAST_SINE


@pytest.mark.parametrize("symmetric", [k for k, e in EXPECTED.items() if e.mirror is not None])
def test_symmetry(symmetric: str) -> None:
    """Points and quads go over into themselves in the mirror."""
    mesh = read(EXAMPLES / f"{symmetric}.obj")
    flip = np.where(np.arange(3) == EXPECTED[symmetric].mirror, -1.0, 1.0)
    distance = np.linalg.norm(mesh.points[:, None] - mesh.points[None] * flip, axis=2)
    image = distance.argmin(axis=1)
    assert distance.min(axis=1).max() < SAME_PLACE
    quads = {frozenset(q) for q in mesh.quads.tolist()}
    assert {frozenset(q) for q in image[mesh.quads].tolist()} == quads
