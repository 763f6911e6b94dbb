"""A first draft of a network: separatrices of a cross field, laid, counted, the best of settings.

:func:`propose_draft` is all of it; :class:`DraftSetting` is what differs between tries.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.draft.assembly import RoundRegionError
from patterndb_sketch.retopo.draft.checking import check_surface, refuse_laces
from patterndb_sketch.retopo.draft.creases import add_creases
from patterndb_sketch.retopo.draft.crossfield import FieldSolver
from patterndb_sketch.retopo.draft.drafted import (
    ODD_IN_THOUSAND,
    DraftedNetwork,
    DraftSetting,
    improve_counts,
    price_layout,
)
from patterndb_sketch.retopo.draft.fitting import fit_quads, sample_both_sides
from patterndb_sketch.retopo.draft.frames import TangentFrames
from patterndb_sketch.retopo.draft.imprint import cut_along_creases, cut_along_curves
from patterndb_sketch.retopo.draft.judging import DraftJudge
from patterndb_sketch.retopo.draft.layout import draft_network
from patterndb_sketch.retopo.draft.remesh import remesh_parts
from patterndb_sketch.retopo.draft.task import REMESHED, DraftTask
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling import (
    FilledNetwork,
    PlacedCache,
    fill_between,
    fill_network,
    has_suitable_fill,
)
from patterndb_sketch.retopo.filling.report import Report
from patterndb_sketch.retopo.network import Network
from patterndb_sketch.retopo.network.invariants import list_kept_faces
from patterndb_sketch.retopo.wording import count_places, format_place
from query.engine import PatternSource

#: Finding a field on so many triangles takes as long as making a quad does.
TRIANGLES_A_QUAD = 40.0

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


#: So many poor quads in a thousand weigh as much as ODD_IN_THOUSAND irregular vertices.
POOR_IN_THOUSAND = 5.0

#: So many numbers of a rank say what is wrong.
WRONG = 4

#: A draft that is nearly sound has no more flipped quads than this share of its edges along
#: creases, and is off the surface by no more than this part of the diagonal above what is allowed.
#: A machined body without its creases is worth less.
FEW_FLIPPED, FURTHER_OFF = 0.05, 0.05


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
        off = max(made.to_surface, made.from_surface)
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
    def nearly_sound(self) -> bool:
        """Is little wrong for its creases: few quads are flipped, or it is a little too far off?"""
        unfilled, tangled, flipped, off = self.rank[:WRONG]
        chains = self.network.chains.values()
        along = sum(chain.count for chain in chains if not (chain.auto or chain.marked))
        # Of a half, flipped quads of the image count, too.
        along *= self.report.quads / max(sum(len(p.quads) for p in self.found.placed.values()), 1)
        if not along or unfilled or tangled:
            return False
        return flipped <= FEW_FLIPPED * along and off <= FURTHER_OFF

    @property
    def price(self) -> float:
        """The less, the better shaped it is: irregular vertices and poor quads in a thousand."""
        odd = sum(self.report.irregular.values()) / ODD_IN_THOUSAND
        return 1000.0 * (odd + len(self.poor) / POOR_IN_THOUSAND) / self.report.quads


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
    judge = DraftJudge(task.surface, task.half, task.goal.allow_off(task.surface))
    samples = sample_both_sides(task.surface, task.half, _find_finest(task))
    best: ProposedDraft | None = None
    why: list[str] = []
    for batch in _lay_out(task, network, mesh, enough, why, tell):
        for one in batch:
            if best is not None and task.budget.spent:
                return best
            made = _make_draft(task, one, samples, judge, notes)
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
    mesh: TangentFrames,
    enough: int,
    why: list[str],
    tell: Callable[[float], None] | None,
) -> Iterator[list[DraftedNetwork]]:
    """Lay out the settings whose fields differ: first some, by price, and then one by one.

    enough: how many at first. why: to this is added why a setting comes to nothing.
    """
    sizes, budget, wanted = task.sizes, task.budget, task.goal.count_quads(task.surface)
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
                    draft_network(network, task.surface, sizes, setting, field, budget, wanted)
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
    samples: Points,
    judge: DraftJudge,
    notes: tuple[str, ...],
) -> ProposedDraft:
    """Fill a layout and fit its quads to samples."""
    surface, sizes = task.surface, task.sizes
    if (wanted := task.goal.count_quads(surface)) is not None:
        one = improve_counts(one, wanted)
    found = fill_network(one.network, surface, task.source, sizes.edge, PlacedCache())
    found = _fill_rest(found, surface, task.source)
    fitted = replace(sizes, edge=_find_finest(task))
    found = fit_quads(found, surface, samples, fitted, one.laid, one.kept)
    made = ProposedDraft.of(found, judge, notes)
    if not made.sound:
        task.budget.spend(made.report.quads / (1 if task.half is None else 2))
    return made


def _fill_rest(found: FilledNetwork, surface: Surface, source: PatternSource) -> FilledNetwork:
    """Fill patches that are refused quads where these are placed one by one: all are fitted."""
    network, placed = found.network, dict(found.placed)
    for number in sorted(network.patches.keys() - placed.keys()):
        if has_suitable_fill(network, network.patches[number]):
            # What lies within it is not joined to it.
            continue
        try:
            network, placed[number] = fill_between(network, surface, source, number)
        except RefusedError:
            # It has no fill at all, which is a flaw of the draft.
            continue
    return replace(found, network=network, placed=placed)


def _prepare(task: DraftTask) -> tuple[Network, TangentFrames, tuple[str, ...]]:
    """Return the network with creases, its field's mesh, cut open along all curves, and notes."""
    network, surface, sizes = task.network, task.surface, task.sizes
    check_surface(surface)
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
        creases = add_creases(network, surface, sizes, task.goal.sharp, closed=task.goal.closed)
    notes: tuple[str, ...] = ()
    if creases is None:
        even = Surface.from_arrays(*remesh_parts(surface, fine)).orient()
        crowded = np.flatnonzero(np.diff(even.adjacency.side_start) > 2)
        if len(crowded):
            raise RefusedError(
                "no draft: triangles of even edges would lie on top of each other at "
                f"{format_place(even.adjacency.middles[crowded[0]])}: the surface is folded there, "
                "or has needles; mend it, or draw by hand"
            )
        mesh = TangentFrames.of(even)
        refuse_laces(mesh, sizes.edge, surface.diagonal)
    else:
        network = creases.network
        refuse_laces(TangentFrames.of(surface), sizes.edge, surface.diagonal)
        mesh = cut_along_creases(network, surface, creases.half, fine)
        if len(creases.clipped):
            where = count_places("a place", "places", creases.clipped)
            notes = (f"creases stop short of drawn curves in {where}",)
    if drawn:
        mesh = cut_along_curves(network, mesh, fine, drawn)
    return network, mesh, notes
