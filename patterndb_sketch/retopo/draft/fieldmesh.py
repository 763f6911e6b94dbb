"""Make the mesh that a field is solved on: cut open along curves, and remeshed evenly.

Triangles of one size and nearly one shape come from Botsch and Kobbelt 2004, "A Remeshing Approach
to Multiresolution Modeling": long edges are split, short ones collapsed, edges flipped towards six
triangles a vertex, and vertices moved along the surface, several times over. Borders stay where
they are but for their division.

A field runs along curves, and lines end there. Each drawn curve is a path along edges of the mesh,
its vertices moved onto the curve; a crease is such a path already. The mesh is cut open along all
paths, what patches cover is left out, and the rest is remeshed. From then on the curves are borders
like others (:mod:`.joints` finds which border is which side of which curve).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import KDTree

from patterndb._native.retopo.draft.remesh import (
    collapse_short,
    flip_to_valence,
    mark_border,
    relax,
    split_long,
)
from patterndb.core.halfedge import Int32Array
from patterndb.errors import InvalidMeshError
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.draft.frames import TangentFrames
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network import Chain, HalfChain, Network
from patterndb_sketch.retopo.network.faces import SurfaceParts
from patterndb_sketch.retopo.wording import format_place

#: Rounds of splitting, collapsing, flipping and moving. Source: Botsch and Kobbelt 2004 take five.
ROUNDS = 6

#: Edges longer and shorter than these times the wanted length are split and collapsed. Source:
#: the same.
LONG, SHORT = 4.0 / 3.0, 4.0 / 5.0

#: A vertex moves by so many wanted lengths at most; from further off it stays for this round.
LONGEST_MOVE = 1.0

#: A part gets so many triangles at least, and so many rows of them around, by its area and the
#: diagonal of its box: on eyes and laces of a few edges' size a field has its singularities, too.
FEWEST, AROUND = 300, 8

#: Of more triangles than these, edges of such parts are no shorter than this part of the wanted
#: length: slivers would get millions of them.
MOST_SMALL, LEAST_SHARE = 1000, 0.15

#: Area of an equilateral triangle, in squared edges.
EQUILATERAL = np.sqrt(3.0) / 4.0

#: A path keeps within so many edges of the mesh of its curve; where there is none, within twice
#: that.
ASIDE = 1.5

#: Being a whole edge off the curve makes an edge of a path so many times as long.
OFF_CURVE = 8.0

#: The two lips of a cut are this part of an edge apart: vertices in one place would be one.
LIP = 1e-3

#: Parts of a closed curve without a node: each is a path of its own.
THIRDS = 3


def remesh_parts(surface: Surface, edge: float) -> tuple[Points, Int32Array]:
    """(v, 3) vertices and (t, 3) triangles as of :func:`remesh_evenly`, but finer on each part that
    is small or thin against the edge."""
    found = SurfaceParts.of(surface)
    areas = np.bincount(found.part, surface.areas, found.parts)
    corner = surface.vertices[surface.triangles]
    low, high = np.full((found.parts, 3), np.inf), np.full((found.parts, 3), -np.inf)
    np.minimum.at(low, found.part, corner.min(axis=1))
    np.maximum.at(high, found.part, corner.max(axis=1))
    length = np.linalg.norm(high - low, axis=1)
    finest = np.minimum(np.sqrt(areas / (FEWEST * EQUILATERAL)), areas / (AROUND * length))
    floor = np.minimum(np.sqrt(areas / (MOST_SMALL * EQUILATERAL)), LEAST_SHARE * edge)
    finest = np.maximum(finest, floor)
    small = finest < edge
    if not small.any():
        return remesh_evenly(surface, edge)
    points, triangles, n = list[Points](), list[Int32Array](), 0
    large = ~small[found.part]
    pieces = [(large, edge)] if large.any() else []
    pieces += [(found.part == k, float(finest[k])) for k in np.flatnonzero(small).tolist()]
    for which, size in pieces:
        at, corners = remesh_evenly(
            Surface.from_arrays(surface.vertices, surface.triangles[which]).orient(), size
        )
        points.append(at)
        triangles.append(corners + n)
        n += len(at)
    return np.concatenate(points), np.concatenate(triangles).astype(np.int32)


def remesh_evenly(surface: Surface, edge: float) -> tuple[Points, Int32Array]:
    """(v, 3) vertices on a manifold surface, all turned alike, and (t, 3) triangles of this edge.

    The surface's handles and borders are kept: an edge whose collapse would close a tunnel stays,
    whatever its length.
    """
    points, triangles = surface.vertices.copy(), surface.triangles.copy()
    twin = surface.adjacency.across.copy()
    for _ in range(ROUNDS):
        points, triangles, twin = split_long(points, triangles, twin, LONG * edge)
        alive = collapse_short(points, triangles, twin, SHORT * edge, LONG * edge)
        points, triangles, twin = _compact(points, triangles, twin, alive)
        border = mark_border(len(points), triangles, twin)
        for _ in range(2):
            flip_to_valence(points, triangles, twin, border)
        moved, normals = relax(points, triangles, border)
        inner = np.flatnonzero(~border)
        there = surface.nearest_facing(moved[inner], normals[inner]).points
        # What faces so may be far off, at the other end of a limb: a vertex that leaps there draws
        # triangles with it, which are divided, and leap in turn.
        far = np.linalg.norm(there - points[inner], axis=1) > LONGEST_MOVE * edge
        there[far] = points[inner[far]]
        points[inner] = there
    return points, triangles


def _compact(
    points: Points, triangles: Int32Array, twin: Int32Array, alive: NDArray[np.bool_]
) -> tuple[Points, Int32Array, Int32Array]:
    """Leave out what was collapsed."""
    kept = triangles[alive]
    used = np.unique(kept)
    name = np.full(len(points), -1, np.int32)
    name[used] = np.arange(len(used), dtype=np.int32)
    row = np.cumsum(alive, dtype=np.int32) - 1
    sides = twin.reshape(-1, 3)[alive].ravel()
    joined = sides >= 0
    sides[joined] = 3 * row[sides[joined] // 3] + sides[joined] % 3
    return np.ascontiguousarray(points[used]), np.ascontiguousarray(name[kept]), sides


def cut_along_curves(
    network: Network, mesh: TangentFrames, edge: float, drawn: Iterable[int] | None = None
) -> TangentFrames:
    """Return the part of a mesh that no patch covers, cut open along drawn chains, remeshed.

    network: on the same surface. drawn: its chains to cut along, by default all that are on no
    border; the others are borders of the mesh already. edge: of the mesh, the surface's unit.
    Raises RefusedError, with the place, where curves are too close to each other for edges of this
    length, and where patches cover everything.
    """
    if drawn is None:
        drawn = [c for c, chain in network.chains.items() if not chain.marked]
    chains = [network.chains[c] for c in drawn]
    paths = _Paths(network, chains, mesh, edge)
    for chain in chains:
        paths.add(chain)
    return _cut_open(network, mesh, paths.points, paths.half, edge)


def cut_along_creases(
    network: Network, surface: Surface, half: Mapping[tuple[int, int], HalfChain], edge: float
) -> TangentFrames:
    """Return a surface cut open exactly along creases, remeshed.

    half: by the end vertices of a side of the surface, the network's half-chain that runs there.
    """
    return _cut_open(network, TangentFrames.of(surface), surface.vertices, half, edge)


@dataclass(frozen=True, slots=True)
class _Piece:
    """A part of a curve, from one vertex of the mesh to another."""

    points: Points
    normals: Points
    start: int
    end: int


class _Paths:
    """The steps of :func:`cut_along_curves`."""

    def __init__(
        self, network: Network, chains: list[Chain], mesh: TangentFrames, edge: float
    ) -> None:
        self.network = network
        self.mesh = mesh
        self.edge = edge
        self.points = mesh.vertices.copy()
        self.tree = KDTree(mesh.vertices)
        self.taken: set[int] = set()
        self.half: dict[tuple[int, int], HalfChain] = {}
        self.anchors: dict[int, int] = {}
        drawn = {n for one in chains if not one.is_closed_loop for n in (one.start, one.end)}
        for number in sorted(drawn):
            node = network.nodes[number]
            rim = any(network.chains[half >> 1].marked for half in node.ends)
            self.anchors[number] = self._take_vertex(node.point, node.normal, rim)

    def _take_vertex(self, point: Points, normal: Points, rim: bool) -> int:
        """The free vertex nearest to a place, moved there; one of a border stays on it."""
        near = self.tree.query_ball_point(point, 4.0 * self.edge)
        fit = [
            v
            for v in near
            if bool(self.mesh.on_border[v]) == rim and self.mesh.surface.normals[v] @ normal > 0.0
        ]
        free = [v for v in fit if v not in self.taken]
        if not free:
            self._refuse(point)
        away = np.linalg.norm(self.mesh.vertices[free] - point, axis=1)
        vertex = free[int(away.argmin())]
        self.taken.add(vertex)
        self.points[vertex] = point
        return vertex

    def _refuse(self, point: Points) -> None:
        raise RefusedError(
            f"curves are too close to each other at {format_place(point)} for a draft with this "
            "edge; take a smaller edge, or erase one of them"
        )

    def add(self, chain: Chain) -> None:
        """Lay the path of a curve."""
        pieces: list[_Piece] = []
        if chain.is_closed_loop:
            line = np.concatenate([chain.points, chain.points[:1]])
            up = np.concatenate([chain.normals, chain.normals[:1]])
            stops = np.linspace(0, len(chain.points), THIRDS + 1).astype(int).tolist()
            at = [self._take_vertex(line[k], up[k], False) for k in stops[:-1]]
            for k, (a, b) in enumerate(pairwise(stops)):
                part = slice(a, b + 1)
                pieces.append(_Piece(line[part], up[part], at[k], at[(k + 1) % THIRDS]))
        else:
            start, end = self.anchors[chain.start], self.anchors[chain.end]
            if start == end:
                middle = len(chain.points) // 2
                via = self._take_vertex(chain.points[middle], chain.normals[middle], False)
                for part, a, b in (
                    (slice(0, middle + 1), start, via),
                    (slice(middle, None), via, end),
                ):
                    pieces.append(_Piece(chain.points[part], chain.normals[part], a, b))
            else:
                pieces.append(_Piece(chain.points, chain.normals, start, end))
        for piece in pieces:
            path = self._find_path(piece)
            for a, b in pairwise(path):
                self.half[a, b], self.half[b, a] = 2 * chain.id, 2 * chain.id + 1
            inner = path[1:-1]
            self.taken.update(inner)
            self.points[inner] = piece.points[
                np.linalg.norm(
                    piece.points[None] - self.mesh.vertices[inner][:, None], axis=2
                ).argmin(axis=1)
            ]

    def _find_path(self, piece: _Piece) -> list[int]:
        """The vertices of the best path beside a curve that passes none that is taken."""
        for aside in (ASIDE, 2.0 * ASIDE):
            found = self._find_path_within(piece, aside * self.edge)
            if found:
                return found
        self._refuse(piece.points[len(piece.points) // 2])
        return []

    def _find_path_within(self, piece: _Piece, reach: float) -> list[int]:
        mesh = self.mesh
        step = max(1, int(0.25 * self.edge / max(np.linalg.norm(
            np.diff(piece.points, axis=0), axis=1).mean(), 1e-300)))  # fmt: skip
        samples = piece.points[::step]
        near = sorted(set().union(*self.tree.query_ball_point(samples, reach)))
        away, which = KDTree(piece.points).query(mesh.vertices[near])
        agree = np.einsum("nc,nc->n", mesh.surface.normals[near], piece.normals[which]) > 0.0
        allowed = np.array(
            [
                v in (piece.start, piece.end)
                or (ok and v not in self.taken and not mesh.on_border[v])
                for v, ok in zip(near, agree.tolist(), strict=True)
            ]
        )
        vertices = np.array(near, np.int64)[allowed]
        off = away[allowed]
        name = np.full(len(mesh.vertices), -1, np.int64)
        name[vertices] = np.arange(len(vertices))
        if name[piece.start] < 0 or name[piece.end] < 0:
            return []
        ends = mesh.surface.adjacency.ends
        ends = ends[(name[ends] >= 0).all(axis=1)]
        used = np.array([(a, b) in self.half for a, b in ends.tolist()], np.bool_)
        ends = ends[~used]
        one, two = name[ends].T
        cost = np.linalg.norm(mesh.vertices[ends[:, 0]] - mesh.vertices[ends[:, 1]], axis=1)
        cost *= 1.0 + OFF_CURVE * ((off[one] + off[two]) / (2.0 * self.edge)) ** 2
        n = len(vertices)
        graph = coo_array((np.r_[cost, cost], (np.r_[one, two], np.r_[two, one])), (n, n))
        begin, goal = int(name[piece.start]), int(name[piece.end])
        _, before = dijkstra(graph.tocsr(), indices=begin, return_predecessors=True)
        way = [goal]
        while way[-1] != begin:
            back = int(before[way[-1]])
            if back < 0:
                return []
            way.append(back)
        return vertices[way[::-1]].tolist()


def _cut_open(
    network: Network,
    mesh: TangentFrames,
    at: Points,
    half: Mapping[tuple[int, int], HalfChain],
    edge: float,
) -> TangentFrames:
    """Return a mesh cut open along sides with half-chains, without what patches cover, remeshed.

    at: (v, 3) where its vertices go.
    """
    n = len(mesh.triangles)
    tail = mesh.triangles.ravel()
    head = np.roll(mesh.triangles, -1, axis=1).ravel()
    of_side = np.array(
        [half.get(pair, -1) for pair in zip(tail.tolist(), head.tolist(), strict=True)],
        np.int64,
    )
    open_sides = np.flatnonzero((mesh.across >= 0) & (of_side < 0))
    here, there = open_sides, mesh.across[open_sides]
    joined = coo_array((np.ones(len(here), np.int8), (here // 3, there // 3)), (n, n))
    _, part = connected_components(joined, directed=False)
    taken = network.patch_of()
    covered = {int(part[s // 3]) for s in np.flatnonzero(of_side >= 0) if of_side[s] in taken}
    kept = ~np.isin(part, sorted(covered))
    if not kept.any():
        raise RefusedError("patches cover the surface; there is nothing left to draft")
    # Corners that no cut parts are one vertex.
    back = np.stack([here, there // 3 * 3 + (there % 3 + 1) % 3])
    ahead = np.stack([here // 3 * 3 + (here % 3 + 1) % 3, there])
    pairs = np.concatenate([back, ahead], axis=1)
    same = coo_array((np.ones(pairs.shape[1], np.int8), tuple(pairs)), (3 * n, 3 * n))
    count, corner = connected_components(same, directed=False)
    triangles = corner.reshape(-1, 3).astype(np.int32)
    points = np.empty((count, 3))
    points[corner] = at[tail]
    points = _part_lips(points, triangles, half, corner, tail)
    return TangentFrames.of(_remesh(points, triangles[kept], edge))


def _part_lips(
    points: Points,
    triangles: Int32Array,
    half: Mapping[tuple[int, int], HalfChain],
    corner: NDArray[np.integer],
    given: Int32Array,
) -> Points:
    """Vertices on cuts moved a little towards their own triangles."""
    on_cut = np.zeros(int(given.max()) + 1, np.bool_)
    on_cut[[v for pair in half for v in pair]] = True
    total, times = np.zeros_like(points), np.bincount(corner, minlength=len(points))
    middle = points[triangles].mean(axis=1)
    np.add.at(total, corner, np.repeat(middle, 3, axis=0))
    moved = points + LIP * (total / times[:, None] - points)
    chosen = np.zeros(len(points), np.bool_)
    chosen[corner[on_cut[given]]] = True
    return np.where(chosen[:, None], moved, points)


def _remesh(points: Points, triangles: Int32Array, edge: float) -> Surface:
    used, named = np.unique(triangles, return_inverse=True)
    try:
        cut = Surface.from_arrays(points[used], named.reshape(-1, 3).astype(np.int32)).orient()
        return Surface.from_arrays(*remesh_parts(cut, edge)).orient()
    except InvalidMeshError as error:
        place = format_place(points[used].mean(axis=0))
        raise RefusedError(
            f"what curves leave at {place} is smaller than a draft's edges; take a smaller edge"
        ) from error
