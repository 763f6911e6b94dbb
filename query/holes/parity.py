"""Parity fixes: where a loop has an odd number of edges, no quads alone can fill it.

Each fix changes the mesh a little so that the loop gets one edge more or less; which is right only
the user can know. Its description includes what it does to faces outside.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from patterndb.core.polygonmesh import PolygonMesh
from query.boundary import MAX_PERIMETER, MIN_PERIMETER
from query.errors import InvalidQueryError
from query.holes.loops import Hole, find_holes, hole_on_loop
from query.holes.topology import MeshTopology

#: The kinds of fixes, in the order in which they are listed, and what each does.
FixKind = Literal["triangle", "edge-loop", "split", "merge"]
KINDS: dict[FixKind, str] = {
    "triangle": "one triangle within, all else quads",
    "edge-loop": "a new loop of edges, led out through the quads around",
    "split": "an edge of the loop split in two",
    "merge": "two edges of the loop merged into one",
}

#: A loop of edges is led out through no more quads than this.
LONGEST_EDGE_LOOP = 400

#: Fixes of a kind that are compared by what they do to other holes.
FIXES_COMPARED = 30

#: A triangle cut off at a corner wider than this, in radians, would be a sliver.
WIDEST_EAR = np.radians(135.0)


@dataclass(frozen=True, slots=True, eq=False)
class ParityFix:
    """A change of a mesh that makes an odd loop even.

    kind:        see KINDS.
    cost:        fixes of one kind are sorted by this, smallest first.
    description: what it does, as a sentence goes on after "the nearest way: ".
    """

    kind: FixKind
    cost: float
    description: str
    _hole: Hole = field(repr=False)
    _edit: _MeshEdit = field(repr=False)

    @property
    def changes(self) -> tuple[int, ...]:
        """Old faces that get other corners, numbers of the mesh as it was given."""
        return tuple(sorted(self._edit.faces))

    def apply(self) -> Hole:
        """Make the changed mesh: its hole, whose loop is even.

        Old vertices keep their numbers and places, new ones come after. Faces that the hole was to
        replace are gone; those that stay keep their order.
        """
        return self._edit.apply(self._hole)


@dataclass(frozen=True, slots=True, eq=False)
class _MeshEdit:
    """faces: old faces with their new corners. added, inside: faces that come after all others,
    the latter within the loop and along it. points: new vertices. loop: of the hole afterwards."""

    loop: list[int]
    points: list[NDArray[np.float64]] = field(default_factory=list)
    faces: dict[int, list[int]] = field(default_factory=dict)
    added: list[list[int]] = field(default_factory=list)
    inside: list[list[int]] = field(default_factory=list)

    def apply(self, hole: Hole) -> Hole:
        mesh = hole.topology.mesh
        gone = set(hole.removed.tolist())
        faces = [self.faces.get(f, face) for f, face in enumerate(mesh.faces()) if f not in gone]
        points = np.concatenate([mesh.points, np.array(self.points).reshape(-1, 3)])
        inside = [face[::-1] if hole.runs_backwards() else face for face in self.inside]
        changed = PolygonMesh.from_faces(points, faces + self.added + inside)
        return hole_on_loop(MeshTopology.of(changed), self.loop)


def list_parity_fixes(hole: Hole, most: int = 1) -> list[ParityFix]:
    """List the nearest fixes to make an odd loop even, up to ``most`` of each kind, best first.

    None for an even loop. A triangle that cuts off a corner, or stands on an edge; a loop of edges
    that leaves the hole lengthwise through quads, to a border or a face that is no quad; an edge
    split, or two merged, for which a face beside it changes its number of sides.
    """
    if len(hole) % 2 == 0:
        return []
    found: list[ParityFix] = []
    for fixes in (_triangles(hole), _edge_loops(hole), _splits(hole), _merges(hole)):
        found += sorted(fixes, key=lambda fix: fix.cost)[:most]
    return found


def refuse_unfillable(hole: Hole) -> None:
    """Raise InvalidQueryError for a loop that quads cannot fill, with the nearest remedies."""
    n = len(hole)
    if n % 2:
        fixes = [f"{fix.kind}: {fix.description}" for fix in list_parity_fixes(hole)]
        remedy = "nearest ways: " + "; ".join(fixes)
        raise InvalidQueryError(
            f"the loop at vertex {int(hole.loop[0])} has {n} edges, an odd number, and quads alone "
            f"cannot fill it; {remedy if fixes else 'nor is there a way to change it by one edge'}"
            "; ngon fills it with one face"
        )
    if not MIN_PERIMETER <= n <= MAX_PERIMETER:
        raise InvalidQueryError(
            f"the loop has {n} edges; loops of {MIN_PERIMETER} to {MAX_PERIMETER} can be filled"
        )


def make_loops_even(
    topology: MeshTopology, kind: FixKind, among: Collection[int] | None = None
) -> tuple[MeshTopology, list[str]]:
    """Make odd border loops of a mesh even, one after another, each by its nearest fix of a kind
    that makes no other odd.

    among: of these vertices; a loop through none of them stays as it is. Returns the mesh
    afterwards, whose old vertices keep their numbers and places, and what was done, in words. A
    loop without such a fix stays odd; so does one that an edge loop out of a later loop runs into.
    """
    done: set[int] = set()
    descriptions: list[str] = []
    while True:
        odd = (hole for hole in find_holes(topology) if len(hole) % 2)
        loops = ((hole, set(hole.loop.tolist())) for hole in odd)
        if among is not None:
            loops = ((hole, loop) for hole, loop in loops if not loop.isdisjoint(among))
        hole, loop = next(((h, loop) for h, loop in loops if done.isdisjoint(loop)), (None, done))
        if hole is None:
            return topology, descriptions
        done |= loop
        # An edge loop may end at the rim of another hole, and make that odd instead, or even too.
        fixes = [fix for fix in list_parity_fixes(hole, FIXES_COMPARED) if fix.kind == kind]
        changed = ((_count_odd(fix.apply().topology, among), fix) for fix in fixes)
        before = _count_odd(topology, among)
        best = next((fix for count, fix in changed if count < before), next(iter(fixes), None))
        if best is not None:
            topology = best.apply().topology
            descriptions.append(best.description)


def _count_odd(topology: MeshTopology, among: Collection[int] | None) -> int:
    """Count odd border loops (through one of these vertices)."""
    odd = [hole for hole in find_holes(topology) if len(hole) % 2]
    if among is None:
        return len(odd)
    return sum(not set(hole.loop.tolist()).isdisjoint(among) for hole in odd)


def _triangles(hole: Hole) -> Iterator[ParityFix]:
    """Triangles that cut off a corner of the loop, or stand on one of its edges."""
    points, loop = hole.points, hole.loop.tolist()
    n = len(loop)
    normals = _inward_normals(hole)
    first_new = len(hole.topology.mesh.points)
    lengths = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    mean = float(lengths.mean())
    for i in range(n):
        a, b, c = points[i - 1], points[i], points[(i + 1) % n]
        around = _angles_of(a, b, c)
        inside = _angle_inside(a, b, c, normals[i])
        if n - 1 >= MIN_PERIMETER and inside < WIDEST_EAR and loop[i - 1] != loop[(i + 1) % n]:
            description = f"a triangle that cuts off the corner at vertex {loop[i]}"
            face = [loop[i - 1], loop[i], loop[(i + 1) % n]]
            rest = loop[:i] + loop[i + 1 :]
            edit = _MeshEdit(rest, inside=[face])
            yield ParityFix("triangle", _skew(around), description, hole, edit)
        # The apex of a triangle on edge i, as high as an equilateral one of the loop's mean edge.
        d = c - b
        inward = np.cross(normals[i] + normals[(i + 1) % n], d)
        size = float(np.linalg.norm(inward))
        if size <= 0:
            continue
        apex = (b + c) / 2 + inward / size * (np.sqrt(0.75) * (lengths[i] + mean) / 2)
        others = np.delete(points, [i, (i + 1) % n], axis=0)
        room = float(np.linalg.norm(others - apex, axis=1).min()) if len(others) else np.inf
        crowding = max(0.0, 1.0 - room / max(mean, 1e-300))
        # Inside stands an irregular vertex more than where a corner is cut off.
        cost = _skew(_angles_of(b, c, apex)) + 2 * crowding + 0.5
        description = f"a triangle on the edge from vertex {loop[i]} to {loop[(i + 1) % n]}"
        face = [loop[i], loop[(i + 1) % n], first_new]
        longer = [*loop[: i + 1], first_new, *loop[i + 1 :]]
        edit = _MeshEdit(longer, [apex], inside=[face])
        yield ParityFix("triangle", cost, description, hole, edit)


def _splits(hole: Hole) -> Iterator[ParityFix]:
    """Edges of the loop that get a vertex in their middle."""
    points, loop = hole.points, hole.loop.tolist()
    n = len(loop)
    new = len(hole.topology.mesh.points)
    lengths = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    for i in range(n):
        a, b = loop[i], loop[(i + 1) % n]
        middle = (points[i] + points[(i + 1) % n]) / 2
        cost = -float(np.log(max(lengths[i], 1e-300) / max(lengths.mean(), 1e-300)))
        description = f"the edge from vertex {a} to {b} split"
        longer = [*loop[: i + 1], new, *loop[i + 1 :]]
        face = _face_beside(hole, i)
        if face < 0:
            yield ParityFix("split", cost, description, hole, _MeshEdit(longer, [middle]))
            continue
        corners = _corners_of(hole, face)
        wider = _insert_between(corners, a, b, new)
        cost += _odd_face_cost(len(wider))
        description += f"; face {face} outside becomes {_name_face(len(wider))}"
        edit = _MeshEdit(longer, [middle], {face: wider})
        yield ParityFix("split", cost, description, hole, edit)


def _merges(hole: Hole) -> Iterator[ParityFix]:
    """Vertices of the loop that are drawn into the next one or the one before."""
    t, loop = hole.topology, hole.loop.tolist()
    n = len(loop)
    if n - 1 < MIN_PERIMETER:
        return
    points = hole.points
    lengths = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    gone = set(hole.removed.tolist())
    at_vertex: dict[int, list[int]] = {}
    for h in np.flatnonzero(np.isin(t.tail, hole.loop)).tolist():
        if int(t.face[h]) not in gone:
            at_vertex.setdefault(int(t.tail[h]), []).append(int(t.face[h]))
    for i in range(n):
        for j, edge in (((i + 1) % n, i), ((i - 1) % n, (i - 1) % n)):
            v, into = loop[i], loop[j]
            beside = _face_beside(hole, edge)
            if beside < 0 or loop.count(v) > 1 or loop.count(into) > 1:
                continue
            changed: dict[int, list[int]] = {}
            for f in at_vertex.get(v, []):
                corners = [into if c == v else c for c in _corners_of(hole, f)]
                if f == beside:
                    corners.remove(into)
                changed[f] = corners
            if any(len(set(c)) < len(c) or len(c) < 3 for c in changed.values()):
                continue
            if _neighbours(hole, v, at_vertex) & _neighbours(hole, into, at_vertex):
                continue  # an edge would be doubled
            cost = float(np.log(max(lengths[edge], 1e-300) / max(lengths.mean(), 1e-300)))
            cost += _odd_face_cost(len(changed[beside]))
            description = (
                f"vertex {v} drawn into vertex {into}; face {beside} outside becomes "
                f"{_name_face(len(changed[beside]))}"
            )
            shorter = loop[:i] + loop[i + 1 :]
            edit = _MeshEdit(shorter, faces=changed)
            yield ParityFix("merge", cost, description, hole, edit)


def _edge_loops(hole: Hole) -> Iterator[ParityFix]:
    """Loops of edges that leave the hole through the middle of the quads outside."""
    t, loop = hole.topology, hole.loop.tolist()
    n = len(loop)
    gone = np.zeros(t.mesh.n_faces, np.bool_)
    gone[hole.removed] = True
    own = {int(h) for h in hole.edges.tolist() if h >= 0}
    points = t.mesh.points
    for i in range(n):
        h = int(hole.edges[i])
        if h < 0:
            continue
        crossed = [h]
        faces: list[int] = []
        end = -1  # the last face, which is no quad
        while h >= 0:
            f = int(t.face[h])
            if gone[f] or f in faces or len(faces) >= LONGEST_EDGE_LOOP:
                crossed = []
                break
            if t.start[f + 1] - t.start[f] != 4:
                end = f
                break
            faces.append(f)
            out = int(t.next[t.next[h]])
            if out in own:
                crossed = []  # it comes back to the loop, which would be odd again
                break
            crossed.append(out)
            h = int(t.twin[out])
            if h < 0 and t.crowded[out]:
                crossed = []
                break
        if not crossed or not faces:
            continue
        first_new = len(points)
        # crossed[k] and crossed[k + 1] are edges of faces[k]; new vertex k lies on crossed[k].
        ends = [(int(t.tail[c]), int(t.head[c])) for c in crossed]
        new = [(points[a] + points[b]) / 2 for a, b in ends]
        changed: dict[int, list[int]] = {}
        added: list[list[int]] = []
        for k, f in enumerate(faces):
            one, two = _halve_quad(_corners_of(hole, f), ends[k], first_new + k, first_new + k + 1)
            changed[f] = one
            added.append(two)
        cost = len(faces) / 10.0
        if end >= 0:
            corners = _insert_between(_corners_of(hole, end), *ends[-1], first_new + len(faces))
            changed[end] = corners
            cost += _odd_face_cost(len(corners))
            where = f"to face {end}, which becomes {_name_face(len(corners))}"
        else:
            where = f"to the border edge from vertex {ends[-1][1]} to {ends[-1][0]}, which is split"
        description = f"a loop of edges led out through {len(faces)} quads, {where}"
        longer = [*loop[: i + 1], first_new, *loop[i + 1 :]]
        edit = _MeshEdit(longer, new, changed, added)
        yield ParityFix("edge-loop", cost, description, hole, edit)


def _neighbours(hole: Hole, vertex: int, at_vertex: dict[int, list[int]]) -> set[int]:
    """Vertices joined to one of the loop by an edge of a face outside."""
    found: set[int] = set()
    for f in at_vertex.get(vertex, []):
        corners = _corners_of(hole, f)
        k = corners.index(vertex)
        found |= {corners[k - 1], corners[(k + 1) % len(corners)]}
    return found


def _corners_of(hole: Hole, face: int) -> list[int]:
    """Corners of a face as the file has them."""
    mesh = hole.topology.mesh
    return mesh.corners[mesh.offsets[face] : mesh.offsets[face + 1]].tolist()


def _face_beside(hole: Hole, i: int) -> int:
    """The face outside along loop edge i; -1 where there is none."""
    h = int(hole.edges[i])
    return int(hole.topology.face[h]) if h >= 0 else -1


def _insert_between(corners: list[int], a: int, b: int, new: int) -> list[int]:
    """Corners of a face with a vertex on its edge between a and b."""
    for k, c in enumerate(corners):
        if {c, corners[(k + 1) % len(corners)]} == {a, b}:
            return [*corners[: k + 1], new, *corners[k + 1 :]]
    raise AssertionError("the edge is one of the face's")


def _halve_quad(
    corners: list[int], entered: tuple[int, int], first: int, second: int
) -> tuple[list[int], list[int]]:
    """Two quads for one, cut from the vertex first, on the edge entered, to second, opposite."""
    k = next(k for k in range(4) if {corners[k], corners[(k + 1) % 4]} == set(entered))
    p, q, r, s = (corners[(k + j) % 4] for j in range(4))
    return [p, first, second, s], [first, q, r, second]


def _odd_face_cost(n_corners: int) -> float:
    """What a face outside costs: none that becomes a quad, more that has more or fewer."""
    return 0.0 if n_corners == 4 else 1.0 + 0.2 * abs(n_corners - 4)


def _name_face(n_corners: int) -> str:
    names = {3: "a triangle", 4: "a quad", 5: "a pentagon", 6: "a hexagon"}
    return names.get(n_corners, f"a face of {n_corners} corners")


def _inward_normals(hole: Hole) -> NDArray[np.float64]:
    """(L, 3) unit normals of the faces beside the loop."""
    from query.holes.neighbourhood import extract_neighbourhood

    return extract_neighbourhood(hole).normals


def _angles_of(
    a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]
) -> list[float]:
    """The three angles of a triangle, in radians."""
    found: list[float] = []
    for p, q, r in ((a, b, c), (b, c, a), (c, a, b)):
        u, w = q - p, r - p
        found.append(float(np.arctan2(np.linalg.norm(np.cross(u, w)), u @ w)))
    return found


def _angle_inside(
    a: NDArray[np.float64],
    b: NDArray[np.float64],
    c: NDArray[np.float64],
    normal: NDArray[np.float64],
) -> float:
    """The angle of the hole at b, in radians from 0 to 2 pi, between its neighbours a and c."""
    u, w = c - b, a - b
    angle = float(np.arctan2(np.cross(u, w) @ normal, u @ w))
    return angle if angle >= 0 else angle + 2 * np.pi


def _skew(angles: Sequence[float]) -> float:
    """How far a triangle is from an equilateral one, in radians."""
    return float(np.abs(np.array(angles) - np.pi / 3).sum())
