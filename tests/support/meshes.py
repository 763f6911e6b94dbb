"""Meshes to test with: plain shapes, random ones, and disks grown quad by quad."""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

from ingest.formats import read_mesh
from patterndb.core.quadmesh import QuadMesh
from tests.support.shared import DATA, EXAMPLES, MESHES, list_shared

Quads = list[list[int]]

ONE = [[0, 1, 2, 3]]
#: Two quads with two edges in common, about a vertex of valence 2.
DOUBLET = [[0, 1, 2, 3], [0, 3, 2, 4]]
#: Three quads about one vertex: a triangular pattern.
TRIANGLE = [[0, 1, 2, 3], [0, 3, 4, 5], [0, 5, 6, 1]]
#: Two quads that touch at a vertex, and at two.
BOW = [[0, 1, 2, 3], [2, 4, 5, 6]]
CLASP = [[0, 1, 2, 3], [0, 4, 2, 5]]
#: Three pages on one edge.
BOOK = [[0, 1, 2, 3], [0, 1, 4, 5], [0, 1, 6, 7]]
#: The same quad twice: after a flip, a closed pillow.
PILLOW = [[0, 1, 2, 3], [0, 1, 2, 3]]
CUBE = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
#: A cube without its lid: a disk without any corner whose centre is irregular four times.
CUP = CUBE[:5]


def grid(rows: int, columns: int) -> Quads:
    """rows by columns quads, row by row."""
    return wrapped(rows, columns)


def wrapped(
    rows: int, columns: int, around: bool = False, along: bool = False, twist: bool = False
) -> Quads:
    """A grid whose columns close (``around``: a tube), whose rows close too (``along``: a torus),
    or whose columns close upside down (``twist``: a Moebius strip)."""
    height = rows if along else rows + 1
    width = columns if around or twist else columns + 1

    def vertex(r: int, c: int) -> int:
        if twist and c == columns:
            r, c = height - 1 - r, 0
        return r % height * width + c % width

    return [
        [vertex(r, c), vertex(r, c + 1), vertex(r + 1, c + 1), vertex(r + 1, c)]
        for r in range(rows)
        for c in range(columns)
    ]


def star(n: int, rings: int = 1) -> Quads:
    """n quads about one vertex, and rings of quads about them."""
    quads = [[0, 2 * i + 1, 2 * i + 2, (2 * i + 2) % (2 * n) + 1] for i in range(n)]
    inner = [*range(1, 2 * n + 1)]
    fresh = 2 * n + 1
    for _ in range(rings - 1):
        outer = [fresh + i for i in range(len(inner))]
        fresh += len(inner)
        for i in range(len(inner)):
            quads.append([inner[i - 1], outer[i - 1], outer[i], inner[i]])
        inner = outer
    return quads


def refined(quads: Sequence[Sequence[int]]) -> Quads:
    """Every quad cut into four (one step of Catmull and Clark, without the points)."""
    names: dict[object, int] = {}

    def name(key: object) -> int:
        return names.setdefault(key, len(names))

    result: Quads = []
    for f, quad in enumerate(quads):
        for e in range(4):
            result.append(
                [
                    name(quad[e]),
                    name(frozenset((quad[e], quad[e - 3]))),
                    name(("face", f)),
                    name(frozenset((quad[e], quad[e - 1]))),
                ]
            )
    return result


def beside(*parts: Quads) -> Quads:
    """The parts as one mesh, nothing glued."""
    result: Quads = []
    for part in parts:
        first = 1 + max((v for q in result for v in q), default=-1)
        result += [[v + first for v in q] for q in part]
    return result


def sound(quads: Sequence[Sequence[int]]) -> Quads:
    """Those with four distinct vertices."""
    return [list(q) for q in quads if len(set(q)) == 4]


SHAPES: dict[str, Quads] = {
    "one": ONE,
    "doublet": DOUBLET,
    "triangle": TRIANGLE,
    "bow": BOW,
    "clasp": CLASP,
    "book": BOOK,
    "pillow": PILLOW,
    "cube": CUBE,
    "cup": CUP,
    "grid": grid(3, 4),
    "tube": wrapped(2, 4, around=True),
    "torus": wrapped(3, 4, around=True, along=True),
    "moebius": wrapped(1, 5, twist=True),
    "wide moebius": wrapped(3, 4, twist=True),
    "star 3": star(3, 2),
    "star 5": star(5, 2),
    "star 6": star(6, 1),
    "refined cube": refined(CUBE),
    "refined cup": refined(CUP),
    "beside": beside(star(5), wrapped(2, 3, around=True), ONE),
    "windowed": [q for i, q in enumerate(grid(4, 5)) if i not in (6, 8, 13)],
    "ring": [q for i, q in enumerate(grid(3, 3)) if i != 4],
}


