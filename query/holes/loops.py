"""Where a mesh is open: border loops, and the loops around faces that are to be made anew."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from patterndb._native.query.holes.loops import flood, walk_borders
from patterndb.core.halfedge import Int32Array
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import InvalidMeshError
from patterndb.verbs import HoleVerbs
from query.holes.topology import (
    MeshTopology,
    explain_closed,
    explain_crowded,
    find_coincident_edges,
)

#: A mesh with more border loops than this share of its faces is a soup, if more than this share of
#: its border edges lie on others.
SOUP = 0.5

#: Faces of a mesh that are no island may share a loop's plane by chance; only loops that lie within
#: another, seen along its normal, and nearer to its plane than this part of its diameter, are told.
NEAR_PLANE = 0.25


@dataclass(frozen=True, slots=True, eq=False)
class Hole(HoleVerbs):
    """A loop to be filled, and what stays around it.

    topology: the whole mesh.
    loop:     (L,) int32 vertices of the mesh, such that quads within run along it.
    edges:    (L,) int32 the half-edge outside that runs from loop vertex i + 1 to i, -1 where
              the loop runs along the border of the mesh.
    removed:  (k,) int32 faces that the fill replaces, ascending; none for a border loop.
    outside:  the mesh cut open around the faces that are removed: no face outside has one of them
              across an edge. All that is measured around a hole is measured here, so that it does
              not depend on the faces that a fill replaces.
    """

    topology: MeshTopology
    loop: Int32Array
    edges: Int32Array
    removed: Int32Array
    outside: MeshTopology = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "outside", _cut_open(self.topology, self.removed))

    @property
    def points(self) -> NDArray[np.float64]:
        """(L, 3) where the loop's vertices lie."""
        return self.topology.mesh.points[self.loop]

    @property
    def length(self) -> float:
        """How long the loop is, in units of the mesh."""
        points = self.points
        return float(np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1).sum())

    @property
    def centre(self) -> NDArray[np.float64]:
        """(3,) the mean of the loop's vertices."""
        return self.points.mean(axis=0)

    def __len__(self) -> int:
        return len(self.loop)

    def to_json(self) -> dict[str, object]:
        """The loop as JSON takes it: its vertices, how many edges, its centre and length."""
        return {
            "loop": self.loop.tolist(),
            "edges": len(self),
            "centre": self.centre.tolist(),
            "length": self.length,
        }

    def runs_backwards(self) -> bool:
        """Must quads of a fill be turned over to agree with most faces beside the loop, as the file
        has them?"""
        beside = self.topology.face[self.edges[self.edges >= 0]]
        if not len(beside):
            beside = self.removed
        return len(beside) > 0 and 2 * int(self.topology.flipped[beside].sum()) > len(beside)


def find_holes(mesh: PolygonMesh | MeshTopology) -> list[Hole]:
    """List the border loops of a mesh, shortest number of edges first.

    A loop that runs through a vertex twice is one loop; an open mesh's outer rim is listed too:
    which of the loops are holes only the user can know. A border that ends at an edge of more than
    two faces is no loop (:func:`query.holes.topology.list_mesh_flaws` names such edges).

    Raises InvalidMeshError for a one-sided mesh, where no border is a loop, and for a soup, whose
    faces have vertices of their own.
    """
    topology = mesh if isinstance(mesh, MeshTopology) else MeshTopology.of(mesh)
    border = np.flatnonzero((topology.twin < 0) & ~topology.crowded)
    loops, starts = walk_borders(
        border.astype(np.int32), topology.twin, topology.previous, topology.crowded
    )
    holes: list[Hole] = []
    nothing = np.zeros(0, np.int32)
    for first, last in zip(starts[:-1].tolist(), starts[1:].tolist(), strict=True):
        edges = loops[first:last]
        if (edges < 0).any():
            continue  # it ends at an edge of more than two faces, as no loop
        holes.append(Hole(topology, topology.head[edges].copy(), edges, nothing))
    if not holes and len(border):
        raise InvalidMeshError(explain_crowded(topology))
    if len(holes) > SOUP * topology.mesh.n_faces and len(holes) > 1:
        _refuse_soup(topology, border)
    holes.sort(key=lambda hole: (len(hole), int(hole.loop.min())))
    return holes


def _refuse_soup(topology: MeshTopology, border: NDArray[np.int64]) -> None:
    """Raise InvalidMeshError where most border edges lie on others."""
    points, tail, head = topology.mesh.points, topology.tail[border], topology.head[border]
    partner, _ = find_coincident_edges(points, tail, head)
    if (partner >= 0).mean() > SOUP:
        raise InvalidMeshError(
            f"the mesh is a soup: most of its {topology.mesh.n_faces:,} faces have vertices of "
            "their own where they should share them, so that every face looks like an island; "
            "merge the vertices that lie at one place first"
        )


