"""How far a fill's strands are off strokes, counted in edges on the fill itself."""

from __future__ import annotations

from collections.abc import Sequence

from patterndb.geometry.neighbours import Neighbours
from query.fill import Fill
from query.placing.strand import far_ends, loop_chains, position
from query.stroke import Stroke


def edges_off(fill: Fill, strokes: Sequence[Stroke], tolerance: int) -> int | None:
    """The fewest edges by which distinct strands miss all strokes; None where they cannot lie
    on them within the tolerance, or there are fewer loops than loop strokes."""
    beside = Neighbours.of(fill.quads, fill.n_vertices, fill.perimeter)
    loops = sum(stroke.is_loop for stroke in strokes)
    if loops and len(loop_chains(beside.twin)) < loops:
        return None
    far = far_ends(beside.twin, beside.border).tolist()
    side_of = [side for side, length in enumerate(fill.lengths) for _ in range(length)]
    choices: list[dict[int, int]] = []
    for stroke in strokes:
        if stroke.start is None or stroke.end is None:
            continue
        near, end = position(fill.lengths, stroke.start), position(fill.lengths, stroke.end)
        found: dict[int, int] = {}
        for at in range(near - tolerance, near + tolerance + 1):
            if not 0 <= at < fill.perimeter or side_of[at] != side_of[near]:
                continue
            other = far[at]
            if side_of[other] != side_of[end] or abs(other - end) > tolerance:
                continue
            # A strand goes by the smaller of its two places.
            strand = min(at, other)
            off = abs(at - near) + abs(other - end)
            found[strand] = min(off, found.get(strand, off))
        choices.append(found)
    return _least_sum(choices, set())


def _least_sum(choices: Sequence[dict[int, int]], taken: set[int]) -> int | None:
    """The least sum with a different strand for each."""
    if not choices:
        return 0
    sums: list[int] = []
    for strand, off in choices[0].items():
        if strand not in taken:
            rest = _least_sum(choices[1:], taken | {strand})
            if rest is not None:
                sums.append(off + rest)
    return min(sums, default=None)
