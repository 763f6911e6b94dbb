"""Curve networks drawn for the tests, in every format, and what writes them.

``python -m tests.support.surfacing.sketches`` writes tests/data/networks: closed networks whose
patches are known (JSON, and as patches: ``.sdm``), loops of B-splines (``.lop``), graphs of strokes
with patches recorded (``graphs/*.json``), and lists of strokes (``strokes/*.curves``).
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations, product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.support.shared import DATA

FOLDER = DATA / "networks"

Points = NDArray[np.float64]

#: Points of a curve in a network file.
SAMPLES = 13

#: Decimals of a coordinate.
DECIMALS = 5


@dataclass(frozen=True, slots=True)
class Solid:
    """A closed surface: corners (N, 3), a quadratic Bezier for every edge, and faces.

    middles: (E, 3) the inner control points. faces: corners counter-clockwise from outside.
    """

    corners: Points
    edges: list[tuple[int, int]]
    middles: Points
    faces: list[list[int]]

    def controls(self, edge: int) -> Points:
        """Return the (3, 3) control points of an edge."""
        a, b = self.edges[edge]
        return np.stack([self.corners[a], self.middles[edge], self.corners[b]])

    def steps(self, face: list[int]) -> list[tuple[int, bool]]:
        """Return the edges around a face, each with whether it is walked backward."""
        number = {edge: i for i, edge in enumerate(self.edges)}
        pairs = zip(face, face[1:] + face[:1], strict=True)
        return [(number[min(a, b), max(a, b)], a > b) for a, b in pairs]


def make_ball() -> Solid:
    """Draw a rhombicuboctahedron on a sphere: 24 corners, 48 arcs, 8 triangles and 18 squares."""
    far = 1.0 + math.sqrt(2.0)
    kinds = sorted(set(permutations((1.0, 1.0, far))))
    corners = np.array([np.multiply(k, s) for k in kinds for s in product((-1, 1), repeat=3)])
    return _round_off(corners * 5.0, list_edges(corners, 2.0))


def make_gem() -> Solid:
    """Draw a truncated octahedron on a sphere: 24 corners, 36 arcs, 6 squares and 8 hexagons."""
    corners = np.array(
        [
            p
            for k in product((-1, 1), repeat=2)
            for p in sorted(set(permutations((0, k[0], 2 * k[1]))))
        ]
    )
    corners = np.unique(corners, axis=0).astype(float)
    return _round_off(corners * 3.0, list_edges(corners, math.sqrt(2.0)))


def make_corner() -> Solid:
    """Draw a cube without one octant, its edges bent: not convex, 6 squares and 3 L-shapes."""
    places = [p for p in product((0, 1, 2), repeat=3) if _is_corner(p)]
    number: dict[tuple[int, ...], int] = {p: i for i, p in enumerate(places)}
    loops = [
        [(0, 0, 0), (0, 2, 0), (2, 2, 0), (2, 0, 0)],
        [(1, 1, 1), (2, 1, 1), (2, 2, 1), (1, 2, 1)],
        [(0, 0, 2), (2, 0, 2), (2, 1, 2), (1, 1, 2), (1, 2, 2), (0, 2, 2)],
    ]
    # The other two of each kind: axes in turn.
    faces = [[number[p[-k:] + p[:-k]] for p in loop] for loop in loops for k in range(3)]
    edges = sorted(
        {(min(a, b), max(a, b)) for f in faces for a, b in zip(f, f[1:] + f[:1], strict=True)}
    )
    corners = np.array(places, float) * 5.0
    middles = np.array([corners[[a, b]].mean(axis=0) for a, b in edges])
    away = middles - np.array([4.0, 4.0, 4.0])
    middles += 0.8 * away / np.linalg.norm(away, axis=1)[:, None]
    return Solid(corners, edges, middles, faces)


def _is_corner(place: tuple[int, ...]) -> bool:
    """Is this a corner of the cube from 0 to 2 without the octant of the largest?"""
    ones = place.count(1)
    return (
        (ones == 0 and place != (2, 2, 2)) or ones == 3 or (ones in (1, 2) and place.count(0) == 0)
    )


def list_edges(corners: Points, length: float) -> list[tuple[int, int]]:
    """Return the pairs of corners that are so far apart."""
    apart = np.linalg.norm(corners[:, None] - corners[None], axis=2)
    return [(a, b) for a, b in np.argwhere(np.abs(apart - length) < 1e-9).tolist() if a < b]


def _round_off(corners: Points, edges: list[tuple[int, int]]) -> Solid:
    """Bend the edges of a convex polyhedron about the origin to arcs, and find its faces."""
    radius = float(np.linalg.norm(corners[0]))
    chords = np.array([corners[[a, b]].mean(axis=0) for a, b in edges])
    tops = radius * chords / np.linalg.norm(chords, axis=1)[:, None]
    after: dict[tuple[int, int], int] = {}
    for a, at in enumerate(corners):
        others = [c for edge in edges if a in edge for c in edge if c != a]
        east = np.cross(at, corners[others[0]])
        north = np.cross(at, east)
        turn = [math.atan2(float(corners[b] @ north), float(corners[b] @ east)) for b in others]
        around = [b for _, b in sorted(zip(turn, others, strict=True))]
        # Whoever comes from b leaves to the neighbour clockwise of it.
        after |= {(b, a): around[i - 1] for i, b in enumerate(around)}
    faces: list[list[int]] = []
    left = set(after)
    while left:
        first = a, b = min(left)
        face: list[int] = []
        while (a, b) in left:
            left.remove((a, b))
            face.append(a)
            a, b = b, after[a, b]
        assert (a, b) == first
        faces.append(face)
    return Solid(corners, edges, 2.0 * tops - chords, faces)


#: The closed networks by name.
SOLIDS = {"ball": make_ball, "corner": make_corner, "gem": make_gem}


def bend(controls: Points, n: int) -> Points:
    """Return n points of a Bezier curve of any degree, evenly in its parameter."""
    t = np.linspace(0.0, 1.0, n)[:, None]
    points = np.repeat(controls[None], n, axis=0)
    while points.shape[1] > 1:
        points = (1 - t[:, None]) * points[:, :-1] + t[:, None] * points[:, 1:]
    return points[:, 0]


def _written(points: Points) -> list[Any]:
    return (np.round(points, DECIMALS) + 0.0).tolist()


def list_network(solid: Solid) -> dict[str, Any]:
    """Return a solid as the document of a network."""
    curves = [
        {
            "id": i,
            "nodes": list(edge),
            "bezier": _written(solid.controls(i)),
            "points": _written(bend(solid.controls(i), SAMPLES)),
        }
        for i, edge in enumerate(solid.edges)
    ]
    cycles = [[{"curve": c, "reversed": r} for c, r in solid.steps(f)] for f in solid.faces]
    return {"nodes": _written(solid.corners), "curves": curves, "cycles": cycles}


def format_patches(solid: Solid) -> str:
    """Return a solid as patches: corners, control points between them and one in the middle."""
    lines = [str(len(solid.faces))]
    for face in solid.faces:
        corners = solid.corners[face]
        # The first lies before the first corner.
        middles = solid.middles[[edge for edge, _ in solid.steps(face[-1:] + face[:-1])]]
        lines.append(str(len(face)))
        lines += [_row(p) for p in (*corners, *middles, middles.mean(axis=0))]
    return "\n".join(lines) + "\n"


def _row(point: Sequence[float] | Points) -> str:
    return " ".join(f"{x + 0.0:.{DECIMALS}f}".rstrip("0").rstrip(".") for x in np.round(point, 5))


def format_loop(n_sides: int) -> str:
    """Return a loop of cubic B-splines, each with an inner knot, around a wavy disk."""
    lines = [str(n_sides)]
    for side in range(n_sides):
        share = 0.3 + 0.1 * side
        knots = [0, 0, 0, 0, share, 1, 1, 1, 1]
        turn = 2.0 * np.pi * (side + np.array([0.0, 0.15, 0.5, 0.8, 1.0])) / n_sides
        reach = 40.0 * np.array([1.0, 1.1, 0.9, 1.05, 1.0])
        control = np.c_[reach * np.cos(turn), reach * np.sin(turn), 8.0 * np.sin(2.0 * turn)]
        lines += ["3", f"{len(knots)} " + " ".join(map(str, knots))]
        lines.append(f"{len(control)} " + " ".join(map(_row, control)))
    return "\n".join(lines) + "\n"


def make_graph(solid: Solid, seed: int) -> dict[str, Any]:
    """Return a solid as a graph of strokes, each of one to three edges that follow each other.

    Pieces are a little off the arcs. Every patch is recorded by its strokes, and one as deleted.
    """
    chance = np.random.default_rng(seed)
    size = float(np.ptp(solid.corners, axis=0).max())
    off = 0.01 * size
    left = list(range(len(solid.edges)))
    strokes: list[dict[str, Any]] = []
    segments: dict[int, dict[str, Any]] = {}
    of_edge: dict[int, int] = {}
    while left:
        edge = left.pop(0)
        chain, end = [edge], solid.edges[edge][1]
        while len(chain) < 3:
            on = next((e for e in left if end in solid.edges[e]), None)
            if on is None:
                break
            left.remove(on)
            chain.append(on)
            end = sum(solid.edges[on]) - end
        at = solid.edges[edge][0]
        strokes.append({"id": len(strokes), "segments": chain})
        for e in chain:
            of_edge[e] = len(strokes) - 1
            nodes = list(solid.edges[e])
            controls = solid.controls(e)
            if nodes[0] != at:
                nodes, controls = nodes[::-1], controls[::-1]
            at = nodes[1]
            a, m, b = controls
            m = m + chance.normal(0.0, off, 3)
            cubic = np.stack([a, (a + 2 * m) / 3, (b + 2 * m) / 3, b])
            segments[e] = {
                "id": e,
                "stroke_id": of_edge[e],
                "ctrl_pts": [_written(cubic)],
                "nodes": nodes,
            }
    patches = [
        {"id": i, "by_algorithm": i % 3 > 0, "manually_deleted": False,
         "strokes": sorted({of_edge[e] for e, _ in solid.steps(face)})}
        for i, face in enumerate(solid.faces)
    ]  # fmt: skip
    patches.append({**patches[0], "id": len(patches), "manually_deleted": True, "strokes": [0, 1]})
    placed: list[dict[str, Any]] = []
    for i, place in enumerate(solid.corners):
        at = [edge for edge, ends in enumerate(solid.edges) if i in ends]
        placed.append({"id": i, "position": _written(place), "neighbor_edges": at})
    return {
        "strokes": strokes,
        "segments": [segments[e] for e in sorted(segments)],
        "nodes": placed,
        "patches_created": patches,
    }


def format_strokes(graph: dict[str, Any]) -> str:
    """Return the strokes of a graph as a list of polylines, each a little off its place."""
    places = np.array([node["position"] for node in graph["nodes"]])
    chance = np.random.default_rng(len(places))
    off = 0.003 * float(np.ptp(places, axis=0).max())
    of = {segment["id"]: segment for segment in graph["segments"]}
    lines: list[str] = []
    for stroke in graph["strokes"]:
        pieces = [bend(np.array(of[s]["ctrl_pts"][0]), 12) for s in stroke["segments"]]
        points = np.concatenate(pieces) + chance.normal(0.0, off, 3)
        lines += [f"v {len(points)}", *(" ".join(f"{x:.5f}" for x in p) for p in points)]
    return "\n".join(lines) + "\n"


def list_files() -> dict[str, str]:
    """Return the texts of all files by their paths below the folder."""
    files: dict[str, str] = {}
    for seed, (name, make) in enumerate(SOLIDS.items()):
        solid = make()
        graph = make_graph(solid, seed)
        files[f"{name}.json"] = json.dumps(list_network(solid), indent=None) + "\n"
        files[f"{name}.sdm"] = format_patches(solid)
        files[f"graphs/{name}.json"] = json.dumps(graph) + "\n"
        files[f"strokes/{name}.curves"] = format_strokes(graph)
    return files | {f"loop{n}.lop": format_loop(n) for n in (3, 4, 6)}


if __name__ == "__main__":
    for path, text in list_files().items():
        (FOLDER / path).parent.mkdir(parents=True, exist_ok=True)
        (FOLDER / path).write_text(text, "ascii")
