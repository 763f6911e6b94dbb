"""The vertex brush: vertices of quads follow the hand, or are smoothed; chains follow them.

:class:`BrushedQuads` is what lies under the brush, and makes the network of vertices that moved.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Set
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points, units
from patterndb.geometry.polyline import arc_length, find_nearest_on
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.arguments import Argument, Number, Vector, optional_length
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling.edgecounts import complete_counts
from patterndb_sketch.retopo.filling.fills import fill_patch, filling_of
from patterndb_sketch.retopo.filling.location import find_patch
from patterndb_sketch.retopo.filling.mesh import (
    FilledNetwork,
    RetopoMesh,
    name_border_vertices,
    weld_patches,
)
from patterndb_sketch.retopo.filling.placing import divide_chain, divide_lengths, trace_border
from patterndb_sketch.retopo.network import Chain, Edit, Network, NetworkBuilder, set_choice
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.tool import Control, Result, Tool, ToolWork
from patterndb_sketch.retopo.tools.course import even_course, note_crossings
from patterndb_sketch.retopo.tracing.curves import take_to_surface
from query.engine import PatternSource

#: Rounds of smoothing at one call unless told otherwise.
ROUNDS = 5

#: Rounds of smoothing, at most, that a call may ask for.
MOST_ROUNDS = 100


def drag_vertices(
    network: Network,
    surface: Surface,
    source: PatternSource,
    sizes: Sizes,
    point: ArrayLike,
    normal: ArrayLike,
    to: ArrayLike,
) -> Edit:
    """Drag the vertices of the quads within the brush's radius (``sizes.brush``) of a point.

    point, normal: (3,) on the surface, where the drag begins; to: (3,), where it ends. Vertices
    whose normals agree move by shares (1 - t)^4 (4 t + 1) of the drag, t their distance as a part
    of the radius, and are taken to the surface. What the network keeps of it: see
    :meth:`BrushedQuads.move_to`. Vertices on borders and on the seam of symmetry stay.

    Counts and fills that are not chosen yet, and are needed, are chosen. Raises RefusedError if
    no quads are near or a curve would have no length. Source: the program of Takayama et al. 2013.
    """
    at, up = np.asarray(point, np.float64), np.asarray(normal, np.float64)
    if (np.asarray(to, np.float64) == at).all():
        return Edit.of(network, network)
    under = BrushedQuads.of(network, surface, source, sizes, at, up)
    foot = surface.nearest_facing(np.asarray(to, np.float64)[None], up[None])
    share = np.where(under.marked, 0.0, under.share)[:, None]
    points, normals = under.mesh.vertices.copy(), under.mesh.normals.copy()
    moves = share[:, 0] > 0.0
    points[moves], normals[moves] = take_to_surface(
        (points + share * (foot.points[0] - at))[moves],
        units(normals + share * (foot.normals[0] - up))[moves],
        surface,
        sizes,
    )

    def course(line: Chain) -> Points:
        by = weigh_falloff(line.points, at, sizes.brush) * (line.normals @ up > 0.0)
        # Ends that stay hold what is between them and the next vertex.
        over = by[[0, -1]] - under.values_on(line, share[:, 0])[[0, -1]]
        along, n = arc_length(line.points), max(line.count, 1)
        ends = divide_lengths(replace(line, count=n), under.network.density)
        off = np.interp(along, ends, np.arange(n + 1.0))
        by -= over[0] * np.maximum(1.0 - off, 0.0) + over[1] * np.maximum(1.0 - off[-1] + off, 0.0)
        return line.points + by[:, None] * (foot.points[0] - at)

    return under.move_to(network, surface, sizes, (points, normals), course)


def relax_vertices(
    network: Network,
    surface: Surface,
    source: PatternSource,
    sizes: Sizes,
    point: ArrayLike,
    normal: ArrayLike,
    rounds: int = ROUNDS,
) -> Edit:
    """Smooth the vertices of the quads within the brush's radius of a point.

    Each round takes every vertex, by the share of :func:`drag_vertices`, to the mean of its
    neighbours: for one on a side these are its two along the side and the inner ones of both
    patches, for a corner all around it. One on a curve that has quads on one side only goes to the
    middle between its neighbours along it, and stays on the curve; there, corners stay, and what
    is on a border or the seam of symmetry.

    Raises RefusedError if no quads are near. Source: the program of Takayama et al. 2013. Differs
    from it: there each patch weighs a corner's neighbours along its sides by half; as each such
    neighbour belongs to two patches, that is the mean of all.
    """
    at, up = np.asarray(point, np.float64), np.asarray(normal, np.float64)
    under = BrushedQuads.of(network, surface, source, sizes, at, up)
    start, neighbour = _list_neighbours(under.mesh)
    degree = np.diff(start)[:, None]
    free = np.flatnonzero((under.share > 0.0) & ~under.rim & ~under.marked)
    slide, before, after = under.find_sliding()
    points, normals = under.mesh.vertices, under.mesh.normals
    for _ in range(rounds):
        mean = np.add.reduceat(points[neighbour], start[:-1], axis=0) / degree
        wanted = points + under.share[:, None] * (mean - points)
        where, there = take_to_surface(wanted[free], normals[free], surface, sizes)
        middle = 0.5 * (points[before] + points[after]) - points[slide]
        slid = points[slide] + under.share[slide, None] * middle
        points, normals = points.copy(), normals.copy()
        points[free], normals[free] = where, there
        for k, place in zip(slide, slid, strict=True):
            points[k], normals[k] = _find_on_chain(network.chains[int(under.mesh.chain[k])], place)
    places = points

    def course(line: Chain) -> Points:
        return _smooth_course(under, line, places, rounds)

    return under.move_to(network, surface, sizes, (points, normals), course, under.one_sided)


def _smooth_course(under: BrushedQuads, line: Chain, places: Points, rounds: int) -> Points:
    """(n, 3) samples of a chain whose vertices are at other places: along the smooth curve through
    these where smoothing had full effect, and moved alongside the vertices where it had less."""
    density = under.network.density
    old = divide_chain(line, density)[0] if line.count else line.points[[0, -1]]
    moves = under.values_on(line, places - under.mesh.vertices)
    along = arc_length(line.points)
    number = np.arange(len(moves))
    ends = divide_lengths(line, density) if line.count else along[[0, -1]]
    at = np.interp(along, ends, number)
    by = np.stack([np.interp(at, number, moves[:, d]) for d in range(3)], axis=1)
    share = np.interp(at, number, under.values_on(line, under.share))
    weight = (1.0 - (1.0 - share) ** rounds)[:, None]
    curve = CubicSpline(number, old + moves, bc_type="natural")(at)
    return (1.0 - weight) * (line.points + by) + weight * curve


def _list_neighbours(mesh: RetopoMesh) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The vertices at the other ends of every vertex's edges: those of i are
    neighbour[start[i]:start[i + 1]]."""
    tail, head = (ends.astype(np.int64) for ends in mesh.list_sides())
    pairs = np.unique(
        np.concatenate([np.stack([tail, head], 1), np.stack([head, tail], 1)]), axis=0
    )
    start = np.concatenate([[0], np.cumsum(np.bincount(pairs[:, 0], minlength=len(mesh.vertices)))])
    return start, pairs[:, 1]


