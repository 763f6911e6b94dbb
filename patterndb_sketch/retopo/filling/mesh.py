"""Fill all patches of a network, and weld them to one mesh of quads."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling.edgecounts import complete_counts
from patterndb_sketch.retopo.filling.fills import fill_patch
from patterndb_sketch.retopo.filling.location import find_islands
from patterndb_sketch.retopo.filling.placing import (
    PlacedPatch,
    is_divided_alike,
    name_border_vertices,
)
from patterndb_sketch.retopo.network import (
    FACE,
    SYMMETRY,
    Chain,
    Density,
    HalfChain,
    Network,
    Patch,
)
from patterndb_sketch.retopo.network.invariants import list_kept_faces
from patterndb_sketch.retopo.wording import count_places
from query.engine import PatternSource


@dataclass(frozen=True, slots=True, eq=False)
class FilledNetwork:
    """A network with its counts and fills, and where they lie.

    placed: of every patch that has quads, by id. notes: what could not be.
    """

    network: Network
    placed: dict[int, PlacedPatch]
    notes: tuple[str, ...] = ()


#: Placed patches that a cache keeps beside twice those that there are: steps taken back show them.
SPARE = 200


@dataclass(slots=True)
class PlacedCache:
    """Placed patches of networks before: after an edit only the patches concerned are placed
    anew. Results do not depend on it."""

    _kept: dict[int, tuple[Patch, tuple[Chain, ...], Density, PlacedPatch]] = field(
        default_factory=dict
    )

    def get(self, network: Network, patch: Patch) -> PlacedPatch | None:
        kept = self._kept.get(patch.id)
        if kept is None:
            return None
        former, chains, density, placed = kept
        same = (
            former.loop == patch.loop
            and former.corners == patch.corners
            and former.choice == patch.choice
            and all(
                _is_same_chain(network.chains[half >> 1], chain)
                and is_divided_alike(chain, density, network.density)
                for half, chain in zip(patch.loop, chains, strict=True)
            )
        )
        return placed if same else None

    def put(self, network: Network, patch: Patch, placed: PlacedPatch) -> None:
        chains = tuple(network.chains[half >> 1] for half in patch.loop)
        self._kept[patch.id] = patch, chains, network.density, placed

    def trim(self, count: int) -> None:
        """Keep no more than so many, those that were placed last."""
        for number in list(self._kept)[: max(len(self._kept) - count, 0)]:
            del self._kept[number]


def fill_network(
    network: Network,
    surface: Surface,
    source: PatternSource,
    edge: float,
    cache: PlacedCache | None = None,
) -> FilledNetwork:
    """The network with counts and fills for all its patches, placed on the surface.

    edge: target length of an edge. Counts and fills that are there stay where they suit. What
    has no quads, and why, is in the notes: patches without a fill, and those within which others
    lie that no curve joins to them.
    """
    cache = PlacedCache() if cache is None else cache
    network, notes = complete_counts(network, edge)
    placed: dict[int, PlacedPatch] = {}
    told = list(notes)
    for patch in sorted(network.patches):
        found = cache.get(network, network.patches[patch])
        if found is None:
            try:
                network, found = fill_patch(network, surface, source, patch)
            except RefusedError as error:
                told.append(str(error))
                continue
            cache.put(network, network.patches[patch], found)
        placed[patch] = found
        if len(found.flipped):
            what = count_places("a flipped quad", "flipped quads", found.find_flipped())
            told.append(f"patch {patch} has {what}")
    cache.trim(SPARE + 2 * len(network.patches))
    for patch, other in find_islands(network, surface, placed).items():
        del placed[patch]
        what = "a face that was given" if other is None else f"patch {other}"
        told.append(
            f"patch {patch} has no quads: {what} lies within it, joined to none of its "
            "sides; join them by a curve, or erase one"
        )
    doubled = find_doublets(network, placed)
    if len(doubled):
        told.append(
            f"{count_places('a doublet', 'doublets', doubled)}: a vertex with two quads, where two "
            "patches and nothing else have a corner; delete that, or lead a curve to it"
        )
    return FilledNetwork(network, placed, tuple(told))


#: Quads around a doublet, an inner vertex whose quads lie over or beside each other. It comes where
#: two patches have a corner and nothing else has, as at a bend in a curve that no other curve leads
#: to. Smoothing cannot open it.
DOUBLET = 2


def find_doublets(network: Network, placed: Mapping[int, PlacedPatch]) -> Points:
    """(k, 3) the inner vertices with two quads, patch by patch.

    What is on the plane of symmetry has as many quads again beyond it. Corners of faces that were
    given are as they were given.
    """
    covered = {half for patch in placed for half in network.patches[patch].loop}

    def is_closed(half: HalfChain) -> bool:
        return half in covered or network.mark(half) == SYMMETRY

    uses: dict[tuple[int, int], int] = {}
    points: dict[tuple[int, int], Points] = {}
    found: list[Points] = []
    for patch in sorted(placed):
        one = placed[patch]
        valence = np.bincount(one.quads.ravel(), minlength=len(one.vertices))
        inner = np.flatnonzero(valence[one.perimeter :] == DOUBLET) + one.perimeter
        found += list(one.vertices[inner])
        for k, key in enumerate(name_border_vertices(network, network.patches[patch])):
            uses[key] = uses.get(key, 0) + int(valence[k])
            points[key] = one.vertices[k]
    for (number, along), quads in uses.items():
        if quads > DOUBLET:
            continue
        around = (2 * number,) if along >= 0 else network.nodes[number].ends
        if any(FACE in network.chains[half >> 1].marks for half in around):
            continue
        whole = all(is_closed(half) and is_closed(half ^ 1) for half in around)
        seam = any(SYMMETRY in network.chains[half >> 1].marks for half in around)
        if whole and quads * (2 if seam else 1) == DOUBLET:
            found.append(points[number, along])
    return np.array(found).reshape(-1, 3)


@dataclass(frozen=True, slots=True, eq=False)
class RetopoMesh:
    """All quads of a network as one mesh, with the faces that were given and stay.

    vertices, normals: (v, 3) float64. quads: (q, 4) int32. patch: (q,) int32, the id of the
    patch that each belongs to. node: (v,) int32, the network's node that a vertex is, or -1;
    chain: (v,) int32, the chain that it lies on, or -1. kept: the vertices of every face that was
    given, counter-clockwise; triangles and larger ones.
    """

    vertices: Points
    normals: Points
    quads: Int32Array
    patch: Int32Array
    node: Int32Array
    chain: Int32Array
    kept: tuple[tuple[int, ...], ...] = ()

    def list_sides(self) -> tuple[Int32Array, Int32Array]:
        """(h,) the vertices that all sides of faces leave, and (h,) those that they lead to: those
        of quads, quad by quad, then those of kept faces."""
        tail = [self.quads.ravel(), *(np.array(face, np.int32) for face in self.kept)]
        head = [np.roll(self.quads, -1, axis=1).ravel()]
        head += [np.roll(np.array(face, np.int32), -1) for face in self.kept]
        return np.concatenate(tail), np.concatenate(head)


def weld_patches(found: FilledNetwork) -> RetopoMesh:
    """The patches as one mesh, welded by what the network says is one place, never by distance."""
    network = found.network
    name: dict[tuple[int, int], int] = {}
    points: list[NDArray[np.float64]] = []
    normals: list[NDArray[np.float64]] = []
    node: list[int] = []
    chain: list[int] = []
    quads: list[Int32Array] = [np.empty((0, 4), np.int32)]
    owner: list[Int32Array] = [np.empty(0, np.int32)]
    for patch in sorted(found.placed):
        placed = found.placed[patch]
        keys = name_border_vertices(network, network.patches[patch])
        number = np.empty(len(placed.vertices), np.int32)
        for k in range(len(placed.vertices)):
            key = keys[k] if k < len(keys) else None
            if key is not None and key in name:
                number[k] = name[key]
                continue
            number[k] = len(points)
            if key is not None:
                name[key] = len(points)
            points.append(placed.vertices[k])
            normals.append(placed.normals[k])
            node.append(key[0] if key is not None and key[1] < 0 else -1)
            chain.append(key[0] if key is not None and key[1] >= 0 else -1)
        quads.append(number[placed.quads])
        owner.append(np.full(len(placed.quads), patch, np.int32))
    kept: list[tuple[int, ...]] = []
    for loop in list_kept_faces(network):
        around = [network.nodes[network.origin(half)] for half in loop]
        for at in around:
            if (at.id, -1) not in name:
                name[at.id, -1] = len(points)
                points.append(at.point)
                normals.append(at.normal)
                node.append(at.id)
                chain.append(-1)
        kept.append(tuple(name[at.id, -1] for at in around))
    return RetopoMesh(
        np.array(points).reshape(-1, 3),
        np.array(normals).reshape(-1, 3),
        np.concatenate(quads).astype(np.int32),
        np.concatenate(owner),
        np.array(node, np.int32),
        np.array(chain, np.int32),
        tuple(kept),
    )


def find_irregular_vertices(mesh: RetopoMesh) -> tuple[Int32Array, Int32Array]:
    """(k,) vertices whose number of faces is not 4 inside, or 2 on a border, and (k,) how many.

    Corners of an open border, with one quad, count; kept faces are faces, too.
    """
    valence = np.bincount(mesh.list_sides()[0], minlength=len(mesh.vertices))
    rim = np.zeros(len(mesh.vertices), np.bool_)
    rim[find_open_edges(mesh).ravel()] = True
    wrong = np.flatnonzero((valence != np.where(rim, 2, 4)) & (valence > 0))
    return wrong.astype(np.int32), valence[wrong].astype(np.int32)


def find_open_edges(mesh: RetopoMesh) -> Int32Array:
    """(e, 2) edges with one face."""
    tail, head = mesh.list_sides()
    low, high = np.minimum(tail, head).astype(np.int64), np.maximum(tail, head)
    _, first, uses = np.unique((low << 32) | high, return_index=True, return_counts=True)
    lone = first[uses == 1]
    return np.stack([tail[lone], head[lone]], axis=1).astype(np.int32)


def _is_same_chain(one: Chain, other: Chain) -> bool:
    return one is other or (
        one.count == other.count
        and one.is_closed_loop == other.is_closed_loop
        and np.array_equal(one.points, other.points)
    )
