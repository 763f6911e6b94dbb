"""Loop strokes: how wide the loop polychords of a pattern have to be."""

from __future__ import annotations

from itertools import combinations_with_replacement


def loop_widths(n_loops: int, n_strokes: int) -> list[tuple[int, ...]]:
    """Widths (n_loops,) of the loop polychords, for every way to give each loop stroke a strand.

    A loop is as wide as it carries strokes, and at least 1; one strand carries one stroke.
    Narrowest first; none where there is a stroke and no loop.

    >>> loop_widths(2, 2)
    [(1, 1), (1, 2), (2, 1)]
    """
    found: set[tuple[int, ...]] = set()
    for carriers in combinations_with_replacement(range(n_loops), n_strokes):
        found.add(tuple(max(1, carriers.count(loop)) for loop in range(n_loops)))
    return sorted(found, key=lambda widths: (sum(widths), widths))
