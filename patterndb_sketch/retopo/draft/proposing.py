"""A first draft of a network: separatrices of a cross field, laid, counted, the best of settings.

:func:`propose_draft` is all of it; :class:`DraftSetting` is what differs between tries.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points, units
from patterndb_sketch.retopo.counts.rules import sum_costs
from patterndb_sketch.retopo.draft.arcs import cut_segments, find_arcs
from patterndb_sketch.retopo.draft.assembly import (
    AtSingularity,
    DraftLine,
    InWedge,
    NetworkBuilder,
    OnLine,
    OnWall,
    RoundRegionError,
    is_cellular,
)
from patterndb_sketch.retopo.draft.creases import add_creases
from patterndb_sketch.retopo.draft.crossfield import CrossField, FieldSolver, list_corner_indices
from patterndb_sketch.retopo.draft.fieldmesh import FieldMesh
from patterndb_sketch.retopo.draft.fitting import fit_quads, sample_both_sides
from patterndb_sketch.retopo.draft.handles import find_shortest_handle
from patterndb_sketch.retopo.draft.imprint import cut_along_creases, cut_along_curves
from patterndb_sketch.retopo.draft.judging import MOST_OFF, DraftJudge
from patterndb_sketch.retopo.draft.remesh import remesh_parts
from patterndb_sketch.retopo.draft.sharpedges import SharpRule
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
from patterndb_sketch.retopo.filling import (
    FilledNetwork,
    PlacedCache,
    choose_counts,
    fill_between,
    fill_network,
    has_suitable_fill,
)
from patterndb_sketch.retopo.filling.edgecounts import NumberedCounts, side_lengths
from patterndb_sketch.retopo.filling.report import Report
from patterndb_sketch.retopo.ground import Ground
from patterndb_sketch.retopo.network import Network
from patterndb_sketch.retopo.network.faces import GroundParts
from patterndb_sketch.retopo.network.keptfaces import list_kept_faces
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.symmetry import Half
from patterndb_sketch.retopo.wording import count_places, format_place, round_down
from query.engine import PatternSource

#: Edges of the mesh that the field is solved on, in target edges.
REMESHED = 0.4

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

#: Where so many of these leave the same region without corners no other is tried.
SAME_REGION = 3

#: As many are tried on a bare surface with a region that has no corners, as one that is a tube.
BARE_SEEDS = 3


#: Where a field has no singularity, regions with a longer border, in diagonals, are cut by a
#: further place. It is
#: the longest loop that Takayama et al.'s program takes for a patch.
LONGEST_LOOP = 2.0


#: Quads of drafts that came out unsound, or what takes as long, after which nothing else is tried:
#: a dozen seconds of work.
MOST_IN_VAIN = 6000

#: The same for the half of a symmetric surface: the whole is still to be tried then.
IN_VAIN_BY_HALVES = 2000

#: Laying so many edges of a line takes as long as making a quad does.
EDGES_A_QUAD = 4.0

#: Finding a field on so many triangles takes as long as making a quad does.
TRIANGLES_A_QUAD = 40.0


@dataclass(slots=True)
class DraftBudget:
    """How many quads of unsound drafts may yet be made, counted on the ground that is worked on."""

    left: float = MOST_IN_VAIN

    @property
    def spent(self) -> bool:
        return self.left <= 0

    def spend(self, quads: float) -> None:
        self.left -= quads


#: A draft of few quads may be this part of their edges off: at 300 quads a sphere is 2 % of its
#: diagonal off its own fills.
OFF_IN_EDGES = 0.4


@dataclass(frozen=True, slots=True)
class DraftGoal:
    """What a draft is to be like.

    quad: the edge length that the wanted number of quads gives, in the surface's unit; None if no
    number is wanted, and edges are as long as the sizes have them.
    sharp: which edges are creases that are kept; None for none of them.
    closed: are creases with an open end left out?
    """

    quad: float | None = None
    sharp: SharpRule | None = None
    closed: bool = False

    def count_quads(self, ground: Ground) -> float | None:
        """Return how many quads a ground is to have, None if no number is wanted."""
        return None if self.quad is None else float(ground.surface.areas.sum()) / self.quad**2

    def allow_off(self, ground: Ground) -> float:
        """Return how far off a ground quads may be, in its diagonals."""
        if self.quad is None:
            return MOST_OFF
        return max(MOST_OFF, OFF_IN_EDGES * self.quad / ground.diagonal)


@dataclass(frozen=True, slots=True, eq=False)
class DraftTask:
    """What is drafted, and with what.

    network: borders, the seam of symmetry and curves that are drawn, along which the field runs and
    on which lines end; what patches cover stays as it is.
    half: that the ground is of a symmetric surface, if it is one: quads are fitted to both sides,
    and reports are about both.
    budget: when it is spent, no other setting is tried.
    """

    network: Network
    ground: Ground
    sizes: Sizes
    source: PatternSource
    half: Half | None = None
    goal: DraftGoal = DraftGoal()
    budget: DraftBudget = field(default_factory=DraftBudget)


@dataclass(frozen=True, slots=True)
class DraftSetting:
    """alignment: how much directions of curvature weigh. merging: singularities of opposed
    indices nearer than this, in target edges, are cancelled. finer: edges are so many times as
    long as asked for, where those come too far off the surface."""

    alignment: float
    merging: float
    finer: float = 1.0


#: What is tried, until one comes out well; of the first TRIED at least the best is taken, and the
#: first of equals. Measured on four surfaces: where only pairs nearer than 3 edges are cancelled
#: there are half as many irregular vertices again, where further ones than 4.5 are, those of legs
#: go, whose quads are sheared then. With directions of curvature weighing twice as much human_man
#: has 45 irregular vertices instead of 54.
TRIED = 3
SETTINGS = (
    DraftSetting(0.003, 3.75),
    DraftSetting(0.003, 4.5),
    DraftSetting(0.006, 3.75),
    DraftSetting(0.01, 2.0),
    DraftSetting(0.003, 3.75, 0.8),
)


@dataclass(frozen=True, slots=True, eq=False)
class DraftedNetwork:
    """A draft: a network with counts on every chain. laid: the chains that are the draft's own.
    singular: irregular vertices of its field. cost: of its counts."""

    network: Network
    laid: frozenset[int]
    setting: DraftSetting
    singular: int
    cost: float
    edge: float


def draft_network(
    network: Network,
    ground: Ground,
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
    seeds = _find_tips(network, field, AT_NODE * sizes.edge)
    if not walls.bare:
        seeds += _seed_rings(field, seeds)
    regular = RegularParts.of(field, ground)
    laid: tuple[Network, frozenset[int]] | None = None
    why = "some regions would be rings or handles; draw by hand"
    again = 0
    for tried in range(MOST_SEEDS + 1):
        if tried and budget.spent:
            break
        before = budget.left
        try:
            found = _lay_field(network, ground, sizes, field, walls, seeds, budget)
        except RoundRegionError as error:
            # A bare surface that goes on coming out so is too thin for its edges.
            if walls.bare and tried == BARE_SEEDS:
                raise
            if not walls.bare and error.at is not None and tried < MOST_SEEDS:
                more = _seed_rims_at(field, error.at, 2.0 * REMESHED * sizes.edge, seeds)
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
        if found is not None and is_cellular(found[0], ground):
            laid = found
            budget.left = before
            if not _has_long_patch(found[0], ground, regular):
                break
        seeds.append(_find_seed(field, regular, seeds))
    if laid is None:
        raise RefusedError(why)
    edge = setting.finer * sizes.edge
    if wanted is None:
        counted, _ = choose_counts(laid[0], edge)
    else:
        counted, edge = scale_counts(laid[0], edge, wanted)
    costs = NumberedCounts.of(counted, edge, anew=True)
    cost = sum_costs(costs.problem, costs.counts(counted))
    corners = list_corner_indices(field.mesh)
    singular = int((field.index != corners).sum())
    return DraftedNetwork(counted, laid[1], setting, singular, cost, edge)


#: Quads are as many as wanted within this share, as far as rounds of scaling the edge come to it.
NEAR_ENOUGH, SCALINGS = 0.03, 6

#: Balls in which counts of the draft that is made are improved.
BALLS = 4


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
    for _ in range(SCALINGS):
        counted, _ = choose_counts(network, edge, n_balls=0)
        ratio = count_quads(counted) / wanted
        if best is None or abs(np.log(ratio)) < best[0]:
            best = abs(float(np.log(ratio))), counted, edge
        if abs(ratio - 1.0) < NEAR_ENOUGH:
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


def improve_counts(draft: DraftedNetwork, wanted: float) -> DraftedNetwork:
    """With better counts, which take long to find, where there are as many quads then."""
    better, _ = choose_counts(draft.network, draft.edge, n_balls=BALLS)
    if abs(float(np.log(count_quads(better) / wanted))) > 2.0 * NEAR_ENOUGH:
        return draft
    return replace(draft, network=better)


def measure_layout(draft: DraftedNetwork) -> tuple[float, float]:
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


#: So many irregular vertices in a thousand quads weigh as much as edges that differ by so much.
ODD_IN_THOUSAND, UNEVEN = 20.0, 0.2

#: And as much as so many poor quads in a thousand.
POOR_IN_THOUSAND = 5.0


def price_layout(draft: DraftedNetwork) -> float:
    odd, uneven = measure_layout(draft)
    return 1000.0 * odd / count_quads(draft.network) / ODD_IN_THOUSAND + uneven / UNEVEN


#: So many numbers of a rank say what is wrong.
WRONG = 4


@dataclass(frozen=True, slots=True, eq=False)
class ProposedDraft:
    """A draft that is made: found: its network, with counts and fills, and where these lie.
    report: of its mesh. flaws: what is wrong with that, in words, with places. rank: the less, the
    better. poor: (n, 3) the middles of poor quads, the worst first. notes: what the user should
    know of how it came, in words."""

    found: FilledNetwork
    report: Report
    flaws: tuple[str, ...]
    rank: tuple[float, ...]
    poor: Points
    notes: tuple[str, ...] = ()

    @classmethod
    def of(
        cls, found: FilledNetwork, judge: DraftJudge, notes: tuple[str, ...] = ()
    ) -> ProposedDraft:
        """Of quads that are fitted."""
        made = judge.report(found)
        off = max(made.to_ground, made.from_ground)
        wrong = (made.unfilled, made.tangled, made.flipped, max(off - judge.most_off, 0.0))
        rank = (*wrong, sum(made.irregular.values()), off)
        flaws = judge.list_flaws(found, made)
        return cls(found, made, flaws, rank, judge.find_poor(found), notes)

    @property
    def network(self) -> Network:
        """With counts and fills."""
        return self.found.network

    @property
    def sound(self) -> bool:
        """Is nothing wrong with it?"""
        return not any(self.rank[:WRONG])

    @property
    def price(self) -> float:
        """The less, the better shaped it is: irregular vertices and poor quads in a thousand."""
        odd = sum(self.report.irregular.values()) / ODD_IN_THOUSAND
        return 1000.0 * (odd + len(self.poor) / POOR_IN_THOUSAND) / self.report.quads


@dataclass(frozen=True, slots=True, eq=False)
class RegularParts:
    """The parts of a surface on which a field has no singularity, as on a torus.

    Elsewhere singularities cut as finely as the shape asks for. at: (v,) of the field's mesh, is
    this vertex on such a part? of_triangle: (t,) the part of each triangle of the ground.
    longest: by part, how long a region's border may be; infinite where there are singularities.
    """

    at: NDArray[np.bool_]
    of_triangle: NDArray[np.signedinteger[Any]]
    longest: NDArray[np.float64]

    @classmethod
    def of(cls, field: CrossField, ground: Ground) -> RegularParts:
        parts = GroundParts.of(ground)
        part = parts.part[ground.nearest(field.mesh.vertices).triangles]
        longest = np.empty(parts.parts)
        for k in range(parts.parts):
            corners = ground.vertices[ground.triangles[parts.part == k]].reshape(-1, 3)
            longest[k] = LONGEST_LOOP * np.linalg.norm(np.ptp(corners, axis=0))
        longest[part[field.singular]] = np.inf
        return cls(np.isfinite(longest[part]), parts.part, longest)


def _has_long_patch(network: Network, ground: Ground, regular: RegularParts) -> bool:
    if not regular.at.any():
        return False
    for patch in network.patches.values():
        chains = [network.chains[half >> 1] for half in patch.loop]
        at = ground.nearest(np.concatenate([chain.points for chain in chains])).triangles
        part = np.bincount(regular.of_triangle[at]).argmax()
        if sum(chain.length for chain in chains) > regular.longest[part]:
            return True
    return False


def propose_draft(
    task: DraftTask,
    enough: int = TRIED,
    tell: Callable[[float], None] | None = None,
) -> ProposedDraft:
    """Propose the best draft of all settings.

    enough: so many settings are laid out; the cheapest layout (:func:`price_layout`) is filled and
    fitted, the next ones only if that is not sound, and other settings if none is. tell: is called
    with the share of settings that are done.
    Raises RefusedError, with the place, for a surface that no field lies on, for faces that were
    given, and where no setting comes to a layout; RoundRegionError where the same region has too
    few corners by two settings.
    """
    network, mesh, notes = _prepare(task)
    judge = DraftJudge(task.ground, task.half, task.goal.allow_off(task.ground))
    samples = sample_both_sides(task.ground, task.half, _find_finest(task))
    best: ProposedDraft | None = None
    why: list[str] = []
    for batch in _lay_out(task, network, mesh, enough, why, tell):
        for one in batch:
            if best is not None and task.budget.spent:
                return best
            made = _make_draft(task, one, network, samples, judge, notes)
            if best is None or made.rank < best.rank:
                best = made
            if made.sound or judge.is_lopsided(made.found, made.report):
                return best
    if best is None:
        raise RefusedError(f"no draft: {why[0]}")
    return best


def _find_finest(task: DraftTask) -> float:
    """Return the edge length of the quads, where lines are laid out for fewer."""
    edge, quad = task.sizes.edge, task.goal.quad
    return edge if quad is None else min(quad, edge)


def _lay_out(
    task: DraftTask,
    network: Network,
    mesh: FieldMesh,
    enough: int,
    why: list[str],
    tell: Callable[[float], None] | None,
) -> Iterator[list[DraftedNetwork]]:
    """Lay out the settings whose fields differ: first some, by price, and then one by one.

    enough: how many at first. why: to this is added why a setting comes to nothing.
    """
    sizes, budget, wanted = task.sizes, task.budget, task.goal.count_quads(task.ground)
    # With the same pairs cancelled a field is the same.
    done: set[tuple[bytes, float, float]] = set()
    solvers: dict[float, FieldSolver] = {}
    batch: list[DraftedNetwork] = []
    laid = False
    for tried, setting in enumerate(SETTINGS, 1):
        if tell is not None:
            tell((tried - 1) / len(SETTINGS))
        if setting.alignment not in solvers:
            solvers[setting.alignment] = FieldSolver(mesh, setting.alignment)
        field = solvers[setting.alignment].solve(setting.merging * sizes.edge)
        key = field.index.tobytes(), setting.alignment, setting.finer
        if key not in done:
            done.add(key)
            try:
                batch.append(
                    draft_network(network, task.ground, sizes, setting, field, budget, wanted)
                )
                laid = True
            except RefusedError as error:
                budget.spend(len(mesh.triangles) / TRIANGLES_A_QUAD)
                if isinstance(error, RoundRegionError) and not laid and str(error) in why:
                    # By two settings the same region: it is in what is drawn.
                    raise RoundRegionError(f"no draft: {error}") from error
                why.append(str(error))
        if batch and (tried >= enough or budget.spent):
            yield sorted(batch, key=price_layout)
            batch = []
        if budget.spent:
            break
    if batch:
        yield sorted(batch, key=price_layout)


def _make_draft(
    task: DraftTask,
    one: DraftedNetwork,
    network: Network,
    samples: Points,
    judge: DraftJudge,
    notes: tuple[str, ...],
) -> ProposedDraft:
    """Fill a layout and fit its quads to samples; network: what of it is given."""
    ground, sizes = task.ground, task.sizes
    if (wanted := task.goal.count_quads(ground)) is not None:
        one = improve_counts(one, wanted)
    found = fill_network(one.network, ground, task.source, sizes.edge, PlacedCache())
    found = _fill_rest(found, ground, task.source)
    fitted = replace(sizes, edge=_find_finest(task))
    found = fit_quads(found, ground, samples, fitted, one.laid, network.patches)
    made = ProposedDraft.of(found, judge, notes)
    if not made.sound:
        task.budget.spend(made.report.quads / (1 if task.half is None else 2))
    return made


def _fill_rest(found: FilledNetwork, ground: Ground, source: PatternSource) -> FilledNetwork:
    """Fill patches that are refused quads where these are placed one by one: all are fitted."""
    network, placed = found.network, dict(found.placed)
    for number in sorted(network.patches.keys() - placed.keys()):
        if has_suitable_fill(network, network.patches[number]):
            # What lies within it is not joined to it.
            continue
        try:
            network, placed[number] = fill_between(network, ground, source, number)
        except RefusedError:
            # It has no fill at all, which is a flaw of the draft.
            continue
    return replace(found, network=network, placed=placed)


def _prepare(task: DraftTask) -> tuple[Network, FieldMesh, tuple[str, ...]]:
    """Return the network with creases, its field's mesh, cut open along all curves, and notes."""
    network, ground, sizes = task.network, task.ground, task.sizes
    check_ground(ground)
    faces = list_kept_faces(network)
    if faces:
        at = network.nodes[network.origin(faces[0][0])].point
        raise RefusedError(
            f"faces that were given stay as they are, the first at {format_place(at)}: a draft "
            "goes round none; go on by hand"
        )
    fine = REMESHED * sizes.edge
    drawn = [c for c, chain in network.chains.items() if not chain.marked]
    creases = None
    if task.goal.sharp is not None:
        creases = add_creases(network, ground, sizes, task.goal.sharp, closed=task.goal.closed)
    notes: tuple[str, ...] = ()
    if creases is None:
        even = Ground.of(*remesh_parts(ground, fine))
        crowded = np.flatnonzero(np.diff(even.topology.side_start) > 2)
        if len(crowded):
            raise RefusedError(
                "no draft: triangles of even edges would lie on top of each other at "
                f"{format_place(even.topology.middles[crowded[0]])}: the surface is folded there, "
                "or has needles; mend it, or draw by hand"
            )
        mesh = FieldMesh.of(even)
        _refuse_laces(mesh, sizes.edge, ground.diagonal)
    else:
        network = creases.network
        _refuse_laces(FieldMesh.of(ground), sizes.edge, ground.diagonal)
        mesh = cut_along_creases(network, ground, creases.half, fine)
        if len(creases.clipped):
            where = count_places("a place", "places", creases.clipped)
            notes = (f"creases stop short of drawn curves in {where}",)
    if drawn:
        mesh = cut_along_curves(network, mesh, fine, drawn)
    return network, mesh, notes


