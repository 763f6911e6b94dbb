"""Fit the quads of a draft to the surface: what lies furthest from them draws them there.

A fill is laid within curves that the field's lines gave, whose ends and corners know nothing of
the surface's tips: ears, horns and fingers between two lines are cut off, and quads are flipped
where lines run close together. Here all vertices of what was laid move at once, curves' too, in
rounds: each towards the mean of its neighbours, along the surface, but for those from which the
surface is far. These go where its far points draw them, the more the further they are, so that the
greatest distance falls and not the mean. No quad flips that was sound, and those that are flipped
are untangled first. In the end curves run through their vertices again, and fills hold their inner
ones.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.sparse import coo_array, csr_array

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.neighbours import Neighbours
from patterndb.geometry.points import Floats, Points, units
from patterndb.geometry.polyline import interpolate
from patterndb.geometry.quadshape import flipped, scaled_jacobian
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.draft.fixedcurves import find_fixed_curves
from patterndb_sketch.retopo.filling import FilledNetwork, place_fill, weld_patches
from patterndb_sketch.retopo.filling.fills import filling_of
from patterndb_sketch.retopo.filling.mesh import RetopoMesh
from patterndb_sketch.retopo.filling.placing import name_border_vertices
from patterndb_sketch.retopo.filling.report import cut_quads
from patterndb_sketch.retopo.network import Chain, Node, set_choice
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.symmetry import Half
from patterndb_sketch.retopo.tracing.curves import project_near
from query.placing.laplace import HeldQuads
from query.placing.untangle import UNMOVED, Mended, MendOptions, mend

#: Rounds, and after how many the surface's far points are looked for anew.
ROUNDS, LOOKED_FOR = 20, 5

#: Points of the surface are this part of a target edge apart, and a triangle is divided into so
#: many parts a side at most.
SPACING, MOST_PARTS = 1.0 / 3.0, 30

#: Distances are weighed against this part of the diagonal: what is drawn beyond it is pulled with
#: all force. Three quarters of what a draft is allowed to be off.
WITHIN = 0.015

#: Points nearer to the quads than this part of that draw nothing.
NEAR = 0.25

#: Parts of their way that vertices go in a round: to the mean of neighbours, along a curve to the
#: middle between these, and to where they are drawn; and no further than this part of an edge.
SMOOTHED, DRAWN, FURTHEST = 0.8, 0.7, 0.5

#: Times that vertices of quads that would flip go half as far, and times that they stay, from the
#: second on with their neighbours.
HALVINGS, HOLDS = 3, 5

#: No vertex goes further, in target edges, where quads are untangled.
LONGEST_LEAP = 1.0

#: Times that all is done, until no quad is flipped or no fewer are than the time before: some
#: tangles open once the others have.
FITTINGS = 3

#: Times that flipped quads are untangled and projected.
UNTANGLINGS = 4

#: Of more quads only vertices so many edges around flipped ones are moved: in a network of 6,000
#: quads all took ten seconds, four times.
MOST_AT_ONCE, AROUND = 2000, 8

#: Rounds for shape alone.
SHAPING = 50

#: Shapes and types of no far points.
NOTHING = (((3,), float), ((3,), np.int32), ((3,), float), ((3,), float), ((), float))

#: The size of a quad's square is this share its own, and else the mean of all.
OWN_SIZE = 0.3

#: Quads with a scaled Jacobian below POOR weigh more, up to MOST times.
POOR, MOST = 0.6, 12.0


def fit_quads(
    found: FilledNetwork,
    surface: Surface,
    samples: Points,
    sizes: Sizes,
    laid: Collection[int],
    kept: Collection[int],
) -> FilledNetwork:
    """The filled network with its quads fitted to the surface.

    samples: (n, 3) points that they are to come near to, see :func:`sample_surface`. laid: the
    chains that may move, with the nodes that no other chain ends at. kept: patches whose vertices
    stay where they were placed.
    """
    fit = _Fit(found, surface, samples, sizes, frozenset(laid), frozenset(kept))
    if not fit.free.any() and found.placed.keys() <= fit.kept:
        return found
    before = len(fit.mesh.quads)
    for _ in range(FITTINGS):
        fit.shape()
        fit.open_tangles()
        fit.run()
        fit.open_tangles()
        left = fit.count_flipped()
        if not left or left >= before:
            break
        before = left
    return fit.finish()


def count_flipped(found: FilledNetwork) -> int:
    """How many quads of a filled network are flipped."""
    return sum(len(one.flipped) for one in found.placed.values())


@dataclass(frozen=True, slots=True, eq=False)
class _FarPoints:
    """Points (n, 3) of the surface, on the quads' triangles with corners (n, 3) the weights (n, 3)
    of what is nearest; away: (n, 3) from there to the points, size: how far."""

    points: Points
    corners: Int32Array
    weights: Floats
    away: Points
    size: Floats


class _Fit:
    """The steps of :func:`fit_quads`, which share the mesh.

    at, normals: (v, 3) where its vertices are now. free: (v,) which may move.
    """

    def __init__(
        self,
        found: FilledNetwork,
        surface: Surface,
        samples: Points,
        sizes: Sizes,
        laid: frozenset[int],
        kept: frozenset[int],
    ) -> None:
        self.found = found
        self.surface = surface
        self.sizes = sizes
        self.laid = laid
        self.kept = kept
        self.mesh = weld_patches(found)
        self.at, self.normals = self.mesh.vertices.copy(), self.mesh.normals.copy()
        self.number = number_vertices(found, self.mesh)
        self.on_network = self._name_vertices()
        self.free = self._find_free()
        self.curves = find_fixed_curves(found.network, laid, kept, self._list_along)
        self.on_curve = np.zeros(len(self.free), np.bool_)
        for curve in self.curves:
            self.free[curve.vertices[curve.sliding]] = True
            self.on_curve[curve.vertices] = True
        self.beside = _link_neighbours(self.mesh)
        self.degree = np.maximum(np.diff(self.beside.indptr), 1)[:, None]
        self.within = WITHIN * surface.diagonal
        tail, head = self.mesh.list_sides()
        self.wanted = float(np.linalg.norm(self.at[tail] - self.at[head], axis=1).mean())
        self.samples = samples

    def _name_vertices(self) -> dict[tuple[int, int], int]:
        """The vertex that every place on the network is; see :func:`name_border_vertices`."""
        at: dict[tuple[int, int], int] = {}
        for patch, number in self.number.items():
            keys = name_border_vertices(self.found.network, self.found.network.patches[patch])
            at.update(zip(keys, number[: len(keys)].tolist(), strict=True))
        return at

    def _find_free(self) -> NDArray[np.bool_]:
        """(v,) what is on chains that were laid, on nodes of nothing else, and within patches that
        are not kept."""
        network, mesh = self.found.network, self.mesh
        still = {
            node
            for chain in network.chains.values()
            if chain.id not in self.laid and not chain.is_closed_loop
            for node in (chain.start, chain.end)
        }
        free = np.where(
            mesh.node >= 0,
            ~np.isin(mesh.node, sorted(still)),
            (mesh.chain < 0) | np.isin(mesh.chain, sorted(self.laid)),
        )
        free[np.concatenate([np.array(face, np.int64) for face in (*mesh.kept, ())])] = False
        for patch in self.kept & self.number.keys():
            free[self.number[patch][self.found.placed[patch].perimeter :]] = False
        return free

    def _list_along(self, chain: Chain) -> list[int]:
        """The vertices along a chain; none where no patch beside it has quads."""
        keys = [(chain.start, -1), *((chain.id, k) for k in range(1, chain.count))]
        keys.append((chain.end, -1))
        return [self.on_network[k] for k in keys] if all(k in self.on_network for k in keys) else []

    def count_flipped(self) -> int:
        return int(flipped(self.mesh.quads, self.at, self.normals).sum())

    def open_tangles(self) -> None:
        """Untangle flipped quads within the surface, as far as that can be."""
        all_quads = self.mesh.quads
        wrong = flipped(all_quads, self.at, self.normals)
        fewest = int(wrong.sum())
        if not fewest:
            return
        free, chosen = self.free & ~self.on_curve, np.ones(len(all_quads), np.bool_)
        if len(all_quads) > MOST_AT_ONCE:
            free = free & self._find_around(all_quads[wrong])
            chosen = free[all_quads].any(axis=1)
        used = np.unique(all_quads[chosen])
        order = used[np.argsort(free[used], kind="stable")]
        name = np.empty(len(self.at), np.int32)
        name[order] = np.arange(len(order), dtype=np.int32)
        quads = np.ascontiguousarray(name[all_quads[chosen]])
        fixed = int((~free[used]).sum())
        # What is held is no boundary, so that the neighbours are those of quads alone.
        net = HeldQuads(quads, fixed, Neighbours.of(quads, len(order), 0))
        options = MendOptions(UNTANGLINGS, UNMOVED * self.surface.diagonal)

        def reproject(before: Points, moved: Points, up: Points) -> tuple[Points, Points]:
            there = self.surface.nearest_facing(moved[fixed:], up[fixed:])
            came, turned = there.points.copy(), there.normals.copy()
            # What leaps lands on the other side of thin plates.
            leaps = np.linalg.norm(came - before[fixed:], axis=1) > LONGEST_LEAP * self.sizes.edge
            leaps |= np.einsum("vc,vc->v", turned, up[fixed:]) < 0.0
            came[leaps], turned[leaps] = before[fixed:][leaps], up[fixed:][leaps]
            return np.concatenate([moved[:fixed], came]), np.concatenate([up[:fixed], turned])

        start = Mended(self.at[order], self.normals[order], fewest)
        mended = mend(net, start, reproject, options)
        if mended is not start:
            self.at, self.normals = self.at.copy(), self.normals.copy()
            self.at[order], self.normals[order] = mended.vertices, mended.normals

    def _find_around(self, quads: Int32Array) -> NDArray[np.bool_]:
        """(v,) which vertices are no more than some edges off some quads."""
        near = np.zeros(len(self.at), np.bool_)
        near[quads] = True
        for _ in range(AROUND):
            near |= (self.beside @ near.astype(np.float64)) > 0.0
        return near

    def shape(self) -> None:
        """Move the vertices for shape alone, which takes little time, and opens most tangles."""
        near = _FarPoints(*(np.empty((0, *n), t) for n, t in NOTHING))
        for _ in range(SHAPING):
            self._step(near)

    def run(self) -> None:
        """Move the vertices, round by round."""
        active = self.samples
        for done in range(ROUNDS):
            if done % LOOKED_FOR == 0:
                active = self.samples
            far = self._measure(active)
            active = far.points
            self._step(far)

    def _measure(self, points: Points) -> _FarPoints:
        """Of points (n, 3) of the surface those that are not near to the quads."""
        cover = Surface.from_arrays(self.at, cut_quads(self.at, self.mesh.quads))
        feet = cover.nearest(points)
        corners = cover.triangles[feet.triangles]
        away = points - feet.points
        size = np.linalg.norm(away, axis=1)
        far = size > NEAR * self.within
        return _FarPoints(points[far], corners[far], feet.weights[far], away[far], size[far])

    def _step(self, far: _FarPoints) -> None:
        """One round."""
        n, edge = len(self.at), self.sizes.edge
        drawn, weight, force = np.zeros((n, 3)), np.zeros(n), np.zeros(n)
        # The cube counts the furthest for nearly all: one tip is a few points of many.
        by = (far.size / self.within) ** 3
        for e in range(3):
            corner, share = far.corners[:, e], far.weights[:, e]
            np.add.at(drawn, corner, (share * by)[:, None] * far.away)
            np.add.at(weight, corner, share * share * by)
            np.maximum.at(force, corner, share * far.size / self.within)
        drawn /= np.maximum(weight, 1e-12)[:, None]
        length = np.linalg.norm(drawn, axis=1, keepdims=True)
        drawn *= np.minimum(1.0, FURTHEST * edge / np.maximum(length, 1e-300))
        share = np.clip(1.5 * force - 0.3, 0.0, 1.0)[:, None]
        up = self.normals + (self.beside @ self.normals) / self.degree
        up = units(0.5 * up + 2.0 * mean_normals(self.at, self.mesh.quads))
        smooth = match_squares(self.at, self.mesh.quads, self.wanted) - self.at
        smooth -= (smooth * up).sum(axis=1, keepdims=True) * up
        move = (1.0 - share) * SMOOTHED * smooth + share * DRAWN * drawn
        moved, turned = self.at.copy(), self.normals.copy()
        loose = self.free & ~self.on_curve
        moved[loose] += move[loose]
        there = self.surface.nearest_facing(moved[loose], up[loose])
        moved[loose], turned[loose] = there.points, there.normals
        wanted = [curve.propose(move) for curve in self.curves]
        for curve, along in zip(self.curves, wanted, strict=True):
            points, normals = curve.locate(along)
            sliding = curve.sliding
            chosen = curve.vertices[sliding]
            moved[chosen], turned[chosen] = points[sliding], normals[sliding]
        self._hold(moved, turned)
        for curve, along in zip(self.curves, wanted, strict=True):
            curve.settle(along, self.at)

    def _hold(self, moved: Points, turned: Points) -> None:
        """Go there, but for vertices of quads that would flip: they go less far, or stay."""
        quads = self.mesh.quads
        wrong = flipped(quads, self.at, self.normals)
        for times in range(HALVINGS + HOLDS):
            worse = flipped(quads, moved, turned) & ~wrong
            if not worse.any():
                self.at, self.normals = moved, turned
                return
            held = np.zeros(len(moved), np.bool_)
            held[quads[worse]] = True
            if times >= HALVINGS:
                if times > HALVINGS:
                    held |= (self.beside @ held.astype(np.float64)) > 0.0
                moved[held], turned[held] = self.at[held], self.normals[held]
                continue
            held &= self.free & ~self.on_curve
            half = 0.5 * (moved[held] + self.at[held])
            there = self.surface.nearest_facing(half, turned[held])
            moved[held], turned[held] = there.points, there.normals

    def finish(self) -> FilledNetwork:
        """The network with its curves through the vertices, and all of these held by patches that
        are not kept."""
        network = self.found.network
        nodes = dict(network.nodes)
        for vertex in np.flatnonzero(self.free & (self.mesh.node >= 0)).tolist():
            number = int(self.mesh.node[vertex])
            point, normal = self.at[vertex].copy(), self.normals[vertex].copy()
            nodes[number] = replace(nodes[number], point=point, normal=normal)
        chains = dict(network.chains)
        for curve in self.curves:
            # A curve of one piece is as it was: vertices slide on it, and its ends stay.
            for half, low, high in curve.pieces if len(curve.pieces) > 1 else ():
                points, normals = curve.piece(low, high)
                if half & 1:
                    points, normals = points[::-1].copy(), normals[::-1].copy()
                old = chains[half >> 1]
                for k, end in ((0, old.start), (-1, old.end)):
                    points[k], normals[k] = nodes[end].point, nodes[end].normal
                chains[half >> 1] = replace(old, points=points, normals=normals)
        for number in sorted(self.laid):
            along = self._list_along(chains[number])
            if along:
                ends = nodes[chains[number].start], nodes[chains[number].end]
                chains[number] = self._lay_through(chains[number], along, ends)
        network = replace(network, nodes=nodes, chains=chains)
        moved: list[int] = []
        for patch, number in self.number.items():
            filling = filling_of(network.patches[patch])
            assert filling.choice is not None
            # A single quad between corners, of which no vertex is free, is held, too: placed again
            # by itself it may be refused.
            inner = number[filling.choice.perimeter :]
            held_here = patch not in self.kept and self.free[inner].all()
            if not (held_here or self.free[number].any()):
                continue
            if held_here:
                held = filling.with_moved(np.arange(len(number)), self.at[number])
                network = set_choice(network, patch, held)
            moved.append(patch)
        placed = dict(self.found.placed)
        for patch in moved:
            placed[patch] = place_fill(network, self.surface, network.patches[patch])
        return replace(self.found, network=network, placed=placed)

    def _lay_through(self, chain: Chain, along: list[int], ends: tuple[Node, Node]) -> Chain:
        """A chain along a smooth curve through its vertices, on the surface, from node to node."""
        corners, up = self.at[along], self.normals[along]
        length = float(np.linalg.norm(np.diff(corners, axis=0), axis=1).sum())
        parts = max(2, int(np.ceil(length / (self.sizes.sampling * chain.count)))) * chain.count
        place = np.linspace(0.0, chain.count, parts + 1)
        points = np.asarray(CubicSpline(np.arange(len(along)), corners, bc_type="natural")(place))
        normals = units(interpolate(up, np.arange(len(along), dtype=np.float64), place))
        there = project_near(self.surface, points, normals, self.sizes)
        points, normals = there.points.copy(), there.normals.copy()
        for k, node in zip((0, -1), ends, strict=True):
            points[k], normals[k] = node.point, node.normal
        return replace(chain, points=points, normals=normals)


def number_vertices(found: FilledNetwork, mesh: RetopoMesh) -> dict[int, Int32Array]:
    """Of every patch with quads the mesh's vertices that those of its fill are."""
    number: dict[int, Int32Array] = {}
    for patch, placed in found.placed.items():
        number[patch] = np.empty(len(placed.vertices), np.int32)
        number[patch][placed.quads] = mesh.quads[mesh.patch == patch]
    return number


