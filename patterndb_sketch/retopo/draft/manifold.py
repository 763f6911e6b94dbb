"""Prepare a surface for a field: part it where it touches itself, and refuse what no field lies on.

Meshes of modelling programs touch themselves in vertices and along edges where vertices were merged
by their distance. A field needs a disk around every vertex, so :func:`part_touching` gives each of
the fans of triangles that meet there a vertex of its own. Of more than two triangles at an edge
those go on together that are neighbours on the surface; an odd one ends there in a border.

:func:`refuse_thin_handles` looks for handles that no ring of quads closes around. A tree of
shortest paths from a root, and a tree of the triangles over the edges that it leaves, leave two
edges for each handle; each closes a loop that parts nothing. After Erickson and Whittlesey 2005,
"Greedy optimal homotopy and homology generators", with edges that reach furthest from the root
taken into the second tree first. From other roots loops are shorter: the ends of the shortest ones
so far are tried.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, dijkstra, minimum_spanning_tree

from patterndb.core.halfedge import Int32Array
from patterndb.errors import InvalidMeshError
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.draft.frames import TangentFrames
from patterndb_sketch.retopo.draft.settings import SETTINGS
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network.faces import SurfaceParts
from patterndb_sketch.retopo.wording import format_place, round_down

#: A fan's new vertex lies inward from where the fans touch by this part of its edges: more than
#: rounding, by which vertices would be taken for one again, and less than anybody sees.
INWARD = 0.01

#: A triangle has three sides: in so many rounds each is divided.
MOST_ROUNDS = 4

#: Least length of a loop around a handle, or through one, in target edges: three quads close
#: a tube, and it has no shape with fewer.
LEAST_AROUND = 3.0

#: Edges that close around a thin handle are shorter by this part: on a finer mesh the loop is a
#: little shorter.
CLOSING = 0.9


#: Loops whose ends are tried as roots.
TRIED = 4


@dataclass(frozen=True, slots=True, eq=False)
class PartedSurface:
    """surface: with the same triangles. touching: (k,) int32, vertices where fans had met."""

    surface: Surface
    touching: Int32Array


def part_touching(surface: Surface) -> PartedSurface:
    """The surface with a vertex for each fan of triangles; itself, where no fans touch.

    Raises RefusedError, with the place, where what is parted has one side only: sheets that were
    told apart by more than two triangles at an edge.
    """
    try:
        parted = _part_fans(surface)
        again = _divide_crowded(parted.surface)
    except InvalidMeshError as error:
        raise RefusedError(f"no draft: where parts of it touch, {error}") from error
    if again is parted.surface:
        return parted
    crowded = np.flatnonzero(np.diff(parted.surface.adjacency.side_start) > 2)
    ends = np.unique(parted.surface.adjacency.ends[crowded].ravel())
    ends = ends[ends < len(surface.vertices)]
    return PartedSurface(again, np.union1d(parted.touching, ends).astype(np.int32))


def _part_fans(surface: Surface) -> PartedSurface:
    """The same, for all but edges both of whose ends have their triangles in one fan."""
    corner = surface.triangles.ravel().astype(np.int64)
    fan = SurfaceParts.of(surface).fan
    pairs = np.unique(np.stack([corner, fan], axis=1), axis=0)
    fans = np.bincount(pairs[:, 0], minlength=len(surface.vertices))
    touching = np.flatnonzero(fans > 1).astype(np.int32)
    if not len(touching):
        return PartedSurface(surface, touching)
    vertices, more = surface.vertices.copy(), list[Points]()
    triangles = surface.triangles.copy().ravel()
    for vertex in touching.tolist():
        at = surface.vertices[vertex]
        for k, one in enumerate(pairs[pairs[:, 0] == vertex, 1].tolist()):
            mine = np.flatnonzero(fan == one)
            inward = at + INWARD * (_find_middle(surface, mine) - at)
            if k == 0:
                vertices[vertex] = inward
                continue
            triangles[mine] = len(vertices) + len(more)
            more.append(inward)
    parted = Surface.from_arrays(
        np.concatenate([vertices, more]), triangles.reshape(-1, 3)
    ).orient()
    return PartedSurface(parted, touching)


def _divide_crowded(surface: Surface) -> Surface:
    """The surface with a middle for each pair of triangles at edges of more than two whose ends are
    in one fan; itself, where there are none. Triangles with several such edges take rounds."""
    for _ in range(MOST_ROUNDS):
        topology = surface.adjacency
        crowded = np.flatnonzero(np.diff(topology.side_start) > 2)
        triangles, vertices = surface.triangles.tolist(), surface.vertices.tolist()
        changed: set[int] = set()
        for edge in crowded.tolist():
            sides = topology.sides[topology.side_start[edge] : topology.side_start[edge + 1]]
            if changed & {side // 3 for side in sides.tolist()}:
                # Divided already, by another side: in the next round.
                continue
            changed |= {side // 3 for side in sides.tolist()}
            middle: dict[int, int] = {}
            for side in sides.tolist():
                other = int(topology.across[side])
                pair = min(side, other) if other >= 0 else side
                a, b, c = surface.triangles[side // 3, (side % 3 + np.arange(3)) % 3].tolist()
                if pair not in middle:
                    own = [side] if other < 0 else [side, other]
                    at = topology.middles[edge]
                    opposite = [surface.triangles[s // 3, (s % 3 + 2) % 3] for s in own]
                    inward = surface.vertices[opposite].mean(axis=0)
                    middle[pair] = len(vertices)
                    vertices.append((at + INWARD * (inward - at)).tolist())
                triangles[side // 3] = [a, middle[pair], c]
                triangles.append([middle[pair], b, c])
        if not changed:
            return surface
        surface = Surface.from_arrays(np.array(vertices), np.array(triangles, np.int32)).orient()
    return surface


def _find_middle(surface: Surface, corners: NDArray[np.intp]) -> Points:
    """(3,) the middle of what is opposite these corners."""
    triangle, e = corners // 3, corners % 3
    opposite = surface.triangles[triangle[:, None], (e[:, None] + [1, 2]) % 3]
    return surface.vertices[opposite].mean(axis=(0, 1))


class ThinHandleError(RefusedError):
    """A handle of the surface is too thin; edge: a length with which it is not, perhaps shorter
    than a draft may have."""

    def __init__(self, message: str, edge: float) -> None:
        super().__init__(message)
        self.edge = edge


def refuse_thin_handles(mesh: TangentFrames, edge: float, diagonal: float) -> None:
    """Raise ThinHandleError, with the place, for a surface with a handle that no ring of quads of
    this edge goes around, or through: a lace, or the slit below it."""
    found = find_shortest_handle(mesh)
    if found is not None and found.length < LEAST_AROUND * edge:
        finer = round_down(CLOSING * found.length / LEAST_AROUND)
        ways = ["close the opening if it is not meant", "draw by hand"]
        if finer >= SETTINGS.least_edge * diagonal:
            ways.insert(0, f"take an edge of {finer:g}")
        raise ThinHandleError(
            f"no draft: a handle of the surface, or the opening through it, is {found.length:.3g} "
            f"around at {format_place(found.middle)}, and an edge is {edge:.3g}: no ring of quads "
            f"closes there; {', '.join(ways[:-1])}, or {ways[-1]}",
            finer,
        )


def check_surface(surface: Surface) -> None:
    """Raise RefusedError, with the place, for a surface on which no field can lie."""
    topology, triangles = surface.adjacency, surface.triangles
    uses = np.diff(topology.side_start)
    shared = np.flatnonzero(uses > 2)
    if len(shared):
        raise RefusedError(
            # How many is not told: the surface may be a finer one than the surface that was given.
            "edges have more than two triangles, the first at "
            f"{format_place(topology.middles[shared[0]])}: part the sheets that touch there"
        )
    fans = np.bincount(triangles.ravel(), minlength=len(surface.vertices))
    mesh = TangentFrames.of(surface)
    for vertex in np.flatnonzero(fans).tolist():
        if len(mesh.list_ring(vertex)) != fans[vertex]:
            raise RefusedError(
                "parts of the surface touch in one vertex at "
                f"{format_place(surface.vertices[vertex])}: part them, or join them along an edge"
            )


@dataclass(frozen=True, slots=True, eq=False)
class HandleLoop:
    """length: of a loop along edges, about the shortest around its handle. middle: (3,) of it."""

    length: float
    middle: Points


def find_shortest_handle(mesh: TangentFrames) -> HandleLoop | None:
    """The shortest loop along edges that parts nothing; None where every loop does.

    Loops around borders part what is beyond them: a sheet with holes has no handle.
    """
    parts, part = connected_components(mesh.edge_graph, directed=False)
    used = np.unique(mesh.triangles)
    best: HandleLoop | None = None
    for number in range(parts):
        own = used[part[used] == number]
        if not len(own):
            continue
        found = sorted(_list_loops(mesh, int(own[0])), key=lambda loop: loop[0])
        for _, start, _ in found[:TRIED]:
            found += _list_loops(mesh, start)
        for length, _, loop in found:
            if best is None or length < best.length:
                best = HandleLoop(length, mesh.vertices[loop].mean(axis=0))
    return best


def _list_loops(mesh: TangentFrames, root: int) -> list[tuple[float, int, list[int]]]:
    """Two loops for each handle of the root's part: length, a vertex on it, and all of them."""
    far, before = dijkstra(mesh.edge_graph, indices=root, return_predecessors=True)
    ends = mesh.surface.adjacency.ends
    one, two = ends[:, 0], ends[:, 1]
    tree = (before[one] == two) | (before[two] == one)
    open_ = np.flatnonzero(~tree & np.isfinite(far[one]))
    size = np.linalg.norm(mesh.vertices[one[open_]] - mesh.vertices[two[open_]], axis=1)
    reach = far[one[open_]] + far[two[open_]] + size
    order = open_[np.argsort(-reach, kind="stable")]
    found: list[tuple[float, int, list[int]]] = []
    for edge in order[~_span_tree(_find_beside(mesh)[order])].tolist():
        loop = _close_loop(before, int(one[edge]), int(two[edge]))
        steps = mesh.vertices[loop] - mesh.vertices[np.roll(loop, -1)]
        found.append((float(np.linalg.norm(steps, axis=1).sum()), loop[0], loop))
    return found


