"""Import a mesh of quads as a network whose patches are its regular grids.

The mesh is cut along its separatrices (:mod:`patterndb_sketch.retopo.quadgrids`); every grid
between them becomes a patch with a regular fill that holds the vertices where they were. Triangles
and larger faces stay as they are (:mod:`patterndb_sketch.retopo.network.invariants`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from patterndb._native.retopo.quadgrids import read_grid
from patterndb.core.halfedge import Int32Array, next_edge
from patterndb.geometry.points import Points, units
from patterndb.geometry.quadshape import flipped
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.filling import Choice, FilledNetwork, Filling, PlacedPatch
from patterndb_sketch.retopo.filling.placing import is_as_given
from patterndb_sketch.retopo.filling.report import cut_fans
from patterndb_sketch.retopo.network import (
    BORDER,
    FACE,
    Chain,
    HalfChain,
    Network,
    Node,
    Patch,
    walk_face,
)
from patterndb_sketch.retopo.quadgrids import (
    GridCurves,
    Quads,
    check_quads,
    follow_curves,
    list_corner_curves,
    make_grid_choice,
    mark_separatrices,
    refuse_fans,
)
from patterndb_sketch.retopo.sizes import EDGE, Sizes
from patterndb_sketch.retopo.tracing.curves import TOO_FAR
from patterndb_sketch.retopo.wording import list_places

#: A loop longer than this many diagonals never becomes a patch by itself, as elsewhere.
LONGEST = 2.0


@dataclass(frozen=True, slots=True, eq=False)
class QuadImport:
    """A mesh of quads as a network.

    network: its curves, with their counts, and a patch for every grid, whose fill holds all
             vertices where they were.
    surface:  what it lies on: the mesh itself, in triangles, unless another was given.
    sizes:   the surface's, with the mean length of the mesh's edges as the target edge.
    filled:  the network with its patches placed: the mesh again.
    vertex:  of every patch by id: (n,) int32, the mesh's vertex that each vertex of its fill is.
    unused:  how many vertices no face uses; they are left out.
    """

    network: Network
    surface: Surface
    sizes: Sizes
    filled: FilledNetwork
    vertex: dict[int, Int32Array]
    unused: int


def import_quads(
    vertices: ArrayLike,
    quads: ArrayLike,
    surface: Surface | None = None,
    others: Sequence[Sequence[int]] = (),
) -> QuadImport:
    """Take a mesh of quads apart into patches of regular grids, to be edited as if drawn.

    vertices: (v, 3). quads: (q, 4), counter-clockwise seen from outside.
    others:   triangles and larger faces, each the vertices around it, turned as the quads are. They
              stay as they are: loops of curves of one edge each, which nothing erases or moves.
    surface:   a surface to draw on; the mesh is projected onto it. Without one the mesh is its
              own surface, and every vertex stays where it is, bit for bit.

    As long as nothing is edited, the network's mesh is the one given, vertex for vertex. A patch
    of which a count or the fill changes is laid anew; the others stay. Corners that were
    regular vertices go when a curve that made them is erased.

    Raises InvalidRetopoError for what is no manifold mesh, all turned alike, with a quad; see
    :func:`~patterndb_sketch.retopo.quadgrids.check_quads`. Source: the retopology program of
    Takayama et al. 2013. Differs from it: see :mod:`.quadgrids`; vertices are not projected
    where the mesh is the surface.
    """
    mesh = check_quads(vertices, quads, others)
    laid = _LaidMesh.of(mesh, surface)
    marked, corner = mark_separatrices(mesh)
    found = follow_curves(mesh, marked, corner)
    return _ImportBuilder(mesh, laid, found).done(list_corner_curves(mesh, corner, found))


@dataclass(frozen=True, slots=True, eq=False)
class _LaidMesh:
    """points, normals: (v, 3) of the mesh's vertices on the surface. given: was there a surface?"""

    surface: Surface
    sizes: Sizes
    points: Points
    normals: Points
    given: bool

    @classmethod
    def of(cls, mesh: Quads, surface: Surface | None) -> _LaidMesh:
        own = Surface.from_arrays(mesh.points[: mesh.n_given], cut_triangles(mesh)).orient()
        normals = own.normals[own.repairs.vertex][mesh.given]
        steps = mesh.points[mesh.quads] - mesh.points[np.roll(mesh.quads, -1, axis=1)]
        edge = float(np.linalg.norm(steps, axis=2).mean())
        if surface is None:
            sizes = replace(Sizes.of(own.diagonal), edge=edge)
            return cls(own, sizes, mesh.points, normals, False)
        sizes = replace(Sizes.of(surface.diagonal), edge=edge)
        there = surface.project(mesh.points, normals, _find_reach(surface))
        return cls(surface, sizes, there.points, there.normals, True)