def choose_hole(
    mesh: PolygonMesh | MeshTopology | Hole,
    *,
    loop: int | Sequence[int] | None = None,
    faces: Iterable[int] | None = None,
) -> Hole:
    """Find the hole that is meant: see :func:`fill_holes`.

    Raises InvalidMeshError where that cannot be told, and for a hole with an island.
    """
    if isinstance(mesh, Hole):
        if loop is not None or faces is not None:
            raise InvalidMeshError("a hole is given; loop and faces would name another")
        if not len(mesh.removed):
            _refuse_islands(mesh, find_holes(mesh.topology))
        return mesh
    topology = mesh if isinstance(mesh, MeshTopology) else MeshTopology.of(mesh)
    if loop is not None and faces is not None:
        raise InvalidMeshError("name a loop or faces, not both")
    if faces is not None:
        return hole_of_faces(topology, faces)
    holes = find_holes(topology)
    if loop is not None:
        hole = hole_of_loop(topology, loop)
    elif len(holes) == 1:
        (hole,) = holes
    elif not holes:
        raise InvalidMeshError(explain_closed(topology))
    else:
        sizes = ", ".join(f"{len(h)} edges at vertex {int(h.loop[0])}" for h in holes[:6])
        raise InvalidMeshError(
            f"the mesh has {len(holes)} border loops ({sizes}{', ...' if len(holes) > 6 else ''}); "
            "name a vertex of the one to be filled"
        )
    _refuse_islands(hole, holes)
    return hole


def _refuse_islands(hole: Hole, others: Sequence[Hole]) -> None:
    islands = find_islands(hole, others)
    if islands:
        at = int(islands[0].loop[0])
        raise InvalidMeshError(
            f"the hole at vertex {int(hole.loop[0])} has an island within: another part of "
            f"the mesh, with vertex {at}; join it to the rim by a face, or take it out"
        )


def hole_of_loop(topology: MeshTopology, vertices: int | Sequence[int]) -> Hole:
    """Return the border loop through a vertex, or through all of several vertices, in either sense.

    Raises InvalidMeshError where no border loop, or more than one, runs through all of them.
    """
    vertices = [vertices] if isinstance(vertices, int | np.integer) else vertices
    named = {int(v) for v in vertices}
    if not named:
        raise InvalidMeshError("name one or more vertices of the loop")
    unknown = [v for v in named if not 0 <= v < len(topology.mesh.points)]
    if unknown:
        raise InvalidMeshError(
            f"vertex {unknown[0]} is not in the mesh, which has {len(topology.mesh.points)} "
            "vertices, counted from 0"
        )
    loops = find_holes(topology)
    if not loops:
        raise InvalidMeshError(explain_closed(topology))
    found = [hole for hole in loops if named <= set(hole.loop.tolist())]
    whole = [hole for hole in found if len(hole) == len(named)]
    found = whole or found
    if not found:
        inner = named.difference(*(hole.loop.tolist() for hole in loops))
        told = (
            f"no border loop runs through vertex {min(inner)}; list the loops first"
            if inner
            else f"no border loop runs through all of vertices {sorted(named)[:8]}: they are on "
            "several; name each hole by itself"
        )
        if inner and topology.crowded.any():
            told += f"; {explain_crowded(topology)}"
        raise InvalidMeshError(told)
    if len(found) > 1:
        raise InvalidMeshError(
            f"{len(found)} border loops run through vertices {sorted(named)[:8]}; name more of them"
        )
    return _turned_to(found[0], [int(v) for v in vertices])


def hole_of_faces(topology: MeshTopology, faces: Iterable[int]) -> Hole:
    """The loop around faces that are to be made anew.

    Raises InvalidMeshError for faces that are not in the mesh, do not hang together, or enclose
    others (an island): their border would be several loops.
    """
    chosen = np.unique(np.fromiter((int(f) for f in faces), np.int64))
    n_faces = topology.mesh.n_faces
    if not len(chosen):
        raise InvalidMeshError("name one or more faces")
    if chosen[0] < 0 or chosen[-1] >= n_faces:
        wrong = int(chosen[0] if chosen[0] < 0 else chosen[-1])
        raise InvalidMeshError(
            f"face {wrong} is not in the mesh, which has {n_faces} faces, counted from 0"
        )
    inside = np.zeros(n_faces, np.bool_)
    inside[chosen] = True
    twin = topology.twin
    mine = inside[topology.face]
    rim = np.flatnonzero(mine & ((twin < 0) | ~inside[topology.face[twin]]))
    loops = _loops_within(topology, inside, rim)
    pieces = _count_pieces(topology, inside, chosen)
    if pieces > 1:
        raise InvalidMeshError(
            f"the {len(chosen)} faces are {pieces} separate pieces; fill them one after the other"
        )
    if len(loops) != 1:
        sizes = ", ".join(str(len(loop)) for loop in loops)
        raise InvalidMeshError(
            f"the faces enclose an island: their border is {len(loops)} loops, of {sizes} edges, "
            "and a fill has one; take the island's faces too, or leave a bridge to it"
            if loops
            else "the faces are a closed surface: they have no border to be filled"
        )
    (edges,) = loops
    # The loop runs as the removed faces did, so the outside half-edge is the twin. It begins at the
    # first of these, where the border loop begins that is left when the faces are deleted.
    outside = np.where(twin[edges] >= 0, twin[edges], -1).astype(np.int32)
    begin = int(np.where(outside >= 0, outside, len(twin)).argmin())
    return Hole(
        topology,
        np.roll(topology.tail[edges], -begin),
        np.roll(outside, -begin),
        chosen.astype(np.int32),
    )


