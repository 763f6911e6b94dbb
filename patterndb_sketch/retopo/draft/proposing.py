"""Propose a draft of one part: the best of several fields, edge lengths and sets of creases.

The tries nest, the outer ones first: with all creases, with closed ones, without
(:func:`propose_by_creases`); with edges of several lengths (:func:`propose_by_edges`); with several
fields, laid out and counted, of which the cheapest is filled and fitted (:func:`propose_draft`).
Each ends with the first draft that is sound, or where the work allowed for it is done.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.draft.assembly import RoundRegionError
from patterndb_sketch.retopo.draft.creases import (
    add_creases,
    drop_open_chains,
    find_border,
    find_creases,
    find_sharp_edges,
)
from patterndb_sketch.retopo.draft.crossfield import FieldSolver
from patterndb_sketch.retopo.draft.fieldmesh import (
    cut_along_creases,
    cut_along_curves,
    remesh_parts,
)
from patterndb_sketch.retopo.draft.fitting import fit_quads, sample_both_sides
from patterndb_sketch.retopo.draft.frames import TangentFrames
from patterndb_sketch.retopo.draft.judging import Draft, DraftJudge
from patterndb_sketch.retopo.draft.layout import (
    CountedLayout,
    improve_counts,
    lay_out,
    price_layout,
)
from patterndb_sketch.retopo.draft.manifold import (
    ThinHandleError,
    check_surface,
    refuse_thin_handles,
)
from patterndb_sketch.retopo.draft.settings import SETTINGS
from patterndb_sketch.retopo.draft.task import DraftBudget, DraftGoal, DraftTask
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling import (
    FilledNetwork,
    PlacedCache,
    fill_between,
    fill_network,
    has_suitable_fill,
)
from patterndb_sketch.retopo.network import Network
from patterndb_sketch.retopo.network.invariants import list_kept_faces
from patterndb_sketch.retopo.wording import count_places, format_place
from query.engine import PatternSource


def propose_by_creases(
    task: DraftTask,
    edges: Sequence[float],
    share: float,
    progress: Callable[[float], None] | None = None,
) -> Draft:
    """Return the first draft that is sound with as many creases as go, or the best; see
    :func:`propose_by_edges`."""
    notes: list[str] = []
    tried: list[Draft] = []
    for goal in _list_goals(task, share):
        budget = DraftBudget(min(SETTINGS.work_on_creases, task.budget.left))
        try:
            one = propose_by_edges(replace(task, goal=goal, budget=budget), edges, share, progress)
        except RefusedError as error:
            notes.append(f"sharp edges are not all kept: {error}")
            continue
        one = replace(one, notes=(*notes, *one.notes), creased=not notes)
        if one.sound or (one.nearly_sound and not goal.strict):
            return one
        tried.append(one)
        notes.append(f"sharp edges are not all kept: there would be {'; '.join(one.flaws)}")
    without = replace(task, goal=replace(task.goal, sharp=None))
    try:
        bare = propose_by_edges(without, edges, share, progress)
    except RefusedError:
        if not tried:
            raise
        return min(tried, key=lambda one: one.rank)
    tried.append(replace(bare, notes=(*notes, *bare.notes), creased=not notes))
    return tried[-1] if bare.sound else min(tried, key=lambda one: one.rank)


def _list_goals(task: DraftTask, share: float) -> list[DraftGoal]:
    """List the goals with creases, as far as they differ on the task's surface.

    share: of the part in the whole surface's area; on small ones edges may become finer."""
    goal = task.goal
    if goal.sharp is None:
        return []
    if share <= SETTINGS.small_part:
        edges = find_sharp_edges(
            task.surface, SETTINGS.small_part_edges[-1] * task.sizes.edge, goal.sharp
        )
    else:
        edges = find_creases(task.surface, task.sizes.edge, goal.sharp)
    closed = drop_open_chains(edges, find_border(task.surface))
    goals = [goal] if edges else []
    return [*goals, replace(goal, closed=True)] if closed and closed != edges else goals


