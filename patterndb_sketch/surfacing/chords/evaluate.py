"""Every sub-cycle solved once, in an order in which its parts come first."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats
from patterndb.system.kernels import kernel
from patterndb_sketch.surfacing.chords.flatness import (
    N_MOMENTS,
    add_moments,
    determinant_of,
    moments_of,
)
from patterndb_sketch.surfacing.chords.subcycles import Subcycles

#: Costs that differ by no more than this share of S(whole cycle) + alpha are equal. They are sums
#: of some tens of terms, each with an error in the 16th digit.
TIE = 1e-12


class Measures(NamedTuple):
    """What sub-cycles are summed up from.

    corner: (k, 10) moments of every end. up_to: (k + 1, 10) moments of the vertices from end 0
    to before every end. arc_to: (k + 1,) lengths of the cycle from end 0 to every end.
    chord: (m,) lengths. printed: which form of S. whole: the whole cycle's determinant.
    """

    corner: Floats
    up_to: Floats
    arc_to: Floats
    chord: Floats
    printed: bool
    whole: float


class Solutions(NamedTuple):
    """What is known of every sub-cycle, by its number.

    value: its cost. fewest: how many chords cut it. choice: the chord that cuts it first, or -1.
    """

    value: Floats
    fewest: NDArray[np.int32]
    choice: NDArray[np.int32]


@kernel
def measured(
    points: Floats, own: Floats, chords: Int64Array, ends: Int64Array, printed: bool
) -> Measures:
    """The measures of a loop of points (n, 3), which are ``own`` in standardised axes."""
    n, k = len(points), len(ends)
    corner = np.zeros((k, N_MOMENTS))
    up_to = np.zeros((k + 1, N_MOMENTS))
    arc_to = np.zeros(k + 1)
    for i in range(k):
        add_moments(corner[i], own[ends[i]])
        up_to[i + 1] = up_to[i]
        arc_to[i + 1] = arc_to[i]
        stop = ends[i + 1] if i + 1 < k else ends[0] + n
        for v in range(ends[i], stop):
            add_moments(up_to[i + 1], own[v % n])
            arc_to[i + 1] += _distance(points, v % n, (v + 1) % n)
    chord = np.empty(len(chords))
    for c in range(len(chords)):
        chord[c] = _distance(points, chords[c, 0], chords[c, 1])
    return Measures(corner, up_to, arc_to, chord, printed, determinant_of(moments_of(own)))


@kernel
def _distance(points: Floats, a: int, b: int) -> float:
    x = points[a, 0] - points[b, 0]
    y = points[a, 1] - points[b, 1]
    z = points[a, 2] - points[b, 2]
    return math.sqrt(x * x + y * y + z * z)


@kernel
def evaluate(
    wrap: int, numbering: Subcycles, measures: Measures, alpha: float, solutions: Solutions
) -> None:
    """Solve all sub-cycles with one wrap (m for none), in the order of their numbers.

    A path is its jumps, with arcs between them and after the last. Each path's extensions by one
    more jump are walked before it is solved itself. Chords that could cut are found once the
    path is settled up to where they end, and are then known to all extensions.
    """
    # Tuples of arrays are taken apart once: handed on in the loops, every array's references
    # would be counted each time, which takes longer than the work.
    first, last = numbering.first, numbering.last
    paths, offsets, bases = numbering.paths, numbering.offsets, numbering.base
    corner, up_to, arc_to, chord = (
        measures.corner,
        measures.up_to,
        measures.arc_to,
        measures.chord,
    )
    value, fewest, choice = solutions.value, solutions.fewest, solutions.choice
    m, k = len(first), len(numbering.ends)
    start, stop, base = 0, k, bases[wrap]
    if wrap < m:
        start, stop = first[wrap], last[wrap]
    to_stop, offset = paths[stop], offsets[stop]
    whole = 1.0 / measures.whole
    tie = TIE * (1.0 + alpha)
    by_first, first_at, by_last, last_at = _inside(wrap, start, stop, numbering)
    n_inside = len(by_first)

    # By depth: a jump, from where to where it goes, the path's number, length and moments up to
    # there, how many chords could cut it, and which jumps and chords to look at next.
    most = stop - start + 1
    jump = np.empty(most, np.int64)
    enter = np.empty(most, np.int64)
    leave = np.empty(most, np.int64)
    number = np.empty(most, np.int64)
    length = np.empty(most)
    moments = np.zeros((most, N_MOMENTS))
    n_cuts = np.empty(most, np.int64)
    next_first = np.empty(most, np.int64)
    next_last = np.empty(most, np.int64)
    # The chords that could cut: the number of the part under it, and what the number of the
    # path changes by if that part is replaced by a jump.
    cut = np.empty(n_inside, np.int64)
    cut_left = np.empty(n_inside, np.int64)
    cut_shift = np.empty(n_inside, np.int64)
    cut_value = np.empty(n_inside)
    cut_length = np.empty(n_inside)
    total = np.empty(n_inside)
    sums = np.empty(N_MOMENTS)

    jump[0], enter[0], leave[0], number[0], length[0] = -1, start, start, 0, 0.0
    n_cuts[0], next_first[0], next_last[0] = 0, 0, 0
    if wrap < m:
        length[0] = chord[wrap]
        for i in range(N_MOMENTS):
            moments[0, i] = corner[stop, i]
    depth = 0
    while depth >= 0:
        at = leave[depth]
        s = next_first[depth]
        ahead = first[by_first[s]] if s < n_inside else stop

        # The chords that end from here to where the next jump begins. ``inside`` is the number
        # of the part from ``behind`` on, among the paths to where the chord ends.
        n, previous, inside, behind, t = n_cuts[depth], -1, 0, 0, 0
        for i in range(next_last[depth], last_at[ahead + 1]):
            c = by_last[i]
            begin, end = first[c], last[c]
            if end != previous:
                previous, inside, behind, t = end, 0, end, depth
            while leave[t] > begin:
                inside += paths[end, leave[t]] - paths[end, behind] + offsets[end, jump[t]]
                behind = enter[t]
                t -= 1
            # It begins under a jump.
            if behind < begin:
                continue
            under = inside + paths[end, begin] - paths[end, behind]
            # Number 0 is the chord itself: it is on the boundary.
            if under > 0:
                up_to_begin = number[t] + to_stop[leave[t]] - to_stop[begin]
                up_to_end = number[depth] + to_stop[at] - to_stop[end]
                cut[n] = c
                cut_left[n] = bases[c] + under
                cut_shift[n] = up_to_begin + offset[c] - up_to_end
                cut_value[n] = value[bases[c] + under]
                cut_length[n] = alpha * chord[c]
                n += 1
        n_cuts[depth] = n
        next_last[depth] = last_at[ahead + 1]

        if s < n_inside:
            c = by_first[s]
            next_first[depth] = s + 1
            end = last[c]
            jump[depth + 1], enter[depth + 1], leave[depth + 1] = c, ahead, end
            number[depth + 1] = number[depth] + to_stop[at] - to_stop[ahead] + offset[c]
            length[depth + 1] = length[depth] + arc_to[ahead] - arc_to[at] + chord[c]
            for i in range(N_MOMENTS):
                moments[depth + 1, i] = (
                    moments[depth, i] + (up_to[ahead, i] - up_to[at, i]) + corner[ahead, i]
                )
            n_cuts[depth + 1] = n
            next_first[depth + 1], next_last[depth + 1] = first_at[end], last_at[end]
            depth += 1
            continue

        # No jump is left: leave the sub-cycle whole, or make the best of its cuts.
        own = base + number[depth] + to_stop[at] - 1
        for i in range(N_MOMENTS):
            sums[i] = moments[depth, i] + (up_to[stop, i] - up_to[at, i])
        flat = determinant_of(sums) * whole
        if not measures.printed:
            flat = math.sqrt(flat)
        least = flat
        share = 1.0 / (length[depth] + arc_to[stop] - arc_to[at])
        for i in range(n):
            total[i] = cut_value[i] + value[own + cut_shift[i]] + share * cut_length[i]
            least = min(least, total[i])
        value[own], fewest[own], choice[own] = flat, 0, -1
        if flat > least + tie:
            best = -1
            for i in range(n):
                if total[i] > least + tie:
                    continue
                n_chords = 1 + fewest[cut_left[i]] + fewest[own + cut_shift[i]]
                if (
                    best < 0
                    or n_chords < fewest[own]
                    or (n_chords == fewest[own] and cut[i] < cut[best])
                ):
                    best = i
                    value[own], fewest[own], choice[own] = total[i], n_chords, cut[i]
        depth -= 1


@kernel
def _inside(
    wrap: int, start: int, stop: int, numbering: Subcycles
) -> tuple[Int64Array, Int64Array, Int64Array, Int64Array]:
    """The chords between two ends but for the wrap, by their first end and by their last, and
    where in these orders those of every end begin."""
    starting, start_at = numbering.starting, numbering.start_at
    ending, end_at = numbering.ending, numbering.end_at
    by_first = np.empty(len(starting), np.int64)
    by_last = np.empty(len(starting), np.int64)
    first_at = np.empty(stop + 2, np.int64)
    last_at = np.empty(stop + 2, np.int64)
    n_first, n_last = 0, 0
    for v in range(start, stop + 1):
        first_at[v], last_at[v] = n_first, n_last
        for s in range(start_at[v], start_at[v + 1]):
            c = starting[s]
            if numbering.last[c] <= stop and c != wrap:
                by_first[n_first] = c
                n_first += 1
        for s in range(end_at[v], end_at[v + 1]):
            c = ending[s]
            if numbering.first[c] >= start and c != wrap:
                by_last[n_last] = c
                n_last += 1
    first_at[stop + 1], last_at[stop + 1] = n_first, n_last
    return by_first[:n_first], first_at, by_last[:n_last], last_at
