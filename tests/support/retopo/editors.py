"""Editors, and drawings made with them, for the tests of the editor and what stands around it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from patterndb_sketch.retopo.editor import Call, Outcome, Retopology
from patterndb_sketch.retopo.network import Network, check_network
from patterndb_sketch.retopo.sizes import Sizes
from query.engine import PatternSource
from tests.support.retopo.networks import plane, sphere

#: Cells of the grid have edges of 1, and so four edges each.
SIZES = Sizes(snap=0.1, spine=0.5, autocompletion=0.5, brush=0.5, edge=0.25, sampling=0.02)


def do(editor: Retopology, tool: str, **arguments: object) -> Outcome:
    """A call that must do something, and leave a sound network."""
    outcome = editor.do(Call(tool, arguments))
    assert outcome.refused is None, outcome
    check_network(editor.network)
    return outcome


def line(*points: tuple[float, float]) -> list[list[float]]:
    """Points of the plane."""
    return [[x, y, 0.0] for x, y in points]


def drawn_grid(source: PatternSource, n: int = 3) -> Retopology:
    """An editor on the plane with n x n square patches from (0, 0) on."""
    editor = Retopology(plane(), source, SIZES)
    for k in range(n + 1):
        do(editor, "stroke", points=line((k, 0), (k, n)))
    for k in range(n + 1):
        for j in range(n):
            do(editor, "stroke", points=line((j, k), (j + 1, k)))
    assert len(editor.network.patches) == n * n
    return editor


def drawn_octants(source: PatternSource) -> Retopology:
    """An editor on the unit sphere, cut by three planes into eight patches of three sides."""
    editor = Retopology(sphere(), source)
    for at, normal in (
        ([1.0, 0.02, 0.0], [0.0, 0.0, 1.0]),
        ([0.0, 1.0, 0.02], [1.0, 0.0, 0.0]),
        ([0.02, 0.0, 1.0], [0.0, 1.0, 0.0]),
    ):
        do(editor, "loop", at=at, normal=normal)
    assert len(editor.network.patches) == 8
    return editor


def chain_at(network: Network, x: float, y: float) -> int:
    """The chain of the plane's network whose middle is at a place."""
    away = {
        chain.id: float(np.linalg.norm(chain.points.mean(axis=0)[:2] - [x, y]))
        for chain in network.chains.values()
    }
    found = min(away, key=away.__getitem__)
    assert away[found] < 1e-3
    return found


def patch_around(network: Network, x: float, y: float) -> int:
    """The patch of the plane's network whose corners' mean is at a place."""
    for patch in network.patches.values():
        nodes = [network.nodes[network.origin(patch.loop[k])].point for k in patch.corners]
        if np.linalg.norm(np.mean(nodes, axis=0)[:2] - [x, y]) < 1e-3:
            return patch.id
    raise AssertionError(f"there is no patch around {x}, {y}")


def same_arrays(one: ArrayLike, two: ArrayLike) -> bool:
    """Are two arrays the same, bit for bit?"""
    a, b = np.asarray(one), np.asarray(two)
    return (a.dtype, a.shape) == (b.dtype, b.shape) and a.tobytes() == b.tobytes()
