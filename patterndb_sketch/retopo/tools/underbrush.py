"""Under the brush: the vertices of quads near a point, and the network after they moved."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Set
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling.border import border
from patterndb_sketch.retopo.filling.choosing import filled, filling_of
from patterndb_sketch.retopo.filling.counting import counted
from patterndb_sketch.retopo.filling.finding import patch_at
from patterndb_sketch.retopo.filling.meshing import FilledNetwork, RetopoMesh, border_keys, welded
from patterndb_sketch.retopo.ground import Ground
from patterndb_sketch.retopo.network import Chain, Draft, Edit, Network, with_choice
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tools.course import crossing_notes, evened, on_ground
from query.engine import PatternSource

#: A vertex that moves by less than this part of the ground's diagonal stays: it is at rest.
STILL = 1e-9

#: Where a chain's samples go, (n, 3), before they are taken to the ground; its ends are nodes'.
Course = Callable[[Chain], Points]


def falloff(points: Points, at: Points, radius: float) -> NDArray[np.float64]:
    """(n,) shares (1 - t)^4 (4 t + 1) of points (n, 3), t their distance as a part of a radius."""
    t = np.minimum(np.linalg.norm(points - at, axis=1) / radius, 1.0)
    return (1.0 - t) ** 4 * (4.0 * t + 1.0)


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
        share = falloff(mesh.vertices, point, sizes.brush) * (mesh.normals @ normal > 0.0)
        if not share.any():
            raise RefusedError("no quads are under the brush; point at some, or make it larger")
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
        course: Course,
        still: frozenset[int] = frozenset(),
    ) -> Edit:
        """The network with vertices of the mesh at other points (v, 3) of the ground.

        Corners go where the vertices on them do. Chains on which a vertex or an end moved get the
        samples that ``course`` gives them, taken to the ground; ``still`` ones keep theirs. A
        patch of which a vertex moved holds its inner vertices where they are now, and one that
        holds all, as imported ones do, those on its border, too.
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
            self._reshape(draft, ground, sizes, chain, course)
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

    def vertices_on(self, line: Chain, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """(count + 1, ...) values of a chain's vertices, given those of the mesh's; 0 for those
        that are not in it."""
        inner = [(line.id, k) for k in range(1, max(line.count, 1))]
        keys = [(line.start, -1), *inner, (line.end, -1)]
        none = np.zeros(values.shape[1:])
        return np.array([values[self.at[key]] if key in self.at else none for key in keys])

    def _reshape(
        self, draft: Draft, ground: Ground, sizes: Sizes, chain: int, course: Course
    ) -> None:
        line = self.network.chains[chain]
        wanted = course(line)
        points, normals = line.points.copy(), line.normals.copy()
        goes = np.any(wanted != points, axis=1)
        goes[[0, -1]] = False
        points[goes], normals[goes] = on_ground(wanted[goes], normals[goes], ground, sizes)
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
