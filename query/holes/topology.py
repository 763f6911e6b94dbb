"""The half-edges of a mesh, how its faces are turned, and what is wrong with it."""

# scipy has no types: what it returns is typed by the function's own annotation.
# pyright: reportMissingTypeStubs=false

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb._native.query.holes.loops import turn_alike
from patterndb.core.halfedge import Int32Array, sort_by_edge
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.errors import InvalidMeshError
from patterndb.geometry.points import Floats, Points

#: Edges of more than two faces that a message names.
CROWDED_NAMED = 3

#: Ends of edges no further apart than this part of the edge lie at one place: a gap that can be
#: seen is wider, one that was not merged is rounding, or what a modeller mirrored a little off.
AT_ONE_PLACE = 0.05

#: How many edges nearest to one are looked at, itself among them: of a soup all that meet there.
LOOKED_AT = 6


@dataclass(frozen=True, slots=True, eq=False)
class MeshTopology:
    """The half-edges of a polygon mesh whose faces are turned alike, component by component.

    mesh:    as it was given; nothing of it is changed.
    tail, head, face: (h,) int32 of every half-edge, face after face, corner after corner.
    next, previous: (h,) int32 half-edges of the same face.
    twin:    (h,) int32 the half-edge that runs the other way, -1 at the border and at edges with
             more than two faces.
    flipped: (f,) bool, faces that were read backwards so that neighbours agree.
    crowded: (h,) bool, half-edges of edges that more than two faces share.
    start:   (f + 1,) int64 the first half-edge of each face.
    """

    mesh: PolygonMesh
    tail: Int32Array
    head: Int32Array
    face: Int32Array
    next: Int32Array
    previous: Int32Array
    twin: Int32Array
    flipped: NDArray[np.bool_]
    crowded: NDArray[np.bool_]
    start: NDArray[np.int64]

    @classmethod
    def of(cls, mesh: PolygonMesh) -> MeshTopology:
        """Join the faces of a mesh along their edges.

        Faces that a file gives backwards are turned as the first face of their component is,
        or as most of them are. Raises InvalidMeshError where no two sides can be told apart (a
        Moebius strip).
        """
        arity = mesh.arities()
        face = np.repeat(np.arange(mesh.n_faces, dtype=np.int32), arity)
        start = mesh.offsets
        tail = mesh.corners.astype(np.int32)
        at = np.arange(len(tail))
        first, last = start[face], start[face + 1] - 1
        following = np.where(at == last, first, at + 1)
        head = tail[following]
        partner, same_sense, crowded = _pair_edges(tail, head)
        flip, torn = turn_alike(face, partner, same_sense, start)
        if torn >= 0:
            raise InvalidMeshError(
                f"the faces around face {int(face[torn])} cannot all be turned the same way: the "
                "mesh is one-sided there (a Moebius strip); cut it along an edge"
            )
        back = flip[face]
        preceding = np.empty_like(following)
        preceding[following] = at
        return cls(
            mesh,
            np.where(back, head, tail).astype(np.int32),
            np.where(back, tail, head).astype(np.int32),
            face,
            np.where(back, preceding, following).astype(np.int32),
            np.where(back, following, preceding).astype(np.int32),
            partner,
            flip,
            crowded,
            start,
        )


def _pair_edges(
    tail: Int32Array, head: Int32Array
) -> tuple[Int32Array, NDArray[np.bool_], NDArray[np.bool_]]:
    """Pair the half-edges of every edge that two faces share.

    Returns (h,) the partner or -1, (h,) whether both run the same way, (h,) whether more than
    two share the edge.
    """
    order, start = sort_by_edge(tail, head)
    count = np.diff(start)
    pairs = start[:-1][count == 2]
    one, two = order[pairs], order[pairs + 1]
    partner = np.full(len(tail), -1, np.int32)
    partner[one], partner[two] = two, one
    crowded = np.zeros(len(tail), np.bool_)
    crowded[order[np.repeat(count > 2, count)]] = True
    same = np.zeros(len(tail), np.bool_)
    paired = partner >= 0
    same[paired] = tail[paired] == tail[partner[paired]]
    return partner, same, crowded