def _link_neighbours(mesh: RetopoMesh) -> csr_array:
    """(v, v) 1 for every edge."""
    tail, head = mesh.list_sides()
    pairs = np.unique(np.stack([np.r_[tail, head], np.r_[head, tail]]), axis=1)
    n = len(mesh.vertices)
    return coo_array((np.ones(pairs.shape[1]), tuple(pairs)), (n, n)).tocsr()


def sample_surface(surface: Surface, spacing: float) -> Points:
    """(n, 3) points all over a surface, about so far apart, its vertices among them."""
    corners = surface.vertices[surface.triangles]
    longest = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).max(axis=1)
    parts = np.clip(np.ceil(longest / spacing), 1, MOST_PARTS).astype(np.int64)
    found = [surface.vertices[np.unique(surface.triangles)]]
    for n in np.unique(parts[parts > 1]).tolist():
        weights = np.array(list(_list_weights(n)))
        inner = np.einsum("ke,tec->tkc", weights, corners[parts == n])
        found.append(inner.reshape(-1, 3))
    return np.concatenate(found)


def sample_both_sides(surface: Surface, half: Half | None, edge: float) -> Points:
    """(n, 3) points of the surface that quads are fitted to; of a half, with the images of those
    beyond the plane: no surface is symmetric to the last hair."""
    if half is None:
        return sample_surface(surface, SPACING * edge)
    points = sample_surface(half.whole, SPACING * edge)
    beyond = half.plane.heights(points) < 0.0
    return np.concatenate([points[~beyond], half.plane.mirror(points[beyond])])


