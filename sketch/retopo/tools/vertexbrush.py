"""Vertex brush: placed vertices follow the hand, or are smoothed; chains follow them."""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.halfedge import Int32Array
from query.engine import PatternSource
from query.placing.shape import units
from query.placing.surface import Points
from query.polyline import arc_length
from sketch.retopo.errors import RefusedError
from sketch.retopo.filling.border import border
from sketch.retopo.filling.choosing import filled, filling_of
from sketch.retopo.filling.counting import counted
from sketch.retopo.filling.finding import patch_at
from sketch.retopo.filling.meshing import FilledNetwork, RetopoMesh, border_keys, welded
from sketch.retopo.ground import Ground
from sketch.retopo.network import Chain, Draft, Edit, Network, with_choice
from sketch.retopo.sizes import Sizes
from sketch.retopo.tools.course import crossing_notes, evened, on_ground

#: Rounds of smoothing at one call unless told otherwise.
ROUNDS = 5

#: A vertex that moves by less than this part of the ground's diagonal stays: it is at rest.
STILL = 1e-9


def brush(
    network: Network,
    ground: Ground,
    source: PatternSource,
    sizes: Sizes,
    point: ArrayLike,
    normal: ArrayLike,
    to: ArrayLike,
) -> Edit:
    """Drag the vertices of the quads within the brush's radius (``sizes.brush``) of a point.

    point, normal: (3,) on the surface, where the drag begins; to: (3,), where it ends. Vertices
    whose normals agree move by shares (1 - t)^4 (4 t + 1) of the drag, t their distance as a part
    of the radius, and are taken to the ground. What the network keeps of it: see
    :meth:`Under.edited`. Vertices on borders and on the seam of symmetry stay.

    Counts and fills that are not chosen yet, and are needed, are chosen. Raises RefusedError if
    no quads are near or a curve would have no length. Source: the program of Takayama et al. 2013.
    """
    at, up = np.asarray(point, np.float64), np.asarray(normal, np.float64)
    if (np.asarray(to, np.float64) == at).all():
        return Edit.of(network, network)
    under = Under.of(network, ground, source, sizes, at, up)
    foot = ground.nearest_facing(np.asarray(to, np.float64)[None], up[None])
    share = np.where(under.marked, 0.0, under.share)[:, None]
    points, normals = under.mesh.vertices.copy(), under.mesh.normals.copy()
    moves = share[:, 0] > 0.0
    points[moves], normals[moves] = on_ground(
        (points + share * (foot.points[0] - at))[moves],
        units(normals + share * (foot.normals[0] - up))[moves],
        ground,
        sizes,
    )
    return under.edited(network, ground, sizes, points, normals, frozenset())


def relax(
    network: Network,
    ground: Ground,
    source: PatternSource,
    sizes: Sizes,
    point: ArrayLike,
    normal: ArrayLike,
    rounds: int = ROUNDS,
) -> Edit:
    """Smooth the vertices of the quads within the brush's radius of a point.

    Each round takes every vertex, by the share of :func:`brush`, to the mean of its neighbours:
    for one on a side these are its two along the side and the inner ones of both patches, for a
    corner all around it. One on a curve that has quads on one side only goes to the middle
    between its neighbours along it, and stays on the curve; there, corners stay, and what is on
    a border or the seam of symmetry.

    Raises RefusedError if no quads are near. Source: the program of Takayama et al. 2013. Differs
    from it: there each patch weighs a corner's neighbours along its sides by half; as each such
    neighbour belongs to two patches, that is the mean of all.
    """
    at, up = np.asarray(point, np.float64), np.asarray(normal, np.float64)
    under = Under.of(network, ground, source, sizes, at, up)
    start, neighbour = _neighbours(under.mesh)
    degree = np.diff(start)[:, None]
    free = np.flatnonzero((under.share > 0.0) & ~under.rim & ~under.marked)
    slide, before, after = under.sliding()
    points, normals = under.mesh.vertices, under.mesh.normals
    for _ in range(rounds):
        mean = np.add.reduceat(points[neighbour], start[:-1], axis=0) / degree
        wanted = points + under.share[:, None] * (mean - points)
        where, there = on_ground(wanted[free], normals[free], ground, sizes)
        middle = 0.5 * (points[before] + points[after]) - points[slide]
        slid = points[slide] + under.share[slide, None] * middle
        points, normals = points.copy(), normals.copy()
        points[free], normals[free] = where, there
        for k, place in zip(slide, slid, strict=True):
            points[k], normals[k] = _on_chain(network.chains[int(under.mesh.chain[k])], place)
    return under.edited(network, ground, sizes, points, normals, under.one_sided)