def _find_on_chain(line: Chain, point: Points) -> tuple[Points, Points]:
    """The point of a chain nearest to a point (3,), and the normal there."""
    _, k, share = find_nearest_on(line.points, point)
    at = line.points[k] + share * (line.points[k + 1] - line.points[k])
    up = (1.0 - share) * line.normals[k] + share * line.normals[k + 1]
    return at, units(up[None])[0]


#: A vertex that moves by less than this part of the surface's diagonal stays: it is at rest.
STILL = 1e-9

#: Where a chain's samples go, (n, 3), before they are taken to the surface; its ends are nodes'.
Course = Callable[[Chain], Points]


def weigh_falloff(points: Points, at: Points, radius: float) -> NDArray[np.float64]:
    """(n,) shares (1 - t)^4 (4 t + 1) of points (n, 3), t their distance as a part of a radius."""
    t = np.minimum(np.linalg.norm(points - at, axis=1) / radius, 1.0)
    return (1.0 - t) ** 4 * (4.0 * t + 1.0)


@dataclass(frozen=True, slots=True, eq=False)
class BrushedQuads:
    """The quads under the brush.

    network: with their counts and fills. mesh: the patches that may have vertices under it,
    welded. number: of every vertex of their fills in the mesh, by patch. at: of what is on the
    network, by its key, see :func:`name_border_vertices`. share: (v,) by which each moves, 0
    outside. one_sided: chains with quads on one side. rim: (v,) is it on one, or on the corner of
    one? marked: (v,) the same of chains that stay, borders and the seam.
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
        surface: Surface,
        source: PatternSource,
        sizes: Sizes,
        point: Points,
        normal: Points,
    ) -> BrushedQuads:
        """Of those within ``sizes.brush`` of a point (3,), whose normals agree with its own."""
        network, told = complete_counts(network, sizes.edge)
        notes = list(told)
        found = FilledNetwork(network, {})
        for patch in _find_near(network, surface, point, sizes.brush + sizes.edge):
            try:
                network, found.placed[patch] = fill_patch(network, surface, source, patch)
            except RefusedError as error:
                notes.append(str(error))
        mesh = weld_patches(replace(found, network=network))
        share = weigh_falloff(mesh.vertices, point, sizes.brush) * (mesh.normals @ normal > 0.0)
        if not share.any():
            raise RefusedError("no quads are under the brush; point at some, or make it larger")
        number: dict[int, Int32Array] = {}
        at: dict[tuple[int, int], int] = {}
        for patch, placed in found.placed.items():
            number[patch] = np.empty(len(placed.vertices), np.int32)
            number[patch][placed.quads] = mesh.quads[mesh.patch == patch]
            keys = name_border_vertices(network, network.patches[patch])
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
            _is_on(network, mesh, one_sided),
            _is_on(network, mesh, marked),
            tuple(notes),
        )

    def find_sliding(self) -> tuple[list[int], list[int], list[int]]:
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

    def move_to(
        self,
        before: Network,
        surface: Surface,
        sizes: Sizes,
        to: tuple[Points, Points],
        course: Course,
        still: frozenset[int] = frozenset(),
    ) -> Edit:
        """The network with vertices of the mesh at other points (v, 3) of the surface.

        to: these, and the normals (v, 3) there.

        Corners go where the vertices on them do. Chains on which a vertex or an end moved get the
        samples that ``course`` gives them, taken to the surface; ``still`` ones keep theirs. A
        patch of which a vertex moved holds its inner vertices where they are now, and one that
        holds all, as imported ones do, those on its border, too.
        """
        points, normals = to
        move = points - self.mesh.vertices
        move[np.abs(move).max(axis=1) <= STILL * surface.diagonal] = 0.0
        moved = np.any(move, axis=1)
        if not moved.any():
            return Edit.of(before, before, self.notes)
        builder = NetworkBuilder(self.network)
        lines: set[int] = set()
        for vertex in np.flatnonzero(moved):
            if self.mesh.node[vertex] >= 0:
                node = int(self.mesh.node[vertex])
                builder.move_node(node, points[vertex], normals[vertex])
                lines |= {half >> 1 for half in builder.nodes[node].ends}
            elif self.mesh.chain[vertex] >= 0:
                lines.add(int(self.mesh.chain[vertex]))
        for chain in sorted(lines - still):
            self._reshape(builder, surface, sizes, chain, course)
        after = builder.finish()
        for patch, number in self.number.items():
            if moved[number].any():
                filling = filling_of(after.patches[patch])
                assert filling.choice is not None
                whole = len(filling.moved_vertices[0]) == len(number)
                which = np.arange(0 if whole else filling.choice.perimeter, len(number))
                after = set_choice(after, patch, filling.with_moved(which, points[number[which]]))
        told = note_crossings(self.network, after, lines - still, sizes)
        return Edit.of(before, after, (*self.notes, *told))

    def values_on(self, line: Chain, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """(count + 1, ...) values of a chain's vertices, given those of the mesh's; 0 for those
        that are not in it."""
        inner = [(line.id, k) for k in range(1, max(line.count, 1))]
        keys = [(line.start, -1), *inner, (line.end, -1)]
        none = np.zeros(values.shape[1:])
        return np.array([values[self.at[key]] if key in self.at else none for key in keys])

    def _reshape(
        self, builder: NetworkBuilder, surface: Surface, sizes: Sizes, chain: int, course: Course
    ) -> None:
        line = self.network.chains[chain]
        wanted = course(line)
        points, normals = line.points.copy(), line.normals.copy()
        goes = np.any(wanted != points, axis=1)
        goes[[0, -1]] = False
        points[goes], normals[goes] = take_to_surface(wanted[goes], normals[goes], surface, sizes)
        for k, node in ((0, line.start), (-1, line.end)):
            points[k], normals[k] = builder.nodes[node].point, builder.nodes[node].normal
        builder.reshape_chain(chain, *even_course(points, normals, surface, sizes, False))
        if not builder.chains[chain].length > 0.0:
            raise RefusedError("a curve would have no length: drag less far")


def _find_near(network: Network, surface: Surface, point: Points, radius: float) -> list[int]:
    """The patches that a point is in, or that have a border vertex within a radius of it."""
    found = {
        patch.id
        for patch in network.patches.values()
        if np.linalg.norm(trace_border(network, patch)[0] - point, axis=1).min() < radius
    }
    try:
        found.add(find_patch(network, surface, point))
    except RefusedError:
        if not found:
            raise RefusedError("no quads are near; point at some") from None
    return sorted(found)


def _is_on(network: Network, mesh: RetopoMesh, chains: Set[int]) -> NDArray[np.bool_]:
    """(v,) is a vertex on one of some chains, or on a node where one ends?"""
    ids = np.array(sorted(chains), np.int64)
    ends = [node for k in chains for node in (network.chains[k].start, network.chains[k].end)]
    nodes = np.array(sorted({node for node in ends if node >= 0}), np.int64)
    return np.isin(mesh.chain, ids) | np.isin(mesh.node, nodes)


def _drag(work: ToolWork, a: dict[str, Any]) -> Result:
    start, end = work.find_foot(a["at"]), work.find_foot(a["to"])
    return work.keep_edit(
        drag_vertices(
            work.network,
            work.surface,
            work.source,
            _brush_sizes(work, "brush", a["radius"]),
            start.points[0],
            start.normals[0],
            end.points[0],
        )
    )


def _relax(work: ToolWork, a: dict[str, Any]) -> Result:
    start = work.find_foot(a["at"])
    return work.keep_edit(
        relax_vertices(
            work.network,
            work.surface,
            work.source,
            _brush_sizes(work, "relax", a["radius"]),
            start.points[0],
            start.normals[0],
            a["rounds"],
        )
    )


def _brush_sizes(work: ToolWork, tool: str, radius: float | None) -> Sizes:
    """The sizes with the brush that a call asks for."""
    if radius is None:
        return work.state.sizes
    return replace(work.state.sizes, brush=work.check_length(f"{tool}: radius", radius))


_MIDDLE = Argument(Vector(), "a point of the surface, the brush's middle")
_RADIUS = optional_length("of the brush")

BRUSH = Tool(
    "brush",
    "Drag the quads' vertices under the brush; curves follow.",
    {"at": _MIDDLE, "to": Argument(Vector(), "where it is dragged to"), "radius": _RADIUS},
    _drag,
    position=210,
    holds=True,
    control=Control("6", "brush", "drag the vertices of quads", target="none", brush="brush"),
)

RELAX = Tool(
    "relax",
    "Smooth the quads' vertices under the brush; curves follow.",
    {
        "at": _MIDDLE,
        "radius": _RADIUS,
        "rounds": Argument(Number(1, MOST_ROUNDS, whole=True), "of smoothing", ROUNDS),
    },
    _relax,
    position=220,
    holds=True,
    control=Control("7", "relax", "click: vertices are evened out", target="none", brush="brush"),
)