def hole_on_loop(topology: MeshTopology, loop: Sequence[int]) -> Hole:
    """The hole whose loop runs through these vertices in order.

    Where no face is beside one of its edges, the mesh keeps its border there.
    """
    half = {
        (int(topology.tail[h]), int(topology.head[h])): h
        for h in np.flatnonzero(np.isin(topology.tail, loop)).tolist()
    }
    edges = [half.get((b, a), -1) for a, b in zip(loop, [*loop[1:], loop[0]], strict=True)]
    return Hole(
        topology, np.array(loop, np.int32), np.array(edges, np.int32), np.zeros(0, np.int32)
    )


def find_islands(hole: Hole, others: Sequence[Hole]) -> list[Hole]:
    """Loops of other components that lie within a hole, near its plane: what a fill would cover."""
    points = hole.points
    centre = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - centre, full_matrices=False)
    flat = (points - centre) @ axes[:2].T
    size = float(np.ptp(flat, axis=0).max())
    piece = _component_of(hole)
    found: list[Hole] = []
    for other in others:
        if other is hole or _component_of(other) == piece:
            continue
        at = other.points - centre
        near = np.abs(at @ axes[2]).max() < NEAR_PLANE * size
        if near and all(_is_within(flat, p) for p in at @ axes[:2].T):
            found.append(other)
    return found


def _cut_open(topology: MeshTopology, removed: Int32Array) -> MeshTopology:
    """Return the same mesh where faces that stay and faces that are removed have no common edge."""
    if not len(removed):
        return topology
    gone = np.zeros(topology.mesh.n_faces, np.bool_)
    gone[removed] = True
    gone_at = gone[topology.face]
    rim = (topology.twin >= 0) & (gone_at != gone_at[topology.twin])
    return replace(topology, twin=np.where(rim, -1, topology.twin).astype(np.int32))


def _component_of(hole: Hole) -> int:
    """The smallest face reached from the loop's outside by way of edges."""
    start = (
        int(hole.topology.face[hole.edges[hole.edges >= 0][0]]) if (hole.edges >= 0).any() else -1
    )
    if start < 0:
        return -1
    return int(flood(start, hole.topology.face, hole.topology.twin, hole.topology.start).min())


def _is_within(polygon: NDArray[np.float64], point: NDArray[np.float64]) -> bool:
    """Is a point (2,) inside a polygon (n, 2)? By the parity of crossings."""
    a, b = polygon, np.roll(polygon, -1, axis=0)
    spans = (a[:, 1] > point[1]) != (b[:, 1] > point[1])
    height = np.where(spans, b[:, 1] - a[:, 1], 1.0)
    x = a[:, 0] + (point[1] - a[:, 1]) * (b[:, 0] - a[:, 0]) / height
    return bool((spans & (x > point[0])).sum() % 2)


def _turned_to(hole: Hole, vertices: list[int]) -> Hole:
    """The same loop, beginning at the first vertex that was named."""
    at = int(np.flatnonzero(hole.loop == vertices[0])[0])
    return Hole(hole.topology, np.roll(hole.loop, -at), np.roll(hole.edges, -at), hole.removed)


def _loops_within(
    topology: MeshTopology, inside: NDArray[np.bool_], rim: NDArray[np.int64]
) -> list[Int32Array]:
    """The loops that the rim half-edges of chosen faces form, as the faces run."""
    on_rim = np.zeros(len(topology.tail), np.bool_)
    on_rim[rim] = True
    loops: list[Int32Array] = []
    left = on_rim.copy()
    for first in rim.tolist():
        if not left[first]:
            continue
        loop: list[int] = []
        h = first
        while left[h]:
            left[h] = False
            loop.append(h)
            h = int(topology.next[h])
            while not on_rim[h]:
                h = int(topology.next[topology.twin[h]])
        loops.append(np.array(loop, np.int32))
    return loops


def _count_pieces(
    topology: MeshTopology, inside: NDArray[np.bool_], chosen: NDArray[np.int64]
) -> int:
    """How many pieces faces form, joined by edges."""
    left = set(chosen.tolist())
    pieces = 0
    while left:
        pieces += 1
        stack = [left.pop()]
        while stack:
            f = stack.pop()
            for h in range(int(topology.start[f]), int(topology.start[f + 1])):
                g = int(topology.twin[h])
                other = int(topology.face[g]) if g >= 0 else -1
                if other in left:
                    left.remove(other)
                    stack.append(other)
    return pieces
