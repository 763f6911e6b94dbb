"""Every assignment of strokes to strands: is there a solution, and which are the best?"""

from __future__ import annotations

import numpy as np

from patterndb.core.halfedge import Int32Array, Int64Array
from patterndb.system.kernels import kernel
from query.solving.evenness import most_even
from query.solving.flow import candidates, cut_system, link, unlink
from query.solving.rounding import soluble


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

    Arguments as in :func:`carry`; found: (>= 2 * strands,) int32 scratch.
    """
    for s in range(len(flow)):
        if candidates(flow[s], side_start, lengths, tolerance, edges, end, found) == 0:
            return False
    return True


@kernel
def carry(
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
) -> int:
    """Add the best widths under which strands lie on all the strokes; return how many there are.

    edges: (p,) strand that crosses each edge, end: (strands, 2) of
    :func:`query.solving.flow.chord_ends`, side_start: (n + 1,) where sides begin there;
    lengths: (n,) edges asked for; weight: (n, n) what the square of a width counts between
    two sides; flow: (s, 4) of :func:`.flow.flows_seen`, none for no strokes. tag, keys,
    best, order, count: the list to which they are added, see :func:`.evenness.most_even`.
    With a list of no room only whether there is any: 1 or 0.
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
        n_found[s] = candidates(flow[s], side_start, lengths, tolerance, edges, end, found[s])
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
    while s >= 0:
        if s < n_flows:
            if placed[s]:
                c = carrier[s] >> 1
                unlink(s, c, first_on, next_on)
                on[c] -= 1
                placed[s] = False
            if choice[s] == n_found[s]:
                choice[s] = 0
                rank[s] = 0
                s -= 1
                continue
            carrier[s] = found[s, choice[s]]
            c = carrier[s] >> 1
            link(s, c, rank[s], first_on, next_on)
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
            if soluble(slack[:nodes], class_i, class_j, m, closed):
                return 1
        else:
            for c in range(n_strands):
                own[c] = max(1, on[c])
            count = most_even(
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
            )
        if s == n_flows:
            break
    return count
