"""The tool that proposes a first network for a whole surface."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.arguments import Argument, Flag, optional_length
from patterndb_sketch.retopo.draft.byparts import (
    EDGES,
    LEAST_EDGE,
    fill_as_placed,
    propose_by_parts,
)
from patterndb_sketch.retopo.draft.judging import DraftJudge
from patterndb_sketch.retopo.draft.parting import part_touching
from patterndb_sketch.retopo.draft.proposing import IN_VAIN_BY_HALVES, ProposedDraft
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.ground import Ground
from patterndb_sketch.retopo.network.structure import SYMMETRY
from patterndb_sketch.retopo.state import State
from patterndb_sketch.retopo.symmetry import Half, begin_symmetry, cut_half, propose_plane
from patterndb_sketch.retopo.tool import Control, Result, Tool, ToolWork
from patterndb_sketch.retopo.wording import count_places, format_place

#: Edges of a draft, in parts of the surface's diagonal, are no longer: they would leave no shape.
MOST_EDGE = 0.15


@dataclass(frozen=True, slots=True, eq=False)
class _MadeDraft:
    """A draft, the state but for its network, and what there is to say."""

    made: ProposedDraft
    state: State
    notes: tuple[str, ...]


def _act(work: ToolWork, a: dict[str, Any]) -> Result:
    state = work.state
    if a["edge"] is not None:
        state = replace(state, sizes=replace(state.sizes, edge=a["edge"]))
    low, high = _list_edges(work.ground)
    if not low <= state.sizes.edge <= high:
        raise RefusedError(
            f"an edge of {state.sizes.edge:g} is out of proportion for a draft of this surface; "
            f"give edge from {low:.3g} to {high:.3g}"
        )
    told: tuple[str, ...] = ()
    parted = part_touching(work.ground)
    ground = parted.ground
    if len(parted.touching):
        places = work.ground.vertices[parted.touching]
        said = count_places("a vertex", "vertices", places)
        told = (f"parts of the surface touch in {said}: drafted as if they did not",)
    best = _draft_by_halves(work, state, ground) if a["symmetry"] else _draft(work, state, ground)
    if not best.made.sound:
        where = f"; {told[0]}" if told else ""
        raise RefusedError(
            f"no draft: there would be {'; '.join(best.made.flaws)}, by all that was tried{where}; "
            "take another edge, mend the surface there, or draw by hand"
        )
    if ground is not work.ground:
        try:
            best = _fill_touching(work, best)
        except RefusedError as error:
            if best.state.plane is state.plane:
                raise
            whole = _give_up_halves(_draft(work, state, ground), str(error))
            best = _fill_touching(work, whole)
    now = replace(best.state, network=best.made.network)
    return Result(now, (*told, *best.notes, *_describe(best)))


def _fill_touching(work: ToolWork, draft: _MadeDraft) -> _MadeDraft:
    """A draft of a ground that was parted, filled on the ground as it is.

    Raises RefusedError, with the place, where its quads are not sound there: where parts touch.
    """
    state = replace(draft.state, network=draft.made.network)
    half, ground = work.half, work.ground
    if half is None and state.plane is not None:
        half = cut_half(work.ground, state.plane)
        ground = half.ground
    placed = draft.made.found.placed
    found = fill_as_placed(state.network, ground, work.source, state.sizes.edge, placed)
    made = ProposedDraft.of(found, DraftJudge(ground, half))
    if not made.sound:
        raise RefusedError(
            f"no draft: there would be {'; '.join(made.flaws) or 'regions without quads'}, where "
            "parts of the surface touch; part them, or draw by hand"
        )
    return replace(draft, made=made)


def _list_edges(ground: Ground) -> tuple[float, float]:
    """The least and the greatest edge of a draft of a ground."""
    return LEAST_EDGE * ground.diagonal, MOST_EDGE * ground.diagonal


def _draft(work: ToolWork, state: State, ground: Ground) -> _MadeDraft:
    """A draft of all that is worked on."""
    low, high = _list_edges(work.ground)
    edges = tuple(times for times in EDGES if low <= times * state.sizes.edge <= high)
    found = propose_by_parts(work.network, ground, state.sizes, work.source, work.half, edges)
    return _MadeDraft(found.made, state, found.notes)


def _draft_by_halves(work: ToolWork, state: State, ground: Ground) -> _MadeDraft:
    """A draft of one half where the surface is symmetric, bare and comes out well so; else of
    all."""
    drawn = any(not chain.marked for chain in work.network.chains.values())
    found = None if drawn or state.plane is not None else propose_plane(ground)
    if found is None or not found.symmetric:
        return _draft(work, state, ground)
    try:
        half = cut_half(ground, found.plane)
        if half.in_plane:
            at = format_place(_find_in_plane(ground, half))
            raise RefusedError(f"{half.in_plane} triangles lie in the plane, one at {at}")
        seam = begin_symmetry(work.network, half, state.sizes.sampling).network
        # Where a seam alone closes a loop it is a patch: of a draft its lines are to go there.
        seam = replace(seam, patches={})
        if not any(SYMMETRY in chain.marks for chain in seam.chains.values()):
            return _draft(work, state, ground)
        by_parts = propose_by_parts(
            seam,
            half.ground,
            state.sizes,
            work.source,
            half,
            most_in_vain=IN_VAIN_BY_HALVES,
        )
    except RefusedError as error:
        return _give_up_halves(_draft(work, state, ground), str(error))
    said = f"symmetry is on: {found.describe()}"
    made = by_parts.made
    by_halves = _MadeDraft(made, replace(state, plane=found.plane), (said, *by_parts.notes))
    if made.sound:
        return by_halves
    try:
        whole = _draft(work, state, ground)
    except RefusedError:
        return by_halves
    if made.rank <= whole.made.rank:
        return by_halves
    return _give_up_halves(whole, f"there would be {'; '.join(made.flaws)}")


def _give_up_halves(whole: _MadeDraft, why: str) -> _MadeDraft:
    """A draft of the whole surface that says why it is not one of halves."""
    said = f"not by halves, though the surface is symmetric: {why}"
    return replace(whole, notes=(said, *whole.notes))


def _find_in_plane(ground: Ground, half: Half) -> Points:
    """(3,) the middle of a triangle of a ground that lies in a half's plane, and is in no half."""
    off = np.abs(half.plane.heights(ground.vertices))[ground.triangles].max(axis=1)
    return ground.vertices[ground.triangles[off.argmin()]].mean(axis=0)


def _describe(draft: _MadeDraft) -> tuple[str, ...]:
    """What came of it, in words."""
    report = draft.made.report
    off = 100 * max(report.to_ground, report.from_ground)
    own = len(draft.made.network.patches)
    patches = "1 patch" if own == 1 else f"{own} patches"
    if draft.state.plane is not None:
        patches += " on each side"
    said = (
        f"{patches}, {report.quads} quads, "
        f"{sum(report.irregular.values())} irregular vertices, {off:.2g} % off at most"
    )
    return (said, *draft.made.flaws)


DRAFT = Tool(
    "draft",
    "Propose a network for the whole surface, to be edited like any other.",
    {
        "edge": optional_length("target length of the quads' edges"),
        "symmetry": Argument(Flag(), "work on one half of a surface that is symmetric", True),
    },
    _act,
    position=235,
    holds=True,
    control=Control("8", "draft", "a first network by the machine, to be edited", gesture="act"),
)