@dataclass(frozen=True, slots=True, eq=False)
class Under:
    """The quads under the brush.

    network: with their counts and fills. mesh: the patches that may have vertices under it,
    welded. number: of every vertex of their fills in the mesh, by patch. at: of what is on the
    network, by its key, see :func:`border_keys`. share: (v,) by which each moves, 0 outside.
    one_sided: chains with quads on one side. rim: (v,) is it on one, or on the corner of one?
    marked: (v,) the same of chains that stay, borders and the seam.
    """

    network: Network
    mesh: RetopoMesh
    number: Mapping[int, Int32Array]
    at: Mapping[tuple[int, int], int]
    share: NDArray[np.float64]
    one_sided: frozenset[int]
    rim: NDArray[np.bool_]
    marked: NDArray[np.bool_]
    notes: tuple[str, ...]

    @classmethod
    def of(
        cls,
        network: Network,
        ground: Ground,
        source: PatternSource,
        sizes: Sizes,
        point: Points,
        normal: Points,
    ) -> Under:
        """Of those within ``sizes.brush`` of a point (3,), whose normals agree with its own."""
        network, told = counted(network, sizes.edge)
        notes = list(told)
        found = FilledNetwork(network, {})
        for patch in _near(network, ground, point, sizes.brush + sizes.edge):
            try:
                network, found.placed[patch] = filled(network, ground, source, patch)
            except RefusedError as error:
                notes.append(str(error))
        mesh = welded(replace(found, network=network))
        away = np.linalg.norm(mesh.vertices - point, axis=1) / sizes.brush
        under = (away < 1.0) & (mesh.normals @ normal > 0.0)
        if not under.any():
            raise RefusedError("no quads are under the brush; point at some, or make it larger")
        share = np.where(under, (1.0 - np.minimum(away, 1.0)) ** 4 * (4.0 * away + 1.0), 0.0)
        number: dict[int, Int32Array] = {}
        at: dict[tuple[int, int], int] = {}
        for patch, placed in found.placed.items():
            number[patch] = np.empty(len(placed.vertices), np.int32)
            number[patch][placed.quads] = mesh.quads[mesh.patch == patch]
            keys = border_keys(network, network.patches[patch])
            at.update(zip(keys, number[patch][: len(keys)].tolist(), strict=True))
        halves = [half for patch in found.placed for half in network.patches[patch].loop]
        sides = np.bincount([half >> 1 for half in halves])
        one_sided = frozenset(np.flatnonzero(sides == 1).tolist())
        marked = {chain.id for chain in network.chains.values() if chain.marked}
        return cls(
            network,
            mesh,
            number,
            at,
            share,
            one_sided,
            _on(network, mesh, one_sided),
            _on(network, mesh, marked),
            tuple(notes),
        )

    def sliding(self) -> tuple[list[int], list[int], list[int]]:
        """Vertices within chains with quads on one side, and those before and after along them."""
        found: list[tuple[int, int, int]] = []
        for (chain, k), vertex in self.at.items():
            if k < 0 or chain not in self.one_sided or self.share[vertex] == 0.0:
                continue
            line = self.network.chains[chain]
            before = self.at[(chain, k - 1) if k > 1 else (line.start, -1)]
            after = self.at[(chain, k + 1) if k + 1 < line.count else (line.end, -1)]
            found.append((vertex, before, after))
        return [a for a, _, _ in found], [b for _, b, _ in found], [c for _, _, c in found]

    def edited(
        self,
        before: Network,
        ground: Ground,
        sizes: Sizes,
        points: Points,
        normals: Points,
        still: frozenset[int],
    ) -> Edit:
        """The network with vertices of the mesh at other points (v, 3) of the ground.

        Corners and chains go where the vertices on them do; the samples between follow by what
        the two vertices next to them do, so that a chain keeps its detail. A patch of which a
        vertex moved holds its inner vertices where they are now; as it may be an imported one,
        that holds them all, it holds those on its border, too. ``still`` chains keep their course.
        """
        move = points - self.mesh.vertices
        move[np.abs(move).max(axis=1) <= STILL * ground.diagonal] = 0.0
        moved = np.any(move, axis=1)
        if not moved.any():
            return Edit.of(before, before, self.notes)
        draft = Draft(self.network)
        lines: set[int] = set()
        for vertex in np.flatnonzero(moved):
            if self.mesh.node[vertex] >= 0:
                node = int(self.mesh.node[vertex])
                draft.move_node(node, points[vertex], normals[vertex])
                lines |= {half >> 1 for half in draft.nodes[node].ends}
            elif self.mesh.chain[vertex] >= 0:
                lines.add(int(self.mesh.chain[vertex]))
        for chain in sorted(lines - still):
            self._reshape(draft, ground, sizes, chain, move)
        after = draft.finished()
        for patch, number in self.number.items():
            if moved[number].any():
                filling = filling_of(after.patches[patch])
                assert filling.choice is not None
                whole = len(filling.moved_vertices[0]) == len(number)
                which = np.arange(0 if whole else filling.choice.perimeter, len(number))
                after = with_choice(after, patch, filling.with_moved(which, points[number[which]]))
        told = crossing_notes(self.network, after, lines - still, sizes)
        return Edit.of(before, after, (*self.notes, *told))

    def _reshape(
        self, draft: Draft, ground: Ground, sizes: Sizes, chain: int, move: Points
    ) -> None:
        """Let a chain follow its vertices, which move by (v, 3)."""
        line = self.network.chains[chain]
        n = max(line.count, 1)
        keys = [(line.start, -1), *((chain, k) for k in range(1, n)), (line.end, -1)]
        moves = np.array([move[self.at[key]] if key in self.at else np.zeros(3) for key in keys])
        along = arc_length(line.points)
        of_vertex = np.linspace(0.0, along[-1], n + 1)
        by = np.stack([np.interp(along, of_vertex, moves[:, d]) for d in range(3)], axis=1)
        points, normals = line.points.copy(), line.normals.copy()
        goes = np.any(by, axis=1)
        goes[[0, -1]] = False
        points[goes], normals[goes] = on_ground((points + by)[goes], normals[goes], ground, sizes)
        for k, node in ((0, line.start), (-1, line.end)):
            points[k], normals[k] = draft.nodes[node].point, draft.nodes[node].normal
        draft.reshape_chain(chain, *evened(points, normals, ground, sizes, False))
        if not draft.chains[chain].length > 0.0:
            raise RefusedError("a curve would have no length: drag less far")