def propose_by_edges(
    task: DraftTask,
    edges: Sequence[float],
    share: float,
    progress: Callable[[float], None] | None = None,
) -> Draft:
    """Return the first draft that is sound, with edges of several lengths, or the best.

    share: of the part in the whole surface's area."""
    sizes, diagonal = task.sizes, task.surface.diagonal
    best: Draft | None = None
    why: RefusedError | None = None
    bare = all(chain.marked for chain in task.network.chains.values())
    left, enough = list(edges), SETTINGS.tried
    if share <= SETTINGS.small_part:
        left += [
            times
            for times in SETTINGS.small_part_edges
            if times * sizes.edge >= SETTINGS.least_edge * diagonal
        ]
        enough = 1
    while left and not (task.budget.spent and (best or why)):
        times = left.pop(0)
        tried = replace(sizes, edge=times * sizes.edge)
        try:
            made = propose_draft(replace(task, sizes=tried), enough, progress)
        except RefusedError as error:
            if why is None and isinstance(error, ThinHandleError):
                finer = error.edge / sizes.edge
                if share <= SETTINGS.most_quads * finer**2:
                    left = [finer]
            why = error if why is None else why
            if best is None and isinstance(error, RoundRegionError) and not bare:
                # Around what is drawn; other edges have it, too.
                raise
            continue
        if best is None or made.rank < best.rank:
            notes = made.notes
            if times != edges[0]:
                flaws = str(why) if best is None else f"there would be {'; '.join(best.flaws)}"
                notes = (f"edges are {times:.2g} times as long as asked for: else {flaws}", *notes)
            best = replace(made, notes=notes)
        if made.sound:
            break
    if best is None:
        assert why is not None
        raise why
    return best


def propose_draft(
    task: DraftTask,
    enough: int = SETTINGS.tried,
    progress: Callable[[float], None] | None = None,
) -> Draft:
    """Propose the best draft of all settings.

    enough: so many settings are laid out; the cheapest layout (:func:`price_layout`) is filled and
    fitted, the next ones only if that is not sound, and other settings if none is. progress: is
    called with the share of settings that are done.
    Raises RefusedError, with the place, for a surface that no field lies on, for faces that were
    given, and where no setting comes to a layout; RoundRegionError where the same region has too
    few corners by two settings.
    """
    network, mesh, notes = _prepare(task)
    judge = DraftJudge(task.surface, task.half, task.goal.allow_off(task.surface))
    samples = sample_both_sides(task.surface, task.half, _find_finest(task))
    best: Draft | None = None
    why: list[str] = []
    for batch in _lay_out(task, network, mesh, enough, why, progress):
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
    progress: Callable[[float], None] | None,
) -> Iterator[list[CountedLayout]]:
    """Lay out the settings whose fields differ: first some, by price, and then one by one.

    enough: how many at first. why: to this is added why a setting comes to nothing.
    """
    sizes, budget, wanted = task.sizes, task.budget, task.goal.count_quads(task.surface)
    # With the same pairs cancelled a field is the same.
    done: set[tuple[bytes, float, float]] = set()
    solvers: dict[float, FieldSolver] = {}
    batch: list[CountedLayout] = []
    laid = False
    for tried, setting in enumerate(SETTINGS.fields, 1):
        if progress is not None:
            progress((tried - 1) / len(SETTINGS.fields))
        if setting.alignment not in solvers:
            solvers[setting.alignment] = FieldSolver(mesh, setting.alignment)
        field = solvers[setting.alignment].solve(setting.merging * sizes.edge)
        key = field.index.tobytes(), setting.alignment, setting.finer
        if key not in done:
            done.add(key)
            try:
                batch.append(lay_out(network, task.surface, sizes, setting, field, budget, wanted))
                laid = True
            except RefusedError as error:
                budget.spend(len(mesh.triangles) / SETTINGS.triangles_per_quad)
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
    one: CountedLayout,
    samples: Points,
    judge: DraftJudge,
    notes: tuple[str, ...],
) -> Draft:
    """Fill a layout and fit its quads to samples."""
    surface, sizes = task.surface, task.sizes
    if (wanted := task.goal.count_quads(surface)) is not None:
        one = improve_counts(one, wanted)
    found = fill_network(one.network, surface, task.source, sizes.edge, PlacedCache())
    found = _fill_rest(found, surface, task.source)
    fitted = replace(sizes, edge=_find_finest(task))
    found = fit_quads(found, surface, samples, fitted, one.laid, one.kept)
    made = Draft.of(found, judge, notes)
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
    fine = SETTINGS.field_edge * sizes.edge
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
        refuse_thin_handles(mesh, sizes.edge, surface.diagonal)
    else:
        network = creases.network
        refuse_thin_handles(TangentFrames.of(surface), sizes.edge, surface.diagonal)
        mesh = cut_along_creases(network, surface, creases.half, fine)
        if len(creases.clipped):
            where = count_places("a place", "places", creases.clipped)
            notes = (f"creases stop short of drawn curves in {where}",)
    if drawn:
        mesh = cut_along_curves(network, mesh, fine, drawn)
    return network, mesh, notes