#: A loop around a handle, or through one, is at least so many target edges long: three quads close
#: a tube, and it has no shape with fewer.
LEAST_AROUND = 3.0

#: Edges that close around a thin handle are shorter by this part: on a finer mesh the loop is a
#: little shorter.
CLOSING = 0.9

#: Edges of a draft are no shorter than this part of the diagonal: they give a hundred thousand
#: quads.
LEAST_EDGE = 0.004


class LaceError(RefusedError):
    """A handle of the surface is too thin; edge: a length with which it is not, perhaps shorter
    than a draft may have."""

    def __init__(self, message: str, edge: float) -> None:
        super().__init__(message)
        self.edge = edge


def _refuse_laces(mesh: FieldMesh, edge: float, diagonal: float) -> None:
    """LaceError, with the place, for a surface with a handle that no ring of quads of this edge
    goes around, or through: a lace, or the slit below it."""
    found = find_shortest_handle(mesh)
    if found is not None and found.length < LEAST_AROUND * edge:
        finer = round_down(CLOSING * found.length / LEAST_AROUND)
        ways = ["close the opening if it is not meant", "draw by hand"]
        if finer >= LEAST_EDGE * diagonal:
            ways.insert(0, f"take an edge of {finer:g}")
        raise LaceError(
            f"no draft: a handle of the surface, or the opening through it, is {found.length:.3g} "
            f"around at {format_place(found.middle)}, and an edge is {edge:.3g}: no ring of quads "
            f"closes there; {', '.join(ways[:-1])}, or {ways[-1]}",
            finer,
        )


