"""Which points of one ring belong to which of the other."""

from __future__ import annotations

import numpy as np

from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.tools.cylinder.rings import Ring


def paired(
    first: tuple[Ring, int], second: tuple[Ring, int], division: int
) -> list[tuple[float, float]]:
    """Places on two rings that belong together, beginning with the vertices given.

    The part between the rings lies on the left of both, so that one is walked forwards and the
    other backwards. Where both have nodes, one belongs to the next; where one has, each belongs
    to the point at the same part of the way round; where neither has, ``division`` pairs
    divide both evenly.
    Raises RefusedError if both have nodes, and not the same number.

    Source: sketch-based quad meshes paper, section 4, and its released program.
    """
    (one, start), (other, end) = first, second
    k, m = len(one.corners), len(other.corners)
    if k and m:
        if k != m:
            raise RefusedError(
                f"one loop has {k} corners and the other {m}; add or delete corners until they "
                "have as many, or none"
            )
        ahead = _around(one, start, backwards=False)
        back = _around(other, end, backwards=True)
        return [(float(a), float(b)) for a, b in zip(ahead, back, strict=True)]
    if k:
        ahead = _around(one, start, backwards=False)
        way = one.fractions(start, backwards=False)
        return [(float(a), other.place(end, float(way[a]), backwards=True)) for a in ahead]
    if m:
        back = _around(other, end, backwards=True)
        way = other.fractions(end, backwards=True)
        return [(one.place(start, float(way[b]), backwards=False), float(b)) for b in back]
    return [
        (
            one.place(start, j / division, backwards=False),
            other.place(end, j / division, backwards=True),
        )
        for j in range(division)
    ]


def _around(ring: Ring, start: int, *, backwards: bool) -> list[int]:
    """The nodes of a ring as they are met from one of them on."""
    n = len(ring.edge.points)
    way = (start - ring.corners) % n if backwards else (ring.corners - start) % n
    return [int(ring.corners[k]) for k in np.argsort(way)]
