"""The samples that neighbouring pieces of a body share, so that their meshes meet."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from patterndb.geometry.points import Floats
from patterndb_sketch.features.bodies.outline import Outline
from patterndb_sketch.features.bodies.pieces import Edge, Piece, pieces
from patterndb_sketch.features.bodies.wheelhouse import inner_line

#: Edges along the whole shoulder per metre, at resolution 1.
PER_METRE = 11.0

#: Edges at resolution 1: half across the roof, across the ledge, the lower and the upper part of
#: the side, up the windscreen, into the wheelhouse.
ACROSS, LEDGE, LOWER, UPPER, SCREEN, DEEP = 11, 5, 7, 8, 11, 5

#: Samples crowd towards edges: the strength of the sinh law for one end, and for both.
CROWDING = 1.6
BOTH = 2.2

#: Shares of the shoulder nearer than this to each other become one break.
BREAK = 0.03


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """pieces: they cover the half body. samples: by key, increasing parameters in [0, 1]."""

    pieces: tuple[Piece, ...]
    samples: dict[str, Floats]

    def along(self, edge: Edge) -> Floats:
        """The samples of an edge, in its direction."""
        low, high = min(edge.start, edge.end), max(edge.start, edge.end)
        every = self.samples[edge.key]
        part = every[(every >= low - 1e-12) & (every <= high + 1e-12)]
        return part if edge.start <= edge.end else part[::-1]


def crowded(count: int, start: bool, end: bool) -> Floats:
    """count + 1 numbers from 0 to 1 that crowd towards the ends that say so."""
    t = np.linspace(0.0, 1.0, count + 1)
    if start and end:
        return 0.5 + 0.5 * np.sinh(BOTH * (2.0 * t - 1.0)) / np.sinh(BOTH)
    if start:
        return np.sinh(CROWDING * t) / np.sinh(CROWDING)
    if end:
        return 1.0 - np.sinh(CROWDING * (1.0 - t)) / np.sinh(CROWDING)
    return t


def joined(breaks: list[float], parts: list[Floats]) -> Floats:
    """The parts, scaled to lie between the breaks, each of which is met exactly."""
    result = [np.array(breaks[:1])]
    for a, b, part in zip(breaks, breaks[1:], parts, strict=False):
        result.append(np.r_[a + (b - a) * part[1:-1], b])
    return np.concatenate(result)


def _breaks(outline: Outline) -> tuple[list[float], list[float]]:
    """Of the shoulder: over the bends of the arches, and beside the ends of the roof's base."""
    over = [p for house in outline.houses for p in house.arch(np.array(house.bends))[:, 0].tolist()]
    beside = [float(outline.windscreen[1]), float(outline.rear_window[1])]
    # A seam that nearly ends at another would leave a sliver: it moves to the other's end.
    for i, place in enumerate(over):
        near = min(beside, key=lambda other: abs(other - place))
        if abs(near - place) < BREAK:
            over[i] = near
    return over, beside


def layout(outline: Outline, resolution: float) -> Layout:
    """The pieces of a body; resolution: a factor on the edges in every direction."""

    def count(edges: float) -> int:
        return max(2, round(edges * resolution))

    over, beside = _breaks(outline)
    ends = outline.surfaces["side"].top(np.array([0.0, 1.0]))[:, 0]
    per_share = PER_METRE * float(ends[1] - ends[0])
    breaks = [0.0, *sorted(set(over + beside)), 1.0]
    parts = [crowded(count((b - a) * per_share), a == 0.0, b == 1.0) for a, b in pairwise(breaks)]
    shoulder = joined(breaks, parts)

    def between(a: float, b: float) -> int:
        return int(np.searchsorted(shoulder, b) - np.searchsorted(shoulder, a))

    across, ledge, low, up = count(ACROSS), count(LEDGE), count(LOWER), count(UPPER)
    deep = count(DEEP)
    inward = across + ledge - deep
    front, rear = outline.houses
    cuts = [0.0, *over, 1.0]
    spans = [between(a, b) for a, b in pairwise(cuts)]

    def rise(at: float) -> Floats:
        return joined([0.0, at, 1.0], [crowded(low, True, False), crowded(up, False, True)])

    def arch(span: int) -> Floats:
        legs = crowded(low, True, False), crowded(low, False, True)
        return joined([0.0, *front.bends, 1.0], [legs[0], crowded(span, False, False), legs[1]])

    def edge(foot: float) -> Floats:
        parts = [crowded(across, False, True), crowded(ledge, True, True)]
        return joined([0.0, 2.0 * foot - 1.0, 1.0], parts)

    inside = 2.0 * inner_line(outline.surfaces["floor"], front.inner)(np.array([0.0, 1.0])) - 1.0

    def bottom(at: float) -> Floats:
        parts = [crowded(inward, False, False), crowded(deep, True, True)]
        return joined([0.0, at, 1.0], parts)

    names = ("sill_front", "front_span", "sill_middle", "rear_span", "sill_rear")
    samples = {name: crowded(span, True, True) for name, span in zip(names, spans, strict=True)}
    samples |= {
        "shoulder": shoulder,
        "hood_edge": edge(float(outline.windscreen[0])),
        "deck_edge": edge(float(outline.rear_window[0])),
        "front_bottom": bottom(float(inside[0, 0])),
        "rear_bottom": bottom(float(inside[1, 0])),
        "front_corner": rise(float(front.arch(np.array(front.bends))[0, 1])),
        "rear_corner": rise(float(rear.arch(np.array(rear.bends))[1, 1])),
        "front_arch": arch(spans[1]),
        "rear_arch": arch(spans[3]),
        "up": crowded(up, True, True),
        "across": crowded(across, False, True),
        "ledge": crowded(ledge, True, True),
        "hood": crowded(between(0.0, beside[0]), True, True),
        "cabin": crowded(between(*beside), True, True),
        "deck": crowded(between(beside[1], 1.0), True, True),
        "screen": crowded(count(SCREEN), True, True),
        "deep": crowded(deep, True, True),
        "inwards": crowded(deep, True, True),
        "inward": crowded(inward, False, False),
    }
    return Layout(pieces(outline, tuple(over)), samples)