def check_ground(ground: Ground) -> None:
    """Raise RefusedError, with the place, for a surface on which no field can lie."""
    topology, triangles = ground.topology, ground.triangles
    uses = np.diff(topology.side_start)
    shared = np.flatnonzero(uses > 2)
    if len(shared):
        raise RefusedError(
            # How many is not told: the ground may be a finer one than the surface that was given.
            "edges have more than two triangles, the first at "
            f"{format_place(topology.middles[shared[0]])}: part the sheets that touch there"
        )
    fans = np.bincount(triangles.ravel(), minlength=len(ground.vertices))
    mesh = FieldMesh.of(ground)
    for vertex in np.flatnonzero(fans).tolist():
        if len(mesh.list_ring(vertex)) != fans[vertex]:
            raise RefusedError(
                "parts of the surface touch in one vertex at "
                f"{format_place(ground.vertices[vertex])}: part them, or join them along an edge"
            )


def _find_seed(field: CrossField, regular: RegularParts, seeds: list[int]) -> int:
    """The inner regular vertex furthest from singularities, borders and other seeds, of parts that
    have no singularity where there are any."""
    from scipy.sparse.csgraph import dijkstra

    mesh = field.mesh
    graph = mesh.edge_graph
    sources = [*field.singular.tolist(), *seeds, *np.flatnonzero(mesh.on_border).tolist()]
    # What has no triangle is on no part, and infinitely far, too.
    inner = ~mesh.on_border & (field.index == 0) & (mesh.leaving >= 0)
    if (inner & regular.at).any():
        inner &= regular.at
    if not sources:
        return int(np.flatnonzero(inner)[0])
    far = dijkstra(graph, indices=sources, min_only=True)
    # Parts that have none of these are infinitely far.
    far[~inner] = -1.0
    return int(far.argmax())


