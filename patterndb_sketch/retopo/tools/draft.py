"""The tool that proposes a first network for a whole surface."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from patterndb_sketch.retopo.arguments import Argument, Flag, optional_length
from patterndb_sketch.retopo.draft.parting import part_touching
from patterndb_sketch.retopo.draft.proposing import ProposedDraft, propose_draft
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network.structure import SYMMETRY
from patterndb_sketch.retopo.symmetry import begin_symmetry, cut_half, propose_plane
from patterndb_sketch.retopo.tool import Control, Result, Tool, ToolWork
from patterndb_sketch.retopo.wording import count_places

#: Edges of a draft, in parts of the surface's diagonal: more than 0.15 leave no shape, and less
#: than 0.004 give a hundred thousand quads, for which a draft is not made.
LEAST_EDGE, MOST_EDGE = 0.004, 0.15


def _act(work: ToolWork, a: dict[str, Any]) -> Result:
    state = work.state
    if a["edge"] is not None:
        state = replace(state, sizes=replace(state.sizes, edge=a["edge"]))
    share = state.sizes.edge / work.ground.diagonal
    if not LEAST_EDGE <= share <= MOST_EDGE:
        low, high = (part * work.ground.diagonal for part in (LEAST_EDGE, MOST_EDGE))
        raise RefusedError(
            f"an edge of {state.sizes.edge:g} is out of proportion for a draft of this surface; "
            f"give edge from {low:.3g} to {high:.3g}"
        )
    notes: list[str] = []
    parted = part_touching(work.ground)
    ground = parted.ground
    if len(parted.touching):
        places = work.ground.vertices[parted.touching]
        said = count_places("a vertex", "vertices", places)
        notes.append(f"parts of the surface touch in {said}: drafted as if they did not")
    drawn = any(not chain.marked for chain in work.network.chains.values())
    by_halves: tuple[ProposedDraft, Result] | None = None
    if a["symmetry"] and state.plane is None and not drawn:
        found = propose_plane(ground)
        if found.symmetric:
            half = cut_half(ground, found.plane)
            seam = begin_symmetry(work.network, half, state.sizes.sampling).network
            if any(SYMMETRY in chain.marks for chain in seam.chains.values()):
                try:
                    made = propose_draft(seam, half.ground, state.sizes, work.source, half)
                except RefusedError as error:
                    notes.append(f"not by halves, though the surface is symmetric: {error}")
                else:
                    said = f"symmetry is on: {found.describe()}"
                    now = replace(state, network=made.network, plane=found.plane)
                    by_halves = made, Result(now, (*notes, said, *_describe(made)))
    if by_halves is not None and by_halves[0].sound:
        return by_halves[1]
    try:
        made = propose_draft(work.network, ground, state.sizes, work.source, work.half)
    except RefusedError:
        if by_halves is None:
            raise
        return by_halves[1]
    if by_halves is not None:
        if by_halves[0].rank <= made.rank:
            return by_halves[1]
        flaws = "; ".join(by_halves[0].flaws)
        notes.append(f"not by halves, though the surface is symmetric: there would be {flaws}")
    return Result(replace(state, network=made.network), (*notes, *_describe(made)))


def _describe(made: ProposedDraft) -> tuple[str, ...]:
    """What came of it, in words."""
    report = made.report
    off = 100 * max(report.to_ground, report.from_ground)
    said = (
        f"{sum(report.patches.values())} patches, {report.quads} quads, "
        f"{sum(report.irregular.values())} irregular vertices, {off:.2g} % off at most"
    )
    return (said, *made.flaws)


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
