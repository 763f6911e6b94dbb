"""The four-sided pieces that a half body is meshed in, and the samples that neighbouring pieces
share, so that their meshes meet."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from bodies.coons import segment
from bodies.outline import Outline, Path, Wheelhouse, inner_line
from patterndb.geometry.points import Floats, Points

LOW, HIGH = segment([0.5, 0], [1, 0]), segment([0.5, 1], [1, 1])
LONG_LOW, LONG_HIGH = segment([0, 0], [1, 0]), segment([0, 1], [1, 1])
LEFT, MIDDLE, RIGHT = segment([0, 0], [0, 1]), segment([0.5, 0], [0.5, 1]), segment([1, 0], [1, 1])


@dataclass(frozen=True, slots=True, eq=False)
class Edge:
    """One side of a piece: the part from ``start`` to ``end`` of the samples under ``key``.

    path: the surface's parameters, for the parameters of the samples.
    """

    key: str
    path: Path
    start: float = 0.0
    end: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """A four-sided part of a surface; bottom and top run along p, left and right along q."""

    name: str
    surface: str
    component: str
    bottom: Edge
    right: Edge
    top: Edge
    left: Edge


def pieces(outline: Outline, over: tuple[float, ...]) -> tuple[Piece, ...]:
    """All pieces; over: parameters of the shoulder where the seams over the arches end."""
    return (
        *_side(outline, over), *_top(outline), *_roof(), *_ends(), *_floor(outline),
        *_house(outline.houses[0], "front_wheelhouse"),
        *_house(outline.houses[1], "rear_wheelhouse"),
    )  # fmt: skip


def _side(outline: Outline, over: tuple[float, ...]) -> list[Piece]:
    """Below, between and above the arches; seams lead from the arches' bends to the shoulder."""
    front, rear = outline.houses
    (f1, f2), (r1, r2) = (house.arch(np.array(house.bends)) for house in outline.houses)
    a, b = front.bends
    sills = [
        Edge("sill_front", segment([0, 0], [front.feet[0], 0])),
        Edge("sill_middle", segment([front.feet[1], 0], [rear.feet[0], 0])),
        Edge("sill_rear", segment([rear.feet[1], 0], [1, 0])),
    ]
    seams = [
        Edge("sill_front", segment([0, f1[1]], f1)),
        Edge("sill_middle", segment(f2, r1)),
        Edge("sill_rear", segment(r2, [1, r2[1]])),
    ]
    ends = [f1, f2, r1, r2]
    ups = [Edge("up", segment(end, [at, 1])) for end, at in zip(ends, over, strict=True)]
    cuts = [0.0, *over, 1.0]
    tops = [Edge("shoulder", LONG_HIGH, p, q) for p, q in pairwise(cuts)]
    corner = [Edge("front_corner", LEFT, 0.0, f1[1]), Edge("front_corner", LEFT, f1[1], 1.0)]
    back = [Edge("rear_corner", RIGHT, 0.0, r2[1]), Edge("rear_corner", RIGHT, r2[1], 1.0)]

    def arch(house: Wheelhouse, start: float, end: float) -> Edge:
        return Edge(f"{house.name}_arch", house.arch, start, end)

    parts = [
        (sills[0], arch(front, 0.0, a), seams[0], corner[0]),
        (seams[0], ups[0], tops[0], corner[1]),
        (arch(front, a, b), ups[1], tops[1], ups[0]),
        (sills[1], arch(rear, 0.0, a), seams[1], arch(front, 1.0, b)),
        (seams[1], ups[2], tops[2], ups[1]),
        (arch(rear, a, b), ups[3], tops[3], ups[2]),
        (sills[2], back[0], seams[2], arch(rear, 1.0, b)),
        (seams[2], back[1], tops[4], ups[3]),
    ]
    names = ("bumper", "fender", "over_front", "sill", "doors", "over_rear", "apron", "quarter")
    return [
        Piece(f"side_{name}", "side", "body", *part)
        for name, part in zip(names, parts, strict=True)
    ]


def _top(outline: Outline) -> list[Piece]:
    """The hood and the deck, each a middle and an outer strip, and the ledge between them."""
    paths, a, c = outline.paths, outline.windscreen, outline.rear_window
    hood, deck, belt = paths["hood_seam"], paths["deck_seam"], paths["belt_line"]
    base, foot = paths["windscreen_base"], paths["rear_window_base"]
    first, last = (path(np.zeros(1))[0] for path in (base, foot))
    split, rear_split = 2.0 * a[0] - 1.0, 2.0 * c[0] - 1.0
    beside = [Edge("ledge", segment(end, [1, end[1]])) for end in (a, c)]
    parts = {
        "hood": (
            Edge("hood_edge", LOW, 0.0, split), Edge("hood", hood),
            Edge("across", base), Edge("hood", segment([0.5, 0], first)),
        ),
        "hood_side": (
            Edge("hood_edge", LOW, split, 1.0), Edge("shoulder", RIGHT, 0.0, a[1]),
            beside[0], Edge("hood", hood),
        ),
        "ledge": (
            beside[0], Edge("shoulder", RIGHT, a[1], c[1]), beside[1], Edge("cabin", belt)
        ),
        "deck": (
            Edge("across", foot), Edge("deck", deck),
            Edge("deck_edge", HIGH, 0.0, rear_split), Edge("deck", segment(last, [0.5, 1])),
        ),
        "deck_side": (
            beside[1], Edge("shoulder", RIGHT, c[1], 1.0),
            Edge("deck_edge", HIGH, rear_split, 1.0), Edge("deck", deck),
        ),
    }  # fmt: skip
    return [Piece(name, "top", "body", *part) for name, part in parts.items()]