def _seed_rings(field: CrossField, seeds: list[int]) -> list[int]:
    """A vertex of each part between drawn curves that no line begins in: of its border, or within
    it where it has none."""
    mesh = field.mesh
    parts = GroundParts.of(mesh.ground)
    of_vertex = np.full(len(mesh.vertices), -1)
    of_vertex[mesh.triangles.ravel()] = np.repeat(parts.part, 3)
    # Of a ring few lines would leave patches that go around it, which have no shape.
    lines = np.zeros(parts.parts)
    for vertex in (*field.singular.tolist(), *seeds):
        all_of = (1 if mesh.on_border[vertex] else 4) - int(field.index[vertex])
        lines[of_vertex[vertex]] += max(all_of, 0)
    corners = np.bincount(
        of_vertex[np.flatnonzero(mesh.on_border & (field.index == 1))], minlength=parts.parts
    )
    rims = np.bincount(
        [of_vertex[loop[0]] for loop in _list_rims(mesh)] or [0], minlength=parts.parts
    )
    begun = (lines >= LEAST_ACROSS) | ((rims < 2) & (lines + corners > 0))
    found: list[int] = []
    for part in np.flatnonzero(~begun).tolist():
        own = of_vertex == part
        rim = np.flatnonzero(own & mesh.on_border)
        if len(rim):
            found += [v for v in _spread_along_rim(mesh, own) if field.index[v] == 0]
    return found