def _near(network: Network, ground: Ground, point: Points, radius: float) -> list[int]:
    """The patches that a point is in, or that have a border vertex within a radius of it."""
    found = {
        patch.id
        for patch in network.patches.values()
        if np.linalg.norm(border(network, patch)[0] - point, axis=1).min() < radius
    }
    try:
        found.add(patch_at(network, ground, point))
    except RefusedError:
        if not found:
            raise RefusedError("no quads are near; point at some") from None
    return sorted(found)


def _on(network: Network, mesh: RetopoMesh, chains: Set[int]) -> NDArray[np.bool_]:
    """(v,) is a vertex on one of some chains, or on a node where one ends?"""
    ids = np.array(sorted(chains), np.int64)
    ends = [node for k in chains for node in (network.chains[k].start, network.chains[k].end)]
    nodes = np.array(sorted({node for node in ends if node >= 0}), np.int64)
    return np.isin(mesh.chain, ids) | np.isin(mesh.node, nodes)


def _neighbours(mesh: RetopoMesh) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The vertices at the other ends of every vertex's edges: those of i are
    neighbour[start[i]:start[i + 1]]."""
    tail = mesh.quads.ravel().astype(np.int64)
    head = np.roll(mesh.quads, -1, axis=1).ravel().astype(np.int64)
    pairs = np.unique(
        np.concatenate([np.stack([tail, head], 1), np.stack([head, tail], 1)]), axis=0
    )
    start = np.concatenate([[0], np.cumsum(np.bincount(pairs[:, 0], minlength=len(mesh.vertices)))])
    return start, pairs[:, 1]


def _on_chain(line: Chain, point: Points) -> tuple[Points, Points]:
    """The point of a chain nearest to a point (3,), and the normal there."""
    one, along = line.points[:-1], np.diff(line.points, axis=0)
    size = np.maximum((along**2).sum(axis=1), np.finfo(np.float64).tiny)
    share = np.clip(((point - one) * along).sum(axis=1) / size, 0.0, 1.0)
    at = one + share[:, None] * along
    k = int(np.linalg.norm(at - point, axis=1).argmin())
    up = (1.0 - share[k]) * line.normals[k] + share[k] * line.normals[k + 1]
    return at[k], units(up[None])[0]
