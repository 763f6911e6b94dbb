"""Whole patches as meshes: pieces that share their chords, without gaps or T-joints."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike

from patterndb_sketch.curvenetwork.network import Curve, CurveNetwork, Cycle, InvalidNetworkError
from patterndb_sketch.surfacing.sampling import (
    loop_of,
    sample,
)
from patterndb_sketch.surfacing.tessellation import (
    find_self_intersections,
    patch_of_least_area,
    tessellate_patch,
)
from tests.support.surfacing.networkfiles import CLOSED
from tests.support.surfacing.tessellation import as_loop, check_disk, chorded, wobbly

NO_CHORDS = np.zeros((0, 2), int)


def around(piece: list[int], along: dict[tuple[int, int], list[int]]) -> list[int]:
    """The vertices around a piece, given those along every chord."""
    result: list[int] = []
    for a, b in zip(piece, piece[1:] + piece[:1], strict=True):
        result += [a, *along.get((a, b), [])]
    return result


class TestPieces:
    @settings(max_examples=60, deadline=None)
    @given(
        st.integers(4, 60),
        st.integers(0, 12),
        st.integers(0, 2**32),
        st.sampled_from([0.0, 0.05, 0.3]),
        st.sampled_from([0.1, 0.3]),
        st.booleans(),
    )
    def test_pieces_are_disks_that_share_their_chords(
        self, n: int, wanted: int, seed: int, noise: float, spacing: float, coarse: bool
    ) -> None:
        drawn = wobbly(n, seed, noise)
        # Rounded, many points are in one line, and some at one place.
        loop = as_loop(np.round(drawn, 1) if coarse else drawn)
        chords, pieces = chorded(n, wanted, seed)
        mesh = tessellate_patch(loop, np.array(chords).reshape(-1, 2), pieces, spacing)
        points = mesh.vertices(loop)
        assert (points[:n] == loop.points).all()
        # The vertices along chords come first, chord by chord, straight and evenly spaced.
        along: dict[tuple[int, int], list[int]] = {}
        count = n
        for a, b in chords:
            ends = loop.points[[a, b]]
            length = float(np.linalg.norm(ends[1] - ends[0]))
            edges = max(1, round(length / spacing))
            names = list(range(count, count + edges - 1))
            shares = np.arange(1, edges)[:, None] / edges
            assert points[names] == pytest.approx(ends[0] + shares * (ends[1] - ends[0]))
            along[a, b], along[b, a] = names, names[::-1]
            count += len(names)
        # Every piece is one disk around its part of the loop and its chords.
        for piece, faces in zip(pieces, mesh.faces, strict=True):
            check_disk(faces, around(piece, along))
        # Together they are one disk around the loop: watertight, and so without T-joints.
        check_disk(mesh.triangles, list(range(n)))
        assert set(mesh.triangles.ravel().tolist()) == set(range(len(points)))
        assert len(mesh.methods) == len(pieces)
        given_up = sum(method == "area" for method in mesh.methods)
        assert len(mesh.notes) == given_up

    @pytest.mark.parametrize("seed", range(20))
    def test_in_one_line_pieces_do_not_join_the_same_points_of_a_chord(self, seed: int) -> None:
        # Where nothing has area, triangles along a chord cost nothing on either side of it.
        chance = np.random.default_rng(seed)
        loop = as_loop(np.outer(chance.uniform(size=9), [3.0, 4.0, 5.0]))
        chords, pieces = chorded(9, 4, seed)
        mesh = tessellate_patch(loop, np.array(chords).reshape(-1, 2), pieces, 0.3)
        assert len(mesh.points) and set(mesh.methods) <= {"area", "laplacian"}
        check_disk(mesh.triangles, list(range(9)))

    def test_notes_name_the_piece(self) -> None:
        turn = 4.0 * np.pi * np.arange(40) / 40
        radius = 1.0 + 0.3 * np.cos(turn / 2.0)
        points = np.stack(
            [radius * np.cos(turn), radius * np.sin(turn), 0.3 * np.sin(turn / 2.0)], axis=1
        )
        pieces = [[0, 1, 2], [0, *range(2, 40)]]
        mesh = tessellate_patch(as_loop(points), np.array([[0, 2]]), pieces, 0.2)
        assert mesh.methods == ("laplacian", "area")
        assert len(mesh.notes) == 1 and mesh.notes[0].startswith("piece 1: ")


@cache
def read_closed(path: Path) -> CurveNetwork:
    """A closed network, Euler characteristic 2."""
    read = json.loads(path.read_text())
    nodes = np.array(read["nodes"], float)
    curves: list[Curve] = []
    for number, curve in enumerate(read["curves"]):
        points = np.array(curve["points"], float)
        points[0], points[-1] = nodes[curve["nodes"]]
        curves.append(Curve(points, tuple(curve["nodes"]), number, number))
    cycles = [
        Cycle(tuple((step["curve"], step["reversed"]) for step in cycle))
        for cycle in read["cycles"]
    ]
    return CurveNetwork(tuple(curves), nodes, tuple(cycles))


@pytest.mark.parametrize("method", ["laplacian", "area"])
@pytest.mark.parametrize("path", CLOSED, ids=lambda path: path.stem)
def test_the_patches_of_a_closed_network_are_a_closed_surface(path: Path, method: str) -> None:
    network = read_closed(path)
    sampling = sample(network)
    points = [sampling.points]
    faces: list[np.ndarray] = []
    count = len(sampling.points)
    for cycle in network.cycles:
        loop = loop_of(network, sampling, cycle)
        n = len(loop.points)
        if method == "area":
            mesh = patch_of_least_area(loop)
        else:
            mesh = tessellate_patch(loop, NO_CHORDS, [np.arange(n)], sampling.spacing)
            assert mesh.methods == ("laplacian",)
        names = np.concatenate([loop.vertices, count + np.arange(len(mesh.points))])
        faces.append(names[mesh.triangles])
        points.append(mesh.points)
        count += len(mesh.points)
    triangles = np.concatenate(faces)
    sides = Counter(
        (min(t[e], t[(e + 1) % 3]), max(t[e], t[(e + 1) % 3]))
        for t in triangles.tolist()
        for e in range(3)
    )
    assert set(sides.values()) == {2}
    assert count - len(sides) + len(triangles) == 2
    if method == "laplacian":
        assert len(find_self_intersections(np.concatenate(points), triangles)) == 0


class TestRefused:
    LOOP = as_loop(wobbly(8, 0, 0.0))
    WHOLE = (tuple(range(8)),)

    def refuse(self, message: str, chords: list[list[int]], pieces: Sequence[ArrayLike]) -> None:
        with pytest.raises(InvalidNetworkError, match=message):
            tessellate_patch(self.LOOP, np.array(chords, int).reshape(-1, 2), pieces, 0.3)

    def test_pieces(self) -> None:
        self.refuse("a piece is missing", [[0, 4]], self.WHOLE)
        self.refuse("a piece is missing", [[0, 4]], [[0, 1, 2, 3, 4]])
        self.refuse("neither an edge", [], [[0, 1, 2, 3, 4], [4, 5, 6, 7, 0]])
        self.refuse("the loop's sense", [[0, 4]], [[4, 3, 2, 1, 0], [4, 5, 6, 7, 0]])
        self.refuse("another piece", [], [range(8), range(8)])

    def test_spacing(self) -> None:
        with pytest.raises(InvalidNetworkError, match="above 0"):
            tessellate_patch(self.LOOP, NO_CHORDS, self.WHOLE, 0.0)