#: Lines across a ring that has no corner: a patch goes no further around it than a quarter.
ACROSS_RING = 4

#: A ring with so many lines needs no more.
LEAST_ACROSS = 3


def _seed_rims_at(field: CrossField, at: Points, near: float, seeds: list[int]) -> list[int]:
    """Vertices that divide borders at a point evenly, of those that have no seed yet."""
    mesh = field.mesh
    found: list[int] = []
    for loop in _list_rims(mesh):
        away = np.linalg.norm(mesh.vertices[loop] - at, axis=1).min()
        if away <= near and not set(loop) & set(seeds):
            found += [v for v in _divide_rim(mesh, loop) if field.index[v] == 0]
    return found


def _spread_along_rim(mesh: FieldMesh, own: NDArray[np.bool_]) -> list[int]:
    """Vertices that divide the longest border of a part evenly."""
    loops = [loop for loop in _list_rims(mesh) if own[loop[0]]]
    return _divide_rim(mesh, max(loops, key=lambda one: float(_measure_rim(mesh, one).sum())))


def _list_rims(mesh: FieldMesh) -> list[list[int]]:
    """The vertices around every border."""
    border = mesh.ground.topology.border
    tail = mesh.triangles.ravel()[border]
    head = mesh.triangles[border // 3, (border % 3 + 1) % 3]
    ahead = {int(a): int(b) for a, b in zip(tail, head, strict=True)}
    loops: list[list[int]] = []
    left = set(ahead)
    while left:
        loop = [min(left)]
        left.discard(loop[0])
        while (after := ahead.get(loop[-1], -1)) in left:
            loop.append(after)
            left.discard(after)
        loops.append(loop)
    return loops


def _measure_rim(mesh: FieldMesh, loop: list[int]) -> NDArray[np.float64]:
    return np.linalg.norm(np.diff(mesh.vertices[[*loop, loop[0]]], axis=0), axis=1)


def _divide_rim(mesh: FieldMesh, loop: list[int]) -> list[int]:
    along = np.cumsum(_measure_rim(mesh, loop))
    wanted = along[-1] * np.arange(ACROSS_RING) / ACROSS_RING
    found = dict.fromkeys(np.searchsorted(along, wanted).tolist())
    return [loop[k] for k in found if k < len(loop)]


def _find_tips(network: Network, field: CrossField, near: float) -> list[int]:
    """The vertices at open ends of drawn curves that are regular: there a line goes on straight, as
    one leaves every regular vertex of a border, and only there it is needed."""
    mesh = field.mesh
    rim = np.flatnonzero(mesh.on_border)
    found: list[int] = []
    for node in network.nodes.values():
        if node.open and len(rim):
            away = np.linalg.norm(mesh.vertices[rim] - node.point, axis=1)
            vertex = int(rim[away.argmin()])
            if away.min() <= near and field.index[vertex] == 0:
                found.append(vertex)
    return found


def _lay_field(
    network: Network,
    ground: Ground,
    sizes: Sizes,
    field: CrossField,
    walls: Walls,
    seeds: list[int],
    budget: DraftBudget,
) -> tuple[Network, frozenset[int]] | None:
    """The network of a field's separatrices, and which of its chains are theirs; None if a line
    runs on and on. budget: is spent on the lines."""
    mesh = field.mesh
    starts = start_at_vertices(field, [*field.singular.tolist(), *seeds])
    arcs = find_arcs(field, starts, sizes.edge)
    laid = [LineSegments.none()]
    for k, arc in enumerate(arcs):
        laid.append(cut_segments(field, arc.points, arc.triangles, k))
    used = {end for arc in arcs for end in (arc.begin, arc.end)}
    free = np.array([k for k in range(len(starts)) if k not in used], np.intp)
    left = starts[free]
    longest = LONGEST_TRACE * mesh.ground.diagonal
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
    builder = NetworkBuilder(network, ground, sizes, lines, JOINING * sizes.edge, corners)
    made = builder.build()
    laid_here = frozenset(builder.laid & made.chains.keys())
    own = {c: replace(made.chains[c], laid=True) for c in sorted(laid_here)}
    return replace(made, chains={**made.chains, **own}), laid_here


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
