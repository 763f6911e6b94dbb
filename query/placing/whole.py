"""Smoothing that flips nothing: as far towards rest as a net on a surface stays whole.

Within a reflex outline, over a fold or over far more than half of a ball, the net of the least
squared edges turns over somewhere. Where a round of smoothing would flip a quad, its vertices and
those around them stay, and the rest of the net goes on.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.neighbours import Neighbours
from patterndb.geometry.points import Points
from patterndb.geometry.quadshape import flipped
from patterndb.geometry.surface import Surface
from query.placing.laplace import edge_energy
from query.placing.projection import AT_REST, Rest, normals_at, settled

#: Rounds, at most.
ROUNDS = 30

#: A round that shortens the sum of squared edges by a smaller part than this is the last.
GAIN = 1e-3

#: Edges from a quad that would flip within which vertices are held back, and the further part of
#: their way that is left to them each time.
SPREAD = 8
SLOWER = 0.7

#: Times that vertices around quads that would flip are held back.
HOLDS = 8


def settled_whole(
    surface: Surface, quads: Int32Array, beside: Neighbours, vertices: Points, perimeter: int
) -> Rest:
    """Smooth and project from ``vertices`` (v, 3) on the surface; no quad flips that was sound.

    The move told is that of the last round, 1e-4 or more where vertices had to be held back.
    """
    at = vertices
    wrong = _wrong(surface, quads, beside, at)
    stretch = edge_energy(beside.start, beside.neighbour, at)
    done, largest = 0, np.inf
    while done < ROUNDS:
        done += 1
        rest = settled(surface, beside, at, perimeter, 1)
        moved, free = _held(surface, quads, beside, at, rest.vertices, wrong, perimeter)
        after = edge_energy(beside.start, beside.neighbour, moved)
        largest = rest.move if free else max(rest.move, AT_REST)
        if after >= stretch:
            break
        gain = 1.0 - after / stretch
        at, stretch = moved, after
        if largest < AT_REST or gain < GAIN:
            break
    return Rest(at, done, largest)


def _held(
    surface: Surface,
    quads: Int32Array,
    beside: Neighbours,
    before: Points,
    after: Points,
    wrong: NDArray[np.bool_],
    perimeter: int,
) -> tuple[Points, bool]:
    """The vertices after a move, held back where quads would flip, and could all go?

    Vertices of such quads stay where they were, those further away go a part of their way that
    grows with each edge.
    """
    part = np.ones(len(before))
    moved = after
    for _ in range(HOLDS):
        worse = _wrong(surface, quads, beside, moved) & ~wrong
        if not worse.any():
            return moved, bool(part.min() == 1.0)
        held = np.zeros(len(before))
        held[quads[worse]] = 1.0
        for step in range(1, SPREAD):
            around = held[quads].max(axis=1) >= 1.0 - (step - 1) / SPREAD
            near = quads[around]
            held[near] = np.maximum(held[near], 1.0 - step / SPREAD)
        part = np.minimum(part, 1.0 - held) * np.where(held > 0.0, SLOWER, 1.0)
        moved = before + part[:, None] * (after - before)
        moved[perimeter:] = surface.nearest(moved[perimeter:]).points
        moved[:perimeter] = before[:perimeter]
    return before, False


def _wrong(
    surface: Surface, quads: Int32Array, beside: Neighbours, vertices: Points
) -> NDArray[np.bool_]:
    return flipped(quads, vertices, normals_at(surface, beside, vertices))
