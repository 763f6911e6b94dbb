"""Make the image of a half: of its network, where symmetry ends, of its mesh, and of density."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import count

import numpy as np
from scipy.spatial import KDTree

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling.choice import Choice, Filling, Flow
from patterndb_sketch.retopo.filling.mesh import RetopoMesh, find_open_edges
from patterndb_sketch.retopo.network import (
    NONE,
    SYMMETRY,
    Chain,
    Density,
    Edit,
    HalfChain,
    Network,
    NetworkBuilder,
    Node,
    Paint,
    Patch,
    walk_face,
)
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.symmetry.half import Plane
from patterndb_sketch.retopo.tracing.curves import project_near
from patterndb_sketch.retopo.wording import format_place

#: An image that is this near to a line of the brush, in its radii, is that line.
SAME = 1e-9


def end_symmetry(network: Network, surface: Surface, sizes: Sizes, plane: Plane) -> Edit:
    """The network with its image beside it, on the whole surface: both halves are curves to draw
    on.

    The curves of the half keep their ids, counts and patches, the seam too, without its marks.
    Images have the same counts, and the images of fills. They are projected on the surface,
    which need not be symmetric; those that are off it by more than the snap radius somewhere are
    left out, and told.
    Raises RefusedError if there is no symmetry to switch off.
    """
    if not any(SYMMETRY in chain.marks for chain in network.chains.values()):
        raise RefusedError("symmetry is off already")
    return _Images(network, surface, sizes, plane).done()


@dataclass(frozen=True, slots=True)
class _Names:
    """Ids of the images, by the ids of what they are images of; on the seam they are the same."""

    nodes: dict[int, int]
    chains: dict[int, int]

    def half(self, half: HalfChain) -> HalfChain:
        """The image of a half-chain, in the same sense along it."""
        return 2 * self.chains[half >> 1] + (half & 1)


class _Images:
    """The steps of :func:`end_symmetry`, which need the same things."""

    def __init__(self, network: Network, surface: Surface, sizes: Sizes, plane: Plane) -> None:
        # A draft of the half has made that the network's surface.
        self.network = network if network.surface is None else replace(network, surface=surface)
        self.surface = surface
        self.sizes = sizes
        self.plane = plane
        self.ids = count(network.next_id)
        self.off: dict[int, float] = {}  # images of chains that the surface has no place for
        self.seam = {c.id for c in network.chains.values() if SYMMETRY in c.marks}
        on_seam = {n for c in self.seam for n in _ends(network.chains[c])}
        self.names = _Names(
            {n: n if n in on_seam else next(self.ids) for n in sorted(network.nodes)},
            {c: c if c in self.seam else next(self.ids) for c in sorted(network.chains)},
        )
        self.on_seam = on_seam

    def done(self) -> Edit:
        nodes = self._nodes()
        chains = self._chains(nodes)
        both = replace(self.network, nodes=nodes, chains=chains)
        patches = dict(self.network.patches)
        for patch in self.network.patches.values():
            new = self._patch(both, patch)
            patches[new.id] = new
        both = replace(both, patches=patches, next_id=next(self.ids))
        notes: list[str] = []
        if self.off:
            builder = NetworkBuilder(both)
            for chain in sorted(self.off):
                builder.remove_chain(chain)
            both = builder.finish()
            notes.append(
                f"the surface is not symmetric: the images of {len(self.off)} curves, up to "
                f"{max(self.off.values()):.4g} off it, are left out"
            )
        return Edit.of(self.network, both, notes)

    def _projected(self, points: Points, normals: Points) -> tuple[Points, Points, float]:
        """Images (n, 3) of points with normals, on the surface, and how far they were off it."""
        images = self.plane.mirror(points)
        up = self.plane.mirror_directions(normals)
        found = project_near(self.surface, images, up, self.sizes)
        off = np.linalg.norm(found.points - images, axis=1)
        # Next to the plane the surface may lead across it; there the image itself is better.
        there = (off <= self.sizes.snap) & (self.plane.heights(found.points) < 0.0)
        images[there], up[there] = found.points[there], found.normals[there]
        return images, up, float(off.max())

    def _nodes(self) -> dict[int, Node]:
        found = dict(self.network.nodes)
        for node in self.network.nodes.values():
            if node.id in self.on_seam:
                ends, flags = self._both_sides(node)
                found[node.id] = replace(node, ends=ends, corner_flags=flags)
                continue
            points, normals, _ = self._projected(node.point[None], node.normal[None])
            name, n = self.names.nodes[node.id], node.valence
            ends = tuple(self.names.half(end) for end in reversed(node.ends))
            flags = tuple(node.corner_flags[(n - 2 - j) % n] for j in range(n))
            found[name] = Node(name, points[0], normals[0], ends, flags, node.cut)
        return found

    def _both_sides(self, node: Node) -> tuple[tuple[HalfChain, ...], tuple[bool, ...]]:
        """The ends of a node on the seam with their images, and its flags."""
        n = node.valence
        if n == 1:
            return node.ends, node.corner_flags
        seam = SYMMETRY
        mark = self.network.mark
        outer = next(
            j
            for j in range(n)
            if mark(node.ends[j]) == seam or mark(node.ends[(j + 1) % n] ^ 1) == seam
        )
        ends = node.ends[outer + 1 :] + node.ends[: outer + 1]
        flags = node.corner_flags[outer + 1 :] + node.corner_flags[: outer + 1]
        inside, outside = flags[:-1], flags[-1:]
        images = tuple(self.names.half(end) for end in reversed(ends) if end >> 1 not in self.seam)
        leaves, arrives = ends[0] >> 1 in self.seam, ends[-1] >> 1 in self.seam
        if leaves and arrives:
            result = inside + inside[::-1]
        elif arrives:
            result = inside + inside[::-1] + outside
        else:
            result = inside + outside + inside[::-1]
        both = ends + images
        return both, result if any(result) else (True,) * len(both)

    def _chains(self, nodes: dict[int, Node]) -> dict[int, Chain]:
        found = dict(self.network.chains)
        for chain in self.network.chains.values():
            if chain.id in self.seam:
                left, right = (mark if mark != SYMMETRY else "" for mark in chain.marks)
                found[chain.id] = replace(chain, marks=(left, right))
                continue
            points, normals, off = self._projected(chain.points, chain.normals)
            name, ends = self.names.chains[chain.id], (NONE, NONE)
            if not chain.is_closed_loop:
                ends = self.names.nodes[chain.start], self.names.nodes[chain.end]
                for k, node in ((0, nodes[ends[0]]), (-1, nodes[ends[1]])):
                    points[k], normals[k] = node.point, node.normal
            if off > self.sizes.snap or not (points != points[0]).any():
                self.off[name] = off
            left, right = chain.marks
            marks = (right, left)
            kept = chain.count, chain.pinned, marks, chain.auto
            found[name] = Chain(name, *ends, points, normals, *kept)
        return found

    def _patch(self, both: Network, patch: Patch) -> Patch:
        """The image of a patch, whose fill is turned over with it."""
        loop, corners = walk_face(both.nodes, both.chains, self.names.half(patch.loop[0]) ^ 1)
        images = [self.names.half(half) ^ 1 for half in patch.loop]
        if set(loop) != set(images):
            # A session of an older version may have a curve that went on behind the seam.
            at = self.network.chains[patch.loop[0] >> 1].points.mean(axis=0)
            raise RefusedError(
                f"the image of the patch at {format_place(at)} would not close as it does; erase a "
                "curve of it that ends on the plane, or delete the patch"
            )
        choice = patch.choice
        if isinstance(choice, Filling):
            # Of the patch's half-chains, that whose image the image's loop begins with.
            last = images.index(loop[0])
            counts = [both.chains[half >> 1].count for half in patch.loop]
            choice = mirror_filling(choice, patch, last, counts, self.plane)
        return Patch(next(self.ids), loop, corners, choice)


def mirror_filling(
    filling: Filling, patch: Patch, last: int, counts: list[int], plane: Plane
) -> Filling:
    """The image of a patch's fill.

    last: the place in the patch's loop whose half-chain, turned round, begins the image's loop.
    counts: edges of the half-chains of the patch's loop.
    """
    flows = tuple(Flow.of(plane.mirror(flow.points)) for flow in filling.flows)
    choice = filling.choice
    if choice is None:
        return Filling(None, flows)
    if sum(counts) != choice.perimeter:
        # Of counts before: another fill takes its place anyway.
        return Filling(None, flows)
    perimeter, n = choice.perimeter, len(choice.lengths)
    first = sum(counts[: last + 1])
    number = np.arange(choice.n_vertices, dtype=np.int32)
    number[:perimeter] = (first - np.arange(perimeter)) % perimeter
    quads = number[choice.faces[:, ::-1]]
    # The side that half-chain ``last`` is on is side 0 of the image, the one before side 1.
    side = sum(corner <= last for corner in patch.corners) - 1
    rotation = choice.rotation
    if n:
        rotation = (rotation - side if choice.mirrored else rotation + side) % n
    image = Choice(
        lengths=tuple(choice.lengths[(side - i) % n] for i in range(n)),
        quads=np.ascontiguousarray(quads, "<i4").tobytes(),
        n_vertices=choice.n_vertices,
        code=choice.code,
        widths=choice.widths,
        rotation=rotation,
        mirrored=not choice.mirrored,
        origin=choice.origin,
        n_irregular=choice.n_irregular,
        by=choice.by,
    )
    which, at = filling.moved_vertices
    result = Filling(image, flows)
    return result.with_moved(number[which], plane.mirror(at)) if len(which) else result


def _ends(chain: Chain) -> set[int]:
    return {chain.start, chain.end} - {NONE}


@dataclass(frozen=True, slots=True, eq=False)
class MirroredMesh:
    """A mesh of quads that is its own image.

    mesh:     of both halves: the quads of the half first, then their images. A vertex or quad
              of the image has the node, chain and patch of what it is the image of.
    image:    (v,) int32, the vertex that is a vertex's image; on the seam it is itself.
    pinched:  (e, 2) int32, edges beside the seam whose two ends are on it: they and their images
              are one edge, of four quads. More edges along the curves there mend it.
    """

    mesh: RetopoMesh
    image: Int32Array
    pinched: Int32Array


def mirror_mesh(half: RetopoMesh, network: Network, plane: Plane) -> MirroredMesh:
    """The mesh of a half and its image, welded where the network has a seam, never by distance.

    half: of ``network``, as welded. Vertices on the seam are moved exactly onto the plane, from
    where rounding has left them; all others and their images are mirror images by arithmetic,
    and exactly so for the planes x, y or z = 0. Quads of the image are turned over.

    Differs from the program of Takayama et al. 2013, which welds what is near to the plane: a
    vertex that only comes near stays its own.
    """
    seam = find_seam_vertices(half, network)
    n, extra = len(half.vertices), int((~seam).sum())
    image = np.empty(n + extra, np.int32)
    image[:n][seam] = np.flatnonzero(seam)
    image[:n][~seam] = np.arange(n, n + extra)
    image[n:] = np.flatnonzero(~seam)
    points, normals = half.vertices.copy(), half.normals.copy()
    points[seam] = plane.flatten(points[seam])
    normals[seam] = plane.flatten_normals(normals[seam])
    both = RetopoMesh(
        np.concatenate([points, plane.mirror(points[~seam])]),
        np.concatenate([normals, plane.mirror_directions(normals[~seam])]),
        np.concatenate([half.quads, image[half.quads[:, ::-1]]]).astype(np.int32),
        np.concatenate([half.patch, half.patch]),
        np.concatenate([half.node, half.node[~seam]]),
        np.concatenate([half.chain, half.chain[~seam]]),
    )
    return MirroredMesh(both, image, _find_pinched(half, seam))


def find_seam_vertices(half: RetopoMesh, network: Network) -> np.ndarray:
    """(v,) bool: is a vertex of the half on a chain that is marked as the seam, or at its end?"""
    chains = [chain for chain in network.chains.values() if SYMMETRY in chain.marks]
    nodes = {node for chain in chains for node in (chain.start, chain.end)} - {NONE}
    return np.isin(half.chain, [chain.id for chain in chains]) | np.isin(half.node, sorted(nodes))


def _find_pinched(half: RetopoMesh, seam: np.ndarray) -> Int32Array:
    """(e, 2) inner edges of the half with both ends on the seam."""
    tail, head = half.quads.ravel(), np.roll(half.quads, -1, axis=1).ravel()
    both = seam[tail] & seam[head]
    edges = np.unique(np.sort(np.stack([tail[both], head[both]], axis=1), axis=1), axis=0)
    rim = {(min(a, b), max(a, b)) for a, b in find_open_edges(half).tolist()}
    inner = [edge for edge in edges.tolist() if tuple(edge) not in rim]
    return np.array(inner, np.int32).reshape(-1, 2)


def mirror_paint(stroke: Paint, plane: Plane) -> Paint:
    """A brush stroke along its lines and their images, each once.

    One stroke, not two: where both sides of it overlap, at the plane, it has its effect once.
    """
    image = replace(
        stroke,
        starts=plane.mirror(stroke.starts),
        ends=plane.mirror(stroke.ends),
        normals=plane.mirror_directions(stroke.normals),
    )
    there = np.concatenate([stroke.starts, stroke.ends], axis=1)
    back = np.concatenate([stroke.ends, stroke.starts], axis=1)
    made = np.concatenate([image.starts, image.ends], axis=1)
    away, _ = KDTree(np.concatenate([there, back])).query(made)
    new = away > SAME * stroke.radius
    if not new.any():
        return stroke
    return stroke.joined(
        replace(image, starts=image.starts[new], ends=image.ends[new], normals=image.normals[new])
    )


def mirror_density(density: Density, plane: Plane) -> Density:
    """The density with all its strokes on both sides."""
    if not density.strokes:
        return density
    return Density(tuple(mirror_paint(one, plane) for one in density.strokes))