def _find_reach(surface: Surface) -> float:
    """How far off a surface a mesh may be that is projected onto it."""
    return TOO_FAR * EDGE * surface.diagonal


def cut_triangles(mesh: Quads) -> Int32Array:
    """(t, 3) every quad cut along its shorter diagonal, every other face into a fan, of vertices as
    they were given."""
    quads, points = mesh.quads, mesh.points
    one = np.linalg.norm(points[quads[:, 0]] - points[quads[:, 2]], axis=1)
    two = np.linalg.norm(points[quads[:, 1]] - points[quads[:, 3]], axis=1)
    turned = np.where((one <= two)[:, None], quads, np.roll(quads, -1, axis=1))
    halves = mesh.given[np.concatenate([turned[:, [0, 1, 2]], turned[:, [0, 2, 3]]])]
    return np.concatenate([halves, cut_fans(mesh.others)])


class _ImportBuilder:
    """The steps of :func:`import_quads`, which need the same things."""

    def __init__(self, mesh: Quads, laid: _LaidMesh, found: GridCurves) -> None:
        self.mesh = mesh
        self.laid = laid
        self.found = found

    def done(self, corners: dict[int, list[int]]) -> QuadImport:
        found = self.found
        ends = {v: around for v, around in corners.items() if not self.mesh.held[v]}
        lines = [
            np.append(self.mesh.tail[along], self.mesh.tail[next_edge(along[-1])])
            for along in map(found.of, range(len(found)))
        ]
        lines += self._list_lone_edges()
        held, rim = self._list_held_ends(lines)
        ends.update(held)
        # Ids: chains first, so that a half-curve's number is its half-chain's.
        node = {vertex: len(lines) + k for k, vertex in enumerate(sorted(ends))}
        chains = {k: self._chain(k, lines[k], node) for k in range(len(lines))}
        rim |= set(np.flatnonzero(self.mesh.border & ~self.mesh.held).tolist())
        nodes = {
            node[vertex]: self._node(node[vertex], vertex, ends[vertex], vertex in rim)
            for vertex in node
        }
        next_id = len(lines) + len(node)
        longest = LONGEST * self.laid.surface.diagonal
        bare = Network(nodes, chains, {}, next_id, longest)
        patches: dict[int, Patch] = {}
        vertex: dict[int, Int32Array] = {}
        seen: set[HalfChain] = set()
        for half in range(2 * len(found)):
            if half in seen or bare.mark(half):
                continue
            loop, places = walk_face(nodes, chains, half)
            seen.update(loop)
            source, filling = self._grid(loop, places)
            patches[next_id] = Patch(next_id, loop, places, filling)
            vertex[next_id] = source
            longest = max(longest, sum(chains[h >> 1].length for h in loop))
            next_id += 1
        network = Network(nodes, chains, patches, next_id, longest)
        placed = self._placed(patches, vertex)
        unused = int(((self.mesh.valence == 0) & ~self.mesh.held).sum())
        laid = self.laid
        filled = FilledNetwork(network, placed, _note_losses(placed, unused))
        return QuadImport(network, laid.surface, laid.sizes, filled, vertex, unused)

    @cached_property
    def _beside(self) -> dict[tuple[int, int], tuple[bool, int]]:
        """Of the sides of faces at a vertex that is held, from vertex to vertex as they were given:
        is the face on the left one that is no quad, and its vertex before the side."""
        mesh = self.mesh
        quads = mesh.given[mesh.quads[mesh.held[mesh.quads].any(axis=1)]].tolist()
        beside: dict[tuple[int, int], tuple[bool, int]] = {}
        for face, other in [(q, False) for q in quads] + [(f, True) for f in mesh.others]:
            for k, vertex in enumerate(face):
                beside[face[k - 1], vertex] = other, face[k - 2]
        return beside

    def _list_lone_edges(self) -> list[Int32Array]:
        """The edges of other faces that no quad has: each its two vertices."""
        beside = self._beside
        found: list[Int32Array] = []
        for (a, b), (other, _) in beside.items():
            back = beside.get((b, a))
            if other and (back is None or (back[0] and a < b)):
                found.append(np.array([a, b], np.int32))
        return found

    def _list_held_ends(self, lines: list[Int32Array]) -> tuple[dict[int, list[int]], set[int]]:
        """The half-curves that leave every vertex of other faces, counter-clockwise, at a border
        from that on; and which of these vertices are on a border. Raises InvalidRetopoError where
        several fans meet."""
        given, held, beside = self.mesh.given, self.mesh.held, self._beside
        leaving: dict[int, dict[int, int]] = {}
        for k, line in enumerate(lines):
            for half, (a, b) in ((2 * k, line[:2]), (2 * k + 1, line[:-3:-1])):
                if held[a]:
                    leaving.setdefault(int(given[a]), {})[int(given[b])] = half
        ends: dict[int, list[int]] = {}
        rim: set[int] = set()
        for vertex, halves in sorted(leaving.items()):
            # The side of a border that has a face on its left comes first.
            first = next((w for w in halves if (w, vertex) not in beside), next(iter(halves)))
            around = [first]
            while (vertex, around[-1]) in beside:
                _, at = beside[vertex, around[-1]]
                if at == first:
                    break
                around.append(at)
            else:
                rim.add(vertex)
            if len(around) < len(halves):
                refuse_fans(vertex)
            ends[vertex] = [halves[w] for w in around]
        return ends, rim

    def _chain(self, curve: int, line: Int32Array, node: dict[int, int]) -> Chain:
        """A curve with its edges divided into samples; the mesh's vertices are among them.

        line: (n,) int32, the vertices along it."""
        given, held = self.mesh.given, self.mesh.held
        corners, up = self.laid.points[line], self.laid.normals[line]
        lengths = np.linalg.norm(np.diff(corners, axis=0), axis=1)
        if not lengths.any():
            raise InvalidRetopoError(
                f"all vertices from {line[0]} to {line[-1]} along a curve of the mesh are in one "
                "place; merge or move them"
            )
        parts = [max(1, math.ceil(length / self.laid.sizes.sampling)) for length in lengths]
        edge = np.repeat(np.arange(len(lengths)), parts)
        share = np.concatenate([np.arange(k) / k for k in parts])[:, None]
        points = (1.0 - share) * corners[edge] + share * corners[edge + 1]
        normals = units((1.0 - share) * up[edge] + share * up[edge + 1])
        if self.laid.given:
            there = self.laid.surface.project(points, normals, _find_reach(self.laid.surface))
            inner = share[:, 0] > 0.0
            points[inner], normals[inner] = there.points[inner], there.normals[inner]
        at_vertex = share[:, 0] == 0.0
        normals[at_vertex] = up[edge[at_vertex]]
        marks = ("", "")
        if curve >= len(self.found) or self.mesh.twin[self.found.of(curve)[0]] < 0:
            marks = ("", BORDER)
        if held[line[0]] and held[line[1]]:
            a, b = given[line[:2]].tolist()
            right, _ = self._beside.get((b, a), (None, 0))
            left, _ = self._beside[a, b]
            marks = (FACE if left else "", BORDER if right is None else FACE if right else "")
        kept = FACE in marks
        return Chain(
            curve,
            node[int(given[line[0]])],
            node[int(given[line[-1]])],
            np.concatenate([points, corners[-1:]]),
            np.concatenate([normals, up[-1:]]),
            len(line) - 1,
            kept,
            marks,
        )

    def _node(self, node: int, vertex: int, ends: list[int], border: bool) -> Node:
        """A corner; all wedges but that beyond the border are corners of patches, or of faces."""
        flags = (True,) * (len(ends) - border) + (False,) * border
        regular = len(ends) == (3 if border else 4) and not self.mesh.held[vertex]
        point, normal = self.laid.points[vertex], self.laid.normals[vertex]
        return Node(node, point.copy(), normal.copy(), tuple(ends), flags, regular)

    def _grid(
        self, loop: tuple[HalfChain, ...], corners: tuple[int, ...]
    ) -> tuple[Int32Array, Filling]:
        """The vertices of the mesh that a patch's fill has, and that fill."""
        counts = [self.found.count(half) for half in loop]
        if corners != (0, 1, 2, 3) or len(loop) != 4 or counts[:2] != counts[2:]:
            first = self.found.first(self.mesh, loop[0]) // 4
            raise InvalidRetopoError(f"the part of the mesh at quad {first} is no regular grid")
        w, n = counts[:2]
        first = self.found.first(self.mesh, loop[0])
        choice, numbers = make_grid_choice(w, n)
        source = np.empty(choice.n_vertices, np.int32)
        source[numbers] = read_grid(self.mesh.twin, self.mesh.tail, first, w, n)
        filling = Filling(choice).with_moved(np.arange(len(source)), self.laid.points[source])
        return self.mesh.given[source], filling

    def _placed(
        self, patches: dict[int, Patch], vertex: dict[int, Int32Array]
    ) -> dict[int, PlacedPatch]:
        """All patches with their vertices where they were."""
        points, normals = self.laid.points, self.laid.normals
        fills = {patch: choice_of(one) for patch, one in patches.items()}
        rows = [vertex[patch][fills[patch].faces] for patch in patches]
        over = flipped(np.concatenate(rows), points, normals)
        parts = np.split(over, np.cumsum([len(row) for row in rows])[:-1])
        return {
            patch: PlacedPatch(
                fills[patch].faces,
                points[vertex[patch]],
                normals[vertex[patch]],
                fills[patch].perimeter,
                np.flatnonzero(part).astype(np.int32),
                True,
            )
            for patch, part in zip(patches, parts, strict=True)
        }


def refuse_losses(found: FilledNetwork) -> None:
    """RefusedError if patches have no quads that a mesh which was given has there."""
    lost = [
        patch
        for key, patch in sorted(found.network.patches.items())
        if key not in found.placed and isinstance(patch.choice, Filling) and is_as_given(patch)
    ]
    if lost:
        quads = sum(len(choice_of(patch).faces) for patch in lost)
        raise RefusedError(
            f"{quads} quads of the mesh that was given would be lost, those of "
            f"{', '.join(f'patch {patch.id}' for patch in lost)}; {'; '.join(found.notes)}"
        )


def choice_of(patch: Patch) -> Choice:
    """The fill of an imported patch, which always has one."""
    choice = patch.choice.choice
    assert isinstance(choice, Choice)
    return choice


def _note_losses(placed: dict[int, PlacedPatch], unused: int) -> tuple[str, ...]:
    notes: list[str] = []
    if unused:
        notes.append(f"{unused} vertices that no quad uses are left out")
    over = np.concatenate([one.find_flipped() for one in placed.values()])
    if len(over):
        notes.append(
            f"{len(over)} quads of the mesh are flipped, or have no area, {list_places(over)}"
        )
    return tuple(notes)
