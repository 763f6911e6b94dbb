"""Quad meshes modelled for the tests, and what writes them: ``python -m tests.support.models``.

They have what artists' meshes have: irregular vertices of valence 3 to 6, borders, handles, a plane
of symmetry, parts that taper. Nothing in them is random beyond a seed, so that figures that other
programs counted stay true (tests/data/learning.jsonl).
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray

from tests.support.reference.halfedge import Quads, as_complex, fans, twins
from tests.support.shared import DATA

FOLDER = DATA / "meshes"

Points = NDArray[np.float64]
Cell = tuple[int, int, int]

#: Decimals of a coordinate in the files.
DECIMALS = 4


def list_models() -> list[str]:
    """Return the names of the models."""
    return list(MODELS)


def make_chair() -> tuple[Points, Quads]:
    """Model a chair of cubes: closed, symmetric in the plane x = 0, valences 3 to 6."""
    seat = set(product(range(-2, 2), range(4), [3]))
    back = set(product(range(-2, 2), [3], range(4, 8))) - {(-1, 3, 5), (0, 3, 5)}
    legs = {(x, y, z) for x in (-2, 1) for y in (0, 3) for z in range(3)}
    arms = {(x, y, z) for x in (-2, 1) for y in range(4) for z in (5,)}
    posts = {(x, 0, 4) for x in (-2, 1)}
    return smooth(*skin(seat | back | legs | arms | posts), 3)


def make_frame() -> tuple[Points, Quads]:
    """Model a bar with two eyes: closed, two handles."""
    bar = set(product(range(9), range(4), range(2)))
    eyes = {(x, y, z) for x in (1, 2, 6) for y in (1, 2) for z in range(2)}
    return smooth(*skin(bar - eyes), 4)


def make_trough() -> tuple[Points, Quads]:
    """Model a trough without its rim's top, with a step inside: one border with corners."""
    block = set(product(range(6), range(4), range(3)))
    step = set(product(range(2), range(1, 3), [3]))
    points, quads = skin(block | step)
    top = [q for q in quads if not all(points[v][2] == 3 and points[v][0] >= 3 for v in q)]
    return smooth(*compact(points, top), 2)


def make_glove() -> tuple[Points, Quads]:
    """Model a palm of cubes with three fingers and an open wrist."""
    palm = set(product(range(4), range(4), range(2)))
    fingers = {(x, y, 0) for x in (0, 2) for y in range(4, 8)} | {(4, 1, 0), (5, 1, 0), (6, 1, 0)}
    points, quads = skin(palm | fingers)
    open_wrist = [q for q in quads if not all(points[v][1] == 0 for v in q)]
    return smooth(*compact(points, open_wrist), 3)


def make_ring() -> tuple[Points, Quads]:
    """Model a torus whose edges were turned at random: one handle, irregular all over."""
    rows, columns = 10, 20
    quads = [
        [rows * c + r, rows * ((c + 1) % columns) + r,
         rows * ((c + 1) % columns) + (r + 1) % rows, rows * c + (r + 1) % rows]
        for c in range(columns) for r in range(rows)
    ]  # fmt: skip
    u = 2 * np.pi * np.arange(columns) / columns
    v = 2 * np.pi * np.arange(rows) / rows
    around, along = np.meshgrid(3 + np.cos(v), u)
    height = np.tile(np.sin(v), columns)
    points = np.c_[(around * np.cos(along)).ravel(), (around * np.sin(along)).ravel(), height]
    return smooth(points, turn_edges(quads, 45, seed=3), 2)


