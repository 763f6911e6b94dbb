"""Polychords, boundary labels and signatures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from tests.support.reference.halfedge import as_complex, border_loop, fans

Sides = list[list[int]]


def polychords(twin: Sequence[int]) -> tuple[list[int], int, int, list[bool]]:
    """(polychord of every half-edge, open ones, loops, which cross themselves).

    Edges are in one class if they are opposite in a quad or the same edge of two. Open ones
    are numbered first, by their first border half-edges; loops by their first half-edges.
    """
    of_edge = [-1] * len(twin)
    border = [h for h, t in enumerate(twin) if t < 0]
    count = n_open = 0
    for first in border + list(range(len(twin))):
        if of_edge[first] >= 0:
            continue
        todo = [first]
        while todo:
            h = todo.pop()
            if h >= 0 and of_edge[h] < 0:
                of_edge[h] = count
                todo += [4 * (h // 4) + (h + 2) % 4, twin[h]]
        count += 1
        n_open += first in border
    crosses = [False] * count
    for f in range(len(twin) // 4):
        if of_edge[4 * f] == of_edge[4 * f + 1]:
            crosses[of_edge[4 * f]] = True
    return of_edge, n_open, count - n_open, crosses


def label(twin: Sequence[int], start: int) -> Sides:
    """Polychords along every side from border half-edge ``start``; one side if no corner."""
    complex_ = as_complex(twin)
    vertex = fans(complex_)
    count = Counter(vertex.values())
    of_edge = polychords(twin)[0]
    sides: Sides = []
    for h in border_loop(complex_, start):
        if not sides or count[vertex[h]] != 2:
            sides.append([])
        sides[-1].append(of_edge[h])
    return renamed(sides)


def renamed(sides: Sides) -> Sides:
    """The labels numbered 0, 1, 2, ... as they come."""
    names: dict[int, int] = {}
    return [[names.setdefault(c, len(names)) for c in side] for side in sides]


def word(sides: Sides) -> list[int]:
    """Every side's length, then its labels."""
    return [x for side in sides for x in (len(side), *side)]


def seen_from(sides: Sides, rotation: int, reflected: bool, closed: bool) -> Sides:
    """The label as read from side ``rotation`` on, backwards where reflected.

    closed: there is no corner; rotation counts boundary vertices of the one side.
    """
    if closed:
        side = sides[0][rotation:] + sides[0][:rotation]
        return renamed([side[::-1] if reflected else side])
    n = len(sides)
    if reflected:
        return renamed([sides[(rotation - k) % n][::-1] for k in range(n)])
    return renamed([sides[(rotation + k) % n] for k in range(n)])


def canonical_word(sides: Sides, closed: bool) -> tuple[list[int], int]:
    """(the signature, how many rotations and reflections give it)."""
    n = len(sides[0]) if closed else len(sides)
    words = [
        word(seen_from(sides, rotation, reflected, closed))
        for reflected in (False, True)
        for rotation in range(n)
    ]
    return min(words), words.count(min(words))