def _span_tree(pairs: Int32Array) -> NDArray[np.bool_]:
    """(n,) which of pairs of numbers (n, 2), the first first, are a tree that spans all: each that
    joins what those before it do not (Kruskal 1956)."""
    low, high = pairs.min(axis=1), pairs.max(axis=1)
    rank = np.arange(1, len(pairs) + 1)
    # Of pairs that are given twice the second closes a ring of two.
    _, first = np.unique((low.astype(np.int64) << 32) | high, return_index=True)
    first = first[low[first] != high[first]]
    size = int(high.max(initial=-1)) + 1
    graph = coo_array((rank[first].astype(np.float64), (low[first], high[first])), (size, size))
    found = np.zeros(len(pairs), np.bool_)
    found[np.rint(minimum_spanning_tree(graph.tocsr()).data).astype(np.int64) - 1] = True
    return found


def _find_beside(mesh: TangentFrames) -> Int32Array:
    """(e, 2) the two triangles of every edge; beyond a border its loop, numbered after them."""
    adjacency = mesh.surface.adjacency
    n, border = len(mesh.triangles), adjacency.border
    rim_of = {vertex: k for k, rim in enumerate(mesh.rims) for vertex in rim}
    rim = np.array([rim_of[tail] for tail in mesh.border_ends[0].tolist()], np.int32)
    found = np.empty((len(adjacency.ends), 2), np.int32)
    start = adjacency.side_start[:-1]
    found[:, 0] = adjacency.sides[start] // 3
    found[:, 1] = adjacency.sides[adjacency.side_start[1:] - 1] // 3
    found[adjacency.edges[border], 1] = n + rim
    return found


def _close_loop(before: Int32Array, one: int, two: int) -> list[int]:
    """The vertices of two paths to a root and the edge between their ends, without what both
    have."""
    paths: list[list[int]] = []
    for vertex in (one, two):
        path = [vertex]
        while before[path[-1]] >= 0:
            path.append(int(before[path[-1]]))
        paths.append(path)
    here, there = paths
    while len(here) > 1 and len(there) > 1 and here[-2] == there[-2]:
        here.pop()
        there.pop()
    return [*here, *reversed(there[:-1])]