def make_shield() -> tuple[Points, Quads]:
    """Model a sheet with a notched outline and a hole, turned edges within: two borders."""
    cells = [(x, y) for x in range(14) for y in range(12)]
    notches = {(0, 0), (1, 0), (0, 1), (13, 11), (13, 5), (6, 0), (7, 0), (7, 1)}
    hole = {(5, 6), (6, 6), (5, 7)}
    flat = [cell for cell in cells if cell not in notches | hole]
    quads = [[13 * x + y, 13 * (x + 1) + y, 13 * (x + 1) + y + 1, 13 * x + y + 1] for x, y in flat]
    x, y = np.divmod(np.arange(15 * 13), 13)
    points = np.c_[x, y, 0.02 * ((x - 7.0) ** 2 + (y - 6.0) ** 2)].astype(float)
    return smooth(*compact(points, turn_edges(quads, 30, seed=8)), 1)


def make_mask() -> tuple[Points, Quads]:
    """Model a face with two eyes and a mouth, the mirror image of one half: four borders."""
    half = [(x, y) for x in range(6) for y in range(12)]
    gone = {(2, 7), (3, 7), (2, 8), (3, 8), (0, 2), (1, 2), (5, 0), (5, 11), (4, 0)}
    kept = [cell for cell in half if cell not in gone]
    quads = [[13 * x + y, 13 * (x + 1) + y, 13 * (x + 1) + y + 1, 13 * x + y + 1] for x, y in kept]
    # Vertices of the plane, x = 0, are 0 to 12 and stay where they are.
    quads = turn_edges(quads, 16, seed=5, held=range(13))
    x, y = np.divmod(np.arange(7 * 13), 13)
    points = np.c_[x, y, 4 - 0.08 * x**2 - 0.04 * (y - 6.0) ** 2].astype(float)
    other = [[v if v < 13 else v + 7 * 13 for v in q[::-1]] for q in quads]
    both = np.concatenate([points, points * [-1.0, 1.0, 1.0]])
    return smooth(*compact(both, [*quads, *other]), 2)


