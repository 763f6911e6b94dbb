"""Lay out a field: its separatrices as the chains of a network, with counts."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points, units
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.draft.arcs import cut_segments, find_arcs
from patterndb_sketch.retopo.draft.assembly import (
    AtSingularity,
    DraftLine,
    InWedge,
    LayoutBuilder,
    OnLine,
    OnWall,
    RoundRegionError,
    is_cellular,
)
from patterndb_sketch.retopo.draft.crossfield import CrossField, list_corner_indices
from patterndb_sketch.retopo.draft.drafted import DraftedNetwork, DraftSetting, scale_counts
from patterndb_sketch.retopo.draft.seeds import (
    RegularParts,
    find_seed,
    find_tips,
    has_long_patch,
    seed_rims_at,
    seed_rings,
)
from patterndb_sketch.retopo.draft.task import REMESHED, DraftBudget
from patterndb_sketch.retopo.draft.tracing import (
    AT_BORDER,
    AT_LINE,
    LineSegments,
    Starts,
    TracedLines,
    start_at_vertices,
    trace_lines,
)
from patterndb_sketch.retopo.draft.walls import Walls
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling import choose_counts
from patterndb_sketch.retopo.network import Network
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.wording import format_place

#: T-junctions on both sides of a line, nearer than this to each other in target edges, are one
#: crossing.
JOINING = 0.7

#: A trace this long, in diagonals, is cut off, and the try with it.
LONGEST_TRACE = 12.0

#: A line that ends on a drawn curve nearer than this to its end, in target edges, ends there.
AT_NODE = 0.35

#: Regular places from which lines are traced, too, where regions would be rings: a torus, whose
#: field has no singularity, needs one.
MOST_SEEDS = 12

#: Number of these that leave the same region without corners, after which no other is tried.
SAME_REGION = 3

#: As many are tried on a bare surface with a region that has no corners, as one that is a tube.
BARE_SEEDS = 3

#: Number of edges of a line that take as long to lay as a quad takes to make.
EDGES_A_QUAD = 4.0


def draft_network(
    network: Network,
    surface: Surface,
    sizes: Sizes,
    setting: DraftSetting,
    field: CrossField,
    budget: DraftBudget | None = None,
    wanted: float | None = None,
) -> DraftedNetwork:
    """One try, with the field of its setting; raises RefusedError, with the place, where it comes
    to nothing. budget: is spent on lines that come to nothing; no further ones follow then."""
    budget = budget or DraftBudget()
    walls = Walls(network, AT_NODE * sizes.edge)
    total, due = int(field.index.sum()), 4 * field.mesh.euler
    if total != due:
        raise RefusedError(
            f"the field's indices sum to {total}, and to {due} on any field: the "
            "surface has folds that are too sharp; smooth it, or draw by hand"
        )
    poles = np.flatnonzero((field.index > 2) & ~field.mesh.on_border)
    if len(poles):
        raise RefusedError(
            f"fewer than two lines would end at {format_place(field.mesh.vertices[poles[0]])}: a "
            "part of the surface is smaller than an edge there, or it has a needle; take that "
            "away, or a smaller edge"
        )
    seeds = find_tips(network, field, AT_NODE * sizes.edge)
    if not walls.bare:
        seeds += seed_rings(field, seeds)
    regular = RegularParts.of(field, surface)
    laid: _LaidField | None = None
    why = "some regions would be rings or handles; draw by hand"
    again = 0
    for tried in range(MOST_SEEDS + 1):
        if tried and budget.spent:
            break
        before = budget.left
        try:
            found = _lay_field(network, surface, sizes, field, walls, seeds, budget)
        except RoundRegionError as error:
            # A bare surface that goes on coming out so is too thin for its edges.
            if walls.bare and tried == BARE_SEEDS:
                raise
            if not walls.bare and error.at is not None and tried < MOST_SEEDS:
                more = seed_rims_at(field, error.at, 2.0 * REMESHED * sizes.edge, seeds)
                if more:
                    seeds += more
                    why = str(error)
                    continue
            again = again + 1 if str(error) == why else 1
            found, why = None, str(error)
            if again == SAME_REGION:
                # Further places cut other regions, and not this one.
                if laid is None:
                    raise
                break
        if found is not None and is_cellular(found.network, surface):
            laid = found
            budget.left = before
            if not has_long_patch(found.network, surface, regular):
                break
        seeds.append(find_seed(field, regular, seeds))
    if laid is None:
        raise RefusedError(why)
    edge = setting.finer * sizes.edge
    if wanted is None:
        counted, _ = choose_counts(laid.network, edge)
    else:
        counted, edge = scale_counts(laid.network, edge, wanted)
    corners = list_corner_indices(field.mesh)
    singular = int((field.index != corners).sum())
    return DraftedNetwork(counted, laid.chains, laid.kept, singular, edge)


@dataclass(frozen=True, slots=True, eq=False)
class _LaidField:
    """The network of a field's separatrices. chains: those that are theirs. kept: the patches that
    were there, which have other ids if lines end on their borders."""

    network: Network
    chains: frozenset[int]
    kept: frozenset[int]


def _lay_field(
    network: Network,
    surface: Surface,
    sizes: Sizes,
    field: CrossField,
    walls: Walls,
    seeds: list[int],
    budget: DraftBudget,
) -> _LaidField | None:
    """Lay the separatrices of a field; None if a line runs on and on. budget: is spent on them."""
    mesh = field.mesh
    starts = start_at_vertices(field, [*field.singular.tolist(), *seeds])
    arcs = find_arcs(field, starts, sizes.edge)
    laid = [LineSegments.none()]
    for k, arc in enumerate(arcs):
        laid.append(cut_segments(field, arc.points, arc.triangles, k))
    used = {end for arc in arcs for end in (arc.begin, arc.end)}
    free = np.array([k for k in range(len(starts)) if k not in used], np.intp)
    left = starts[free]
    longest = LONGEST_TRACE * mesh.surface.diagonal
    traced = trace_lines(field, left, LineSegments.joined(laid), len(arcs), longest)
    budget.spend(float(traced.length.sum()) / (EDGES_A_QUAD * sizes.edge))
    if not np.isin(traced.ended, (AT_LINE, AT_BORDER)).all():
        return None
    joints = _Joints(field, walls, starts)
    lines: list[DraftLine] = []
    for arc in arcs:
        normals = _normals_along(field, arc.triangles)
        along = np.concatenate(
            [[0.0], np.cumsum(np.linalg.norm(np.diff(arc.points, axis=0), axis=1))]
        )
        one = joints.start(arc.begin, (int(arc.triangles[0]), arc.points[1]))
        two = joints.start(arc.end, (int(arc.triangles[-1]), arc.points[-2]))
        lines.append(DraftLine(arc.points, normals, along, one, two))
    lines += _list_traces(field, free, left, traced, joints, len(arcs))
    corners = joints.corners()
    builder = LayoutBuilder(network, surface, sizes, lines, JOINING * sizes.edge, corners)
    made = builder.build()
    laid_here = frozenset(builder.laid & made.chains.keys())
    own = {c: replace(made.chains[c], auto=True) for c in sorted(laid_here)}
    return _LaidField(replace(made, chains={**made.chains, **own}), laid_here, builder.kept)


def _normals_along(field: CrossField, triangles: Int32Array) -> Points:
    """(n + 1, 3) normals at the points between pieces in triangles (n,)."""
    up = field.mesh.normal[triangles]
    return units(np.concatenate([up[:1], up[:-1] + up[1:], up[-1:]]))


def _list_traces(
    field: CrossField,
    free: np.ndarray,
    left: Starts,
    traced: TracedLines,
    joints: _Joints,
    arcs: int,
) -> Iterator[DraftLine]:
    mesh = field.mesh
    segments = traced.segments
    begins = segments.lift(mesh, segments.begin)
    ends = segments.lift(mesh, segments.end)
    bounds = np.searchsorted(segments.line, arcs + np.arange(len(left) + 1))
    for i in range(len(left)):
        mine = slice(int(bounds[i]), int(bounds[i + 1]))
        points = np.concatenate([begins[mine], ends[mine][-1:]])
        normals = _normals_along(field, segments.triangle[mine])
        along = np.concatenate([segments.along[mine], [traced.length[i]]])
        if traced.ended[i] == AT_BORDER:
            end = joints.on_border(points[-1], int(traced.other[i]))
        else:
            end = OnLine(int(traced.other[i]), float(traced.there[i]), bool(traced.left[i]))
        yield DraftLine(points, normals, along, joints.start(int(free[i])), end)


class _Joints:
    """Where lines begin and end, in terms of the network."""

    def __init__(self, field: CrossField, walls: Walls, starts: Starts) -> None:
        self.field = field
        self.walls = walls
        self.starts = starts
        self.borders: dict[int, OnWall | InWedge] = {}
        mesh = field.mesh
        begun = np.zeros(len(field.index), np.bool_)
        begun[starts.vertex] = True
        for vertex in np.flatnonzero(mesh.on_border & ((field.index != 0) | begun)).tolist():
            self.borders[vertex] = self.on_border(mesh.vertices[vertex], int(mesh.leaving[vertex]))

    def start(
        self, k: int, led: tuple[int, Points] | None = None
    ) -> AtSingularity | OnWall | InWedge:
        """The joint of a start; led: the triangle and the point that an arc goes to from there,
        which need not be where the trace would have gone."""
        mesh = self.field.mesh
        vertex, triangle = int(self.starts.vertex[k]), int(self.starts.triangle[k])
        corner, angle = int(self.starts.corner[k]), float(self.starts.angle[k])
        if led is not None:
            triangle = led[0]
            corner = int(np.flatnonzero(mesh.triangles[triangle] == vertex)[0])
            away = led[1] - mesh.vertices[vertex]
            angle = float(np.arctan2(away @ mesh.y[triangle], away @ mesh.x[triangle]))
        turned = (angle - mesh.side_angle[triangle, corner] + 0.1) % (2.0 * np.pi) - 0.1
        share = min(max(turned / mesh.corner_angle[triangle, corner], 0.0), 1.0)
        order = mesh.list_ring(vertex).index(3 * triangle + corner) + share
        if vertex in self.borders:
            at = self.borders[vertex]
            return replace(at, order=order + (at.order if isinstance(at, InWedge) else 0.0))
        return AtSingularity(vertex, order)

    def on_border(self, point: Points, side: int) -> OnWall | InWedge:
        """The place of the network's border chains that a place on a border's side is."""
        mesh = self.field.mesh
        f, e = divmod(side, 3)
        tail, head = mesh.vertices[mesh.triangles[f, [e, (e + 1) % 3]]]
        return self.walls.find_place(point, head - tail, 0.5 * (tail + head))

    def corners(self) -> list[OnWall | InWedge]:
        """Border vertices with one wedge, which no line leaves."""
        return [at for vertex, at in self.borders.items() if self.field.index[vertex] == 1]
