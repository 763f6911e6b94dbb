"""The meshes that the page offers: a ball, a saddle, a head, a head with holes.

``scripts/build_page.py`` writes them into the bundle. Needs no package: a wheel is built where
nothing is installed. The heads are the repository's own examples (CC0-1.0).
"""

from __future__ import annotations

import math
from collections import defaultdict
from pathlib import Path

Vertex = tuple[float, float, float]
Mesh = tuple[list[Vertex], list[list[int]]]

ROOT = Path(__file__).resolve().parents[1]
HEAD = ROOT / "examples" / "head.obj"
HEAD_WITH_HOLES = ROOT / "docs" / "meshes" / "head.obj"

#: Quads along a side of the cube that becomes the ball, and along the saddle.
ALONG = 24


def write_examples(folder: Path) -> None:
    """Write all example meshes as OBJ into a folder, which is made."""
    folder.mkdir(parents=True, exist_ok=True)
    # The head is coarse: smoothed once, its outline looks as it is meant.
    meshes = {
        "ball": make_ball(ALONG),
        "saddle": make_saddle(2 * ALONG),
        "head": subdivide(read_obj(HEAD)),
        "head-holes": read_obj(HEAD_WITH_HOLES),
    }
    for name, mesh in meshes.items():
        (folder / f"{name}.obj").write_text(format_obj(mesh), encoding="utf-8")


def make_ball(along: int) -> Mesh:
    """Make a ball of radius 1: a cube whose sides are divided evenly by angle."""
    number: dict[Vertex, int] = {}
    faces: list[list[int]] = []
    for axis in range(3):
        for sign in (-1.0, 1.0):

            def corner(i: int, j: int, axis: int = axis, sign: float = sign) -> int:
                u, v = (math.tan(math.pi / 4 * (2 * k / along - 1)) for k in (i, j))
                # Both directions turn with the side, so that all quads face outwards.
                place = [0.0, 0.0, 0.0]
                place[axis], place[(axis + 1) % 3], place[(axis + 2) % 3] = sign, sign * u, v
                size = math.hypot(*place)
                x, y, z = (round(c / size, 6) + 0.0 for c in place)
                return number.setdefault((x, y, z), len(number))

            faces += [
                [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)]
                for i in range(along)
                for j in range(along)
            ]
    return list(number), faces


def make_saddle(along: int) -> Mesh:
    """Make the saddle z = (x² - y²) / 2 over the square from -1.2 to 1.2."""
    line = [1.2 * (2 * i / along - 1) for i in range(along + 1)]
    points = [(x, y, (x * x - y * y) / 2) for y in line for x in line]
    row = along + 1
    faces = [
        [j * row + i, j * row + i + 1, (j + 1) * row + i + 1, (j + 1) * row + i]
        for j in range(along)
        for i in range(along)
    ]
    return points, faces


def subdivide(mesh: Mesh) -> Mesh:
    """Subdivide polygons to quads by the rules of Catmull and Clark (1978), borders as curves."""
    points, faces = mesh
    beside: dict[tuple[int, int], list[int]] = defaultdict(list)
    around: dict[int, list[int]] = defaultdict(list)
    for f, face in enumerate(faces):
        for a, b in zip(face, [*face[1:], face[0]], strict=True):
            beside[min(a, b), max(a, b)].append(f)
            around[a].append(f)
    edges: dict[int, list[tuple[int, int]]] = defaultdict(list)
    for edge in beside:
        for v in edge:
            edges[v].append(edge)
    middles = [average([points[v] for v in face]) for face in faces]
    halves = {edge: average([points[v] for v in edge]) for edge in beside}
    moved: list[Vertex] = []
    for v, place in enumerate(points):
        border = [edge for edge in edges[v] if len(beside[edge]) == 1]
        n = len(edges[v])
        if border:
            moved.append(blend([(0.5, place), (0.5, average([halves[e] for e in border]))]))
        elif n == 0:
            moved.append(place)
        else:
            face_part = average([middles[f] for f in around[v]])
            edge_part = average([halves[edge] for edge in edges[v]])
            moved.append(blend([(1 / n, face_part), (2 / n, edge_part), (1 - 3 / n, place)]))
    number = {edge: len(points) + i for i, edge in enumerate(beside)}
    for edge, sides in beside.items():
        inner = [halves[edge], average([middles[f] for f in sides])]
        moved.append(halves[edge] if len(sides) == 1 else average(inner))
    first = len(moved)
    quads: list[list[int]] = []
    for f, face in enumerate(faces):
        for i, v in enumerate(face):
            before, after = face[i - 1], face[(i + 1) % len(face)]
            leave = number[min(v, after), max(v, after)]
            arrive = number[min(before, v), max(before, v)]
            quads.append([v, leave, first + f, arrive])
    return moved + middles, quads


def average(places: list[Vertex]) -> Vertex:
    """Find the mean of places."""
    return blend([(1 / len(places), place) for place in places])


def blend(parts: list[tuple[float, Vertex]]) -> Vertex:
    """Sum places by their weights."""
    x, y, z = (sum(weight * place[c] for weight, place in parts) for c in range(3))
    return x, y, z


def read_obj(path: Path) -> Mesh:
    """Read vertices and polygons of one of the repository's own files."""
    points: list[Vertex] = []
    faces: list[list[int]] = []
    for line in path.read_text(encoding="utf-8").splitlines():
        kind, *rest = line.split() or [""]
        if kind == "v":
            x, y, z = map(float, rest[:3])
            points.append((x, y, z))
        elif kind == "f":
            faces.append([int(token.partition("/")[0]) - 1 for token in rest])
    return points, faces


def format_obj(mesh: Mesh) -> str:
    """Write a mesh as the text of an OBJ file, with six figures."""
    points, faces = mesh
    lines = ["# patterndb, CC0-1.0 (https://creativecommons.org/publicdomain/zero/1.0/)"]
    lines += ["v " + " ".join(f"{c:.6g}" for c in place) for place in points]
    lines += ["f " + " ".join(str(v + 1) for v in face) for face in faces]
    return "\n".join(lines) + "\n"