def explain_crowded(topology: MeshTopology) -> str:
    """Name the edges of more than two faces, by their vertices, and what follows from them."""
    crowded = np.flatnonzero(topology.crowded)
    ends = np.sort(np.stack([topology.tail[crowded], topology.head[crowded]], axis=1), axis=1)
    edges, first, count = np.unique(ends, axis=0, return_index=True, return_counts=True)
    named = "; ".join(
        f"{a}-{b} ({n} faces, such as face {topology.face[crowded[k]]})"
        for (a, b), k, n in zip(
            edges[:CROWDED_NAMED].tolist(), first.tolist(), count.tolist(), strict=False
        )
    )
    more = "; ..." if len(edges) > CROWDED_NAMED else ""
    are = "edge has" if len(edges) == 1 else "edges have"
    return (
        f"{len(edges):,} {are} more than two faces, between vertices {named}{more}: a border that "
        "ends there is no loop and cannot be filled; take the faces too many away, or part them"
    )


def explain_closed(topology: MeshTopology) -> str:
    """Say why a mesh without a border has no hole."""
    if topology.crowded.any():
        return f"the mesh has no border; {explain_crowded(topology)}"
    return "the mesh is closed: it has no border, and so no hole; name faces to be made anew"


def list_mesh_flaws(mesh: PolygonMesh | MeshTopology) -> tuple[str, ...]:
    """List what somebody that fills holes of a mesh should know of it, a sentence each.

    Edges of more than two faces, faces that are turned against their neighbours, border edges that
    lie on each other though no vertex joins them, and that a mesh is closed. Vertices and faces
    count from 0. Raises InvalidMeshError for a one-sided mesh.
    """
    topology = mesh if isinstance(mesh, MeshTopology) else MeshTopology.of(mesh)
    border = np.flatnonzero((topology.twin < 0) & ~topology.crowded)
    notes: list[str] = []
    if not len(border):
        notes.append(explain_closed(topology))
    elif topology.crowded.any():
        notes.append(explain_crowded(topology))
    turned = np.flatnonzero(topology.flipped)
    if len(turned):
        are = "face is" if len(turned) == 1 else "faces are"
        notes.append(
            f"{len(turned):,} {are} turned against the others of the same part, such as face "
            f"{turned[0]}; holes are found as if all were turned alike, and a fill is turned as "
            "most faces beside it are"
        )
    partner, apart = find_coincident_edges(
        topology.mesh.points, topology.tail[border], topology.head[border]
    )
    lying = np.flatnonzero(partner >= 0)
    if len(lying):
        names = [
            f"{topology.tail[border[i]]} and {topology.head[border[i]]}"
            for i in (lying[0], partner[lying[0]])
        ]
        notes.append(
            f"{len(lying):,} of {len(border):,} border edges lie on another one, up to "
            f"{apart[lying].max():.3g} away, such as that between vertices {names[0]} on that "
            f"between {names[1]}: the mesh is open there, though no gap is seen; if it should not "
            "be, merge the vertices that lie at one place first"
        )
    return tuple(notes)


def find_coincident_edges(
    points: Points, tail: Int32Array, head: Int32Array
) -> tuple[NDArray[np.int64], Floats]:
    """Find for every edge, from point tail (b,) to head (b,), another one that lies on it.

    Returns ((b,) the other edge or -1, (b,) how far apart their ends are at most).
    """
    n = len(tail)
    partner, apart = np.full(n, -1, np.int64), np.zeros(n)
    if n < 2:
        return partner, apart
    a, b = points[tail], points[head]
    middle, length = (a + b) / 2.0, np.linalg.norm(b - a, axis=1)
    reach = AT_ONE_PLACE * float(length.max())
    # Imported here because fills of boundaries load this module, and need no tree.
    from scipy.spatial import KDTree

    found = KDTree(middle).query(middle, min(LOOKED_AT, n), distance_upper_bound=reach + 1e-300)
    near: NDArray[np.int64] = np.asarray(found[1], np.int64)
    for column in near.T:
        there = np.flatnonzero((column < n) & (partner < 0))
        other = column[there]
        mine = other != there
        there, other = there[mine], other[mine]
        along = np.maximum(_measure(a, a, there, other), _measure(b, b, there, other))
        against = np.maximum(_measure(a, b, there, other), _measure(b, a, there, other))
        gap = np.minimum(along, against)
        close = gap <= AT_ONE_PLACE * np.minimum(length[there], length[other])
        close &= length[there] > 0.0
        partner[there[close]], apart[there[close]] = other[close], gap[close]
    return partner, apart


def _measure(one: Points, two: Points, i: NDArray[np.int64], j: NDArray[np.int64]) -> Floats:
    return np.linalg.norm(one[i] - two[j], axis=1)
