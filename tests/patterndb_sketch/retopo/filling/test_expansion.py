"""Any fill is read as an expansion of its pattern, whose strips can be doubled."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb.core.halfedge import Int32Array
from patterndb_sketch.retopo.filling import Choice
from patterndb_sketch.retopo.filling.expansion import Expansion
from query.engine import PatternSource, fills
from query.recognition import hash_quads, weld
from tests.support.retopo.topology import (
    key,
)


def split(choice: Choice, half: int) -> tuple[Int32Array, list[int]]:
    """The quads of a choice with the strip through a half-edge split, and the boundary edges
    that it crosses; edge by edge, in plain Python."""
    quads = choice.faces.tolist()
    quads_at: dict[frozenset[int], list[tuple[int, int]]] = {}
    for q, quad in enumerate(quads):
        for e in range(4):
            quads_at.setdefault(frozenset((quad[e], quad[(e + 1) % 4])), []).append((q, e))
    crossed: dict[frozenset[int], None] = {}
    stack = [frozenset((quads[half // 4][half % 4], quads[half // 4][(half % 4 + 1) % 4]))]
    while stack:
        edge = stack.pop()
        if edge in crossed:
            continue
        crossed[edge] = None
        for q, e in quads_at[edge]:
            stack.append(frozenset((quads[q][(e + 2) % 4], quads[q][(e + 3) % 4])))
    perimeter, n = choice.perimeter, choice.n_vertices
    rim = [u for u in range(perimeter) if frozenset((u, (u + 1) % perimeter)) in crossed]
    name: dict[object, int] = {}
    for u in range(perimeter):
        name[u] = len(name)
        if u in rim:
            name[frozenset((u, (u + 1) % perimeter))] = len(name)
    for one in [*range(perimeter, n), *(edge for edge in crossed if edge not in name)]:
        name[one] = len(name)
    made: list[list[int]] = []
    for q, quad in enumerate(quads):
        a, b, c, d = (name[v] for v in quad)
        ab, bc, cd, da = (name.get(frozenset((quad[e], quad[(e + 1) % 4]))) for e in range(4))
        if ab is not None and bc is not None:
            middle = name[("middle", q)] = len(name)
            made += [[a, ab, middle, da], [ab, b, bc, middle]]
            made += [[middle, bc, c, cd], [da, middle, cd, d]]
        elif ab is not None:
            made += [[a, ab, cd, d], [ab, b, c, cd]]
        elif bc is not None:
            made += [[a, b, bc, da], [da, bc, c, d]]
        else:
            made.append([a, b, c, d])
    return np.array(made, np.int32), rim


@settings(max_examples=40)
@given(st.data())
def test_any_fill_is_read_and_its_strips_are_doubled(
    source: PatternSource, data: st.DataObject
) -> None:
    """As quads that are split one by one: learned, relaxed and constructed fills alike."""
    sides = data.draw(st.lists(st.integers(1, 7), min_size=2, max_size=6))
    sides[0] += sum(sides) % 2
    if sum(sides) < 4:
        sides[0] += 2
    listed = list(fills(source, sides, limit=30, per_pattern=2))
    choice = Choice.of(listed[data.draw(st.integers(0, len(listed) - 1))])
    read = Expansion.of(choice)
    assert (read.pattern.code.tobytes(), read.widths) == (choice.code, choice.widths)
    same = read.resize(choice.widths[: read.pattern.n_chords])
    assert key(same) == key(choice)
    assert (same.rotation, same.mirrored) == (choice.rotation, choice.mirrored)
    # A pattern that is not known is recognised.
    found = Expansion.of(replace(choice, widths=(), origin="imported"))
    assert key(found.resize(found.widths)) == key(choice)
    half = data.draw(st.integers(0, len(read.twin) - 1))
    quads, rim = split(choice, half)
    longer = [
        n + sum(start <= u < start + n for u in rim)
        for start, n in zip(np.cumsum([0, *choice.lengths]), choice.lengths, strict=False)
    ]
    made = read.widen([int(read.chord[half])], rim, tuple(longer))
    assert made.lengths == tuple(longer)
    assert made.n_irregular == choice.n_irregular
    twin = weld(quads, int(quads.max()) + 1, sum(longer))
    assert key(made) == hash_quads(quads, twin, False)
    again = Expansion.of(made)
    assert (again.widths, again.first, again.strict) == (made.widths, again.first, read.strict)
    if rim:
        assert {read.across(u) for u in rim} == set(rim)