def make_knot() -> tuple[Points, Quads]:
    """Model a closed tube of cubes that bends in three directions, its corners many."""
    way = [(0, 0, 0), (5, 0, 0), (5, 4, 0), (5, 4, 4), (0, 4, 4), (0, 4, 2), (0, 0, 2), (0, 0, 0)]
    cells: set[Cell] = set()
    for a, b in pairwise(way):
        steps = max(abs(q - p) for p, q in zip(a, b, strict=True))
        for t in range(steps + 1):
            x, y, z = (p + (q - p) * t // steps for p, q in zip(a, b, strict=True))
            cells.add((x, y, z))
    return smooth(*skin(cells | {(2, 0, -1), (5, 2, -1), (3, 4, 5)}), 3)


#: What makes each model. A new one gets its rows in tests/data/learning.jsonl.
MODELS: dict[str, Callable[[], tuple[Points, Quads]]] = {
    "chair": make_chair,
    "frame": make_frame,
    "glove": make_glove,
    "knot": make_knot,
    "mask": make_mask,
    "ring": make_ring,
    "shield": make_shield,
    "trough": make_trough,
}

#: The faces of a cell: outward, counter-clockwise.
FACES: dict[Cell, tuple[Cell, Cell, Cell, Cell]] = {
    (1, 0, 0): ((1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0, 1)),
    (-1, 0, 0): ((0, 0, 0), (0, 0, 1), (0, 1, 1), (0, 1, 0)),
    (0, 1, 0): ((0, 1, 0), (0, 1, 1), (1, 1, 1), (1, 1, 0)),
    (0, -1, 0): ((0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)),
    (0, 0, 1): ((0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)),
    (0, 0, -1): ((0, 0, 0), (0, 1, 0), (1, 1, 0), (1, 0, 0)),
}


def skin(cells: Iterable[Cell]) -> tuple[Points, Quads]:
    """Return the surface of a body of unit cubes, which must not touch itself in an edge only."""
    inside = set(cells)
    number: dict[Cell, int] = {}
    quads: Quads = []
    for x, y, z in sorted(inside):
        for (dx, dy, dz), face in FACES.items():
            if (x + dx, y + dy, z + dz) not in inside:
                corners = [(x + a, y + b, z + c) for a, b, c in face]
                quads.append([number.setdefault(corner, len(number)) for corner in corners])
    return np.array(list(number), float), quads


def turn_edges(quads: Quads, count: int, seed: int, held: Sequence[int] | range = ()) -> Quads:
    """Turn random edges, each within the hexagon of its two quads.

    An edge is turned where all vertices keep 3 to 6 quads (2 to 4 on the border), no two vertices
    get a second edge, and none of the hexagon is ``held``.
    """
    quads = [list(q) for q in quads]
    chance = random.Random(seed)
    done = 0
    while done < count:
        twin = twins(quads)
        h = chance.randrange(len(twin))
        t = twin[h]
        if t < 0:
            continue
        f, g = h // 4, t // 4
        a, b, c, d = (quads[f][(h + i) % 4] for i in range(4))
        _, _, e, k = (quads[g][(t + i) % 4] for i in range(4))
        # The hexagon is a e k b c d; the edge a b becomes e c.
        if len({a, b, c, d, e, k}) < 6 or {a, b, c, d, e, k} & set(held):
            continue
        turned = [list(q) for q in quads]
        turned[f], turned[g] = [e, c, d, a], [c, e, k, b]
        if is_fair(turned) and not _has_edge(quads, e, c):
            quads = turned
            done += 1
    return quads


def _has_edge(quads: Quads, a: int, b: int) -> bool:
    return any({a, b} == {q[i], q[i - 1]} for q in quads for i in range(4))


def is_fair(quads: Quads) -> bool:
    """Has every inner vertex 3 to 6 quads, and every border vertex 1 to 4?"""
    twin = twins(quads)
    border = {quads[h // 4][i % 4] for h, t in enumerate(twin) if t < 0 for i in (h, h + 1)}
    count: dict[int, int] = {}
    for v in (v for q in quads for v in q):
        count[v] = count.get(v, 0) + 1
    return all(1 <= n <= 4 if v in border else 3 <= n <= 6 for v, n in count.items())


def compact(points: Points, quads: Quads) -> tuple[Points, Quads]:
    """Leave out points that no quad has."""
    used = sorted({v for q in quads for v in q})
    number = {v: i for i, v in enumerate(used)}
    return points[used], [[number[v] for v in q] for q in quads]


def smooth(points: Points, quads: Quads, steps: int) -> tuple[Points, Quads]:
    """Move every inner vertex half the way to the mean of its neighbours, several times."""
    twin = twins(quads)
    neighbours: dict[int, set[int]] = {}
    border: set[int] = set()
    for h, t in enumerate(twin):
        a, b = quads[h // 4][h % 4], quads[h // 4][(h + 1) % 4]
        neighbours.setdefault(a, set()).add(b)
        neighbours.setdefault(b, set()).add(a)
        border |= {a, b} if t < 0 else set()
    inner = [v for v in sorted(neighbours) if v not in border]
    for _ in range(steps):
        means = [points[sorted(neighbours[v])].mean(axis=0) for v in inner]
        points = points.copy()
        points[inner] = (points[inner] + means) / 2
    return points, quads


def is_manifold(points: Points, quads: Quads) -> bool:
    """Is every vertex one fan of quads, and every edge one of at most two that run against it?"""
    twin = twins(quads)
    edges = [(quads[h // 4][h % 4], quads[h // 4][(h + 1) % 4]) for h in range(len(twin))]
    n_fans = len(set(fans(as_complex(twin)).values()))
    return len(set(edges)) == len(edges) and n_fans == len(points)


def format_model(name: str) -> str:
    """Return a model as the text of an OBJ file."""
    points, quads = MODELS[name]()
    lines = [f"# {MODELS[name].__doc__}"]
    lines += ["v " + " ".join(f"{x:.{DECIMALS}f}" for x in point + 0.0) for point in points]
    lines += ["f " + " ".join(str(v + 1) for v in quad) for quad in quads]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for model in MODELS:
        (FOLDER / f"{model}.obj").write_text(format_model(model), "ascii")
