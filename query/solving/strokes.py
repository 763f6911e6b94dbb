"""Strokes on a pattern: which strands carry them, and the best widths under which they do.

A stroke asks for a strand of quads that leaves side a at edge i and side b at edge j, give
or take the tolerance K. If polychord q carries it, q is a strand 1 wide between two parts of
any width >= 0: x_q = u + 1 + w. The strand cuts side a in two *pieces*, of i + d and
L_a - i - 1 - d edges with \\|d\\| <= K, and side b likewise. So strokes only cut sides: what is
left is the same matching as without them, with pieces in the place of sides, and classes of
polychords that join pieces. A tolerance is one more node, of slack 2 K, joined to the two
pieces of its cut: what it gives to one it does not give to the other.

Several strokes may lie on one polychord, in any order; its two ends see that order reversed.
:func:`carry_strokes` tries every assignment of strokes to strands.

Source: Marcias et al. 2015, section 4, "Edge-flow constraints". Differs from the paper: one
system of the matching instead of an integer program per polychord, every assignment of
strokes to polychords is tried, and each of several strokes has a strand of its own.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array, Int64Array
from patterndb.system.kernels import kernel
from query.boundary import Boundary
from query.orientation import Orientation
from query.solving.evenness import add_most_even
from query.solving.matching import is_soluble
from query.stroke import Stroke

#: Columns of strokes as a pattern sees them: side and edge of one end, and of the other.
FLOW_COLUMNS = 4


def orient_strokes(
    strokes: Sequence[Stroke], boundary: Boundary, orientation: Orientation
) -> Int32Array:
    """(s, 4) int32 side, edge, side, edge of the strokes in the pattern's own order.

    Loops are left out: no side sees them.
    """
    n = max(boundary.n_sides, 1)
    rows: list[list[int]] = []
    for stroke in strokes:
        if stroke.start is None or stroke.end is None:
            continue
        row: list[int] = []
        for side, edge in (stroke.start, stroke.end):
            if orientation.mirrored:
                row += [(orientation.rotation - side) % n, boundary.lengths[side] - 1 - edge]
            else:
                row += [(orientation.rotation + side) % n, edge]
        rows.append(row)
    return np.array(rows, np.int32).reshape(-1, FLOW_COLUMNS)


@kernel
def find_chord_ends(edges: Int32Array, end: Int32Array) -> None:
    """Write the two positions, ascending, at which each strand meets the boundary.

    edges: (p,) strand that crosses each edge; end: (>= strands, 2) int32.
    """
    end[:] = -1
    for at in range(len(edges)):
        c = edges[at]
        end[c, 0 if end[c, 0] < 0 else 1] = at


@kernel
def find_carriers(
    flow: Int32Array,
    side_start: Int32Array,
    lengths: Int32Array,
    tolerance: int,
    edges: Int32Array,
    end: Int32Array,
    found: Int32Array,
) -> int:
    """The strands that may carry one stroke, for all that its own place says.

    flow: (4,); side_start: (n + 1,) first edge of each side of the pattern; lengths: (n,)
    edges asked for. found: (>= 2 * strands,) int32, overwritten with 2 * strand + flip, where
    flip says that the stroke's first end is the strand's second. Returns how many.
    """
    a, i, b, j = flow[0], flow[1], flow[2], flow[3]
    count = 0
    for at in range(side_start[a], side_start[a + 1]):
        c = edges[at]
        flip = 0 if end[c, 0] == at else 1
        other = end[c, 1 - flip]
        if not side_start[b] <= other < side_start[b + 1]:
            continue
        if at - side_start[a] > i + tolerance or other - side_start[b] > j + tolerance:
            continue
        if side_start[a + 1] - at > lengths[a] - i + tolerance:
            continue
        if side_start[b + 1] - other > lengths[b] - j + tolerance:
            continue
        found[count] = 2 * c + flip
        count += 1
    return count


@kernel
def cut_system(
    edges: Int32Array,
    end: Int32Array,
    side_start: Int32Array,
    lengths: Int32Array,
    weight: Int32Array,
    flow: Int32Array,
    carrier: Int32Array,
    n_flows: int,
    next_on: Int32Array,
    first_on: Int32Array,
    tolerance: int,
    slack: Int32Array,
    class_i: Int32Array,
    class_j: Int32Array,
    class_n: Int32Array,
    class_weight: Int32Array,
    part_class: Int32Array,
    part_chord: Int32Array,
    class_at: Int32Array,
) -> tuple[int, int, int]:
    """The system of the pieces, when the first ``n_flows`` strokes are carried as said.

    weight: (n, n) what the square of a width counts between two sides.
    carrier: (s,) 2 * strand + flip for every stroke; first_on: (strands,) the stroke on each
    strand that comes first as its first end sees them, or -1; next_on: (s,) the stroke after
    each, or -1. Other inputs as in :func:`find_carriers`.

    Overwritten: slack: (nodes,) of pieces and tolerances; class_i, class_j, class_n,
    class_weight: (m,) with class_n 0 for those of a tolerance, the first of each two having
    the weight 1 and the other 0, as :mod:`.evenness` takes them; part_class, part_chord:
    (parts,) class and strand of every part, in order of the strands, whose own width is 1 or,
    where strokes divide the strand, 0. class_at: (nodes, nodes) int32 scratch, -1 throughout
    before and after.
    Returns (nodes, classes, parts); (0, 0, 0) where a piece is too short for its strands.
    """
    n_sides = len(lengths)
    n_strands = len(first_on)
    # Parts are numbered strand by strand, in the order their first ends see.
    parts = 0
    part_first = np.empty(n_strands + 1, np.int32)
    for c in range(n_strands):
        part_first[c] = parts
        parts += 1
        f = first_on[c]
        while f >= 0:
            parts += 1
            f = next_on[f]
    part_first[n_strands] = parts
    piece = np.empty((parts, 2), np.int32)
    side_of = np.empty(n_sides + 2 * n_flows, np.int32)
    nodes = 0
    n_cuts = 0
    before = np.empty(2 * n_flows, np.int32)
    on_chord = np.empty(n_flows, np.int32)
    for s in range(n_sides):
        left = 0
        freedom = 0
        base = 0
        side_of[nodes] = s
        for at in range(side_start[s], side_start[s + 1]):
            c = edges[at]
            second = 1 if end[c, 1] == at else 0
            if first_on[c] < 0:
                piece[part_first[c], second] = nodes
                base += 1
                continue
            m = 0
            f = first_on[c]
            while f >= 0:
                on_chord[m] = f
                m += 1
                f = next_on[f]
            for t in range(m):
                part = part_first[c] + (m - t if second else t)
                piece[part, second] = nodes
                f = on_chord[m - 1 - t if second else t]
                begins = (carrier[f] & 1) == second
                place = flow[f, 1] if begins else flow[f, 3]
                slack[nodes] = place - left + freedom + tolerance - base
                if slack[nodes] < 0:
                    return 0, 0, 0
                before[n_cuts] = nodes
                n_cuts += 1
                nodes += 1
                side_of[nodes] = s
                left = place + 1
                freedom = tolerance
                base = 0
            piece[part_first[c] + (0 if second else m), second] = nodes
        slack[nodes] = lengths[s] - left + freedom - base
        if slack[nodes] < 0:
            return 0, 0, 0
        nodes += 1
    m = 0
    for c in range(n_strands):
        for part in range(part_first[c], part_first[c + 1]):
            i = min(piece[part, 0], piece[part, 1])
            j = max(piece[part, 0], piece[part, 1])
            k = class_at[i, j]
            if k < 0:
                k = m
                class_at[i, j] = k
                class_i[k] = i
                class_j[k] = j
                class_n[k] = 0
                class_weight[k] = weight[side_of[i], side_of[j]]
                m += 1
            class_n[k] += 1
            part_class[part] = k
            part_chord[part] = c
    for k in range(m):
        class_at[class_i[k], class_j[k]] = -1
    if tolerance > 0:
        for cut in range(n_cuts):
            for side in range(2):
                class_i[m] = before[cut] + side
                class_j[m] = nodes
                class_n[m] = 0
                class_weight[m] = 1 - side
                m += 1
            slack[nodes] = 2 * tolerance
            nodes += 1
    return nodes, m, parts


@kernel
def link_stroke(
    stroke: int, strand: int, rank: int, first_on: Int32Array, next_on: Int32Array
) -> bool:
    """Insert a stroke on a strand as its number ``rank``; False where there are fewer."""
    if rank == 0:
        next_on[stroke] = first_on[strand]
        first_on[strand] = stroke
        return True
    f = first_on[strand]
    for _ in range(rank - 1):
        if f < 0:
            return False
        f = next_on[f]
    if f < 0:
        return False
    next_on[stroke] = next_on[f]
    next_on[f] = stroke
    return True


@kernel
def unlink_stroke(stroke: int, strand: int, first_on: Int32Array, next_on: Int32Array) -> None:
    """Undo :func:`link_stroke`."""
    if first_on[strand] == stroke:
        first_on[strand] = next_on[stroke]
        return
    f = first_on[strand]
    while next_on[f] != stroke:
        f = next_on[f]
    next_on[f] = next_on[stroke]


@kernel
def may_carry(
    edges: Int32Array,
    end: Int32Array,
    side_start: Int32Array,
    lengths: Int32Array,
    flow: Int32Array,
    tolerance: int,
    found: Int32Array,
) -> bool:
    """Is there a strand for every stroke, for all that each place says by itself?

    Arguments as in :func:`carry_strokes`; found: (>= 2 * strands,) int32 scratch.
    """
    for s in range(len(flow)):
        if find_carriers(flow[s], side_start, lengths, tolerance, edges, end, found) == 0:
            return False
    return True


@kernel
def carry_strokes(
    edges: Int32Array,
    end: Int32Array,
    side_start: Int32Array,
    lengths: Int32Array,
    weight: Int32Array,
    flow: Int32Array,
    tolerance: int,
    tag: int,
    keys: Int64Array,
    best: Int32Array,
    order: Int64Array,
    count: int,
    cancelled: NDArray[np.uint8],
) -> int:
    """Add the best widths under which strands lie on all the strokes; return how many there are.

    edges: (p,) strand that crosses each edge, end: (strands, 2) of
    :func:`query.solving.strokes.find_chord_ends`, side_start: (n + 1,) where sides begin there;
    lengths: (n,) edges asked for; weight: (n, n) what the square of a width counts between
    two sides; flow: (s, 4) of :func:`orient_strokes`, none for no strokes. tag, keys,
    best, order, count: the list to which they are added, see :func:`.evenness.add_most_even`.
    With a list of no room only whether there is any: 1 or 0. cancelled: (1,), where it is 1, the
    answer is of no use.
    """
    n_flows = len(flow)
    n_sides = len(lengths)
    n_strands = len(edges) // 2
    keep = len(order)
    most_nodes = n_sides + 4 * n_flows
    most_parts = n_strands + n_flows
    most_classes = most_parts + 4 * n_flows
    slack = np.empty(most_nodes, np.int32)
    class_i = np.empty(most_classes, np.int32)
    class_j = np.empty(most_classes, np.int32)
    class_n = np.empty(most_classes, np.int32)
    class_weight = np.empty(most_classes, np.int32)
    part_class = np.empty(most_parts, np.int32)
    part_chord = np.empty(most_parts, np.int32)
    class_at = np.full((most_nodes, most_nodes), -1, np.int32)
    closed = np.zeros(most_classes, np.bool_)

    strand_weight = np.empty(n_strands, np.int32)
    side = 0
    for at in range(len(edges)):
        while side_start[side + 1] <= at:
            side += 1
        c = edges[at]
        if end[c, 0] == at:
            other = 0
            while side_start[other + 1] <= end[c, 1]:
                other += 1
            strand_weight[c] = weight[side, other]
    own = np.ones(n_strands, np.int32)

    found = np.empty((n_flows, 2 * len(edges)), np.int32)
    n_found = np.empty(n_flows, np.int32)
    for s in range(n_flows):
        n_found[s] = find_carriers(flow[s], side_start, lengths, tolerance, edges, end, found[s])
        if n_found[s] == 0:
            return count
    carrier = np.empty(n_flows, np.int32)
    first_on = np.full(n_strands, -1, np.int32)
    next_on = np.full(n_flows, -1, np.int32)
    on = np.zeros(n_strands, np.int32)
    # The next choice for every stroke: which candidate, and at which rank on its strand.
    choice = np.zeros(n_flows, np.int32)
    rank = np.zeros(n_flows, np.int32)
    placed = np.zeros(n_flows, np.bool_)
    s = 0
    while s >= 0 and not cancelled[0]:
        if s < n_flows:
            if placed[s]:
                c = carrier[s] >> 1
                unlink_stroke(s, c, first_on, next_on)
                on[c] -= 1
                placed[s] = False
            if choice[s] == n_found[s]:
                choice[s] = 0
                rank[s] = 0
                s -= 1
                continue
            carrier[s] = found[s, choice[s]]
            c = carrier[s] >> 1
            link_stroke(s, c, rank[s], first_on, next_on)
            placed[s] = True
            if rank[s] == on[c]:
                choice[s] += 1
                rank[s] = 0
            else:
                rank[s] += 1
            on[c] += 1
        nodes, m, parts = cut_system(
            edges,
            end,
            side_start,
            lengths,
            weight,
            flow,
            carrier,
            min(s + 1, n_flows),
            next_on,
            first_on,
            tolerance,
            slack,
            class_i,
            class_j,
            class_n,
            class_weight,
            part_class,
            part_chord,
            class_at,
        )
        if nodes == 0:
            if s == n_flows:
                s -= 1
            continue
        if s + 1 < n_flows:
            s += 1
            continue
        if keep == 0:
            if is_soluble(slack[:nodes], class_i, class_j, m, closed):
                return 1
        else:
            for c in range(n_strands):
                own[c] = max(1, on[c])
            count = add_most_even(
                slack[:nodes],
                class_i[:m],
                class_j[:m],
                class_n[:m],
                class_weight[:m],
                part_class[:parts],
                part_chord[:parts],
                own,
                strand_weight,
                tolerance,
                tag,
                keys,
                best,
                order,
                count,
                cancelled,
            )
        if s == n_flows:
            break
    return count


@kernel
def can_carry(
    edges: Int32Array,
    side_start: Int32Array,
    lengths: Int32Array,
    flow: Int32Array,
    tolerance: int,
) -> bool:
    """Are there widths under which strands lie on all the strokes?

    Arguments as in :func:`find_carrying_widths`.
    """
    n_strands = len(edges) // 2
    end = np.empty((n_strands, 2), np.int32)
    find_chord_ends(edges, end)
    weight = np.ones((len(lengths), len(lengths)), np.int32)
    keys = np.empty(0, np.int64)
    best = np.empty((0, n_strands + 1), np.int32)
    never = np.zeros(1, np.uint8)
    count = carry_strokes(
        edges, end, side_start, lengths, weight, flow, tolerance, 0, keys, best, keys, 0, never
    )
    return count > 0


@kernel
def find_carrying_widths(
    edges: Int32Array,
    side_start: Int32Array,
    lengths: Int32Array,
    flow: Int32Array,
    tolerance: int,
    keep: int,
) -> Int32Array:
    """(k, n) int32, the ``keep`` best widths under which strands lie on all the strokes.

    edges: (2 n,) strand that crosses each edge; side_start: (N + 1,) where sides begin there;
    lengths: (N,) edges asked for; flow: (s, 4) of :func:`orient_strokes`, none for no strokes.
    All there are, if fewer than ``keep``; best first.
    """
    n_strands = len(edges) // 2
    end = np.empty((n_strands, 2), np.int32)
    find_chord_ends(edges, end)
    weight = np.ones((len(lengths), len(lengths)), np.int32)
    keys = np.empty(keep, np.int64)
    best = np.empty((keep, n_strands + 1), np.int32)
    order = np.empty(keep, np.int64)
    never = np.zeros(1, np.uint8)
    count = carry_strokes(
        edges, end, side_start, lengths, weight, flow, tolerance, 0, keys, best, order, 0, never
    )
    widths = np.empty((count, n_strands), np.int32)
    for k in range(count):
        for p in range(n_strands):
            widths[k, p] = best[order[k], p]
    return widths
