"""The tool that proposes a first network for a whole surface."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.arguments import list_arguments
from patterndb_sketch.retopo.draft.creases import AUTOMATIC, SharpRule
from patterndb_sketch.retopo.draft.judging import Draft, DraftJudge
from patterndb_sketch.retopo.draft.manifold import part_touching
from patterndb_sketch.retopo.draft.parts import fill_as_placed, propose_by_parts
from patterndb_sketch.retopo.draft.settings import SETTINGS
from patterndb_sketch.retopo.draft.task import DraftBudget, DraftGoal, DraftRequest, DraftTask
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network.faces import SurfaceParts
from patterndb_sketch.retopo.network.structure import SYMMETRY
from patterndb_sketch.retopo.symmetry import begin_symmetry, cut_half, propose_plane
from patterndb_sketch.retopo.symmetry.half import Half
from patterndb_sketch.retopo.tool import Control, Result, State, Tool, ToolWork
from patterndb_sketch.retopo.wording import count_places, format_place, round_down, round_up


@dataclass(frozen=True, slots=True, eq=False)
class _MadeDraft:
    """A draft, and the state without its network."""

    made: Draft
    state: State


def _act(work: ToolWork, a: dict[str, Any]) -> Result:
    asked = DraftRequest(**a)
    state, goal = _read_goal(work, asked)
    parted = part_touching(work.surface)
    surface = parted.surface
    notes: list[str] = []
    if len(parted.touching):
        places = work.surface.vertices[parted.touching]
        said = count_places("a vertex", "vertices", places)
        notes.append(f"parts of the surface touch in {said}: drafted as if they did not")
    drafting = _Drafting(work, state, surface, asked)
    best = drafting.draft(goal)
    made = best.made
    if not made.sound and (asked.strict or made.report.tangled or not made.report.quads):
        raise RefusedError(
            f"no draft: there would be {'; '.join(made.flaws)}, by all that was tried; "
            "take another edge, mend the surface there, or draw by hand"
        )
    if surface is not work.surface and made.sound:
        best = drafting.fill_touching(best, goal)
    now = replace(best.state, network=best.made.network)
    if goal.quad is not None:
        now = replace(now, sizes=replace(now.sizes, edge=goal.quad))
    return Result(now, (*notes, *best.made.notes, *_describe(best, asked.quads)))


def _read_goal(work: ToolWork, asked: DraftRequest) -> tuple[State, DraftGoal]:
    """Read what is wanted; raises RefusedError for edges out of proportion."""
    state, surface = work.state, work.surface
    low, high = SETTINGS.least_edge * surface.diagonal, SETTINGS.most_edge * surface.diagonal
    quad: float | None = None
    edge = state.sizes.edge if asked.edge is None else asked.edge
    if asked.quads is not None:
        area = float(surface.areas.sum())
        quad = float(np.sqrt(area / asked.quads))
        edge = min(max(quad, float(np.sqrt(area / SETTINGS.most_laid)), low), high)
    if not low <= edge <= high:
        raise RefusedError(
            f"an edge of {edge:g} is out of proportion for a draft of this surface; "
            f"give edge from {round_up(low):g} to {round_down(high):g}"
        )
    state = replace(state, sizes=replace(state.sizes, edge=edge))
    sharp = asked.sharp
    if isinstance(sharp, str):
        rule = AUTOMATIC if sharp == "auto" else None
    else:
        rule = SharpRule.above(sharp)
    return state, DraftGoal(quad, rule, strict=asked.strict)


@dataclass(frozen=True, slots=True, eq=False)
class _Drafting:
    """Drafts of one surface with different goals."""

    work: ToolWork
    state: State
    surface: Surface
    asked: DraftRequest

    def draft(self, goal: DraftGoal) -> _MadeDraft:
        """Draft one half where the surface is symmetric, bare and comes out well so; else all."""
        halves, why = self._draft_half(goal)
        if halves is None:
            whole = self._draft_all(goal)
            return whole if why is None else _give_up_halves(whole, why)
        made = halves.made
        poor = len(made.poor) > SETTINGS.poor_half * made.report.quads / 1000.0
        sound = made.sound or (made.nearly_sound and not goal.strict)
        if sound and made.creased and not poor:
            return halves
        try:
            whole = self._draft_all(goal)
        except RefusedError:
            return halves
        if not _is_better(whole.made, made, goal):
            return halves
        if not made.sound:
            lost = f"there would be {'; '.join(made.flaws)}"
        elif made.creased:
            lost = "there would be " + count_places("a poor quad", "poor quads", made.poor)
        else:
            lost = "sharp edges would be lost"
        return _give_up_halves(whole, lost)

    def _draft_all(self, goal: DraftGoal) -> _MadeDraft:
        """Draft all that is worked on."""
        work, diagonal = self.work, self.work.surface.diagonal
        low, high = SETTINGS.least_edge * diagonal, SETTINGS.most_edge * diagonal
        edges = tuple(
            times for times in SETTINGS.edges if low <= times * self.state.sizes.edge <= high
        )
        task = DraftTask(work.network, self.surface, self.state.sizes, work.source, work.half, goal)
        return _MadeDraft(propose_by_parts(task, edges, strict=self.asked.strict), self.state)

    def _draft_half(self, goal: DraftGoal) -> tuple[_MadeDraft | None, str | None]:
        """Draft one half; None where the surface has none, and where that is refused, with why."""
        work, state, surface = self.work, self.state, self.surface
        drawn = any(not chain.marked for chain in work.network.chains.values())
        may_halve = self.asked.symmetry and not drawn and state.plane is None
        found = propose_plane(surface) if may_halve else None
        if found is None or not found.symmetric:
            return None, None
        try:
            half = cut_half(surface, found.plane)
            if half.in_plane:
                at = format_place(_find_in_plane(surface, half))
                raise RefusedError(f"{half.in_plane} triangles lie in the plane, one at {at}")
            seam = begin_symmetry(work.network, half, state.sizes.sampling).network
            # Where a seam alone closes a loop it is a patch: of a draft its lines are to go there.
            seam = replace(seam, patches={})
            if not any(SYMMETRY in chain.marks for chain in seam.chains.values()):
                return None, None
            budget = DraftBudget(SETTINGS.work_on_half)
            task = DraftTask(seam, half.surface, state.sizes, work.source, half, goal, budget)
            made = propose_by_parts(task)
        except RefusedError as error:
            return None, str(error)
        if not made.sound and SurfaceParts.of(half.surface).parts > 1:
            # It is of one part alone.
            return None, f"there would be {'; '.join(made.flaws)}"
        notes = (f"symmetry is on: {found.describe()}", *made.notes)
        return _MadeDraft(replace(made, notes=notes), replace(state, plane=found.plane)), None

    def fill_touching(self, draft: _MadeDraft, goal: DraftGoal) -> _MadeDraft:
        """Fill the draft of a surface that was parted on the surface as it is.

        Raises RefusedError, with the place, where its quads are not sound there: where parts touch.
        """
        try:
            return _fill_touching(self.work, draft)
        except RefusedError as error:
            if draft.state.plane is self.state.plane:
                raise
            whole = self._draft_all(goal)
            return _fill_touching(self.work, _give_up_halves(whole, str(error)))


def _is_better(one: Draft, other: Draft, goal: DraftGoal) -> bool:
    """Is one draft better than another? A few flaws cost less than sharp edges do."""
    if not goal.strict and one.nearly_sound != other.nearly_sound:
        return one.nearly_sound
    if not goal.strict and one.nearly_sound and one.creased != other.creased:
        return one.creased
    if one.sound != other.sound:
        return one.sound
    if not one.sound:
        return one.rank < other.rank
    if one.creased != other.creased:
        return one.creased
    return one.price < other.price


def _fill_touching(work: ToolWork, draft: _MadeDraft) -> _MadeDraft:
    """A draft of a surface that was parted, filled on the surface as it is.

    Raises RefusedError, with the place, where its quads are not sound there: where parts touch.
    """
    state = replace(draft.state, network=draft.made.network)
    half, surface = work.half, work.surface
    if half is None and state.plane is not None:
        half = cut_half(work.surface, state.plane)
        surface = half.surface
    placed = draft.made.found.placed
    found = fill_as_placed(state.network, surface, work.source, state.sizes.edge, placed)
    made = Draft.of(found, DraftJudge(surface, half), draft.made.notes)
    if not made.sound:
        raise RefusedError(
            f"no draft: there would be {'; '.join(made.flaws) or 'regions without quads'}, where "
            "parts of the surface touch; part them, or draw by hand"
        )
    return replace(draft, made=replace(made, creased=draft.made.creased))


def _give_up_halves(whole: _MadeDraft, why: str) -> _MadeDraft:
    """A draft of the whole surface that says why it is not one of halves."""
    said = f"not by halves, though the surface is symmetric: {why}"
    return replace(whole, made=replace(whole.made, notes=(said, *whole.made.notes)))


def _find_in_plane(surface: Surface, half: Half) -> Points:
    """(3,) the middle of a triangle of a surface that lies in a half's plane, and is in no half."""
    off = np.abs(half.plane.heights(surface.vertices))[surface.triangles].max(axis=1)
    return surface.vertices[surface.triangles[off.argmin()]].mean(axis=0)