def _roof() -> list[Piece]:
    low, high = Edge("across", LOW), Edge("across", HIGH)
    screen, middle = Edge("screen", RIGHT), Edge("screen", MIDDLE)
    return [
        Piece("windscreen", "screen", "roof", low, screen, high, middle),
        Piece("roof", "roof", "roof", low, Edge("cabin", RIGHT), high, Edge("cabin", MIDDLE)),
        Piece("rear_window", "window", "roof", low, screen, high, middle),
        Piece(
            "glass", "glass", "roof",
            Edge("cabin", LONG_LOW), screen, Edge("cabin", LONG_HIGH), Edge("screen", LEFT),
        ),
    ]  # fmt: skip


def _ends() -> list[Piece]:
    def end(name: str, low: str, high: str, corner: str) -> Piece:
        sides = (Edge(low, LOW), Edge(corner, RIGHT), Edge(high, HIGH), Edge(corner, MIDDLE))
        return Piece(name, name, "body", *sides)

    return [
        end("nose", "front_bottom", "hood_edge", "front_corner"),
        end("tail", "rear_bottom", "deck_edge", "rear_corner"),
    ]


def _floor(outline: Outline) -> list[Piece]:
    """A middle strip of five parts, and outside of it three: between them are the wheelhouses."""
    front, rear = outline.houses
    inner = inner_line(outline.surfaces["floor"], front.inner)
    cuts = np.array([0.0, *front.feet, *rear.feet, 1.0])
    deep = inner(cuts)
    inside = 2.0 * deep[[0, -1], 0] - 1.0
    names = ("sill_front", "front_span", "sill_middle", "rear_span", "sill_rear")

    def part(start: float, end: float) -> Path:
        return lambda t: inner(start + t * (end - start))

    within = [Edge("inward", segment([0.5, at[1]], at)) for at in deep]
    beyond = [Edge("deep", segment(at, [1, at[1]])) for at in deep]
    within[0] = Edge("front_bottom", LOW, 0.0, inside[0])
    within[-1] = Edge("rear_bottom", HIGH, 0.0, inside[1])
    beyond[0] = Edge("front_bottom", LOW, inside[0], 1.0)
    beyond[-1] = Edge("rear_bottom", HIGH, inside[1], 1.0)
    result: list[Piece] = []
    for i, name in enumerate(names):
        a, b = cuts[i], cuts[i + 1]
        line, middle = Edge(name, part(a, b)), Edge(name, segment([0.5, a], [0.5, b]))
        where = name.replace("sill", "floor").replace("span", "axle")
        sides = (within[i], line, within[i + 1], middle)
        result.append(Piece(f"{where}_middle", "floor", "body", *sides))
        if i % 2 == 0:
            outer = Edge(name, segment([1, a], [1, b]))
            sides = (beyond[i], outer, beyond[i + 1], line)
            result.append(Piece(where, "floor", "body", *sides))
    return result


def _house(house: Wheelhouse, component: str) -> list[Piece]:
    a, b = house.bends
    name, arch = house.name, f"{house.name}_arch"
    across = [Edge("inwards", segment([at, 0], [at, 1])) for at in (0.0, a, b, 1.0)]
    result = [
        Piece(
            f"{name}_tub_{where}", f"{name}_tub", component,
            Edge(arch, LONG_LOW, start, end), across[i + 1],
            Edge(arch, LONG_HIGH, start, end), across[i],
        )
        for i, (where, start, end) in enumerate(
            [("front", 0.0, a), ("top", a, b), ("rear", b, 1.0)]
        )
    ]  # fmt: skip

    def up_front(t: Floats) -> Points:
        return np.stack([np.zeros(len(t)), t / a], axis=1)

    def over(t: Floats) -> Points:
        return np.stack([(t - a) / (b - a), np.ones(len(t))], axis=1)

    def up_rear(t: Floats) -> Points:
        return np.stack([np.ones(len(t)), (1.0 - t) / (1.0 - b)], axis=1)

    wall = Piece(
        f"{name}_wall", f"{name}_wall", component,
        Edge(f"{name}_span", LONG_LOW), Edge(arch, up_rear, 1.0, b),
        Edge(arch, over, a, b), Edge(arch, up_front, 0.0, a),
    )  # fmt: skip
    return [*result, wall]


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