@st.composite
def shapes(draw: st.DrawFn, most: int = 40) -> Quads:
    """One of the shapes above, or a grid, tube, torus or strip of random size."""
    if draw(st.booleans()):
        small = [q for q in SHAPES.values() if len(q) <= most]
        return draw(st.sampled_from(small))
    rows = draw(st.integers(1, 5))
    columns = draw(st.integers(3, max(3, most // rows)))
    kind = draw(st.integers(0, 3))
    closed = kind == 2 and rows >= 3
    return wrapped(rows, columns, around=kind in (1, 2), along=closed, twist=kind == 3)


@st.composite
def quad_soups(draw: st.DrawFn, most: int = 40) -> Quads:
    """Random meshes: a shape with quads left out, vertices glued together, a quad given twice,
    and quads turned, flipped and shuffled. Everything that is wrong with meshes occurs."""
    quads = draw(shapes(most))
    if draw(st.booleans()):
        quads = beside(quads, draw(shapes(most)))[:most]
    n = 1 + max(v for q in quads for v in q)
    for _ in range(draw(st.integers(0, 3))):
        a, b = draw(st.integers(0, n - 1)), draw(st.integers(0, n - 1))
        quads = [[a if v == b else v for v in q] for q in quads]
    left_out = draw(st.sets(st.integers(0, len(quads) - 1), max_size=len(quads) // 3))
    quads = sound([q for i, q in enumerate(quads) if i not in left_out]) or ONE
    if draw(st.integers(0, 9)) == 0:
        quads = [*quads, list(draw(st.sampled_from(quads)))]
    return scrambled(quads, draw(st.randoms(use_true_random=False)))


def scrambled(quads: Quads, chance: random.Random) -> Quads:
    """The quads in another order, each turned and now and then flipped, vertices renamed."""
    n = 1 + max(v for q in quads for v in q)
    names = list(range(n))
    chance.shuffle(names)
    result = [[names[v] for v in q] for q in quads]
    chance.shuffle(result)
    for i, q in enumerate(result):
        turn = chance.randrange(4)
        q = q[turn:] + q[:turn]
        result[i] = q[::-1] if chance.random() < 0.3 else q
    return result


@st.composite
def disks(draw: st.DrawFn, most: int = 24) -> list[int]:
    """Half-edges of a random disk, grown quad by quad along one to three border edges.

    Vertices of valence 2, quads with two edges in common and edges between the same two
    vertices occur; no quad touches itself.
    """
    twin = [-1] * 4
    border = [0, 1, 2, 3]
    for _ in range(draw(st.integers(0, most - 1))):
        widest = 3 if len(border) >= 6 else 2 if len(border) >= 4 else 1
        span = draw(st.sampled_from([1, 1, 2, 2, 2, 3][: 2 * widest]))
        at = draw(st.integers(0, len(border) - 1))
        border = border[at:] + border[:at]
        h = len(twin)
        twin += [-1] * 4
        # The new quad meets the border edges in the other direction.
        for i in range(span):
            twin[border[i]] = h + span - 1 - i
            twin[h + span - 1 - i] = border[i]
        border = [*range(h + span, h + 4), *border[span:]]
    return twin


@cache
def mesh_of_file(path: Path) -> QuadMesh:
    """The quad mesh in a file."""
    return QuadMesh.from_quads(read_mesh(path).quads()[0])


def examples() -> list[Path]:
    """The example meshes."""
    return sorted(EXAMPLES.glob("*.obj"))


def models() -> list[Path]:
    """The meshes that are modelled for the tests, see tests/support/models.py."""
    return sorted((DATA / "meshes").glob("*.obj"))


def shared_meshes(*names: str) -> list[Path]:
    """Those of the artists' meshes by name that are there, for larger runs."""
    return list_shared(MESHES, *(f"{name}.obj" for name in names))


def random_patches(mesh: QuadMesh, n: int, most: int, seed: int) -> Iterator[NDArray[np.int32]]:
    """Half-edges of ``n`` random disks of 2 to ``most`` quads of a mesh, grown quad by quad.

    Of two candidates the one with more neighbours inside is taken: compact disks hold more
    interior vertices.
    """
    chance = np.random.default_rng(seed)
    while n:
        wanted = int(chance.integers(2, most + 1))
        patch = [int(chance.integers(mesh.n_quads))]
        for _ in range(4 * wanted):
            if len(patch) >= wanted:
                break
            beyond = [
                t >> 2
                for q in patch
                for t in mesh.twin[4 * q : 4 * q + 4].tolist()
                if t >= 0 and t >> 2 not in patch
            ]
            if not beyond:
                break
            most_common = max(chance.choice(beyond, 3).tolist(), key=beyond.count)
            if _euler(mesh, [*patch, most_common]) == 1:
                patch.append(most_common)
        if len(patch) > 1:
            yield half_edges(mesh, patch)
            n -= 1


def half_edges(mesh: QuadMesh, patch: Sequence[int]) -> NDArray[np.int32]:
    """The half-edges of some quads of the mesh on their own."""
    place = np.full(mesh.n_quads + 1, -1)
    place[list(patch)] = np.arange(len(patch))
    twin = mesh.twin.reshape(-1, 4)[list(patch)].ravel()
    joined = (twin >= 0) & (place[twin >> 2] >= 0)
    return np.where(joined, 4 * place[twin >> 2] + (twin & 3), -1).astype(np.int32)


def _euler(mesh: QuadMesh, patch: Sequence[int]) -> int:
    """V - E + F by the mesh's vertices, so that a patch that touches itself is no disk."""
    border = int((half_edges(mesh, patch) < 0).sum())
    vertices = len(set(mesh.quads[list(patch)].ravel().tolist()))
    return vertices - (4 * len(patch) + border) // 2 + len(patch)


def write_obj(path: Path, quads: Sequence[Sequence[int]]) -> Path:
    """The quads as an OBJ file, on points that do not matter."""
    n = 1 + max((v for q in quads for v in q), default=0)
    lines = [f"v {i} {i * i % 7} 0" for i in range(n)]
    lines += ["f " + " ".join(str(v + 1) for v in q) for q in quads]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")
    return path