def _list_weights(n: int) -> Iterable[tuple[float, float, float]]:
    """Weights of the points that divide a triangle's sides into n parts, without its corners."""
    for i in range(n):
        for j in range(n - i + 1):
            if max(i, j, n - i - j) < n:
                yield i / n, j / n, (n - i - j) / n


def match_squares(at: Points, quads: Int32Array, edge: float) -> Points:
    """Return (v, 3) where vertices are to go: the weighted mean of the corners of their squares.

    at: (v, 3) where they are; those of no quad stay. quads: (q, 4). edge: the mean edge length.
    """
    corner = at[quads]
    middle = corner.mean(axis=1)
    # Half diagonals; the square's are turned into each other by a right angle.
    one, two = 0.5 * (corner[:, 0] - corner[:, 2]), 0.5 * (corner[:, 1] - corner[:, 3])
    normal = units(np.cross(one, two))
    one = 0.5 * (one + np.cross(two, normal))
    own = np.linalg.norm(one, axis=1, keepdims=True)
    wanted = OWN_SIZE * own + (1.0 - OWN_SIZE) * edge / np.sqrt(2.0)
    one = one * (wanted / np.maximum(own, 1e-300))
    two = np.cross(normal, one)
    poor = np.clip((POOR - scaled_jacobian(quads, at)) / POOR, 0.0, 1.0)
    weight = 1.0 + (MOST - 1.0) * poor
    drawn = np.stack([middle + one, middle + two, middle - one, middle - two], axis=1)
    total = _sum_at(quads, weight[:, None, None] * drawn, len(at))
    count = np.bincount(quads.ravel(), np.repeat(weight, 4), len(at))[:, None]
    return np.where(count > 0.0, total / np.maximum(count, 1e-300), at)


def mean_normals(at: Points, quads: Int32Array) -> Points:
    """Return (v, 3) unit normals of the quads around each vertex.

    Projection by them brings back what had landed on the other side of a thin plate, where the
    surface's own normal would keep it.
    """
    corner = at[quads]
    across = np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
    return units(_sum_at(quads, np.repeat(across[:, None], 4, axis=1), len(at)))


def _sum_at(quads: Int32Array, values: Floats, n: int) -> Floats:
    """Return (n, 3) sums of values (q, 4, 3) over the vertices of quads."""
    flat = values.reshape(-1, 3)
    total = np.stack([np.bincount(quads.ravel(), flat[:, c], n) for c in range(3)], axis=1)
    return total.astype(np.float64, copy=False)
