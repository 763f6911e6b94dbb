"""Where the corners of a boundary may fall on a pattern: every choice of marks within bounds.

A mark lies on a boundary vertex, or at a *slot* inside a boundary edge, where it parts the
polychord that crosses the edge into *strands*. The slots of a polychord are ordered across it; its
two ends see the same order, reversed. On one polychord with m marks, any sequence of slots is a
choice, each with a mark at the one end, the other, or both: no other partings matter.

Each choice of marks becomes one record; :mod:`query.marks.marked` makes a table of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from patterndb.core.buffers import copy_items
from patterndb.core.code import Code, border_count, clockwise_start, rooted_code
from patterndb.core.halfedge import Index, Int32Array, next_border_edge
from patterndb.core.polychord import trace
from patterndb.system.kernels import kernel

#: Bits of an edge's slots in one number: more marks than that on one polychord are refused.
MOST_SLOTS = 12


@dataclass(frozen=True, slots=True, eq=False)
class Partings:
    """All ways to set up to m marks into the slots of one polychord, fewest marks first.

    marks: (a,) int32 how many marks; parting 0 has none.
    slots: (a,) int32 how many slots; there is one strand more.
    near, far: (a,) int32 bit s is set where slot s has a mark at the polychord's first end,
        and at its other end; slots are counted across it as its first end sees them.
    """

    marks: Int32Array
    slots: Int32Array
    near: Int32Array
    far: Int32Array

    @classmethod
    def up_to(cls, most: int) -> Partings:
        """Those with at most ``most`` marks: 2.41**most of them, about."""
        rows = [(0, 0, 0, 0)]
        level = rows
        for s in range(most):
            level = [
                (marks + more, s + 1, near | a << s, far | b << s)
                for marks, _, near, far in level
                for more, a, b in ((1, 1, 0), (1, 0, 1), (2, 1, 1))
                if marks + more <= most
            ]
            rows = rows + level
        columns = np.array(sorted(rows), np.int32).T.copy()
        return cls(columns[0], columns[1], columns[2], columns[3])


class Rim(NamedTuple):
    """The boundary of a pattern of P edges.

    quads: (P,) int32 number of quads at each boundary vertex, from corner 0 on.
    chord: (P,) int32 polychord that crosses each edge, in label order.
    near, far: (n,) int32 first and other edge that each polychord ends on.
    shift, reflected: (g,) int32 and bool, the symmetries: vertex i looks like vertex
        shift + i, or, reflected, like shift - i, and edge i like edge shift - i - 1.
    """

    quads: Int32Array
    chord: Int32Array
    near: Int32Array
    far: Int32Array
    shift: Int32Array
    reflected: NDArray[np.bool_]


@kernel
def trace_rim(code: Code) -> Rim:
    """The boundary of the pattern of a canonical code, (4q,) uint16."""
    size = len(code)
    q = size // 4
    twin = code.astype(np.int32) - 1
    loop = np.empty(size, np.int32)
    perimeter = 0
    h = 0
    while True:
        loop[perimeter] = h
        perimeter += 1
        h = next_border_edge(twin, h)
        if h == 0:
            break
    of_edge, n_open, n_total = trace(twin)
    name = np.full(n_total, -1, np.int32)
    quads = np.empty(perimeter, np.int32)
    chord = np.empty(perimeter, np.int32)
    near = np.empty(n_open, np.int32)
    far = np.empty(n_open, np.int32)
    fresh = 0
    for i in range(perimeter):
        quads[i] = border_count(twin, loop[i])
        c = of_edge[loop[i]]
        if name[c] < 0:
            name[c] = fresh
            near[fresh] = i
            fresh += 1
        else:
            far[name[c]] = i
        chord[i] = name[c]
    shift = np.empty(2 * perimeter, np.int32)
    reflected = np.empty(2 * perimeter, np.bool_)
    number = np.empty(q, np.int32)
    entry = np.empty(q, np.int32)
    order = np.empty(q, np.int32)
    seen = np.empty(size, np.uint16)
    n = 0
    for i in range(perimeter):
        if quads[i] != quads[0]:
            continue
        for clockwise in (False, True):
            copy_items(code, size, seen, 0)
            start = clockwise_start(twin, loop[i]) if clockwise else loop[i]
            if rooted_code(twin, q, start, clockwise, seen, number, entry, order, True) == 0:
                shift[n] = i
                reflected[n] = clockwise
                n += 1
    return Rim(quads, chord, near, far, shift[:n].copy(), reflected[:n].copy())


@kernel
def mirror_bits(bits: Index, n: Index) -> Index:
    """The lowest n bits in reverse order."""
    result = 0
    for s in range(n):
        result |= (bits >> s & 1) << (n - 1 - s)
    return result


@kernel
def is_first_image(
    pattern: Rim, at_vertex: NDArray[np.bool_], slots: Int32Array, bits: Int32Array
) -> bool:
    """Does no symmetry of the pattern take the marks to a smaller image?

    at_vertex: (P,) bool; slots, bits: (P,) int32 slots of every edge and which of them have
    marks, counter-clockwise. Of all images of a choice exactly one passes.
    """
    perimeter = len(slots)
    for g in range(len(pattern.shift)):
        for i in range(perimeter):
            if pattern.reflected[g]:
                v = (pattern.shift[g] - i) % perimeter
                e = (pattern.shift[g] - i - 1) % perimeter
                other = mirror_bits(bits[e], slots[e])
            else:
                v = (pattern.shift[g] + i) % perimeter
                e = v
                other = bits[e]
            mine = (int(at_vertex[i]), slots[i], bits[i])
            theirs = (int(at_vertex[v]), slots[e], other)
            if theirs < mine:
                return False
            if theirs > mine:
                break
    return True


# Columns of a record's head; the counts at its N marks follow, then the upper triangle of
# the strands that join its sides, row by row, in the order of its system.
PATTERN = 0
COST = 1
UNMARKED = 2  # corners of the pattern without a mark
RELAXED = 3  # 0 where the marks are the pattern's corners
PERIMETER = 4  # strand ends
START_EDGE = 5
START_STRAND = 6
ROTATION = 7
REFLECTED = 8
STRANDS = 9
HEAD = 10


@kernel
def _with_room(array: NDArray[Any], size: int) -> NDArray[Any]:
    """The array, or a copy twice as long where it has less than ``size`` rows."""
    return array if size <= len(array) else np.concatenate((array, np.zeros_like(array)))


@kernel
def write_label(
    pattern: Rim,
    at_vertex: NDArray[np.bool_],
    slots: Int32Array,
    bits: Int32Array,
    counts: Int32Array,
    label: NDArray[np.int16],
    chord: NDArray[np.int16],
    joins: Int32Array,
) -> tuple[int, int, int, int]:
    """Write a record's label, beginning at the first mark from corner 0 on.

    at_vertex: (P,), slots, bits: (P,) of :func:`is_first_image`. counts: (N,) quads
    at the marks; label: (>= N + 2 s,); chord: (>= s,) for s strands; joins: (N, N)
    symmetric, a strand with both ends on a side counts once. Returns (edge and strand
    where the first mark lies, length of the label, number of strands).
    """
    perimeter = len(slots)
    n_chords = len(pattern.near)
    # Strands of all polychords in one list, each polychord's as its near end sees them.
    base = np.zeros(n_chords + 1, np.int32)
    for c in range(n_chords):
        base[c + 1] = base[c] + slots[pattern.near[c]] + 1
    name = np.full(base[n_chords], -1, np.int32)
    side_of = np.empty(base[n_chords], np.int32)
    joins[:] = 0
    edge = 0
    strand = 0
    while not at_vertex[edge] if strand == 0 else bits[edge] >> (strand - 1) & 1 == 0:
        strand += 1
        if strand > slots[edge]:
            edge += 1
            strand = 0
    start_edge, start_strand = edge, strand
    side = -1
    size_at = 0
    at = 0
    fresh = 0
    while True:
        marked = at_vertex[edge] if strand == 0 else bits[edge] >> (strand - 1) & 1 == 1
        if marked:
            side += 1
            counts[side] = pattern.quads[edge] if strand == 0 else 2
            size_at = at
            label[size_at] = 0
            at += 1
        c = pattern.chord[edge]
        across = strand if pattern.near[c] == edge else slots[edge] - strand
        s = base[c] + across
        if name[s] < 0:
            name[s] = fresh
            chord[fresh] = c
            side_of[s] = side
            fresh += 1
        else:
            i = side_of[s]
            joins[i, side] += 1
            if i != side:
                joins[side, i] += 1
        label[at] = name[s]
        label[size_at] += 1
        at += 1
        strand += 1
        if strand > slots[edge]:
            edge = (edge + 1) % perimeter
            strand = 0
        if edge == start_edge and strand == start_strand:
            return start_edge, start_strand, at, fresh


@kernel
def write_canonical_system(joins: Int32Array, system: Int32Array) -> tuple[int, bool]:
    """Write the smallest image of ``joins`` over all rotations and reflections.

    joins: (N, N); system: (N (N + 1) / 2,) its upper triangle, row by row. Returns
    (rotation, reflected): side i of the system is side rotation + i, or rotation - i.
    """
    n = len(joins)
    best_rotation = -1
    best_reflected = False
    for reflected in (False, True):
        for rotation in range(n):
            order = -1 if best_rotation < 0 else 0
            at = 0
            for i in range(n):
                a = (rotation - i) % n if reflected else (rotation + i) % n
                for j in range(i, n):
                    b = (rotation - j) % n if reflected else (rotation + j) % n
                    if order == 0 and joins[a, b] != system[at]:
                        order = -1 if joins[a, b] < system[at] else 1
                    if order < 0:
                        system[at] = joins[a, b]
                    at += 1
                if order > 0:
                    break
            if order < 0:
                best_rotation = rotation
                best_reflected = reflected
    return best_rotation, best_reflected


@kernel
def list_records(
    flat: Code,
    offsets: NDArray[np.int64],
    n_irregular: Int32Array,
    n_reflex: Int32Array,
    n_marks: int,
    most: int,
    free: bool,
    marks: Int32Array,
    slots: Int32Array,
    near: Int32Array,
    far: Int32Array,
) -> tuple[Int32Array, NDArray[np.int16], NDArray[np.int16]]:
    """Every way to set ``n_marks`` marks on each of the patterns, up to symmetry: the records.

    Returns their heads, (r, HEAD + N + N (N + 1) / 2) int32; for each record the number of strands
    on side 0, their numbers, and so on, flat int16; for each the polychord of every strand, flat
    int16.

    flat, offsets: the patterns' codes; n_irregular, n_reflex: (p,). most, free: as in
    :func:`query.marks.marked.mark_patterns`. marks, slots, near, far: the columns of
    :class:`query.marks.markplaces.Partings`.
    """
    n = n_marks
    width = HEAD + n + n * (n + 1) // 2
    head = np.zeros((256, width), np.int32)
    label = np.zeros(4096, np.int16)
    chord = np.zeros(4096, np.int16)
    joins = np.empty((n, n), np.int32)
    rows = 0
    label_size = 0
    chord_size = 0
    for p in range(len(offsets) - 1):
        pattern = trace_rim(flat[offsets[p] : offsets[p + 1]])
        perimeter = len(pattern.quads)
        n_chords = len(pattern.near)
        # Corners from each vertex on that can still get a mark at no cost.
        corners = np.zeros(perimeter + n_chords + 1, np.int32)
        for i in range(perimeter - 1, -1, -1):
            corners[i] = corners[i + 1] + (pattern.quads[i] != 2)
        budget = most - n_irregular[p] - n_reflex[p]
        if free:
            # Every corner is irregular, marked or not.
            budget -= corners[0] - n_reflex[p]
        if budget < 0 or (not free and abs(corners[0] - n) > budget + n_reflex[p]):
            continue
        at_vertex = np.zeros(perimeter, np.bool_)
        edge_slots = np.zeros(perimeter, np.int32)
        bits = np.zeros(perimeter, np.int32)
        # Vertex by vertex, then polychord by polychord: which option is taken, and what
        # the options before it cost and set.
        n_items = perimeter + n_chords
        option = np.empty(n_items, np.int32)
        spent = np.zeros(n_items + 1, np.int32)
        placed = np.zeros(n_items + 1, np.int32)
        option[0] = -1
        item = 0
        while item >= 0:
            if item < n_items:
                option[item] += 1
                more = option[item]
                cost = 0
                if item < perimeter:
                    k = pattern.quads[item]
                    if not free and k == 1:
                        cost = 1 - more
                    elif not free and k == 2:
                        cost = more
                    done = option[item] > 1
                else:
                    done = option[item] == len(marks)
                    if not done:
                        more = marks[option[item]]
                        cost = 0 if free else more
                        done = placed[item] + more > n or spent[item] + cost > budget
                if done:
                    item -= 1
                    continue
                cost += spent[item]
                more += placed[item]
                if cost > budget or more > n:
                    continue
                if not free and more + corners[item + 1] + budget - cost < n:
                    continue
                if item < perimeter:
                    at_vertex[item] = option[item] == 1
                else:
                    c = item - perimeter
                    parting = option[item]
                    a, b = pattern.near[c], pattern.far[c]
                    edge_slots[a] = slots[parting]
                    edge_slots[b] = slots[parting]
                    bits[a] = near[parting]
                    bits[b] = mirror_bits(far[parting], slots[parting])
                item += 1
                spent[item] = cost
                placed[item] = more
                if item < n_items:
                    option[item] = -1
                continue
            item -= 1
            if placed[n_items] != n or not is_first_image(pattern, at_vertex, edge_slots, bits):
                continue
            head = _with_room(head, rows + 1)
            label = _with_room(label, label_size + n + perimeter + 2 * n)
            chord = _with_room(chord, chord_size + n_chords + n)
            row = head[rows]
            start_edge, start_strand, size, n_strands = write_label(
                pattern,
                at_vertex,
                edge_slots,
                bits,
                row[HEAD : HEAD + n],
                label[label_size:],
                chord[chord_size:],
                joins,
            )
            rotation, reflected = write_canonical_system(joins, row[HEAD + n :])
            unmarked = 0
            for i in range(perimeter):
                unmarked += pattern.quads[i] != 2 and not at_vertex[i]
            row[PATTERN] = p
            row[COST] = n_irregular[p] + unmarked
            row[UNMARKED] = unmarked
            row[RELAXED] = unmarked > 0 or corners[0] != n
            row[PERIMETER] = 2 * n_strands
            row[START_EDGE] = start_edge
            row[START_STRAND] = start_strand
            row[ROTATION] = rotation
            row[REFLECTED] = reflected
            row[STRANDS] = n_strands
            rows += 1
            label_size += size
            chord_size += n_strands
    return head[:rows].copy(), label[:label_size].copy(), chord[:chord_size].copy()
