"""Lay out a field: its separatrices as the chains of a network, with counts, and a price."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points, units
from patterndb.geometry.polyline import arc_length
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.draft.assembly import (
    DraftLine,
    LayoutBuilder,
    RoundRegionError,
    is_cellular,
)
from patterndb_sketch.retopo.draft.crossfield import CrossField, list_corner_indices
from patterndb_sketch.retopo.draft.joints import Constraints, Joints, OnLine
from patterndb_sketch.retopo.draft.seeds import (
    RegularParts,
    find_seed,
    find_tips,
    has_long_patch,
    seed_rims_at,
    seed_rings,
)
from patterndb_sketch.retopo.draft.settings import SETTINGS, FieldSetting
from patterndb_sketch.retopo.draft.task import DraftBudget
from patterndb_sketch.retopo.draft.tracing import (
    AT_BORDER,
    AT_LINE,
    LineSegments,
    Starts,
    TracedLines,
    cut_segments,
    find_arcs,
    start_at_vertices,
    trace_lines,
)
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling import choose_counts
from patterndb_sketch.retopo.filling.edgecounts import side_lengths
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


@dataclass(frozen=True, slots=True, eq=False)
class CountedLayout:
    """A draft: a network with counts on every chain. laid: the chains that are the draft's own.
    kept: the patches that are not. singular: irregular vertices of its field. edge: of its counts.
    """

    network: Network
    laid: frozenset[int]
    kept: frozenset[int]
    singular: int
    edge: float


def lay_out(
    network: Network,
    surface: Surface,
    sizes: Sizes,
    setting: FieldSetting,
    field: CrossField,
    budget: DraftBudget | None = None,
    wanted: float | None = None,
) -> CountedLayout:
    """One try, with the field of its setting; raises RefusedError, with the place, where it comes
    to nothing. budget: is spent on lines that come to nothing; no further ones follow then."""
    budget = budget or DraftBudget()
    walls = Constraints(network, AT_NODE * sizes.edge)
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
    for tried in range(SETTINGS.most_seeds + 1):
        if tried and budget.spent:
            break
        before = budget.left
        try:
            found = _lay_field(network, surface, sizes, field, walls, seeds, budget)
        except RoundRegionError as error:
            # A bare surface that goes on coming out so is too thin for its edges.
            if walls.bare and tried == SETTINGS.bare_seeds:
                raise
            if not walls.bare and error.at is not None and tried < SETTINGS.most_seeds:
                more = seed_rims_at(field, error.at, 2.0 * SETTINGS.field_edge * sizes.edge, seeds)
                if more:
                    seeds += more
                    why = str(error)
                    continue
            again = again + 1 if str(error) == why else 1
            found, why = None, str(error)
            if again == SETTINGS.same_region:
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
    return CountedLayout(counted, laid.chains, laid.kept, singular, edge)


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
    walls: Constraints,
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
    budget.spend(float(traced.length.sum()) / (SETTINGS.line_edges_per_quad * sizes.edge))
    if not np.isin(traced.ended, (AT_LINE, AT_BORDER)).all():
        return None
    joints = Joints(field, walls, starts)
    lines: list[DraftLine] = []
    for arc in arcs:
        normals = _normals_along(field, arc.triangles)
        along = arc_length(arc.points)
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
    joints: Joints,
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


def count_quads(network: Network) -> float:
    """About how many quads the fills of a network with counts have."""
    total = 0.0
    for patch in network.patches.values():
        n = side_lengths(network, patch)
        total += 0.25 * (n[0] + n[2]) * (n[1] + n[3]) if len(n) == 4 else (sum(n) / 4.0) ** 2
    return total


def scale_counts(network: Network, edge: float, wanted: float) -> tuple[Network, float]:
    """The network with counts for about so many quads: bounds that curvature sets go with the edge,
    so that a coarse mesh is not finer than it is to be; in the end they fall."""
    best: tuple[float, Network, float] | None = None
    low, high = 0.0, np.inf
    for _ in range(SETTINGS.scalings):
        counted, _ = choose_counts(network, edge, searches=0)
        ratio = count_quads(counted) / wanted
        if best is None or abs(np.log(ratio)) < best[0]:
            best = abs(float(np.log(ratio))), counted, edge
        if abs(ratio - 1.0) < SETTINGS.count_share:
            break
        if ratio > 1.0:
            low = max(low, edge)
        else:
            high = min(high, edge)
        edge *= float(np.sqrt(ratio))
        if not low < edge < high:
            edge = float(np.sqrt(low * high)) if np.isfinite(high) and low else edge
    assert best is not None
    return best[1], best[2]


def improve_counts(draft: CountedLayout, wanted: float) -> CountedLayout:
    """With better counts, which take long to find, where there are as many quads then."""
    better, _ = choose_counts(draft.network, draft.edge, searches=SETTINGS.searches)
    if abs(float(np.log(count_quads(better) / wanted))) > 2.0 * SETTINGS.count_share:
        return draft
    return replace(draft, network=better)


def measure_layout(draft: CountedLayout) -> tuple[float, float]:
    """About how many irregular vertices a draft will have, and how uneven its edges will be."""
    network = draft.network
    odd = 0
    for patch in network.patches.values():
        n = side_lengths(network, patch)
        odd += len(n) != 4 or n[0] != n[2] or n[1] != n[3]
    count = np.array([chain.count for chain in network.chains.values()], float)
    length = np.array([chain.length for chain in network.chains.values()])
    used = count > 0
    mean = length[used].sum() / count[used].sum()
    off = np.sqrt(np.average((length[used] / count[used] / mean - 1.0) ** 2, weights=count[used]))
    return draft.singular + 2.0 * odd, float(off)


def price_layout(draft: CountedLayout) -> float:
    odd, uneven = measure_layout(draft)
    return (
        1000.0 * odd / count_quads(draft.network) / SETTINGS.irregular_per_thousand
        + uneven / SETTINGS.uneven
    )