def _describe(draft: _MadeDraft, wanted: int | None) -> tuple[str, ...]:
    """Describe what came of it, and what is wrong with it, with places."""
    report = draft.made.report
    off = 100 * max(report.to_surface, report.from_surface)
    own = len(draft.made.network.patches)
    patches = "1 patch" if own == 1 else f"{own} patches"
    if draft.state.plane is not None:
        patches += " on each side"
    said = [
        f"{patches}, {report.quads} quads, "
        f"{sum(report.irregular.values())} irregular vertices, {off:.2g} % off at most"
    ]
    if wanted is not None and abs(report.quads / wanted - 1.0) > SETTINGS.near_count:
        more = report.quads > wanted
        why = "the least that its curves and patches need" if more else "the most that was found"
        said.append(f"{wanted} quads were asked for; {report.quads} are {why}")
    if len(poor := draft.made.poor):
        said.append(
            f"a scaled Jacobian below {SETTINGS.poor_quad:g} has "
            + count_places("a quad", "quads, the worst", poor)
        )
    return (*said, *draft.made.flaws)


DRAFT = Tool(
    "draft",
    "Propose a network for the whole surface, to be edited like any other.",
    list_arguments(DraftRequest),
    _act,
    position=235,
    holds=True,
    control=Control("8", "draft", "a first network by the machine, to be edited", gesture="act"),
)
